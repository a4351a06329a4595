"""Define the plate driver: the common interface for all backends, and the rules it enforces.

**The driver checks limits before a backend receives a command, and always silences the plate at the
end.** A command outside the limits raises an error and does not change the plate. Any other fault
silences the plate. Backends implement the methods that begin with an underscore; callers use the
public methods.

The plate is switched off in these places:

=====================================  ===========================================================
when                                   where
=====================================  ===========================================================
a command or a check raises any error  `GuardedOutput._silent_on_fault`
too long on, or on too often           `GuardedOutput.check`
the ``with`` block ends, however       `GuardedOutput.__exit__`, which calls `close`
a step of the protocol ends            `slipscale.experiments.session.surface_state.SurfaceState`
a session ends or is stopped           `slipscale.experiments.session.session.Session.run`
SIGINT, SIGTERM or SIGHUP              `slipscale.hardware.signals.signals_raise`: they raise, and
                                       the ``with`` block ends
the process is killed or hangs         the board's watchdog (``docs/reference/board-protocol.md``),
                                       or the guard (`slipscale.hardware.output.guard`)
=====================================  ===========================================================

A presentation succeeds only if the reported amplitude (measured or applied) matches the command,
and if the reported voltage is within `PlateLimits.voltage_band` of the calibration's prediction.
Readbacks of kind "commanded" or "none" cannot reveal a wrong amplitude.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Collection
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.hardware.address import DEFAULT_PLATE, Plate
from slipscale.hardware.calibration.device_check import check_device, check_same_device
from slipscale.hardware.errors import ConnectionLost, Late, NotReached, OverLimit, PlateRefused
from slipscale.hardware.output.state import GuardedOutput
from slipscale.hardware.records import Output, PlateIdentity, Presentation, Readback
from slipscale.stimuli.modulation import DEFAULT_MODULATOR, Loop, Modulator

if TYPE_CHECKING:
    from slipscale.hardware.clock import Clock
    from slipscale.stimuli.surface import Sensor, Surface

PROVING = ("measured", "applied")  # kinds of readback that can reveal a wrong amplitude
RING_DOWN_TIME_CONSTANTS = 7  # After this time, the amplitude has decayed to 0.1 %.
UNKNOWN_TIME_CONSTANT_S = 0.01  # Q = 1,000 at 30.5 kHz


class PlateDriver(GuardedOutput):
    """Base class of plate drivers: a context manager that silences the plate on exit.

    Parameters
    ----------
    clock : Clock
        Clock for the time stamps of readbacks and for the duration of vibration.
    plate : Plate
        Limits that the driver enforces, the calibration, which narrows them, and the plate file,
        which is stored with the data.

    Attributes
    ----------
    notes : tuple of str
        Notes for the operator, such as a warning about an old calibration; available after
        `connect`.
    modulator : Modulator or None
        How fast and how often the amplitude can be changed; None if the backend cannot modulate.
    why_not_modulated : str
        Reason why the backend cannot modulate.
    amplifier_gain : float
        Volts at the plate per volt of the backend; 1 if the backend's voltage is applied to the
        plate directly.
    largest_level : float
        The plate's limit without the calibration's, which applies to `excite`: a new calibration
        may extend the calibrated range.
    follow_lag_s : float or None
        Delay between `follow` and the plate's response; None if the backend cannot follow a finger.
    tracks : bool
        Whether the plate is driven at the calibrated frequency, so that the resonance can be
        tracked (`slipscale.hardware.resonance_tracking`); if False, the backend follows the
        resonance automatically.
    tracked_hz : float or None
        Drive frequency after resonance tracking.
    second_level : float
        Level of a second actuator during the next presentations
        (`slipscale.hardware.backends.pair`).
    simulated : bool
        Whether the plate is simulated. A simulated plate may use a calibration of another plate;
        the operator then sees a note.
    """

    name: ClassVar[str]
    modulator: Modulator | None = None
    amplifier_gain: float = 1.0
    follow_lag_s: float | None = None
    tracks: ClassVar[bool] = False
    tracked_hz: float | None = None
    simulated: ClassVar[bool] = False
    why_not_modulated: str = "this backend can only hold a constant amplitude"

    def __init__(
        self,
        *,
        clock: Clock,
        plate: Plate = DEFAULT_PLATE,
    ) -> None:
        self.largest_level = plate.limits.level
        narrowed = plate.calibration.narrow(plate.limits) if plate.calibration else plate.limits
        super().__init__(clock, narrowed)
        self.calibration = plate.calibration
        self.plate_file = plate.file
        self.notes: tuple[str, ...] = ()
        self.identity: PlateIdentity | None = None
        self.second_level = 0.0
        self._played: Loop | None = None
        self._repeats_s = math.inf  # time at which a played change ends and would start again

    def connect(self) -> PlateIdentity:
        """Connect to the device, identify it, and silence the plate.

        To reconnect after a fault, call `close` and then `connect`.

        Raises
        ------
        WrongDevice
            If the calibration is for another device, plate or backend, or if an earlier connection
            was to another device.
        UserError
            If the calibration is too old or dated in the future.
        """
        self._opened, self.output = False, Output.UNREACHABLE
        try:
            self._start_guard()
            identity = self._connect()
            check_same_device(self.identity, identity)
            self.identity = identity
            self._opened, self.output = True, Output.OFF
            self.notes = (*self._unattended_notes(), *self._check_identity(self.identity))
        except BaseException:
            self.close()
            raise
        self._fault_known = False
        self._on_time.command(self._lived_s(), vibrates=False)
        return self.identity

    def check_supported(self, surface: Surface, *, sensors: Collection[Sensor] = ()) -> Loop | None:
        """Return the loop that presents a texture, or None for a plain surface.

        If a sensor measures the finger's position, a backend with a `follow_lag_s` can follow the
        finger and requires no `modulator`. Transients require a `follow_lag_s` and a `modulator`,
        and some textures require a sensor.

        Raises
        ------
        OverLimit
            If an amplitude is outside the limits.
        UserError
            If the backend cannot play a texture, or cannot play it fast enough, or if a required
            sensor is missing.
        """
        self.limits.check_level(surface.level)
        loop = surface.loop(self.modulator or DEFAULT_MODULATOR)
        measured = surface.sensor in sensors and self.follow_lag_s is not None
        if surface.needs_sensor:
            change = surface.change(self.modulator or DEFAULT_MODULATOR)
            if self.follow_lag_s is None or (change and self.modulator is None):
                raise self._unpresented(surface, self.why_not_modulated)
            if change:
                self._check_loop(change)
            if not measured:
                raise UserError(
                    "texture '{surface_name}': it depends on the finger's {sensor}; name a "
                    "sensor ([plate] {sensor}, or --{sensor})",
                    surface_name=surface.name or surface.label,
                    sensor=surface.sensor,
                )
            return None
        if loop is None:
            self._check_possible(surface.level)
            return None
        self._check_loop(loop)
        if self.modulator is not None:
            return loop
        if measured:
            return None
        follows = self.follow_lag_s is not None and surface.sensor
        raise self._unpresented(
            surface,
            self.why_not_modulated,
            ", name a finger-position sensor ([plate] position)" if follows else "",
        )

    def _check_loop(self, loop: Loop) -> None:
        for each in loop.levels:
            self.limits.check_level(each)
        if self.modulator is not None:
            self.modulator.check(loop)

    def _unpresented(self, surface: Surface, why: str, hint: str = "") -> UserError:
        return UserError(
            "plate: backend '{name}' cannot present the texture '{surface_label}': {why}; "
            "present it on a plate that supports modulation{hint}, or remove the textures from "
            "the study",
            name=self.name,
            surface_label=surface.label,
            why=why,
            hint=hint,
        )

    def present(self, surface: Surface) -> Presentation:
        """Present a surface: ramp to its amplitude, and return when the plate has settled.

        An amplitude of 0 switches the output off. A texture is played until the next command, after
        the plate has settled at the mean amplitude of the texture; the returned presentation
        describes this mean amplitude.

        Raises
        ------
        OverLimit
            If the amplitude or the duty cycle is outside the limits. The output stays as it was.
        UserError
            If the backend cannot play the texture, see `check_supported`. The output stays as it
            was.
        NotReached
            If the reported amplitude differs from the commanded one. The plate is silenced.
        OffCalibration
            If the reported voltage differs from the calibration's prediction. The plate is
            silenced.
        PlateFault
            If the hardware fails in any other way. The plate is silenced.
        """
        loop = self.check_supported(surface)
        level = loop.mean_level if loop else surface.level
        if level > 0:
            self._check_duty()
        with self._commanding(vibrates=self._vibrates(level)):
            self._played, self._repeats_s = None, math.inf
            presentation = self._drive(level)
            try:
                self.confirm(level, presentation.readback)
            except NotReached:
                if level > 0:
                    raise
                presentation = self._after_ring_down(presentation)
                self.confirm(0.0, presentation.readback)
            if loop:
                self._play(loop)
                self._played = loop
        if self.calibration is not None:
            predicted_v = self.calibration.voltage_v_peak(level)
            presentation = replace(presentation, predicted_v_peak=predicted_v)
        return presentation

    def confirm(self, commanded_level: float, readback: Readback) -> None:
        """Raise `NotReached` or `OffCalibration` unless a readback shows the commanded amplitude.

        Readbacks of the kinds "commanded" and "none" are accepted. The voltage of a simulated plate
        is not compared, because its calibration may belong to another plate.
        """
        reported_level, reported_v = readback.level, readback.voltage_v_peak
        if readback.kind in PROVING and reported_level is not None:
            self.limits.check_reached(
                commanded_level, reported_level, applied=readback.kind == "applied"
            )
        if self.calibration and reported_v is not None and commanded_level and not self.simulated:
            largest_level = max(self._played.levels) if self._played else commanded_level
            self.limits.check_predicted(
                commanded_level,
                reported_v=reported_v,
                predicted_v=self.calibration.voltage_v_peak(largest_level),
            )

    def follow(self, level: float) -> None:
        """Change the amplitude without waiting, for a texture that follows the finger.

        The plate must be vibrating and have a `follow_lag_s`. Calling `follow` does not count as a
        new command, so the limit on unattended vibration time continues to apply. Until `present`
        settles again, readbacks are momentary values.

        Raises
        ------
        OverLimit
            If the amplitude is outside the limits. The output stays as it was.
        PlateRefused
            If the plate is off; call `present` first.
        PlateFault
            If the hardware fails in any other way. The plate is silenced.
        """
        self.limits.check_level(level)
        if self.output is not Output.MAY_BE_ON:
            raise PlateRefused(
                "plate '{name}': its output is {output}, so it cannot follow the finger",
                name=self.name,
                output=self.output,
            )
        with self._silent_on_fault():
            self._follow(level)
            self._check_in_time()
            self._repeats_s = math.inf

    def play(self, change: Loop) -> None:
        """Play a change of amplitude triggered by the finger.

        The plate repeats the change unless another amplitude is commanded (`follow`) before the
        change ends. If the computer is late, this command or the next `check` raises `Late`.

        Raises
        ------
        OverLimit, UserError
            If an amplitude is outside the limits, or if the plate is not fast enough. The output
            stays as it was.
        PlateRefused
            If the plate is off, or cannot modulate.
        PlateFault
            If the hardware fails in any other way. The plate is silenced.
        """
        self._check_loop(change)
        if self.modulator is None or self.output is not Output.MAY_BE_ON:
            raise PlateRefused(
                "plate '{name}': its output is {output}, so its amplitude cannot be changed",
                name=self.name,
                output=self.output,
            )
        with self._silent_on_fault():
            self._repeats_s = self.clock.now() + change.period_s
            self._change(change)

    def check(self) -> None:
        """Raise a pending `PlateFault`, or `Late` if no command was sent before a change ended."""
        super().check()
        if self.output is Output.MAY_BE_ON:
            with self._silent_on_fault():
                self._check_in_time()

    def _check_in_time(self) -> None:
        late_s = self.clock.now() - self._repeats_s
        if late_s > 0:
            raise Late(
                "plate '{name}': the computer was {late_s:.2f} s late, so the plate repeated a "
                "change",
                name=self.name,
                late_s=late_s,
            )

    def excite(self, *, frequency_hz: float, voltage_v: float) -> Readback:
        """Drive the plate at a frequency and voltage for calibration, and read back.

        Parameters
        ----------
        frequency_hz : float
            Drive frequency.
        voltage_v : float
            Drive voltage in V peak at the plate, after any amplifier.

        Raises
        ------
        OverLimit
            If frequency, voltage or duty cycle is outside the limits. The output stays as it was.
            If the plate then measures more than `largest_level`, it is silenced.
        PlateRefused
            If the backend does not accept drive frequencies and voltages.
        """
        self.limits.check_frequency(frequency_hz)
        self.limits.check_voltage(voltage_v)
        if voltage_v > 0:
            self._check_duty()
        with self._commanding(vibrates=True):  # The output is on even at 0 V.
            self._played = None
            readback = self._excite(frequency_hz=frequency_hz, voltage_v=voltage_v)
            measured = readback.level if readback.kind == "measured" else None
            if measured is not None and measured > self.largest_level:
                q = self.limits.quantity
                raise OverLimit(
                    "the plate reached {measured} at {voltage_v:g} V peak and {frequency_hz:g} "
                    "Hz, more than the plate's limit of {largest_level}, and was switched off; "
                    "lower the voltage of this sweep (--sweep-voltage or --max-voltage)",
                    measured=q.short(round(measured, 3)),
                    voltage_v=voltage_v,
                    frequency_hz=frequency_hz,
                    largest_level=q.short(self.largest_level),
                )
        return readback

    def read_back(self) -> Readback:
        """Return the current state of the plate. Raises `PlateFault` if reading back fails."""
        if not self._opened:
            raise ConnectionLost("plate '{name}': not connected", name=self.name)
        with self._silent_on_fault():
            return self._read_back()

    def vibration_level(self) -> float:
        """Return the current amplitude in µm p-p. By default, the plate's readback is returned."""
        return self.read_back().level or 0.0

    @property
    def unfelt(self) -> bool:
        """Whether the plate or the board is simulated, so that a finger would feel nothing."""
        return self.simulated or (self.identity is not None and self.identity.emulated)

    def describe(self) -> dict[str, Any]:
        """Return the description for the session's record, as JSON data."""
        file = {"plate_file": self.plate_file.summary()} if self.plate_file else {}
        return {
            **file,
            "backend": self.name,
            "identity": asdict(self.identity) if self.identity else None,
            "limits": {
                name: each for name, each in asdict(self.limits).items() if name != "quantity"
            },
            "calibration": self.calibration.summary() if self.calibration else None,
            "notes": list(self.notes),
        }

    def _after_ring_down(self, presentation: Presentation) -> Presentation:
        """After switching the plate off, wait until it has rung down, and read back again.

        The plate may still be ringing if 0 µm is commanded directly after it was switched off. The
        waiting time depends on the plate's Q. If the plate still vibrates afterwards, `present`
        raises a fault.
        """
        wait_s = RING_DOWN_TIME_CONSTANTS * self._time_constant_s()
        self.clock.sleep(wait_s)
        return replace(
            presentation,
            readback=self._read_back(),
            settle_time_s=presentation.settle_time_s + wait_s,
        )

    def _time_constant_s(self) -> float:
        """Return the plate's calibrated time constant, or a long default without a calibration."""
        if self.calibration is None:
            return UNKNOWN_TIME_CONSTANT_S
        resonance = self.calibration.resonance
        return resonance.quality_factor / (math.pi * resonance.frequency_hz)

    def _unattended_notes(self) -> tuple[str, ...]:
        """Return the note about an output that only an interlock switches off."""
        if not self.interlock:
            return ()
        return (
            Message(
                "if this program is killed, only the interlock switches the plate off: {interlock}",
                interlock=self.interlock,
            ),
        )

    def _check_identity(self, identity: PlateIdentity) -> tuple[str, ...]:
        """Check the identity of the device; return notes for the operator."""
        file = self.plate_file
        wanted = file.identity.device_serial if file else ""
        return check_device(self, identity, wanted=wanted)

    def _vibrates(self, level: float) -> bool:
        """Return whether a level makes the plate vibrate."""
        return level > 0

    @abstractmethod
    def _connect(self) -> PlateIdentity:
        """Connect, identify the device, and silence the plate; `_close` is called on failure."""

    @abstractmethod
    def _drive(self, level: float) -> Presentation:
        """Ramp to an amplitude, and return when the plate has settled (for 0: when it is off)."""

    @abstractmethod
    def _read_back(self) -> Readback:
        """Return the current state of the plate."""

    def _check_possible(self, level: float) -> None:
        """Raise `OverLimit` if the device cannot produce the amplitude."""

    def _play(self, loop: Loop) -> None:
        """Play a loop until the next command; requires a `modulator`."""
        raise NotImplementedError

    def _change(self, change: Loop) -> None:
        """Play a change of amplitude immediately; by default, in the same way as a texture."""
        self._play(change)

    def _follow(self, level: float) -> None:
        """Change the amplitude without waiting; requires a `follow_lag_s`."""
        raise NotImplementedError

    def _excite(self, *, frequency_hz: float, voltage_v: float) -> Readback:
        """Drive at a frequency and voltage, and return when the plate has settled."""
        raise PlateRefused(
            "backend '{name}' cannot drive {voltage_v:g} V at {frequency_hz:g} Hz: it does not "
            "accept frequencies and voltages",
            name=self.name,
            voltage_v=voltage_v,
            frequency_hz=frequency_hz,
        )

    def __enter__(self) -> Self:
        self.connect()
        return self
