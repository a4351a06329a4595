"""Summarise simulated studies: power, precision, false alarms, and sample sizes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.planning.power.grid import AXES, Condition, without_its_effect
from slipscale.analysis.planning.power.outcome import Outcome, Share, Sums
from slipscale.analysis.writing.numbers import joined

if TYPE_CHECKING:
    from slipscale.analysis.planning.power.design import Design
    from slipscale.analysis.planning.power.shard import Looks

LOOK = "look after "
#: Number of Gauss-Hermite nodes for averaging power over the distribution of the effect.
EFFECTS = 9
#: Smallest distance between a mean sensation and an end of the scale.
ROOM = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Summary of one condition's simulated studies.

    Parameters
    ----------
    condition : Condition
    power : Mapping
        Proportion of studies with a significant result, keyed by test or pair of neighbouring
        levels.
    decisive : tuple of str
        Tests that must all reach the target power: the primary omnibus test, the tests of all pairs
        of neighbouring levels, and the tests of factors with a simulated effect. If the design
        includes none of these tests, the tuple contains all tests.
    false_alarms : Mapping
        Proportion of studies simulated without an effect in which each test is significant.
    widths : Mapping
        Half-widths of the confidence interval, keyed by estimated quantity.
    steps : Mapping
        Results from catch steps; empty if not requested.
    unusable : Share
        Proportion of studies that `analyse` would reject.
    looks : tuple of (int, Share)
        Number of participants at each interim analysis, with the proportion of studies that
        stopped there.
    false_looks : Share or None
        Proportion of studies that stopped at any interim analysis although there was no effect.
    assurance : float or None
        Expected power, averaged over the uncertainty in the effect.
    """

    condition: Condition
    power: Mapping[str, Share]
    decisive: tuple[str, ...]
    false_alarms: Mapping[str, Share]
    widths: Mapping[str, Sums]
    steps: Mapping[str, Sums]
    unusable: Share
    looks: tuple[tuple[int, Share], ...] = ()
    false_looks: Share | None = None
    assurance: float | None = None

    @property
    def weakest(self) -> Share:
        """Lowest power among the tests that must reach the target power."""
        return min((self.power[name] for name in self.decisive), key=lambda share: share.value)

    @property
    def expected_participants(self) -> float:
        """Mean number of participants in a study that may stop at an interim analysis."""
        ended = math.fsum(share.value for _, share in self.looks)
        early = math.fsum(size * share.value for size, share in self.looks)
        return early + (1 - ended) * self.condition.participants

    @property
    def any_look(self) -> float:
        """The proportion of studies that stopped at any interim analysis."""
        return math.fsum(share.value for _, share in self.looks)


@dataclass(frozen=True, slots=True, kw_only=True)
class Assurance:
    """Normal distribution that represents the uncertainty in an effect."""

    mean: float
    sd: float

    def effects(self, largest: float) -> list[tuple[float, float]]:
        """Return effects between 0 and `largest`, with their quadrature weights."""
        nodes, weights = np.polynomial.hermite_e.hermegauss(EFFECTS)
        values = np.clip(self.mean + self.sd * nodes, 0.0, largest)
        # Rounded, because a difference in the last bit would give a different condition on another
        # machine.
        return [
            (round(float(value), 6), float(weight))
            for value, weight in zip(values, weights / weights.sum(), strict=True)
        ]


def largest_effect(design: Design) -> float:
    """Return the largest effect for which all mean sensations remain within the scale."""
    mean = np.array(design.population.mean_sensation)
    away = np.abs(mean - mean.mean()).max()
    room = min(mean.mean(), 100 - mean.mean()) - ROOM
    return float(room / away) if away > 0 else 1.0


def rows(
    design: Design,
    wanted: Sequence[Condition],
    outcomes: Mapping[Condition, Outcome],
    *,
    looks: Looks,
    assurance: Assurance | None = None,
) -> list[Row]:
    """Summarise the wanted conditions that have been simulated, in their order."""
    return [
        _row(design, condition, outcomes, looks, assurance)
        for condition in wanted
        if condition in outcomes
    ]


def _row(
    design: Design,
    condition: Condition,
    outcomes: Mapping[Condition, Outcome],
    looks: Looks,
    assurance: Assurance | None,
) -> Row:
    own = outcomes[condition]
    without = outcomes.get(without_its_effect(condition))
    tests = [name for name in own.found if not name.startswith(LOOK)]
    neighbours = [name for name in tests if " - " in name]
    effects = [name for name, simulated in design.factor_tests.items() if simulated]
    first = [design.omnibus] if design.omnibus in tests else []
    steps = [name for name in own.found if name.startswith(LOOK)]
    expected = None
    if assurance:
        expected = math.fsum(
            weight
            * weakest(outcomes[replace(condition, effect=effect)], [*first, *neighbours, *effects])
            for effect, weight in assurance.effects(largest_effect(design))
        )
    return Row(
        condition=condition,
        power={name: own.power(name) for name in tests},
        decisive=tuple([*first, *neighbours, *effects] or tests),
        false_alarms={name: without.power(name) for name in tests} if without else {},
        widths=own.widths,
        steps=own.steps,
        unusable=Share.of(own.unusable, own.studies),
        looks=tuple((int(name.removeprefix(LOOK)), own.power(name)) for name in steps),
        false_looks=Share.of(sum(without.found[name] for name in steps), without.studies)
        if without and looks.number > 1
        else None,
        assurance=expected,
    )


def weakest(outcome: Outcome, tests: Sequence[str]) -> float:
    """Return the lowest power among the tests."""
    return min(outcome.power(name).value for name in tests or list(outcome.found))


def varying(found: Sequence[Row]) -> list[str]:
    """Return the options that differ between conditions; ``participants`` is always included."""
    return [
        axis
        for axis in AXES
        if axis == "participants" or len({getattr(row.condition, axis) for row in found}) > 1
    ]


def fewest(found: Sequence[Row], target: float) -> dict[Condition, int | None]:
    """Return the smallest sufficient sample size for each condition.

    A sample size is sufficient if the power reaches the target with this size and with all larger
    sizes that were simulated.

    Returns
    -------
    dict
        Sample size, or None if no size suffices, keyed by condition (with ``participants`` set to
        0).
    """
    enough: dict[Condition, int | None] = {}
    missed: set[Condition] = set()
    for row in sorted(found, key=lambda one: -one.condition.participants):
        others = replace(row.condition, participants=0)
        enough.setdefault(others, None)
        if row.weakest.value < target:
            missed.add(others)
        if others not in missed:
            enough[others] = row.condition.participants
    return enough


def equal_effects(design: Design) -> list[str]:
    """Return the names of the factors whose effect is equal in all simulated people."""
    differing = dict(design.population.effect_sds)
    return [name for name, _ in design.task.factors if name not in differing]


def assumption(design: Design) -> str:
    """Return a warning about effects that are equal in all simulated people; empty without."""
    if not (names := equal_effects(design)):
        return ""
    return (
        f"All simulated people have the same effect of {joined(names)}. Power is lower if people "
        "differ: in one example, it fell from .52 to .10 with simulated_sd = 0.1 in "
        "[[factors]]. Set simulated_sd to the spread that you expect."
    )


def sentence(design: Design, row: Row) -> str:
    """Describe the power in one condition, for use in a grant application."""
    condition, weak = row.condition, row.weakest
    people = (
        "" if condition.effect == 1 else f" and {condition.effect:g} times the population's effect"
    )
    ratings = "rating" if condition.repetitions == 1 else "ratings"
    tests = PRIMARY_TESTS[design.choices.primary]
    if any(design.factor_tests.values()):
        tests += "; repeated-measures ANOVA for effects of factors"
    first = (
        f"With {condition.participants} participants and {condition.repetitions} {ratings} of each "
        f"of {len(design.task.levels)} surfaces, every planned comparison ({tests}; "
        f"two-sided, alpha = {design.alpha:g}) was significant in at least {weak.value:.0%} of "
        f"{weak.studies:,} simulated studies (95 % Monte Carlo interval {weak.low:.1%} to "
        f"{weak.high:.1%}) with people from population '{design.population.name}'{people}"
    )
    parts = [first]
    if condition.lapses or condition.dropout:
        parts.append(f"with {condition.lapses:.0%} lapses and {condition.dropout:.0%} dropout")
    alarms = row.false_alarms.get(row.decisive[0])
    if alarms:
        parts.append(
            f"without an effect, {test_title(row.decisive[0])} was significant in "
            f"{alarms.value:.1%} of studies ({alarms.low:.1%} to {alarms.high:.1%})"
        )
    width = row.widths["exponent"].mean
    if math.isfinite(width):
        level = design.choices.confidence
        parts.append(
            f"the {level:.0%} interval for the exponent has a mean half-width of {width:.2f}"
        )
    if names := equal_effects(design):
        parts.append(f"the effect of {joined(names)} was assumed to be equal in all people")
    return "; ".join(parts) + "."


#: Names of tests in sentences and tables, keyed by their names in study files.
TITLES = {
    "friedman": "Friedman's test",
    "rm_anova": "the repeated-measures ANOVA",
    "page_trend": "Page's test",
    "linear_trend": "the linear trend",
    "power_law": "the exponent",
    "mixed_model": "the mixed model's exponent",
}


def test_title(name: str) -> str:
    """Return the title of a test, a pair of levels or a factor for printed output."""
    return TITLES.get(name, name)


PRIMARY_TESTS = {
    "ranks": "Friedman's test, and Wilcoxon signed-rank tests between neighbouring levels, "
    "Holm-corrected across all pairs",
    "logarithms": "repeated-measures ANOVA of logarithms with the Greenhouse–Geisser correction, "
    "and paired t tests between neighbouring levels, Holm-corrected across all pairs",
}


def as_json(design: Design, found: Sequence[Row], target: float) -> dict[str, object]:
    """Return all conditions and their results as JSON data."""
    return {
        "study": design.name,
        "population": design.population.name,
        "primary": design.choices.primary,
        "normalisation": design.rule,
        "exclusions": list(design.choices.exclusions),
        "alpha": design.alpha,
        "target": target,
        "equal_effects": equal_effects(design),
        "warning": assumption(design),
        "enough": [
            {**asdict(others), "participants": size}
            for others, size in fewest(found, target).items()
        ],
        "conditions": [_as_json(row) for row in found],
    }


def _as_json(row: Row) -> dict[str, object]:
    return {
        **asdict(row.condition),
        "weakest": row.weakest.value,
        "power": {name: asdict(share) for name, share in row.power.items()},
        "false_alarms": {name: asdict(share) for name, share in row.false_alarms.items()},
        "half_widths": _means(row.widths),
        "steps": _means(row.steps),
        "not_analysable": row.unusable.value,
        "looks": [{"participants": size, **asdict(share)} for size, share in row.looks],
        "looks_false_alarms": asdict(row.false_looks) if row.false_looks else None,
        "expected_participants": row.expected_participants if row.looks else None,
        "assurance": row.assurance,
    }


def _means(sums: Mapping[str, Sums]) -> dict[str, dict[str, float | None]]:
    return {
        name: {"mean": _finite(each.mean), "error": _finite(each.error)}
        for name, each in sums.items()
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
