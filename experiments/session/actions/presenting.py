"""Present surfaces, and restore a lost surface before a step that requires it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from slipscale.experiments.journal.serialisation import answer_record
from slipscale.experiments.session.markers import Event, Markers
from slipscale.hardware.clock import Clock, VirtualClock

if TYPE_CHECKING:
    from slipscale.experiments.journal.journal import Journal
    from slipscale.experiments.session.masking_noise import Noise
    from slipscale.experiments.session.progress import Progress
    from slipscale.experiments.session.resonance_tracking import ResonanceTracking
    from slipscale.experiments.session.surface_state import SurfaceState
    from slipscale.experiments.steps.replies import Presented
    from slipscale.experiments.steps.steps import Present, Step


@dataclass(slots=True, kw_only=True)
class Presenting:
    """Carries out `Present` steps, and presents surfaces again after an interruption.

    Parameters
    ----------
    surface, journal, clock, noise, markers, progress, tracking
        Components of the session.
    """

    surface: SurfaceState
    journal: Journal
    clock: Clock
    noise: Noise
    markers: Markers
    progress: Progress
    tracking: ResonanceTracking | None
    # Whether a resumed pilot must present the surface at its original time.
    _rewinds: bool = field(default=False, init=False)

    def present(self, step: Present) -> Presented:
        """Present a surface, and send markers at its onset and when it has settled."""
        if not self.surface.begins(step):
            self.restore(step)
        self._rewinds = False
        self.noise.start()
        self.progress.tell("presenting", level=step.surface.made.level)
        if self.tracking and self.surface.state == "silent":
            self.tracking.before(step, self.journal, self.clock)
        self.markers.mark(Event.ONSET, step)
        made = self.surface.present(step)
        self.markers.mark(Event.SETTLED, step)
        self._note_standard(step)
        return made

    def take_up(self) -> None:
        """Record that the run is resumed and that the surface on the plate was lost."""
        virtual = isinstance(self.clock, VirtualClock)
        self.journal.write("take_up", virtual=virtual)
        self._rewinds = virtual
        if not virtual:
            self.surface.interrupt()

    def restore(self, step: Step) -> None:
        """If a step requires a surface that was interrupted, let the participant feel it again."""
        if self.surface.must_be_felt_again(step):
            self.noise.start()
            self.progress.tell("presenting")
            self.markers.mark(Event.ONSET, step)
            with self._when_it_was_presented() as at:
                made = self.surface.restore(at)
            self.markers.mark(Event.SETTLED, step)
            self._note_standard(step)
            trial = step.trial.number if step.trial else None
            for presented, answer in made:
                interval = {} if presented.interval is None else {"interval": presented.interval}
                self.journal.write(
                    "represented", trial=trial, **interval, answer=answer_record(answer)
                )

    @contextmanager
    def _when_it_was_presented(self) -> Iterator[Callable[[float], None]]:
        """Yield a function that sets a resumed pilot's clock to the time of the first presentation.

        On exit from the context, the clock is reset to its previous time. Because textures change
        with time, a resumed pilot explores each texture at its original time.
        """
        clock = self.clock
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
        if made := self.surface.take_standard_made():
            trial = step.trial.number if step.trial else None
            self.journal.write("standard_again", trial=trial, answer=answer_record(made))
