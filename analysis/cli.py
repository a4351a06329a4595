"""The commands ``analyse``, ``reproduce`` and their kin: a few lines each.

Only light imports at the top: pandas, SciPy and matplotlib load when a command runs.
"""

from __future__ import annotations

import json
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from argparse import ArgumentParser, Namespace
    from collections.abc import Callable, Iterator

DONE, ANSWER_IS_NO = 0, 1
#: Participants of the smallest study whose power is asked for.
FEWEST = 3


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
    from analysis.folders import make_folder  # noqa: PLC0415
    from analysis.reproduce import choose, compare, write_figures  # noqa: PLC0415
    from analysis.terminal import print_comparisons  # noqa: PLC0415

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


def add_power(parser: ArgumentParser) -> None:
    """Fill the parser of ``slipscale power``."""
    parser.add_argument(
        "study",
        metavar="STUDY",
        nargs="?",
        default="biet2007",
        help="a TOML file or a shipped study's name, for its amplitudes and repetitions",
    )
    parser.add_argument(
        "--sizes",
        metavar="N",
        type=int,
        nargs="+",
        default=[6, 8, 10, 12, 16, 20, 24, 32],
        help="numbers of participants to try (default: 6 to 32)",
    )
    parser.add_argument("--repetitions", type=int, metavar="N", help="default: the study's")
    parser.add_argument("--studies", type=int, default=1000, metavar="N", help="default: 1000")
    parser.add_argument("--seed", type=int, default=2007, metavar="N", help="default: 2007")
    parser.add_argument("--alpha", type=float, default=0.05, help="level of tests, default: 0.05")
    parser.add_argument("--target", type=float, default=0.8, help="power asked for, default: 0.8")
    parser.add_argument(
        "--trial-to-trial",
        type=float,
        metavar="SHARE",
        help="share of the variance that repetitions average out (default: the population's)",
    )
    parser.add_argument("--json", action="store_true", help="print the table as JSON")


#: Option of ``power``: whether its values can be meant, and what was expected.
EXPECTED: dict[str, tuple[Callable[[Any], bool], str]] = {
    "sizes": (lambda sizes: min(sizes) >= FEWEST, f"{FEWEST} participants or more"),
    "repetitions": (lambda n: n is None or n >= 1, "1 or more"),
    "studies": (lambda n: n >= 1, "1 or more"),
    "seed": (lambda n: n >= 0, "0 or more"),
    "alpha": (lambda share: 0 < share < 1, "a share above 0 and below 1"),
    "target": (lambda share: 0 < share < 1, "a share above 0 and below 1"),
}


def refuse_nonsense(args: Namespace) -> None:
    """Refuse every value of ``power`` that cannot be meant, all in one sentence."""
    from faults import UserError  # noqa: PLC0415

    wrong = []
    for name, (meant, expected) in EXPECTED.items():
        value = getattr(args, name)
        if not meant(value):
            shown = " ".join(str(one) for one in value) if isinstance(value, list) else value
            wrong.append(f"--{name} {shown}: expected {expected}")
    if wrong:
        raise UserError("; ".join(wrong))


def run_power(args: Namespace) -> int:
    """Simulate studies of several sizes; 1 where none reaches the power asked for."""
    from analysis.power import fewest, power_curve  # noqa: PLC0415
    from analysis.terminal import print_power  # noqa: PLC0415
    from experiments.participants.population import Population  # noqa: PLC0415
    from experiments.study import read_study  # noqa: PLC0415
    from faults import UserError  # noqa: PLC0415

    refuse_nonsense(args)
    study, _ = read_study(args.study)
    estimation = [task for task in study.tasks if task.protocol == "magnitude_estimation"]
    if not estimation:
        raise UserError(f"{study.name}: no magnitude_estimation among its tasks; nothing to plan")
    repetitions = args.repetitions or int(getattr(estimation[0], "repetitions", 1))
    try:
        population = (
            Population()
            if args.trial_to_trial is None
            else Population(trial_to_trial=args.trial_to_trial)
        )
    except ValueError as error:
        raise UserError(
            f"--trial-to-trial {args.trial_to_trial}: expected a share from 0 to "
            f"{1 - Population().shared:g}, what the part shared by all amplitudes leaves"
        ) from error
    with telling() as progress:
        curve = power_curve(
            study.amplitudes_um_pp,
            sorted(set(args.sizes)),
            repetitions=repetitions,
            studies=args.studies,
            seed=args.seed,
            alpha=args.alpha,
            population=population,
            progress=progress,
        )
    enough = fewest(curve, args.target)
    if args.json:
        rows = [
            {
                "participants": point.participants,
                "omnibus": point.omnibus,
                "steps": [
                    {"from_um_pp": low, "to_um_pp": high, "power": share}
                    for (low, high), share in point.steps.items()
                ],
                "exponent_half_width": point.exponent_half_width,
            }
            for point in curve
        ]
        print(json.dumps({"enough": enough, "target": args.target, "sizes": rows}, indent=2))
    else:
        print_power(curve, args.target, enough, repetitions)
    return ANSWER_IS_NO if enough is None else DONE


COMMANDS: dict[str, tuple[Callable[[ArgumentParser], None], Callable[[Namespace], int]]] = {
    "analyse": (add_analyse, run_analyse),
    "reproduce": (add_reproduce, run_reproduce),
    "power": (add_power, run_power),
}
