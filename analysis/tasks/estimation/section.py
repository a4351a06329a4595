"""Write the section on geometric means, Table III next to the paper's, and all descriptives."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.published import biet2007
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import DASH, grouped, interval

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from slipscale.analysis.tasks.kind import Analysis


def estimates(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return geometric means, then Table III by the paper's convention, then other statistics."""
    section = ReportSection("Magnitude estimates")
    prepared = analysis.prepared
    if prepared is None:
        return section
    quantity, level = analysis.dataset.quantity, 100 * analysis.dataset.choices.confidence
    if prepared.geometric:
        section.blocks.append(
            _described(
                analysis,
                {
                    "Geometric mean": ("", "geometric_mean"),
                    "n": ("above 0", "geometric_n"),
                    "Within-participant": (f"{level:g} % interval", "within_low", "within_high"),
                    "Student's": (f"{level:g} % interval", "geometric_low", "geometric_high"),
                },
                f"Geometric means. Within-participant intervals compare {quantity.levels}; "
                "Student's intervals include differences in scale between participants. The zero "
                "rule applies to estimates of zero.",
            )
        )
    section.blocks.append(table3(analysis))
    section.blocks += html.figure_if_drawn(
        svgs,
        "table3",
        f"The paper's Fig. 15: arithmetic means of {quantity.judged}, here and in the paper.",
        "Line chart of the arithmetic means in the table, here and in the paper",
    )
    spread = prepared.logs.std(ddof=1).max()
    here = f" (here up to {spread:.2f})" if spread > 0 else ""
    section.blocks.append(
        _described(
            analysis,
            {
                "Mean": ("arithmetic", "mean"),
                "Student's": (f"{level:g} % interval", "mean_low", "mean_high"),
                "Median": ("", "median"),
                "SD": ("sample", "sd_sample"),
                "SD ": ("population", "sd_population"),
            },
            "Arithmetic means. Their Student's intervals are too short for skewed estimates: at "
            ".95 they contain the true mean of log-normal estimates in .90 to .93 of studies of 6 "
            "to 30 participants if the standard deviation of the participants' natural logarithms "
            f"is 0.6{here}, in .86 to .91 if it is 0.8, in .82 to .88 if it is 1. Intervals of "
            f"geometric means keep their level.",
        )
    )
    if len(analysis.textures):
        section.blocks.append(textures(analysis))
    return section


def _described(analysis: Analysis, columns: Mapping[str, tuple[str, ...]], caption: str) -> Markup:
    """Return a table of descriptive statistics.

    ``columns`` maps a title to its unit, and to one column or the two ends of an interval.
    """
    quantity = analysis.dataset.quantity
    titles = [TableColumn(title=quantity.title, unit=quantity.short_unit)]
    titles += [TableColumn(title=title.strip(), unit=unit) for title, (unit, *_) in columns.items()]
    rows = [
        [
            f"{row['amplitude_um_pp']:g}",
            *(_cell(*(row[name] for name in names)) for _, *names in columns.values()),
        ]
        for row in analysis.description.to_dict(orient="records")
    ]
    return html.table(titles, rows, caption)


def _cell(*values: float) -> str:
    if len(values) == 2:  # noqa: PLR2004 - the ends of an interval
        return interval(values[0], values[1])
    return str(values[0]) if isinstance(values[0], int) else grouped(values[0])


def textures(analysis: Analysis) -> Markup:
    """Return the same statistics for textures, which have no single amplitude."""
    titles = ("Mean", "Max. dev.", "SD")
    return html.table(
        [
            TableColumn(title="Texture", left=True),
            TableColumn(title="n"),
            *(TableColumn(title=title) for title in titles),
        ],
        [
            [name, str(n), *(grouped(value) for value in values)]
            for name, n, *values in analysis.textures.itertuples(index=False)
        ],
        "Normalised estimates of textures, on the scale of the plain surfaces of the same run. "
        "They are not part of any other table, figure or test.",
    )


def table3(analysis: Analysis) -> Markup:
    """Return Table III, next to the paper's if the amplitudes are the paper's."""
    quantity, convention = analysis.dataset.quantity, analysis.dataset.choices.standard_deviation
    paper = biet2007.BY_AMPLITUDE
    beside = quantity.of_plate and any(
        amplitude in paper for amplitude in analysis.table3["amplitude_um_pp"]
    )
    titles = ("Mean", "Max. dev.", "SD")
    columns = [TableColumn(title=quantity.title, unit=quantity.short_unit), TableColumn(title="n")]
    columns += [TableColumn(title=title) for title in titles]
    if beside:
        columns += [TableColumn(title=title, paper=True) for title in titles]
    rows = []
    for amplitude, n, *values in analysis.table3.itertuples(index=False):
        row = [f"{amplitude:g}", str(n), *(grouped(value) for value in values)]
        if beside:
            known = paper.get(amplitude)
            row += [getattr(known, name) if known else DASH for name in biet2007.STATISTICS]
        rows.append(row)
    return html.table(
        columns,
        rows,
        f"{'The convention of Table III: a' if quantity.of_plate else 'A'}rithmetic means of "
        "normalised estimates across participants (one value per participant: their mean). "
        "Max. dev.: largest distance of a value from the mean. SD: "
        f"{convention} standard deviation "
        f"({'n − 1' if convention == 'sample' else 'n'} in the denominator)."
        + (f" The paper's: Table III, n = {biet2007.PARTICIPANTS}." if beside else ""),
        over=[("", 2), ("this study", 3), ("the paper", 3)] if beside else (),
    )
