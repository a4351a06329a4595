"""Implement ``slipscale export``."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path

from slipscale.analysis.cli.analyse import add_data, analysed
from slipscale.analysis.cli.mapping_arguments import add_mapping
from slipscale.analysis.cli.progress_line import telling
from slipscale.experiments.lab.defaults import here, say
from slipscale.faults import DONE, harmless

#: Descriptions of the formats, keyed by format, in the order in which they are written.
FORMS = {
    "word": "report for a word processor (report.docx)",
    "pdf": "report on A4 pages (report.pdf)",
    "scripts": "R script that recomputes the numbers in the report",
    "methods": "methods section with references (methods.md, references.bib)",
    "french-excel": "tables with semicolons and decimal commas (excel-fr/)",
    "spss": "tables for SPSS, with the labels of variables (spss/)",
}
#: Default formats: all except tables for French Excel and SPSS.
DEFAULT = ("word", "pdf", "scripts", "methods")


def add_export(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale export``."""
    add_data(parser)
    parser.add_argument("--out", metavar="DIR", required=True, help="folder for all files")
    parser.add_argument(
        "--forms",
        metavar="FORM",
        nargs="+",
        choices=tuple(FORMS),
        default=DEFAULT,
        help="; ".join(f"{name}: {text}" for name, text in FORMS.items())
        + f" (default: {' '.join(DEFAULT)})",
    )
    add_mapping(parser)


def run_export(args: Namespace) -> int:
    """Analyse a data set, write every requested format, and list the written files."""
    from slipscale.analysis.export.files import check_installed, write_export

    say(here())
    check_installed(args.forms)
    with telling() as progress:
        analysis = analysed(args, progress)
        progress("writing tables, figures, the report and the requested formats")
        out = Path(args.out)
        names = write_export(analysis, out, [name for name in FORMS if name in args.forms])
    for sentence in analysis.problems:
        print(harmless(f"note: {sentence}"), file=sys.stderr)
    for name in ("report.html", *names):
        print(out / name)
    return DONE


COMMANDS = {"export": (add_export, run_export)}
