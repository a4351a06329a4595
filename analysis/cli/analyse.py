"""The command ``slipscale analyse``; pandas, SciPy and matplotlib load when it runs."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from analysis.cli.progress_line import telling
from faults import DONE

if TYPE_CHECKING:
    from argparse import ArgumentParser, Namespace


def add_analyse(parser: ArgumentParser) -> None:
    """Fill the parser of ``slipscale analyse``."""
    from typing import get_args  # noqa: PLC0415

    from experiments.study.analysis_choices import Normalisation  # noqa: PLC0415

    rules = get_args(Normalisation)
    parser.add_argument("dataset", metavar="DATASET", help="a data set's folder, or a tidy CSV/TSV")
    parser.add_argument(
        "--out", metavar="DIR", help="for the results (default: DATASET/derivatives/slipscale)"
    )
    parser.add_argument(
        "--normalise",
        metavar="RULE",
        choices=rules,
        help=f"how estimates come to one scale: {', '.join(rules)}",
    )
    parser.add_argument("--json", action="store_true", help="print Table III as JSON")


def run_analyse(args: Namespace) -> int:
    """Analyse a data set; print Table III and where everything lies."""
    from analysis.pipeline import analyse  # noqa: PLC0415
    from analysis.reading.load import load  # noqa: PLC0415
    from analysis.reporting.output_folder import default_folder  # noqa: PLC0415
    from analysis.reporting.terminal import print_table3  # noqa: PLC0415

    with telling() as progress:
        progress("reading the data")
        data = load(args.dataset)
        out = Path(args.out) if args.out else default_folder(data, args.dataset)
        analysis = analyse(data, normalise=args.normalise, progress=progress)
        progress("writing tables, figures and the report")
        # Matplotlib takes a second to load: not before something is to be drawn.
        from analysis.reporting.files import write_analysis  # noqa: PLC0415

        report = write_analysis(analysis, out)
    for sentence in analysis.problems:
        print(f"note: {sentence}", file=sys.stderr)
    if args.json:
        print(analysis.table3.to_json(orient="records", indent=2, double_precision=15))
    else:
        print_table3(analysis)
        print(f"report: {report}")
    return DONE


COMMANDS = {"analyse": (add_analyse, run_analyse)}
