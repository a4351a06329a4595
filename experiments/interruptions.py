"""What comes between a session's steps: the operator's wishes, and the rig's faults.

It knows neither the protocol nor its steps: only that something is under way which may have to
be begun again once the pause is over or the rig is mended.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from experiments.participants.base import StopRequested
from experiments.steps import Voided
from hardware.driver import PlateFault

if TYPE_CHECKING:
    from collections.abc import Callable

    from experiments.journal import Journal, Record
    from experiments.noise import Noise
    from experiments.operator import Operator, State
    from experiments.participants.base import Participant
    from experiments.progress import Progress
    from experiments.stage import Stage
    from experiments.steps import Answer
    from hardware.clock import Clock
    from hardware.driver import PlateDriver

RECONNECT_WAIT_S = 0.5


class _Paused(Exception):
    """The operator asked for a pause in the middle of a step."""


class Interruptions:
    """Looks after the operator and the rig while a session's steps are carried out.

    Parameters
    ----------
    plate, stage, participant, journal, clock, operator, noise, progress
        The session's.
    hold_text : str
        Asks the participant to wait.
    unblind : bool
        Whether the operator is told the amplitude.
    """

    def __init__(
        self,
        *,
        plate: PlateDriver,
        stage: Stage,
        participant: Participant,
        journal: Journal,
        clock: Clock,
        operator: Operator,
        noise: Noise,
        progress: Progress,
        hold_text: str,
        unblind: bool,
    ) -> None:
        self._plate = plate
        self._stage = stage
        self._participant = participant
        self._journal = journal
        self._clock = clock
        self._operator = operator
        self._noise = noise
        self._progress = progress
        self._hold_text = hold_text
        self._unblind = unblind
        self._voids = _unheard_voids(journal.records)

    def attempt(self, action: Callable[[], Answer]) -> Answer:
        """Do something until neither a fault nor a pause comes between."""
        paused = False
        while True:
            try:
                if paused:
                    self._hold()
                    paused = False
                return action()
            except PlateFault as fault:
                self._recover(fault)
            except _Paused:
                paused = True

    def watch(self) -> None:
        """Look after the plate and the operator: runs at every frame of a participant's step."""
        self._stage.check()
        self.watch_operator()

    def watch_operator(self) -> None:
        """Do what the operator asks for, if anything."""
        request = self._operator.poll()
        if request is None:
            return
        if request.what == "void":
            self._void(request.reason)
        elif request.what == "pause":
            raise _Paused
        elif request.what == "stop":
            raise StopRequested("asked by the operator")

    def heard(self) -> Voided:
        """Return which trials were voided since this was last asked."""
        voided, self._voids = Voided(trials=tuple(self._voids)), []
        return voided

    def _void(self, reason: str) -> None:
        """Void the trial in progress, or the last one while the next is not yet presented."""
        trial = self._progress.trial
        refusal = self._refusal()
        if trial is None or refusal:
            self._progress.say(refusal)
            return
        self._journal.write("void", task=trial.task, trial=trial.number, reason=reason)
        self._voids.append(trial.number)
        self._progress.void()
        self._progress.say(f"trial {trial.number} will be repeated")

    def _refusal(self) -> str:
        """Return why no trial can be voided now; empty where one can."""
        trial = self._progress.trial
        if trial is None:
            return "no trial to void yet"
        if self._progress.over and trial.number >= trial.total:
            return "the task is over: its last trial can no longer be repeated"
        voided = [r.data for r in self._journal.records if r.kind == "void"]
        if any((v["task"], v["trial"]) == (trial.task, trial.number) for v in voided):
            return f"trial {trial.number} is voided already"
        return ""

    def _hold(self) -> None:
        """Pause: silence, wait for the operator, let the step begin anew."""
        self._stage.interrupt()
        self._plate.silence()
        self._journal.write("pause")
        self._wait_for("paused", "go_on")
        self._journal.write("go_on")

    def _recover(self, fault: PlateFault) -> None:
        """Silence, write down, ask whether to retry, reconnect."""
        self._stage.quieten()
        while True:
            self._progress.fault()
            self._journal.write("fault", code=fault.code, message=fault.message)
            self._plate.close()
            self._clock.sleep(RECONNECT_WAIT_S)
            told = fault if self._unblind else fault.blinded()
            try:
                self._wait_for("fault", "retry", str(told))
            except StopRequested:
                raise told from None
            try:
                self._plate.connect()
            except PlateFault as again:
                fault = again
            else:
                return

    def _wait_for(self, state: State, wanted: str, message: str = "") -> None:
        """Have the participant wait until the operator says what is wanted, or stops."""
        self._noise.stop()
        self._progress.tell(state, message=message)

        def answered() -> bool:
            request = self._operator.poll()
            if request is not None and request.what == "stop":
                raise StopRequested("asked by the operator")
            if request is not None and request.what == "void":
                self._void(request.reason)
            return request is not None and request.what == wanted

        if not answered():
            self._participant.hold(self._hold_text, answered)


def _unheard_voids(records: list[Record]) -> list[int]:
    """Return the trials voided that the protocol has not been told of."""
    waiting: list[int] = []
    for record in records:
        if record.kind == "void":
            waiting.append(record.data["trial"])
        elif record.kind == "done" and (record.data["answer"] or {}).get("type") == "Voided":
            waiting = []
    return waiting
