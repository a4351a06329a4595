"""The command ``slipscale study``: new, show, validate, schema."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from faults import DONE, harmless

if TYPE_CHECKING:
    from argparse import ArgumentParser, Namespace

NEW_STUDY = "biet2007"
WHICH = "a TOML file or a shipped study's name"


def add_study(parser: ArgumentParser) -> None:
    """Fill the parser of ``slipscale study``."""
    commands = parser.add_subparsers(
        dest="what", metavar="new | show | validate | schema", required=True
    )
    new = commands.add_parser("new", help="write a study file to begin with")
    new.add_argument("path", type=Path, metavar="FILE", help="a new TOML file")
    show = commands.add_parser("show", help="say what a study does, and a participant's orders")
    show.add_argument("study", metavar="STUDY", nargs="?", default="biet2007", help=WHICH)
    show.add_argument(
        "--participant", default="01", metavar="01", help="whose orders (default: 01)"
    )
    show.add_argument(
        "--session", default="", metavar="01", help="of which session (default: the study's first)"
    )
    show.add_argument("--run", default="01", metavar="01", help="of which run (default: 01)")
    validate = commands.add_parser(
        "validate", help="tell every fault of a study file, and how balanced its orders are"
    )
    validate.add_argument("study", metavar="STUDY", help=WHICH)
    commands.add_parser("schema", help="print the JSON Schema of study files, for editors")


def run_study(args: Namespace) -> int:
    """Write, show or validate a study file, or print the schema of all."""
    from experiments.running import study_commands  # noqa: PLC0415

    actions = {
        "new": lambda: study_commands.new(args.path, NEW_STUDY),
        "show": lambda: study_commands.show(args.study, args.participant, args.session, args.run),
        "validate": lambda: study_commands.validate(args.study),
        "schema": study_commands.schema,
    }
    print(harmless(actions[args.what]()))
    return DONE


COMMANDS = {"study": (add_study, run_study)}
