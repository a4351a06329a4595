"""Write the files of `slipscale export`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.resources import files
from pathlib import Path

import pandas as pd

from slipscale.analysis.export.french_excel import write_french
from slipscale.analysis.export.reported_numbers import reported_numbers, settings, task_trials
from slipscale.analysis.export.spss import write_sav
from slipscale.analysis.export.word import write_word
from slipscale.analysis.reporting import methods_text
from slipscale.analysis.reporting.files import software, write_analysis
from slipscale.analysis.reporting.tables import tables
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing.csv_file import write_csv
from slipscale.faults import UserError

#: Main script, and script for other tasks, factors and sessions.
SCRIPT, TASK_SCRIPT = "recompute.R", "recompute_tasks.R"


def write_export(analysis: Analysis, out: Path, forms: Sequence[str]) -> list[str]:
    """Write the output of `analyse` together with export files, and return the export files' names.

    Parameters
    ----------
    out : Path
        Output folder, created if necessary.
    forms : sequence of str
        Keys of `FORMS`.

    Raises
    ------
    UserError
        If a file cannot be written, or WeasyPrint cannot load the library Pango.
    ModuleNotFoundError
        If the extra ``export`` is not installed. In this case, nothing is written.
    """
    check_installed(forms)
    report = write_analysis(analysis, out, formats=("png", "pdf"))
    try:
        return [name for form in forms for name in FORMS[form](analysis, report)]
    except OSError as error:
        raise UserError(
            "{filename}: cannot be written ({reason})",
            filename=error.filename or out,
            reason=error.strerror or error,
        ) from error


def check_installed(forms: Sequence[str]) -> None:
    """Check that the packages for the requested formats can be imported.

    Raises
    ------
    ModuleNotFoundError
        If the extra ``export`` is not installed.
    UserError
        If WeasyPrint cannot load the library Pango.
    """
    if "word" in forms:
        import docx  # noqa: F401
    if "pdf" in forms:
        try:
            import weasyprint  # noqa: F401
        except OSError as error:
            raise UserError(
                "--forms pdf: WeasyPrint cannot load Pango, its text layout library ({error}); "
                "install Pango (Debian: libpango-1.0-0 libpangoft2-1.0-0), or print report.html"
                " from a browser",
                error=error,
            ) from None


def _word(_analysis: Analysis, report: Path) -> list[str]:
    write_word(report, report.with_suffix(".docx"))
    return ["report.docx"]


def _pdf(_analysis: Analysis, report: Path) -> list[str]:
    from weasyprint import HTML

    HTML(filename=report).write_pdf(report.with_suffix(".pdf"))
    return ["report.pdf"]


def _scripts(analysis: Analysis, report: Path) -> list[str]:
    numbers = reported_numbers(analysis)
    write_csv(numbers, report.with_name("numbers.csv"))
    write_csv(settings(analysis), report.with_name("settings.csv"))
    trials = task_trials(analysis)
    for name, rows in trials.items():
        write_csv(rows, report.with_name(f"{name}.csv"))
    crossed = numbers["name"].str.match(r"(factors|sessions)\.").any()
    scripts = [SCRIPT, *([TASK_SCRIPT] if trials or crossed else [])]
    for name in scripts:
        text = (
            files("slipscale.analysis.export").joinpath("scripts", name).read_text(encoding="utf-8")
        )
        report.with_name(name).write_text(text, encoding="utf-8", newline="\n")
    return [*scripts, "numbers.csv", "settings.csv", *(f"{name}.csv" for name in trials)]


def _methods(analysis: Analysis, report: Path) -> list[str]:
    texts = methods_text.sentences(analysis, software(analysis))
    papers = methods_text.references(texts)
    paragraphs = [methods_text.cited(text) for text in texts]
    lines = ["# Methods", *paragraphs, "# References", *(each.listed for each in papers.values())]
    for name, text in {
        "methods.md": "\n\n".join(lines) + "\n",
        "references.bib": "\n".join(each.bibtex(key) for key, each in papers.items()),
    }.items():
        report.with_name(name).write_text(text, encoding="utf-8", newline="\n")
    return ["methods.md", "references.bib"]


def _tables_as(
    write: Callable[[pd.DataFrame, Path], None], ending: str, folder_name: str
) -> Callable[[Analysis, Path], list[str]]:
    """Return the function that writes every table into a folder next to the report."""

    def written(analysis: Analysis, report: Path) -> list[str]:
        folder = report.with_name(folder_name)
        folder.mkdir(exist_ok=True)
        for name, table in tables(analysis).items():
            write(table, folder / f"{name}{ending}")
        return [f"{folder.name}/"]

    return written


#: Format -> function that writes the file next to the report.
FORMS: dict[str, Callable[[Analysis, Path], list[str]]] = {
    "word": _word,
    "pdf": _pdf,
    "scripts": _scripts,
    "methods": _methods,
    "french-excel": _tables_as(write_french, ".csv", "excel-fr"),
    "spss": _tables_as(write_sav, ".sav", "spss"),
}
