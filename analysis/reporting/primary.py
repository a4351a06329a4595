"""The primary analysis: what the study declared, and what it says in one sentence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from slipscale.experiments.study.analysis_choices import Primary


@dataclass(frozen=True, slots=True, kw_only=True)
class Family:
    """Tests that make one analysis.

    Parameters
    ----------
    tests : tuple of str
        Names of `slipscale.analysis.reporting.apa.WRITERS`, in the order of their sentences.
    title : str
        In words.
    """

    tests: tuple[str, ...]
    title: str


FAMILIES: dict[Primary, Family] = {
    "ranks": Family(
        tests=("friedman", "pairwise_ranks"),
        title="Friedman's test, and Wilcoxon's test of each pair of amplitudes, Holm-corrected",
    ),
    "logarithms": Family(
        tests=("rm_anova", "pairwise_logs"),
        title="repeated-measures ANOVA of log estimates (Greenhouse-Geisser), and paired t of each "
        "pair of amplitudes, Holm-corrected",
    ),
}
