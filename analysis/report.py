"""The report: one self-contained page that a results section is written from."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version
from importlib.resources import files
from typing import TYPE_CHECKING

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from analysis import html, normalisation, published

if TYPE_CHECKING:
    import pandas as pd

    from analysis.pipeline import Analysis

try:
    VERSION = version("slipscale")
except PackageNotFoundError:  # a checkout that was never installed
    VERSION = "unknown"

MODES = {"pilot": "pilot", "participant": "participants", "unknown": "not recorded"}


def render(analysis: Analysis, fig15_svg: str) -> str:
    """Return the page."""
    environment = Environment(
        loader=PackageLoader("analysis"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    css = files("analysis").joinpath("templates", "report.css").read_text(encoding="utf-8")
    return environment.get_template("report.html").render(
        title=analysis.dataset.name,
        version=VERSION,
        css=Markup(css),  # noqa: S704 - our own file
        pilot=analysis.dataset.mode == "pilot",
        facts=facts(analysis),
        sections=[estimates_section(analysis, fig15_svg), data_section(analysis)],
        sha256=analysis.dataset.sha256,
    )


def facts(analysis: Analysis) -> list[tuple[str, str]]:
    """Return what stands at the top: name and value."""
    data = analysis.dataset
    details = data.details
    found = [
        ("Participants", str(len(analysis.cells))),
        ("Trials analysed", html.number(len(analysis.estimates), 0)),
        ("Amplitudes", ", ".join(f"{a:g}" for a in analysis.cells.columns) + " µm p-p"),
        ("Normalisation", analysis.rule),
        ("Records of", MODES.get(data.mode, data.mode)),
    ]
    found += [
        (title, ", ".join(details[key]))
        for key, title in (("study", "Study"), ("plate", "Plate"), ("language", "Language"))
        if key in details
    ]
    return found


def estimates_section(analysis: Analysis, fig15_svg: str) -> html.Section:
    """Return Fig. 15 and Table III."""
    choices = analysis.dataset.choices
    rule = normalisation.RULES[analysis.rule]
    section = html.Section("Magnitude estimates")
    section.blocks.append(
        html.figure(
            fig15_svg,
            f"Perceived slipperiness against vibration amplitude. Thick: means of "
            f"{len(analysis.cells)} participants with {100 * choices.confidence:g} % "
            "within-participant confidence intervals (Cousineau-Morey). Thin: each participant's "
            f"means. Normalisation: {analysis.rule} ({rule.formula}).",
        )
    )
    section.blocks.append(table3(analysis.table3, choices.standard_deviation))
    return section


def table3(table: pd.DataFrame, standard_deviation: str) -> Markup:
    """Return Table III, beside the paper's where the amplitudes are the paper's."""
    paper = {float(row.amplitude_um_pp): row for row in published.TABLE3}
    beside = any(amplitude in paper for amplitude in table["amplitude_um_pp"])
    columns = [
        html.Column(title="Amplitude", unit="µm, p-p"),
        html.Column(title="n"),
        html.Column(title="Mean"),
        html.Column(title="Max. dev."),
        html.Column(title="SD"),
    ]
    if beside:
        columns += [html.Column(title=t, paper=True) for t in ("Mean", "Max. dev.", "SD")]
    rows = []
    for amplitude, n, *values in table.itertuples(index=False):
        row = [f"{amplitude:g}", str(n), *(html.number(value) for value in values)]
        if beside:
            known = paper.get(amplitude)
            row += [getattr(known, name) if known else "–" for name in published.STATISTICS]
        rows.append(row)
    return html.table(
        columns,
        rows,
        "Normalised estimates over participants, each participant's mean being one value. "
        "Max. dev.: largest distance of a value from the mean. SD: "
        f"{standard_deviation} standard deviation "
        f"({'n − 1' if standard_deviation == 'sample' else 'n'} in the denominator)."
        + (f" The paper's: Table III, n = {published.PARTICIPANTS}." if beside else ""),
        over=[("", 2), ("this study", 3), ("the paper", 3)] if beside else (),
    )


def data_section(analysis: Analysis) -> html.Section:
    """Return what was read, what was left out, and why."""
    section = html.Section("Data")
    data = analysis.dataset
    counts = data.counts
    section.blocks.append(
        html.paragraph(
            f"{html.number(counts.get('estimation_rows', 0), 0)} rows of magnitude estimation "
            f"were read: {counts.get('practice', 0)} practice and {counts.get('voided', 0)} "
            f"voided trials are not analysed, {counts.get('unanswered', 0)} main trials have no "
            f"usable answer ({counts.get('timed_out', 0)} timed out), "
            f"{html.number(counts.get('analysed', 0), 0)} were analysed."
        )
    )
    if analysis.problems:
        section.blocks.append(html.heading("To be looked at"))
        section.blocks.append(html.bullets(analysis.problems, "problem"))
    return section
