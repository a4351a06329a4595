"""Pilots: complete studies with simulated participants on the mock plate, in virtual time.

A pilot runs the same session code as a session with a person. The clock, the plate, the sensors and
the participant are simulated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.journals import journals
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.journal.plan_and_progress import (
    elapsed_s,
    holds_records,
    is_complete,
    read_plan,
)
from slipscale.experiments.journal.record import Record
from slipscale.experiments.participants.simulated_people.growth import people_for
from slipscale.experiments.participants.simulated_people.in_session import (
    GAVE_UP,
    SimulatedParticipant,
)
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.participants.simulated_people.respondent import respondent_of
from slipscale.experiments.running.begin_or_resume import plate_for, run_plan
from slipscale.experiments.running.contact_sources import (
    NOT_NAMED,
    ContactSpecs,
    of_plate,
    of_study,
    open_sources,
    require_virtual,
    simulated,
    with_stage,
)
from slipscale.experiments.running.rehearsal import bounded, check_answered, check_supported
from slipscale.experiments.session.operator import UnattendedOperator
from slipscale.experiments.session.parts import Setup
from slipscale.experiments.session.sound.question_sounds import ImaginedSounds
from slipscale.experiments.study.file import parse_study, read_study
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError
from slipscale.hardware.address import is_mock, with_plate_file
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.contact.source import Surroundings
from slipscale.hardware.driver import PlateDriver
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.signals import signals_raise

MOCK = "mock"  # the simulated plate without faults
# Scatter of the mock's readings, relative to the study's tolerance. With more scatter, an
# occasional reading would be out of tolerance and end the pilot with a plate fault.
PART_OF_TOLERANCE = 1 / 6
MOCK_NOISE_UM = 0.005  # default scatter
FRAME_S = 0.01  # sampling interval of a measured finger


def pilot_plans(
    study_name: str,
    *,
    participants: int | None,
    seed: int | None,
    language: str | None,
    population: Population | None = None,
    text: str | None = None,
) -> list[RunPlan]:
    """Return the plans of a pilot's runs: all planned sessions and runs of each participant.

    Parameters
    ----------
    study_name : str
        A study file, or the name of a study that comes with Slipscale.
    participants, seed, language
        These values override the study's values.
    population : Population, optional
        Simulated population (default: the shipped population).
    text : str, optional
        Content of the study file, if it differs from the saved file.
    """
    if text is None:
        study, text = read_study(study_name)
    else:
        study = parse_study(text, study_name)
    count = study.participants if participants is None else participants
    if count < 1:
        raise UserError("--participants {count}: expected 1 or more", count=count)
    width = max(2, len(str(count)))
    people = people_for(study, population).model_dump_json()
    return [
        RunPlan(
            study_name=study_name,
            study_text=text,
            participant=f"{number:0{width}d}",
            session=session,
            run=f"{run:02d}",
            seed=study.seed if seed is None else seed,
            language=language or study.language,
            mode="pilot",
            population=people,
        )
        for number in range(1, count + 1)
        for session in study.sessions or ("",)
        for run in range(1, study.runs + 1)
    ]


def next_folder(parent: Path) -> Path:
    """Return the path of a new numbered folder: pilots/001, pilots/002, ..."""
    taken = [int(entry.name) for entry in parent.glob("[0-9]*") if entry.name.isdigit()]
    return parent / f"{max(taken, default=0) + 1:03d}"


def claim(folder: Path, plans: list[RunPlan]) -> None:
    """Check that a folder is new or contains only runs of this pilot.

    Raises
    ------
    UserError
        If the folder contains a different pilot, a participant's data or only unrelated files.
    """
    try:
        # A pilot that is interrupted before its first record leaves folders without files.
        if not folder.exists() or all(entry.is_dir() for entry in _entries(folder)):
            return
    except OSError as error:
        raise UserError("--out {folder}: {reason}", folder=folder, reason=error.strerror) from None
    known = {plan.journal_path(folder): plan for plan in plans}
    for path in journals(folder):
        if path in known and (not holds_records(path) or _same(read_plan(path)[0], known[path])):
            continue
        raise UserError(
            "--out {folder}: contains another pilot or a participant's data ({path_name}); "
            "expected a new folder, or the folder of an interrupted pilot of the same study and "
            "seed",
            folder=folder,
            path_name=path.name,
        )
    if not journals(folder):
        raise UserError(
            "--out {folder}: is not empty; expected a new folder or the pilot's own folder",
            folder=folder,
        )


def _entries(folder: Path) -> Iterator[Path]:
    """Yield every entry under a folder, recursively; raise OSError if it is not a folder."""
    for entry in folder.iterdir():
        yield entry
        if entry.is_dir():
            yield from _entries(entry)


def _same(one: RunPlan, other: RunPlan) -> bool:
    """Return whether two plans belong to the same pilot, even if the study file has moved."""
    return (one.study_text, one.seed, one.language, one.mode, one.population) == (
        (other.study_text, other.seed, other.language, other.mode, other.population)
    )


def simulated_plate(plan: RunPlan, spec: str = MOCK) -> PlateDriver:
    """Return the simulated plate of a run, in virtual time, with the limits of its plate file."""
    return plate_for(plan, with_plate_file(spec, plan.study.plate.file), VirtualClock())


def run_pilot(
    folder: Path,
    plans: list[RunPlan],
    *,
    spec: str = MOCK,
    contact: ContactSpecs | None = None,
    tell: Callable[[str], None],
) -> None:
    """Carry out the unfinished runs of a pilot, and then build its data set.

    Parameters
    ----------
    folder : Path
        Folder for the pilot's data set; for requirements, see `claim`.
    plans : list of RunPlan
    spec : str
        Plate specification (SPEC) for a mock plate, optionally with simulated faults.
    contact : ContactSpecs, optional
        Simulated finger sensors; those not specified are taken from the study.
    tell : callable
        Called after each run, with the participant's label.
    """
    contact = contact or NOT_NAMED
    if not is_mock(spec):
        raise UserError("--plate {spec}: a pilot runs in virtual time; expected mock", spec=spec)
    check_supported(plans[0], simulated_plate(plans[0], spec), contact)
    check_answered(plans[0])
    require_virtual(contact)
    claim(folder, plans)
    with signals_raise():
        for plan in plans:
            specs = contact.otherwise(simulated(of_study(plan.study)))
            run_simulated(folder, plan, spec, specs)
            tell(plan.participant)
    build_dataset(folder)


def run_simulated(
    folder: Path,
    plan: RunPlan,
    spec: str,
    contact: ContactSpecs | None = None,
    *,
    synced: bool | None = None,
) -> None:
    """Carry out a run with a simulated participant, or resume an interrupted run.

    The plate uses the limits in the study's plate file and reports their source. The study's finger
    sensors are simulated unless other sensors are specified. Participants who drop out answer no
    further questions and do not return for later sessions.

    Parameters
    ----------
    folder : Path
        The data set.
    plan : RunPlan
    spec : str
        SPEC of the plate.
    contact : ContactSpecs, optional
    synced : bool, optional
        Whether each journal record is flushed to disk as it is written. The default is True only if
        the plate's SPEC has options, such as simulated faults.
    """
    if synced is None:
        synced = spec != MOCK
    contact = contact or simulated(of_study(plan.study))
    spec = with_plate_file(_steady(spec, plan), plan.study.plate.file)
    path = plan.journal_path(folder)
    population = (
        Population.model_validate_json(plan.population)
        if plan.population
        else people_for(plan.study)
    )
    plan = replace(plan, population=population.model_dump_json())
    clock = VirtualClock()
    if holds_records(path):
        _, records = read_plan(path)
        if is_complete(records) or gave_up(records):
            return
        clock = VirtualClock(elapsed_s(records))
        opened = Journal.reopen(path, clock, synced=synced)
    else:
        opened = Journal.create(path, clock, private=plan.study.private_files, synced=synced)
    with (
        opened as journal,
        plate_for(plan, spec, clock) as plate,
        ExitStack() as stack,
    ):
        contact = contact.otherwise(simulated(of_plate(plate.plate_file)))
        person = SimulatedParticipant(
            respondent_of(plan, population),
            feel=plate.vibration_level,
            clock=clock,
            frame_s=FRAME_S if contact.used else None,
        )
        if plan.visit and person.respondent.drops_out:
            return
        surroundings = Surroundings(
            clock=clock,
            seed=plan.seed,
            participant=plan.participant,
            finger=person.finger,
            vibration_level=plate.vibration_level,
        )
        run_plan(
            plan,
            Setup(
                plate=plate,
                participant=person,
                journal=journal,
                clock=clock,
                operator=UnattendedOperator(),
                sounds=ImaginedSounds(),
            ),
            spec=spec,
            sources=open_sources(with_stage(contact, plan.study), surroundings, stack),
            steps=person.attend(bounded(plan.steps(), plan)),
        )


def _steady(spec: str, plan: RunPlan) -> str:
    """Limit the noise of a mock plate SPEC without options to the study's tolerance."""
    wanted_um, study = plan.study.plate.tolerance_level, plan.study
    if wanted_um is not None and not study.plate_quantity.in_um_pp:
        # The mock plate converts levels to µm with this factor.
        wanted_um *= PlateLimits().level / study.plate.level
    if spec != MOCK or wanted_um is None or wanted_um * PART_OF_TOLERANCE >= MOCK_NOISE_UM:
        return spec
    return f"{MOCK}:noise={wanted_um * PART_OF_TOLERANCE:g}"


def gave_up(records: list[Record]) -> bool:
    """Return whether a simulated participant dropped out of a run."""
    last = records[-1]
    return last.kind == "stop" and last.data["reason"] == GAVE_UP
