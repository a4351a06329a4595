"""Write the section on groups of participants: their means, and every two of them compared."""

from __future__ import annotations

from math import exp
from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.groups.statistics import GROUPS
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import DASH, grouped, interval, level_of, p_value

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.groups.welch import Welch
    from slipscale.analysis.tasks.kind import Analysis

#: Fields of `GroupComparison` -> description of the numbers, for a quantity ``q``, and format of a
#: value.
COMPARED: dict[str, tuple[str, str, Callable[[float], float]]] = {
    "exponents": ("Exponent", "difference", float),
    "levels": ("Geometric mean over all {q.levels}", "ratio", exp),
}


def groups(analysis: Analysis, _svgs: Mapping[str, str]) -> ReportSection:
    """Return the groups' means and pairs; empty if the participants are in no groups."""
    section = ReportSection("Groups")
    found = analysis.inference[GROUPS]
    if not found:
        return section
    for name, (template, how, read) in COMPARED.items():
        title = template.format(q=analysis.dataset.quantity)
        part = getattr(found, name)
        if isinstance(part, NotComputed):
            section.blocks.append(html.paragraph(f"{title}: {part.reason}.", "note"))
        else:
            level = level_of(analysis.dataset.choices.confidence)
            section.blocks += [
                _means(part, title, level, read),
                _pairs(part, title, how, level, read),
            ]
    return section


def _means(found: Welch, title: str, level: str, read: Callable[[float], float]) -> Markup:
    return html.table(
        [
            TableColumn(title="Group", left=True),
            TableColumn(title="n"),
            TableColumn(title="Mean"),
            TableColumn(title=f"{level} CI"),
        ],
        [
            [
                group.group,
                str(group.n),
                grouped(read(group.mean)),
                interval(read(group.interval.low), read(group.interval.high)),
            ]
            for group in found.groups
        ],
        f"{title}, by group: t-based intervals across the group's participants.",
    )


def _pairs(
    found: Welch, title: str, how: str, level: str, read: Callable[[float], float]
) -> Markup:
    return html.table(
        [
            TableColumn(title="Groups", left=True),
            TableColumn(title=how.capitalize()),
            TableColumn(title=f"{level} CI"),
            TableColumn(title="t"),
            TableColumn(title="df"),
            TableColumn(title="p", unit="Holm"),
            TableColumn(title="g", unit="Hedges"),
            TableColumn(title=f"{level} CI", unit="of g"),
        ],
        [
            [
                f"{pair.first} – {pair.second}",
                grouped(read(pair.difference)),
                interval(read(pair.interval.low), read(pair.interval.high)),
                grouped(pair.t),
                grouped(pair.df, 1),
                p_value(pair.p_holm).removeprefix("p ").removeprefix("= "),
                grouped(pair.hedges_g),
                DASH if pair.hedges_g_interval is None else interval(*pair.hedges_g_interval),
            ]
            for pair in found.pairs
        ],
        f"{title}: every two groups by Welch's t test.",
    )
