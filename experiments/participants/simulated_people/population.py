"""The simulated population: parameters for the participants in a pilot, each with its source.

A participant feels a surface of amplitude *A* as a sensation between 0 (not slippery) and 100 (the
most slippery surface imaginable). Across the population, the sensation at *A* follows a beta
distribution on 0-100. A participant's position in this distribution, as a standard normal deviate,
is

    sqrt(1 - t) (cos(angle(A)) intercept + sin(angle(A)) exponent) + sqrt(t) noise

The intercept and the exponent are constant for each person; the noise varies from trial to trial.
People with a high intercept find all surfaces more slippery. People with a high exponent show a
steeper growth of sensation. The weights of the intercept and the exponent change smoothly with the
amplitude, because angle(A) is a linear function of log(1 + A / 0.5 µm). The distribution of
sensations at an amplitude does not depend on the number of amplitudes in a study.

`POPULATIONS` contains the shipped populations. A laboratory can define its own population in a TOML
file with the same keys.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from statistics import NormalDist
from typing import Annotated, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    ValidationError,
    model_serializer,
    model_validator,
)

from slipscale.experiments.participants.simulated_people.habits import REALISTIC, Habits
from slipscale.experiments.participants.simulated_people.own_behaviour import (
    behaviour_names,
    load_behaviour,
)
from slipscale.faults import UserError
from slipscale.faults.frozen_table import setting
from slipscale.faults.message import Message
from slipscale.faults.toml_file import parse_toml
from slipscale.faults.validation import in_words

# Biet 2007, Table III (page 2688 of the journal's volume 54).
AMPLITUDE_UM_PP = (0.0, 0.5, 1.2, 2.3)
MEAN_SENSATION = (12.75, 19.58, 56.25, 81.33)
SD_SENSATION = (12.75, 8.11, 8.82, 10.76)
# The constant in angle(A), in log(1 + A / 0.5 µm): our assumption.
TURN_UM_PP = 0.5
# Maximum number of cached amplitudes, because adaptive methods keep presenting new amplitudes.
MOST_KEPT = 2**12
OWN = "behaviour"
IN_UM = "amplitude_um_pp"  # key of the levels in a population file, if they are in µm

Share = Annotated[float, Field(ge=0, le=1)]
AboveZero = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Percent = Annotated[float, Field(gt=0, lt=100)]
Number = TypeVar("Number", float, "NDArray[np.float64]")


class Population(BaseModel):
    """Assumptions about a population of simulated people, each with its source."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, populate_by_name=True
    )

    name: str = setting("biet2007", "Name of the population for reports.")
    levels: tuple[NotNegative, ...] = Field(
        default=AMPLITUDE_UM_PP,
        alias=IN_UM,
        min_length=2,
        description="Amplitudes at which the sensation is known, in ascending order (Biet 2007, "
        "Table III). We assume that the sensation follows a monotone cubic between these "
        "amplitudes and is constant outside their range.",
    )
    unit: str = setting("", "Unit of the levels; default: µm peak to peak.")
    mean_sensation: tuple[Percent, ...] = setting(
        MEAN_SENSATION, "Mean sensation at each amplitude, 0 to 100. Biet 2007, Table III."
    )
    sd_sensation: tuple[AboveZero, ...] = setting(
        SD_SENSATION,
        "Standard deviation of the sensation at each amplitude, from Biet 2007, Table III "
        "(interpreted as the sample standard deviation).",
    )
    shared: Share = setting(
        0.55,
        "Proportion of the variance at the lowest and highest amplitudes that comes from "
        "differences between people's intercepts. The remaining variance, except for "
        "trial-to-trial variance, comes from differences between exponents. Our assumption, which "
        "gives a correlation of 0.29 between a person's mean sensations at the lowest and highest "
        "amplitudes. The published table does not show which sensations belong to the same person.",
    )
    trial_to_trial: Share = setting(
        0.15,
        "Proportion of the variance that is due to variation from trial to trial. Our assumption.",
    )
    noise_sigma: NotNegative = setting(
        0.25,
        "Standard deviation, between people, of the logarithm of their trial-to-trial noise. "
        "Our assumption.",
    )
    scale_tops: tuple[AboveZero, ...] = Field(
        default=(10.0, 20.0, 50.0, 100.0, 1000.0),
        min_length=1,
        description="Numbers from which participants choose the top of their scale. Our "
        "assumption: with a free modulus, participants choose round numbers that span several "
        "powers of ten, and the smallest step of a scale is a hundredth of its top.",
    )
    line_shift_sd: NotNegative = setting(
        0.3,
        "Between-person standard deviation of the logit of the rating of a sensation of 50. Our "
        "assumption.",
    )
    line_stretch_sigma: NotNegative = setting(
        0.2,
        "Between-person standard deviation of the logarithm of the factor by which a person "
        "multiplies the logit of each sensation on the rating line. Our assumption.",
    )
    criterion: NotNegative = setting(
        1.6,
        "Smallest change that a person reports as a difference, in units of the noise in judging "
        "a difference. Our assumption, chosen so that nearly everyone feels the paper's steps "
        '("all of the subjects feel clearly the difference").',
    )
    criterion_sd: NotNegative = setting(
        0.3, "Standard deviation of the criterion between people. Our assumption."
    )
    noise: AboveZero = setting(
        2.2,
        (
            "Noise in judging a difference, given as the change in sensation for which the median "
            "person has d' = 1. Our assumption."
        ),
    )
    threshold_sigma: NotNegative = setting(
        0.25,
        "Between-person standard deviation of the logarithm of the noise in judging a "
        "difference. Our assumption.",
    )
    exploration_s: AboveZero = setting(3.0, "Median duration of an exploration. Our assumption.")
    exploration_sigma: NotNegative = setting(
        0.3,
        "Standard deviation of the log duration of an exploration, between trials. Our assumption.",
    )
    answer_s: AboveZero = setting(2.0, "Median time for an answer. Our assumption.")
    answer_sigma: NotNegative = setting(
        0.4, "Standard deviation of the log time of an answer, between trials. Our assumption."
    )
    pace_sigma: NotNegative = setting(
        0.25,
        "Standard deviation, between people, of the logarithm of the pace at which they explore "
        "and answer. Our assumption.",
    )
    reading_words_per_minute: AboveZero = setting(
        238.0,
        "Mean silent reading speed in 190 studies (Brysbaert 2019, Journal of Memory and "
        "Language 109, 104047).",
    )
    reading_sigma: NotNegative = setting(
        0.14,
        "Between-person standard deviation of the logarithm of reading speed. Brysbaert 2019: most "
        "adults read 175 to 300 words per minute.",
    )
    screen_s: NotNegative = setting(
        1.0, "Time per screen in addition to the reading time. Our assumption."
    )
    habits: Habits = setting(Habits(), "Response habits, which are all off by default.")
    effects: tuple[tuple[str, str, AboveZero], ...] = setting(
        (),
        "Number by which a condition multiplies sensation, for each level of a study factor; "
        "default: 1. The values come from `simulated` in the study file.",
    )
    growths: tuple[tuple[str, str, AboveZero], ...] = setting(
        (),
        "Number by which a condition multiplies the exponent of sensation; default: 1. The "
        "values come from `simulated_growth` in the study file.",
    )
    effect_sds: tuple[tuple[str, NotNegative], ...] = setting(
        (),
        "Standard deviation, between people, of the logarithm of a factor's effects, by factor "
        "name. The values come from `simulated_sd` in the study file.",
    )
    behaviour: str = setting(
        "",
        "Name of a behaviour from a package (an entry point of slipscale.participants); default: "
        "Slipscale's own simulated people.",
    )

    @model_serializer(mode="wrap")
    def _in_file(self, numbers: SerializerFunctionWrapHandler) -> dict[str, object]:
        """Return the values with the keys of a file; parameters that are not used are omitted."""
        return {
            IN_UM if name == "levels" and not self.unit else name: value
            for name, value in numbers(self).items()
            if value or isinstance(value, float)
        }

    @model_validator(mode="after")
    def _possible(self) -> Self:
        known = self.levels
        if not len(known) == len(self.mean_sensation) == len(self.sd_sensation):
            raise ValueError(
                Message(
                    "expected the same number of values of {in_um}, mean_sensation and "
                    "sd_sensation",
                    in_um=IN_UM,
                )
            )
        if any(low >= high for low, high in pairwise(known)):
            raise ValueError(Message("{in_um}: expected ascending values", in_um=IN_UM))
        if self.shared + self.trial_to_trial > 1:
            raise ValueError(
                "shared and trial_to_trial are proportions of the same variance: expected a sum of "
                "at most 1"
            )
        for mean, sd in zip(self.mean_sensation, self.sd_sensation, strict=True):
            if sd**2 >= mean * (100 - mean):
                raise ValueError(
                    Message(
                        "no distribution on 0 to 100 has mean {mean:g} and SD {sd:g}",
                        mean=mean,
                        sd=sd,
                    )
                )
        return self

    @property
    def own(self) -> float:
        """The proportion of the variance due to the person's exponent."""
        return max(1 - self.shared - self.trial_to_trial, 0.0)

    def in_condition(
        self, percent: Number, levels: Mapping[str, str], own: Callable[[str], Number]
    ) -> Number:
        """Return a sensation (0 to 100) after applying the effects of the trial's condition.

        Parameters
        ----------
        percent : float or array
        levels : Mapping
            The level of each factor.
        own : callable
            Returns the person's standard normal deviate for a named parameter.
        """

        def product(known: tuple[tuple[str, str, float], ...]) -> float:
            return math.prod(by for name, level, by in known if levels.get(name) == level)

        growth = product(self.growths)
        if growth != 1:
            percent = 100 * (percent / 100) ** growth
        for name, sd in self.effect_sds:
            if name in levels:
                percent = percent * math.e ** (sd * own(f"effect of {name} {levels[name]}"))
        return percent * product(self.effects)

    def angle(self, level: float) -> float:
        """Return angle(A) in radians, which sets the weights of the intercept and the exponent.

        The module's description contains the formula. At the lowest and highest level, the squared
        sine of this angle is the proportion of the variance between people that is due to the
        exponent.
        """
        turn = TURN_UM_PP * (self.levels[-1] / AMPLITUDE_UM_PP[-1] if self.unit else 1.0)
        low, high = (math.log1p(a / turn) for a in self._ends)
        at = math.log1p(self.within(level) / turn)
        largest = math.atan2(math.sqrt(self.own), math.sqrt(self.shared))
        return largest * (2 * (at - low) / (high - low) - 1)

    def within(self, level: float) -> float:
        """Clip a level, such as a noisy plate readback, to the population's range."""
        low, high = self._ends
        return min(max(level, low), high)

    @property
    def _ends(self) -> tuple[float, float]:
        return self.levels[0], self.levels[-1]


class Curves:
    """Sensation as a function of amplitude in one population; created by `curves`."""

    def __init__(self, population: Population) -> None:
        from scipy.interpolate import PchipInterpolator

        known = population.levels
        self._population = population
        self._mean = PchipInterpolator(known, population.mean_sensation, extrapolate=False)
        self._sd = PchipInterpolator(known, population.sd_sensation, extrapolate=False)
        self._known: dict[float, tuple[float, float, float, float, float]] = {}

    def mean(self, level: float) -> float:
        """Return the mean sensation (0-100) at a level; levels outside the range are clipped."""
        return self._at(level)[0]

    def turns(self, level: float) -> tuple[float, float]:
        """Return the weights of the intercept and the exponent at a level."""
        return self._at(level)[3:]

    def sensation(self, level: float, deviate: float) -> float:
        """Return the sensation (0-100) of a person at a given position in the population.

        Parameters
        ----------
        level : float
            The level under the finger.
        deviate : float
            The person's position in the population, as a standard normal deviate.
        """
        from scipy.special import betaincinv

        _, a, b, _, _ = self._at(level)
        return 100 * float(betaincinv(a, b, PLACE.cdf(deviate)))

    def shapes(self, level: float) -> tuple[float, float]:
        """Return the two parameters of the beta distribution at an amplitude."""
        return self._at(level)[1:3]

    def _at(self, level: float) -> tuple[float, float, float, float, float]:
        found = self._known.get(level)
        if found is None:
            people = self._population
            felt = people.within(level)
            mean = float(self._mean(felt)) / 100
            sd = float(self._sd(felt)) / 100
            concentration = mean * (1 - mean) / sd**2 - 1
            angle = people.angle(felt)
            person = math.sqrt(1 - people.trial_to_trial)
            found = (
                100 * mean,
                mean * concentration,
                (1 - mean) * concentration,
                person * math.cos(angle),
                person * math.sin(angle),
            )
            if len(self._known) >= MOST_KEPT:
                self._known.clear()
            self._known[level] = found
        return found


PLACE = NormalDist()


@lru_cache(maxsize=64)
def curves(population: Population) -> Curves:
    """Return a population's curves, which are cached."""
    return Curves(population)


POPULATIONS: dict[str, Callable[[], Population]] = {
    "biet2007": Population,
    "realistic": lambda: Population(name="realistic", habits=REALISTIC),
}


def read_population(name: str) -> Population:
    """Return a shipped or installed population by name, or read one from a TOML file.

    Raises
    ------
    UserError
        If the population does not exist, the file has errors, or a package uses the name of a
        shipped population.
    """
    if name in POPULATIONS and name in behaviour_names():
        raise UserError(
            "{behaviour}: '{name}' is a shipped population; expected a different name for the "
            "entry point",
            behaviour=load_behaviour(name).named,
            name=name,
        )
    if name in POPULATIONS:
        return POPULATIONS[name]()
    if name in behaviour_names():
        return _of_package(name)
    try:
        text = Path(name).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        known = ", ".join([*POPULATIONS, *behaviour_names()])
        raise UserError(
            "population '{name}': {reason}; expected a TOML file or one of the available "
            "populations: {known}",
            name=name,
            reason=reason,
            known=known,
        ) from None
    found = parse_toml(text, name, Population)
    if found.behaviour:
        load_behaviour(found.behaviour)  # reports a missing behaviour before anything begins
    return found


def _of_package(name: str) -> Population:
    behaviour = load_behaviour(name)
    try:
        own = dict(behaviour.kind.population)
        return Population.model_validate({**own, "name": name, OWN: name})
    except (TypeError, ValueError) as error:
        message = in_words(error) if isinstance(error, ValidationError) else error
        raise UserError(
            "{behaviour}: its population is invalid: {message}",
            behaviour=behaviour.named,
            message=message,
        ) from None
