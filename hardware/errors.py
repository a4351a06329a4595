"""Define hardware faults, with codes for the journal and remedies for the operator.

Backends report every hardware fault as one of these exceptions.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from slipscale.faults import RigError
from slipscale.faults.message import Message, as_data, from_data


class PlateFault(RigError):
    """Hardware fault, with a ``code`` for the journal and a ``remedy`` for the operator.

    A blinded operator sees the message only if it is declared to contain neither a level nor a
    drive voltage, and ``in_general`` otherwise (docs/decisions/blinding.md).

    Parameters
    ----------
    template : str
        The fault, without its remedy, with placeholders for ``values``; see `Message`.
    level_free : bool or None
        Whether the message contains neither a level nor a voltage; by default, as declared by the
        class (``never_a_level``).
    """

    code: ClassVar[str] = "fault"
    remedy: ClassVar[str] = "See the message."
    in_general: ClassVar[str] = "the plate reports a fault (see the journal for the message)"
    never_a_level: ClassVar[bool] = False

    def __init__(
        self, template: str, /, *, level_free: bool | None = None, **values: object
    ) -> None:
        self.message = Message(template, **values)
        super().__init__("{fault}. {remedy}", fault=self.message, remedy=self.remedy)
        self.level_free = self.never_a_level if level_free is None else level_free

    def record(self) -> dict[str, object]:
        """Return the journal's record: the English message, and the data to translate it from.

        A blinded operator may see the message only if the record is ``level_free``.
        """
        data = as_data(self.message)
        record = {"code": self.code, "message": str(self.message), "level_free": self.level_free}
        return record | (data if isinstance(data, dict) else {})

    def blinded(self) -> PlateFault:
        """Return the fault with a message that a blinded operator may see."""
        if self.level_free:
            return self
        shown = type(self).__new__(type(self))  # the class may have its own constructor
        PlateFault.__init__(shown, self.in_general, level_free=True)
        return shown


def visible_message(record: Mapping[str, object]) -> str:
    """Return a recorded fault's message; empty if a blinded operator may not see it."""
    if record.get("level_free") is not True:
        return ""
    try:
        return from_data(record if "template" in record else record.get("message", ""))
    except ValueError:  # another program changed the record
        return str(record.get("message", ""))


def fault_of(record: Mapping[str, object]) -> PlateFault:
    """Return the fault of a `PlateFault.record`."""
    message = from_data(record if "template" in record else record["message"])
    level_free = bool(record["level_free"])
    return FAULTS[str(record["code"])](message, level_free=level_free)


class PlateNotFound(PlateFault):
    """Raised if there is no device at the given address."""

    code = "not_there"
    never_a_level = True
    remedy = "Check the cable and the port name: slipscale plate list shows the ports."


class NoPermission(PlateFault):
    """Raised if the user has no permission to open the device."""

    code = "no_permission"
    never_a_level = True
    remedy = (
        "On Linux, join the group that owns the port (sudo usermod -aG dialout $USER), "
        "then log out and in again."
    )


class WrongDevice(PlateFault):
    """Raised if the connected device is not a plate, or not the expected plate."""

    code = "wrong_device"
    in_general = "the device is not the expected plate (see the journal for its answer)"
    never_a_level = True
    remedy = "Specify this plate's port, or the calibration that was made with this plate."


class PlateBusy(PlateFault):
    """Raised if the device is in use by another program or does not accept commands."""

    code = "busy"
    in_general = "the device is busy (see the journal for the message)"
    remedy = "Close the other program that uses the plate, then try again."


class PlateTimeout(PlateFault):
    """Raised if a device does not answer in time."""

    code = "time_out"
    never_a_level = True
    remedy = (
        "Check that the device has power and that no other program uses it, then unplug and replug "
        "it."
    )


class GarbledReply(PlateFault):
    """Raised if an answer cannot be read."""

    code = "garbled"
    in_general = "the device's answer cannot be read (see the journal for the answer)"
    remedy = "Check the cable, and keep it away from the amplifier."


class ProtocolViolation(PlateFault):
    """Raised if the board's answer violates the protocol."""

    code = "protocol"
    in_general = "the board's answer violates the protocol (see the journal for the answer)"
    remedy = "Correct the board's firmware; slipscale plate conform SPEC lists the violations."


class PlateRefused(PlateFault):
    """Raised if the device rejects a command."""

    code = "refused"
    in_general = (
        "the device rejected a command or did not keep a setting (see the journal for the message)"
    )
    remedy = "Let the board cool down or clear its error, then try again."


class ConnectionLost(PlateFault):
    """Raised if the device is disconnected or restarts during use."""

    code = "lost"
    never_a_level = True
    remedy = "Plug the plate in again; the session can reconnect."


class GuardLost(ConnectionLost):
    """Raised if the process that switches the output off ends or stands still."""

    code = "guard_lost"
    remedy = (
        "Wait for the session to reconnect, which starts the guard process again. If it is lost "
        "repeatedly, find the program that stops processes on this computer."
    )


class Late(PlateFault):
    """Raised if the plate repeats a change because the computer was late."""

    code = "late"
    never_a_level = True
    remedy = "Close the other programs on this computer, then try again."


class Frozen(PlateFault):
    """Raised if the session or the computer stood still while the plate was on."""

    code = "frozen"
    never_a_level = True
    remedy = "Close the other programs on this computer, and switch its standby off."


class StillVibrating(PlateFault):
    """Raised if the plate could not be silenced and has no watchdog."""

    code = "still_vibrating"
    never_a_level = True
    remedy = (
        "Take the finger off and switch the drive off by hand: the generator's Output key, or the "
        "amplifier's mains switch"
    )


class OverLimit(PlateFault):
    """Raised if a command is outside the plate's limits. The plate is not changed."""

    code = "over_limit"
    in_general = "a command is outside the plate's limits (see the journal for the values)"
    remedy = (
        "Stay within the plate's limits. If the plate supports more, declare its limits in "
        "its plate file (slipscale plate new)"
    )


class NotReached(PlateFault):
    """Raised if the measured amplitude differs from the commanded amplitude.

    The usual cause is a drive that saturates because a finger absorbs energy from the plate.
    """

    code = "not_reached"
    remedy = (
        "Check that the amplifier is on, and that no other program drives the plate. If this does "
        "not help, lower the study's largest amplitude or recalibrate: the drive may have reached "
        "its highest voltage."
    )
    in_general = (
        "the plate measures a different amplitude than commanded (see the journal for the values)"
    )


class OffCalibration(PlateFault):
    """Raised if the drive voltage differs from the calibration's prediction.

    The sensor, the amplifier or the plate must have changed, so the measured amplitude may be
    wrong.
    """

    code = "off_calibration"
    remedy = (
        "Take the finger off; check the vibration sensor and the amplifier with a second "
        "instrument, then recalibrate the plate."
    )
    in_general = "the drive voltage differs from the calibration (see the journal for both values)"


FAULTS: dict[str, type[PlateFault]] = {
    kind.code: kind
    for kind in (
        PlateNotFound, NoPermission, WrongDevice, PlateBusy, PlateTimeout, GarbledReply,
        ProtocolViolation, PlateRefused, ConnectionLost, StillVibrating, OverLimit, NotReached,
        OffCalibration, GuardLost, Late, Frozen,
    )
}  # fmt: skip
