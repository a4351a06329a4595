"""The commands ``analyse``, ``reproduce`` and their kin: a few lines each.

Only light imports at the top: pandas, SciPy and matplotlib load when a command runs.
"""

from __future__ import annotations

import json
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from argparse import ArgumentParser, Namespace
    from collections.abc import Callable, Iterator

DONE, ANSWER_IS_NO = 0, 1


@contextmanager
def telling() -> Iterator[Callable[[str], None]]:
    """Show what goes on as one line on stderr, where that is a terminal."""
    from rich.console import Console  # noqa: PLC0415

    console = Console(stderr=True)
    with console.status("") as status:
        yield lambda words: status.update(f"{words} ...")


def add_analyse(parser: ArgumentParser) -> None:
    """Fill the parser of ``slipscale analyse``."""
    from typing import get_args  # noqa: PLC0415

    from experiments.analysis_choices import Normalisation  # noqa: PLC0415

    rules = get_args(Normalisation)
    parser.add_argument("dataset", metavar="DATASET", help="a data set's folder, or a tidy CSV/TSV")
    parser.add_argument("--out", metavar="DIR", help="default: DATASET/derivatives/slipscale")
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
    from analysis.terminal import print_table3  # noqa: PLC0415

    with telling() as progress:
        analysis = analyse(args.dataset, args.out, normalise=args.normalise, progress=progress)
    for sentence in analysis.problems:
        print(f"note: {sentence}", file=sys.stderr)
    if args.json:
        print(analysis.table3.to_json(orient="records", indent=2, double_precision=15))
    else:
        print_table3(analysis)
        print(f"report: {analysis.report}")
    return DONE


def add_reproduce(parser: ArgumentParser) -> None:
    """Fill the parser of ``slipscale reproduce``."""
    parser.add_argument(
        "items",
        metavar="ITEM",
        nargs="*",
        help="an item, or the beginning of several: table3, fig9.fe, ...; default: all",
    )
    parser.add_argument(
        "--out", metavar="DIR", default="results", help="for the figures; default: results"
    )
    parser.add_argument("--json", action="store_true", help="print the items as JSON")


def run_reproduce(args: Namespace) -> int:
    """Compare ours with the paper; 1 on drift, or where a cell of Table III disagrees."""
    from analysis.reproduce import compare, write_figures  # noqa: PLC0415
    from analysis.terminal import print_comparisons  # noqa: PLC0415

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


COMMANDS: dict[str, tuple[Callable[[ArgumentParser], None], Callable[[Namespace], int]]] = {
    "analyse": (add_analyse, run_analyse),
    "reproduce": (add_reproduce, run_reproduce),
}
