"""Write the sentences on the primary and the secondary analyses."""

from __future__ import annotations

from collections.abc import Iterator

from slipscale.analysis.statistics.not_computed import NotComputed, missing
from slipscale.analysis.statistics.statistic import Inference
from slipscale.analysis.tasks.estimation.statistics import STATISTICS
from slipscale.experiments.study.analysis_choices import Primary
from slipscale.stimuli.quantity import Quantity

#: Names of the primary analyses in a plan; ``q`` is a placeholder for the quantity.
TITLES: dict[Primary, str] = {
    "ranks": "Friedman's test, and Wilcoxon's test for each pair of {q.levels}, Holm-corrected",
    "logarithms": "repeated-measures ANOVA of log estimates (Greenhouse-Geisser), and a paired t "
    "test for each pair of {q.levels}, Holm-corrected",
}


def _written(
    inference: Inference,
    primary: Primary,
    confidence: float,
    quantity: Quantity,
    *,
    of_primary: bool,
) -> Iterator[str | NotComputed]:
    """Yield sentences on primary or secondary results, or `NotComputed` for missing results."""
    for statistic in STATISTICS:
        found = inference[statistic]
        for sentence in statistic.sentences:
            if (sentence.primary == primary) is not of_primary:
                continue
            if isinstance(found, NotComputed):
                yield found
            elif (text := sentence.write(found, confidence, quantity)) is not None:
                yield text


def primary_sentences(
    inference: Inference, primary: Primary, confidence: float, quantity: Quantity
) -> list[str]:
    """Return the sentences about the primary analysis, or the reason why it was not computed."""
    found = list(_written(inference, primary, confidence, quantity, of_primary=True))
    if texts := [each for each in found if isinstance(each, str)]:
        return texts
    reasons = {each.reason for each in missing(found)}
    return [f"The primary analysis was not computed: {'; '.join(sorted(reasons))}."]


def secondary_sentences(
    inference: Inference, primary: Primary, confidence: float, quantity: Quantity
) -> list[str]:
    """Return the sentences on all secondary tests of magnitude estimates."""
    found = _written(inference, primary, confidence, quantity, of_primary=False)
    return [each for each in found if isinstance(each, str)]
