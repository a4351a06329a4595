"""The driver against the emulated board, byte for byte, in virtual time."""

import csv
from contextlib import closing
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from slipscale.faults import UserError
from slipscale.hardware.address import Plate
from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.backends.serial_board.driver import SerialBoard
from slipscale.hardware.backends.serial_board.link import BoardLink
from slipscale.hardware.backends.serial_board.protocol import parse_status
from slipscale.hardware.backends.serial_board.supervision import ActivePresentation, check_status
from slipscale.hardware.calibration.record import Calibration
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.contact.followed_texture import SETTLES_S
from slipscale.hardware.emulator.firmware import Board
from slipscale.hardware.errors import (
    ConnectionLost,
    GarbledReply,
    NotReached,
    OffCalibration,
    OverLimit,
    PlateBusy,
    PlateFault,
    PlateNotFound,
    PlateRefused,
    PlateTimeout,
    ProtocolViolation,
    WrongDevice,
)
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.plate.twin import Drive, Twin
from slipscale.hardware.records import Output
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.quantity import made_by_plate
from slipscale.stimuli.surface import VirtualSurface
from slipscale.stimuli.texture import Grating
from slipscale.stimuli.transient import Transient

SURFACE = VirtualSurface(level=1.2)
TEXTURE = Grating(
    spatial_period_mm=2.5, waveform="square", mean_level=1.2, depth_level=0.8, label="T1"
)

# What the host repairs by itself: the command runs once, nothing is recorded.
REPAIRED = [
    "drop",
    "garbage_before",
    "garbage_inside",
    "garbage_after",
    "garbage_line",
    "truncated",
    "delayed",
    "duplicated",
    "out_of_order",
]
# What ends a trial, and how it is told.
ENDING = {
    "unplug": ConnectionLost,
    "unplug_mid_read": ConnectionLost,
    "reset": ConnectionLost,
    "busy": PlateBusy,
    "hot": PlateRefused,
    "deaf": PlateTimeout,
    "trickle": PlateTimeout,
}
PATIENCE = ("reset", "trickle", "deaf")
AWAY = ("unplug", "unplug_mid_read", "busy", "hot", "deaf")
MATRIX = [
    (fault, phase)
    for fault in ENDING
    for phase in ("connect", "present", "play", "read", "silence", "exploring")
    # A greeting is patient with a board that starts or is slow, and a hot one obeys a silence.
    if (fault, phase) not in {(each, "connect") for each in PATIENCE} | {("hot", "silence")}
]


def serial_plate(board, **options):
    words = "".join(f",{key}={value}" for key, value in options.items())
    return open_plate(f"serial:{board.port}{words}", clock=board.host)


def wait_for(board, condition, *, at_most_s=60.0):
    """Wait for something that the board does; the bound only ends a broken test."""
    end_s = board.host.now() + at_most_s
    while not condition():
        assert board.host.now() < end_s
        board.host.sleep(0.01)


def checked_for(plate, duration_s):
    """Check like a session does, once a frame."""
    for _ in range(round(duration_s / 0.005)):
        plate.clock.sleep(0.005)
        plate.check()


def fault_within(plate, *, at_most_s=60.0):
    """Check until the fault comes up."""
    checked_for(plate, at_most_s)


def presented_again(board, plate, surface):
    """Reconnect as the session does, close then connect, until the surface can be presented."""

    def presented():
        plate.close()
        try:
            plate.connect()
            return plate.present(surface)
        except PlateFault:
            return None

    wait_for(board, presented)


def test_a_surface_is_presented_held_and_silenced(board):
    with serial_plate(board) as plate:
        assert plate.identity.model == "slipscale-plate-1"
        presentation = plate.present(SURFACE)
        assert presentation.readback.kind == "measured"
        assert presentation.readback.level == pytest.approx(1.2, abs=0.03)
        assert board.state()["amplitude_um_pp"] == pytest.approx(1.2, abs=1e-3)
        checked_for(plate, 0.8)  # longer than the watchdog: the heartbeat keeps it up
        assert board.state()["state"] == "HOLD"
        assert plate.vibration_level() == pytest.approx(1.2, abs=0.03)
        plate.silence()
        assert not board.state()["vibrates"]
        plate.present(SURFACE)
    assert not board.state()["vibrates"]


@pytest.mark.parametrize("phase", ["connect", "present", "play/1", "play/2", "read", "silence"])
@pytest.mark.parametrize("fault", REPAIRED)
def test_a_spoiled_answer_is_repaired_and_its_command_ran_once(board, fault, phase):
    before = board.fault(f"{fault}@{phase}")
    with serial_plate(board) as plate:
        boots = board.state()["boots"]
        plate.present(TEXTURE)
        plate.read_back()
        plate.check()
        plate.silence()
        state = board.state()
    assert state["presented_levels"] == [*before["presented_levels"], 1.2]
    assert state["played"] == [*before["played"], [2.0, 0.4]]
    assert state["boots"] == boots
    assert not state["vibrates"]


@pytest.mark.parametrize("fault, phase", MATRIX)
def test_a_fault_ends_the_trial_silent_and_the_next_one_works(board_that_waits, fault, phase):
    board = board_that_waits
    with closing(serial_plate(board)) as plate:
        _end_a_trial(board, plate, fault, phase)
    assert not board.state()["vibrates"]


def _end_a_trial(board, plate, fault, phase):
    if phase != "exploring":
        board.fault(f"{fault}@{phase}")

    def trial():
        plate.connect()
        plate.present(TEXTURE)
        if phase == "exploring":
            board.fault(fault)
            fault_within(plate)
        plate.read_back()
        plate.silence()

    with pytest.raises(ENDING[fault]):
        trial()
    wait_for(board, lambda: not board.state()["vibrates"])
    if fault in AWAY:
        board.back()
    presented_again(board, plate, VirtualSurface(level=0.5))
    state = board.state()
    assert state["target_level"] == 0.5, state


@pytest.mark.parametrize("fault", PATIENCE)
def test_a_board_that_starts_or_is_slow_is_greeted_patiently(board, fault):
    board.fault(f"{fault}@connect")
    with serial_plate(board) as plate:
        plate.present(SURFACE)


def test_a_board_that_restarted_is_not_taken_for_one_that_obeyed(board):
    """A repetition that meets a fresh board would succeed, with the output off."""
    with serial_plate(board) as plate:
        plate.present(SURFACE)
        board.fault("reset_after@present")
        with pytest.raises(ConnectionLost, match="restarted"):
            plate.present(SURFACE)


def test_after_a_fault_came_up_nothing_can_be_presented_before_one_connects_again(board):
    with serial_plate(board) as plate:
        board.fault("deaf")
        with pytest.raises(PlateTimeout):
            fault_within(plate)
        with pytest.raises(ConnectionLost, match="until it is reconnected"):
            plate.present(SURFACE)


def test_unplugged_for_good_is_told_as_not_there(host):
    board = host.plug_in("--back-after", "0")
    plate = serial_plate(board)
    plate.connect()
    plate.present(SURFACE)
    board.unplug()
    with pytest.raises(ConnectionLost):
        fault_within(plate)
    plate.close()
    with pytest.raises(PlateNotFound):
        plate.connect()


def test_a_texture_is_held_watched_and_ended_by_the_next_surface(board):
    with serial_plate(board) as plate:
        presentation = plate.present(TEXTURE)
        assert presentation.commanded_level == 1.2
        for _ in range(80):  # longer than the watchdog: the heartbeat keeps it up
            checked_for(plate, 0.01)
            assert plate.read_back().level == pytest.approx(1.2, abs=0.03)
        assert board.state()["state"] == "LIST"
        plate.present(SURFACE)
        assert board.state()["state"] == "HOLD"
        plate.present(TEXTURE)
    assert not board.state()["vibrates"]


def test_a_change_is_played_at_once_ends_and_can_be_played_again(board):
    change = Transient(
        from_level=0.5, to_level=1.5, transition_s=0.01, duration_s=0.15, position_mm=0.0
    )
    with serial_plate(board) as plate:
        plate.present(VirtualSurface(level=0.5))
        for _ in range(2):
            plate.play(change.change(plate.modulator))
            plate.clock.sleep(0.06)
            state = board.state()
            assert (state["state"], round(state["amplitude_um_pp"], 1)) == ("LIST", 1.5)
            plate.clock.sleep(0.13)
            assert board.state()["amplitude_um_pp"] == pytest.approx(0.5, abs=0.05)
            plate.follow(change.final_level)
            plate.clock.sleep(SETTLES_S)
            plate.check()


@pytest.mark.parametrize("waveform", ["sine", "square", "triangle", "sawtooth"])
def test_the_board_makes_the_envelope_that_the_mock_makes(host, tmp_path, waveform):
    """To 0.02 µm, wherever in the period each began."""
    texture = replace(TEXTURE, waveform=waveform, spatial_period_mm=3.3, depth_level=1.2)
    log = tmp_path / "plate.csv"
    board = host.plug_in("--log", str(log), "--noise", "0")
    with serial_plate(board) as plate:
        plate.present(texture)
        board.host.sleep(0.4)
    board.close()
    with log.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["state"] == "LIST"]
    assert len(rows) > 300
    begun_s = float(rows[0]["time_s"])
    rows = rows[5:]  # the first edge, from the mean
    times_s = np.array([float(row["time_s"]) for row in rows])
    commanded, made = (
        np.array([float(row[name]) for row in rows])
        for name in ("commanded_level", "amplitude_um_pp")
    )
    loop = texture.loop()
    since_s = times_s - begun_s + 100 * loop.period_s  # the mock has no first edge

    def mock_um_pp(offset_s):
        twin = Twin(seed=7)
        twin.set_drive(Drive(frequency_hz=30_500, target_um_pp=1.2, played=loop), 0.0)
        return np.array([twin.amplitude_um_pp(t) for t in since_s + offset_s])

    # The log has a line a millisecond: within the one before its first, the list began.
    offsets_s = np.linspace(0, 0.001, 41)
    off_by_um = [np.abs(mock_um_pp(offset_s) - made).max() for offset_s in offsets_s]
    assert min(off_by_um) < 0.02
    offset_s = offsets_s[np.argmin(off_by_um)]
    due = [loop.at_level(t + offset_s) for t in since_s]
    assert np.abs(commanded - due).max() < 0.05


def test_older_firmware_is_told_and_its_textures_refused_before_anything_moves(host):
    board = host.plug_in("--fault", "old_firmware")
    with serial_plate(board) as plate:
        plate.present(SURFACE)
        with pytest.raises(
            UserError,
            match=r"'T1': the board's firmware \(1\.0\) can only hold a " r"constant ampl",
        ):
            plate.present(TEXTURE)
        assert board.state()["state"] == "HOLD"
        assert board.state()["target_level"] == 1.2


def test_a_board_with_a_short_list_is_told(board, monkeypatch):
    monkeypatch.setattr(wire, "parse_list_limits", lambda _: wire.ListLimits(points=20))
    with (
        serial_plate(board) as plate,
        pytest.raises(UserError, match="can store 20 amplitudes, but 64 are required"),
    ):
        plate.present(TEXTURE)


def test_a_texture_for_which_the_voltage_does_not_suffice_is_a_fault(board, monkeypatch):
    monkeypatch.setattr(
        wire, "parse_status", lambda value: parse_status(value.replace("LIST", "SAT"))
    )
    with serial_plate(board) as plate:
        plate.present(TEXTURE)
        with pytest.raises(NotReached, match=r"a texture with a mean of 1\.2 µm p-p was commanded"):
            fault_within(plate)


def test_a_plate_that_falls_silent_is_told_from_a_groove(board, monkeypatch):
    monkeypatch.setattr(
        wire,
        "parse_status",
        lambda value: (
            replace(parse_status(value), level=0.0)
            if value.startswith("LIST")
            else parse_status(value)
        ),
    )
    with serial_plate(board) as plate:
        plate.present(replace(TEXTURE, depth_level=1.2))
        with pytest.raises(NotReached, match=r"1\.2 µm p-p was commanded, but 0\.000"):
            fault_within(plate)


def test_a_board_that_stops_playing_is_noticed(board, monkeypatch):
    monkeypatch.setattr(
        wire, "parse_status", lambda value: parse_status(value.replace("LIST", "HOLD"))
    )
    with serial_plate(board) as plate:
        plate.present(TEXTURE)
        with pytest.raises(PlateRefused, match="reports HOLD, not LIST"):
            fault_within(plate)


def test_the_plates_q_bounds_what_the_board_is_asked_for(board):
    ringing = Calibration.model_validate(
        {
            "device": {"backend": "serial", "serial": "EMULATED-1"},
            "made": {"date": datetime.now(tz=UTC).date(), "by": "A. Test", "instrument": "none"},
            "drive": {},
            "resonance": {
                "frequency_hz": 30_500,
                "frequency_ci95_hz": 1,
                "quality_factor": 600,
                "quality_factor_ci95": 5,
                "residual_um": 0,
            },
            "gain": {
                "um_pp_per_v": 0.153,
                "um_pp_per_v_ci95": 0,
                "residual_um": 0,
                "voltage_max_v": 16.5,
                "amplitude_max_um_pp": 2.5,
            },
            "points": [
                {
                    "sweep": "voltage",
                    "frequency_hz": 30_500,
                    "voltage_v": 16.5,
                    "amplitude_um_pp": 2.5,
                }
            ],
        }
    )
    with SerialBoard(board.port, clock=board.host, plate=Plate(calibration=ringing)) as plate:
        assert plate.modulator.edge_s == pytest.approx(3 * 600 / (np.pi * 30_500))
        with pytest.raises(
            UserError, match=r"the plate and its connection can follow at most 25\.4"
        ):
            plate.present(replace(TEXTURE, finger_speed_mm_s=70))


def test_limits_are_narrowed_to_the_boards(board):
    wide = PlateLimits(level=9, voltage_v=99, frequency_max_hz=9e4, on_time_s=9e9)
    with SerialBoard(board.port, clock=board.host, plate=Plate(limits=wide)) as plate:
        assert plate.limits == PlateLimits()
        assert plate.watchdog_s == 0.5
        with pytest.raises(OverLimit):
            plate.present(VirtualSurface(level=2.6))


def test_the_plate_can_be_driven_at_a_frequency_and_voltage_of_ones_own(board):
    with serial_plate(board) as plate:
        on = plate.excite(frequency_hz=30_500, voltage_v=7.5).level
        off = plate.excite(frequency_hz=30_500 + 30_500 / 120, voltage_v=7.5).level
    assert on == pytest.approx(1.15, abs=0.03)
    assert off == pytest.approx(1.15 / 2**0.5, abs=0.03)


def test_a_session_that_hangs_lets_the_plate_fall_silent_and_is_told_when_it_wakes(board):
    with serial_plate(board, attention=0.2) as plate:
        plate.present(SURFACE)
        wait_for(board, lambda: not board.state()["vibrates"])
        with pytest.raises(PlateTimeout, match="switched the plate off"):
            fault_within(plate)


@pytest.mark.parametrize("fault", ["wrong_identity", "nmea"])
def test_another_device_on_the_port_is_told_quickly(host, fault):
    board = host.plug_in("--fault", fault)
    with pytest.raises(WrongDevice):
        serial_plate(board).connect()


def test_a_port_on_which_nothing_answers_is_a_time_out(host):
    board = host.plug_in("--back-after", "0", "--fault", "deaf")
    with pytest.raises(PlateTimeout, match=r"the board did not answer \*IDN\?"):
        serial_plate(board).connect()


def test_a_value_that_cannot_be_read_is_garbled(board, monkeypatch):
    with serial_plate(board) as plate:
        monkeypatch.setattr(plate._link, "ask", lambda _: "HOLD,many")
        with pytest.raises(GarbledReply, match="HOLD,many"):
            plate.read_back()


@pytest.mark.parametrize("spec", ["serial", "serial:", "serial:attention=3"])
def test_a_spec_without_a_port_is_the_users_fault(spec):
    with pytest.raises(UserError, match="serial:PORT"):
        open_plate(spec, clock=VirtualClock())


def test_a_time_below_zero_would_stop_the_heartbeat_and_is_refused():
    with pytest.raises(UserError, match="attention is '-1', expected a number, 0 or more"):
        open_plate("serial:COM3,attention=-1", clock=VirtualClock())


def test_a_board_that_chatters_and_is_deaf_while_it_starts_is_greeted():
    """As an ESP32 is: its boot loader's lines, then 0.4 s of nothing."""
    line = ChatteringLine()
    assert BoardLink(line, line.clock).greet() == "Slipscale,slipscale-plate-1,EMULATED-1,1.2"
    assert line.unheard > 0


class ChatteringLine:
    """A line at whose end a board starts when it is opened."""

    port = "COM9"
    CHATTER = b"ets Jun  8 2016 00:22:57\r\n\r\n" + b"load:0x3fff0030,len:1184\r\n" * 9
    DEAF_S = 0.4

    def __init__(self):
        self.clock = VirtualClock()
        self.board = Board(Twin(), boot=1)
        self.told = self.CHATTER
        self.unheard = 0

    def write(self, data):
        if self.clock.now() < self.DEAF_S:
            self.unheard += 1
            return
        for _, reply in self.board.receive(data, self.clock.now()):
            self.told += reply

    def read(self):
        self.clock.sleep(0.001)
        data, self.told = self.told, b""
        return data


@pytest.mark.parametrize(
    "limits, fault, told",
    [
        (
            wire.BoardLimits(watchdog_ms=50),
            ProtocolViolation,
            "watchdog time is 50 ms, but must be 400",
        ),
        (wire.BoardLimits(voltage_v=0), ProtocolViolation, "largest voltage is 0 V"),
        (
            wire.BoardLimits(frequency_min_hz=50e3, frequency_max_hz=60e3),
            WrongDevice,
            "the board drives 50000 to 60000 Hz, but the plate's limits are 25000 to 40000",
        ),
    ],
)
def test_impossible_limits_of_a_board_are_a_fault_before_a_session(
    board, monkeypatch, limits, fault, told
):
    genuine = wire.parse_limits
    monkeypatch.setattr(wire, "parse_limits", lambda _: genuine(wire.format_limits(limits)))
    with pytest.raises(fault, match=told):
        serial_plate(board).connect()


@pytest.mark.parametrize("options", [[], ["--firmware"]])
def test_a_finger_that_rests_on_the_plate_costs_time_and_no_amplitude(host, options):
    board = host.plug_in("--finger", "--seed", "5", *options)
    with serial_plate(board) as plate:
        for amplitude_um_pp in (0.5, 1.0, 1.5, 2.0):
            presentation = plate.present(VirtualSurface(level=amplitude_um_pp))
            assert board.state()["amplitude_um_pp"] == pytest.approx(amplitude_um_pp, rel=0.025)
            assert presentation.settled_by == "readback"
            plate.silence()


@pytest.mark.parametrize("options", [[], ["--firmware"]])
def test_a_finger_that_comes_and_goes_is_no_fault(host, options):
    board = host.plug_in(*options)
    with serial_plate(board) as plate:
        plate.present(SURFACE)
        for on in (True, False, True, False):
            board.finger(on=on)
            checked_for(plate, 0.5)  # some heartbeats
            wait_for(board, lambda: board.state()["state"] == "HOLD")
            assert board.state()["amplitude_um_pp"] == pytest.approx(1.2, rel=0.025)


@pytest.mark.parametrize("options", [[], ["--firmware"]])
def test_a_plate_that_follows_goes_where_it_is_told_and_stays_on_in_a_groove_of_0(host, options):
    board = host.plug_in(*options)
    with serial_plate(board) as plate:
        plate.present(SURFACE)
        for amplitude_um_pp in (2.0, 0.4, 0.0, 1.0):
            plate.follow(amplitude_um_pp)
            checked_for(plate, 0.2)  # the ramp, and some heartbeats
            state = board.state()
            assert state["amplitude_um_pp"] == pytest.approx(max(amplitude_um_pp, 0.05), abs=0.03)
            assert state["vibrates"]
        with pytest.raises(OverLimit):
            plate.follow(2.6)
        assert plate.present(SURFACE).settled_by == "readback"


def test_a_board_that_silences_itself_while_it_follows_is_a_fault(host):
    board = host.plug_in()
    with serial_plate(board) as plate:
        plate.present(SURFACE)
        plate.follow(1.0)
        board.fault("hot")
        with pytest.raises(PlateFault):
            checked_for(plate, 2.0)


@pytest.mark.parametrize("options", [[], ["--firmware"]])
def test_a_finger_on_a_slow_texture_is_no_fault_while_the_board_corrects_its_mean(host, options):
    """By 5 % a period: two a second take longer than the 0.3 s that one amplitude is given."""
    board = host.plug_in(*options)
    with serial_plate(board) as plate:
        plate.present(replace(TEXTURE, spatial_period_mm=25.0, finger_speed_mm_s=50.0))
        checked_for(plate, 1.2)  # the first period tells nothing yet
        board.finger()
        checked_for(plate, 1.2)  # it is off, and the heartbeat has seen it
        mean_um_pp = plate.read_back().level
        assert mean_um_pp == pytest.approx(TEXTURE.mean_level, rel=0.05)
        plate.check()


def test_a_plate_that_does_not_settle_again_is_a_fault(board, monkeypatch):
    monkeypatch.setattr(
        wire, "parse_status", lambda value: parse_status(value.replace("HOLD", "RAMP", pretend))
    )
    pretend = 0
    with serial_plate(board) as plate:
        plate.present(SURFACE)
        pretend = 1
        with pytest.raises(NotReached, match="does not settle"):
            fault_within(plate)


def test_nothing_directly_after_a_surface_waits_for_the_plate_to_ring_down(board):
    with serial_plate(board) as plate:
        for _ in range(10):
            plate.present(VirtualSurface(level=2.3))
            plate.silence()
            silent = plate.present(VirtualSurface(level=0.0))
            assert silent.readback.level <= 0.05


def test_a_board_without_a_sensor_measures_nothing_and_says_so(board, monkeypatch):
    monkeypatch.setattr(
        wire,
        "parse_status",
        lambda value: replace(parse_status(value), level=None, temperature_c=None),
    )
    with serial_plate(board) as plate:
        readback = plate.present(SURFACE).readback
        assert (readback.kind, readback.level) == ("none", None)
        plate.check()


@pytest.mark.parametrize("sensor", [0.0, 0.5])
def test_a_broken_sensor_never_drives_the_plate_to_its_voltage_limit(host, sensor):
    board = host.plug_in("--noise", "0", "--sensor", str(sensor))
    with serial_plate(board) as plate:
        with pytest.raises(NotReached, match=r"0\.5 µm"):
            plate.present(VirtualSurface(level=0.5))
        assert plate.output is Output.OFF


def test_a_status_with_another_voltage_than_the_calibrations_is_a_fault():
    status = wire.BoardStatus(
        state="HOLD", target_level=1.2, level=1.2, frequency_hz=30_500.0,
        voltage_v=15.65, temperature_c=22.0,
    )  # fmt: skip
    active = ActivePresentation(1.2, predicted_v=7.82)
    with pytest.raises(
        OffCalibration, match=r"the plate is driven with 15\.65 V peak at 1\.2 µm p-p"
    ):
        check_status(status, active, PlateLimits(), port="COM3")
    check_status(replace(status, voltage_v=9.4), active, PlateLimits(), port="COM3")


def test_a_board_in_volts_presents_volts_and_is_refused_for_micrometres(host, plate_in_volts):
    file = plate_in_volts("serial")
    board = host.plug_in("--plate", str(file))
    with serial_plate(board, plate=file) as plate:
        made = plate.present(VirtualSurface(level=60.0))
        assert made.readback.level == pytest.approx(60.0, rel=0.025)
        with pytest.raises(OverLimit, match="voltage 131 V peak is outside 0 to 130"):
            plate.present(VirtualSurface(level=131.0))
    wait_for(board, lambda: board.state()["state"] == "OFF")
    with pytest.raises(WrongDevice, match=r"in v_peak, but um_pp \(µm peak to peak\) was expected"):
        serial_plate(board).connect()


def test_levels_in_a_unit_that_a_board_reports_too_coarsely_are_refused_before_the_session():
    mm = made_by_plate("displacement", "mm", "peak to peak")
    limits = PlateLimits(level=0.0025, deviation_level=0.00005, quantity=mm)
    plate = SerialBoard("COM3", clock=VirtualClock(), plate=Plate(limits=limits))
    assert plate.check_supported(VirtualSurface(level=0.0)) is None
    for level in (0.00004, 0.00115, 0.0023):
        with pytest.raises(UserError, match=f"COM3: .* for {level:g} mm p-p; use a smaller unit"):
            plate.check_supported(VirtualSurface(level=level))
    in_um = SerialBoard("COM3", clock=VirtualClock())
    for level in (0.02, 0.0346787, 2.3):
        assert in_um.check_supported(VirtualSurface(level=level)) is None


@pytest.mark.parametrize("level", [0.00115, 0.0346787, 1.2, 2.3])
def test_a_commanded_level_is_changed_by_less_than_a_thousandth(level):
    sent = float(wire.amplitude_command(level).removeprefix("AMPL "))
    assert sent == pytest.approx(level, rel=1e-3)
