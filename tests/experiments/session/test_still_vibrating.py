"""A plate that cannot be switched off: however the session ends, the operator is told."""

import pytest

from slipscale.experiments.session.operator import Request, UnattendedOperator
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.contact.source import SensorFault
from slipscale.hardware.errors import ConnectionLost, PlateNotFound, StillVibrating
from slipscale.hardware.records import Output

BY_HAND = "Take the finger off and switch the drive off by hand"


def stop(_plate):
    return Request(what="stop")


def pause(_plate):
    return Request(what="pause")


def interrupt(_plate):
    raise KeyboardInterrupt


def sensor_fault(_plate):
    raise SensorFault("lasers: no answer")


def lose(plate):
    plate._check = lambda: _raise(ConnectionLost("GEN: disconnected"))


def _raise(error):
    raise error


class Operator(UnattendedOperator):
    """Has the plate freeze while it presents a surface, and then acts."""

    def __init__(self, laboratory, act, retries=2):
        super().__init__(retries)
        self.laboratory, self.act = laboratory, act
        self.told = []

    def tell(self, status):
        super().tell(status)
        self.told.append(status)

    def poll(self):
        plate = self.laboratory.plate
        if self.act and plate.output is Output.MAY_BE_ON:
            act, self.act = self.act, None
            freeze(plate)
            return act(plate)
        return super().poll()


def freeze(plate):
    plate._silence = lambda: _raise(StillVibrating("GEN: the output could not be switched off"))
    plate._connect = lambda: _raise(PlateNotFound("GEN: cannot be opened"))


@pytest.mark.parametrize("act", [stop, pause, interrupt, sensor_fault, lose])
def test_the_session_ends_with_the_fault_however_it_is_ended(laboratory, act):
    with pytest.raises(StillVibrating, match=BY_HAND):
        laboratory.run(operator=Operator(laboratory, act))
    assert laboratory.plate.output is Output.UNREACHABLE
    faults = [record.data["code"] for record in laboratory.records(kind="fault")]
    assert "still_vibrating" in faults
    assert laboratory.records()[-1].kind == "stop"


def test_a_complete_run_is_complete_and_the_fault_is_told(laboratory, monkeypatch):
    def frozen(plate):
        if done:
            raise StillVibrating("GEN: the output could not be switched off")
        silence(plate)

    done, silence = [], MockPlate._silence
    monkeypatch.setattr(MockPlate, "_silence", frozen)
    operator = UnattendedOperator()
    monkeypatch.setattr(
        operator, "tell", lambda told: done.append(1) if told.done >= told.planned > 0 else None
    )
    with pytest.raises(StillVibrating, match=BY_HAND):
        laboratory.run(operator=operator)
    assert [record.kind for record in laboratory.records()][-2:] == ["fault", "end"]


@pytest.mark.parametrize("act", [pause, sensor_fault, lose])
def test_what_to_do_by_hand_stays_on_the_screen_until_the_plate_is_connected(laboratory, act):
    operator = Operator(laboratory, act)
    with pytest.raises(StillVibrating):
        laboratory.run(operator=operator)
    faults = [status for status in operator.told if status.state == "fault"]
    assert len(faults) == 3
    assert all(BY_HAND in status.message for status in faults)
    assert {status.code for status in faults} == {"still_vibrating"}


def test_a_note_does_not_hide_what_to_do_by_hand(laboratory):
    class Noting(Operator):
        noted = False

        def poll(self):
            if self._state == "fault" and not self.noted:
                self.noted = True
                return Request(what="note", reason="smoke")
            return super().poll()

    operator = Noting(laboratory, sensor_fault)
    with pytest.raises(StillVibrating):
        laboratory.run(operator=operator)
    [noted] = [status for status in operator.told if "the note was saved" in status.message]
    assert BY_HAND in noted.message


def test_after_the_drive_was_switched_off_by_hand_the_session_goes_on(laboratory):
    class Hand(Operator):
        def poll(self):
            if self._state == "fault":
                del self.laboratory.plate._silence, self.laboratory.plate._connect
            return super().poll()

    operator = Hand(laboratory, sensor_fault)
    assert laboratory.run(operator=operator) == "complete"
    assert operator.told[-1].code == ""
