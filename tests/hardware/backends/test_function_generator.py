"""The generator's driver against a simulated instrument."""

import datetime as dt
import itertools
import math
import re

import pytest

from slipscale.faults import UserError
from slipscale.hardware.address import Plate
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
from slipscale.hardware.calibration.sweep import SweepPlan, calibration_from, sweep
from slipscale.hardware.clock import SystemClock, VirtualClock
from slipscale.hardware.emulator.generator_server import GeneratorServer
from slipscale.hardware.emulator.generators import MAKES, Keysight
from slipscale.hardware.errors import (
    ConnectionLost,
    GarbledReply,
    NotReached,
    OverLimit,
    PlateFault,
    PlateNotFound,
    PlateRefused,
    PlateTimeout,
    StillVibrating,
    WrongDevice,
)
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.records import Output
from slipscale.hardware.registry import open_plate
from slipscale.hardware.resonance_tracking import track
from slipscale.stimuli.surface import VirtualSurface
from tests.support.local_line import LocalLine

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


class WatchedLine(LocalLine):
    """Answers can be replaced."""

    def __init__(self, identity):
        generator = Keysight()
        generator.identity = identity
        generator.channel[1].on = True  # left on by the person who used it before
        super().__init__(generator)
        self.answers = {}

    def ask(self, query):
        answer = super().ask(query)
        return self.answers.get(query, answer)


class Watched(FunctionGenerator):
    def __init__(self, identity="Agilent Technologies,33521A,MY50000042,2.09", **options):
        facts = {key: options.pop(key) for key in ("calibration", "limits") if key in options}
        plate = Plate(**{"calibration": calibration(amplifier_gain=10)} | facts)
        self.line = WatchedLine(identity)
        super().__init__(self.line, clock=SystemClock(), plate=plate, **options)
        self.wire, self.answers, self._ask = self.line.wire, self.line.answers, self.line.ask
        self.channel = self.line.generator.channel[1]

    def volts_pp(self):
        return float(self._ask("VOLT?")), self._ask("OUTP?") == "1"


def surface(amplitude_um_pp):
    return VirtualSurface(level=amplitude_um_pp)


def test_connecting_switches_the_output_off_before_anything_else():
    with Watched() as plate:
        assert plate.wire[:2] == ["*IDN?", "OUTP 0"]
        assert plate.identity.serial == "MY50000042"
        assert plate.notes == ()


@pytest.mark.parametrize(
    "drive, vpp",
    [
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
        assert presentation.readback.level == pytest.approx(2.3, rel=1e-5)
        assert presentation.settle_time_s > 0.03


def test_the_limit_is_one_of_volts_peak_at_the_plate():
    """15 V RMS are 21.2 V peak: more than the 16.5 V that a plate may have."""
    rms = calibration(voltage_convention="V RMS", amplifier_gain=10)
    with Watched(calibration=rms) as plate:
        assert plate.limits.voltage_v == 16.5
        plate.present(surface(1.7))
        with pytest.raises(OverLimit, match=r"21\.2132 V peak at the plate is outside 0 to 16\.5"):
            plate.check_supported(surface(2.3))
        before = plate.volts_pp()
        with pytest.raises(OverLimit):
            plate.present(surface(2.3))
        assert plate.volts_pp() == before


def test_the_voltage_is_ramped_in_small_steps_up_and_down():
    with Watched(calibration=calibration(amplifier_gain=10)) as plate:
        connected = len(plate.wire)
        plate.present(surface(2.3))
        plate.present(surface(0.5))
        wire = plate.wire[connected:]
    volts = [float(each.split()[1]) for each in wire if re.fullmatch(r"VOLT [\d.]+", each)]
    assert max(volts) == pytest.approx(3.0, rel=1e-3)
    assert max(abs(after - before) for before, after in itertools.pairwise(volts)) < 0.16 * 3.0


def test_zero_amplitude_is_output_off():
    with Watched(calibration=calibration(amplifier_gain=10)) as plate:
        plate.present(surface(1.2))
        presentation = plate.present(surface(0))
        assert plate.volts_pp()[1] is False
        assert presentation.readback.level == 0


def test_the_output_is_off_after_an_exception():
    def session(plate):
        with plate:
            plate.present(surface(1.2))
            raise ZeroDivisionError

    plate = Watched(calibration=calibration(amplifier_gain=10))
    with pytest.raises(ZeroDivisionError):
        session(plate)
    assert plate.wire[-2:] == ["OUTP 0", "OUTP?"]


def test_a_generator_that_complains_is_refused_and_silenced():
    with Watched(calibration=calibration(amplifier_gain=10)) as plate:
        plate.answers["SYST:ERR?"] = '-222,"Data out of range"'
        with pytest.raises(PlateRefused, match="-222"):
            plate.present(surface(1.2))
        assert plate.wire[-2:] == ["OUTP 0", "OUTP?"]


def test_a_truncated_answer_is_not_taken_for_the_truth():
    with Watched(calibration=calibration(amplifier_gain=10)) as plate:
        plate.answers["FREQ?"] = "304"  # of 30480
        with pytest.raises(PlateRefused, match=r"FREQ\? returns 304, but 30480 was set"):
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
        del plate.answers["OUTP?"]
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
    with pytest.raises(UserError, match="the SPEC has 5, the calibration was made with 10"):
        Watched(calibration=calibration(amplifier_gain=10), amplifier_gain=5)


def test_an_amplifiers_gain_is_never_guessed():
    with pytest.raises(UserError, match=r"gain is unknown.*gain=20"):
        open_plate(f"scpi:{RESOURCE}", clock=SystemClock())
    with pytest.raises(UserError, match="gain is '-20', expected a number above 0"):
        open_plate(f"scpi:{RESOURCE},gain=-20", clock=SystemClock())


def test_another_instrument_is_the_wrong_device():
    with pytest.raises(WrongDevice, match="voltmeter"):
        Watched("voltmeter").connect()


def test_a_load_of_50_ohm_that_stays_is_refused():
    plate = Watched()
    plate.answers["OUTP:LOAD?"] = "+5.000000E+01"
    with pytest.raises(PlateRefused, match="OUTP:LOAD"):
        plate.connect()


def test_a_serial_port_is_a_resource_too():
    assert GeneratorLine("/dev/ttyUSB0").resource == "ASRL/dev/ttyUSB0::INSTR"


def ideal(frequency_hz, voltage_v):
    return 2.3 / 15 * voltage_v / math.hypot(1, 2 * 60 * (frequency_hz - 30_480) / 30_480)


def test_the_spec_names_resource_calibration_and_gain(tmp_path):
    path = tmp_path / "plate.toml"
    points = sweep(SweepPlan(max_voltage_v=15.0), ideal)
    made = calibration_from(
        points,
        device=Device(backend="scpi", serial="MY50000042"),
        made=Provenance(date=TODAY, by="a test", instrument="none"),
        drive=DriveChain(amplifier_gain=20),
    )
    write_calibration(made, path)
    plate = open_plate(f"scpi:{RESOURCE},calibration={path},gain=20", clock=SystemClock())
    assert plate.resource == RESOURCE
    assert plate.limits.level == pytest.approx(2.3)
    with pytest.raises(UserError, match="scpi:RESOURCE"):
        open_plate("scpi:", clock=SystemClock())


def test_a_port_that_is_not_there_is_a_fault_of_the_rig():
    plate = open_plate("scpi:/dev/ttyNONE,gain=1", clock=SystemClock())
    with pytest.raises(PlateNotFound):
        plate.connect()


# Makes, and drops of the line: generators simulated after their manuals.

CHANNELS = [(make, channel) for make in DIALECTS for channel in (1, 2)]


def local(make, line=(), **options):
    """A driver and its simulated generator in this process, in virtual time."""
    wire = LocalLine(MAKES[make]())
    for name, value in dict(line).items():
        setattr(wire, name, value)
    return driver(wire, wire.generator, wire.clock, options), wire


@pytest.fixture
def on_a_socket(monkeypatch):
    """Return a driver of a generator behind PyVISA and a socket of this machine, and its server."""
    monkeypatch.setattr(generator_line, "TIMEOUT_MS", 60_000)
    with GeneratorServer("keysight") as server:
        server.generator.channel[1].on = True
        line = GeneratorLine(server.resource)
        yield driver(line, server.generator, VirtualClock(), {}), server


def driver(line, generator, clock, options):
    options.setdefault("plate", Plate(calibration=calibration_of(generator)))
    plate = FunctionGenerator(line, clock=clock, **options)
    plate._machine = clock
    return plate


def calibration_of(generator):
    made = calibration(amplifier_gain=10)
    serial = generator.identity.split(",")[2]
    return made.model_copy(update={"device": Device(backend="scpi", serial=serial)})


@pytest.mark.parametrize("make, channel", CHANNELS)
def test_every_make_gets_the_volts_on_the_channel_chosen(make, channel):
    plate, wire = local(make, channel=channel)
    chosen, other = wire.generator.channel[channel], wire.generator.channel[3 - channel]
    chosen.on = True  # left on by the person who used it before
    with plate:
        assert not chosen.on
        made = plate.present(surface(2.3))
        assert chosen.on
        assert chosen.plate_vpp() == pytest.approx(3.0, rel=1e-5)
        assert chosen.frequency_hz == 30_480
        assert (chosen.function[:3], chosen.offset_v) == ("SIN", 0)
        assert made.readback.level == pytest.approx(2.3, rel=1e-3)
        assert plate.present(surface(0)).readback.level == 0
        assert not chosen.on
        plate.present(surface(1.0))
    assert not any(each.on for each in wire.generator.channel.values())
    assert other.open_vpp == 0.2
    assert wire.generator.errors == []


def test_a_surface_is_presented_over_a_socket(on_a_socket):
    plate, server = on_a_socket
    with plate:
        made = plate.present(surface(2.3))
        assert made.readback.level == pytest.approx(2.3, rel=1e-3)
        assert server.generator.channel[1].plate_vpp() == pytest.approx(3.0, rel=1e-5)
    assert not server.generator.channel[1].on


def test_a_generator_is_driven_where_its_resonance_was_tracked():
    plate, rig = local("keysight")
    with plate:
        moved_hz, half_hz = 30_450.0, 30_480 / 120

        def measured_um_pp():
            return 0.3 / math.hypot(1, (rig.generator.channel[1].frequency_hz - moved_hz) / half_hz)

        assert track(plate, measured_um_pp).refused == ""
        assert not rig.generator.channel[1].on
        plate.present(surface(1.0))
        assert rig.generator.channel[1].frequency_hz == pytest.approx(moved_hz, abs=0.1)


@pytest.mark.parametrize("make", DIALECTS)
def test_every_make_that_keeps_another_load_is_refused(monkeypatch, make):
    plate, rig = local(make)
    rig.generator.channel[1].on = True
    obey = rig.generator.obey
    monkeypatch.setattr(
        rig.generator, "obey", lambda line: None if re.search("(INF|HZ)$", line) else obey(line)
    )
    with pytest.raises(PlateRefused, match=r"(LOAD|OUTP|IMP).* returns .*5"):
        plate.connect()
    assert rig.generator.channel[1].on is False


def test_a_make_that_is_not_known_is_refused_with_the_remedy():
    plate, wire = local("tektronix")
    wire.generator.identity = "Nobody,F1,1,1"
    with pytest.raises(WrongDevice, match=r"'Nobody F1'.*dialect=.*keysight, rigol"):
        plate.connect()
    chosen = {"plate": Plate(), "amplifier_gain": 10, "dialect": DIALECTS["tektronix"]}
    named, wire = local("tektronix", **chosen)
    wire.generator.identity = "Nobody,F1,1,1"
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


def on(wire):
    return any(channel.on for channel in wire.generator.channel.values())


@pytest.mark.parametrize("for_good", [False, True], ids=["and comes back", "for good"])
@pytest.mark.parametrize("make", ["keysight", "siglent"])
def test_a_line_that_drops_at_any_command_leaves_no_plate_on_unsaid(make, for_good):
    """What comes back is switched off; what does not is reported, with what to do by hand."""
    plate, whole = local(make)
    session(plate)
    assert len(whole.wire) > 150
    unsaid, said = [], 0
    for position in range(1, len(whole.wire) + 1):
        plate, wire = local(make, {"drop_at": position, "for_good": for_good})
        told = None
        try:
            session(plate)
        except PlateFault as fault:
            told = fault
        if on(wire) and not isinstance(told, StillVibrating):
            unsaid.append((position, wire.wire[position - 1], told))
        if on(wire) and plate.output is not Output.UNREACHABLE:
            unsaid.append((position, plate.output))
        said += isinstance(told, StillVibrating)
        if on(wire) and not for_good:
            unsaid.append((position, "still on", told))
    assert unsaid == []
    assert (said > 50) == for_good


@pytest.mark.parametrize("for_good", [False, True], ids=["and comes back", "for good"])
def test_a_socket_that_drops_while_the_plate_vibrates_is_opened_again_or_reported(
    on_a_socket, monkeypatch, for_good
):
    plate, server = on_a_socket
    plate.connect()
    plate.present(surface(1.2))
    server.drop_at, server.for_good = len(server.lines) + 1, for_good
    plate._output.line._instrument.timeout = 60  # PyVISA waits even if the line is gone
    if for_good:  # nothing answers any more, however long the driver waits
        monkeypatch.setattr(generator_line, "TIMEOUT_MS", 60)
    expected = StillVibrating if for_good else (ConnectionLost, PlateTimeout)
    with pytest.raises(expected):
        plate.read_back()
    assert server.generator.channel[1].on == for_good
    assert plate.output is (Output.UNREACHABLE if for_good else Output.OFF)


@pytest.mark.parametrize("within", [False, True], ids=["between commands", "within a command"])
def test_who_interrupts_a_session_is_told_too_when_the_plate_is_out_of_reach(monkeypatch, within):
    plate, wire = local("keysight")

    def interrupt():
        wire.drop_at, wire.for_good = len(wire.wire) + 1, True
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
    with pytest.raises(StillVibrating):
        plate.close()  # told as long as it is so


# What changes a generator behind the driver's back, and what it cannot make.


def press(generator, key):
    """Do at the front panel what a person does who uses the generator for something else."""
    channel = generator.channel[1]
    if key == "preset":
        generator.reset()
    elif key == "load 50 Ω":
        channel.load_ohm = 50.0
    elif key == "square":
        channel.function = "SQU"
    elif key == "offset":
        channel.offset_v = 1.0
    else:
        channel.active = {key}


def keys(make):
    functions = MAKES[make].functions
    names = functions.values() if isinstance(functions, dict) else functions
    # The 33500's BPSK and SUM are unknown to the 33220A, which shares its dialect.
    modulations = [each for each in names if each not in ("BPSK", "SUM") or make == "rigol"]
    return ["preset", "load 50 Ω", "square", "offset", *modulations]


PRESSED = [(make, key) for make in MAKES for key in keys(make)]


@pytest.mark.parametrize("make, key", PRESSED)
def test_a_setting_that_changed_since_the_connection_is_refused_before_the_output_is_on(make, key):
    plate, wire = local(make)
    plate.connect()
    press(wire.generator, key)
    with pytest.raises(PlateRefused, match="reset, was changed at its front panel"):
        plate.present(surface(1.2))
    assert wire.generator.channel[1].plate_vpp() == 0
    assert plate.output is Output.OFF
    plate.close()
    plate.connect()  # makes all settings again
    plate.present(surface(1.2))
    assert wire.generator.channel[1].plate_vpp() == pytest.approx(1.2 * 3 / 2.3, rel=2e-3)


@pytest.mark.parametrize("make, key", PRESSED)
def test_a_setting_that_changes_while_the_plate_vibrates_is_found_by_the_readback(make, key):
    plate, wire = local(make)
    plate.connect()
    plate.present(surface(1.2))
    press(wire.generator, key)
    try:
        told = plate.read_back()
    except PlateRefused:
        assert wire.generator.channel[1].plate_vpp() == 0
    else:  # a preset switches the output off, which is not what is wanted
        with pytest.raises(NotReached):
            plate.confirm(1.2, told)


def test_a_frequency_changed_at_the_front_panel_is_found_by_the_readback():
    plate, wire = local("keysight")
    plate.connect()
    plate.present(surface(1.2))
    wire.generator.channel[1].frequency_hz = 30_000.0
    with pytest.raises(PlateRefused, match="FREQ"):
        plate.read_back()


@pytest.mark.parametrize("make", ["keysight", "33220", "rigol"])
def test_no_ramp_crosses_a_switching_attenuator(make):
    plate, wire = local(make)
    with plate:
        for amplitude_um_pp in (2.3, 0.1, 1.0, 0):
            plate.present(surface(amplitude_um_pp))
    assert wire.generator.channel[1].dropouts == 0


SMALLEST_VPP = {"keysight": 0.002, "33220": 0.02, "rigol": 0.002, "siglent": 0.004,
                "tektronix": 0.04}  # fmt: skip


@pytest.mark.parametrize("make", MAKES)
def test_every_make_presents_from_its_own_smallest_voltage_on_and_refuses_less(make):
    plate, wire = local(make)
    smallest_um_pp = SMALLEST_VPP[make] * 2.3 / 3
    with plate:
        made = plate.present(surface(1.001 * smallest_um_pp))
        assert made.readback.level == pytest.approx(smallest_um_pp, rel=0.01)
        with pytest.raises(OverLimit, match="from the generator, which supplies"):
            plate.check_supported(surface(0.99 * smallest_um_pp))
        assert wire.generator.channel[1].on  # as it was
    assert wire.generator.errors == []


def test_an_amplifier_of_gain_100_does_not_turn_small_amplitudes_into_one():
    made = calibration(amplifier_gain=100)
    with Watched(calibration=made, limits=PlateLimits()) as plate:
        for amplitude_um_pp in (0.014, 0.005):
            with pytest.raises(OverLimit, match=r"supplies 0\.002 to 20 V"):
                plate.present(surface(amplitude_um_pp))
        assert plate.present(surface(0.05)).readback.level == pytest.approx(0.05, rel=0.01)


def test_volts_that_no_generator_makes_are_refused_without_an_amplifier():
    with Watched(calibration=calibration()) as plate:
        plate.present(surface(1.5))
        with pytest.raises(OverLimit, match=r"15 V peak at the plate require 30 V peak to peak"):
            plate.present(surface(2.3))


def test_a_generator_that_takes_long_for_each_command_presents():
    """At 80 ms for a command and a time-out of 1 s, a query behind 12 queued commands fails."""
    plate, wire = local("keysight", {"command_s": 0.08})
    with plate:
        assert plate.present(surface(1.2)).readback.level == pytest.approx(1.2, rel=0.01)
        for _ in range(12):
            wire.write("VOLT?")
        with pytest.raises(PlateTimeout):
            wire.ask("VOLT?")


def test_the_presentation_reports_the_predicted_voltage_beside_the_applied_one():
    plate, _ = local("keysight")
    with plate:
        made = plate.present(surface(1.2))
    assert made.predicted_v_peak == pytest.approx(1.2 * 15 / 2.3)
    assert made.readback.voltage_v_peak == pytest.approx(made.predicted_v_peak, rel=1e-3)
