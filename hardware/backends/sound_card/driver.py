"""Drive a plate with a sound card and an amplifier, if there is no driver board.

SPEC: ``sound:DEVICE,option=value,...`` where DEVICE is a device's number or part of its
name, as listed by ``python -m sounddevice``, with

================  ===============================================================
``full_scale``    V peak **at the plate**, after the amplifier, of a full-scale
                  sine; required unless a calibration or a plate file defines it
``calibration``   a file written by ``slipscale plate calibrate``
``plate``         a file written by ``slipscale plate new``
``rate``          samples per second (192000)
``channel``       1 (left, the default) or 2; the other is silent
``attention``     seconds (5); if a session neither commands nor checks for this
                  long, it is assumed to hang and the carrier stops; 0: never
``frequency``     sine frequency, Hz: for a plate file in a quantity other than µm, in
                  place of a calibration
``per_volt``      the level per V peak at the plate, your own measurement at that
                  frequency; not for a plate in volts
================  ===============================================================

At the end of a session, the carrier is ramped down. The stream belongs to the process: the system
closes it when the process is killed, and it plays silence when the process is stopped. If the
computer freezes, **nothing** stops a card from repeating its last buffer:
use a hardware interlock (docs/how-to/function-generator.md). The vibration is not measured.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.hardware import address as addresses
from slipscale.hardware.backends import drive_of_level
from slipscale.hardware.backends.gain import agreed_gain
from slipscale.hardware.backends.sound_card.carrier import RAMP_S, Carrier
from slipscale.hardware.clock import Clock, SystemClock
from slipscale.hardware.driver import PlateDriver
from slipscale.hardware.errors import (
    ConnectionLost,
    OverLimit,
    PlateBusy,
    PlateFault,
    PlateNotFound,
    PlateTimeout,
    StillVibrating,
)
from slipscale.hardware.output.unattended import StopsAlone
from slipscale.hardware.records import PlateIdentity, Presentation, Readback

if TYPE_CHECKING:
    from slipscale.hardware.backends.drive_of_level import DriveOfLevel

RATE_HZ = 192_000.0
PASSBAND = 0.45  # highest usable frequency, as a fraction of the sampling rate
CHANNELS = 2
POLL_S = 0.002
# ALSA devices whose streams a sound server plays, and moves to other outputs.
ROUTED = ("default", "pulse", "pipewire")
ENDS_S = 1.0  # time, in addition to `RAMP_S`, for the device to request the samples of a ramp


def _channel(text: str) -> int:
    if text not in {"1", "2"}:
        raise ValueError("expected 1 or 2")
    return int(text)


OPTIONS: dict[str, Callable[[str], object]] = {
    "attention": addresses.number_from_0,
    "channel": _channel,
    "full_scale": addresses.positive_number,
    "rate": addresses.positive_number,
    **drive_of_level.OPTIONS,
}


class SoundCard(PlateDriver):
    """Plate driven by a sound card.

    Parameters
    ----------
    device : str
        Number or name of the device; "" is the system's default device.
    clock : Clock
        Clock for the time stamps of readbacks.
    plate : Plate
        Limits at the plate, whose highest frequency is reduced at low sampling rates; its
        calibration, which is required for surfaces but not for `excite`; and its file, whose
        ``amplifier_gain`` is the full-scale voltage in V peak at the plate.
    full_scale_v : float
        Voltage of a full-scale sine at the plate in V peak; by default, from the calibration.
    rate_hz : float
        Samples per second.
    channel : int
        Output channel, 1 or 2.
    drive : DriveOfLevel
        Drive voltage per level, for plates whose levels are not in µm; by default, taken from the
        calibration.

    Raises
    ------
    UserError
        If the full-scale voltage is unknown, if two sources disagree, or if the sampling rate is
        too low.
    """

    name = "sound"
    tracks = True
    unattended = StopsAlone("the system ends the stream of a process that is killed or stopped")
    why_not_modulated = "sound cards can only hold a constant amplitude"

    def __init__(
        self,
        device: str,
        *,
        clock: Clock,
        plate: addresses.Plate = addresses.DEFAULT_PLATE,
        full_scale_v: float | None = None,
        rate_hz: float = RATE_HZ,
        channel: int = 1,
        drive: DriveOfLevel | None = None,
    ) -> None:
        super().__init__(clock=clock, plate=plate)
        self._level_drive = drive or drive_of_level.calibrated(plate.calibration)
        self.amplifier_gain = agreed_gain(
            full_scale_v,
            plate,
            unknown="plate 'sound': the voltage at the plate is unknown; measure it with an "
            "oscilloscope, and set the peak voltage at full scale in the SPEC, for example "
            "full_scale=20",
        )
        highest_hz = PASSBAND * rate_hz
        if highest_hz <= self.limits.frequency_min_hz:
            raise UserError(
                "plate 'sound': rate is {rate_hz:g} Hz, which supports at most {highest_hz:g} "
                "Hz; the plate is driven at {frequency_min_hz:g} Hz or more",
                rate_hz=rate_hz,
                highest_hz=highest_hz,
                frequency_min_hz=self.limits.frequency_min_hz,
            )
        self.limits = replace(
            self.limits,
            frequency_max_hz=min(self.limits.frequency_max_hz, highest_hz),
            voltage_v=drive_of_level.largest_v_peak(self.limits),
        )
        self.device: str | int = int(device) if device.isdecimal() else device
        self.instrument = f"sound device {device}, channel {channel}"
        self._channel = channel
        self._machine: Clock = SystemClock()
        self._attended_s = 0.0
        self._carrier = Carrier(rate_hz)
        self._stream: Any = None
        self._underflows = 0
        self._unattended = False
        self._aborted = False  # Stop here, so that nothing more is played.
        self._unstoppable: StillVibrating | None = None  # until the device is opened again

    def _connect(self) -> PlateIdentity:
        self._close()
        try:
            import sounddevice
        except OSError as error:
            raise UserError(
                "plate 'sound': PortAudio is missing (Debian: apt-get install libportaudio2)"
            ) from error
        self._carrier = carrier = Carrier(self._carrier.rate_hz)
        self._underflows, self._unattended, self._aborted = 0, False, False
        self._attended_s = self._machine.now()
        device = None if self.device == "" else self.device

        def fill(memory: Any, _frames: int, _time: object, status: Any) -> None:
            block = np.frombuffer(memory, np.float32).reshape(-1, CHANNELS)
            self._underflows += bool(status.output_underflow)
            waited_s = self._machine.now() - self._attended_s
            if carrier.target and self.attention_s and waited_s > self.attention_s:
                self._unattended = True
            if self._unattended:
                carrier.target = 0.0
            block[:] = 0
            block[:, self._channel - 1] = carrier.samples(len(block))

        try:
            about = sounddevice.query_devices(device, kind="output")
            self._stream = sounddevice.RawOutputStream(
                device=device,
                samplerate=carrier.rate_hz,
                channels=CHANNELS,
                dtype="float32",
                callback=fill,
            )
            self._stream.start()
            self._unstoppable = None
        except (sounddevice.PortAudioError, ValueError) as error:
            raise PlateNotFound(
                "sound device '{device}': it cannot be opened with {channels} channels at "
                "{rate_hz:g} Hz ({error})",
                device=self.device,
                channels=CHANNELS,
                rate_hz=carrier.rate_hz,
                error=error,
            ) from error
        # Cards report no serial number, so each card and channel counts as a device.
        return PlateIdentity(
            manufacturer="sound card",
            model=str(about["name"]),
            serial=f"{about['name']}, channel {self._channel}",
            firmware="",
        )

    def _check_identity(self, identity: PlateIdentity) -> tuple[str, ...]:
        notes = super()._check_identity(identity)
        if identity.model not in ROUTED:
            return notes
        return (
            *notes,
            Message(
                "sound device '{device}' belongs to the sound server: if the computer's default "
                "output changes, the plate's signal moves to the new output, and no fault is "
                "reported. Give the card's own number instead (python -m sounddevice lists them)",
                device=identity.model,
            ),
        )

    def _drive(self, level: float) -> Presentation:
        drive = self._level_drive
        if drive is None:
            raise UserError(
                "plate 'sound': a sound card needs calibration=FILE; slipscale plate calibrate "
                "writes one"
            )
        begun_s = self._machine.now()
        self._play_sine(
            frequency_hz=self.tracked_hz or drive.frequency_hz,
            voltage_v=drive.voltage_v_peak(level),
            settling_s=drive.settling_s,
        )
        return Presentation(
            commanded_level=level,
            readback=self._read_back(),
            settled_by="wait",
            settle_time_s=self._machine.now() - begun_s,
        )

    def _excite(self, *, frequency_hz: float, voltage_v: float) -> Readback:
        settling_s = drive_of_level.UNKNOWN_PLATE_SETTLING_S
        self._play_sine(frequency_hz=frequency_hz, voltage_v=voltage_v, settling_s=settling_s)
        return self._read_back()

    def _play_sine(self, *, frequency_hz: float, voltage_v: float, settling_s: float) -> None:
        self.limits.check_frequency(frequency_hz)
        self._check_voltage(voltage_v)
        self._attend()
        self._carrier.frequency_hz = frequency_hz
        self._carrier.target = voltage_v / self.amplifier_gain
        self._until_ramped()
        self._machine.sleep(float(self._stream.latency) + settling_s)
        self._attend()

    def _check_possible(self, level: float) -> None:
        if self._level_drive is not None:
            self._check_voltage(self._level_drive.voltage_v_peak(level))

    def _check_voltage(self, voltage_v: float) -> None:
        """Raise `OverLimit` if the voltage is above the plate's limit or the card's full scale."""
        self.limits.check_voltage(voltage_v)
        if voltage_v > self.amplifier_gain:
            raise OverLimit(
                "{voltage_v:g} V peak at the plate is more than the card's full scale, "
                "{amplifier_gain:g} V",
                voltage_v=voltage_v,
                amplifier_gain=self.amplifier_gain,
            )

    def _until_ramped(self) -> None:
        begun_s = self._machine.now()
        while self._carrier.level != self._carrier.target:
            if self._machine.now() - begun_s > RAMP_S + ENDS_S:
                raise ConnectionLost(
                    "sound device '{device}': it requests no samples", device=self.device
                )
            self._machine.sleep(POLL_S)

    def _read_back(self) -> Readback:
        """Return the level that corresponds to the present amplitude of the carrier."""
        self._attend()
        if self._level_drive is None:
            return Readback(level=None, kind="none", time_s=self.clock.now())
        voltage_v = self._carrier.level * self.amplifier_gain
        return Readback(
            level=voltage_v * self._level_drive.level_per_v,
            kind="applied",
            time_s=self.clock.now(),
            voltage_v_peak=voltage_v,
        )

    def _check(self) -> None:
        self._attend()

    def _attend(self) -> None:
        """Record that the session is alive, and raise the stored fault, if any."""
        name = Message("sound device '{device}'", device=self.device)
        if self._stream is None:
            raise ConnectionLost("{name}: not connected", name=name)
        if not self._stream.active:
            raise ConnectionLost("{name}: it was disconnected", name=name)
        if self._underflows:
            raise PlateBusy(
                "{name}: this computer was too slow ({underflows} times), so the carrier was "
                "interrupted",
                name=name,
                underflows=self._underflows,
                level_free=True,
            )
        if self._unattended:
            raise PlateTimeout(
                "{name}: the session sent no command for {attention_s:g} s, so the plate was "
                "switched off",
                name=name,
                attention_s=self.attention_s,
            )
        self._attended_s = self._machine.now()

    def _silence(self) -> None:
        self._carrier.target = 0.0
        if self._stream is None:
            if self._unstoppable is not None:
                raise self._unstoppable
            return
        if not self._stream.active:
            if not self._aborted:
                raise ConnectionLost(
                    "sound device '{device}': it was disconnected", device=self.device
                )
            return
        try:
            self._until_ramped()
            self._machine.sleep(float(self._stream.latency))
        except PlateFault:
            self._abort()

    def _abort(self) -> None:
        """Stop the stream without playing the remaining samples."""
        import sounddevice

        try:
            self._stream.abort()
            self._aborted = True
        except sounddevice.PortAudioError as error:
            self._unstoppable = StillVibrating(
                "sound device '{device}': it could not be stopped ({error}), so the plate may "
                "still vibrate",
                device=self.device,
                error=error,
            )
            raise self._unstoppable from error
        self._unstoppable = None

    def _close(self) -> None:
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.close(ignore_errors=True)


def open_plate(address: str, *, clock: Clock, seed: int) -> PlateDriver:  # noqa: ARG001 - real
    """Return a driver for a sound card (entry point ``sound``).

    Raises
    ------
    UserError
        If the device does not exist, an option is unknown, the full scale is missing, or the
        calibration is unusable.
    """
    device, options, plate = addresses.opened(address, SoundCard.name, OPTIONS)
    if not device:
        raise UserError(
            "plate 'sound': expected sound:DEVICE; python -m sounddevice lists the devices"
        )
    card = SoundCard(
        device,
        clock=clock,
        plate=plate,
        full_scale_v=options.get("full_scale"),
        rate_hz=options.get("rate", RATE_HZ),
        channel=options.get("channel", 1),
        drive=drive_of_level.stated(SoundCard.name, options, plate),
    )
    card.attention_s = options.get("attention", card.attention_s)
    return card
