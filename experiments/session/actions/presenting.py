"""Present surfaces, and restore a lost surface before a step that requires it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from slipscale.experiments.journal.serialisation import answer_record
from slipscale.experiments.session.markers import Event
from slipscale.hardware.clock import VirtualClock

if TYPE_CHECKING:
    from slipscale.experiments.session.parts import Parts
    from slipscale.experiments.session.resonance_tracking import ResonanceTracking
    from slipscale.experiments.steps.replies import Presented
    from slipscale.experiments.steps.steps import Present, Step


@dataclass(slots=True, kw_only=True)
class Presenting:
    """Carries out `Present` steps, and presents surfaces again after an interruption.

    Parameters
    ----------
    parts : Parts
        Components that the session's actions share.
    tracking : ResonanceTracking or None
        Re-tunes the resonance between trials.
    """

    parts: Parts
    tracking: ResonanceTracking | None
    # Whether a resumed pilot must present the surface at its original time.
    _rewinds: bool = field(default=False, init=False)

    def present(self, step: Present) -> Presented:
        """Present a surface, and send markers at its onset and when it has settled."""
        if not self.parts.surface.begins(step):
            self.restore(step)
        self._rewinds = False
        self.parts.noise.start()
        self.parts.progress.tell("presenting", level=step.surface.made.level)
        if self.tracking and self.parts.surface.state == "silent":
            self.tracking.before(step, self.parts.journal, self.parts.clock)
        self.parts.markers.mark(Event.ONSET, step)
        made = self.parts.surface.present(step)
        self.parts.markers.mark(Event.SETTLED, step)
        self._note_standard(step)
        return made

    def take_up(self) -> None:
        """Record that the run is resumed and that the surface on the plate was lost."""
        virtual = isinstance(self.parts.clock, VirtualClock)
        self.parts.journal.write("take_up", virtual=virtual)
        self._rewinds = virtual
        if not virtual:
            self.parts.surface.interrupt()

    def restore(self, step: Step) -> None:
        """If a step requires a surface that was interrupted, let the participant feel it again."""
        if self.parts.surface.must_be_felt_again(step):
            self.parts.noise.start()
            self.parts.progress.tell("presenting")
            self.parts.markers.mark(Event.ONSET, step)
            with self._when_it_was_presented() as at:
                made = self.parts.surface.restore(at)
            self.parts.markers.mark(Event.SETTLED, step)
            self._note_standard(step)
            trial = step.trial.number if step.trial else None
            for presented, answer in made:
                interval = {} if presented.interval is None else {"interval": presented.interval}
                self.parts.journal.write(
                    "represented", trial=trial, **interval, answer=answer_record(answer)
                )

    @contextmanager
    def _when_it_was_presented(self) -> Iterator[Callable[[float], None]]:
        """Yield a function that sets a resumed pilot's clock to the time of the first presentation.

        On exit from the context, the clock is reset to its previous time. Because textures change
        with time, a resumed pilot explores each texture at its original time.
        """
        clock = self.parts.clock
        if not (self._rewinds and isinstance(clock, VirtualClock)):
            yield lambda _began_s: None
            return
        now_s = clock.now()
        try:
            yield clock.set
        finally:
            # The clock is set back only once, because a simulated fault would recur at every retry.
            clock.set(now_s)
            self._rewinds = False

    def _note_standard(self, step: Step) -> None:
        """Record that the standard was repeated before a trial's surface, if it was."""
        if made := self.parts.surface.take_standard_made():
            trial = step.trial.number if step.trial else None
            self.parts.journal.write("standard_again", trial=trial, answer=answer_record(made))
