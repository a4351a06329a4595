"""Let the operator answer questions, by entering verbal reports or making decisions.

The participant's screen shows the question until the operator has answered. The operator's entries
are validated in the same way as a participant's entries.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from slipscale.experiments.languages.texts import ENGLISH, shipped_texts
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.screens.entry import ENTER

if TYPE_CHECKING:
    from slipscale.experiments.participants.base import Participant, Watch
    from slipscale.experiments.session.progress import Progress
    from slipscale.experiments.steps.steps import Ask
    from slipscale.hardware.clock import Clock


class _Given(Exception):
    """Raised to close the participant's screen; carries the operator's answer."""

    def __init__(self, reply: Reply) -> None:
        super().__init__()
        self.reply = reply


class OperatorAnswers:
    """Collects the operator's answers to a session's questions.

    Parameters
    ----------
    progress, clock
        Components of the session.
    """

    def __init__(self, progress: Progress, clock: Clock) -> None:
        self._progress = progress
        self._clock = clock
        self._question: Ask | None = None
        self._rejected: list[str] = []

    def await_answer(self, step: Ask, participant: Participant, watch: Watch) -> Reply:
        """Wait for the operator's answer. Simulated participants answer without an operator."""
        self._question, self._rejected = step, []
        self._progress.asks_operator(step)
        onset_s = self._clock.now()
        try:
            return participant.perform(step, watch)
        except _Given as given:
            return replace(
                given.reply,
                onset_s=onset_s,
                response_time_s=self._clock.now() - onset_s,
                time_source="operator",
                rejected=tuple(self._rejected),
            )
        finally:
            self._question = None
            self._progress.asks_operator(None)

    def take(self, typed: str) -> None:
        """Accept the operator's entry as the answer, or show why the entry is invalid."""
        if self._question is None:
            self._progress.say("no question is currently open")
            return
        texts = shipped_texts(ENGLISH)  # the operator's language is English
        entry = self._question.question.entry(texts)
        line = typed.strip()
        # An answer of a single key must be the whole line, so that "12" is not taken for "1".
        for character in (line,) if entry.single_key else (*line, ENTER):
            verdict = entry.press(character)
            if isinstance(verdict, Reply):
                raise _Given(verdict)
            if verdict:
                self._rejected.append(typed)
                self._progress.say(texts[verdict.reason].format(**verdict.blanks))
                return
