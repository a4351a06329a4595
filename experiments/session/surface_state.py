"""What should be on the plate, or have been felt, and whether that still holds.

A *script* is what a trial presents: one surface and its exploration, or several intervals of them,
with the silences between. If a fault, a pause or a crash comes between, it is performed again from
its first step before the participant is asked anything more, or feels the next interval: no answer
is taken about a surface that is not there, or that this finger, in this hour, has not felt.

A surface outside a trial stays wanted until the protocol silences the plate. One that a trial
silences before its question is part of its script, and so remembered
(docs/decisions/interrupted-trials.md).

A surface that was explored and silenced outside a trial is a *standard*: what the trials after it
are compared with. After an interruption it is felt again before the next of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from slipscale.experiments.protocols.steps import Adjust, Ask, Explore, Present, Presented
from slipscale.hardware.errors import PlateFault

if TYPE_CHECKING:
    from collections.abc import Callable

    from slipscale.experiments.protocols.steps import Reply, Silence, Step
    from slipscale.experiments.session.followed_textures import Following
    from slipscale.hardware.clock import Clock
    from slipscale.hardware.contact.source import Sample
    from slipscale.hardware.driver import PlateDriver
    from slipscale.stimuli.quantity import Quantity
    from slipscale.stimuli.surface import Surface


PlateState = Literal["silent", "as commanded", "not measured", "lost"]
MEASURED = ("measured", "applied")


@dataclass(frozen=True, slots=True, kw_only=True)
class Done:
    """A step of the script, and when a presentation began."""

    step: Present | Explore | Silence
    began_s: float = 0.0


class SurfaceState:
    """What the participant should be feeling, or have felt, and whether it holds.

    Parameters
    ----------
    plate : PlateDriver
    clock : Clock
    explore : callable
        Has the participant explore what is presented.
    following : Following
        Has textures follow the finger.
    """

    def __init__(
        self,
        plate: PlateDriver,
        clock: Clock,
        explore: Callable[[Explore], Reply],
        following: Following,
    ) -> None:
        self._plate = plate
        self._clock = clock
        self._explore = explore
        self._following = following
        self._script: list[Done] = []
        self._held = True  # nothing came between since the script began
        self._hushed = False  # the plate was silenced on purpose since
        self._wanted: Present | None = None  # what the plate should make now
        self._standard: tuple[Present, Explore] | None = None
        self._standard_due = False
        self._standard_made: Presented | None = None
        self._commanded_level = 0.0
        self._measured = False
        self._temperature_c: float | None = None

    @property
    def state(self) -> PlateState:
        """What the plate does, by its last reading; it tells no amplitude."""
        if self._wanted is None or self._hushed:
            return "silent"
        if not self._held:
            return "lost"
        return "as commanded" if self._measured else "not measured"

    @property
    def temperature_c(self) -> float | None:
        """The plate's temperature by its last reading; None where it tells none."""
        return self._temperature_c

    @property
    def quantity(self) -> Quantity:
        """What the plate's levels are in."""
        return self._plate.limits.quantity

    @property
    def level(self) -> float | None:
        """The amplitude wanted (of a texture the largest), or None."""
        return self._wanted.surface.level if self._wanted else None

    def must_be_felt_again(self, step: Step) -> bool:
        """Whether what a step needs to be there, or to have been felt, was interrupted."""
        if self._held or not self._script:
            return False
        if self._wanted is not None:
            return True
        if isinstance(step, Present):
            return not self.begins(step)
        asked = isinstance(step, Ask | Explore | Adjust) and step.trial is not None
        return asked and step.trial == self._trial

    def begins(self, step: Present) -> bool:
        """Whether a presentation begins a script, in place of being its next interval."""
        return step.interval is None or step.trial is None or step.trial != self._trial

    def present(self, step: Present) -> Presented:
        """Make a surface, after its lead-in where the plate does not make that."""
        self._feel_standard(step)
        if step.lead_in:
            before, explore = step.lead_in
            led_in = self._held and self._wanted and self._wanted.surface == before.surface
            if not led_in:
                self.forget()
                self._drive(before)
                self._explore(explore)
        if self.begins(step):
            self.forget()
        began_s = self._clock.now()
        made = self._drive(step)
        self._script.append(Done(step=step, began_s=began_s))
        return made

    def presented(self, step: Present, began_s: float) -> None:
        """Note a surface that a journal says was presented; the plate makes it no more."""
        if self.begins(step):
            self.forget()
        self._script.append(Done(step=step, began_s=began_s))
        self._wanted, self._held = step, False

    def explored(self, step: Explore) -> None:
        """Note that the participant has explored the surface."""
        if self._wanted is not None:
            self._script.append(Done(step=step))

    def turn(self, surface: Surface) -> None:
        """Make the wanted surface another one, as the participant turns it."""
        if self._wanted is None:
            raise ValueError("there is no surface to turn: none was presented")
        self._make(replace(self._wanted, surface=surface))

    def adjusted(self, surface: Surface) -> None:
        """Note to what the wanted surface was turned: that is what was felt."""
        if self._wanted is None:
            return
        self._wanted = turned = replace(self._wanted, surface=surface)
        last = max(n for n, done in enumerate(self._script) if isinstance(done.step, Present))
        self._script[last] = replace(self._script[last], step=turned)

    def feel_again(self, before: Present, explore: Explore) -> Presented:
        """Have another surface felt, then make the wanted one again; return what was made first.

        Whatever comes between, the wanted surface is then the one that is lost.
        """
        wanted = self._wanted
        if wanted is None:
            raise ValueError("there is no surface to go back to: none was presented")
        try:
            made = self._drive(before)
            self._explore(explore)
            self.confirm()
            self._plate.silence()
            self._drive(wanted)
        except BaseException:
            self._wanted, self._held = wanted, False
            raise
        return made

    def restore(self, at: Callable[[float], None]) -> list[tuple[Present, Presented]]:
        """Perform the script again, from its first step as far as it was.

        To be called where `must_be_felt_again` says so.

        Parameters
        ----------
        at : callable
            Told when each presentation began, before it is made again.

        Returns
        -------
        list of tuple
            Each surface and what the plate did.
        """
        wanted = self._wanted
        made: list[tuple[Present, Presented]] = []
        try:
            for done in self._script:
                if isinstance(done.step, Present):
                    at(done.began_s)
                    made.append((done.step, self._redrive(done.step)))
                elif isinstance(done.step, Explore):
                    self._explore(done.step)
                else:
                    self._plate.silence()
                    self._wanted = None
        except BaseException:
            self._wanted, self._held = wanted, False
            raise
        return made

    def confirm(self) -> None:
        """Raise a `PlateFault` unless the plate still makes the wanted surface.

        The tolerance is the driver's own: what it would not take for the surface when it was
        presented is not taken for it when it was rated (docs/decisions/one-tolerance.md). For a
        texture, command and reading are means.
        """
        if self._wanted is not None:
            self.read_back_level()

    def read_back_level(self) -> float | None:
        """Return what the plate says it makes; raise its fault unless that is what is wanted."""
        self._plate.check()
        self._following.settle()
        told = self._plate.read_back()
        self._temperature_c = told.temperature_c
        self._measured = told.kind in MEASURED and told.level is not None
        self._plate.confirm(self._commanded_level, told)
        return told.level

    def check(self) -> None:
        """Raise the plate's fault, if any, while it makes a surface. Cheap."""
        if self._wanted is not None and self._held:
            self._plate.check()

    def follow(self, samples: list[Sample]) -> None:
        """Command what is due where the finger is, while the plate makes a followed texture."""
        if self._wanted is not None and self._held:
            self._following.see(samples)

    def silence(self, step: Silence) -> None:
        """Silence the plate as the protocol asks for it; no surface is wanted there any more."""
        self._plate.silence()
        if self._wanted and self._wanted.trial is None and self._held:
            self._standard_due = False  # unless it was interrupted between the standard and its end
        self.silenced(step)

    def silenced(self, step: Silence) -> None:
        """Note that the protocol silenced the plate; its trial may go on."""
        if self._wanted is None:
            return
        if self._wanted.trial is None:
            explored = [done.step for done in self._script if isinstance(done.step, Explore)]
            self._standard = (self._wanted, explored[-1]) if explored else None
            self.forget()
        elif step.trial == self._trial:
            self._script.append(Done(step=step))
            self._wanted = None
        else:
            self.forget()

    def forget(self) -> None:
        """Note that no surface is wanted, nor remembered."""
        self._script, self._wanted, self._held = [], None, True

    def part_over(self) -> None:
        """Note that a block or a task is over: its standard counts no more."""
        self._standard = None

    def take_standard_made(self) -> Presented | None:
        """Return how the standard was presented again since the last call, if it was."""
        made, self._standard_made = self._standard_made, None
        return made

    def interrupt(self) -> None:
        """Note that something comes between; what was felt is to be felt again."""
        self._held = False
        self._standard_due = True

    def hush(self) -> None:
        """Silence the plate for something apart; what was felt is to be felt again."""
        self.interrupt()
        self._plate.silence()
        self._hushed = True

    def shut_down(self) -> None:
        """Silence the plate, whatever state the line is in: at the end, or after a fault."""
        self.interrupt()
        try:
            self._plate.silence()
        except PlateFault:
            self._plate.close()

    @property
    def _trial(self) -> object:
        """The trial of the script's surfaces, None outside one."""
        first = self._script[0].step if self._script else None
        return first.trial if first else None

    def _feel_standard(self, step: Present) -> None:
        """Have the standard presented, explored and silenced again, if a trial needs that first."""
        if not (self._standard and self._standard_due and step.trial is not None):
            return
        present, explore = self._standard
        made = self._drive(present)
        self._explore(explore)
        self._plate.silence()
        self._wanted = None
        self._standard_made, self._standard_due = made, False

    def _redrive(self, step: Present) -> Presented:
        """Make a surface of the script again, after the standard and its lead-in."""
        self._feel_standard(step)
        if step.lead_in:
            before, explore = step.lead_in
            self._drive(before)
            self._explore(explore)
        return self._drive(step)

    def _drive(self, step: Present) -> Presented:
        """Present a surface; it is there once it has settled and reads back as commanded."""
        self._wanted, self._held = None, True
        return self._make(step)

    def _make(self, step: Present) -> Presented:
        self._hushed = False
        made = self._plate.present(self._following.presented_as(step.surface))
        self._wanted, self._held = step, True
        self._commanded_level = made.commanded_level
        self.confirm()
        return Presented(
            commanded_level=made.commanded_level,
            readback_level=made.readback.level,
            readback_kind=made.readback.kind,
            settled_by=made.settled_by,
            onset_s=self._clock.now(),
            voltage_v_peak=made.readback.voltage_v_peak,
            temperature_c=made.readback.temperature_c,
        )
