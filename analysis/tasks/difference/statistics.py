"""Declare the statistic of the descending difference task."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from slipscale.analysis.reading.delimited import read_tables
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Family, Inputs, Named, Statistic
from slipscale.analysis.tasks.difference.coder_agreement import agreement
from slipscale.analysis.tasks.difference.verbal_coding import SHIPPED, load_codebook
from slipscale.analysis.tasks.difference.yes_no import DescendingDifference, analyse_differences

if TYPE_CHECKING:
    from slipscale.analysis.reading.dataset import Dataset


def difference(data: Dataset) -> DescendingDifference | NotComputed:
    """Analyse yes/no answers and verbal reports, and the agreement between human coders."""
    folder, name = data.folder, data.choices.codebook
    book = load_codebook(folder / name if folder and name else SHIPPED)
    choices = data.choices
    found = analyse_differences(
        data.differences, book, choices.confidence, data.quantity, choices.axis or "linear"
    )
    codes = folder / "code" / "verbal_codes.tsv" if folder else None
    if isinstance(found, NotComputed) or codes is None or not codes.is_file():
        return found
    frame, _ = read_tables([codes], codes.parent, required=("verbal_report", "coder", "category"))
    return replace(found, coders=agreement(frame))


def _curves(found: DescendingDifference) -> list[float]:
    return [one.p for one in (found.psychometric, found.weber) if one]


class _Difference(Statistic[DescendingDifference]):
    key = "difference"
    meaning = "descending difference: proportions of “yes”, d′, curves and verbal reports"
    families = (Family(name="slope of the curve of “{q.yes}”", read=_curves),)
    methods = (
        "Proportions of “{q.yes}” have Clopper–Pearson intervals; repeated answers are weighted by "
        "their effective sample size [[korn1998]]. The probability of “{q.yes}” was modelled as a "
        "logistic function of {q.yes_no.size}, fitted by generalised estimating equations with an "
        "exchangeable within-participant correlation [[liang1986]], small-sample standard errors "
        "[[mancl2001]] and Fieller's interval for the midpoint. Sensitivity (d′) comes from a "
        "probit model that includes participant effects, with profile-likelihood intervals; "
        "individual d′ and c values use the log-linear correction [[hautus1995]]."
    )
    conclusions = (
        Named("finding.all_felt_a_difference", "everybody felt a difference at least once"),
        Named("finding.all_said_less_slippery", "everybody said “less slippery”"),
        Named("psychometric.p", "the answer “yes” depends on the size of the step"),
        Named("weber.p", "the answer “yes” depends on the Weber fraction of the step"),
    )
    headlines = (Named("d_prime", "d′ of the descending difference"),)

    def compute(self, inputs: Inputs) -> DescendingDifference | NotComputed:
        return difference(inputs.data)


DIFFERENCE = _Difference()
