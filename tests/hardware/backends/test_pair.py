"""Two actuators as one plate: both are driven, and a fault of either switches off both."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from slipscale.faults import UserError
from slipscale.hardware.address import Plate
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.backends.pair import PlatePair
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.errors import NotReached, OverLimit, PlateFault, StillVibrating
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.plate.twin import Drive, Twin
from slipscale.hardware.records import Output
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.quantity import made_by_plate
from slipscale.stimuli.surface import VirtualSurface
from slipscale.stimuli.texture import Grating

VOLTS = PlateLimits(
    quantity=made_by_plate("voltage", "V", "peak"), level=150.0, deviation_level=3.0
)
ON = VirtualSurface(level=1.2)


@pytest.fixture
def pair():
    clock = VirtualClock()
    first, second = (
        MockPlate(clock=clock, plate=Plate(limits=limits), twin=Twin(noise_um=0))
        for limits in (PlateLimits(), VOLTS)
    )
    with PlatePair(first, second) as pair:
        pair.second_level = 100.0
        yield pair


@pytest.fixture
def board_of_1_5_um():
    """A pair whose first plate narrows its limits when it connects, as a board does."""

    class Narrowing(MockPlate):
        def _connect(self):
            self.limits = replace(self.limits, level=1.5)
            return super()._connect()

    clock = VirtualClock()
    return PlatePair(Narrowing(clock=clock), MockPlate(clock=clock, plate=Plate(limits=VOLTS)))


def levels(pair):
    pair.clock.sleep(0.1)
    return tuple(round(each.vibration_level(), 3) for each in (pair.first, pair.second))


def test_both_are_driven_each_in_its_own_quantity_and_silenced_together(pair):
    made = pair.present(ON)
    assert (made.commanded_level, made.second_readback_level) == (1.2, pytest.approx(100))
    assert levels(pair) == (1.2, 100)
    pair.silence()
    assert levels(pair) == (0, 0)
    assert pair.output is Output.OFF


def test_the_first_at_rest_is_not_off_while_the_second_is_driven(pair):
    pair.present(VirtualSurface(level=0.0))
    assert levels(pair) == (0, 100)
    assert pair.output is Output.MAY_BE_ON


@pytest.mark.parametrize("faulty", ["first", "second"])
@pytest.mark.parametrize("fault", ["lost", "time_out", "still_vibrating"])
@pytest.mark.parametrize("phase", ["present", "read_back", "check", "silence"])
def test_a_fault_of_either_switches_off_the_other(pair, faulty, fault, phase):
    pair.present(ON)
    getattr(pair, faulty).inject(fault, phase=phase)
    act = (lambda: pair.present(ON)) if phase == "present" else getattr(pair, phase)
    with pytest.raises(PlateFault):
        act()
    # The twin of the faulty one keeps vibrating if its silence failed.
    other = pair.second if faulty == "first" else pair.first
    assert other.twin.drive.target_um_pp is None
    assert pair.output is not Output.MAY_BE_ON
    if phase == "silence" or fault == "lost":
        assert pair.output is Output.UNREACHABLE
        with pytest.raises(PlateFault, match="nothing can be presented"):
            pair.present(ON)


def test_a_signal_while_the_first_is_silenced_does_not_leave_the_second_on(pair, monkeypatch):
    def interrupted():
        raise KeyboardInterrupt

    pair.present(ON)
    monkeypatch.setattr(pair.first, "_silence", interrupted)
    with pytest.raises(KeyboardInterrupt):
        pair.silence()
    assert pair.second.output is Output.OFF
    monkeypatch.undo()


def test_that_one_may_still_vibrate_is_not_hidden_by_a_fault_of_the_other(pair):
    pair.present(ON)
    pair.first.inject("lost", phase="silence")
    pair.second.inject("still_vibrating", phase="silence")
    with pytest.raises(StillVibrating):
        pair.silence()


def test_that_one_may_still_vibrate_is_told_again_when_the_pair_is_closed(pair, monkeypatch):
    def stuck():
        raise StillVibrating("the output could not be switched off")

    pair.present(ON)
    monkeypatch.setattr(pair.first, "_silence", stuck)
    for attempt in (pair.silence, pair.close, pair.close):
        with pytest.raises(StillVibrating):
            attempt()
    assert levels(pair) == (1.2, 0)
    monkeypatch.undo()


def test_a_second_actuator_that_drifts_is_a_fault(pair):
    pair.present(ON)
    pair.second.twin.set_drive(Drive(target_um_pp=1.0), pair.clock.now())
    pair.clock.sleep(0.1)
    with pytest.raises(NotReached, match="100 V peak was commanded"):
        pair.read_back()
    assert levels(pair) == (0, 0)


def test_the_calibration_of_another_plate_is_harmless_if_the_first_is_simulated(pair):
    pair.calibration = pair.first.calibration = SimpleNamespace(voltage_v_peak=lambda _: 99.0)
    assert pair.present(ON).predicted_v_peak == 99.0
    pair.present(Grating(spatial_period_mm=5.0, mean_level=1.0, depth_level=0.5))
    pair.read_back()


def test_a_level_beyond_the_second_s_limit_is_refused_before_anything_moves(pair):
    pair.present(ON)
    pair.second_level = 151.0
    with pytest.raises(OverLimit, match="voltage 151 V peak is outside 0 to 150"):
        pair.present(ON)
    assert levels(pair) == (1.2, 100)


def test_the_limits_that_the_first_learns_when_it_connects_are_the_pairs(board_of_1_5_um):
    with board_of_1_5_um as pair:
        assert pair.limits.level == 1.5
        with pytest.raises(OverLimit, match=r"amplitude 2\.3 µm p-p is outside 0 to 1\.5"):
            pair.check_supported(VirtualSurface(level=2.3))


def test_what_the_first_cannot_produce_is_refused_before_the_session(pair, monkeypatch):
    def impossible(level):
        raise OverLimit(f"{level:g} needs more than the amplifier supplies")

    monkeypatch.setattr(pair.first, "_check_possible", impossible)
    with pytest.raises(OverLimit, match="2 needs more"):
        pair.check_supported(VirtualSurface(level=2.0))


@pytest.mark.parametrize("address", ["mock", "mock+mock+mock", "mock+", ""])
def test_a_pair_has_two_specs(address):
    with pytest.raises(UserError, match=r"expected two SPECs separated by [+]"):
        open_plate(f"pair:{address}", clock=VirtualClock())


def test_a_slow_actuator_is_no_frozen_session_for_the_other(monkeypatch):
    clock = VirtualClock()
    first, second = (MockPlate(clock=clock) for _ in range(2))
    first.frozen_s = second.frozen_s = 1.0
    drive = first._drive
    first._drive = lambda level: (clock.sleep(3.0), drive(level))[1]  # type: ignore[method-assign]
    with PlatePair(first, second) as plate:
        plate.second_level = 1.0
        for level in (1.2, 0.8):
            plate.present(VirtualSurface(level=level))
            plate.check()
