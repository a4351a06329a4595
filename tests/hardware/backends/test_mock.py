import itertools

import pytest

from slipscale.faults import UserError
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.errors import FAULTS, ConnectionLost, NotReached, PlateFault, PlateTimeout
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.surface import VirtualSurface

PAPER = (0.0, 0.5, 1.2, 2.3)


def surface(amplitude_um_pp):
    return VirtualSurface(level=amplitude_um_pp)


def session(plate, amplitudes, *, silent_between):
    """Present, let the participant explore and answer, read back again; return all readings."""
    readings = []
    for amplitude in amplitudes:
        begun = plate.clock.now()
        presentation = plate.present(surface(amplitude))
        plate.clock.sleep(3.7)
        plate.check()
        readings.append((begun, presentation, plate.read_back()))
        if silent_between:
            plate.silence()
    return readings


@pytest.mark.parametrize("amplitude", PAPER)
def test_the_papers_surfaces_are_reached_and_read_back(amplitude):
    with open_plate("mock", clock=VirtualClock(), seed=1) as plate:
        presentation = plate.present(surface(amplitude))
        assert presentation.readback.kind == "measured"
        assert presentation.readback.level == pytest.approx(amplitude, abs=0.03)
        assert plate.vibration_level() == pytest.approx(amplitude, abs=1e-9)


def test_nothing_waits_on_a_virtual_clock_but_its_time_passes():
    clock = VirtualClock()
    with open_plate("mock", clock=clock) as plate:
        presentation = plate.present(surface(2.3))
    assert presentation.settle_time_s == pytest.approx(0.05, abs=0.005)
    assert clock.now() == pytest.approx(presentation.settle_time_s)


def test_the_envelope_is_ramped_without_a_jump():
    class Watching(VirtualClock):
        def sleep(self, duration_s):
            for _ in range(8):
                super().sleep(duration_s / 8)
                amplitudes.append(plate.vibration_level())

    amplitudes = [0.0]
    plate = open_plate("mock", clock=Watching())
    plate.connect()
    plate.present(surface(2.3))
    rises = [after - before for before, after in itertools.pairwise(amplitudes)]
    assert max(rises) < 0.08  # without a ramp: 0.6
    assert min(rises) > -1e-3


def test_silence_leaves_nothing_after_a_few_time_constants():
    clock = VirtualClock()
    plate = open_plate("mock", clock=clock)
    plate.connect()
    plate.present(surface(2.3))
    plate.silence()
    clock.sleep(0.01)
    assert plate.vibration_level() < 1e-6


@pytest.mark.parametrize("silent_between", [True, False])
@pytest.mark.parametrize("resumed_at", range(4))
def test_a_resumed_session_reads_back_what_an_undisturbed_one_would(resumed_at, silent_between):
    plate = open_plate("mock", clock=VirtualClock(), seed=9)
    plate.connect()
    undisturbed = session(plate, PAPER, silent_between=silent_between)

    clock = VirtualClock()
    again = open_plate("mock", clock=clock, seed=9)
    clock.set(undisturbed[resumed_at][0])
    again.connect()
    resumed = session(again, PAPER[resumed_at:], silent_between=silent_between)
    assert resumed == undisturbed[resumed_at:]


def test_looking_at_the_plate_does_not_change_it():
    def readings(looks):
        clock = VirtualClock()
        plate = open_plate("mock", clock=clock, seed=4)
        plate.connect()
        plate.present(surface(1.2))
        for _ in range(looks):
            plate.vibration_level()
            plate.check()
        clock.sleep(1.0)
        return plate.read_back()

    assert readings(0) == readings(50)


def test_a_finger_that_saturates_the_drive_is_a_fault_and_the_plate_falls_silent():
    clock = VirtualClock()
    plate = open_plate("mock:finger=0.0033333", clock=clock)
    plate.connect()
    plate.present(surface(1.2))
    with pytest.raises(NotReached):
        plate.present(surface(2.3))
    clock.sleep(0.1)
    assert plate.vibration_level() < 1e-9


@pytest.mark.parametrize("code", sorted(FAULTS))
@pytest.mark.parametrize("phase", ["connect", "present", "read_back", "check"])
def test_a_fault_on_order_comes_at_its_command_silences_and_is_over_after_a_reconnect(code, phase):
    clock = VirtualClock()
    plate = open_plate(f"mock:fault={code}@{phase}/2", clock=clock)

    def trial():
        plate.close()
        plate.connect()
        plate.present(surface(1.2))
        plate.read_back()
        plate.check()

    trial()
    with pytest.raises(FAULTS[code], match="as requested"):
        trial()
    plate.silence()
    clock.sleep(0.1)
    assert plate.vibration_level() < 1e-9
    trial()
    assert plate.vibration_level() == pytest.approx(1.2)


def test_a_lost_line_stays_lost_until_one_connects_again():
    plate = open_plate("mock", clock=VirtualClock())
    plate.connect()
    plate.inject("lost", phase="check")
    for command in (plate.check, plate.read_back, plate.check):
        with pytest.raises(ConnectionLost):
            command()
    plate.connect()
    plate.read_back()


def test_commands_are_logged_with_their_times():
    clock = VirtualClock()
    plate = MockPlate(clock=clock)
    plate.connect()
    clock.sleep(2)
    plate.present(surface(0.5))
    plate.silence()
    assert [(each.name, each.amplitude_um_pp) for each in plate.log] == [
        ("connect", None),
        ("present", 0.5),
        ("silence", None),
    ]
    assert plate.log[1].time_s == 2


def test_a_silence_that_times_out_can_be_repeated():
    clock = VirtualClock()
    plate = open_plate("mock:fault=time_out@silence", clock=clock)
    plate.connect()
    plate.present(surface(2.3))
    with pytest.raises(PlateTimeout):
        plate.silence()
    plate.silence()
    clock.sleep(0.1)
    assert plate.vibration_level() < 1e-9


@pytest.mark.parametrize(
    "address, said",
    [
        ("mock:speed=3", "'speed=3' is not an option"),
        ("mock:q=tall", "q is 'tall', expected a number"),
        ("mock:q=nan", "expected a number"),
        ("mock:q=-5", "quality_factor is -5"),
        ("mock:noise=-1", "noise is '-1', expected a number, 0 or more"),
        ("mock:fault=gremlin@3", "expected FAULT"),
        ("mock:fault=lost@lunch/3", "expected FAULT"),
        ("mock:fault=lost@0", "expected FAULT"),
        ("mock:q=60,q=70", "'q=70' is not an option"),
    ],
)
def test_a_wrong_address_is_one_sentence(address, said):
    with pytest.raises(UserError, match=said) as caught:
        open_plate(address, clock=VirtualClock())
    assert not isinstance(caught.value, PlateFault)
