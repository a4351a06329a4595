"""Write the section on pairwise comparisons and on tests that could not be computed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from markupsafe import Markup

from slipscale.analysis.statistics.not_computed import missing
from slipscale.analysis.statistics.repeated_measures.pairwise import PairComparison, PairedT
from slipscale.analysis.statistics.statistic import Inference, Statistic
from slipscale.analysis.tasks.effects.groups.statistics import GROUPS
from slipscale.analysis.tasks.effects.sessions.statistics import SESSIONS
from slipscale.analysis.tasks.estimation import sentences as apa
from slipscale.analysis.tasks.estimation.statistics import PAIRWISE, STATISTICS
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import (
    DASH,
    grouped,
    interval,
    level_of,
    p_cell,
    p_value,
)
from slipscale.analysis.writing.verdicts import reliable
from slipscale.stimuli.quantity import Quantity

#: Whether a pair differs significantly, and whether it is equivalent -> conclusion.
DIFFER = "differ"
CONCLUSIONS = {
    (True, False): DIFFER,
    (True, True): "different, but within the bound",
    (False, True): "equivalent within the bound",
    (False, False): "undecided",
}


def comparisons(analysis: Analysis, _svgs: Mapping[str, str]) -> ReportSection:
    """Return the section on pairwise comparisons and on tests that could not be computed."""
    section = ReportSection("Comparisons")
    if analysis.prepared is None:
        return section
    pairs, quantity = analysis.inference[PAIRWISE], analysis.dataset.quantity
    if pairs:
        choices = analysis.dataset.choices
        other = apa.pairwise_logs if choices.primary == "ranks" else apa.pairwise_ranks
        if text := other(pairs, choices.confidence, quantity):
            section.gist = [text]
        level = f"{100 * analysis.dataset.choices.confidence:g} %"
        section.blocks.append(
            html.table(
                [
                    TableColumn(title="From → to", unit=quantity.short_unit, left=True, whole=True),
                    TableColumn(title="Ratio", unit="of geometric means"),
                    TableColumn(title=f"{level} CI", unit="of the ratio"),
                    TableColumn(title="t"),
                    TableColumn(title="df"),
                    TableColumn(title="p", unit="Holm"),
                    TableColumn(title="d_z"),
                    TableColumn(title=f"{level} CI", unit="of d_z"),
                    TableColumn(title="Up / down", unit="participants"),
                    TableColumn(title="n", unit="logs / ranks"),
                    TableColumn(title="p Wilcoxon", unit="Holm"),
                ],
                [_row(pair) for pair in pairs],
                "Paired t tests of the logarithms of estimates above zero, and Wilcoxon "
                "signed-rank tests of all estimates. d_z: mean difference divided by the "
                "standard deviation of the differences.",
            )
        )
        tested = [(pair, pair.logs) for pair in pairs if pair.logs]
        if tested:
            section.blocks += _equivalence(tested, analysis.dataset.choices.confidence, quantity)
    lacking = [
        f"{title.format(q=quantity)}: {part.reason}."
        for title, result in _parts(analysis.inference).items()
        for part in missing([result])
    ]
    if lacking:
        section.blocks.append(html.heading("Not computed"))
        section.blocks.append(html.bullets(lacking, "note"))
    return section


def _equivalence(
    tested: Sequence[tuple[PairComparison, PairedT]], confidence: float, quantity: Quantity
) -> list[Markup]:
    """Return a table and a sentence on equivalence tests and Bayes factors.

    Pairs that differ and are not equivalent are summarised in the sentence. All other pairs are
    rows of the table.
    """
    bound = tested[0][1].equivalence.bound
    within = f"within a ratio of {1 / bound:.3g} to {bound:.3g}"
    rows, differ = [], []
    for pair, logs in tested:
        conclusion = CONCLUSIONS[
            reliable(logs.p_holm, confidence), reliable(logs.equivalence_p_holm, confidence)
        ]
        if conclusion == DIFFER:
            differ.append(logs)
            continue
        rows.append(
            [
                f"{pair.from_level:g} → {pair.to_level:g}",
                grouped(logs.ratio),
                interval(*logs.equivalence.interval),
                p_cell(logs.equivalence_p_holm),
                apa.bayes_of_none(logs.bayes_factor).removeprefix("= "),
                str(pair.n_logs),
                conclusion,
            ]
        )
    blocks = []
    if rows:
        columns = [
            TableColumn(title="From → to", unit=quantity.short_unit, left=True, whole=True),
            TableColumn(title="Ratio", unit="of geometric means"),
            TableColumn(title=f"{level_of(2 * confidence - 1)} CI", unit="of the ratio"),
            TableColumn(title="p", unit="equivalence, Holm"),
            TableColumn(title="BF₀₁", unit="no difference / difference"),
            TableColumn(title="n"),
            TableColumn(title="Conclusion", left=True),
        ]
        caption = (
            f"Pairs that were equivalent {within}, and undecided pairs (two one-sided paired t "
            "tests of log estimates). BF₀₁: Bayes factor in favour of no difference."
        )
        blocks.append(html.table(columns, rows, caption))
    if differ:
        p = p_value(min(logs.equivalence_p_holm for logs in differ))
        bayes = apa.bayes_of_none(min(logs.bayes_factor for logs in differ))
        many = f"{len(differ)} of {len(tested)} pairs" if rows else f"all {len(tested)} pairs"
        every, factors = "all ", "all Bayes factors"
        if len(differ) > 1:
            p, bayes = p.replace("=", "≥"), bayes.replace("=", "≤")
        else:
            every, factors = "", "Bayes factor"
            many = many if rows else "the pair"
        blocks.append(
            html.paragraph(
                f"For {many} of {quantity.levels}, equivalence {within} was not shown (two "
                f"one-sided paired t tests of log estimates, {every}{p}; {factors} in favour of no "
                f"difference {bayes}; see pairwise.csv)."
            )
        )
    return blocks


def _row(pair: PairComparison) -> list[str]:
    logs, ranks = pair.logs, pair.ranks
    tested = (
        [DASH, DASH, DASH, DASH, p_cell(None), DASH, DASH]
        if not logs
        else [
            grouped(logs.ratio),
            interval(*logs.ratio_interval),
            grouped(logs.t),
            str(logs.df),
            p_cell(logs.p_holm),
            grouped(logs.d_z),
            interval(*(logs.d_z_interval or (None, None))),
        ]
    )
    return [
        f"{pair.from_level:g} → {pair.to_level:g}",
        *tested,
        f"{ranks.up} / {ranks.down}",
        f"{pair.n_logs} / {pair.n}",
        p_cell(ranks.p_holm),
    ]


def _parts(inference: Inference) -> dict[str, object]:
    """Return all tests of magnitude estimates, and their parts, keyed by title."""
    table: tuple[Statistic[object], ...] = (*STATISTICS, SESSIONS, GROUPS)
    titled = [statistic for statistic in table if statistic.title]
    parts: dict[str, object] = {each.title: inference[each] for each in titled}
    for statistic in titled:
        if (found := inference.found(statistic)) is not None:
            parts |= statistic.parts(found)
    return parts
