"""The surface that should be on the plate, and whether the plate makes it now.

A surface that was presented stays *wanted* until the protocol silences the plate. If it is lost
(a fault, a pause, a crash), it is presented and explored again before the participant is asked
anything more: no rating is taken of a surface that is not there.

Where the protocol silences the plate before it asks (the longest exploration is over), the surface
is *remembered* for the questions of its trial. An interruption breaks that memory: the surface is
then presented, explored and silenced again before the question (docs/decisions/0160).

A surface that was explored and silenced outside a trial is a *standard*: what the trials after it
are compared with. After an interruption it is felt again before the next of them
(docs/decisions/0210).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from experiments.protocols.steps import Ask, Presented
from hardware.errors import PlateFault

if TYPE_CHECKING:
    from collections.abc import Callable

    from experiments.protocols.steps import Explore, Present, Reply, Silence, Step
    from hardware.clock import Clock
    from hardware.driver import PlateDriver


PlateState = Literal["silent", "as commanded", "not measured", "lost"]
MEASURED = ("measured", "applied")


class SurfaceState:
    """What the participant should be feeling, and whether the plate makes it now.

    Parameters
    ----------
    plate : PlateDriver
    clock : Clock
    explore : callable
        Has the participant explore what is presented.
    """

    def __init__(
        self, plate: PlateDriver, clock: Clock, explore: Callable[[Explore], Reply]
    ) -> None:
        self._plate = plate
        self._clock = clock
        self._explore = explore
        self._present: Present | None = None
        self._explored: Explore | None = None
        self._made = False
        # Silenced before the questions of its trial, and whether nothing came between since.
        self._remembered: tuple[Present, Explore | None] | None = None
        self._fresh = False
        self._standard: tuple[Present, Explore] | None = None
        self._standard_due = False
        self._standard_made: Presented | None = None
        self._commanded_um_pp = 0.0
        self._measured = False

    @property
    def state(self) -> PlateState:
        """What the plate does, by its last reading; it tells no amplitude."""
        if self._present is None:
            return "silent"
        if not self._made:
            return "lost"
        return "as commanded" if self._measured else "not measured"

    @property
    def amplitude_um_pp(self) -> float | None:
        """The amplitude wanted (of a texture the largest), or None."""
        return self._present.surface.amplitude_um_pp if self._present else None

    def must_be_felt_again(self, step: Step) -> bool:
        """Whether a surface was lost that must be there, or be remembered, for a step."""
        if self._present is not None:
            return not self._made
        asked = isinstance(step, Ask) and step.trial is not None
        if self._remembered is None or self._fresh or not asked:
            return False
        return self._remembered[0].trial == step.trial

    def present(self, step: Present) -> Presented:
        """Make a surface, after its lead-in where the plate does not make that."""
        if self._standard and self._standard_due and step.trial is not None:
            self._feel_standard(*self._standard)
        if step.lead_in:
            before, explore = step.lead_in
            led_in = self._made and self._present and self._present.surface == before.surface
            if not led_in:
                self._drive(before)
                self._explore(explore)
        return self._drive(step)

    def remember(self, present: Present) -> None:
        """Note a surface that a journal says was presented; the plate makes it no more."""
        self.forget()
        self._present = present

    def explored(self, step: Explore) -> None:
        """Note that the participant has explored the surface."""
        self._explored = step

    def restore(self) -> Presented:
        """Make the lost surface again and have it explored again, as far as it was.

        To be called where `must_be_felt_again` says so. A surface that the protocol had silenced is
        silenced again.
        """
        remembered = self._remembered
        present, explored = remembered or (self._present, self._explored)
        if present is None:
            raise ValueError("there is no surface to restore: none was presented")
        try:
            made = self.present(present)
            if explored:
                self._explore(explored)
            if remembered:
                self._plate.silence()
        except BaseException:
            self.forget()
            if remembered:
                self._remembered = remembered
            else:
                self._present, self._explored = present, explored
            raise
        self._explored = explored
        if remembered:
            self.forget()
            self._remembered, self._fresh = remembered, True
        return made

    def confirm(self) -> None:
        """Raise a `PlateFault` unless the plate still makes the wanted surface.

        The tolerance is the driver's own: what it would not take for the surface when it was
        presented is not taken for it when it was rated (docs/decisions/0022). Of a texture both
        the command and the reading are means.
        """
        if self._present is None:
            return
        self._plate.check()
        told = self._plate.read_back()
        self._measured = told.kind in MEASURED and told.amplitude_um_pp is not None
        if told.kind in MEASURED and told.amplitude_um_pp is not None:
            self._plate.limits.check_reached(self._commanded_um_pp, told.amplitude_um_pp)

    def check(self) -> None:
        """Raise the plate's fault, if any, while it makes a surface. Cheap."""
        if self._made:
            self._plate.check()

    def silence(self, step: Silence) -> None:
        """Silence the plate as the protocol asks for it; no surface is wanted there any more."""
        self._plate.silence()
        if self._present and self._present.trial is None and self._made:
            self._standard_due = False  # unless it was interrupted between the standard and its end
        self.silenced(step)

    def silenced(self, step: Silence) -> None:
        """Note that the protocol silenced the plate; questions of its trial may follow."""
        if self._present is None:
            return
        present, explored, fresh = self._present, self._explored, self._made
        self.forget()
        if present.trial is None:
            self._standard = (present, explored) if explored else None
        elif step.trial is not None and present.trial == step.trial:
            self._remembered, self._fresh = (present, explored), fresh

    def forget(self) -> None:
        """Note that no surface is wanted, nor remembered."""
        self._present, self._explored, self._made = None, None, False
        self._remembered, self._fresh = None, False

    def part_over(self) -> None:
        """Note that a block or a task is over: its standard counts no more."""
        self._standard = None

    def take_standard_made(self) -> Presented | None:
        """Return how the standard was presented again since the last call, if it was."""
        made, self._standard_made = self._standard_made, None
        return made

    def interrupt(self) -> None:
        """Note that the surface is about to be lost, or is; it stays wanted, or remembered."""
        self._made, self._fresh = False, False
        self._standard_due = True

    def hush(self) -> None:
        """Silence the plate for something apart; the surface that stood there is lost."""
        self.interrupt()
        self._plate.silence()

    def shut_down(self) -> None:
        """Silence the plate, whatever state the line is in: at the end, or after a fault."""
        self.interrupt()
        try:
            self._plate.silence()
        except PlateFault:
            self._plate.close()

    def _feel_standard(self, present: Present, explore: Explore) -> None:
        """Have the standard presented, explored and silenced again."""
        made = self._drive(present)
        self._explore(explore)
        self._plate.silence()
        self.forget()
        self._standard_made, self._standard_due = made, False

    def _drive(self, step: Present) -> Presented:
        """Present a surface; it is there once it has settled and reads back as commanded."""
        self.forget()
        made = self._plate.present(step.surface)
        self._present, self._made = step, True
        self._commanded_um_pp = made.commanded_um_pp
        self.confirm()
        return Presented(
            commanded_um_pp=made.commanded_um_pp,
            readback_um_pp=made.readback.amplitude_um_pp,
            readback_kind=made.readback.kind,
            settled_by=made.settled_by,
            onset_s=self._clock.now(),
        )
