"""The conformance checks on boards that follow the protocol, and on boards that do not."""

import json
import math
import threading
import time

import pytest

from slipscale import commands
from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.conformance.bench import Bench
from slipscale.hardware.conformance.table import RULES, examine
from slipscale.hardware.emulator import compiled
from slipscale.hardware.emulator.firmware import Board
from slipscale.hardware.plate.dynamics import FingerLoad
from slipscale.hardware.plate.twin import Twin


class VirtualLine:
    """A board at the end of a line, in time that passes only while somebody waits."""

    port = "virtual"

    def __init__(self, board):
        self.board = board
        self.clock = VirtualClock()
        self.told = b""

    def now(self):
        return self.clock.now()

    def sleep(self, duration_s):
        for _ in range(math.ceil(duration_s * 1000)):
            self.clock.sleep(0.001)
            self.board.tick(self.clock.now())

    def write(self, data):
        for _, reply in self.board.receive(data, self.clock.now()):
            self.told += reply

    def read(self):
        if not self.told:
            self.sleep(0.001)
        data, self.told = self.told, b""
        return data


def departures(board):
    line = VirtualLine(board)
    return {each.rule: each.detail for each in examine(Bench(line, line))
            if each.outcome == "departs"}  # fmt: skip


@pytest.fixture(scope="module")
def code(tmp_path_factory):
    return compiled.load(compiled.build(tmp_path_factory.mktemp("firmware")))


EXAMINATIONS = 5
NAP_S, LATE_S = 0.002, 0.015  # a ramp lasts 25 ms, and is looked for within it
PLATES = {
    "a free plate": {},
    "a plate with a finger": {"finger": FingerLoad(loss=1 / 300)},
    "a noisy sensor": {"noise_um": 0.01, "seed": 3},
}


@pytest.mark.parametrize("plate", PLATES)
def test_the_emulated_board_conforms(plate):
    assert departures(Board(Twin(**PLATES[plate]), boot=1)) == {}


@pytest.mark.parametrize("plate", PLATES)
def test_the_compiled_firmware_conforms(code, plate):
    assert departures(compiled.CompiledBoard(Twin(**PLATES[plate]), 1, code=code)) == {}


def test_a_board_without_lists_conforms_and_is_told_what_does_not_apply():
    line = VirtualLine(Board(Twin(), boot=1, lists=False))
    outcomes = {each.outcome for each in examine(Bench(line, line))}
    assert outcomes == {"conforms", "not applicable"}


@pytest.mark.parametrize("options", [[], ["--firmware"]])
def test_a_board_on_a_real_port_conforms(emulate, options, capsys):
    """In real time: what departs while this machine kept its own time is a departure.

    Above, in virtual time, no rule departs even once. Where the machine was late by itself, it is
    examined again: neither the board nor the bench was on time then.
    """
    board = emulate(*options)
    departs = {}
    for _ in range(EXAMINATIONS):
        with Lateness() as machine:
            status = commands.main(["plate", "conform", f"serial:{board.port}", "--json"])
        verdicts = json.loads(capsys.readouterr().out)
        found = {v["rule"]: v["detail"] for v in verdicts if v["outcome"] != "conforms"}
        assert status == bool(found)
        assert not board.state()["vibrates"]
        if not found:
            assert [each["rule"] for each in verdicts] == [rule for rule, _ in RULES]
            return
        assert machine.worst_s > LATE_S, f"departs, and the machine was never late: {found}"
        departs |= found
    pytest.fail(f"never conforms in {EXAMINATIONS} examinations on a late machine: {departs}")


class Lateness:
    """Finds out how late this machine wakes a thread that sleeps, at the worst."""

    def __init__(self):
        self.worst_s = 0.0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._look)

    def _look(self):
        before_s = time.monotonic()
        while not self._over.wait(NAP_S):
            now_s = time.monotonic()
            self.worst_s = max(self.worst_s, now_s - before_s - NAP_S)
            before_s = now_s

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._over.set()
        self._thread.join()


def test_a_board_that_departs_is_a_no(emulate, capsys):
    board = emulate("--fault", "deaf", "--back-after", "0")
    assert commands.main(["plate", "conform", f"serial:{board.port}"]) == 1
    assert "departs         the board answers and tells its limits" in capsys.readouterr().out


class ForgetsNotAtStop(Board):
    """What firmware 1.1 did: the stop byte is taken out of its line."""

    def receive(self, data, now_s):
        before, stop, after = data.partition(wire.STOP)
        if not stop:
            return super().receive(data, now_s)
        answers = super().receive(before, now_s)
        self.silence(now_s)
        return answers + self.receive(after, now_s)


class HoldsTooEarly(Board):
    """What firmware 1.1 did: HOLD follows the ramp, whatever is measured."""

    def _settled(self, *_args, **_options):
        return "HOLD"


class ForgetsItsAnswer(Board):
    """What firmware 1.1 did: plain ``*IDN?`` takes the place of the answer that was kept."""

    def _line(self, line, now_s):
        if line == b"*IDN?":
            self._last = None
        return super()._line(line, now_s)


class CutsLines(Board):
    """What firmware 1.1 did: what is too long is cut, and the rest is run."""

    def receive(self, data, now_s):
        *lines, rest = data.split(b"\n")
        whole = [line[: wire.LONGEST_LINE] + b"\n" for line in lines]
        return super().receive(b"".join(whole) + rest, now_s)


class AnswersTwice(Board):
    """A line that echoes, or a board with two handlers."""

    def receive(self, data, now_s):
        return [each for each in super().receive(data, now_s) for _ in range(2)]


class NeverForgotten(Board):
    """Its watchdog is content with anything that comes."""

    def receive(self, data, now_s):
        self._heard_s = now_s
        return super().receive(data, now_s)


BROKEN = {
    "a correct frame gets one answer": (AnswersTwice, {}),
    "a frame with ! inside is not run": (ForgetsNotAtStop, {}),
    "AMPL settles within 2 s, and HOLD is true": (
        HoldsTooEarly,
        {"finger": FingerLoad(loss=1 / 300)},
    ),
    "no-frames and plain *IDN? do not part a repetition": (ForgetsItsAnswer, {}),
    "lines have 96 bytes at most": (CutsLines, {}),
    "the watchdog silences when no correct frame comes": (NeverForgotten, {}),
}


@pytest.mark.parametrize("rule", BROKEN)
def test_a_board_that_breaks_a_rule_is_told_which(rule):
    board, plate = BROKEN[rule]
    assert rule in departures(board(Twin(**plate), boot=1))


@pytest.mark.parametrize("spec", ["mock", "serial:", "scpi:COM3", "serial:COM3,attention=1"])
def test_only_a_driver_board_can_be_examined(spec, capsys):
    assert commands.main(["plate", "conform", spec]) == 2
    assert "expected serial:PORT" in capsys.readouterr().err
