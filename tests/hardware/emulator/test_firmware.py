"""The board's rules, without a line: bytes and times in, bytes out."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.emulator.firmware import Board
from slipscale.hardware.plate.dynamics import NO_FINGER, FingerLoad
from slipscale.hardware.plate.twin import Twin
from slipscale.stimuli.modulation import Loop

SQUARE = Loop(levels=(2.0, 0.4), step_s=0.02, edge_s=0.002, mean_level=1.2)


class Bench:
    """A board on a bench, and the seconds that pass."""

    def __init__(self, **twin):
        self.twin = Twin(**twin)
        self.board = Board(self.twin, boot=1)
        self.now_s = 0.0
        self.sequence = 0

    def wait(self, duration_s, *, alive=True):
        for _ in range(round(duration_s / 0.005)):
            self.now_s += 0.005
            self.board.tick(self.now_s)
            if alive:
                self.ask("STAT?")

    def send(self, data):
        return [reply for _, reply in self.board.receive(data, self.now_s)]

    def ask(self, body):
        self.sequence += 1
        (reply,) = self.send(wire.command_frame(self.sequence, body))
        return wire.parse_reply(reply.rstrip())

    def status(self):
        return wire.parse_status(self.ask("STAT?").value)

    def present(self, amplitude_um_pp):
        assert self.ask(f"AMPL {amplitude_um_pp}").code == 0
        self.wait(0.12)

    def play(self, loop):
        self.present(loop.mean_level)
        for body in wire.list_commands(loop):
            assert self.ask(body).code == 0
        return self.now_s


@pytest.fixture
def bench():
    return Bench()


def test_an_amplitude_is_ramped_settled_and_held(bench):
    assert bench.ask("AMPL 2.3").code == 0
    assert bench.status().state == "RAMP"
    bench.wait(0.01)
    assert 0.1 < bench.status().level < 2
    bench.wait(0.05)
    status = bench.status()
    assert status.state == "HOLD"
    assert status.level == pytest.approx(2.3, abs=0.03)
    assert status.voltage_v == pytest.approx(15, abs=0.1)


def test_a_board_that_was_kept_from_its_ramp_does_not_take_it_for_done(bench):
    bench.ask("AMPL 2.3")
    bench.now_s += 0.3  # nothing ran meanwhile
    assert bench.status().state == "RAMP"
    bench.wait(0.02)
    status = bench.status()
    assert status.state == "HOLD"
    assert status.level == pytest.approx(2.3, abs=0.03)


def test_zero_amplitude_ramps_down_and_is_output_off(bench):
    bench.present(2.3)
    bench.ask("AMPL 0")
    assert bench.board.vibrates
    bench.wait(0.06)
    assert bench.status().state == "OFF"


def test_a_watchdog_silences_the_plate_within_its_time_when_the_host_is_quiet(bench):
    bench.present(2.3)
    bench.wait(0.49, alive=False)
    assert bench.board.vibrates
    bench.wait(0.02, alive=False)
    assert not bench.board.vibrates
    assert bench.status().state == "WDOG"


def test_garbage_does_not_feed_the_watchdog(bench):
    bench.present(2.3)
    for _ in range(120):
        bench.wait(0.005, alive=False)
        assert bench.send(b">9 STAT?*0000\n") == []
    assert not bench.board.vibrates


def test_a_forgotten_plate_falls_silent_though_the_host_lives(bench):
    bench.board.limits = wire.BoardLimits(on_time_s=1)
    bench.present(1.2)
    bench.wait(1.1)
    assert bench.status().state == "LONG"


def test_the_stop_byte_silences_even_inside_a_frame(bench):
    bench.present(2.3)
    bench.send(b">12 AMPL 1!")
    assert not bench.board.vibrates


def test_a_frame_with_the_stop_byte_inside_is_never_run(bench):
    frame = wire.command_frame(12, "AMPL 2.3")
    for place in range(1, len(frame)):
        assert bench.send(frame[:place] + wire.STOP + frame[place:]) == []
    bench.send(b"\n")
    assert not bench.board.vibrates


def test_a_frame_directly_after_the_stop_byte_is_run(bench):
    bench.present(2.3)
    (reply,) = bench.send(b">7 AM" + wire.STOP + wire.command_frame(8, "STAT?"))
    assert wire.parse_status(wire.parse_reply(reply.rstrip()).value).state == "OFF"


def test_a_line_that_is_too_long_is_thrown_away_as_a_whole(bench):
    frame = wire.command_frame(8, "LIM?")
    longest = b"#" * (wire.LONGEST_LINE + 1 - len(frame)) + frame
    assert len(bench.send(longest)) == 1
    assert bench.send(b"#" + longest) == []
    assert bench.send(longest[:-1] + b"x" * 100 + b"\n") == []
    assert len(bench.send(frame)) == 1


def test_under_a_finger_hold_is_told_when_the_amplitude_is_there_and_not_before():
    bench = Bench(finger=FingerLoad(loss=1 / 300), noise_um=0)
    bench.ask("AMPL 1.2")
    told = []
    while not told or told[-1].state == "RAMP":
        bench.wait(0.005)
        told.append(bench.status())
    assert told[-1].state == "HOLD"
    assert 0.07 < bench.now_s < 0.1
    assert told[-1].level == pytest.approx(1.2, rel=0.025)
    assert told[-1].voltage_v == pytest.approx(1.2 * 18 / 2.3, rel=0.025)


def test_a_finger_that_lands_is_told_until_the_voltage_has_followed(bench):
    bench.present(1.2)
    bench.twin.finger = FingerLoad(loss=1 / 300)
    bench.wait(0.02)
    assert bench.status().state == "RAMP"
    bench.wait(0.08)
    assert bench.status().state == "HOLD"
    bench.twin.finger = NO_FINGER
    bench.wait(0.02)
    assert bench.status().state == "RAMP"
    assert bench.status().level > 1.25
    bench.wait(0.08)
    assert bench.status().level == pytest.approx(1.2, abs=0.03)


def test_a_repeated_command_runs_once_and_gets_the_same_answer(bench):
    bench.ask("FOO")
    bench.ask("AMPL 9")
    frame = wire.command_frame(500, "SYST:ERR?")  # each run takes an error away
    answers = [bench.send(frame) for _ in range(3)]
    assert answers[0] == answers[1] == answers[2]
    assert bench.ask("SYST:ERR?").code == 0
    assert bench.ask("SYST:ERR?").value == '0,"No error"'


def test_a_repeated_amplitude_does_not_begin_its_ramp_anew(bench):
    frame = wire.command_frame(500, "AMPL 2.3")
    bench.send(frame)
    bench.wait(0.02, alive=False)
    bench.send(frame)
    bench.wait(0.025, alive=False)
    assert bench.status().state == "HOLD"


def test_commands_outside_the_boards_limits_are_refused_and_change_nothing(bench):
    bench.present(1.2)
    for body in ("AMPL 2.6", "AMPL -0.1", "DRIV 24000,1", "DRIV 30500,17", "OUTP ON"):
        assert bench.ask(body).code == wire.OUT_OF_RANGE
    for body in ("AMPL NAN", "AMPL inf", "AMPL 1e0", "AMPL  1", "AMPL 1,2", "STAT? 1"):
        assert bench.ask(body).code == wire.DATA_TYPE
    assert bench.ask("AMPL").code == wire.MISSING_PARAMETER
    assert bench.ask("VOLT 3").code == wire.UNDEFINED_HEADER
    status = bench.status()
    assert (status.state, status.target_level) == ("HOLD", 1.2)


def test_errors_queue_up_and_are_read_oldest_first(bench):
    bench.ask("AMPL 9")
    bench.ask("FOO")
    assert bench.ask("SYST:ERR?").value == '-222,"Data out of range"'
    assert bench.ask("SYST:ERR?").value == '-113,"Undefined header"'
    assert bench.ask("SYST:ERR?").value == '0,"No error"'


def test_a_hot_board_silences_refuses_and_says_why(bench):
    bench.present(1.2)
    bench.board.hot = True
    bench.wait(0.01)
    assert bench.status().state == "HOT"
    assert bench.ask("AMPL 0.5").code == wire.TOO_HOT
    assert not bench.board.vibrates


def test_a_busy_board_does_not_run_commands_nor_feed_its_watchdog(bench):
    bench.present(1.2)
    bench.board.busy = True
    assert bench.ask("AMPL 2.3").code == wire.BUSY
    bench.wait(0.6)
    assert not bench.board.vibrates


def test_a_plate_whose_voltage_does_not_suffice_says_so():
    bench = Bench(finger=FingerLoad(loss=1 / 300))
    bench.present(2.3)
    status = bench.status()
    assert status.state == "SAT"
    assert status.level == pytest.approx(2.3 * 16.5 / 18, abs=0.03)


def test_a_list_is_played_by_the_boards_own_time_and_read_as_its_mean():
    bench = Bench(noise_um=0)
    begun_s = bench.play(SQUARE)
    assert bench.status().state == "LIST"
    for _ in range(200):
        bench.wait(0.005)
        status = bench.status()
        assert status.target_level == pytest.approx(1.2)
        assert status.level == pytest.approx(1.2, abs=0.03)
        since_s = bench.now_s - begun_s
        assert bench.board.commanded_level(bench.now_s) == SQUARE.at_level(since_s)
        if since_s % SQUARE.step_s > 0.012:  # what rings of an edge is gone
            level = SQUARE.level(SQUARE.step_at(since_s))
            assert bench.twin.amplitude_um_pp(bench.now_s) == pytest.approx(level, abs=1e-3)
    assert status.voltage_v == pytest.approx(2 / 2.3 * 15, abs=0.01)


def test_a_list_is_filled_line_by_line_and_a_line_in_the_middle_ends_it(bench):
    for body in ("LIST:AMPL 1,0.1,0.2,0.3", "LIST:AMPL 4,0.4,0.5", "LIST:AMPL 3,0.6"):
        assert bench.ask(body).code == 0
    assert bench.board.points == [0.1, 0.2, 0.6]
    assert bench.ask("LIST:AMPL 5,0.1").code == wire.OUT_OF_RANGE
    assert bench.ask("*RST").code == 0
    assert bench.board.points == []


def test_a_list_outside_the_boards_limits_is_refused_and_changes_nothing(bench):
    bench.present(1.2)
    assert bench.ask("LIST:AMPL 1,2,0.4").code == 0
    for body in (
        "LIST:AMPL 1,2.6",
        "LIST:AMPL 1.5,1",
        "LIST:AMPL 0,1",
        "LIST:PLAY 1,20,2",
        "LIST:PLAY 2,3.9,2",
        "LIST:PLAY 2,20,1.9",
        "LIST:PLAY 2,20,20.1",
        "LIST:PLAY 2,600001,2",
    ):
        assert bench.ask(body).code == wire.OUT_OF_RANGE
    for body in ("LIST:AMPL 1,nan", "LIST:AMPL 1,1,,1", "LIST:PLAY 2,20,2,1", "LIST:LIM? 1"):
        assert bench.ask(body).code == wire.DATA_TYPE
    for body in ("LIST:AMPL", "LIST:AMPL 1", "LIST:PLAY 2,20"):
        assert bench.ask(body).code == wire.MISSING_PARAMETER
    assert bench.ask("LIST:PLAY 3,20,2").code == wire.SETTINGS_CONFLICT
    assert bench.board.points == [2.0, 0.4]
    status = bench.status()
    assert (status.state, status.target_level) == ("HOLD", 1.2)


def test_only_a_settled_plate_plays_and_what_it_plays_is_not_changed(bench):
    assert bench.ask("LIST:AMPL 1,2,0.4").code == 0
    assert bench.ask("LIST:PLAY 2,20,2").code == wire.SETTINGS_CONFLICT
    bench.ask("AMPL 1.2")
    assert bench.ask("LIST:PLAY 2,20,2").code == wire.SETTINGS_CONFLICT
    bench.wait(0.06)
    assert bench.ask("LIST:PLAY 2,20,2").code == 0
    for body in ("LIST:PLAY 2,20,2", "LIST:AMPL 1,1"):
        assert bench.ask(body).code == wire.SETTINGS_CONFLICT
    assert bench.board.points == [2.0, 0.4]
    assert bench.status().state == "LIST"


def test_a_repeated_start_does_not_begin_the_list_anew(bench):
    bench.present(1.2)
    bench.ask("LIST:AMPL 1,2,0.4")
    frame = wire.command_frame(500, "LIST:PLAY 2,20,2")
    first = bench.send(frame)
    begun_s = bench.now_s
    bench.wait(0.03, alive=False)
    assert bench.send(frame) == first
    assert bench.board.commanded_level(bench.now_s) == SQUARE.at_level(bench.now_s - begun_s)


def test_an_amplitude_after_a_list_is_ramped_to_from_where_the_list_was(bench):
    begun_s = bench.play(SQUARE)
    bench.wait(0.025)
    due_um_pp = SQUARE.at_level(bench.now_s - begun_s)
    assert due_um_pp == pytest.approx(0.4)
    bench.ask("AMPL 2.3")
    assert bench.board.commanded_level(bench.now_s) == pytest.approx(due_um_pp)
    bench.wait(0.005)
    assert bench.board.commanded_level(bench.now_s) == pytest.approx(0.58, abs=0.01)
    bench.wait(0.055)
    assert bench.status().state == "HOLD"


@pytest.mark.parametrize("why", ["OFF", "WDOG", "LONG", "HOT"])
def test_what_silences_a_plate_silences_a_list(bench, why):
    bench.board.limits = wire.BoardLimits(on_time_s=1)
    bench.play(SQUARE)
    if why == "OFF":
        bench.send(b">12 LIST!")
    bench.board.hot = why == "HOT"
    bench.wait(1.1, alive=why != "WDOG")
    assert bench.status().state == why
    assert bench.twin.amplitude_um_pp(bench.now_s + 0.1) < 1e-6
    assert bench.board.commanded_level(bench.now_s) == 0


def test_ridges_for_which_the_voltage_does_not_suffice_are_told():
    bench = Bench(finger=FingerLoad(loss=1 / 150))
    bench.play(SQUARE)
    bench.wait(0.1)
    status = bench.status()
    assert status.state == "SAT"
    assert status.voltage_v == 16.5
    assert status.level < 1.15


def test_older_firmware_knows_no_lists_and_all_else():
    bench = Bench()
    bench.board = Board(bench.twin, boot=1, lists=False)
    for body in ("LIST:LIM?", "LIST:AMPL 1,1", "LIST:PLAY 2,20,2"):
        assert bench.ask(body).code == wire.UNDEFINED_HEADER
    bench.present(1.2)
    assert bench.status().state == "HOLD"


def test_a_terminal_gets_a_plain_answer_to_a_plain_question(bench):
    assert bench.send(b"*IDN?\r\n") == [b"Slipscale,slipscale-plate-1,EMULATED-1,1.2\r\n"]


@given(st.lists(st.binary(max_size=150), max_size=8))
def test_no_bytes_whatever_start_the_plate_or_break_the_board(chunks):
    bench = Bench()
    for chunk in chunks:
        bench.send(chunk)
    assert not bench.board.vibrates
    bench.send(b"\n")
    assert bench.ask("STAT?").code == 0


@pytest.mark.parametrize("sensor", [0.0, 0.5, 2.0])
def test_a_broken_sensor_changes_the_drive_by_half_at_most(sensor):
    """A dead sensor wound the plate up to 16.5 V, 2.53 µm for 0.5 µm."""
    twin = Twin(noise_um=0, sensor=sensor)
    board = Board(twin, boot=1)
    board.receive(wire.command_frame(1, "AMPL 0.5"), 0.0)
    largest_um_pp = 0.0
    for millisecond in range(1, 400):
        board.tick(millisecond / 1000)
        largest_um_pp = max(largest_um_pp, twin.amplitude_um_pp(millisecond / 1000))
    assert largest_um_pp < 0.5 * 1.51
    assert board.state == ("RAMP" if sensor > 1 else "SAT")
