"""The operator of a session: the status shown to operators, and the requests they can make."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol

if TYPE_CHECKING:
    from slipscale.experiments.session.sound.masking_noise import NoiseState
    from slipscale.experiments.session.surface_state import PlateState
    from slipscale.experiments.steps.steps import Ask
    from slipscale.experiments.steps.trial import Trial

State = Literal["showing", "presenting", "waiting", "paused", "fault", "done"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionStatus:
    """The state of a session. The amplitude is included only if the session is unblinded.

    Parameters
    ----------
    state : str
        "showing" a screen, "presenting" a surface, "waiting" for the participant, "paused",
        "fault" (the rig failed: retry or stop?), "done".
    task : str
        The task label.
    trial, total : int
        Number of the current trial, and number of trials in the task; 0 before the first trial.
    voidable : Trial or None
        Trial that is voided unless the operator names another: the current or the last trial.
    answered : Trial or None
        The trial before the current trial. This earlier trial can also be voided, because a slip of
        the finger is often noticed only when the next surface has been presented.
    asked : tuple of Ask
        Questions asked so far about the run and the participant; all of them can be repeated.
    answering : Ask or None
        The question awaiting the operator's answer (a verbal report or a decision).
    done, planned : int
        Number of finished and planned trials in the whole session.
    elapsed_s : float
        Time since the session began (or was resumed), excluding faults and pauses.
    time_left_s : float or None
        Estimated remaining time, based on the pace so far (excluding faults and pauses); None
        before the end of the first trial.
    faults, voided : int
        Number of faults and voided trials so far.
    noise : str
        Whether the masking noise is "playing", "silent" or "absent".
    plate : str
        State of the plate according to its readback: "silent", "as commanded", "not measured" (no
        sensor, or no response from it) or "lost".
    temperature_c : float or None
        The plate's last temperature reading; None if the plate does not report its temperature.
    message : str
        A description of the fault, or the reason for refusing a request.
    code : str
        The fault's code (`PlateFault.code`) in the state "fault", otherwise empty.
    level : str or None
        Commanded level with its unit; None if the operator is blinded.
    unblinded : bool
        Whether the operator sees amplitudes.
    warnings : tuple of str
        Persistent problems, such as a missing backup or a lost journal.
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
    code: str = ""
    warnings: tuple[str, ...] = ()
    level: str | None = None
    unblinded: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """An operator request: pause, resume, void a trial, repeat a question, retry or stop.

    Parameters
    ----------
    what : str
        Kind of request. A "note" is a comment (``reason``) for the journal. The request "unblind"
        shows the amplitude from now on; the journal records this. The request "answer" answers
        the question `SessionStatus.answering` with the text in ``reason``.
    reason : str
        The text that the operator typed.
    trial : Trial or None
        The trial to void; None selects `SessionStatus.voidable`. Naming the trial is safer, because
        the session may reach the next trial while the operator types a reason.
    question : Ask or None
        The question to repeat, from `SessionStatus.asked`.
    """

    what: Literal[
        "pause", "go_on", "void", "ask_again", "retry", "stop", "note", "answer", "unblind"
    ]
    reason: str = ""
    trial: Trial | None = None
    question: Ask | None = None


class Operator(Protocol):
    """Common interface for a session's operators."""

    @property
    def busy(self) -> bool:
        """Whether the operator is typing a request. No task ends while the operator is typing."""

    def tell(self, status: SessionStatus) -> None:
        """Show the session's state."""

    def poll(self) -> Request | None:
        """Return the operator's current request, if any. Never waits."""


def answer_wanted(ask: Ask) -> str:
    """Return the question to show to the operator, with numbered options, if any.

    >>> from slipscale.experiments.steps.questions.choice import ChoiceQuestion
    >>> from slipscale.experiments.steps.steps import Ask
    >>> options = (("again", "test again"), ("on", "go on"))
    >>> answer_wanted(Ask(name="x", question=ChoiceQuestion(prompt="Failed.", options=options)))
    'Failed. 1 test again, 2 go on'
    """
    question = ask.question
    listed = ", ".join(f"{n} {words}" for n, words in enumerate(question.listed, start=1))
    return f"{question.prompt} {listed}" if listed else question.prompt


class Operators:
    """Several operators of one session, all of whom see the status and can make requests."""

    def __init__(self, *operators: Operator) -> None:
        self._operators = operators

    @property
    def busy(self) -> bool:
        """Whether an operator is typing a request."""
        return any(operator.busy for operator in self._operators)

    def tell(self, status: SessionStatus) -> None:
        """Show the state to all operators."""
        for operator in self._operators:
            operator.tell(status)

    def poll(self) -> Request | None:
        """Return the first request from any operator; None if there is none."""
        return next((request for each in self._operators if (request := each.poll())), None)


class UnattendedOperator:
    """An operator for unattended runs, who retries a few times after faults and then stops."""

    def __init__(self, retries: int = 3) -> None:
        self._retries = retries
        self._asked = 0
        self._state: State = "showing"

    @property
    def busy(self) -> bool:
        """Always False, because there is no operator who could be typing."""
        return False

    def tell(self, status: SessionStatus) -> None:
        """Store the state."""
        self._state = status.state

    def poll(self) -> Request | None:
        """Retry after a fault, up to ``retries`` times per session; then stop."""
        if self._state != "fault":
            return None
        self._asked += 1
        return Request(what="retry" if self._asked <= self._retries else "stop")
