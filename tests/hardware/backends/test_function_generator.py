"""The generator's driver against a simulated instrument."""

import datetime as dt
import itertools
import math
import re
from pathlib import Path

import pytest

from slipscale.faults import UserError
from slipscale.hardware.backends import generator_line
from slipscale.hardware.backends.function_generator import FunctionGenerator
from slipscale.hardware.backends.generator_dialects import DIALECTS
from slipscale.hardware.backends.generator_line import GeneratorLine
from slipscale.hardware.calibration.record import (
    Calibration,
    Device,
    DriveChain,
    Gain,
    Point,
    Provenance,
    Resonance,
    write_calibration,
)
from slipscale.hardware.clock import SystemClock, VirtualClock
from slipscale.hardware.errors import (
    GarbledReply,
    OverLimit,
    PlateFault,
    PlateNotFound,
    PlateRefused,
    StillVibrating,
    WrongDevice,
)
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.registry import open_plate
from slipscale.hardware.resonance_tracking import track
from slipscale.stimuli.surface import VirtualSurface

SIMULATED = f"{Path(__file__).with_name('generator.yaml')}@sim"
RESOURCE = "TCPIP0::generator::inst0::INSTR"


TODAY = dt.datetime.now(tz=dt.UTC).date()


def calibration(**drive):
    return Calibration(
        device=Device(backend="scpi", serial="MY50000042"),
        made=Provenance(date=TODAY, by="a test", instrument="none"),
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


class WatchedLine(GeneratorLine):
    """Writes down what goes over the wire; answers can be replaced."""

    def __init__(self, resource):
        super().__init__(resource, SIMULATED)
        self.wire = []
        self.answers = {}

    def write(self, command):
        self.wire.append(command)
        super().write(command)

    def ask(self, query):
        answer = super().ask(query)
        return self.answers.get(query, answer)


class Watched(FunctionGenerator):
    def __init__(self, resource=RESOURCE, **options):
        options.setdefault("calibration", calibration())
        super().__init__(resource, clock=SystemClock(), **options)
        self._output.line = line = WatchedLine(resource)
        self.wire, self.answers, self._ask = line.wire, line.answers, line.ask

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
    wide = PlateLimits(voltage_v=22)
    with Watched(calibration=calibration(**drive), limits=wide) as plate:
        presentation = plate.present(surface(2.3))
        assert plate.volts_pp() == (pytest.approx(vpp, rel=1e-5), True)
        assert float(plate._ask("FREQ?")) == 30_480
        assert presentation.settled_by == "wait"
        assert presentation.readback.kind == "applied"
        assert presentation.readback.amplitude_um_pp == pytest.approx(2.3, rel=1e-5)
        assert presentation.settle_time_s > 0.03


def test_the_limit_is_one_of_volts_peak_at_the_plate():
    """15 V RMS are 21.2 V peak: more than the 16.5 V that a plate may have."""
    with Watched(calibration=calibration(voltage_convention="V RMS")) as plate:
        assert plate.limits.voltage_v == 16.5
        plate.present(surface(1.7))
        with pytest.raises(OverLimit, match=r"21\.2132 V peak at the plate is outside 0 to 16\.5"):
            plate.present(surface(2.3))
        assert not plate.volts_pp()[1]


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
        with pytest.raises(PlateRefused, match=r"FREQ\? is 304 after 30480"):
            plate.present(surface(1.2))
        plate.answers["FREQ?"] = ""
        with pytest.raises(GarbledReply):
            plate.present(surface(1.2))


def test_an_output_that_stays_on_is_told():
    with Watched(calibration=calibration(amplifier_gain=10)) as plate:
        plate._machine = VirtualClock()
        plate.present(surface(1.2))
        plate.answers["OUTP?"] = "1"
        with pytest.raises(StillVibrating, match=r"still on.*may still vibrate.*Output key"):
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
    with pytest.raises(UserError, match="the SPEC says 5, the calibration was made with 10"):
        Watched(calibration=calibration(amplifier_gain=10), amplifier_gain=5)


def test_an_amplifiers_gain_is_never_guessed():
    with pytest.raises(UserError, match=r"gain is not known.*gain=20"):
        open_plate(f"scpi:{RESOURCE}", clock=SystemClock())
    with pytest.raises(UserError, match="gain is '-20', expected a number above 0"):
        open_plate(f"scpi:{RESOURCE},gain=-20", clock=SystemClock())


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
    plate = open_plate("scpi:/dev/ttyNONE,gain=1", clock=SystemClock())
    with pytest.raises(PlateNotFound):
        plate.connect()


# Makes, and drops of the line: generators simulated after their manuals, on a socket.

CHANNELS = [(make, channel) for make in DIALECTS for channel in (1, 2)]


def on_the_bench(bench, monkeypatch, **options):
    """A driver of a simulated generator that does not wait, but for a line that is gone."""
    monkeypatch.setattr(generator_line, "TIMEOUT_MS", 60)
    options.setdefault("calibration", calibration_of(bench))
    plate = FunctionGenerator(bench.resource, clock=VirtualClock(), **options)
    plate._machine = VirtualClock()
    return plate


def calibration_of(bench):
    made = calibration(amplifier_gain=10)
    serial = bench.generator.identity.split(",")[2]
    return made.model_copy(update={"device": Device(backend="scpi", serial=serial)})


@pytest.mark.parametrize("make, channel", CHANNELS)
def test_every_make_gets_the_volts_on_the_channel_chosen(bench, monkeypatch, make, channel):
    rig = bench(make)
    chosen, other = rig.generator.channel[channel], rig.generator.channel[3 - channel]
    other.on = False
    with on_the_bench(rig, monkeypatch, channel=channel) as plate:
        assert not chosen.on
        made = plate.present(surface(2.3))
        assert chosen.on
        assert chosen.plate_vpp() == pytest.approx(3.0, rel=1e-5)
        assert chosen.frequency_hz == 30_480
        assert (chosen.function[:3], chosen.offset_v) == ("SIN", 0)
        assert made.readback.amplitude_um_pp == pytest.approx(2.3, rel=1e-3)
        assert plate.present(surface(0)).readback.amplitude_um_pp == 0
        assert not chosen.on
        plate.present(surface(1.0))
    assert not rig.vibrating()
    assert other.vpp == 0.1
    assert rig.generator.errors == []


def test_a_generator_is_driven_where_its_resonance_was_tracked(bench, monkeypatch):
    rig = bench("keysight")
    with on_the_bench(rig, monkeypatch) as plate:
        moved_hz, half_hz = 30_450.0, 30_480 / 120

        def measured_um_pp():
            return 0.3 / math.hypot(1, (rig.generator.channel[1].frequency_hz - moved_hz) / half_hz)

        assert track(plate, measured_um_pp).refused == ""
        assert not rig.generator.channel[1].on
        plate.present(surface(1.0))
        assert rig.generator.channel[1].frequency_hz == pytest.approx(moved_hz, abs=0.1)


@pytest.mark.parametrize("make", DIALECTS)
def test_every_make_that_keeps_another_load_is_refused(bench, monkeypatch, make):
    rig = bench(make)
    obey = rig.generator.obey
    monkeypatch.setattr(
        rig.generator, "obey", lambda line: None if re.search("(INF|HZ)$", line) else obey(line)
    )
    with pytest.raises(PlateRefused, match=r"(LOAD|OUTP|IMP).* is .*5"):
        on_the_bench(rig, monkeypatch).connect()
    assert rig.generator.channel[1].on is False


def test_a_make_that_is_not_known_is_refused_with_the_remedy(bench, monkeypatch):
    rig = bench("tektronix")
    rig.generator.identity = "Nobody,F1,1,1"
    with pytest.raises(WrongDevice, match=r"'Nobody F1'.*dialect=.*keysight, rigol"):
        on_the_bench(rig, monkeypatch).connect()
    named = on_the_bench(
        rig, monkeypatch, calibration=None, amplifier_gain=10, dialect=DIALECTS["tektronix"]
    )
    with named:
        assert named.identity.model == "F1"


def test_the_spec_names_channel_and_dialect():
    address = f"scpi:{RESOURCE},gain=10,channel=2,dialect=rigol"
    plate = open_plate(address, clock=SystemClock())
    assert (plate._output.channel, plate._output.dialect.name) == (2, "rigol")
    with pytest.raises(UserError, match="channel is '3', expected 1 or 2"):
        open_plate(f"scpi:{RESOURCE},gain=10,channel=3", clock=SystemClock())
    with pytest.raises(UserError, match="dialect is 'hp', expected one of keysight"):
        open_plate(f"scpi:{RESOURCE},gain=10,dialect=hp", clock=SystemClock())


def session(plate):
    with plate:
        plate.present(surface(1.2))
        plate.present(surface(0.5))
        plate.silence()
        plate.present(surface(2.3))
        plate.read_back()
        plate.present(surface(0))


@pytest.mark.parametrize("for_good", [False, True], ids=["and comes back", "for good"])
@pytest.mark.parametrize("make", ["keysight", "siglent"])
def test_a_line_that_drops_at_any_command_leaves_no_plate_on_unsaid(
    bench, monkeypatch, make, for_good
):
    """What comes back is switched off; what does not is said, with what to do by hand."""
    whole = bench(make)
    session(on_the_bench(whole, monkeypatch))
    assert len(whole.lines) > 80
    unsaid, said = [], 0
    for position in range(1, len(whole.lines) + 1):
        rig = bench(make)
        for channel in rig.generator.channel.values():
            channel.on = False
        rig.drop_at, rig.for_good = position, for_good
        plate = on_the_bench(rig, monkeypatch)
        plate._machine = VirtualClock()
        told = None
        try:
            session(plate)
        except PlateFault as fault:
            told = fault
        if rig.vibrating() and not isinstance(told, StillVibrating):
            unsaid.append((position, rig.lines[position - 1], told))
        said += isinstance(told, StillVibrating)
        if rig.vibrating() and not for_good:
            unsaid.append((position, "still on", told))
    assert unsaid == []
    assert (said > 50) == for_good


@pytest.mark.parametrize("within", [False, True], ids=["between commands", "within a command"])
def test_who_interrupts_a_session_is_told_too_when_the_plate_is_out_of_reach(
    bench, monkeypatch, within
):
    rig = bench("keysight")
    plate = on_the_bench(rig, monkeypatch)

    def interrupt():
        rig.drop_at, rig.for_good = len(rig.lines) + 1, True
        raise KeyboardInterrupt

    def interrupted():
        with plate:
            plate.present(surface(1.2))
            if within:
                monkeypatch.setattr(plate, "_read_back", interrupt)
                plate.read_back()
            interrupt()

    with pytest.raises(StillVibrating, match=r"may still vibrate.*switch the drive off by hand"):
        interrupted()
    plate.close()  # told once is enough
