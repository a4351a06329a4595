"""Check study, folder, plate, sensors, sound and display before the participant arrives.

Each check in the table tests a single condition and, if this is not met, recommends an action. The
checks do not change the data set, except that one tests whether the folder is writable.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import stdev

from slipscale.experiments.dataset.backup import check_folder as check_backup
from slipscale.experiments.dataset.journals import read_runs
from slipscale.experiments.journal.locks import has_locks
from slipscale.experiments.languages.texts import ENGLISH, Texts, shipped_texts
from slipscale.experiments.running.begin_or_resume import plate_for
from slipscale.experiments.running.changed_since import changes
from slipscale.experiments.running.contact_sources import (
    NOT_NAMED,
    ContactSpecs,
    of_run,
    try_sources,
)
from slipscale.experiments.running.disk_space import why_not_taken
from slipscale.experiments.running.rehearsal import check_supported, surfaces
from slipscale.experiments.running.run_state import (
    check_alike,
    check_mode,
    check_same_study,
    participants,
    remedy,
    run_state,
)
from slipscale.experiments.session.marker_outputs import open_markers
from slipscale.experiments.session.markers import Event
from slipscale.experiments.study.file import read_study
from slipscale.experiments.study.run_plan import RunPlan, check_labels, journal_path
from slipscale.faults import RigError, UserError
from slipscale.faults.message import Message, joined
from slipscale.hardware.address import is_mock, with_plate_file
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.driver import PlateDriver
from slipscale.hardware.signals import silent_on_signals
from slipscale.stimuli.quantity import Quantity
from slipscale.stimuli.surface import VirtualSurface

ENOUGH_MB = 100
FOCUS_FRAMES = 40
READINGS, READINGS_S = 20, 0.2


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedSession:
    """The session that is about to be run."""

    study: str
    plate: str
    out: Path
    participant: str | None = None
    session: str = ""
    run: str = "01"
    screen: int = 0
    full_screen: bool = True
    language: str | None = None  # None: the study's language
    pilot: bool = False
    markers: tuple[str, ...] = ()
    contact: ContactSpecs = NOT_NAMED
    sound_required: bool = False  # require masking noise even if the study treats it as optional
    backup: Path | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """The result of a check.

    Parameters
    ----------
    passed : bool or None
        Whether the check passed; None if a problem was found that does not prevent the session.
    detail : str
        What was found.
    remedy : str
        The recommended action; empty if no action is needed.
    name : str
        Name of the check, which the function `check` fills in.
    """

    passed: bool | None
    detail: str
    remedy: str = ""
    name: str = ""


def check_study(planned: PlannedSession) -> Finding:
    """Check that the study file is valid."""
    plan = _plan(planned)
    plan.person_questions()  # raises an error if texts in the chosen language are missing
    tasks = ", ".join(options.protocol for options in plan.study.tasks)
    return Finding(passed=True, detail=f"{plan.study.name} ({plan.language}): {tasks}")


def _plan(planned: PlannedSession) -> RunPlan:
    """Return the plan of a run with which the checks are made; participant 01 is an example."""
    study, text = read_study(planned.study)
    return RunPlan(
        study_name=planned.study,
        study_text=text,
        participant="01",
        session=planned.session or (*study.sessions, "")[0],
        seed=study.seed,
        language=planned.language or study.language,
        mode="pilot",
    )


def check_folder(planned: PlannedSession) -> Finding:
    """Check that the folder is writable and is the right place for the data."""
    folder = planned.out
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder, buffering=0) as trial:
            trial.write(b"trial")
            trial.flush()
            os.fsync(trial.fileno())
            locked = has_locks(trial)
        free_mb = shutil.disk_usage(folder).free // 1_000_000
        full = why_not_taken(folder, ENOUGH_MB * 1_000_000) if free_mb >= ENOUGH_MB else ""
    except OSError as error:
        return Finding(
            passed=False,
            detail=f"{folder}: {error.strerror}",
            remedy="choose a folder on a local disk with --out, or correct its permissions",
        )
    if free_mb < ENOUGH_MB:
        return Finding(
            passed=False,
            detail=Message("{folder}: {free_mb} MB free", folder=folder, free_mb=free_mb),
            remedy=Message("free some space: at least {enough_mb} MB", enough_mb=ENOUGH_MB),
        )
    if full:
        return Finding(
            passed=False,
            detail=(
                Message(
                    "{folder}: {free_mb} MB are reported as free, but writing {enough_mb} MB "
                    "failed ({reason})",
                    folder=folder,
                    free_mb=free_mb,
                    enough_mb=ENOUGH_MB,
                    reason=full,
                )
            ),
            remedy="ask for a higher quota or file-size limit, or choose another disk",
        )
    check_mode(folder, "pilot" if planned.pilot or is_mock(planned.plate) else "participant")
    if planned.backup:
        check_backup(folder, planned.backup)
    notes = list(_notes(planned, locked=locked))
    return Finding(
        passed=None if notes else True,
        detail=Message("{folder}: {free_mb:.0f} GB free", folder=folder, free_mb=free_mb / 1000),
        remedy="; ".join(notes),
    )


def _notes(planned: PlannedSession, *, locked: bool) -> Iterator[str]:
    """Yield notes about problems of the folder and journals that do not prevent a session."""
    if not locked:
        yield (
            "the file system does not support locks: only a lock file prevents two sessions "
            "from writing the same run; record to a local disk and copy the data afterwards"
        )
    _, problems = read_runs(planned.out)
    if problems:
        files = ", ".join(sorted({problem.file for problem in problems}))
        yield Message(
            "damaged: {files}; for details: slipscale data verify {out}",
            files=files,
            out=planned.out,
        )
    try:
        study, text = read_study(planned.study)
    except UserError:
        return  # the check of the study reports this error
    try:
        check_same_study(planned.out, study.name)
    except UserError as error:
        yield str(error)
    yield from changes(planned.out, study, text, planned.plate)


def check_participant(planned: PlannedSession) -> Finding:
    """Check that the participant label is not in use."""
    if planned.participant is None:
        taken = participants(planned.out)
        numbers = {int(label) for label in taken if label.isdigit()}
        number = next(n for n in range(1, len(taken) + 2) if n not in numbers)
        return Finding(
            passed=True,
            detail=Message(
                "{count} so far; the next free label is {number:02d}",
                count=len(taken),
                number=number,
            ),
        )
    check_labels(participant=planned.participant, session=planned.session, run=planned.run)
    check_alike(planned.out, planned.participant, session=planned.session, run=planned.run)
    path = journal_path(
        planned.out,
        participant=planned.participant,
        session=planned.session,
        run=planned.run,
    )
    state = run_state(path)
    if state == "free":
        return Finding(
            passed=True, detail=Message("{participant} is free", participant=planned.participant)
        )
    return Finding(
        passed=False,
        detail=Message(
            "{participant} already has a run ({state}): {path}",
            participant=planned.participant,
            state=state,
            path=path,
        ),
        remedy=remedy(path, state),
    )


def check_plate(planned: PlannedSession) -> Finding:
    """Check that the plate responds, presents the study's largest amplitude, and stops.

    The plate must also support all other surfaces of the study. Textures are not played.
    """
    plan = _plan(planned)
    study = plan.study
    spec = with_plate_file(planned.plate, study.plate.file)
    with (
        plate_for(plan, spec, SystemClock()) as plate,
        silent_on_signals(plate),
    ):
        check_supported(plan, plate, planned.contact)
        # The plate settles at a texture's mean amplitude.
        largest = max((each.settled_level for each in surfaces(plan)), default=0.0)
        plate.second_level = max(study.second_levels, default=0.0)
        made = plate.present(VirtualSurface(level=largest))
        notes = [*plate.notes, *_scatter(plate, study.plate_quantity)]
        plate.silence()
        who = plate.identity
        textures = "plays textures" if plate.modulator else "plays no textures"
        unfelt = plate.unfelt
    reading = made.readback.level
    found = [f"{who.manufacturer} {who.model} {who.serial}" if who else planned.plate]
    found.append(
        "no readback"
        if reading is None
        else Message(
            "reads {reading:.2f} of {largest}",
            reading=reading,
            largest=study.plate_quantity.short(largest),
        )
    )
    if study.second_plate and made.second_readback_level is not None:
        short = study.second_plate.quantity.quantity.short
        second = Message(
            "the second actuator reads {reading:.2f} of {largest}",
            reading=made.second_readback_level,
            largest=short(max(study.second_levels)),
        )
        found.append(second)
    found += [f"{made.settle_time_s * 1000:.0f} ms", textures]
    if unfelt:
        found.append("simulated: participants cannot feel it, and a run on it is a pilot")
    return Finding(
        # A note (such as an old calibration) does not prevent a session, but the operator should
        # read it.
        passed=None if notes else True,
        detail=joined("; ", found),
        remedy=joined("; ", notes),
    )


def _scatter(plate: PlateDriver, quantity: Quantity) -> Iterator[str]:
    """Yield advice if readings at a constant amplitude scatter too much for a session.

    A reading out of tolerance is a fault (docs/decisions/one-tolerance.md). If the scatter is a
    fifth of the tolerance, a false fault requires a deviation of five standard deviations, which is
    practically impossible.
    """
    readbacks = []
    for _ in range(READINGS):
        plate.clock.sleep(READINGS_S / READINGS)
        readbacks.append(plate.read_back())
    read = [each.level for each in readbacks if each.kind == "measured"]
    if len(amplitudes := [each for each in read if each is not None]) < READINGS:
        return
    deviation_level, limit_level = stdev(amplitudes), plate.limits.deviation_level / 5
    # By chance, the standard deviation of 20 readings exceeds its true value by 25 % in about 1 of
    # 20 cases.
    if deviation_level > 1.25 * limit_level:
        yield (
            Message(
                "the readings scatter by {deviation_level:.3f} {unit} (standard deviation), more "
                "than {limit_level:.3f}: a session would treat this as faults; average the "
                "sensor's signal over a longer time, or find the source of the vibration",
                deviation_level=deviation_level,
                unit=quantity.unit,
                limit_level=limit_level,
            )
        )


def check_contact(planned: PlannedSession) -> Finding:
    """Check that the finger sensors can be connected and read."""
    readings = try_sources(_contact_specs(planned), _plan(planned).study.seed)
    return Finding(passed=True, detail="; ".join(readings))


def check_display(planned: PlannedSession) -> Finding:
    """Open the participant's window as in a session, and check that key presses reach it.

    If the keyboard does not provide time stamps, the window measures the response times.
    """
    # Imported here, because PsychoPy takes seconds to load and earlier checks may fail first.
    from slipscale.experiments.participants.psychopy_window import PsychoPyWindow

    # The screen can be checked even if the study is invalid.
    texts: Texts = shipped_texts(planned.language or ENGLISH)
    with suppress(UserError):
        texts = _plan(planned).texts()
    frames = iter(range(FOCUS_FRAMES))
    with PsychoPyWindow(
        texts=texts,
        clock=SystemClock(),
        pilot=planned.pilot or is_mock(planned.plate),
        full_screen=planned.full_screen,
        screen=planned.screen,
    ) as window:
        window.hold("", lambda: next(frames, None) is None)
        focused, stamped = window.focused, window.stamps_keys
        size = f"{window.display.handle.width} x {window.display.handle.height}"
    if not focused:
        return Finding(
            passed=False,
            detail=Message(
                "screen {screen}, {pixels}: the window has no keyboard focus",
                screen=planned.screen,
                pixels=size,
            ),
            remedy=(
                "close any window that covers the participant's screen, then click on the "
                "screen once"
            ),
        )
    seen = Message("screen {screen}, {pixels}, keyboard focus", screen=planned.screen, pixels=size)
    if not stamped:
        return Finding(
            passed=None,
            detail=Message("{seen}; the keyboard does not time-stamp key presses", seen=seen),
            remedy="response times will be measured by the window, about 10 ms late and less "
            "regular, and marked accordingly; see docs/explanation/analysis.md",
        )
    return Finding(passed=True, detail=Message("{seen}; key presses have time stamps", seen=seen))


def check_sound(planned: PlannedSession) -> Finding:
    """Check that the study's masking noise, if any, can be generated, and find an audio device."""
    from slipscale.experiments.session.sound.masking_noise import MaskingNoise, check_device

    study, _ = read_study(planned.study)
    noise = study.masking_noise
    if noise is None:
        missing = check_device() if study.headphone_test else None
        return Finding(
            passed=None if missing else True,
            detail=joined(
                "; ",
                (
                    "the study uses no masking noise",
                    *(["no audio device: the headphone test will be skipped"] if missing else []),
                ),
            ),
            remedy=missing or "",
        )
    # Generates the same noise as a session, and raises an error if its peaks would clip.
    MaskingNoise(level_db=noise.level_db, fade_s=noise.fade_s, seed=study.seed)
    remedy = check_device()
    required = noise.required or planned.sound_required
    if remedy is None:
        return Finding(
            passed=True, detail=Message("pink noise at {level_db:g} dB FS", level_db=noise.level_db)
        )
    return Finding(
        passed=False if required else None,
        detail=joined(
            "; ",
            (
                "no audio device",
                *(["the headphone test will be skipped"] if study.headphone_test else []),
                *([] if required else ["the study allows a session without masking noise"]),
            ),
        ),
        remedy=remedy,
    )


def check_markers(planned: PlannedSession) -> Finding:
    """Open the marker outputs as in a session, and send each a start and an end marker."""
    lost: list[str] = []
    with open_markers(planned.markers) as markers:
        markers.lost = lambda name, reason: lost.append(f"{name}: {reason}")
        markers.mark(Event.BEGIN)
        markers.mark(Event.END)
        names = ", ".join(markers.names)
    if lost:
        return Finding(
            passed=False,
            detail="; ".join(lost),
            remedy="check the recorder's cable and driver, or omit --markers",
        )
    detail = (
        Message("sent a start and an end marker to {names}", names=names)
        if names
        else "none are requested"
    )
    return Finding(passed=True, detail=detail)


CHECKS: dict[str, Callable[[PlannedSession], Finding]] = {
    "study": check_study,
    "folder": check_folder,
    "participant": check_participant,
    "plate": check_plate,
    "finger": check_contact,
    "sound": check_sound,
    "markers": check_markers,
    "display": check_display,
}
# The checks that require a valid study.
NEED_STUDY = ("plate", "finger", "sound")


def _measures_finger(planned: PlannedSession) -> bool:
    """Return whether the command, the study or the plate file specifies a finger sensor."""
    try:
        return bool(_contact_specs(planned).used)
    except UserError:
        return bool(planned.contact.used)


def _contact_specs(planned: PlannedSession) -> ContactSpecs:
    """Return the finger sensors given by the command, else by the study, else by the plate."""
    plan = _plan(planned)
    spec = with_plate_file(planned.plate, plan.study.plate.file)
    plate = plate_for(plan, spec, SystemClock())
    return of_run(planned.contact, plan.study, plate.plate_file)


def check(
    planned: PlannedSession, tell: Callable[[Finding], None], *, only: str | None = None
) -> list[Finding]:
    """Run all checks in order, or only one; call ``tell`` with each finding.

    User errors and rig faults are returned as findings instead of being raised, so the list is
    always complete.
    """
    if only is not None and only not in CHECKS:
        raise UserError(
            "--only {only}: no such check; expected {checks}", only=only, checks=", ".join(CHECKS)
        )
    findings: list[Finding] = []
    for name, look in CHECKS.items():
        if only is not None and name != only:
            continue
        if name == "finger" and not _measures_finger(planned):
            continue
        studyless = findings and findings[0].passed is False and name in NEED_STUDY
        if studyless:
            finding = Finding(passed=False, detail="not checked: the study has errors")
        else:
            try:
                finding = look(planned)
            except (UserError, RigError) as error:
                finding = Finding(passed=False, detail=str(error))
        findings.append(replace(finding, name=name))
        tell(findings[-1])
    return findings
