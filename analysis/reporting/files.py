"""Write all output files of `slipscale analyse`: tables, figures, JSON and the report.

The same data and software versions give identical files, because the files contain no dates, paths
or random order.
"""

from __future__ import annotations

import platform
from collections.abc import Callable, Collection, Mapping
from importlib.metadata import version
from pathlib import Path

from matplotlib.figure import Figure

from slipscale import figure_style
from slipscale.analysis import json_form
from slipscale.analysis.published import biet2007
from slipscale.analysis.reporting import page
from slipscale.analysis.reporting.latex import latex_tables
from slipscale.analysis.reporting.multiplicity import multiplicity
from slipscale.analysis.reporting.tables import quality_table, tables
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.axes import with_tips
from slipscale.analysis.writing.csv_file import write_csv
from slipscale.analysis.writing.output_folder import make_folder
from slipscale.faults import UserError
from slipscale.figure_style.paper import PaperStyle, drawn_for

#: Figure that is also written as PNG in every analysis, for slides and messages.
MAIN_PICTURE = "fig15.png"
#: Folder of the figures for a paper.
FOR_PAPER = "figures"
XML = '<?xml version="1.0" encoding="utf-8"?>\n'
SOFTWARE = ("slipscale", "numpy", "scipy", "pandas", "statsmodels", "pingouin", "matplotlib")


def write_analysis(
    analysis: Analysis,
    out: Path,
    progress: Callable[[str], None] | None = None,
    *,
    formats: Collection[str] = (),
    paper: PaperStyle | None = None,
) -> Path:
    """Write tables, figures and the report into a folder, and return the path of the report.

    Parameters
    ----------
    progress : callable, optional
        Function called with a short description of the next step.
    formats : collection of str
        Figure formats in addition to SVG: ``"png"``, ``"pdf"``.
    paper : PaperStyle, optional
        Style of further figures for a paper, which are written to the folder `FOR_PAPER` in all
        formats.

    Raises
    ------
    UserError
        If a file cannot be written.
    """
    tell = progress or (lambda _: None)
    make_folder(out)
    tell("writing tables")
    try:
        found = tables(analysis)
        for name, table in found.items():
            write_csv(table, out / f"{name}.csv")
        for name, text in latex_tables(analysis).items():
            _write(out / f"{name}.tex", text)
        versions = software(analysis)
        for name, value in {
            "inference": analysis.inference.results,
            "results": results(analysis, versions)
            | {"tables": [f"{name}.csv" for name in sorted(found)]},
            "dataset_description": derivative_description(analysis),
        }.items():
            _write(out / f"{name}.json", json_form.text(value, analysis.dataset.quantity.named))
        if analysis.friction is not None:
            _write(out / "friction.json", json_form.text(analysis.friction))
        tell("drawing figures")
        drawn = draw(analysis)
        svgs = _write_figures(drawn, out, formats)
        if paper is not None:
            tell("drawing figures for the paper")
            make_folder(out / FOR_PAPER)
            with drawn_for(paper):
                _write_figures(draw(analysis), out / FOR_PAPER, ("png", "pdf"))
        tell("writing the report")
        report = out / "report.html"
        _write(report, page.render(analysis, svgs, versions))
    except OSError as error:
        raise UserError(
            "{filename}: cannot be written ({reason})",
            filename=error.filename or out,
            reason=error.strerror or error,
        ) from error
    return report


def _write_figures(
    drawn: Mapping[str, Figure], out: Path, formats: Collection[str]
) -> dict[str, str]:
    """Write figures, and return them as SVG elements keyed by name."""
    svgs = {name: with_tips(figure_style.svg(figure, salt=name)) for name, figure in drawn.items()}
    for name, figure in drawn.items():
        _write(out / f"{name}.svg", f"{XML}{svgs[name]}\n")
        for each in ("png", "pdf"):
            path = out / f"{name}.{each}"
            if each in formats or path.name == MAIN_PICTURE:
                figure_style.save(figure, path)
            else:  # possibly left by an analysis of other data
                path.unlink(missing_ok=True)
    return svgs


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")


def software(analysis: Analysis) -> dict[str, str]:
    """Return the versions of all software used, including packages that add analyses."""
    outside = {kind.package: kind.version for kind in analysis.kinds if kind.package}
    ours = {name: version(name) for name in SOFTWARE}
    return {"python": platform.python_version()} | ours | outside


def results(analysis: Analysis, software: Mapping[str, str]) -> dict[str, object]:
    """Return the content of results.json: all results in machine-readable form.

    Parameters
    ----------
    software : Mapping
        Version of each software package used, keyed by name.
    """
    data = analysis.dataset
    named = data.quantity.columns
    return {
        "dataset": data.name,
        "mode": data.mode,
        "sha256": data.sha256,
        "files": {source.name: source.sha256 for source in data.sources},
        "details": data.details,
        "software": software,
        "choices": data.choices.model_dump(),
        "frozen_in_the_study_file": data.frozen,
        "study_file_unchanged": data.unchanged,
        "counts": data.counts,
        "problems": analysis.problems,
        "excluded": analysis.excluded,
        "table3": named(analysis.table3).to_dict(orient="records"),
        "textures": named(analysis.textures).to_dict(orient="records"),
        "descriptives": named(analysis.description).to_dict(orient="records"),
        "inference": analysis.inference.results,
        "multiplicity": multiplicity(
            analysis.inference, data.choices.primary, data.choices.confidence, data.quantity
        ),
        "individuals": named(analysis.individuals).to_dict(orient="records"),
        "sensitivity": analysis.sensitivity,
        "robustness": analysis.robustness,
        "quality": quality_table(analysis).to_dict(orient="records"),
        "paper": [
            {name: getattr(row, name) for name in ("amplitude_um_pp", *biet2007.STATISTICS)}
            for row in biet2007.TABLE3
            if data.quantity.of_plate
        ],
        **({} if analysis.plan is None else {"plan": analysis.plan}),
    }


def derivative_description(analysis: Analysis) -> dict[str, object]:
    """Return the BIDS description of the output folder."""
    return {
        "Name": f"Slipscale's analysis of {analysis.dataset.name}",
        "BIDSVersion": "1.10.0",
        "DatasetType": "derivative",
        "GeneratedBy": [{"Name": "Slipscale", "Version": html.VERSION}],
    }


def draw(analysis: Analysis) -> dict[str, Figure]:
    """Return the figures available for the data, keyed by file name."""
    found: dict[str, Figure] = {}
    for kind in analysis.kinds:
        found |= kind.figures(analysis)
    return found
