"""The mailbox of a running session, which publishes its status and receives requests.

The mailbox is a folder next to the run's journal that only its owner can access. The session writes
``status.json`` there and reads the request files that other processes (a second terminal, the
console) put there. The session and the console never wait for each other, so a missing or crashed
console does not affect the session. The session deletes the folder when it ends; the next session
removes the remains of a crashed session.
"""

from __future__ import annotations

import os
import secrets
import shutil
import time
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PlainSerializer,
    PlainValidator,
    ValidationError,
)

from slipscale.experiments.journal.locks import writer
from slipscale.experiments.session.operator import Request, SessionStatus, State, answer_wanted
from slipscale.experiments.steps.steps import Ask
from slipscale.experiments.steps.trial import Trial
from slipscale.faults import UserError
from slipscale.faults.frozen_table import FrozenTable
from slipscale.faults.message import as_data, from_data

# Minimum interval between two reads of the folder, because reading can be slow.
LOOK_S = 0.05
# The session updates the modification time of its requests folder at this interval, to show that it
# is alive.
BEAT_S = 1.0
LONGEST_REQUEST = 20_000
STATUS, REQUESTS = "status.json", "requests"

Asked = Literal["pause", "go_on", "void", "ask_again", "retry", "stop", "note", "answer", "unblind"]


class TrialName(FrozenTable):
    """The name of a trial; trials are numbered from 1 within each task."""

    task: str
    number: int


# Text that is stored with its template and values, so that the console can translate it.
Shown = Annotated[str, PlainValidator(from_data), PlainSerializer(as_data)]


class LiveStatus(BaseModel):
    """The published status of a session; `SessionStatus` and `Mailbox` describe its fields."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    token: str
    process: int
    heading: tuple[Shown, ...]
    state: State
    task: str
    trial: int
    total: int
    voidable: TrialName | None
    answered: TrialName | None
    asked: tuple[str, ...]
    answering: str = ""
    done: int
    planned: int
    elapsed_s: float
    time_left_s: float | None
    faults: int
    voided: int
    noise: str
    plate: str
    temperature_c: float | None = None
    message: Shown
    level: Shown | None
    unblinded: bool = False
    warnings: tuple[Shown, ...] = ()
    refused: Shown


class LiveRequest(FrozenTable):
    """A request from another process. Only the session with the same ``token`` carries it out."""

    token: str
    what: Asked
    reason: Annotated[str, Field(max_length=2000)] = ""
    trial: TrialName | None = None
    question: str = ""


def mailbox_of(journal: Path) -> Path:
    """Return the path of a run's mailbox."""
    return journal.with_name(f"{journal.name}.live")


class Mailbox:
    """An operator that relays requests from other processes to the session.

    Parameters
    ----------
    folder : Path
        See `mailbox_of`.
    heading : tuple of str
        Describes the session: participant, study, plate.
    """

    busy = False

    def __init__(self, folder: Path, heading: tuple[str, ...]) -> None:
        self._folder = folder
        self._heading = heading
        self._token = secrets.token_hex(8)
        self._status = SessionStatus(state="showing")
        self._refused = ""
        self._looked_s = self._beat_s = 0.0
        self._open = False

    def tell(self, status: SessionStatus) -> None:
        """Write the state to the mailbox."""
        self._status = status
        if self._open:
            # A lost status is harmless; a full disk is reported when the journal is written.
            with suppress(OSError):
                _write(self._folder / STATUS, self._told().model_dump_json())

    def poll(self) -> Request | None:
        """Return the next request from another process, or None."""
        now_s = time.monotonic()
        if not self._open or now_s - self._looked_s < LOOK_S:
            return None
        self._looked_s = now_s
        with suppress(OSError):
            if now_s - self._beat_s >= BEAT_S:
                self._beat_s = now_s
                os.utime(self._folder / REQUESTS)
            for path in sorted((self._folder / REQUESTS).glob("*.json")):
                text = path.read_bytes()[:LONGEST_REQUEST]
                path.unlink()
                if request := self._request(text):
                    return request
        return None

    def _request(self, text: bytes) -> Request | None:
        """Return the request in a file, or None after storing the reason for refusing it."""
        try:
            request = LiveRequest.model_validate_json(text)
        except ValidationError:
            return None  # an incomplete file, or a file from another program
        if request.token != self._token:
            return None  # a request to an earlier session
        trial = self._trial(request.trial)
        question = self._question(request.question)
        if request.what == "void" and trial is None:
            self._refuse("that trial can no longer be voided")
        elif request.what == "answer" and not self._waits_for(request.trial):
            self._refuse("that question is over")
        elif request.what == "ask_again" and question is None:
            self._refuse("that question was not asked in this run")
        else:
            self._refused = ""
            return Request(what=request.what, reason=request.reason, trial=trial, question=question)
        return None

    def _waits_for(self, wanted: TrialName | None) -> bool:
        """Return whether the session is waiting for the operator's answer in this trial."""
        status = self._status
        now = TrialName(task=status.task, number=status.trial)
        return status.answering is not None and wanted == now

    def _trial(self, wanted: TrialName | None) -> Trial | None:
        """Return the named trial, or None if the session has moved past it."""
        known = (self._status.voidable, self._status.answered)
        return next((trial for trial in known if trial and wanted == _name(trial)), None)

    def _question(self, name: str) -> Ask | None:
        return next((ask for ask in self._status.asked if ask.name == name), None)

    def _refuse(self, sentence: str) -> None:
        self._refused = sentence
        self.tell(self._status)

    def _told(self) -> LiveStatus:
        status = self._status
        return LiveStatus(
            token=self._token,
            process=os.getpid(),
            heading=self._heading,
            state=status.state,
            task=status.task,
            trial=status.trial,
            total=status.total,
            voidable=_name(status.voidable),
            answered=_name(status.answered),
            asked=tuple(ask.name for ask in status.asked),
            answering=answer_wanted(status.answering) if status.answering else "",
            done=status.done,
            planned=status.planned,
            elapsed_s=status.elapsed_s,
            time_left_s=status.time_left_s,
            faults=status.faults,
            voided=status.voided,
            noise=status.noise,
            plate=status.plate,
            temperature_c=status.temperature_c,
            message=status.message,
            level=status.level,
            unblinded=status.unblinded,
            warnings=status.warnings,
            refused=self._refused,
        )

    def move(self, folder: Path) -> None:
        """Move to a new folder after the journal's folder has become unavailable."""
        shutil.rmtree(self._folder, ignore_errors=True)
        self._folder = folder
        self.__enter__()

    def __enter__(self) -> Self:
        # Only the owner has access, because anyone who can write a request could stop the session.
        # The session continues even if the mailbox cannot be created.
        with suppress(OSError):
            if self._folder.is_symlink():
                self._folder.unlink()
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder.mkdir(mode=0o700)
            (self._folder / REQUESTS).mkdir(mode=0o700)
            self._open = True
        self.tell(self._status)
        return self

    def __exit__(self, *_error: object) -> None:
        self._open = False
        shutil.rmtree(self._folder, ignore_errors=True)


def read_status(journal: Path) -> LiveStatus | None:
    """Return the status that a journal's session has published, or None if there is none.

    A status left behind by a crashed session is ignored once another process writes to the
    journal.
    """
    try:
        status = LiveStatus.model_validate_json((mailbox_of(journal) / STATUS).read_bytes())
    except (OSError, ValidationError):
        return None
    holder = writer(journal)
    return None if holder and holder.process != status.process else status


def beat_ns(journal: Path) -> int | None:
    """Return when the session last updated its mailbox, in ns; None if there is no mailbox."""
    try:
        return (mailbox_of(journal) / REQUESTS).stat().st_mtime_ns
    except OSError:
        return None


def post(journal: Path, request: LiveRequest) -> None:
    """Add a request to a session's mailbox.

    Raises
    ------
    UserError
        If there is no mailbox, because the session has ended or never had one.
    """
    folder = mailbox_of(journal) / REQUESTS
    try:
        # Names sort by time; the random part separates simultaneous requests.
        _write(folder / f"{time.time_ns()}-{secrets.token_hex(4)}.json", request.model_dump_json())
    except OSError:
        raise UserError(
            "{journal_name}: no session of this run is accepting requests",
            journal_name=journal.name,
        ) from None


def _write(path: Path, text: str) -> None:
    """Write a small file atomically, without flushing it to disk."""
    draft = path.with_name(f".{path.name}.tmp")
    draft.write_text(text, encoding="utf-8")
    os.replace(draft, path)  # noqa: PTH105 - Path.replace is the same call


def _name(trial: Trial | None) -> TrialName | None:
    return TrialName(task=trial.task, number=trial.number) if trial else None
