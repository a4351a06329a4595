"""What a blinded operator sees of a fault: neither a level nor a voltage."""

import re

import pytest

from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.backends.serial_board.driver import _parsed
from slipscale.hardware.backends.serial_board.link import BoardLink
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.contact.source import SensorFault
from slipscale.hardware.errors import (
    FAULTS,
    ConnectionLost,
    GarbledReply,
    OverLimit,
    PlateBusy,
    PlateFault,
    PlateRefused,
    PlateTimeout,
    visible_message,
)
from slipscale.hardware.limits import PlateLimits

WITHHELD = {"busy", "garbled", "protocol", "refused", "over_limit", "not_reached"}
WITHHELD |= {"off_calibration"}
TOLD = "the plate makes 1.2 µm p-p at 7.8 V"


class OwnFault(PlateFault):
    """Of a laboratory's own backend, which has heard nothing of blinding."""

    code = "own"

    def __init__(self, message):
        super().__init__(message)


@pytest.mark.parametrize("kind", [*FAULTS.values(), SensorFault, OwnFault, PlateFault])
def test_a_message_is_withheld_unless_its_class_is_declared_to_name_no_level(kind):
    shown = kind(TOLD).blinded()
    withheld = kind.code in WITHHELD | {"own", "fault"}
    assert ("1.2" in str(shown)) != withheld
    assert (type(shown), shown.code) == (kind, kind.code)
    assert shown.remedy in str(shown)
    assert shown.blinded().message == shown.message
    assert kind(TOLD).message == TOLD
    if withheld:
        assert "see the journal" in shown.message
        assert not re.search(r"\d", shown.message)


@pytest.mark.parametrize("kind", [*FAULTS.values(), SensorFault, PlateFault])
def test_a_level_among_the_values_is_recorded_and_withheld(kind):
    fault = kind("the plate makes {level} at {voltage_v:.1f} V", level="1.2 µm p-p", voltage_v=7.8)
    assert fault.record() == {
        "code": kind.code,
        "message": TOLD,
        "level_free": kind.never_a_level,
        "template": "the plate makes {level} at {voltage_v:.1f} V",
        "values": {"level": "1.2 µm p-p", "voltage_v": 7.8},
    }
    shown = fault.blinded()
    if kind.code in WITHHELD | {"fault"}:
        assert set(shown.args[0].values) == {"fault", "remedy"}
        assert shown.args[0].values["fault"] == kind.in_general
        assert shown.record() == {
            "code": kind.code,
            "message": kind.in_general,
            "level_free": True,
        }
    seen = visible_message(fault.record())
    assert seen == (TOLD if kind.never_a_level else "")


def test_a_single_fault_can_be_declared_either_way():
    assert PlateBusy("in use", level_free=True).blinded().message == "in use"
    assert TOLD not in str(ConnectionLost(TOLD, level_free=False).blinded())


def reply(body, code, text):
    """Return what a board's link raises at an answer."""
    answer = wire.BoardReply(1, "boot", code, text)
    with pytest.raises(PlateFault) as refused:
        BoardLink(None, VirtualClock())._value(answer, body)
    return refused.value


@pytest.mark.parametrize(
    "code, text", [(wire.TOO_HOT, "Over temperature"), (wire.BUSY, "Device busy"), (-350, "")]
)
def test_a_refusal_of_the_board_names_the_command_but_not_its_numbers(code, text):
    fault = reply("AMPL 1.2000", code, text)
    assert fault.message == f"the board refused AMPL: {text} ({code})"
    assert fault.blinded().message == fault.message


def test_numbers_in_the_boards_own_words_are_withheld():
    fault = reply("AMPL 2.6", wire.OUT_OF_RANGE, "2.6 exceeds 2.5")
    assert "2.6 exceeds 2.5" in fault.message
    assert "2." not in str(fault.blinded())


class Deaf:
    port = "COM3"

    def __init__(self, clock, answer):
        self.clock, self.answer = clock, answer

    def write(self, data):
        pass

    def read(self):
        self.clock.sleep(0.05)
        return self.answer


@pytest.mark.parametrize("answer, kind", [(b"", PlateTimeout), (b"~~\n", GarbledReply)])
def test_a_board_that_does_not_answer_leaves_the_amplitude_unsaid(answer, kind):
    clock = VirtualClock()
    with pytest.raises(kind) as told:
        BoardLink(Deaf(clock, answer), clock).ask("AMPL 1.2000")
    assert "AMPL" in told.value.blinded().message
    assert "1.2" not in str(told.value)


def test_a_status_that_cannot_be_read_is_withheld():
    with pytest.raises(GarbledReply, match=r"1\.2000") as told:
        _parsed(wire.parse_status, "HOLD,1.2000,nan,30500.0,7.8,20")
    assert "1.2" not in str(told.value.blinded())


def test_a_level_outside_the_limits_is_withheld():
    with pytest.raises(OverLimit, match=r"2\.7") as told:
        PlateLimits().check_level(2.7)
    assert "2." not in str(told.value.blinded())


def test_the_remedy_of_a_refusal_stays():
    assert "cool down" in str(PlateRefused("x 1.2").blinded())
