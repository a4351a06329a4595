"""Begin, resume and control sessions, acknowledge warnings, and run the checklist."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from slipscale.experiments.lab.console.actions.data import check_meant
from slipscale.experiments.lab.console.actions.desk import Actions, Desk
from slipscale.experiments.lab.console.actions.forms import Form, Label, Nothing, Words
from slipscale.experiments.lab.roster import Person
from slipscale.experiments.session.mailbox import LiveRequest, TrialName, post
from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.hardware.address import is_mock


class Begin(Form):
    """Begin a session with the participant whom the console page showed as next."""

    participant: Label
    pilot: bool = False


class Resume(Form):
    """Resume an interrupted run."""

    participant: Label
    session: Annotated[str, Field(pattern="^[A-Za-z0-9]{0,40}$")]
    run: Label
    pilot: bool = False


class Ask(Form):
    """Send a request to the running session, as with the keys in the operator's terminal."""

    token: Annotated[str, Field(pattern="^[0-9a-f]{1,64}$")]
    what: Literal[
        "pause", "go_on", "void", "ask_again", "retry", "stop", "note", "answer", "unblind"
    ]
    reason: Words = ""
    word: Words = ""
    task: Annotated[str, Field(max_length=100)] = ""
    trial: Annotated[int, Field(ge=0)] = 0
    question: Annotated[str, Field(max_length=100)] = ""


class Acknowledge(Form):
    """Acknowledge a session's warning."""

    session: str
    sentence: str


def _begin(desk: Desk, request: Begin) -> str:
    found = desk.free()
    roster = found.rehearsals if request.pilot else found.roster
    person = roster.person(request.participant) if roster else None
    new = roster is not None and request.participant == roster.new
    if not new and not (person and person.next_visit):
        raise UserError(
            "participant {participant} is no longer next; check the table again",
            participant=request.participant,
        )
    if is_mock(found.defaults.plate) and not request.pilot:
        raise UserError(
            "plate '{plate}' is simulated; participants cannot feel it. Set the real plate in "
            "slipscale.toml, or begin a rehearsal",
            plate=found.defaults.plate,
        )
    pilot = ("--pilot",) if request.pilot else ()
    about = Message("participant {participant}", participant=request.participant)
    desk.jobs.start("session", about, "next", "--yes", "--participant", request.participant, *pilot)
    return Message("{about}: starting the session", about=about)


def _resume(desk: Desk, request: Resume) -> str:
    found = desk.free()
    roster = found.rehearsals if request.pilot else found.roster
    person: Person | None = roster.person(request.participant) if roster else None
    run = (request.session, request.run, "interrupted")
    for visit in person.visits if person else ():
        if (visit.session, visit.run, visit.state) == run:
            about = Message("participant {participant}", participant=request.participant)
            desk.jobs.start("session", about, "resume", str(visit.path))
            return Message("{about}: resuming the session", about=about)
    raise UserError(
        "the requested run of participant {participant} is not interrupted; check the table again",
        participant=request.participant,
    )


def _ask(desk: Desk, request: Ask) -> str:
    live = desk.now().live
    if live is None or live.status is None or live.status.token != request.token:
        raise UserError("that session is over")
    if request.what in ("void", "note", "answer") and not request.reason.strip():
        raise UserError("expected a text: a reason, a note, or the answer")
    if request.what == "unblind":
        check_meant(request.word)
    about_trial = request.what in ("void", "answer")
    trial = TrialName(task=request.task, number=request.trial) if about_trial else None
    post(
        live.visit.path,
        LiveRequest(
            token=request.token,
            what=request.what,
            reason=request.reason.strip(),
            trial=trial,
            question=request.question,
        ),
    )
    return Message("request sent to the session: {what}", what=request.what.replace("_", " "))


def _acknowledge(desk: Desk, request: Acknowledge) -> str:
    desk.warnings.acknowledge(request.session, request.sentence)
    return ""


def _check(desk: Desk, _: Nothing) -> str:
    desk.free()
    desk.jobs.start("check", "the checklist", "check", "--json")
    return "checking"


ACTIONS: Actions = {
    "begin": (Begin, _begin),
    "resume": (Resume, _resume),
    "ask": (Ask, _ask),
    "acknowledge": (Acknowledge, _acknowledge),
    "check": (Nothing, _check),
}
