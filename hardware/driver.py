"""The plate driver: what every backend offers, and what is enforced for all of them.

One rule governs this file: **limits are checked here, before a backend hears of a command, and
every way out ends silent.** A command outside the limits raises and leaves the plate as it was;
any other fault silences it. A backend fills in the methods that begin with an underscore; what
callers use is the same for all.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from contextlib import contextmanager, suppress
from dataclasses import asdict
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, ClassVar, Self

from faults import UserError
from hardware.errors import (
    OverLimit,
    PlateFault,
    PlateRefused,
)
from hardware.limits import OnTime, PlateLimits
from stimuli.modulation import DEFAULT_MODULATOR

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import TracebackType

    from hardware.calibration.record import Calibration
    from hardware.clock import Clock
    from hardware.records import PlateIdentity, Presentation, Readback
    from stimuli.modulation import Loop, Modulator
    from stimuli.surface import Surface


class PlateDriver(ABC):
    """A plate, whatever drives it. A context manager that ends silent on every path.

    Parameters
    ----------
    clock : Clock
        The only clock the driver may read.
    limits : PlateLimits
        Enforced here for every backend.
    calibration : Calibration
        Narrows the limits to what was calibrated: nothing is extrapolated.

    Attributes
    ----------
    notes : tuple of str
        After `connect`: what the operator should know (calibration old, or of another plate).
    modulator : Modulator or None
        How fast plate and line follow a texture; None: this backend cannot modulate.
    why_not_modulated : str
        Why it cannot.
    """

    name: ClassVar[str]
    modulator: Modulator | None = None
    why_not_modulated: str = "it holds one amplitude at a time"

    def __init__(
        self,
        *,
        clock: Clock,
        limits: PlateLimits | None = None,
        calibration: Calibration | None = None,
    ) -> None:
        self.clock = clock
        self.calibration = calibration
        self.limits = limits or PlateLimits()
        if calibration is not None:
            self.limits = calibration.narrow(self.limits)
        self.notes: tuple[str, ...] = ()
        self.identity: PlateIdentity | None = None
        self._on_time = OnTime(window_s=self.limits.duty_window_s)
        self._fault_known = False

    def connect(self) -> PlateIdentity:
        """Open the line, check who answers, leave the plate silent.

        After a fault, `close` and `connect` again is how one reconnects.
        """
        try:
            self.identity = self._connect()
        except BaseException:
            self.close()
            raise
        if self.calibration is not None:
            self.notes = self.calibration.notes(self.identity, datetime.now(tz=UTC).date())
        self._fault_known = False
        self._on_time.command(self.clock.now(), vibrates=False)
        return self.identity

    def check_supported(self, surface: Surface) -> Loop | None:
        """Return what the plate plays to make a texture, None for a plain surface; do nothing.

        Raises
        ------
        OverLimit
            An amplitude is outside the limits.
        UserError
            A texture, and this backend cannot modulate, or not as fast as that.
        """
        self.limits.check_amplitude(surface.amplitude_um_pp)
        loop = surface.loop(self.modulator or DEFAULT_MODULATOR)
        if loop is None:
            return None
        if self.modulator is None:
            raise UserError(
                f"plate: backend '{self.name}' cannot present the texture '{surface.label}': "
                f"{self.why_not_modulated}; present it on a plate that modulates, "
                "or take the textures out of the study"
            )
        for each in loop.amplitudes_um_pp:
            self.limits.check_amplitude(each)
        self.modulator.check(loop)
        return loop

    def present(self, surface: Surface) -> Presentation:
        """Make the surface: ramp to its amplitude and return once that has settled.

        An amplitude of 0 switches the output off. A texture settles at its mean amplitude, which
        is what the presentation tells; then it is played until the next command.

        Raises
        ------
        OverLimit
            The amplitude or the duty is outside the limits; the plate was left as it was.
        UserError
            A texture that this backend cannot play, see `check_supported`; the plate was left as
            it was.
        NotReached
            The plate measures another amplitude than commanded; it was silenced.
        PlateFault
            Any other fault of the rig; the plate was silenced.
        """
        loop = self.check_supported(surface)
        amplitude_um_pp = loop.mean_um_pp if loop else surface.amplitude_um_pp
        if amplitude_um_pp > 0:
            self._check_duty()
        with self._silent_on_fault():
            self._on_time.command(self.clock.now(), vibrates=amplitude_um_pp > 0)
            presentation = self._drive(amplitude_um_pp)
            measured_um_pp = presentation.readback.amplitude_um_pp
            if presentation.readback.kind == "measured" and measured_um_pp is not None:
                self.limits.check_reached(amplitude_um_pp, measured_um_pp)
            if loop:
                self._play(loop)
        return presentation

    def excite(self, *, frequency_hz: float, voltage_v: float) -> Readback:
        """Drive at one frequency in Hz and one voltage, settle, read back: for calibration.

        Raises
        ------
        OverLimit
            Frequency, voltage or duty is outside the limits; the plate was left as it was.
        PlateRefused
            The backend keeps frequency and voltage to itself.
        """
        self.limits.check_frequency(frequency_hz)
        self.limits.check_voltage(voltage_v)
        if voltage_v > 0:
            self._check_duty()
        with self._silent_on_fault():
            self._on_time.command(self.clock.now(), vibrates=voltage_v > 0)
            return self._excite(frequency_hz=frequency_hz, voltage_v=voltage_v)

    def read_back(self) -> Readback:
        """Return what the plate does now. Raises `PlateFault` if it cannot say."""
        with self._silent_on_fault():
            return self._read_back()

    def silence(self) -> None:
        """Stop the vibration. May be called at any time, in any state, more than once.

        Raises `PlateFault` when the plate did not confirm, unless a fault was raised before: that
        one has already told that the plate may be out of reach.
        """
        self._on_time.command(self.clock.now(), vibrates=False)
        try:
            self._silence()
        except PlateFault:
            if not self._fault_known:
                self._fault_known = True
                raise

    def check(self) -> None:
        """Raise the `PlateFault` that has come up since the last command, if any.

        Called often (every frame) while a participant explores or answers: it must be cheap.
        """
        now_s = self.clock.now()
        if self._on_time.unattended_s(now_s) > self.limits.on_time_s:
            self.silence()
            raise OverLimit(
                f"the plate vibrated for {self.limits.on_time_s:g} s without a new command; "
                "it was silenced"
            )
        try:
            self._check_duty()
        except OverLimit:
            self.silence()
            raise
        with self._silent_on_fault():
            self._check()

    def vibration_um_pp(self) -> float:
        """Return what a finger on the plate feels now, in µm p-p: by default the readback."""
        return self.read_back().amplitude_um_pp or 0.0

    def close(self) -> None:
        """Silence, then let go of the device. Never raises a `PlateFault`."""
        self._fault_known = True
        try:
            self.silence()
        finally:
            with suppress(PlateFault):
                self._close()

    def describe(self) -> dict[str, Any]:
        """Return what a record of the session should say of the plate, ready for JSON."""
        return {
            "backend": self.name,
            "identity": asdict(self.identity) if self.identity else None,
            "limits": asdict(self.limits),
            "calibration": self.calibration.summary() if self.calibration else None,
            "notes": list(self.notes),
        }

    @contextmanager
    def _silent_on_fault(self) -> Iterator[None]:
        try:
            yield
        except BaseException as error:
            self._fault_known = self._fault_known or isinstance(error, PlateFault)
            with suppress(PlateFault):
                self.silence()
            raise

    def _check_duty(self) -> None:
        duty = self._on_time.duty(self.clock.now())
        if duty > self.limits.duty:
            raise OverLimit(
                f"the plate vibrated {duty:.0%} of the last {self.limits.duty_window_s:g} s, "
                f"more than {self.limits.duty:.0%}"
            )

    @abstractmethod
    def _connect(self) -> PlateIdentity:
        """Open the line, check who answers, leave the plate silent. `_close` follows a failure."""

    @abstractmethod
    def _drive(self, amplitude_um_pp: float) -> Presentation:
        """Ramp to a checked amplitude; return when it has settled."""

    @abstractmethod
    def _read_back(self) -> Readback:
        """Return what the plate does now."""

    @abstractmethod
    def _silence(self) -> None:
        """Stop the vibration; do nothing when not connected."""

    @abstractmethod
    def _close(self) -> None:
        """Let go of the device; do nothing when not connected."""

    def _check(self) -> None:  # noqa: B027 - most backends learn of faults by commands alone
        """Raise the fault that has come up since the last command, if any; cheaply."""

    def _play(self, loop: Loop) -> None:
        """Modulate the settled plate until the next command; a backend with a `modulator` only."""
        raise NotImplementedError

    def _excite(self, *, frequency_hz: float, voltage_v: float) -> Readback:
        """Drive at a checked frequency and voltage; return when it has settled."""
        raise PlateRefused(
            f"backend '{self.name}' cannot drive {voltage_v:g} V at {frequency_hz:g} Hz: "
            "it keeps frequency and voltage to itself"
        )

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
