"""Outside analyses: a section each, which says whose they are."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import DASH, significant

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd
    from markupsafe import Markup

    from slipscale.analysis.own.declaration import OwnFinding, OwnResult
    from slipscale.analysis.result import Analysis

#: Rows of a table in the report; the file beside it holds them all.
ROWS_SHOWN = 40


def own_sections(analysis: Analysis, svgs: Mapping[str, str]) -> list[ReportSection]:
    """Return a section for each outside analysis, in the order of their names."""
    return [_section(each, svgs) for each in analysis.own]


def _section(own: OwnFinding, svgs: Mapping[str, str]) -> ReportSection:
    section = ReportSection(own.title, shown="open")
    if isinstance(own.found, NotComputed):
        section.blocks.append(html.paragraph(f"Not computed: {own.found.reason}."))
    else:
        section.blocks += _result(own.name, own.found, svgs)
    section.blocks.append(
        html.paragraph(
            f"This section is not Slipscale's: it is the analysis '{own.name}' of the package "
            f"{own.package} {own.version}, installed on the computer that made this report."
        )
    )
    return section


def _result(name: str, found: OwnResult, svgs: Mapping[str, str]) -> list[Markup]:
    blocks = [html.paragraph(sentence, "sentence") for sentence in found.sentences]
    if (svg := svgs.get(f"own_{name}")) is not None:
        blocks.append(html.figure(svg, found.figure_caption, found.figure_alt))
    if found.table is not None:
        blocks.append(_table(name, found.table, found.table_caption))
    return blocks


def _table(name: str, table: pd.DataFrame, caption: str) -> Markup:
    shown = table.head(ROWS_SHOWN)
    more = len(table) - len(shown)
    left = f" The first {len(shown)} of {len(table)} rows; all are in own_{name}.csv."
    numeric = [kind.kind in "iuf" for kind in table.dtypes]
    return html.table(
        [
            TableColumn(title=str(title), left=not is_number)
            for title, is_number in zip(table.columns, numeric, strict=True)
        ],
        [[_cell(cell) for cell in row] for row in shown.itertuples(index=False)],
        f"{caption}{left if more else ''}".strip(),
    )


def _cell(value: object) -> str:
    if value is None or value != value:  # noqa: PLR0124 - NaN alone is not itself
        return DASH
    return significant(value) if isinstance(value, float) else str(value)
