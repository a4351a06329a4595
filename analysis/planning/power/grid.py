"""List the conditions of a power analysis: all combinations of the options' values."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from itertools import product
from typing import TYPE_CHECKING, Any, cast, get_args

from slipscale.experiments.protocol_parts.ordering.orders import Rule
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.experiments.participants.simulated_people.population import Population

FEWEST_PARTICIPANTS = 3
#: Maximum number of values in a range. A range with more values is probably a typing error.
MOST_VALUES = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """A combination of study design and participant behaviour.

    Parameters
    ----------
    participants : int
    repetitions : int
        Number of ratings per surface.
    effect : float
        Multiplier of the differences between the population's mean sensations; effects of factors
        are raised to this power. The value 0.5 halves the differences between mean sensations.
    lapses, dropout : float
        Proportions; see `slipscale.experiments.participants.simulated_people.habits.Habits`.
    exponent : float
        Exponent of a power function for the mean sensation at amplitudes above 0 µm. The exponent 0
        keeps the mean sensations of the population.
    order : {"blocked", "simple", "williams"} or None
        Rule for the order of surfaces; None keeps the rule in the study file.
    catch_steps : int or None
        Number of catch steps (steps without a change) per series in the descending difference task.
        If None, the number in the study file is used, and the precision of the false-alarm rate and
        of d' at these steps is not estimated.
    """

    participants: int
    repetitions: int = 1
    effect: float = 1.0
    lapses: float = 0.0
    dropout: float = 0.0
    exponent: float = 0.0
    order: Rule | None = None
    catch_steps: int | None = None

    def told(self, axis: str) -> str:
        """Format an option's value; return an empty string if the study's value is used."""
        value = getattr(self, axis)
        return "" if value is None else str(value) if isinstance(value, str) else f"{value:g}"

    def described(self, axes: Sequence[str]) -> str:
        """Format the values of several options.

        >>> Condition(participants=8, catch_steps=2).described(["effect", "catch_steps"])
        'effect 1, catch steps 2'
        """
        return ", ".join(f"{axis.replace('_', ' ')} {self.told(axis)}" for axis in axes)

    def people(self, population: Population) -> Population:
        """Apply this condition's effect, exponent, lapses and dropout to a population."""
        centre = math.fsum(population.mean_sensation) / len(population.mean_sensation)
        top_level, top = population.levels[-1], population.mean_sensation[-1]
        mean = tuple(
            top * (amplitude / top_level) ** self.exponent if self.exponent and amplitude else own
            for amplitude, own in zip(population.levels, population.mean_sensation, strict=True)
        )
        mean = tuple(centre + self.effect * (each - centre) for each in mean)
        if not all(0 < each < 100 for each in mean):  # noqa: PLR2004
            raise UserError(
                "--effect {effect:g}: mean sensations would range from {low:.3g} to {high:.3g}; "
                "expected an effect that keeps them between 0 and 100",
                effect=self.effect,
                low=min(mean),
                high=max(mean),
            )
        habits = population.habits.model_copy(
            update={"lapses": self.lapses, "dropout": self.dropout}
        )
        changed = {"mean_sensation": mean, "habits": habits}
        for key in ("effects", "growths"):
            known = getattr(population, key)
            changed[key] = tuple((name, level, by**self.effect) for name, level, by in known)
        # On a scale from 0 to 100, the largest possible spread depends on the mean.
        most = (0.9 * math.sqrt(each * (100 - each)) for each in mean)
        changed["sd_sensation"] = tuple(map(min, population.sd_sensation, most))
        return population.model_copy(update=changed)


AXES: tuple[str, ...] = tuple(field.name for field in fields(Condition))
_SHARE = (lambda value: 0 <= value <= 1, "proportions from 0 to 1")
#: Type, validation function and expected values (for error messages) of each option.
EXPECTED: dict[str, tuple[type, tuple[Callable[[float], bool], str]]] = {
    "participants": (
        int,
        (lambda n: n >= FEWEST_PARTICIPANTS, f"{FEWEST_PARTICIPANTS} participants or more"),
    ),
    "repetitions": (int, (lambda n: 1 <= n <= 1000, "1 to 1000")),  # noqa: PLR2004
    "effect": (float, (lambda value: value >= 0, "0 or more")),
    "lapses": (float, _SHARE),
    "dropout": (float, _SHARE),
    "exponent": (float, (lambda value: value >= 0, "0 or more")),
    "catch_steps": (int, (lambda n: 0 <= n <= 100, "0 to 100")),  # noqa: PLR2004
}


def option(axis: str) -> str:
    """Convert the name of a field to a command-line option.

    >>> option("catch_steps")
    '--catch-steps'
    """
    return f"--{axis.replace('_', '-')}"


def orders_of(words: Sequence[str]) -> tuple[Rule, ...]:
    """Convert comma-separated names to rules for the order of surfaces.

    Raises
    ------
    UserError
        If no name is given, or if a name is unknown.
    """
    known = get_args(Rule)
    named = [word.strip() for word in ",".join(words).split(",") if word.strip()]
    wrong = [word for word in named if word not in known]
    if wrong or not named:
        raise UserError(
            "--order {words}: expected one or more of {known}, separated by commas",
            words=" ".join(wrong),
            known=", ".join(known),
        )
    return tuple(dict.fromkeys(cast("list[Rule]", named)))


def values_of(axis: str, words: Sequence[str]) -> tuple[Any, ...]:
    """Parse an option's values: a range or a list, such as ``8:40:4``, ``1,0.5`` or ``8 12 16``.

    Raises
    ------
    UserError
        If the option has no value, or if a value is out of range or is not a number.
    """
    kind, (meant, expected) = EXPECTED[axis]
    found: list[float] = []
    for word in ",".join(words).split(","):
        if word.strip():
            found += _range(axis, word.strip(), kind)
    if not found:
        raise UserError(
            "{option}: no value; expected a list or a range, such as 8,12,16 or 8:40:4",
            option=option(axis),
        )
    for value in found:
        if not (math.isfinite(value) and meant(value)):
            raise UserError(
                "{option} {value:g}: expected {expected}",
                option=option(axis),
                value=value,
                expected=expected,
            )
    return tuple(sorted({kind(value) for value in found}))


def _range(axis: str, word: str, kind: type) -> list[float]:
    parts = word.split(":")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        raise UserError(
            "{option} {word}: expected numbers, such as the list 8,12 or the range 8:40:4",
            option=option(axis),
            word=word,
        ) from None
    if kind is int and any(not number.is_integer() for number in numbers):
        raise UserError("{option} {word}: expected whole numbers", option=option(axis), word=word)
    if len(numbers) == 1:
        return numbers
    first, last, step = (*numbers, 1.0)[:3]
    count = (last - first) / step if step else math.nan
    if len(numbers) > 3 or not 0 <= count < MOST_VALUES:  # noqa: PLR2004
        raise UserError(
            "{option} {word}: expected FIRST:LAST or FIRST:LAST:STEP, ascending, of at most "
            "{most_values} values",
            option=option(axis),
            word=word,
            most_values=MOST_VALUES,
        )
    return [round(first + number * step, 12) for number in range(math.floor(count + 1e-9) + 1)]


def conditions(axes: dict[str, tuple[Any, ...]]) -> list[Condition]:
    """Return all combinations of the options' values.

    Raises
    ------
    UserError
        If the proportions of lapses and dropout add up to 1 or more.
    """
    found = [
        Condition(**dict(zip(axes, values, strict=True))) for values in product(*axes.values())
    ]
    for each in found:
        if each.lapses + each.dropout >= 1:
            raise UserError(
                "--lapses {lapses:g} and --dropout {dropout:g}: no genuine answers remain; "
                "expected a sum below 1",
                lapses=each.lapses,
                dropout=each.dropout,
            )
    return found


def without_effect(wanted: Sequence[Condition]) -> list[Condition]:
    """Return the conditions without an effect and without duplicates, for false-alarm rates."""
    return list(dict.fromkeys(map(without_its_effect, wanted)))


def without_its_effect(condition: Condition) -> Condition:
    """Return a copy of a condition with the effect removed, for estimating false-alarm rates."""
    return replace(condition, effect=0.0, exponent=0.0)
