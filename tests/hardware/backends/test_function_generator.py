"""The generator's driver against a simulated instrument."""

import datetime as dt
import itertools
import math
import re
from pathlib import Path

import pytest

from faults import UserError
from hardware.backends.function_generator import FunctionGenerator
from hardware.calibration.record import (
    Calibration,
    Device,
    DriveChain,
    Gain,
    Point,
    Provenance,
    Resonance,
    write_calibration,
)
from hardware.clock import SystemClock
from hardware.errors import GarbledReply, OverLimit, PlateNotFound, PlateRefused, WrongDevice
from hardware.registry import open_plate
from stimuli.surface import VirtualSurface

SIMULATED = f"{Path(__file__).with_name('generator.yaml')}@sim"
RESOURCE = "TCPIP0::generator::inst0::INSTR"


def calibration(**drive):
    return Calibration(
        device=Device(backend="scpi", serial="MY50000042"),
        made=Provenance(date=dt.date(2026, 11, 21), by="a test", instrument="none"),
        drive=DriveChain(**drive),
        resonance=Resonance(
            frequency_hz=30_480.0,
            frequency_ci95_hz=1,
            quality_factor=60,
            quality_factor_ci95=1,
            residual_um=0.005,
        ),
        gain=Gain(
            um_pp_per_v=2.3 / 15,
            um_pp_per_v_ci95=0,
            residual_um=0.005,
            voltage_max_v=15,
            amplitude_max_um_pp=2.3,
        ),
        points=(Point(sweep="voltage", frequency_hz=30_480, voltage_v=15, amplitude_um_pp=2.3),),
    )


class Watched(FunctionGenerator):
    """Writes down what goes over the wire; answers can be replaced."""

    def __init__(self, resource=RESOURCE, **options):
        options.setdefault("calibration", calibration())
        super().__init__(resource, clock=SystemClock(), visa_library=SIMULATED, **options)
        self.wire = []
        self.answers = {}

    def _write(self, command):
        self.wire.append(command)
        super()._write(command)

    def _ask(self, query):
        answer = super()._ask(query)
        return self.answers.get(query, answer)

    def volts_pp(self):
        return float(self._ask("VOLT?")), self._ask("OUTP?") == "1"


def surface(amplitude_um_pp):
    return VirtualSurface(amplitude_um_pp=amplitude_um_pp)


def test_connecting_switches_the_output_off_before_anything_else():
    with Watched() as plate:
        assert plate.wire[0] == "OUTP 0"
        assert plate.identity.serial == "MY50000042"
        assert plate.notes == ()


@pytest.mark.parametrize(
    "drive, vpp",
    [
        ({}, 30),
        ({"amplifier_gain": 20}, 1.5),
        ({"voltage_convention": "V peak-to-peak"}, 15),
        ({"voltage_convention": "V RMS", "amplifier_gain": 10}, 1.5 * 2 * math.sqrt(2)),
    ],
)
def test_volts_of_every_convention_reach_the_generator_as_volts_peak_to_peak(drive, vpp):
    with Watched(calibration=calibration(**drive)) as plate:
        presentation = plate.present(surface(2.3))
        assert plate.volts_pp() == (pytest.approx(vpp, rel=1e-5), True)
        assert float(plate._ask("FREQ?")) == 30_480
        assert presentation.settled_by == "wait"
        assert presentation.readback.kind == "applied"
        assert presentation.readback.amplitude_um_pp == pytest.approx(2.3, rel=1e-5)
        assert presentation.settle_time_s > 0.03


def test_the_voltage_is_ramped_in_small_steps_up_and_down():
    with Watched(calibration=calibration(amplifier_gain=10)) as plate:
        plate.present(surface(2.3))
        plate.present(surface(0.5))
        wire = list(plate.wire)
    volts = [float(each.split()[1]) for each in wire if re.fullmatch(r"VOLT [\d.]+", each)]
    assert max(volts) == pytest.approx(3.0, rel=1e-3)
    assert max(abs(after - before) for before, after in itertools.pairwise(volts)) < 0.16 * 3.0


def test_zero_amplitude_is_output_off():
    with Watched(calibration=calibration(amplifier_gain=10)) as plate:
        plate.present(surface(1.2))
        presentation = plate.present(surface(0))
        assert plate.volts_pp()[1] is False
        assert presentation.readback.amplitude_um_pp == 0


def test_the_output_is_off_after_an_exception():
    """PyMeasure leaves it on."""

    def session(plate):
        with plate:
            plate.present(surface(1.2))
            raise ZeroDivisionError

    plate = Watched(calibration=calibration(amplifier_gain=10))
    with pytest.raises(ZeroDivisionError):
        session(plate)
    assert plate.wire[-1] == "OUTP 0"


def test_a_generator_that_complains_is_refused_and_silenced():
    with Watched(calibration=calibration(amplifier_gain=10)) as plate:
        plate.answers["SYST:ERR?"] = '-222,"Data out of range"'
        with pytest.raises(PlateRefused, match="-222"):
            plate.present(surface(1.2))
        assert plate.wire[-1] == "OUTP 0"


def test_a_truncated_answer_is_not_taken_for_the_truth():
    with Watched(calibration=calibration(amplifier_gain=10)) as plate:
        plate.answers["FREQ?"] = "304"  # of 30480
        with pytest.raises(PlateRefused, match="FREQ is 304 after 30480"):
            plate.present(surface(1.2))
        plate.answers["FREQ?"] = ""
        with pytest.raises(GarbledReply):
            plate.present(surface(1.2))


def test_an_output_that_stays_on_is_told():
    with Watched(calibration=calibration(amplifier_gain=10)) as plate:
        plate.present(surface(1.2))
        plate.answers["OUTP?"] = "1"
        with pytest.raises(PlateRefused, match="still on"):
            plate.silence()


def test_what_was_not_calibrated_is_refused_before_the_generator_hears_of_it():
    with Watched() as plate:
        heard = len(plate.wire)
        with pytest.raises(OverLimit):
            plate.present(surface(2.4))
        assert len(plate.wire) == heard


def test_without_a_calibration_it_can_be_driven_but_presents_nothing():
    with Watched(calibration=None, amplifier_gain=10) as plate:
        assert plate.excite(frequency_hz=30_500, voltage_v=5).kind == "none"
        assert plate.volts_pp() == (pytest.approx(1.0), True)
        with pytest.raises(UserError, match="needs calibration=FILE"):
            plate.present(surface(1.2))
        assert plate.volts_pp()[1] is False


def test_a_gain_other_than_the_calibrations_is_the_users_fault():
    with pytest.raises(UserError, match="gain is 5, but the calibration was made with 10"):
        Watched(calibration=calibration(amplifier_gain=10), amplifier_gain=5)


def test_another_instrument_is_the_wrong_device():
    with pytest.raises(WrongDevice, match="voltmeter"):
        Watched("TCPIP0::voltmeter::inst0::INSTR").connect()


def test_a_load_of_50_ohm_that_stays_is_refused():
    plate = Watched()
    plate.answers["OUTP:LOAD?"] = "+5.000000E+01"
    with pytest.raises(PlateRefused, match="OUTP:LOAD"):
        plate.connect()


def test_a_serial_port_is_a_resource_too():
    assert Watched("/dev/ttyUSB0").resource == "ASRL/dev/ttyUSB0::INSTR"


def test_the_spec_names_resource_calibration_and_gain(tmp_path):
    path = tmp_path / "plate.toml"
    write_calibration(calibration(amplifier_gain=20), path)
    plate = open_plate(f"scpi:{RESOURCE},calibration={path},gain=20", clock=SystemClock())
    assert plate.resource == RESOURCE
    assert plate.limits.amplitude_um_pp == 2.3
    with pytest.raises(UserError, match="scpi:RESOURCE"):
        open_plate("scpi:", clock=SystemClock())


def test_a_port_that_is_not_there_is_a_fault_of_the_rig():
    plate = open_plate("scpi:/dev/ttyNONE", clock=SystemClock())
    with pytest.raises(PlateNotFound):
        plate.connect()
