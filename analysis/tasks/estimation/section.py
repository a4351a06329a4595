"""Table III beside the paper's, and all descriptive statistics."""

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


def estimates(analysis: Analysis, _svgs: Mapping[str, str]) -> ReportSection:
    """Return Table III, large, and the full descriptives."""
    section = ReportSection("Magnitude estimates")
    if analysis.prepared is None:
        return section
    quantity, level = analysis.dataset.quantity, 100 * analysis.dataset.choices.confidence
    section.blocks.append(table3(analysis))
    section.blocks.append(
        html.table(
            [
                TableColumn(title=quantity.title, unit=quantity.short_unit),
                TableColumn(title="Mean"),
                TableColumn(title="Student's", unit=f"{level:g} % interval"),
                TableColumn(title="Geometric mean"),
                TableColumn(title="n", unit="above 0"),
                TableColumn(title="Student's", unit=f"{level:g} % interval"),
                TableColumn(title="Within-participant", unit=f"{level:g} % interval"),
                TableColumn(title="Median"),
                TableColumn(title="SD", unit="sample"),
                TableColumn(title="SD", unit="population"),
            ],
            [
                [
                    f"{row['amplitude_um_pp']:g}",
                    grouped(row["mean"]),
                    interval(row["mean_low"], row["mean_high"]),
                    grouped(row["geometric_mean"]),
                    str(row["geometric_n"]),
                    interval(row["geometric_low"], row["geometric_high"]),
                    interval(row["within_low"], row["within_high"]),
                    grouped(row["median"]),
                    grouped(row["sd_sample"]),
                    grouped(row["sd_population"]),
                ]
                for row in analysis.description.to_dict(orient="records")
            ],
            "All descriptive statistics. Intervals of geometric means are computed on logarithms "
            f"and taken back; within-participant ones compare {quantity.levels}. "
            "Geometric means leave estimates of zero to the zero rule. Student's intervals of "
            "arithmetic means of skewed estimates contain the true mean in 91 to 92 % of studies "
            "of 6 to 12 participants instead of 95 %; those of geometric means hold.",
        )
    )
    if len(analysis.textures):
        section.blocks.append(textures(analysis))
    return section


def textures(analysis: Analysis) -> Markup:
    """Return the same statistics for textures, which have no one amplitude."""
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
        "They are in no other table, figure or test.",
    )


def table3(analysis: Analysis) -> Markup:
    """Return Table III, beside the paper's where the amplitudes are the paper's."""
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
        "Normalised estimates over participants, each participant's mean being one value. "
        "Max. dev.: largest distance of a value from the mean. SD: "
        f"{convention} standard deviation "
        f"({'n − 1' if convention == 'sample' else 'n'} in the denominator)."
        + (f" The paper's: Table III, n = {biet2007.PARTICIPANTS}." if beside else ""),
        over=[("", 2), ("this study", 3), ("the paper", 3)] if beside else (),
    )
