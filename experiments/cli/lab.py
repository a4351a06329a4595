"""Commands for a laboratory folder: lab, next, participants and note."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.faults import ANSWER_IS_NO, DONE
from slipscale.faults.folders import visible

if TYPE_CHECKING:
    from slipscale.experiments.lab.defaults import Defaults
    from slipscale.experiments.lab.roster import Person, Roster, Visit


HIGHEST_PORT = 65535
LONGEST_NOTE = 2000  # characters; as in `LiveRequest`


def add_lab(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale lab`` to the parser."""
    parser.add_argument(
        "--no-browser",
        action="store_true",
        help="print the console's address without opening a browser",
    )
    parser.add_argument(
        "--port", type=int, default=8470, metavar="N", help=("port of the console (default: 8470)")
    )
    parser.add_argument(
        "--lan",
        metavar="ADDRESS",
        help="serve the console at this network address of the computer, read-only and with TLS",
    )
    commands = parser.add_subparsers(dest="what", metavar="[init]")
    init = commands.add_parser(
        "init",
        help=(
            "create a laboratory folder; its slipscale.toml contains the defaults for all commands"
        ),
        epilog="example: slipscale lab init our-lab --study matching",
    )
    init.add_argument(
        "folder",
        type=Path,
        nargs="?",
        default=Path(),
        metavar="FOLDER",
        help="a new or existing folder (default: this one)",
    )
    init.add_argument(
        "--study",
        metavar="STUDY",
        help="a TOML file, or the name of a study that comes with Slipscale",
    )
    init.add_argument("--plate", metavar="SPEC", help="mock, serial:PORT or scpi:RESOURCE")
    init.add_argument("--screen", metavar="N", help="the participant's monitor")
    init.add_argument(
        "--windowed",
        action="store_const",
        const="true",
        help="run in a window instead of full screen",
    )
    init.add_argument(
        "--language", metavar="CODE", help="language of the text shown to participants"
    )
    init.add_argument(
        "--sound-required",
        action="store_const",
        const="true",
        help="do not start a session without a sound device for the study's masking noise",
    )
    init.add_argument(
        "--data", metavar="DIR", help=("folder for participants' data (default: data)")
    )
    init.add_argument("--pilots", metavar="DIR", help="folder for pilots (default: pilots)")
    init.add_argument(
        "--backup", metavar="DIR", help=("folder to which the journal of each run is copied")
    )


def run_lab(args: Namespace) -> int:
    """Create a laboratory folder, or open the console of the current folder."""
    if args.what is None:
        return _console(args)
    from slipscale.experiments.lab.folder import FILE, LabFile, init

    options = {key: getattr(args, key, None) for key in LabFile.model_fields}
    given = {key: value for key, value in options.items() if value is not None}
    lab = init(args.folder, given, _ask if sys.stdin.isatty() else None)
    print(
        f"wrote {args.folder / FILE}: study {lab.study}, plate {lab.plate}, data in "
        f"{lab.data}\nCommands that you run in this folder use these settings. Continue with "
        "slipscale check, then slipscale next"
    )
    return DONE


def _console(args: Namespace) -> int:
    from slipscale.experiments.lab.console.serve import serve
    from slipscale.experiments.lab.defaults import here
    from slipscale.faults import UserError

    if not 0 <= args.port <= HIGHEST_PORT:
        raise UserError(
            "--port {port}: expected a number from 0 to {highest_port}",
            port=args.port,
            highest_port=HIGHEST_PORT,
        )
    if here().file:
        _folder()  # raises an error if the study cannot be read
    serve(port=args.port, lan=args.lan, browser=not args.no_browser)
    return DONE


def _ask(question: str, default: str) -> str:
    return input(f"{question} [{default}]: ").strip() or default


def add_next(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale next`` to the parser."""
    parser.add_argument(
        "--participant",
        metavar="01",
        help="a participant returning for another session (default: a new participant)",
    )
    parser.add_argument(
        "--pilot",
        action="store_true",
        help="rehearse the session: run a pilot and store its data in the rehearsals folder",
    )
    parser.add_argument("--yes", action="store_true", help="begin without asking for confirmation")


def run_next(args: Namespace) -> int:
    """Show the next participant, ask for confirmation, and run the session."""
    from slipscale.experiments.cli.sessions import begins_as_before, run_session
    from slipscale.faults import UserError
    from slipscale.hardware.address import is_mock

    defaults, roster = _folder(pilot=args.pilot)
    if is_mock(defaults.plate) and not args.pilot:
        raise UserError(
            "{file}: plate '{plate}' is simulated; participants cannot feel it. Set the real "
            "plate in this file (slipscale plate list), or rehearse: slipscale next --pilot",
            file=defaults.file,
            plate=defaults.plate,
        )
    out = defaults.out(pilot=args.pilot)
    label, visit = _whose(roster, args.participant)
    which = f", {visit}" if visit else ""
    for person in roster.of("interrupted"):
        print(f"participant {person.label} was interrupted: {_how_to_resume(person)}")
    print(
        f"next: participant {label}{which}, study {defaults.study}, plate {defaults.plate}, "
        f"data in {out}{', PILOT' if args.pilot else ''}"
    )
    begins_as_before(out, defaults.study, defaults.plate, ask=False)  # `next` asks anyway
    if not args.yes and not _agreed():
        print("not started")
        return ANSWER_IS_NO
    session = visit.session if visit else _first_session(defaults)
    return run_session(
        defaults,
        participant=label,
        session=session,
        run=visit.run if visit else "01",
        pilot=args.pilot,
    )


def _agreed() -> bool:
    from slipscale.faults import UserError

    if not sys.stdin.isatty():
        raise UserError(
            "no terminal is available to answer the question; add --yes to begin at once"
        )
    return input("Begin? [y/N] ").strip().casefold() in ("y", "yes")


def _whose(roster: Roster, wanted: str | None) -> tuple[str, Visit | None]:
    """Return the next participant's label and run (None if the participant is new).

    Raises
    ------
    UserError
        If a session is running, if all planned participants have started, or if the requested
        participant has no planned runs left.
    """
    from slipscale.faults import UserError
    from slipscale.faults.message import Message

    if roster.running:
        raise UserError(
            "a session is running: {journal}; end it first", journal=roster.running.path
        )
    if wanted is None and roster.new is None:
        back = ", ".join(person.label for person in roster.of("returns"))
        raise UserError(
            "all {planned} planned participants have started{returning}; to add another "
            "participant: slipscale run --participant ...",
            planned=roster.planned,
            returning=Message(
                "; participants due to return: {participants} (slipscale next --participant ...)",
                participants=back,
            )
            if back
            else "",
        )
    if wanted is None or (person := roster.person(wanted)) is None:
        return wanted or str(roster.new), None
    if person.next_visit is None:
        raise UserError(
            "participant {wanted}: no planned runs remain ({state})",
            wanted=wanted,
            state=person.state,
        )
    return wanted, person.next_visit


def add_participants(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale participants`` to the parser."""
    parser.add_argument("--json", action="store_true", help="print the participants as JSON")


def run_participants(args: Namespace) -> int:
    """List the participants, and show who is next."""
    defaults, roster = _folder()
    if args.json:
        import json
        from dataclasses import asdict

        print(json.dumps(asdict(roster), indent=2, ensure_ascii=False, default=str))
        return DONE
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD)
    for title in ("participant", "state", "place", "tasks in order", "runs", "last began (UTC)"):
        table.add_column(title)
    for person in roster.people:
        table.add_row(*_row(person))
    console = Console()
    if roster.people:
        console.print(table)
    begun = sum(person.state != "withdrew" for person in roster.people)
    print(
        f"{begun} of {roster.planned} planned participants have started; "
        f"{len(roster.of('done'))} finished"
    )
    for sentence in (*_exclusions(roster), *_without_backup(defaults)):
        print(sentence)
    for person in roster.of("interrupted"):
        print(f"participant {person.label}: {_how_to_resume(person)}")
    for person in roster.of("returns"):
        print(
            f"participant {person.label} returns for {person.next_visit}: "
            f"slipscale next --participant {person.label}"
        )
    print(f"next: participant {roster.new} (slipscale next)" if roster.new else "nobody is next")
    return DONE


def _row(person: Person) -> list[str]:
    over = sum(visit.state == "complete" for visit in person.visits)
    planned = sum(visit.planned for visit in person.visits)
    last = person.last_begun
    return [
        person.label,
        f"{person.state}, excluded" if person.excluded else person.state,
        str(person.place or ""),
        ", ".join(person.order),
        f"{over} of {planned}" if person.visits else "",
        last.started_utc.replace("T", " ")[:16] if last else "",
    ]


def _exclusions(roster: Roster) -> list[str]:
    """Describe which participants the analysis excludes, and by which rules."""
    if not roster.exclusions and not roster.excluded:
        return []
    rules = f"the study's exclusion rules: {', '.join(roster.exclusions) or 'none'}"
    if not roster.analysed_utc:
        return [f"run slipscale analyse to see who is excluded ({rules})"]
    when = roster.analysed_utc.replace("T", " ")[:16]
    if not roster.excluded:
        return [f"the analysis of {when} UTC excludes no participants ({rules})"]
    return [
        f"participant {person.label} is excluded because of {', '.join(person.excluded)} "
        f"(analysis of {when} UTC; {rules})"
        for person in roster.excluded
    ]


def _without_backup(defaults: Defaults) -> list[str]:
    """Return a sentence that lists the runs without a complete backup, if there are any."""
    from slipscale.experiments.dataset.backup import not_backed_up

    missing = not_backed_up(defaults.data, defaults.backup)
    names = ", ".join(path.name.removesuffix("_journal.jsonl") for path in missing)
    many = "1 run has" if len(missing) == 1 else f"{len(missing)} runs have"
    return [f"{many} no complete backup: {names}"] if missing else []


def _how_to_resume(person: Person) -> str:
    from slipscale.experiments.running.run_state import how_to_resume

    return next(how_to_resume(v.path) for v in person.visits if v.state == "interrupted")


def add_note(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale note`` to the parser."""
    parser.add_argument(
        "words",
        nargs="+",
        metavar="WORDS",
        help=("text of the note; must not contain a participant's name"),
    )


def run_note(args: Namespace) -> int:
    """Send the operator's note to the running session, which records the note in its journal."""
    from slipscale.experiments.journal.locks import is_being_written
    from slipscale.experiments.lab.defaults import here, say
    from slipscale.experiments.session.mailbox import LiveRequest, post, read_status
    from slipscale.faults import UserError

    text = " ".join(args.words)
    if len(text) > LONGEST_NOTE:
        raise UserError(
            "the note has {count} characters; expected at most {longest_note}: write several notes",
            count=len(text),
            longest_note=LONGEST_NOTE,
        )
    defaults = here()
    say(defaults)
    folders = (defaults.out(pilot=False), defaults.out(pilot=True))
    live = [
        path.with_name(path.name.removesuffix(".live"))
        for folder in folders
        for path in visible(folder / "sourcedata", "sub-*/*.live")
    ]
    for journal in live:
        status = read_status(journal)
        if status and is_being_written(journal):
            post(journal, LiveRequest(token=status.token, what="note", reason=text))
            print(f"noted in {journal}")
            return DONE
    searched = " and ".join(str(folder) for folder in folders)
    raise UserError(
        "no session is running in {searched}; notes can only be written to a running session's "
        "journal",
        searched=searched,
    )


def _folder(*, pilot: bool = False) -> tuple[Defaults, Roster]:
    """Return the defaults and the participants of the laboratory folder or its rehearsals.

    Raises
    ------
    UserError
        If the current folder is not a laboratory folder.
    """
    from slipscale.experiments.lab.defaults import FILE, here, say
    from slipscale.experiments.lab.roster import read_roster
    from slipscale.experiments.study.file import read_study
    from slipscale.faults import UserError

    defaults = here()
    if defaults.file is None:
        raise UserError(
            "there is no {file} here; create a laboratory folder: slipscale lab init", file=FILE
        )
    say(defaults)
    study, text = read_study(defaults.study)
    return defaults, read_roster(defaults.out(pilot=pilot), study, text)


def _first_session(defaults: Defaults) -> str:
    from slipscale.experiments.study.file import read_study

    return (*read_study(defaults.study)[0].sessions, "")[0]


COMMANDS = {
    "lab": (add_lab, run_lab),
    "next": (add_next, run_next),
    "participants": (add_participants, run_participants),
    "note": (add_note, run_note),
}
