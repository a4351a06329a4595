"""Faults of the rig: each type has a code for the journal and a remedy for the operator.

Backends raise only these for faults of the rig; `slipscale.hardware.driver` re-exports them.
"""

from __future__ import annotations

from typing import ClassVar

from slipscale.faults import RigError


class PlateFault(RigError):
    """A fault of the rig: ``code`` is for the journal, ``remedy`` for the operator."""

    code: ClassVar[str] = "fault"
    remedy: ClassVar[str] = "See the message."

    def __init__(self, message: str) -> None:
        super().__init__(f"{message}. {self.remedy}")
        self.message = message

    def blinded(self) -> PlateFault:
        """Return the fault without amplitudes, for operators who must not know them."""
        return self


class PlateNotFound(PlateFault):
    """There is no device at that address."""

    code = "not_there"
    remedy = "Check the cable and the port name: slipscale plate list shows the ports."


class NoPermission(PlateFault):
    """The device exists, but this user may not open it."""

    code = "no_permission"
    remedy = (
        "On Linux join the group that owns the port (sudo usermod -aG dialout $USER), "
        "then log out and in again."
    )


class WrongDevice(PlateFault):
    """A device answers, but it is not a plate, or not this plate."""

    code = "wrong_device"
    remedy = "Name the plate's own port, or the calibration that belongs to this plate."


class PlateBusy(PlateFault):
    """Another program is using the device, or the device does not accept commands."""

    code = "busy"
    remedy = "Close the other program that uses the plate, then try again."


class PlateTimeout(PlateFault):
    """There was no answer within the agreed time."""

    code = "time_out"
    remedy = "Check that the board has power, then unplug and replug it."


class GarbledReply(PlateFault):
    """An answer could not be read."""

    code = "garbled"
    remedy = "Check the cable and its distance from the amplifier."


class ProtocolViolation(PlateFault):
    """A board's answer violates its protocol."""

    code = "protocol"
    remedy = "Correct the board's firmware; slipscale plate conform SPEC lists the violations."


class PlateRefused(PlateFault):
    """The device understood a command and rejected it."""

    code = "refused"
    remedy = "Let the board cool down or clear its error, then try again."


class ConnectionLost(PlateFault):
    """The device disappeared, or restarted, during use."""

    code = "lost"
    remedy = "Plug the plate in again; the session can reconnect."


class Late(PlateFault):
    """The computer was late, so the plate repeated a change that is to be played once."""

    code = "late"
    remedy = "Close the other programs on this computer, then try again."


class StillVibrating(PlateFault):
    """The plate could not be silenced, and no watchdog will silence it."""

    code = "still_vibrating"
    remedy = (
        "Take the finger off and switch the drive off by hand: the generator's Output key, or the "
        "amplifier's mains switch"
    )


class OverLimit(PlateFault):
    """A command was outside the plate's limits. The plate is left unchanged."""

    code = "over_limit"
    remedy = (
        "Stay within the plate's limits. If the plate supports more, declare its limits in "
        "its plate file (slipscale plate new)"
    )


class NotReached(PlateFault):
    """The measured amplitude differs from the commanded one, usually because the drive saturates.

    A finger takes energy from the plate; at 15 V there is no headroom above the paper's 2.3 µm.
    """

    code = "not_reached"
    remedy = (
        "Check that the amplifier is on, and ask for less finger pressure; otherwise lower "
        "the study's largest amplitude or recalibrate: the drive may have reached its highest "
        "voltage."
    )

    def blinded(self) -> PlateFault:
        """Return this fault without the amplitudes."""
        return NotReached(
            "the plate measures a different amplitude than commanded (see the journal for the "
            "values)"
        )


class OffCalibration(PlateFault):
    """The drive voltage differs from the calibration's prediction for the amplitude.

    The amplitude reported by a sensor is then not trusted: the sensor, the amplifier or the plate
    has changed.
    """

    code = "off_calibration"
    remedy = (
        "Take the finger off; check the vibration sensor and the amplifier with a second "
        "instrument, then recalibrate the plate."
    )

    def blinded(self) -> PlateFault:
        """Return this fault without the amplitude and the voltages."""
        return OffCalibration(
            "the drive voltage differs from the calibration (see the journal for both values)"
        )


FAULTS: dict[str, type[PlateFault]] = {
    kind.code: kind
    for kind in (
        PlateNotFound, NoPermission, WrongDevice, PlateBusy, PlateTimeout, GarbledReply,
        ProtocolViolation, PlateRefused, ConnectionLost, StillVibrating, OverLimit, NotReached,
        OffCalibration, Late,
    )
}  # fmt: skip
