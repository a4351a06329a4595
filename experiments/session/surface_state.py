"""Keep track of the surface on the plate, and restore it after an interruption.

The *script* of a trial is its sequence of presentations: one surface and its exploration, or
several intervals with the silences between them. After a fault, a pause or a crash, the trial's
script is repeated from its first step before the participant continues. An answer is recorded only
if the surface is on the plate and the participant has just felt it.

Outside a trial, a surface remains on the plate until the protocol silences the plate. If the
surface of a trial is silenced before the question, it remains part of the trial's script
(docs/decisions/interrupted-trials.md).

A surface that was explored and silenced outside a trial is a *standard*, the reference for the
following trials. After an interruption, the standard is repeated before the next trial that refers
to it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from slipscale.experiments.steps.replies import Presented, Reply
from slipscale.experiments.steps.steps import Adjust, Ask, Explore, Present, Silence, Step
from slipscale.hardware.errors import PlateFault, StillVibrating

if TYPE_CHECKING:
    from slipscale.experiments.session.followed_textures import Following
    from slipscale.hardware.clock import Clock
    from slipscale.hardware.contact.source import Kind, Sample
    from slipscale.hardware.driver import PlateDriver
    from slipscale.stimuli.quantity import Quantity
    from slipscale.stimuli.surface import Stimulus


PlateState = Literal["silent", "as commanded", "not measured", "lost"]
MEASURED = ("measured", "applied")


@dataclass(frozen=True, slots=True, kw_only=True)
class Done:
    """A completed step of the script, with its start time if it is a presentation."""

    step: Present | Explore | Silence
    began_s: float = 0.0


class SurfaceState:
    """The surface that the participant feels or has felt, and whether it was interrupted.

    Parameters
    ----------
    plate : PlateDriver
    clock : Clock
    explore : callable
        Lets the participant explore the surface on the plate.
    following : Following
        Makes textures follow the finger.
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
        self._held = True  # False after an interruption
        self._hushed = False  # whether the plate was silenced for an interruption
        self._wanted: Present | None = None  # the step whose surface should be on the plate now
        self._standard: tuple[Present, Explore] | None = None
        self._standard_due = False
        self._standard_made: Presented | None = None
        self._commanded_level = 0.0
        self._measured = False
        self._temperature_c: float | None = None

    @property
    def state(self) -> PlateState:
        """State of the plate according to its last reading, without revealing the amplitude."""
        if self._wanted is None or self._hushed:
            return "silent"
        if not self._held:
            return "lost"
        return "as commanded" if self._measured else "not measured"

    @property
    def temperature_c(self) -> float | None:
        """The plate's last temperature reading; None if the plate reports no temperature."""
        return self._temperature_c

    @property
    def quantity(self) -> Quantity:
        """The quantity of the plate's levels."""
        return self._plate.limits.quantity

    @property
    def level(self) -> float | None:
        """The commanded level (for a texture, its maximum); None if no surface is expected."""
        return self._wanted.surface.made.level if self._wanted else None

    @property
    def wanted(self) -> Stimulus | None:
        """The stimulus expected on the plate, or None."""
        return self._wanted.surface if self._wanted else None

    def must_be_felt_again(self, step: Step) -> bool:
        """Return whether a step requires a surface whose presentation was interrupted."""
        if self._held or not self._script:
            return False
        if self._wanted is not None:
            return True
        if isinstance(step, Present):
            return not self.begins(step)
        asked = isinstance(step, Ask | Explore | Adjust) and step.trial is not None
        return asked and step.trial == self._trial

    def begins(self, step: Present) -> bool:
        """Return whether a presentation begins a new sequence rather than the next interval."""
        return step.interval is None or step.trial is None or step.trial != self._trial

    def present(self, step: Present) -> Presented:
        """Present a surface, preceded by its lead-in unless this is already on the plate."""
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
        """Register a surface that was presented before the run was interrupted."""
        if self.begins(step):
            self.forget()
        self._script.append(Done(step=step, began_s=began_s))
        self._wanted, self._held = step, False

    def explored(self, step: Explore) -> None:
        """Register that the participant has explored the surface."""
        if self._wanted is not None:
            self._script.append(Done(step=step))

    def turn(self, surface: Stimulus) -> None:
        """Change the surface on the plate during an adjustment."""
        if self._wanted is None:
            raise ValueError("there is no surface to adjust, because none was presented")
        self._make(replace(self._wanted, surface=surface))

    def adjusted(self, surface: Stimulus) -> None:
        """Register the final surface of an adjustment, which the participant felt last."""
        if self._wanted is None:
            return
        self._wanted = turned = replace(self._wanted, surface=surface)
        last = max(n for n, done in enumerate(self._script) if isinstance(done.step, Present))
        self._script[last] = replace(self._script[last], step=turned)

    def feel_again(self, before: Present, explore: Explore) -> Presented:
        """Present the surface of ``before`` for exploration, then the current surface again.

        Returns the result of presenting ``before``. If this method is interrupted, the current
        surface counts as interrupted too.
        """
        wanted = self._wanted
        if wanted is None:
            raise ValueError("there is no surface to return to, because none was presented")
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
        """Repeat the completed steps of the script in order.

        Call this method when `must_be_felt_again` returns True.

        Parameters
        ----------
        at : callable
            Called before each repetition with the original start time of the presentation.

        Returns
        -------
        list of tuple
            Repeated presentations, each with its result.
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
                    self.confirm()
                else:
                    self._plate.silence()
                    self._wanted = None
        except BaseException:
            self._wanted, self._held = wanted, False
            raise
        return made

    def confirm(self) -> None:
        """Raise a `PlateFault` unless the commanded surface is still on the plate.

        The tolerance is defined by the driver and is the same as during presentation
        (docs/decisions/one-tolerance.md). For a texture, the mean readback is compared with the
        mean command.
        """
        if self._wanted is not None:
            self.read_back_level()

    def read_back_level(self) -> float | None:
        """Return the plate's readback; raise a `PlateFault` if it is out of tolerance."""
        self._plate.check()
        self._following.settle()
        readback = self._plate.read_back()
        self._temperature_c = readback.temperature_c
        self._measured = readback.kind in MEASURED and readback.level is not None
        self._plate.confirm(self._commanded_level, readback)
        return readback.level

    def check(self) -> None:
        """Raise a `PlateFault` if the plate fails while a surface is on it. The check is fast."""
        if self._wanted is not None and self._held:
            self._plate.check()

    def follow(self, kind: Kind, samples: list[Sample]) -> list[float] | None:
        """Update the commanded amplitude while a texture follows the finger (`Following.see`)."""
        if self._wanted is None or not self._held:
            return None
        return self._following.see(kind, samples)

    def silence(self, step: Silence) -> None:
        """Silence the plate as the protocol requests; no surface is then expected on the plate."""
        self._plate.silence()
        if self._wanted and self._wanted.trial is None and self._held:
            self._standard_due = False  # the standard was felt without interruption
        self.silenced(step)

    def silenced(self, step: Silence) -> None:
        """Register that the protocol silenced the plate. The trial may not be over yet."""
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
        """Forget the current surface and the completed steps of the script."""
        self._script, self._wanted, self._held = [], None, True

    def part_over(self) -> None:
        """Forget the standard at the end of a block or task."""
        self._standard = None

    def take_standard_made(self) -> Presented | None:
        """Return the last repetition of the standard once; None if it was not repeated."""
        made, self._standard_made = self._standard_made, None
        return made

    def interrupt(self) -> None:
        """Register an interruption, after which the trial's surfaces must be felt again."""
        self._held = False
        self._standard_due = True

    def hush(self) -> None:
        """Silence the plate for an interruption, after which surfaces must be felt again."""
        self.interrupt()
        self._plate.silence()
        self._hushed = True

    def shut_down(self) -> StillVibrating | None:
        """Silence the plate at the end or after a fault. If this fails, close the connection.

        Returns the fault if the plate may still vibrate. The driver raises it again when it is
        closed at the end of the session.
        """
        self.interrupt()
        try:
            self._plate.silence()
        except PlateFault:
            return self.disconnect()
        return None

    def disconnect(self) -> StillVibrating | None:
        """Close the connection to the plate; return the fault if the plate may still vibrate."""
        try:
            self._plate.close()
        except StillVibrating as still:
            return still
        return None

    @property
    def _trial(self) -> object:
        """The trial to which the current presentations belong; None outside a trial."""
        first = self._script[0].step if self._script else None
        return first.trial if first else None

    def _feel_standard(self, step: Present) -> None:
        """If a trial requires the standard again, present it for exploration, then silence it."""
        if not (self._standard and self._standard_due and step.trial is not None):
            return
        present, explore = self._standard
        made = self._drive(present)
        self._explore(explore)
        self._plate.silence()
        self._wanted = None
        self._standard_made, self._standard_due = made, False

    def _redrive(self, step: Present) -> Presented:
        """Present a surface again, after the standard and the lead-in (if required)."""
        self._feel_standard(step)
        if step.lead_in:
            before, explore = step.lead_in
            self._drive(before)
            self._explore(explore)
        return self._drive(step)

    def _drive(self, step: Present) -> Presented:
        """Present a surface, and wait until it has settled and the readback matches the command."""
        self._wanted, self._held = None, True
        return self._make(step)

    def _make(self, step: Present) -> Presented:
        self._hushed = False
        self._plate.second_level = step.second
        made = self._plate.present(self._following.presented_as(step.surface.made))
        self._wanted, self._held = step, True
        self._commanded_level = made.commanded_level
        self.confirm()
        return Presented(
            commanded_level=made.commanded_level,
            readback_level=made.readback.level,
            readback_kind=made.readback.kind,
            settled_by=made.settled_by,
            onset_s=self._clock.now(),
            drive_voltage_v_peak=made.readback.voltage_v_peak,
            temperature_c=made.readback.temperature_c,
            second_readback=made.second_readback_level,
        )
