"""An actuator on an analogue output, in volts and in m/s²: the device in memory."""

import math
from dataclasses import replace
from types import SimpleNamespace

import pytest

from slipscale.experiments.running.begin_or_resume import plate_for
from slipscale.experiments.running.rehearsal import check_supported, surfaces
from slipscale.experiments.study.file import study_text
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError
from slipscale.hardware.backends.daq_device import TERMINALS
from slipscale.hardware.backends.daq_output import open_plate
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.conformance.contract import RULES, Rig, examine_backend
from slipscale.hardware.errors import ConnectionLost, NotReached, OverLimit, StillVibrating
from slipscale.hardware.records import Output
from slipscale.stimuli.surface import VirtualSurface

PLAN = RunPlan(study_name="a", study_text="", participant="01", seed=1, language="en", mode="pilot")


@pytest.fixture(autouse=True)
def _device():
    TERMINALS.__init__()


@pytest.fixture
def screen(plate_in_volts):
    file = plate_in_volts("daq", 1.0, (20.0, 1000.0))

    def made(more=",readback=emulated/ai0", per_volt=20):
        address = f"emulated/ao0,plate={file},frequency=125,per_volt={per_volt}{more}"
        return open_plate(address, clock=VirtualClock(), seed=0)

    return made


def surface(level):
    return VirtualSurface(level=level)


def test_volts_of_the_plate_are_at_the_terminal_and_are_read_back_from_it(screen):
    with screen() as plate:
        plate.connect()
        made = plate.present(surface(120.0))
        assert max(TERMINALS.output_v) == pytest.approx(6.0, rel=1e-3)
        assert made.readback.kind == "applied"
        assert made.readback.level == pytest.approx(120.0, abs=1e-6)
        assert plate.describe()["plate_file"]["limits"]["voltage_v_peak"] == 130.0
        assert plate.unfelt
    assert TERMINALS.output_v == [0.0]


def test_a_level_beyond_plate_or_terminal_is_refused_in_the_plates_unit(screen):
    with screen(",rate=12500") as plate:
        plate.connect()
        with pytest.raises(OverLimit, match="voltage 140 V peak is outside 0 to 130 V peak"):
            plate.present(surface(140.0))
    small = screen(per_volt=5)
    with pytest.raises(OverLimit, match=r"120 V peak needs 24\.00 V at the terminal"):
        small.check_supported(surface(120.0))


def test_an_output_that_makes_less_is_noticed_and_silenced(screen, monkeypatch):
    with screen() as plate:
        plate.connect()
        measured = plate._measure
        monkeypatch.setattr(plate, "_measure", lambda: 0.5 * measured())
        with pytest.raises(NotReached, match=r"100 V peak was commanded, but 50\.000 V peak was"):
            plate.present(surface(100.0))
        assert plate.output is Output.OFF
        assert TERMINALS.output_v == [0.0]


def test_a_device_that_goes_while_it_drives_is_said_to_be_on(screen):
    plate = screen()
    plate.connect()
    plate.present(surface(50.0))
    TERMINALS.unplugged = True
    with pytest.raises(StillVibrating, match="switch the amplifier off"):
        plate.read_back()
    assert plate.output is Output.UNREACHABLE
    TERMINALS.unplugged = False
    with pytest.raises(ConnectionLost):
        plate.present(surface(50.0))
    plate.connect()
    assert (plate.output, TERMINALS.output_v) == (Output.OFF, [0.0])
    plate.close()


def test_it_keeps_the_drivers_contract_and_proves_nothing_without_a_readback(screen):
    for more, proves in ((",readback=emulated/ai0", "conforms"), ("", "not applicable")):
        plate = screen(more)
        told = {each.rule: each.outcome for each in examine_backend(Rig(plate, plate.clock))}
        assert told == {name: "conforms" for name, _ in RULES} | {
            "the readback can reveal a wrong amplitude": proves,
            "follow() reaches the amplitude": "not applicable",
        }


@pytest.mark.parametrize(
    "more, said",
    [
        (",rate=1000.5", "but 10 periods of 125 Hz must be a whole"),
        (",rate=250", "at least 4 per period"),
    ],
)
def test_a_sine_that_cannot_be_made_is_refused(screen, more, said):
    with pytest.raises(UserError, match=said):
        screen(more)


def test_the_sine_has_the_frequency_and_no_offset(screen):
    with screen() as plate:
        plate.connect()
        plate.present(surface(20.0))
        volts = TERMINALS.output_v
        assert len(volts) == 1000
        assert sum(volts) == pytest.approx(0, abs=1e-9)
        assert volts[25] == pytest.approx(math.sin(2 * math.pi * 0.25))


def test_without_the_library_the_extra_is_named(screen, monkeypatch, tmp_path):
    monkeypatch.setitem(__import__("sys").modules, "nidaqmx", None)
    file = tmp_path / "screen.toml"
    address = f"Dev1/ao0,plate={file},frequency=125,per_volt=20"
    screen()
    with pytest.raises(UserError, match="slipscale"):
        open_plate(address, clock=SimpleNamespace(), seed=0)


def test_a_study_in_its_quantity_is_presented_and_another_is_refused(screen, monkeypatch):
    text = (
        'name = "a"\ntitle = "a"\nvoltages_v_peak = [0.0, 40.0, 120.0]\n'
        '[quantity]\nname = "voltage"\nunit = "V"\nconvention = "peak"\n'
        '[plate]\nvoltage_v_peak = 130.0\n[[tasks]]\nprotocol = "magnitude_estimation"\n'
    )
    plan = replace(PLAN, study_text=text)
    where = "slipscale.experiments.running.begin_or_resume.open_plate"
    monkeypatch.setattr(where, lambda *_, **__: screen())
    with plate_for(plan, "daq:emulated/ao0", VirtualClock()) as plate:
        plate.connect()
        check_supported(plan, plate)
        for made in surfaces(plan):
            plate.present(made)
            assert max(TERMINALS.output_v) == pytest.approx(made.level / 20, abs=1e-9)
    with pytest.raises(UserError, match="makes voltage in V peak, but the study's levels are ampl"):
        plate_for(replace(PLAN, study_text=study_text("biet2007")), "daq", VirtualClock())
