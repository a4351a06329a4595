"""Run a session with a participant, using the window, the plate, masking noise and the operator."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, TypeVar

from rich.console import Console

from slipscale.experiments.dataset.backup import back_up, why_no_backup
from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.journal.plan_and_progress import (
    consent_was_taken_back,
    dataset_of,
    last_backup,
    last_plate,
    latest_s,
    read_plan,
)
from slipscale.experiments.participants.psychopy_window import PsychoPyWindow
from slipscale.experiments.running.begin_or_resume import plate_for, run_plan
from slipscale.experiments.running.changed_texts import changed_texts
from slipscale.experiments.running.contact_sources import (
    NOT_NAMED,
    ContactSpecs,
    of_plate,
    of_records,
    of_study,
    open_sources,
)
from slipscale.experiments.running.rehearsal import check_supported
from slipscale.experiments.running.run_state import (
    check_alike,
    check_mode,
    check_same_study,
    check_unfinished,
    how_to_resume,
    not_built,
    remedy,
    run_state,
)
from slipscale.experiments.session.mailbox import Mailbox, mailbox_of
from slipscale.experiments.session.marker_outputs import open_markers
from slipscale.experiments.session.operator import Operators
from slipscale.experiments.session.parts import Setup
from slipscale.experiments.session.passive_exploration import stage_of
from slipscale.experiments.session.resonance_tracking import ResonanceTracking
from slipscale.experiments.session.sound.masking_noise import MaskingNoise, NoNoise, check_device
from slipscale.experiments.session.sound.question_sounds import NoSounds, SoundOutput, Sounds
from slipscale.experiments.session.terminal import Keys, TerminalOperator
from slipscale.experiments.study.file import read_study
from slipscale.experiments.study.run_plan import RunPlan, check_labels
from slipscale.faults import UserError, harmless
from slipscale.faults.message import Message, joined, report
from slipscale.hardware.address import is_mock, with_plate_file
from slipscale.hardware.backends.pair import PlatePair
from slipscale.hardware.clock import Clock, SystemClock
from slipscale.hardware.contact.serial_columns import open_vibrometer
from slipscale.hardware.contact.source import Surroundings
from slipscale.hardware.contact.stage import EmulatedStage
from slipscale.hardware.signals import signals_raise

if TYPE_CHECKING:
    from slipscale.experiments.session.session import RunOutcome
    from slipscale.hardware.driver import PlateDriver

    Context = TypeVar("Context", Mailbox, Keys)


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """The equipment and options of a session.

    Parameters
    ----------
    plate : str
        Specification (SPEC) of the plate.
    full_screen, screen
        The properties of the participant's window.
    unblind : bool
        Whether the operator sees the amplitude.
    markers : tuple of str
        Marker outputs: SPECs of `slipscale.experiments.session.marker_outputs`.
    contact : ContactSpecs
        The finger sensors that the command specifies.
    sound_required : bool
        Whether masking noise is required even if it is optional in the study.
    backup : Path or None
        Folder to which the journal is copied at the end of the run. The copy is then verified.
    """

    plate: str
    full_screen: bool = True
    screen: int = 0
    unblind: bool = False
    markers: tuple[str, ...] = ()
    contact: ContactSpecs = NOT_NAMED
    sound_required: bool = False
    backup: Path | None = None


def make_plan(
    study_name: str,
    *,
    participant: str,
    session: str = "",
    run: str = "01",
    seed: int | None = None,
    language: str | None = None,
    pilot: bool = False,
) -> RunPlan:
    """Return the plan of a run from the command's options.

    Raises
    ------
    UserError
        If a label is invalid, or the session is not part of the study.
    """
    check_labels(participant=participant, session=session, run=run)
    study, text = read_study(study_name)
    plan = RunPlan(
        study_name=study_name,
        study_text=text,
        participant=participant,
        session=session,
        run=run,
        seed=study.seed if seed is None else seed,
        language=language or study.language,
        mode="pilot" if pilot else "participant",
    )
    # Reject invalid plans before anything is written.
    plan.context()
    plan.person_questions()
    return plan


def begin(dataset: Path, plan: RunPlan, setting: Setting, *, add_study: bool = False) -> RunOutcome:
    """Run a participant's session from the start.

    Parameters
    ----------
    add_study : bool
        Whether the study may be added to a data set that contains another study.

    Raises
    ------
    UserError
        If the run already exists, if the participant withdrew or exists under an equivalent label,
        if the data set has another mode or study, if a participant's run would use a simulated
        plate, or if the window cannot be opened.
    PlateFault
        If the rig failed; the journal can be resumed.
    """
    check_mode(dataset, plan.mode)
    check_alike(dataset, plan.participant, session=plan.session, run=plan.run)
    if not add_study:
        check_same_study(dataset, plan.study.name)
    path = plan.journal_path(dataset)
    state = run_state(path)
    if state != "free":
        # Reported before anything is opened; `Journal.create` also checks this.
        raise UserError(
            "participant {participant} already has a run ({state}): {path}; {remedy}",
            participant=plan.participant,
            state=state,
            path=path,
            remedy=remedy(path, state),
        )
    return _conduct(
        dataset,
        plan,
        replace(setting, contact=setting.contact.otherwise(of_study(plan.study))),
        partial(Journal.create, path, SystemClock(), private=plan.study.private_files),
    )


def go_on(path: Path, setting: Setting) -> RunOutcome:
    """Resume an interrupted run.

    Raises
    ------
    UserError
        If the journal is complete, damaged, misplaced or in use, if the participant withdrew
        consent in the run, or if resuming would continue a participant's run on a simulated plate.
    """
    plan, records = read_plan(path)
    check_unfinished(path, records)
    if consent_was_taken_back(records):
        raise UserError(
            "journal {path}: the participant withdrew consent in this run, so it cannot be "
            "resumed. slipscale data withdraw removes the data of participant {participant}",
            path=path,
            participant=plan.participant,
        )
    dataset = dataset_of(path, plan)
    for sentence in changed_texts(plan, records):
        print(harmless(sentence), file=sys.stderr)
    if plan.mode == "participant" and is_mock(setting.plate):
        raise UserError(
            "--plate {plate}: a participant's run cannot be resumed with a simulated plate, "
            "which the participant cannot feel; the run used {used_plate}",
            plate=setting.plate,
            used_plate=last_plate(records),
        )
    # Session time is measured from the start of the run, including the interruption.
    clock = SystemClock(max(_since_s(records[0].data["started_utc"]), latest_s(records)))
    setting = replace(
        setting,
        contact=setting.contact.otherwise(of_records(records)),
        backup=setting.backup or last_backup(records),
    )
    return _conduct(dataset, plan, setting, partial(Journal.reopen, path, clock))


def _since_s(date: str) -> float:
    """Return the time elapsed since a date, in s; 0 if the date is invalid."""
    try:
        return (datetime.now(UTC) - datetime.fromisoformat(date)).total_seconds()
    except (ValueError, TypeError):  # no date, or a date without a time zone
        return 0.0


def _conduct(
    dataset: Path, plan: RunPlan, setting: Setting, opened: Callable[[], Journal]
) -> RunOutcome:
    """Open the journal and equipment, run the session, close everything, and build the data set.

    The journal is opened first: its lock stops a second session of the same run before it reaches
    the plate, and an unwritable folder is reported before any equipment is used.
    """
    with signals_raise() as leave:
        journal = opened()
        try:
            with ExitStack() as stack:
                stack.push(partial(_leave, dataset, journal, setting))
                stack.push(journal)
                try:
                    return _perform(stack, dataset, plan, setting, journal)
                finally:
                    leave()
        finally:
            journal.close()  # a signal may arrive before the exit stack can close the journal


def _perform(
    stack: ExitStack, dataset: Path, plan: RunPlan, setting: Setting, journal: Journal
) -> RunOutcome:
    """Open the remaining devices, which the exit stack closes later, and run the session."""
    clock = journal.clock
    missing = why_no_backup(dataset, setting.backup) if setting.backup else ""
    no_backup: tuple[str, ...] = ()
    if missing:
        sentence = "NO BACKUP of this run unless you correct this: {reason}"
        no_backup = (Message(sentence, reason=missing),)
    spec = with_plate_file(setting.plate, plan.study.plate.file)
    heading = plan.heading(spec)
    # Opened before the window, because opening the window takes seconds, in which requests must not
    # reach the mailbox of a crashed session.
    mailbox = _enter(stack, Mailbox(mailbox_of(journal.path), heading))
    journal.moved = lambda path: mailbox.move(mailbox_of(path))
    plate = stack.enter_context(plate_for(plan, spec, clock))
    warnings = (*no_backup, *plate.notes)
    for warning in warnings:
        print(harmless(warning), file=sys.stderr)
    check_felt(plan, plate, begun=bool(journal.records))
    check_supported(plan, plate, setting.contact)
    noise = _noise(plan, required=setting.sound_required)
    markers = stack.enter_context(open_markers(setting.markers))
    person = PsychoPyWindow(
        texts=plan.texts(),
        clock=clock,
        pilot=plan.mode == "pilot",
        full_screen=setting.full_screen,
        screen=setting.screen,
        theme=plan.study.screens,
        progress_line=plan.study.progress_line,
    )
    surroundings = Surroundings(clock=clock, seed=plan.seed, finger=person.finger)
    specs = setting.contact.otherwise(of_plate(plate.plate_file))
    sources = open_sources(specs, surroundings, stack)
    stage = stage_of(plan.study.stroke, {kind: each.source for kind, each in sources.items()})
    if plan.mode == "participant" and isinstance(stage, EmulatedStage):
        raise UserError(
            "--position {position}: the stage is emulated, so nothing moves; expected a real "
            "stage, or --pilot",
            position=specs.position,
        )
    stack.enter_context(person)
    keys = _enter(stack, Keys())
    terminal = stack.enter_context(TerminalOperator(Console(), keys, heading=heading))
    return run_plan(
        plan,
        Setup(
            plate=plate,
            participant=person,
            journal=journal,
            clock=clock,
            operator=Operators(terminal, mailbox),
            noise=noise or NoNoise(),
            sounds=_sounds(plan),
            markers=markers,
            unblind=setting.unblind,
            tracking=_tracking(plan, plate, clock, stack),
            warnings=warnings,
        ),
        spec=spec,
        sources=sources,
        backup=setting.backup,
    )


def _enter(stack: ExitStack, context: Context) -> Context:
    """Enter a context after registering its exit, because a signal may interrupt the entry."""
    stack.push(context)
    context.__enter__()
    return context


def check_felt(plan: RunPlan, plate: PlateDriver, *, begun: bool) -> None:
    """Raise `UserError` if a participant's run would use a simulated plate.

    The driver is queried, because an emulated board has a port just like a real board.
    """
    if plan.mode == "participant" and plate.unfelt:
        who = plate.identity
        fault = Message(
            "plate {plate}: the plate is simulated, but this is a participant run; connect the "
            "plate (slipscale plate list)",
            plate=f"{who.model} {who.serial}" if who else plate.name,
        )
        pilot = "or add --pilot: the run is then recorded as a pilot, in a separate folder"
        raise UserError(fault if begun else joined("; ", (fault, pilot)))


def _tracking(
    plan: RunPlan, plate: PlateDriver, clock: Clock, stack: ExitStack
) -> ResonanceTracking | None:
    """Return the resonance tracker if the study requires one; simulated plates need none."""
    wanted = plan.study.plate
    if isinstance(plate, PlatePair):
        plate = plate.first  # the frequency sweep runs between trials, when both actuators are off
    if not wanted.track_resonance or plate.simulated:
        return None
    if not plate.tracks:
        raise UserError(
            "track_resonance: backend '{plate_name}' follows its resonance automatically; remove "
            "the key from the study file",
            plate_name=plate.name,
        )
    vibrometer = stack.enter_context(open_vibrometer(wanted.track_resonance, clock))
    return ResonanceTracking(plate, vibrometer, wanted.track_every_s)


def _leave(
    dataset: Path,
    journal: Journal,
    setting: Setting,
    _kind: type[BaseException] | None,
    error: BaseException | None,
    _trace: TracebackType | None,
) -> None:
    """Build the data set. If the session failed, print how to resume the run."""
    if not journal.records:
        return
    if journal.lost:
        moved = Message(
            "The journal's original location is missing ({lost}): the complete run is in {path}. "
            "Copy the journal back once the disk or folder is available.",
            lost=journal.lost,
            path=journal.path,
        )
        report("warning", moved, moved)
    try:
        for problem in build_dataset(dataset):
            print(f"the data set: {problem}", file=sys.stderr)
    except UserError as fault:
        if error is None:
            raise UserError(not_built(fault, dataset, journal)) from None
        print(harmless(f"the data set was not built: {fault}"), file=sys.stderr)
    if setting.backup:
        try:
            copy = back_up(dataset, journal.path, setting.backup)
            print(harmless(f"backup: {copy}"), file=sys.stderr)
        except UserError as fault:
            warning = Message("NO BACKUP of this run: {fault}", fault=fault)
            report("warning", warning, harmless(warning))
    if error is not None:
        print(f"All answers so far are saved. {how_to_resume(journal.path)}", file=sys.stderr)


def _sounds(plan: RunPlan) -> Sounds:
    """Return the sound output for the headphone test; `NoSounds` without a test or a device."""
    missing = check_device() if plan.study.headphone_test else "the study has none"
    return NoSounds(missing) if missing else SoundOutput()


def _noise(plan: RunPlan, *, required: bool) -> MaskingNoise | None:
    """Return the study's masking noise; None if it is optional and there is no audio device."""
    wanted = plan.study.masking_noise
    if wanted is None:
        return None
    missing = check_device()
    if missing is None:
        return MaskingNoise(level_db=wanted.level_db, fade_s=wanted.fade_s, seed=plan.study.seed)
    if wanted.required or required:
        who = "the study" if wanted.required else "the laboratory folder"
        raise UserError("masking noise is required by {who}: {missing}", who=who, missing=missing)
    print(f"no masking noise: {missing}", file=sys.stderr)
    return None
