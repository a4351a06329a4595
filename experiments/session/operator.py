"""The operator of a session: what they are told, and what they may ask for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol

from slipscale.experiments.protocols.steps import ChoiceQuestion

if TYPE_CHECKING:
    from slipscale.experiments.protocols.steps import Ask, Trial
    from slipscale.experiments.session.masking_noise import NoiseState
    from slipscale.experiments.session.surface_state import PlateState

State = Literal["showing", "presenting", "waiting", "paused", "fault", "done"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionStatus:
    """The state of a session. It holds an amplitude only where the session was told to unblind.

    Parameters
    ----------
    state : str
        "showing" a screen, "presenting" a surface, "waiting" for the participant, "paused",
        "fault" (the rig failed: retry or stop?), "done".
    task : str
        The task's label.
    trial, total : int
        Trial k of n within the task; 0 before the first.
    voidable : Trial or None
        The trial that would be voided now: the one in progress, or the last.
    answered : Trial or None
        The trial before the one in progress: it can be voided too (a slip of the finger is seen
        when the answer is given, and the next surface is there already).
    asked : tuple of Ask
        The questions about the run and the participant so far: each can be asked again.
    answering : Ask or None
        The question that the operator answers now: what the participant says, or a decision.
    done, planned : int
        Trials over and planned in the whole session.
    elapsed_s : float
        Time since the session began (or was resumed), without faults and pauses.
    time_left_s : float or None
        At the pace so far, faults and pauses left out; None before the first trial is over.
    faults, voided : int
        How many so far.
    noise : str
        Whether the masking noise is "playing", "silent" or "absent".
    plate : str
        What the plate does by its own reading: "silent", "as commanded", "not measured" (it has no
        sensor, or none that answered), "lost".
    temperature_c : float or None
        The plate's, by its last reading; None where it tells none.
    message : str
        A fault's or a refusal's sentence.
    level : str or None
        The wanted level with its unit; only unblinded.
    unblinded : bool
        Whether the operator is told amplitudes.
    warnings : tuple of str
        What went wrong around the session and lasts: no backup, a journal that has gone.
    """

    state: State
    task: str = ""
    trial: int = 0
    total: int = 0
    voidable: Trial | None = None
    answered: Trial | None = None
    asked: tuple[Ask, ...] = ()
    answering: Ask | None = None
    done: int = 0
    planned: int = 0
    elapsed_s: float = 0.0
    time_left_s: float | None = None
    faults: int = 0
    voided: int = 0
    noise: NoiseState = "absent"
    plate: PlateState = "silent"
    temperature_c: float | None = None
    message: str = ""
    warnings: tuple[str, ...] = ()
    level: str | None = None
    unblinded: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """What the operator asks for: to pause or go on, void a trial, ask again, retry, or stop.

    "note" has the session write the operator's words, ``reason``, into the journal. "unblind" has
    it tell the amplitude from then on, which is written into the journal too.
    "answer" hands in what they typed, ``reason``, as the answer to `SessionStatus.answering`.

    ``trial`` is the one to be voided, None the one that is `SessionStatus.voidable` now: while a
    reason is typed the session may have come to the next. ``question`` is the one to be asked
    again, of `SessionStatus.asked`.
    """

    what: Literal[
        "pause", "go_on", "void", "ask_again", "retry", "stop", "note", "answer", "unblind"
    ]
    reason: str = ""
    trial: Trial | None = None
    question: Ask | None = None


class Operator(Protocol):
    """The operator's interface to a session."""

    @property
    def busy(self) -> bool:
        """Whether a request is being typed: the end of a task waits for it."""

    def tell(self, status: SessionStatus) -> None:
        """Show the state."""

    def poll(self) -> Request | None:
        """Return what the operator asks for now, if anything. Never waits."""


def answer_wanted(ask: Ask) -> str:
    """Return a question that the operator answers, with the numbers of its answers if it has some.

    >>> from slipscale.experiments.protocols.steps import Ask, ChoiceQuestion
    >>> options = (("again", "test again"), ("on", "go on"))
    >>> answer_wanted(Ask(name="x", question=ChoiceQuestion(prompt="Failed.", options=options)))
    'Failed. 1 test again, 2 go on'
    """
    question = ask.question
    if not isinstance(question, ChoiceQuestion):
        return question.prompt
    listed = ", ".join(f"{n} {words}" for n, (_, words) in enumerate(question.options, start=1))
    return f"{question.prompt} {listed}"


class Operators:
    """Several operators of one session: all are told, and the first who asks is heard."""

    def __init__(self, *operators: Operator) -> None:
        self._operators = operators

    @property
    def busy(self) -> bool:
        """Whether one of them types a request."""
        return any(operator.busy for operator in self._operators)

    def tell(self, status: SessionStatus) -> None:
        """Show all of them the state."""
        for operator in self._operators:
            operator.tell(status)

    def poll(self) -> Request | None:
        """Return what one of them asks for."""
        return next((asked for each in self._operators if (asked := each.poll())), None)


class UnattendedOperator:
    """Nobody is there: a fault is retried a few times, then the session stops."""

    def __init__(self, retries: int = 3) -> None:
        self._retries = retries
        self._asked = 0
        self._state: State = "showing"

    @property
    def busy(self) -> bool:
        """Never."""
        return False

    def tell(self, status: SessionStatus) -> None:
        """Note the state."""
        self._state = status.state

    def poll(self) -> Request | None:
        """Retry after a fault, so many times in a session."""
        if self._state != "fault":
            return None
        self._asked += 1
        return Request(what="retry" if self._asked <= self._retries else "stop")
