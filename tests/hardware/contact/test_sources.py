"""Sources of position and force: what they tell, and what is said of wrong SPECs, lost cables."""

import math
import sys
from dataclasses import replace
from types import SimpleNamespace

import pytest

from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.contact import daq
from slipscale.hardware.contact.emulated_line import EmulatedLine, stroking
from slipscale.hardware.contact.registry import open_source
from slipscale.hardware.contact.serial_columns import SILENT_S
from slipscale.hardware.contact.source import Sample, SensorFault, Surroundings, Touch
from slipscale.stimuli.film.shared_load import band
from slipscale.stimuli.surface import VirtualSurface, peak_from_pp
from tests.support.patient_host import PatientHost


class Moving:
    """A finger that goes along x at 50 mm/s and presses with 0.5 N."""

    def __init__(self, unit="mm", speed=50.0):
        self.unit, self.speed = unit, speed

    def at(self, time_s):
        return Touch(self.speed * time_s, 3.0, 0.5)


def virtual(finger=None, vibration_um_pp=0.0):
    return Surroundings(
        clock=VirtualClock(), seed=1, finger=finger, vibration_level=lambda: vibration_um_pp
    )


def wait_for(source, count, clock):
    """Return at least so many samples."""
    found, end_s = [], clock.now() + 60
    while len(found) < count and clock.now() < end_s:
        found += source.take()
        clock.sleep(0.01)
    return found


# The pointer of a window ----------------------------------------------------------------------


def test_a_pointer_is_turned_into_the_stroke_and_its_pixels_into_millimetres():
    around = virtual(Moving("px"))
    source = open_source("position", "mouse:mm_per_pixel=0.5,angle=90", around)
    around.clock.sleep(2.0)
    [(time_s, (along, across))] = source.take()
    assert (time_s, along, across) == pytest.approx((2.0, 1.5, -50.0))


def test_a_pointer_off_the_window_is_no_finger():
    around = virtual(SimpleNamespace(unit="px", at=lambda _: None))
    assert open_source("position", "mouse:mm_per_pixel=1", around).take() == []


# A script -------------------------------------------------------------------------------------


def test_a_script_begins_anew_with_each_exploration(tmp_path):
    file = tmp_path / "way.csv"
    file.write_text("time_s,x_mm,y_mm\n0,1,0\n0.5,2,0\n1,3,0\n")
    around = virtual()
    source = open_source("position", f"scripted:{file}", around)
    for _ in range(2):
        around.clock.sleep(0.3)
        source.begin()
        assert [each.values[0] for each in source.take()] == [1]
        around.clock.sleep(0.6)
        assert [each.values[0] for each in source.take()] == [2]
        around.clock.sleep(5.0)
        assert [each.values[0] for each in source.take()] == [3]
        around.clock.sleep(1.0)
        assert source.take() == [Sample(around.clock.now(), (3, 0))]  # it stays where it is


@pytest.mark.parametrize(
    "text, wrong",
    [
        ("", "line 1: expected the columns"),
        ("t,x,y\n", "line 1: expected the columns"),
        ("time_s,x_mm,y_mm\n", "expected at least one row"),
        ("time_s,x_mm,y_mm\n0,1,0\n1,nan,0\n", "line 3"),
        (
            "time_s,x_mm,y_mm\n1,1,0\n0.5,1,0\n",
            "line 3: expected 3 numbers, and a time of at least 1",
        ),
        ("time_s,x_mm,y_mm\n0,1\n", "line 2"),
    ],
)
def test_a_script_that_cannot_be_followed_is_named_by_its_line(tmp_path, text, wrong):
    file = tmp_path / "way.csv"
    file.write_text(text)
    with pytest.raises(UserError, match=wrong):
        open_source("position", f"scripted:{file}", virtual())


# Simulated ------------------------------------------------------------------------------------


def test_a_simulated_finger_is_read_on_a_grid_however_often_it_is_asked():
    def told(pauses):
        around = virtual(Moving())
        source = open_source("position", "simulated:rate=100", around)
        source.begin()
        found = []
        for pause_s in pauses:
            around.clock.sleep(pause_s)
            found += source.take()
        return [(round(each.time_s, 9), each.values) for each in found]

    assert told([1.0]) == told([0.25, 0.003, 0.247, 0.5])
    assert len(told([1.0])) == 101


def test_a_simulated_force_is_what_the_film_of_the_amplitude_leaves():
    for amplitude_um_pp in (0.0, 1.2, 2.3):
        around = virtual(Moving(), amplitude_um_pp)
        source = open_source("force", "simulated:friction=0.8,noise=0", around)
        source.begin()
        around.clock.sleep(0.1)
        normal_n, lateral_n = source.take()[-1].values
        relative = VirtualSurface(level=amplitude_um_pp).predicted_relative_friction()
        assert normal_n == 0.5
        assert lateral_n / normal_n == pytest.approx(0.8 * relative, rel=1e-6)


def test_a_finger_that_levitates_has_no_friction():
    around = virtual(SimpleNamespace(unit="mm", at=lambda t: Touch(50 * t, 0, 0.02)), 2.3)
    with pytest.raises(UserError, match="noise is '-1', expected a number, 0 or more"):
        open_source("force", "simulated:noise=-1", around)
    source = open_source("force", "simulated:noise=0", around)
    around.clock.sleep(0.1)
    assert source.take()[-1].values[1] == 0.0


def test_under_a_shared_load_each_participant_has_a_skin_of_their_own_within_the_band():
    def friction(participant):
        around = replace(virtual(Moving(), 1.2), participant=participant)
        source = open_source("force", "simulated:film=shared_load,friction=0.8,noise=0", around)
        source.begin()
        around.clock.sleep(0.1)
        normal_n, lateral_n = source.take()[-1].values
        assert source.describe()["film"] == "shared_load"
        return lateral_n / normal_n

    found = [friction(label) for label in ("01", "02", "03")]
    assert len(set(found)) == 3
    assert friction("01") == found[0]
    least, most = band(peak_from_pp(1.2))
    assert all(0.8 * least <= each <= 0.8 * most for each in found)


# Serial: first over a pseudo-terminal, without a time limit, then in virtual time ---------------


def test_lasers_and_load_cells_are_read_from_a_port_in_their_units():
    around = Surroundings(clock=PatientHost())
    with EmulatedLine() as line:
        spec = f"lasers:{line.port},x_scale=2,x_zero=-1"
        with open_source("position", spec, around) as source:
            places = wait_for(source, 60, around.clock)
        spec = f"load_cells:{line.port},normal=3,lateral=4"
        with open_source("force", spec, around) as source:
            forces = wait_for(source, 20, around.clock)
    assert min(each.values[0] for each in places) < -20
    assert all(-38 - 0.1 <= each.values[0] <= 42.1 for each in places)
    assert [each.time_s for each in places] == sorted(each.time_s for each in places)
    assert {abs(each.values[1]) for each in forces} == {0.3}
    assert {each.values[0] for each in forces} == {0.5}


def test_a_sensor_that_is_unplugged_is_a_fault():
    around = Surroundings(clock=PatientHost())
    with EmulatedLine() as line, open_source("position", f"lasers:{line.port}", around) as source:
        line.unplug()
        with pytest.raises(SensorFault):
            wait_for(source, 10_000, around.clock)


def test_the_tare_is_taken_once_with_no_finger_on_the_plate(host):
    line = host.plug_in_sensor(lambda _: b"7.5;-2\n")
    spec = f"load_cells:{line.port},tare=0.1,normal_scale=2"
    with open_source("force", spec, Surroundings(clock=host)) as source:
        forces = wait_for(source, 5, host)
    assert {each.values for each in forces} == {(0.0, 0.0)}


def test_lines_that_are_no_readings_are_left_out(host):
    lines = [b"boot\n", b"1\n", b"nan,2\n", b"\xff\xfe\n", b"1 \t 2\r\n"]
    line = host.plug_in_sensor(lambda t: lines[round(t * 100) % len(lines)])
    with open_source("position", f"lasers:{line.port}", Surroundings(clock=host)) as source:
        places = wait_for(source, 5, host)
        assert source.unreadable >= 4
    assert {each.values for each in places} == {(1.0, 2.0)}


def test_a_sensor_that_falls_silent_is_a_fault_and_can_come_back(host):
    line = host.plug_in_sensor(stroking)
    with open_source("position", f"lasers:{line.port}", Surroundings(clock=host)) as source:
        wait_for(source, 310, host)  # longer than a sensor may take to start
        line.sends = False
        silent_s = host.now()
        with pytest.raises(SensorFault, match="sent no reading"):
            wait_for(source, 10_000, host)
        assert host.now() - silent_s == pytest.approx(SILENT_S, abs=0.03)
        line.sends = True
        source.begin()
        assert len(wait_for(source, 3, host)) == 3


def test_a_port_that_sends_no_numbers_is_told_with_what_it_sends(host):
    line = host.plug_in_sensor(lambda _: b"$GPGGA,no fix\n")
    with (
        pytest.raises(SensorFault, match=r"the last line was '\$GPGGA,no fix'"),
        open_source("position", f"lasers:{line.port}", Surroundings(clock=host)),
    ):
        pytest.fail("it was connected")


# The data acquisition device ------------------------------------------------------------------


class FakeTask:
    """What nidaqmx.Task does of what is used here."""

    fails = False

    def __init__(self):
        self.channels, self.closed = [], False
        self.ai_channels = SimpleNamespace(add_ai_voltage_chan=self.channels.append)
        self.timing = SimpleNamespace(cfg_samp_clk_timing=lambda *_, **__: None)

    def start(self):
        pass

    def read(self, *, number_of_samples_per_channel):
        assert number_of_samples_per_channel == -1
        if self.fails:
            raise OSError("device gone\nlong story")
        return [[0.1, 0.2], [0.01, -0.02]]

    def close(self):
        self.closed = True


@pytest.fixture
def library(monkeypatch):
    fake = SimpleNamespace(
        Task=FakeTask,
        constants=SimpleNamespace(
            AcquisitionType=SimpleNamespace(CONTINUOUS=1), READ_ALL_AVAILABLE=-1
        ),
        errors=SimpleNamespace(Error=OSError),
    )
    monkeypatch.setitem(sys.modules, "nidaqmx", fake)
    monkeypatch.setattr(FakeTask, "fails", False)


DAQ = "daq:normal=Dev1/ai0,lateral=Dev1/ai1,normal_scale=10,lateral_scale=5,rate=100"


def test_volts_of_a_daq_are_forces_and_the_last_sample_is_of_now(library):
    around = virtual()
    around.clock.sleep(1.0)
    with open_source("force", DAQ, around) as source:
        found = source.take()
    assert [each.values for each in found] == [
        pytest.approx((1.0, 0.05)),
        pytest.approx((2.0, -0.1)),
    ]
    assert [each.time_s for each in found] == pytest.approx([0.99, 1.0])


def test_a_daq_that_goes_is_a_fault_and_is_opened_again(library, monkeypatch):
    with open_source("force", DAQ, virtual()) as source:
        monkeypatch.setattr(FakeTask, "fails", True)
        with pytest.raises(SensorFault, match="device gone"):
            source.take()
        monkeypatch.setattr(FakeTask, "fails", False)
        source.begin()
        assert source.take()


def test_a_missing_library_is_one_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "nidaqmx", None)
    with pytest.raises(UserError, match=r"pip install 'slipscale\[daq\]'"):
        daq.load_library()


# SPECs ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "kind, spec, told",
    [
        ("position", "camera", "expected one of emulated_stage, lasers, mouse"),
        ("force", "camera", "expected one of ati, daq, load_cells, simulated, none"),
        ("position", "mouse", "expected mm_per_pixel"),
        ("position", "mouse:mm_per_pixel=0", "expected a number above 0"),
        ("position", "mouse:mm_per_pixel=1", "no window"),
        ("position", "scripted", "expected scripted:FILE"),
        ("position", "scripted:nowhere.csv", "cannot be read"),
        ("position", "simulated", "are only for simulated participants"),
        ("position", "lasers", "expected lasers:PORT"),
        ("position", "lasers:COM3,x=0", "expected the position of x"),
        ("position", "lasers:COM3,x=1.5", "expected the number's position in the line"),
        ("position", "lasers:COM3,x_scale=0", "a number other than 0"),
        ("position", "lasers:COM3,tare=-1", "0 to 60 seconds"),
        ("force", "load_cells:COM3,lateral=0", "expected the position of normal"),
        ("force", "daq:normal=Dev1/ai0", "also requires normal_scale, lateral, lateral_scale"),
        ("force", "simulated:friction=-1", "expected a number above 0"),
        ("force", "simulated:film=air", "film is 'air', expected reynolds or shared_load"),
    ],
)
def test_a_wrong_spec_is_one_sentence(kind, spec, told, library):
    with pytest.raises(UserError, match=told):
        open_source(kind, spec, virtual())


def test_a_port_that_is_not_there_is_the_rigs_fault(tmp_path):
    with pytest.raises(Exception, match="no such port") as caught:
        open_source("position", f"lasers:{tmp_path / 'none'}", virtual()).connect()
    assert caught.value.code == "not_there"


def test_time_of_a_simulated_reading_is_the_grids_to_rounding():
    around = virtual(Moving())
    source = open_source("position", "simulated:noise=0", around)
    around.clock.sleep(math.pi)
    source.begin()
    around.clock.sleep(0.02)
    assert [each.values[0] for each in source.take()] == pytest.approx(
        [50 * (math.pi + n / 100) for n in range(3)]
    )
