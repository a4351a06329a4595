"""Write the report section on means of estimates."""

from __future__ import annotations

from collections.abc import Mapping

from markupsafe import Markup

from slipscale.analysis.published import biet2007
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import grouped, interval


def estimates(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section with geometric means and Table III."""
    section = ReportSection("Magnitude estimates")
    prepared, quantity = analysis.prepared, analysis.dataset.quantity
    level = 100 * analysis.dataset.choices.confidence
    if prepared is None:
        return section
    if prepared.geometric:
        section.blocks.append(_geometric(analysis))
    section.blocks.append(arithmetic_table(analysis))
    spread = prepared.logs.std(ddof=1).max()
    here = f" (here up to {spread:.2f})" if spread > 0 else ""
    if analysis.description["mean_low"].notna().any():
        text = (
            "Confidence intervals for arithmetic means are too narrow if estimates are skewed: 95 "
            "% intervals contain the true mean in only 90 to 93 % of studies if the standard "
            f"deviation of natural logarithms is 0.6{here}, and in 82 to 88 % if it is 1."
        )
        section.blocks.append(html.paragraph(text, "note"))
    section.blocks += html.figure_if_drawn(
        svgs,
        "growth_means",
        f"Geometric means of {quantity.judged} on a logarithmic axis. Error bars: {level:g} % "
        "within-participant confidence intervals (Cousineau–Morey method, on logarithms), with 3 "
        "or more participants. Thin lines: individual participants.",
        "Line chart of the geometric means in the table",
    )
    if len(analysis.textures):
        section.blocks.append(textures(analysis))
    return section


def _geometric(analysis: Analysis) -> Markup:
    quantity, level = analysis.dataset.quantity, 100 * analysis.dataset.choices.confidence
    return html.table(
        html.columns(
            (quantity.title, quantity.short_unit),
            "Geometric mean",
            ("n", "above 0"),
            ("Within-participant", f"{level:g} % interval"),
            ("t-based", f"{level:g} % interval"),
        ),
        [
            [
                f"{row['level']:g}",
                grouped(row["geometric_mean"]),
                str(row["geometric_n"]),
                interval(row["within_low"], row["within_high"]),
                interval(row["geometric_low"], row["geometric_high"]),
            ]
            for row in analysis.description.to_dict(orient="records")
        ],
        f"Geometric means. Within-participant intervals compare {quantity.levels}; t-based "
        "intervals include differences in scale between participants.",
    )


def textures(analysis: Analysis) -> Markup:
    """Return the table of texture estimates."""
    titles = ("Mean", "Max. dev.", "SD")
    return html.table(
        html.columns("Texture", "n", *titles, left=1),
        [
            [name, str(n), *(grouped(value) for value in values)]
            for name, n, *values in analysis.textures.itertuples(index=False)
        ],
        "Normalised estimates of textures, on the scale of the plain surfaces in the same run. "
        "Textures are not part of any other table, figure or test.",
    )


def arithmetic_table(analysis: Analysis) -> Markup:
    """Return Table III, with the published values if the paper covers all amplitudes."""
    quantity, convention = analysis.dataset.quantity, analysis.dataset.choices.standard_deviation
    paper = biet2007.BY_AMPLITUDE
    beside = analysis.beside_paper
    titles, level = ("Mean", "Max. dev.", "SD"), 100 * analysis.dataset.choices.confidence
    first, interval_of = (quantity.title, quantity.short_unit), ("t-based", f"{level:g} % interval")
    columns = html.columns(first, "n", *titles, interval_of, "Median")
    if beside:
        columns += [TableColumn(title=title, paper=True) for title in titles]
    rows = []
    described = analysis.description.set_index("level")
    for amplitude, n, *values in analysis.table3.itertuples(index=False):
        row = [f"{amplitude:g}", str(n), *(grouped(value) for value in values)]
        low, high, median = described.loc[amplitude, ["mean_low", "mean_high", "median"]]
        row += [interval(low, high), grouped(median)]
        if beside:
            row += [getattr(paper[amplitude], name) for name in biet2007.STATISTICS]
        rows.append(row)
    return html.table(
        columns,
        rows,
        "Arithmetic means of participants' mean normalised estimates. Max. dev.: largest distance "
        f"of any participant from the mean. SD: {convention} standard deviation "
        f"({'n − 1' if convention == 'sample' else 'n'} in the denominator). Intervals are limited "
        "to possible means; there is none for fewer than three participants or for equal values."
        + (f" The paper: Table III, n = {biet2007.PARTICIPANTS}." if beside else ""),
        over=[("", 2), ("this study", 5), ("the paper", 3)] if beside else (),
    )
