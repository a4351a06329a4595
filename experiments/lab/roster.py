"""Read the participants, the state of each run and the next participant from the journals."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Literal

from slipscale.experiments.dataset.journals import journals
from slipscale.experiments.dataset.withdrawn import replacement, withdrawn
from slipscale.experiments.journal.locks import is_being_written
from slipscale.experiments.journal.plan_and_progress import read_usable
from slipscale.experiments.lab.exclusions import read_exclusions
from slipscale.experiments.running.run_state import RunState, run_state
from slipscale.experiments.study.model import Study
from slipscale.experiments.study.run_plan import RunPlan, journal_path
from slipscale.faults import UserError

PersonState = Literal["running now", "interrupted", "damaged", "returns", "done", "withdrew"]
# A participant's state is the first of these that applies to any of the participant's runs.
PRESSING: tuple[RunState, ...] = ("running now", "damaged", "interrupted")


@dataclass(frozen=True, slots=True, kw_only=True)
class Visit:
    """A participant's run, which may not have begun yet.

    Parameters
    ----------
    started_utc : str
        Start time in ISO 8601; empty before the run has begun.
    planned : bool
        Whether the run is part of the study's plan.
    """

    session: str
    run: str
    path: Path
    state: RunState
    started_utc: str = ""
    planned: bool = True

    def __str__(self) -> str:
        """Return a readable name of the session and run."""
        return f"session {self.session}, run {self.run}" if self.session else f"run {self.run}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Person:
    """A participant in a data set.

    Parameters
    ----------
    state : str
        State of the participant: "returns" means that a planned run has not begun, "done" that all
        runs are complete.
    place : int or None
        Position in the counterbalancing, from 1; None for a participant who withdrew.
    order : tuple of str
        The tasks in the order of the participant's first run.
    excluded : tuple of str
        Exclusion rules of the study that applied to the participant in the last analysis.
    """

    label: str
    state: PersonState
    place: int | None = None
    order: tuple[str, ...] = ()
    excluded: tuple[str, ...] = ()
    visits: tuple[Visit, ...] = ()

    @property
    def next_visit(self) -> Visit | None:
        """The first planned run that has not begun."""
        return next((visit for visit in self.visits if visit.state == "free"), None)

    @property
    def last_begun(self) -> Visit | None:
        """The run that began most recently."""
        begun = [visit for visit in self.visits if visit.started_utc]
        return max(begun, key=lambda visit: visit.started_utc, default=None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Roster:
    """The participants in a data set, and the next new participant.

    Parameters
    ----------
    planned : int
        Planned number of participants.
    new : str or None
        Label of the next new participant; None once all planned participants have begun.
    exclusions : tuple of str
        The study's exclusion rules, which are applied in the analysis.
    analysed_utc : str
        Time of the last analysis in ISO 8601; empty if there is none.
    """

    people: tuple[Person, ...]
    planned: int
    new: str | None
    exclusions: tuple[str, ...] = ()
    analysed_utc: str = ""

    def of(self, state: PersonState) -> list[Person]:
        """Return all participants in a given state."""
        return [person for person in self.people if person.state == state]

    def person(self, label: str) -> Person | None:
        """Return the participant with this label; None if there is none."""
        return next((person for person in self.people if person.label == label), None)

    @property
    def excluded(self) -> list[Person]:
        """Return the participants whom the last analysis excluded."""
        return [person for person in self.people if person.excluded]

    @property
    def running(self) -> Visit | None:
        """The run in progress, if any."""
        visits = (visit for person in self.people for visit in person.visits)
        return next((visit for visit in visits if visit.state == "running now"), None)


def read_roster(dataset: Path, study: Study, study_text: str) -> Roster:
    """Return the participants of a data set.

    Raises
    ------
    UserError
        If the list of withdrawn participants cannot be read.
    """
    withdrawn_people = withdrawn(dataset)
    begun: dict[str, list[Path]] = {}
    for path in journals(dataset):
        begun.setdefault(path.parent.name.removeprefix("sub-"), []).append(path)
    people = [_person(dataset, study, study_text, label, paths) for label, paths in begun.items()]
    people = [person for person in people if person.visits and person.label not in withdrawn_people]
    people += [Person(label=label, state="withdrew") for label in withdrawn_people]
    found = read_exclusions(dataset)
    people = [replace(each, excluded=found.flags.get(each.label, ())) for each in people]
    people.sort(key=lambda person: (_number(person.label), person.label))
    return Roster(
        people=tuple(people),
        planned=study.participants,
        new=_next_label([person.label for person in people], withdrawn_people, study.participants),
        exclusions=study.analysis.exclusions,
        analysed_utc=found.analysed_utc,
    )


def _person(dataset: Path, study: Study, study_text: str, label: str, paths: list[Path]) -> Person:
    """Return a participant with all planned and additional runs."""
    plans = [
        RunPlan(
            study_name=study.name,
            study_text=study_text,
            participant=label,
            session=session,
            run=f"{run:02d}",
            seed=study.seed,
            language=study.language,
            mode="participant",
        )
        for session in study.sessions or ("",)
        for run in range(1, study.runs + 1)
    ]
    planned = [
        _visit(journal_path(dataset, participant=label, session=plan.session, run=plan.run), plan)
        for plan in plans
    ]
    known = {visit.path for visit in planned}
    others = [_visit(path, None) for path in paths if path not in known]
    visits = (*planned, *(visit for visit in others if visit.state != "free"))
    if all(visit.state == "free" for visit in visits):
        return Person(label=label, state="returns")
    return Person(
        label=label,
        state=_state(visits),
        place=plans[0].row + 1,
        order=tuple(protocol.task for protocol, _ in plans[0].tasks()),
        visits=visits,
    )


def _state(visits: tuple[Visit, ...]) -> PersonState:
    states = {visit.state for visit in visits}
    for state in PRESSING:
        if state in states:
            return state  # type: ignore[return-value]  # PRESSING are both kinds of state
    return "returns" if "free" in states else "done"


def _visit(path: Path, plan: RunPlan | None) -> Visit:
    session, run, started_utc = _header(path)
    return Visit(
        session=plan.session if plan else session,
        run=plan.run if plan else run,
        path=path,
        state=_known_state(path),
        started_utc=started_utc,
        planned=plan is not None,
    )


def _header(path: Path) -> tuple[str, str, str]:
    """Return the session, run and start time in a journal; empty if the header is unreadable."""
    try:
        stat = path.stat()
        return _read_header(path, stat.st_ino)
    except (OSError, UserError):
        return "", "", ""


@lru_cache(maxsize=4096)
def _read_header(path: Path, _inode: int) -> tuple[str, str, str]:
    plan, reading = read_usable(path, most=1)
    if plan is None:
        raise UserError(
            "{path}: no header", path=path
        )  # not cached: the file may still be incomplete
    return plan.session, plan.run, str(reading.records[0].data["started_utc"])


def _known_state(path: Path) -> RunState:
    """Return the state of a run; a journal is read again only if it has changed."""
    if is_being_written(path):
        return "running now"
    try:
        stat = path.stat()
    except OSError:
        return "free"
    try:
        return _read_state(path, stat.st_ino, stat.st_mtime_ns, stat.st_size)
    except UserError:
        return "damaged"


@lru_cache(maxsize=4096)
def _read_state(path: Path, _inode: int, _changed_ns: int, _size: int) -> RunState:
    return run_state(path)


def _number(label: str) -> int:
    found = re.search(r"[0-9]{1,18}$", label)
    return int(found[0]) if found else 0


def _next_label(labels: list[str], gone: list[str], planned: int) -> str | None:
    """Return the label for the next new participant; None if no further participant is planned.

    Withdrawn participants are replaced first. Other labels follow the pattern of the existing
    labels: P01 and P02 are followed by P03.
    """
    for label in gone:
        if (instead := replacement(label)) not in labels:
            return instead
    plain = [label for label in labels if not label.startswith(replacement("")) or label in gone]
    shapes = {re.sub(r"[0-9]+$", "", label) for label in plain}
    prefix = shapes.pop() if len(shapes) == 1 else ""
    width = max((len(label) - len(prefix) for label in plain), default=len(str(planned)))
    taken = {_number(label) for label in labels}
    number = next((n for n in range(1, planned + 1) if n not in taken), None)
    return None if number is None else f"{prefix}{number:0{max(width, 2)}d}"
