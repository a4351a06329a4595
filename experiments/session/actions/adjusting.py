"""Let the participant adjust a surface, and record every intermediate amplitude."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from slipscale.experiments.journal.serialisation import answer_record
from slipscale.experiments.session.markers import Event
from slipscale.experiments.steps.replies import FEEL_AGAIN, Adjusted, Reply
from slipscale.experiments.steps.rounding import DECIMALS
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.experiments.participants.base import Turn, Watch
    from slipscale.experiments.session.parts import Parts
    from slipscale.experiments.steps.steps import Adjust, Explore, Present


@dataclass(frozen=True, slots=True, kw_only=True)
class Adjusting:
    """Carries out `Adjust` steps.

    Parameters
    ----------
    parts : Parts
        Components that the session's actions share.
    watch : callable
        Called in every frame to check the plate and the operator.
    wait : callable
        Shows the operator that the session is waiting for the participant.
    """

    parts: Parts
    watch: Watch
    wait: Callable[[], None]

    def adjust(self, step: Adjust) -> Adjusted:
        """Let the participant adjust the surface, and record every intermediate amplitude."""
        start = self.parts.surface.wanted
        if start is None:
            raise ValueError("there is no surface to adjust, because none was presented")
        began_s = self.parts.clock.now()
        trace = [(0.0, start.level)]
        again_s: list[float] = []

        def since_s() -> float:
            return round(self.parts.clock.now() - began_s, DECIMALS)

        def turn(notches: int) -> None:
            aim_level = step.turned_level(trace[-1][1], notches)
            if aim_level != trace[-1][1]:
                self.parts.surface.turn(start.turned(aim_level))
                trace.append((since_s(), aim_level))

        try:
            reply = self._turned(step, turn, lambda: again_s.append(since_s()))
            readback_level = self.parts.surface.read_back_level()
        except UserError:
            raise  # usually the journal itself failed, so nothing can be recorded
        except BaseException:
            # The interrupted adjustment is recorded but never used, because the adjustment starts
            # again.
            self.parts.journal.write("discarded", name=step.name, answer={"trace": trace})
            raise
        self.parts.markers.mark(Event.ANSWER, step)
        self.parts.surface.adjusted(start.turned(trace[-1][1]))
        return Adjusted(
            value=trace[-1][1],
            onset_s=reply.onset_s,
            response_time_s=reply.response_time_s,
            time_source=reply.time_source,
            timed_out=reply.timed_out,
            readback_level=readback_level,
            trace=tuple(trace),
            again_s=tuple(again_s),
        )

    def _turned(self, step: Adjust, turn: Turn, asked: Callable[[], None]) -> Reply:
        """Let the participant adjust the surface, and present the reference again on request.

        The time limit applies only to the time spent adjusting. The response time is measured from
        the first adjustment screen to the last key press.
        """
        reply = first = self.parts.participant.adjust(step, turn, self.watch)
        left, count = step, 0
        while step.again is not None and reply.value == FEEL_AGAIN:
            count += 1
            asked()
            self._feel_again(*step.again)
            left = left.with_less_time(reply.response_time_s or 0.0)
            reply = self.parts.participant.adjust(left, turn, self.watch, again=count)
        if not count or reply.response_time_s is None:
            return replace(reply, onset_s=first.onset_s)
        took_s = reply.onset_s + reply.response_time_s - first.onset_s
        return replace(reply, onset_s=first.onset_s, response_time_s=took_s)

    def _feel_again(self, reference: Present, explore: Explore) -> None:
        """Present the reference again during an adjustment, and record the presentation."""
        self.parts.progress.tell("presenting")
        self.parts.markers.mark(Event.ONSET, reference)
        made = self.parts.surface.feel_again(reference, explore)
        self.parts.markers.mark(Event.SETTLED, reference)
        trial = reference.trial.number if reference.trial else None
        self.parts.journal.append("felt_again", trial=trial, answer=answer_record(made))
        self.wait()
