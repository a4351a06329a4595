"""Every test of the report in one list: families, their correction, what survives them all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from slipscale.analysis.statistics.holm import holm
from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants
from slipscale.analysis.statistics.not_computed import NotComputed

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from slipscale.analysis.statistics.group_comparison import GroupComparison
    from slipscale.analysis.statistics.run_all import Inference
    from slipscale.experiments.study.analysis_choices import Primary


@dataclass(frozen=True, slots=True, kw_only=True)
class FamilyOfTests:
    """Tests of one kind.

    Parameters
    ----------
    name : str
        What is tested, and how.
    primary : bool
        Whether it belongs to the study's primary analysis.
    corrected : bool
        Whether Holm's correction is over this family's tests; one test alone needs none.
    tests : int
        With a result.
    below : int
        p, corrected within the family, below the study's level.
    below_over_all : int
        p, corrected by Holm over every test of every family, below the study's level.
    """

    name: str
    primary: bool
    corrected: bool
    tests: int
    below: int
    below_over_all: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Multiplicity:
    """All tests of the report.

    Parameters
    ----------
    families : tuple of FamilyOfTests
        Those with a result.
    tests : int
        In all.
    level : float
        1 - confidence.
    """

    families: tuple[FamilyOfTests, ...]
    tests: int
    level: float


def _pairs(inference: Inference, which: str) -> list[float]:
    if isinstance(inference.pairwise, NotComputed):
        return []
    if which == "ranks":
        return [pair.ranks.p for pair in inference.pairwise]
    tested = [pair.logs for pair in inference.pairwise if not isinstance(pair.logs, NotComputed)]
    return [one.equivalence.p if which == "equivalence" else one.p for one in tested]


def _slopes(*slopes: MeanOverParticipants | NotComputed) -> list[float]:
    return [slope.p for slope in slopes if isinstance(slope, MeanOverParticipants)]


def _order(inference: Inference) -> list[float]:
    found = inference.order
    if isinstance(found, NotComputed):
        return []
    return _slopes(found.log_slope_per_trial, found.log_slope_per_um_pp_before)


def _curves(inference: Inference) -> list[float]:
    found = inference.difference
    if isinstance(found, NotComputed):
        return []
    return [one.p for one in (found.psychometric, found.weber) if not isinstance(one, NotComputed)]


def _ratings(inference: Inference, test: Literal["friedman", "page_trend"]) -> list[float]:
    if isinstance(inference.ratings, NotComputed):
        return []
    tested = [getattr(task, test) for task in inference.ratings]
    return [one.p for one in tested if not isinstance(one, NotComputed)]


def _rated_pairs(inference: Inference) -> list[float]:
    if isinstance(inference.ratings, NotComputed):
        return []
    return [pair.p_wilcoxon for task in inference.ratings for pair in task.pairs]


def _of_groups(inference: Inference, read: Callable[[GroupComparison], list[float]]) -> list[float]:
    return [] if isinstance(inference.groups, NotComputed) else read(inference.groups)


def _welch(found: GroupComparison) -> list[float]:
    parts = (found.exponents, found.levels)
    return [part.p for part in parts if not isinstance(part, NotComputed)]


def _group_pairs(found: GroupComparison) -> list[float]:
    parts = [part for part in (found.exponents, found.levels) if not isinstance(part, NotComputed)]
    # Of two groups the pair is the test of all.
    return [pair.p for part in parts if len(part.groups) > 2 for pair in part.pairs]  # noqa: PLR2004


def _mixed(found: GroupComparison) -> list[float]:
    anova = found.anova
    return [] if isinstance(anova, NotComputed) else [anova.group.p, anova.interaction.p]


def _sessions_anova(inference: Inference) -> list[float]:
    found = inference.sessions
    if isinstance(found, NotComputed) or isinstance(found.anova, NotComputed):
        return []
    return [found.anova.session.p, found.anova.interaction.p]


def _session_changes(inference: Inference) -> list[float]:
    found = inference.sessions
    measures = () if isinstance(found, NotComputed) else found.measures
    return _slopes(*(each.change for measure in measures for each in measure.changes))


#: Family: its name, the primary analysis it belongs to, whether Holm's correction is over it, and
#: its uncorrected p. The mixed model, exponents, growth functions, reliability, shares and d' are
#: estimates with intervals: nothing is tested there.
FAMILIES: tuple[tuple[str, Primary | None, bool, Callable[[Inference], Sequence[float]]], ...] = (
    (
        "amplitudes, Friedman's test",
        "ranks",
        False,
        lambda found: [] if isinstance(found.friedman, NotComputed) else [found.friedman.p],
    ),
    ("pairs of amplitudes, Wilcoxon's test", "ranks", True, lambda found: _pairs(found, "ranks")),
    (
        "amplitudes, repeated-measures analysis of variance",
        "logarithms",
        False,
        lambda found: [] if isinstance(found.rm_anova, NotComputed) else [found.rm_anova.p_gg],
    ),
    ("pairs of amplitudes, paired t", "logarithms", True, lambda found: _pairs(found, "logs")),
    ("pairs of amplitudes, equivalence", None, True, lambda found: _pairs(found, "equivalence")),
    (
        "ordered trend, Page's test",
        None,
        False,
        lambda found: [] if isinstance(found.page_trend, NotComputed) else [found.page_trend.p],
    ),
    (
        "linear trend",
        None,
        False,
        lambda found: (
            []
            if isinstance(found.linear_trend, NotComputed)
            else _slopes(found.linear_trend.log_slope_per_um_pp)
        ),
    ),
    ("order and carry-over", None, False, _order),
    ("sessions, analysis of variance", None, False, _sessions_anova),
    ("changes from the first session", None, True, _session_changes),
    ("groups, Welch's tests", None, False, lambda found: _of_groups(found, _welch)),
    ("pairs of groups, Welch's t", None, True, lambda found: _of_groups(found, _group_pairs)),
    ("groups, mixed analysis of variance", None, False, lambda found: _of_groups(found, _mixed)),
    ("curves of “yes”, slope", None, False, _curves),
    ("ratings on a line, Friedman's test", None, False, lambda found: _ratings(found, "friedman")),
    (
        "ratings on a line, Page's test",
        None,
        False,
        lambda found: _ratings(found, "page_trend"),
    ),
    ("pairs of rated surfaces, Wilcoxon's test", None, True, _rated_pairs),
)


def multiplicity(inference: Inference, primary: Primary, confidence: float) -> Multiplicity:
    """List every test that the report judges by a p, and what survives Holm's correction over all.

    Parameters
    ----------
    primary : {"ranks", "logarithms"}
        The study's primary analysis.
    confidence : float
        The study's; the level of every test is one less it.
    """
    level = round(1 - confidence, 12)
    found = {name: [p for p in read(inference) if np.isfinite(p)] for name, _, _, read in FAMILIES}
    over_all = iter(holm([p for ps in found.values() for p in ps]))
    families = []
    for name, belongs, corrected, _ in FAMILIES:
        own = found[name]
        within = holm(own) if corrected else own
        survive = [next(over_all) for _ in own]
        if own:
            families.append(
                FamilyOfTests(
                    name=name,
                    primary=belongs == primary,
                    corrected=corrected and len(own) > 1,
                    tests=len(own),
                    below=sum(p < level for p in within),
                    below_over_all=sum(p < level for p in survive),
                )
            )
    return Multiplicity(
        families=tuple(families), tests=sum(len(ps) for ps in found.values()), level=level
    )
