"""Command ``slipscale data``: build or verify a data set, withdraw a participant, or merge."""

from __future__ import annotations

import shlex
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.experiments.lab.defaults import dataset_default, here, say
from slipscale.faults import ANSWER_IS_NO, DONE, UserError

if TYPE_CHECKING:
    from slipscale.experiments.dataset.journals import Problem


def add_data(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale data`` to the parser."""
    commands = parser.add_subparsers(
        dest="what", metavar="build | verify | withdraw | merge", required=True
    )
    build = commands.add_parser(
        "build",
        help="rewrite all tables from the journals",
        epilog="example: slipscale data build data",
    )
    verify = commands.add_parser(
        "verify",
        help="compare the tables with the journals, and check that the journals are complete",
        epilog="example: slipscale data verify data",
    )
    withdraw = commands.add_parser(
        "withdraw",
        help="remove a participant's data permanently; the number is never reused",
        epilog="example: slipscale data withdraw data --participant 01",
    )
    withdraw.add_argument(
        "--participant", required=True, metavar="01", help="label of the participant who withdraws"
    )
    withdraw.add_argument(
        "--yes",
        action="store_true",
        help="remove the data; without --yes, only print what would be removed",
    )
    merge = commands.add_parser(
        "merge",
        help="merge data sets from two computers into a new one, and report contradictions",
        epilog="example: slipscale data merge data other-data --out merged",
    )
    for name in ("one", "other"):
        merge.add_argument(name, type=Path, metavar="DATASET", help="a data set folder")
    merge.add_argument(
        "--out", type=Path, required=True, metavar="DIR", help="new folder for the merged data set"
    )
    optional = dataset_default()
    for command in (build, verify, withdraw):
        command.add_argument(
            "dataset", type=Path, metavar="DATASET", help="a data set folder", **optional
        )
    for command in (build, verify):
        command.add_argument("--json", action="store_true", help="print the problems as JSON")


def run_data(args: Namespace) -> int:
    """Run a subcommand on a data set, and return 1 if anything is damaged or differs."""
    from slipscale.experiments.dataset.bids import build_dataset
    from slipscale.experiments.dataset.journals import journals
    from slipscale.experiments.dataset.verification import verify

    if args.what == "merge":
        return _merge(args.one, args.other, args.out)
    say(here())
    if args.what == "withdraw":
        return _withdraw(args.dataset, args.participant, remove=args.yes)
    found = journals(args.dataset)
    if not found:
        raise UserError(
            "{dataset}: no journals; expected a data set folder, with "
            "sourcedata/sub-01/sub-01_run-01_journal.jsonl",
            dataset=args.dataset,
        )
    actions = {"build": build_dataset, "verify": verify}
    return _tell(args, actions[args.what](args.dataset), len(found))


def _merge(one: Path, other: Path, out: Path) -> int:
    from slipscale.experiments.dataset.merging import merge

    merged = merge(one, other, out)
    for sentence in merged.notes:
        print(f"note: {sentence}", file=sys.stderr)
    for problem in merged.problems:
        print(problem, file=sys.stderr)
    print(f"{out}: {merged.runs} runs from {one} and {other}, which are unchanged")
    return ANSWER_IS_NO if merged.problems else DONE


def _withdraw(dataset: Path, participant: str, *, remove: bool) -> int:
    from slipscale.experiments.dataset.remains import LABEL
    from slipscale.experiments.dataset.withdrawal import (
        sources_with,
        theirs,
        withdraw,
    )
    from slipscale.experiments.dataset.withdrawn import replacement

    if remove:
        shown, left = withdraw(dataset, participant)
    else:
        shown, left = theirs(dataset, participant), []
    for path in shown:
        shared = path.suffix == ".tsv" and participant not in LABEL.findall(path.name)
        rows = "rows " if shared else ""
        print(f"{rows}{'removed' if remove else 'would be removed'}: {path}")
    if not remove:
        print("Nothing has been removed yet. To remove the data, add --yes.", file=sys.stderr)
        return ANSWER_IS_NO
    for source in sources_with(dataset, participant):
        print(
            f"{dataset} was merged from {source}, which may still contain participant "
            f"{participant}. To check and remove the data: slipscale data withdraw {source} "
            f"--participant {participant} "
            "--yes",
            file=sys.stderr,
        )
    print(
        "The results of all participants were removed as well; slipscale analyse computes "
        "them again. Remove any copies of the data that you made elsewhere. To test a replacement "
        f"for participant {participant}: --participant {replacement(participant)}"
    )
    for path in left:
        print(
            f"{path} may still hold data from participant {participant}: look at it, and remove "
            "what is theirs",
            file=sys.stderr,
        )
    return ANSWER_IS_NO if left else DONE


def _tell(args: Namespace, problems: Sequence[Problem], journals: int) -> int:
    if args.json:
        import json
        from dataclasses import asdict

        from slipscale.faults.message import output

        found = [
            asdict(each) | {"place": output(each.place), "what": output(each.what)}
            for each in problems
        ]
        print(json.dumps(found, indent=2, ensure_ascii=False))
    for problem in problems if not args.json else ():
        print(problem, file=sys.stderr)
    if problems:
        if not args.json:
            many = "1 problem" if len(problems) == 1 else f"{len(problems)} problems"
            build = f"slipscale data build {shlex.quote(str(args.dataset))}"
            rebuild = f"; to write the tables again from the journals: {build}"
            print(f"{many} in {args.dataset}{rebuild * (args.what == 'verify')}", file=sys.stderr)
        return ANSWER_IS_NO
    if not args.json:
        done = {"build": "built from", "verify": "agrees with"}[args.what]
        print(f"{args.dataset}: {done} its journals ({journals})")
    return DONE


COMMANDS = {"data": (add_data, run_data)}
