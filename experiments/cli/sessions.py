"""Commands for sessions: run, resume and check.

The required modules are imported when a command runs, because PsychoPy, pydantic and rich load
slowly.
"""

from __future__ import annotations

import shlex
import sys
from argparse import ArgumentParser, Namespace
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.experiments.cli.session_options import (
    add_language,
    add_participant,
    add_plate,
    add_setting,
    add_unblind,
    contact_specs,
    named_contact,
)
from slipscale.experiments.lab.defaults import Defaults, here, say
from slipscale.faults import ANSWER_IS_NO, DONE, INTERRUPTED, UserError, harmless
from slipscale.faults.message import Message

if TYPE_CHECKING:
    from slipscale.experiments.running.lab_session import Setting
    from slipscale.experiments.running.preflight import Finding
    from slipscale.experiments.study.run_plan import RunPlan


def add_run(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale run`` to the parser."""
    add_participant(parser, required=True)
    add_plate(parser)
    add_setting(parser)
    add_language(parser)
    parser.add_argument(
        "--seed",
        type=int,
        metavar="N",
        help="random seed for trial orders (default: the study's seed)",
    )
    parser.add_argument("--pilot", action="store_true", help="mark the run as a pilot")
    parser.add_argument(
        "--add-study",
        action="store_true",
        help="add this study to a data set that already contains a different study",
    )
    add_unblind(parser)


def run_run(args: Namespace) -> int:
    """Run a participant's session."""
    from slipscale.experiments.running.lab_session import make_plan
    from slipscale.hardware.address import is_mock

    defaults = here()
    say(defaults)
    # Nobody can feel a mock plate, so answers on a mock plate are not participant data.
    pilot = args.pilot or is_mock(args.plate)
    plan = make_plan(
        args.study,
        participant=args.participant,
        session=args.session,
        run=args.run,
        seed=args.seed,
        language=args.language,
        pilot=pilot,
    )
    out = args.out or defaults.out(pilot=pilot)
    if not begins_as_before(out, args.study, args.plate):
        return ANSWER_IS_NO
    return _begin(
        out, plan, _setting(args, args.plate, markers=_markers(args)), add_study=args.add_study
    )


def begins_as_before(dataset: Path, study: str, plate: str, *, ask: bool = True) -> bool:
    """Report changes since the last run and, in a terminal, ask whether to begin anyway."""
    from slipscale.experiments.running.changed_since import changes
    from slipscale.experiments.study.file import read_study

    changed = list(changes(dataset, *read_study(study), plate))
    for sentence in changed:
        print(harmless(sentence), file=sys.stderr)
    if not changed or not ask or not sys.stdin.isatty():
        return True
    if input("Begin anyway? [y/N] ").strip().casefold() in ("y", "yes"):
        return True
    print("not started")
    return False


def run_session(
    defaults: Defaults, *, participant: str, session: str, run: str, pilot: bool
) -> int:
    """Run a participant's session with the settings of a laboratory folder."""
    from slipscale.experiments.running.contact_sources import ContactSpecs
    from slipscale.experiments.running.lab_session import Setting, make_plan

    plan = make_plan(
        defaults.study,
        participant=participant,
        session=session,
        run=run,
        language=defaults.language,
        pilot=pilot,
    )
    setting = Setting(
        plate=defaults.plate,
        full_screen=not defaults.windowed,
        screen=defaults.screen,
        markers=defaults.markers,
        contact=ContactSpecs(position=defaults.position, force=defaults.force),
        sound_required=defaults.sound_required,
        backup=defaults.backup,
    )
    return _begin(defaults.out(pilot=pilot), plan, setting)


def _begin(out: Path, plan: RunPlan, setting: Setting, *, add_study: bool = False) -> int:
    from slipscale.experiments.running.lab_session import begin

    return report_end(begin(out, plan, setting, add_study=add_study), plan.journal_path(out))


def _setting(args: Namespace, plate: str, *, markers: tuple[str, ...]) -> Setting:
    """Return the equipment and options for a session, as given on the command line."""
    from slipscale.experiments.running.lab_session import Setting

    return Setting(
        plate=plate,
        full_screen=not args.windowed,
        screen=args.screen,
        unblind=args.unblind,
        markers=markers,
        contact=contact_specs(args),
        sound_required=here().sound_required,
        backup=args.backup,
    )


def _markers(args: Namespace) -> tuple[str, ...]:
    """Return the marker outputs in the arguments or, by default, in the laboratory folder."""
    return tuple(args.markers) if args.markers else here().markers


def add_resume(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale resume`` to the parser."""
    parser.add_argument(
        "journal",
        type=Path,
        metavar="RUN_JOURNAL",
        nargs="?",
        help="the journal of an interrupted run (default: list the interrupted runs)",
    )
    parser.add_argument(
        "--plate",
        metavar="SPEC",
        help="mock, serial:PORT or scpi:RESOURCE (default: the run's plate)",
    )
    add_setting(parser)
    add_unblind(parser)


def run_resume(args: Namespace) -> int:
    """Resume an interrupted run."""
    from slipscale.experiments.journal.plan_and_progress import (
        answered_by,
        dataset_of,
        last_markers,
        last_plate,
        read_plan,
    )
    from slipscale.experiments.running.run_state import check_unfinished

    if args.journal is None or args.journal.is_dir():
        raise UserError(_interrupted(args.journal))
    plan, records = read_plan(args.journal)
    check_unfinished(args.journal, records)
    plate = args.plate or last_plate(records)
    if answered_by(records) == "simulated":
        from slipscale.experiments.dataset.bids import build_dataset
        from slipscale.experiments.running.contact_sources import of_records, require_virtual
        from slipscale.experiments.running.pilot import run_simulated

        folder = dataset_of(args.journal, plan)
        specs = named_contact(args).otherwise(of_records(records))
        require_virtual(specs)
        run_simulated(folder, plan, plate, specs)
        for problem in build_dataset(folder):
            print(f"the data set: {problem}", file=sys.stderr)
        return report_end("complete", args.journal)
    from slipscale.experiments.running.lab_session import go_on

    say(here())
    markers = tuple(args.markers or ()) or last_markers(records)
    return report_end(go_on(args.journal, _setting(args, plate, markers=markers)), args.journal)


def _interrupted(folder: Path | None) -> str:
    """Return the error message for a missing journal, which lists the interrupted runs."""
    from slipscale.experiments.dataset.journals import journals
    from slipscale.experiments.running.run_state import how_to_resume, run_state

    defaults = here()
    places = [folder] if folder else [defaults.data, defaults.pilots, *defaults.pilots.glob("*")]
    found = [
        path for place in places for path in journals(place) if run_state(path) == "interrupted"
    ]
    start = Message("{folder} is a folder", folder=folder) if folder else "RUN_JOURNAL is missing"
    start += "; expected the journal of an interrupted run"
    if found:
        return f"{start}. {'; '.join(how_to_resume(path) for path in found)}"
    searched = folder or f"{defaults.data} or {defaults.pilots}"
    return Message(
        "{start}, but there is no interrupted run in {searched}; to begin a run: slipscale "
        "run --participant 01",
        start=start,
        searched=searched,
    )


def report_end(outcome: str, journal: Path) -> int:
    """Report how a session ended, and return the exit status."""
    if outcome == "complete":
        print(f"complete: {journal}")
        with suppress(UserError, OSError):  # The run is complete, whatever cannot be read.
            print(f"next: {_next_command(journal)}")
        return DONE
    from slipscale.experiments.running.run_state import how_to_resume

    print(f"stopped; nothing is lost. {how_to_resume(journal)}")
    return INTERRUPTED


def _next_command(journal: Path) -> str:
    """Return the command that usually follows a complete run.

    In a laboratory folder, this is the next participant's session while participants are missing.
    Otherwise, it is the analysis.
    """
    from slipscale.experiments.journal.plan_and_progress import read_plan
    from slipscale.experiments.lab.roster import read_roster

    dataset, defaults = journal.parents[2], here()
    plan, _ = read_plan(journal)
    if plan.mode == "participant" and defaults.file is not None:
        roster = read_roster(dataset, plan.study, plan.study_text)
        if roster.of("returns") or roster.new:
            return "slipscale next"
    return f"slipscale analyse {shlex.quote(str(dataset))}"


def add_check(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale check`` to the parser."""
    add_participant(parser, required=False)
    add_plate(parser)
    add_setting(parser)
    add_language(parser)
    parser.add_argument("--pilot", action="store_true", help="check whether a pilot run can start")
    parser.add_argument(
        "--only", metavar="NAME", help="run only one check: plate, display, sound, ..."
    )
    parser.add_argument("--json", action="store_true", help="print the findings as JSON")


def _tell_step(finding: Finding) -> None:
    """Write the progress of the checklist to standard error, where other programs can read it."""
    print(f"step: {finding.name}", file=sys.stderr, flush=True)


def run_check(args: Namespace) -> int:
    """Run the checks that precede a session, and return 1 if a check fails."""
    from slipscale.experiments.running.preflight import PlannedSession, check
    from slipscale.hardware.address import is_mock

    defaults = here()
    say(defaults)
    planned = PlannedSession(
        study=args.study,
        plate=args.plate,
        out=args.out or defaults.out(pilot=args.pilot or is_mock(args.plate)),
        participant=args.participant,
        session=args.session,
        run=args.run,
        screen=args.screen,
        full_screen=not args.windowed,
        language=args.language,
        pilot=args.pilot,
        markers=_markers(args),
        contact=contact_specs(args),
        sound_required=defaults.sound_required,
        backup=args.backup,
    )
    findings = check(planned, _tell_step if args.json else _print_finding, only=args.only)
    if args.json:
        import json
        from dataclasses import asdict

        from slipscale.faults.message import output

        found = [
            asdict(each) | {"detail": output(each.detail), "remedy": output(each.remedy)}
            for each in findings
        ]
        print(json.dumps(found, indent=2, ensure_ascii=False))
    failed = [finding.name for finding in findings if finding.passed is False]
    if failed:
        print(f"not ready: {', '.join(failed)}", file=sys.stderr)
        return ANSWER_IS_NO
    if not args.json:
        print("ready")
    return DONE


def _print_finding(finding: Finding) -> None:
    from rich.console import Console
    from rich.text import Text

    mark, style = {True: ("✓", "green"), False: ("✗", "bold red"), None: ("!", "yellow")}[
        finding.passed
    ]
    detail, remedy = harmless(finding.detail), harmless(finding.remedy)
    line = Text.assemble((f" {mark} ", style), (f"{finding.name:<12}", "bold"), detail)
    if remedy:
        line.append(f"\n   {'':<12}→ {remedy}", "yellow")
    Console(soft_wrap=True).print(line)


COMMANDS = {
    "run": (add_run, run_run),
    "resume": (add_resume, run_resume),
    "check": (add_check, run_check),
}
