"""Write the report section on the descending difference task."""

from __future__ import annotations

from collections.abc import Mapping

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.difference import sentences
from slipscale.analysis.tasks.difference.figures import step_label
from slipscale.analysis.tasks.difference.statistics import DIFFERENCE
from slipscale.analysis.tasks.difference.yes_no import DescendingDifference
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.axes import LINES_AT_MOST
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import grouped, interval
from slipscale.stimuli.quantity import Quantity, capitalised

#: Largest number of different wordings shown per category.
WORDINGS_SHOWN = 40


def _caption(found: DescendingDifference, quantity: Quantity) -> str:
    fit = found.psychometric
    intervals = (
        f"Proportion of “{quantity.yes}” answers at each {quantity.yes_no.each}, with "
        "Clopper–Pearson intervals."
    )
    texts = [intervals]
    if fit:
        texts.append(
            "Curve: logistic function, with a pointwise confidence band (t distribution, "
            f"{fit.df} degrees of freedom)."
        )
    if 1 < found.participants <= LINES_AT_MOST:
        texts.append(
            "Rings: individual participants' proportions; larger rings represent more participants."
        )
    return " ".join(texts)


def difference(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section with the figure, the steps and the verbal reports."""
    quantity = analysis.dataset.quantity
    section = ReportSection(capitalised(quantity.yes_no.name))
    found = analysis.inference[DIFFERENCE]
    if not found or "difference" not in svgs:
        return section
    if quantity.stepped:
        confidence = analysis.dataset.choices.confidence
        section.gist = [sentences.psychometric(found.psychometric, confidence, quantity)]
    section.blocks.append(
        html.figure(
            svgs["difference"],
            _caption(found, quantity),
            f"Proportion of “{quantity.yes}” answers. "
            + ", ".join(
                f"{step_label(step, quantity)}: {step.yes} of {step.n}" for step in found.steps
            )
            + f", no change: {found.catch.yes} of {found.catch.n}",
        )
    )
    if not quantity.stepped:
        # Participants were not asked about the removed amplitude.
        if (analysis.dataset.differences["level"] > 0).any():
            section.blocks.append(
                html.paragraph(
                    "Levels are differences between the stimulus and its reference.", "note"
                )
            )
        return section
    words = found.verbal_reports
    if isinstance(words, NotComputed):
        section.blocks.append(html.paragraph(f"There are {words.reason}.", "note"))
        return section
    section.blocks.append(
        html.table(
            [
                TableColumn(title="Category", left=True),
                TableColumn(title="Reports"),
                TableColumn(title="In the participants' words", left=True),
            ],
            [
                [
                    name,
                    str(entry.count),
                    "; ".join(
                        f"“{text}”" + (f" ×{count}" if count > 1 else "")
                        for text, count in list(entry.words.items())[:WORDINGS_SHOWN]
                    ),
                ]
                for name, entry in words.categories.items()
            ],
            f"Answers to “What has been removed?”: {words.n} reports, coded with {words.codebook}. "
            "A report can belong to several categories. Less slippery: "
            f"{words.meaning.get('less_slippery', 0)}; more slippery: "
            f"{words.meaning.get('more_slippery', 0)}; unclear: "
            f"{words.meaning.get('unclear', 0)}.",
        )
    )
    coders = found.coders
    if coders:
        section.blocks.append(
            html.paragraph(
                f"Two coders ({' and '.join(coders.coders)}) agreed on {coders.agreed} of "
                f"{coders.reports} reports, Cohen's κ = {grouped(coders.kappa)}, 95 % CI "
                f"{interval(*coders.interval)}."
            )
        )
    return section
