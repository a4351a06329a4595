"""Implement ``slipscale reproduce``."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace
from pathlib import Path

from slipscale.analysis.cli.progress_line import telling
from slipscale.faults import ANSWER_IS_NO, DONE


def add_reproduce(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale reproduce``."""
    parser.add_argument(
        "items",
        metavar="ITEM",
        nargs="*",
        help=(
            "name of an item, or beginning of several names, such as table3 or fig9.fe (default: "
            "all items)"
        ),
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        default="results",
        help=("folder for figures (default: results)"),
    )
    parser.add_argument("--json", action="store_true", help="print the items as JSON")


def run_reproduce(args: Namespace) -> int:
    """Compare results with the paper; return 1 if results changed or Table III disagrees."""
    from slipscale.analysis.reproduction.comparison import choose, compare, write_figures
    from slipscale.analysis.reproduction.terminal import print_comparisons
    from slipscale.analysis.writing.output_folder import make_folder

    choose(args.items)
    make_folder(Path(args.out))
    with telling() as progress:
        comparisons = compare(args.items, progress)
        paths = write_figures(Path(args.out), args.items, progress)
    if args.json:
        print(json.dumps([comparison.record() for comparison in comparisons], indent=2))
    else:
        print_comparisons(comparisons)
        if paths:
            print(f"figures: {', '.join(str(path) for path in paths if path.suffix == '.png')}")
    return ANSWER_IS_NO if any(comparison.failed for comparison in comparisons) else DONE


COMMANDS = {"reproduce": (add_reproduce, run_reproduce)}
