"""Subcommands of ``slipscale study``: new, show, validate, texts and schema."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace, _SubParsersAction
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from slipscale.experiments.lab.defaults import here, say
from slipscale.faults import DONE, UserError, harmless

if TYPE_CHECKING:
    Commands: TypeAlias = _SubParsersAction[ArgumentParser]

    from matplotlib.figure import Figure

NEW_STUDY = "biet2007"  # template of a new file
WHICH = "a TOML file, or the name of a study that comes with Slipscale"


def add_study(parser: ArgumentParser) -> Commands:
    """Add the arguments of ``slipscale study``, and return the subparsers for more subcommands."""
    commands = parser.add_subparsers(
        dest="what",
        metavar="new | show | validate | freeze | texts | schema",
        required=True,
    )
    new = commands.add_parser(
        "new",
        help="write a study file that you can edit",
        epilog="example: slipscale study new ours.toml --title Ours --license CC0-1.0",
    )
    new.add_argument("path", type=Path, metavar="FILE", help="a new TOML file")
    new.add_argument(
        "--title",
        metavar="TEXT",
        help="title of the study and its data set (default: prompt for it)",
    )
    new.add_argument(
        "--author", metavar="NAME", action="append", help="name of an author; may be repeated"
    )
    new.add_argument(
        "--license",
        metavar="NAME",
        help="licence of the data, such as CC0-1.0 or CC-BY-4.0 (default: prompt for it)",
    )
    new.add_argument(
        "--from",
        dest="template",
        default=NEW_STUDY,
        metavar="NAME",
        help=f"the shipped study to start from (default: {NEW_STUDY})",
    )
    show = commands.add_parser(
        "show",
        help="describe a study and a participant's orders",
        epilog="example: slipscale study show matching --timeline --people 20",
    )
    default = here()
    show.add_argument("study", metavar="STUDY", nargs="?", default=default.study, help=WHICH)
    show.add_argument(
        "--participant",
        default="01",
        metavar="01",
        help="participant whose trial orders are shown (default: 01)",
    )
    show.add_argument(
        "--session",
        default="",
        metavar="01",
        help="session whose trial orders are shown (default: the study's first)",
    )
    show.add_argument(
        "--run", default="01", metavar="01", help=("run whose orders are shown (default: 01)")
    )
    show.add_argument(
        "--timeline",
        action="store_true",
        help="print a participant's timeline instead of the orders: durations with their spread, "
        "vibration time and cost",
    )
    show.add_argument(
        "--people",
        type=int,
        default=200,
        metavar="N",
        help="number of simulated people for the timeline (default: 200)",
    )
    show.add_argument(
        "--population",
        metavar="NAME",
        help="simulated people for the timeline: biet2007 (default), realistic (with human "
        "habits), or a TOML file",
    )
    show.add_argument("--json", action="store_true", help="print the timeline as JSON")
    show.add_argument(
        "--figure",
        type=Path,
        metavar="FILE",
        help="draw the timeline as .svg, .png or .pdf; without --timeline, draw the orders for all "
        "participants, which unblinds you",
    )
    validate = commands.add_parser(
        "validate",
        help="report all errors in a study file and the balance of its presentation orders",
        epilog="example: slipscale study validate matching",
    )
    # Outside a laboratory folder there is no default study.
    optional: dict[str, Any] = {"nargs": "?", "default": default.study} if default.file else {}
    validate.add_argument("study", metavar="STUDY", help=WHICH, **optional)
    texts = commands.add_parser(
        "texts",
        help="write a file in which the study's text can be translated into another language",
        epilog="example: slipscale study texts matching --language de --out texts.de.toml",
    )
    texts.add_argument("study", metavar="STUDY", help=WHICH, **optional)
    texts.add_argument(
        "--language", required=True, metavar="CODE", help=("language code, such as de or pt-BR")
    )
    texts.add_argument(
        "--out",
        required=True,
        type=Path,
        metavar="FILE",
        help="a new file in the same folder as the study file",
    )
    commands.add_parser(
        "schema",
        help="print the JSON Schema of study files, for editors",
        epilog="example: slipscale study schema",
    )
    return commands


def run_study(args: Namespace) -> int:
    """Run a subcommand: create, show, validate or translate a study, or print the JSON Schema."""
    from slipscale.experiments.running import study_commands

    if args.what in ("show", "validate", "texts"):
        say(here())
    if args.what == "show" and args.timeline:
        return _timeline(args)
    if args.what == "show":
        _refuse_without_timeline(args)
        figure = _figure_path(args)
    actions = {
        "new": lambda: study_commands.new(args.path, args.template, *_about(args)),
        "show": lambda: study_commands.show(args.study, args.participant, args.session, args.run),
        "validate": lambda: study_commands.validate(args.study),
        "texts": lambda: study_commands.texts(args.study, args.language, args.out),
        "schema": study_commands.schema,
    }
    print(harmless(actions[args.what]()))
    if args.what == "show" and figure:
        _save(study_commands.orders_of_all(args.study), figure)
        print(f"figure  {figure}")
    return DONE


def _about(args: Namespace) -> tuple[str, tuple[str, ...], str]:
    """Return title, authors and licence from the command line; prompt for missing values."""
    title, authors, licence = args.title or "", tuple(args.author or ()), args.license or ""
    if args.path.exists():
        return title, authors, licence  # will be rejected, so do not prompt
    if sys.stdin.isatty():
        title = title or input(f"Title of the study [{args.path.stem}]: ").strip()
        named = authors or input("Authors, separated by commas [none yet]: ").split(",")
        authors = tuple(name.strip() for name in named if name.strip())
        licence = licence or input("Licence of the data, such as CC0-1.0 [none yet]: ").strip()
    return title or args.path.stem, authors, licence


def _refuse_without_timeline(args: Namespace) -> None:
    """Reject options that require ``--timeline``."""
    for name in ("population", "json"):
        if getattr(args, name):
            raise UserError("--{name} requires --timeline", name=name)


def _figure_path(args: Namespace) -> Path | None:
    """Return the path of the figure, if a figure is requested."""
    figure: Path | None = args.figure
    if figure and figure.suffix not in (".svg", ".png", ".pdf"):
        raise UserError(
            "--figure {figure}: expected a name that ends in .svg, .png or .pdf", figure=figure
        )
    return figure


def _save(figure: Figure, path: Path) -> None:
    from slipscale.figure_style import save

    try:
        save(figure, path)
    except OSError as error:
        raise UserError("--figure {path}: {reason}", path=path, reason=error.strerror) from None


def _timeline(args: Namespace) -> int:
    """Print a participant's timeline, and draw it if requested."""
    from slipscale.experiments.participants.simulated_people.population import read_population
    from slipscale.experiments.running.timeline import as_json, lines, timeline

    figure = _figure_path(args)
    population = read_population(args.population) if args.population else None
    found = timeline(args.study, people=args.people, population=population)
    print(as_json(found) if args.json else harmless("\n".join(lines(found))))
    if figure:
        from slipscale.experiments.running.timeline_figure import timeline_figure

        _save(timeline_figure(found), figure)
        if not args.json:
            print(f"figure  {figure}")
    return DONE
