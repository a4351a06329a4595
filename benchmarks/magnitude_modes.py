"""Compare the analysis of ratings, ratios and productions with the truth of simulated people.

Usage: python benchmarks/magnitude_modes.py [--studies 400] [--regression 0.0]

Runs the shipped studies on the bare path, twelve people a study, analyses each study, and compares
with what the population's curves give, drawn here without protocol, person or analysis. Prints the
bias in standard errors over 400 people, and how many studies' 95 % intervals hold the truth.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from scipy.special import betaincinv, ndtr

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.productions.statistics import productions
from slipscale.analysis.tasks.ratings.statistics import ratings
from slipscale.analysis.tasks.ratios.statistics import ratios
from slipscale.experiments.participants.simulated_people.bare_run import bare_run
from slipscale.experiments.participants.simulated_people.habits import Habits
from slipscale.experiments.participants.simulated_people.population import Population, curves
from slipscale.experiments.protocols.magnitude_production import MagnitudeProduction
from slipscale.experiments.protocols.ratio_to_standard import RatioToStandard
from slipscale.experiments.protocols.steps import Adjust, Ask, Present
from slipscale.experiments.running.pilot import pilot_plans
from slipscale.experiments.study.file import read_study

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants

    Array = NDArray[np.float64]

PEOPLE = 12
RECOVERED = 400
DRAWN, GRID = 20_000, 441
LEVEL = 0.95
STUDIES = {
    "visual_analogue_scale": "rating",
    "ratio_to_standard": "ratio",
    "magnitude_production": "produced_um_pp",
}


def simulated(name: str, participants: int, people: Population) -> pd.DataFrame:
    """Return a study's main trials as the analysis reads them, from bare runs."""
    answer_of = STUDIES[name]
    rows = []
    for plan in pilot_plans(name, participants=participants, seed=None, language=None):
        shown = 0.0
        for step, answer, _ in bare_run(plan, people):
            if isinstance(step, Present) and step.trial:
                shown = step.surface.amplitude_um_pp
            if isinstance(step, Ask | Adjust) and step.name == answer_of and step.trial:
                factors = step.trial.factors
                if step.trial.phase == "main" and not factors["catch"]:
                    rows.append(
                        {
                            "participant_id": plan.participant,
                            "task": name,
                            "surface": f"{shown:g}",
                            "amplitude_um_pp": shown,
                            "bound": "",
                            **factors,
                            answer_of: answer.value,
                        }
                    )
    return pd.DataFrame(rows)


class Drawn:
    """People drawn from the population's description: their curves, as arrays."""

    def __init__(self, people: Population, seed: int = 1) -> None:
        random = np.random.default_rng(seed)
        self.people = people
        self._curves = curves(people)
        self._intercept, self._exponent, own, trial, shift, stretch = random.normal(size=(6, DRAWN))
        sigma = people.noise_sigma
        spread = np.sqrt(people.trial_to_trial) * np.exp(sigma * own - sigma**2)
        self.noise = spread * trial
        self._shift = people.line_shift_sd * shift
        self._stretch = np.exp(people.line_stretch_sigma * stretch)
        self._felt: Array | None = None  # at the amplitudes that the plate can be turned to
        self.uniform = random.uniform(size=(2, DRAWN))

    def percent(self, amplitude_um_pp: float, noise: Array | float = 0.0) -> Array:
        """Return everybody's sensation, 0 to 100."""
        intercept, exponent = self._curves.turns(amplitude_um_pp)
        a, b = self._curves.shapes(amplitude_um_pp)
        deviate = intercept * self._intercept + exponent * self._exponent + noise
        return np.asarray(100 * betaincinv(a, b, ndtr(deviate)))

    def rating(self, amplitude_um_pp: float) -> Array:
        """Return everybody's place on the line."""
        share = np.clip(self.percent(amplitude_um_pp, self.noise) / 100, 0.001, 0.999)
        logit = self._shift + self._stretch * np.log(share / (1 - share))
        return np.asarray(np.round(100 / (1 + np.exp(-logit))))

    def log_ratio(self, amplitude_um_pp: float, standard_um_pp: float) -> Array:
        """Return the logarithm of everybody's ratio to the standard, typed with two digits."""
        ratio = np.maximum(self.percent(amplitude_um_pp, self.noise), 0.5)
        ratio /= np.maximum(self.percent(standard_um_pp), 0.5)
        digits = 10.0 ** (np.floor(np.log10(ratio)) - 1)
        return np.asarray(np.log(np.maximum(np.round(ratio / digits) * digits, 0.01)))

    def log_produced(self, number: float, task: MagnitudeProduction) -> Array:
        """Return the mean of everybody's log amplitudes, from a low and from a high beginning."""
        low, high, step = task.lowest_um_pp, task.highest_um_pp, task.step_um_pp
        wanted = (number / task.modulus) ** (1 - self.people.habits.regression)
        target = wanted * np.maximum(self.percent(task.standard_um_pp), 0.5)
        grid = np.linspace(low, high, GRID)
        if self._felt is None:
            self._felt = np.stack([self.percent(each, self.noise) for each in grid])
        reached = self._felt >= target
        logs = []
        for began, uniform in zip(("low", "high"), self.uniform, strict=True):
            away = 0.25 * (high - low) * uniform
            start = low + away if began == "low" else high - away
            place = np.rint((start - low) / (high - low) * (GRID - 1)).astype(int)
            goes_up = ~reached[place, np.arange(DRAWN)]
            # Up to the first amplitude that is strong enough, down to the first that is not.
            above = reached & (grid[:, None] >= start)
            below = ~reached & (grid[:, None] <= start)
            up = np.where(above.any(axis=0), grid[above.argmax(axis=0)], high)
            down = np.where(below.any(axis=0), grid[GRID - 1 - below[::-1].argmax(axis=0)], low)
            end = np.where(goes_up, up, down)
            turns = np.maximum(np.ceil(np.abs(end - start) / step), 1)
            landed = start + np.where(goes_up, 1, -1) * turns * step
            logs.append(np.log(np.clip(landed, low, high)))
        return np.asarray(np.mean(logs, axis=0))


def truths(people: Population) -> dict[str, dict[str, float]]:
    """Return what each analysis should find."""
    drawn = Drawn(people)
    rated, judged, produced = (read_study(name)[0] for name in STUDIES)
    judging, producing = judged.tasks[0], produced.tasks[0]
    if not (isinstance(judging, RatioToStandard) and isinstance(producing, MagnitudeProduction)):
        raise TypeError("the shipped studies begin with other tasks")
    log_ratios = [
        drawn.log_ratio(each, judging.standard_um_pp).mean() for each in judged.amplitudes_um_pp
    ]
    logs = [drawn.log_produced(each, producing).mean() for each in producing.numbers]
    return {
        "visual_analogue_scale": {
            **{f"mean at {a:g} µm": drawn.rating(a).mean() for a in rated.amplitudes_um_pp},
            "pull of the start": people.habits.anchoring,
        },
        "ratio_to_standard": {
            **{
                f"log ratio at {a:g} µm": log
                for a, log in zip(judged.amplitudes_um_pp, log_ratios, strict=True)
            },
            "exponent": _slope(judged.amplitudes_um_pp, log_ratios),
        },
        "magnitude_production": {
            **{
                f"log amplitude of {n:g}": log
                for n, log in zip(producing.numbers, logs, strict=True)
            },
            "slope": _slope(producing.numbers, logs),
        },
    }


def _slope(x: tuple[float, ...], y: list[float]) -> float:
    return float(np.polyfit(np.log(x), y, 1)[0])


def found(name: str, trials: pd.DataFrame) -> dict[str, tuple[float, float, float]]:
    """Return what the analysis finds: value, and the bounds of its interval."""
    if name == "visual_analogue_scale":
        (rated,) = ratings(trials, LEVEL)
        values = {f"mean at {e.surface} µm": (e.mean, *e.interval) for e in rated.surfaces}
        return {**values, "pull of the start": _of(rated.start_effect)}
    if name == "ratio_to_standard":
        (judged,) = ratios(trials, LEVEL)
        law = judged.power_law
        values = {
            f"log ratio at {e.comparison_um_pp:g} µm": tuple(np.log([e.ratio, *e.interval]))
            for e in judged.surfaces
        }
        return {**values, "exponent": (law.exponent, *law.interval)}
    (made,) = productions(trials, LEVEL)
    values = {
        f"log amplitude of {e.number:g}": tuple(np.log([e.amplitude_um_pp, *e.interval]))
        for e in made.numbers
    }
    return {**values, "slope": _of(made.slope)}


def _of(mean: MeanOverParticipants | NotComputed) -> tuple[float, float, float]:
    if isinstance(mean, NotComputed):
        raise TypeError(mean.reason)
    return (mean.mean, *mean.interval)


def studies(trials: pd.DataFrame) -> Iterator[pd.DataFrame]:
    """Yield the trials of twelve people at a time."""
    labels = trials["participant_id"].unique()
    for first in range(0, len(labels) - PEOPLE + 1, PEOPLE):
        yield trials[trials["participant_id"].isin(labels[first : first + PEOPLE])]


def main() -> int:
    """Run the comparison and print it; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--studies", type=int, default=400, help="studies of twelve people")
    parser.add_argument("--regression", type=float, default=0.0, help="the habit, in production")
    options = parser.parse_args()
    people = Population()
    if options.regression:
        people = people.model_copy(update={"habits": Habits(regression=options.regression)})
    worst = 0.0
    print(f"{'study':24}{'quantity':24}{'truth':>9}{'found':>9}{'SE':>8}{'bias/SE':>9}{'cover':>8}")
    for name, expected in truths(people).items():
        if options.regression and name != "magnitude_production":
            continue
        trials = simulated(name, max(options.studies * PEOPLE, RECOVERED), people)
        labels = trials["participant_id"].unique()[:RECOVERED]
        whole = found(name, trials[trials["participant_id"].isin(labels)])
        each = [found(name, one) for one in studies(trials)][: options.studies]
        for quantity, truth in expected.items():
            value, low, high = whole[quantity]
            error = (high - low) / 2 / 1.966  # Student's, 399 degrees of freedom
            held = np.mean([one[quantity][1] <= truth <= one[quantity][2] for one in each])
            worst = max(worst, abs(value - truth) / error)
            print(
                f"{name:24}{quantity:24}{truth:9.3f}{value:9.3f}{error:8.4f}"
                f"{(value - truth) / error:9.2f}{held:8.3f}"
            )
    print(f"largest bias: {worst:.2f} standard errors")
    return int(worst > 3)


if __name__ == "__main__":
    sys.exit(main())
