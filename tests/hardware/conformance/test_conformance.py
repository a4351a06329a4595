"""The conformance checks on boards and backends that are right, and on those that are not."""

import json
import os
from contextlib import nullcontext
from dataclasses import replace

import pytest

from slipscale import commands
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.backends.serial_board.protocol import BoardLimits
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.conformance.bench import ALIVE_S, Bench, Departure
from slipscale.hardware.conformance.contract import RULES as CONTRACT
from slipscale.hardware.conformance.contract import Rig, examine_backend
from slipscale.hardware.conformance.guided import STEPS, Terminal
from slipscale.hardware.conformance.table import RULES, examine
from slipscale.hardware.emulator import compiled
from slipscale.hardware.emulator.firmware import Board
from slipscale.hardware.errors import ConnectionLost
from slipscale.hardware.plate.dynamics import NO_FINGER, FingerLoad
from slipscale.hardware.plate.twin import Twin
from tools.campaigns.wrong_boards.variants import GUIDED_ONLY, WRONG, DoubledLimit
from tools.campaigns.wrong_boards.verdicts import departures as wrong_departures
from tools.campaigns.wrong_boards.verdicts import guided_departures
from tools.campaigns.wrong_boards.virtual_line import Operator, VirtualLine


def departures(board):
    line = VirtualLine(board)
    return {each.rule: each.detail for each in examine(Bench(line, line))
            if each.outcome == "departs"}  # fmt: skip


@pytest.fixture(scope="module")
def code(tmp_path_factory):
    return compiled.load(compiled.build(tmp_path_factory.mktemp("firmware")))


PLATES = {
    "a free plate": {},
    "a plate with a finger": {"finger": FingerLoad(loss=1 / 300)},
    "a noisy sensor": {"noise_um": 0.01, "seed": 3},
}


@pytest.mark.parametrize("plate", PLATES)
def test_the_emulated_board_conforms(plate):
    assert departures(Board(Twin(**PLATES[plate]), boot=1)) == {}


@pytest.mark.parametrize("unit, largest", [("v_peak", 130.0), ("m_s2_rms", 17.0)])
def test_a_board_in_another_unit_conforms(unit, largest):
    limits = BoardLimits(level=largest)
    assert departures(Board(Twin(), boot=1, unit=unit, limits=limits)) == {}


@pytest.mark.parametrize("plate", PLATES)
def test_the_compiled_firmware_conforms(code, plate):
    assert departures(compiled.CompiledBoard(Twin(**PLATES[plate]), 1, code=code)) == {}


def test_a_board_without_lists_conforms_and_is_told_what_does_not_apply():
    line = VirtualLine(Board(Twin(), boot=1, lists=False))
    outcomes = {each.outcome for each in examine(Bench(line, line))}
    assert outcomes == {"conforms", "not applicable", "not proved"}  # the on-time, without --long


@pytest.mark.parametrize("options", [[], ["--firmware"]])
def test_the_command_examines_a_board_at_a_port(host, options, capsys):
    board = host.plug_in(*options)
    words = ["plate", "conform", f"serial:{board.port}", "--json"]
    assert commands.main([*words, "--accept-unproved"]) == 0
    verdicts = json.loads(capsys.readouterr().out)
    assert [each["rule"] for each in verdicts] == [rule for rule, _ in (*RULES, *STEPS)]
    assert [each for each in verdicts if each["outcome"] == "departs"] == []
    unproved = [each["rule"] for each in verdicts if each["outcome"] == "not proved"]
    on_time = "the plate is switched off after the maximum on-time"
    assert unproved == [on_time, *(rule for rule, _ in STEPS)]
    assert not board.state()["vibrates"]


def test_rules_that_were_not_proved_are_a_no_unless_accepted(monkeypatch, capsys, host):
    board = host.plug_in()
    monkeypatch.setattr("slipscale.hardware.conformance.table.RULES", RULES[:1])
    words = ["plate", "conform", f"serial:{board.port}"]
    assert commands.main(words) == 1
    assert "7 rules, 0 violated, 6 not proved" in capsys.readouterr().out
    assert commands.main([*words, "--accept-unproved"]) == 0


def test_a_doubled_voltage_limit_is_found_by_default_if_the_plate_is_loaded():
    assert set(wrong_departures(DoubledLimit)) == {
        "the drive voltage stays within the board's limit"
    }


def test_a_board_that_departs_is_a_no(host, capsys):
    board = host.plug_in("--fault", "deaf", "--back-after", "0")
    assert commands.main(["plate", "conform", f"serial:{board.port}"]) == 1
    assert "departs         the board answers and reports its limits" in capsys.readouterr().out


# Of each kind of wrong board a rule that finds it; the campaign wrong_boards runs all on all.
FOUND_BY = {
    "AnswersTwice": "a correct frame gets one answer",
    "ContentWatchdog": "the watchdog silences the plate when no correct frame arrives",
    "CutList": "an amplitude list reaches its largest amplitude",
    "CutsLines": "lines have at most 96 bytes",
    "DeafToStopInOpen": "the stop byte ! ends open-loop operation",
    "DoubledLimit": "the drive voltage stays within the board's limit",
    "DoubledDrive": "after DRIV, the board applies the voltage that it reports",
    "EchoedReadback": "after DRIV, the board applies the voltage that it reports",
    "FakedReadback": "an amplitude list reaches its largest amplitude",
    "FakesSilence": "OFF is silent",
    "FakesSilenceAfterStop": "the stop byte ! leaves the plate silent",
    "FakesSilenceAfterWatchdog": "WDOG is silent",
    "FakesSilenceAndReading": "a vibrometer measures no vibration when the board is off",
    "FlatList": "an amplitude list is played in order and on time",
    "ForgetsItsAnswer": "a repeated frame is recognised after invalid frames and unframed *IDN?",
    "ForgetsNotAtStop": "a frame that contains the stop byte ! is not executed",
    "FrozenReadback": "the mean amplitude in HOLD is within 2.5 % of TARGET",
    "InvertedList": "an amplitude list is played in order and on time",
    "NoLimits": "values outside the board's limits cause error -222",
    "NoOnTimeLimit": "the plate is switched off after the maximum on-time",
    "NoWatchdog": "WDOG is silent",
    "NoWatchdogInList": "the watchdog also silences the plate during an amplitude list",
    "NoWatchdogInOpen": "the watchdog also silences the plate in open-loop operation",
    "SlowList": "an amplitude list is played in order and on time",
    "StepsInsteadOfRamp": "amplitude changes are ramps, not steps",
    "FalseHold": "a loaded plate in state HOLD has the commanded amplitude",
    "NoSaturation": "a loaded plate at the largest amplitude reports HOLD or SAT",
    "WideHold": "a loaded plate in state HOLD has the commanded amplitude",
}
KINDS = {each.__name__: each for each in WRONG}


def on_a_bench(kind, **limits):
    loaded = kind is DoubledLimit  # A finger raises the voltage to its limit.
    board = kind(Twin(finger=FingerLoad(loss=1 / 300) if loaded else NO_FINGER), boot=1)
    board.limits = replace(board.limits, **limits)
    line = VirtualLine(board)
    bench = Bench(line, line, long=True)
    bench.greet()
    return line, bench


def check(rule, line, bench):
    if rule in dict(RULES):
        dict(RULES)[rule](bench)
    else:
        dict(STEPS)[rule](bench, Operator(line, bench))


def test_the_campaign_has_28_kinds_of_wrong_board():
    assert set(FOUND_BY) == set(KINDS)
    assert len(KINDS) == 28
    guided = {name for name, rule in FOUND_BY.items() if rule in dict(STEPS)}
    assert guided == {each.__name__ for each in GUIDED_ONLY}


@pytest.mark.parametrize("name", FOUND_BY)
def test_every_kind_of_wrong_board_departs_from_a_rule_that_a_correct_one_keeps(name):
    on_time = {"on_time_s": 3.0} if name == "NoOnTimeLimit" else {}
    check(FOUND_BY[name], *on_a_bench(Board, **on_time))
    with pytest.raises(Departure):
        check(FOUND_BY[name], *on_a_bench(KINDS[name], **on_time))


class OffFrequency(Board):
    """Drives open loop beside the frequency that it was told."""

    off_hz = 0.0

    def status(self, now_s):
        status = super().status(now_s)
        off_hz = self.off_hz if self.state == "OPEN" else 0.0
        return replace(status, frequency_hz=status.frequency_hz + off_hz)


@pytest.mark.parametrize("off_hz, kept", [(0.5, True), (-0.5, True), (2.0, False), (-2.0, False)])
def test_open_loop_keeps_its_frequency_within_a_hertz(monkeypatch, off_hz, kept):
    monkeypatch.setattr(OffFrequency, "off_hz", off_hz)
    with nullcontext() if kept else pytest.raises(Departure, match="Hz and"):
        check("DRIV applies the commanded frequency and voltage", *on_a_bench(OffFrequency))


def test_every_step_of_the_guided_part_is_kept_by_the_correct_board():
    assert guided_departures(Board) == {}


def test_the_guided_part_asks_at_the_terminal_and_keeps_the_board_alive(board, monkeypatch):
    """The operator takes longer than the watchdog for each reading; nothing else speaks."""
    read, write = os.pipe()
    bench = Bench(board.host.open_line(board.port), board.host)
    asked = 0

    def status():
        """Query the status, every 0.1 s; the operator types after 0.8 s."""
        nonlocal asked
        board.host.sleep(ALIVE_S)
        asked += 1
        if asked in TYPED:
            print(TYPED[asked], file=keyboard, flush=True)
        return Bench.status(bench)

    with os.fdopen(read) as stdin, os.fdopen(write, "w") as keyboard:
        monkeypatch.setattr("sys.stdin", stdin)
        bench.greet()
        bench.settle(1.0)
        monkeypatch.setattr(bench, "status", status)
        assert Terminal(bench).level() == 1.02
    assert asked >= max(TYPED)
    bench.expect_state("HOLD")


TYPED = {8: "a lot", 16: "1,02"}


def test_the_shipped_backends_keep_the_drivers_contract(capsys):
    assert commands.main(["plate", "conform", "mock", "--json"]) == 0
    verdicts = json.loads(capsys.readouterr().out)
    assert [each["rule"] for each in verdicts] == [rule for rule, _ in CONTRACT]
    assert {each["outcome"] for each in verdicts} == {"conforms"}


class Forgetful(MockPlate):
    """A plug-in that is wrong in one way."""

    def __init__(self, wrong):
        super().__init__(clock=VirtualClock())
        self.wrong = wrong

    def _drive(self, amplitude_um_pp):
        if self.wrong == "stays at the first" and self.log[-1].name == "present":
            amplitude_um_pp = self.log[-1].amplitude_um_pp
        if self.wrong == "another error":
            raise KeyError("amplitude")
        made = super()._drive(amplitude_um_pp)
        if self.wrong == "commanded only":
            return replace(made, readback=replace(made.readback, kind="commanded"))
        if self.wrong == "another commanded":
            return replace(made, commanded_level=made.commanded_level * 2)
        return made

    def _silence(self):
        if self.wrong == "no silence before connect" and not self._connected:
            raise ConnectionLost("not connected")
        if self.wrong != "never silent":
            super()._silence()

    def _connect(self):
        identity = super()._connect()
        return replace(identity, model="") if self.wrong == "nameless" else identity


@pytest.mark.parametrize(
    "wrong, rule",
    [
        ("another error", "an amplitude settles and remains constant"),
        ("another commanded", "an amplitude settles and remains constant"),
        ("never silent", "silence() can be called at any time, and more than once"),
        ("no silence before connect", "the output is off after connecting"),
        ("nameless", "the output is off after connecting"),
    ],
)
def test_a_backend_that_breaks_the_contract_is_told_which_rule(wrong, rule):
    plate = Forgetful(wrong)
    departs = {v.rule for v in examine_backend(Rig(plate, plate.clock)) if v.outcome == "departs"}
    assert rule in departs


def test_a_backend_that_only_echoes_is_told_that_this_proves_nothing():
    plate = Forgetful("commanded only")
    told = {each.rule: each for each in examine_backend(Rig(plate, plate.clock))}
    verdict = told["the readback can reveal a wrong amplitude"]
    assert verdict.outcome == "not applicable"
    assert "measure with a vibrometer" in verdict.detail


@pytest.mark.parametrize(
    "arguments, said",
    [
        (["serial:"], "expected serial:PORT"),
        (["mock", "--guided"], "only to driver boards"),
        (["nowhere:COM3"], "unknown backend 'nowhere'"),
    ],
)
def test_what_cannot_be_examined_is_refused(arguments, said, capsys):
    assert commands.main(["plate", "conform", *arguments]) == 2
    assert said in capsys.readouterr().err
