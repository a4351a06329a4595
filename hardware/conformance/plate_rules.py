"""Check settling, stopping, watchdog, open loop and amplitude lists. The plate vibrates."""

from __future__ import annotations

from collections.abc import Callable

from slipscale.faults.message import Message
from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.conformance.bench import Bench, differs
from slipscale.hardware.limits import PlateLimits

WATCHDOG_LATE_S = 0.15
OPEN_LOOP_SHARE = 0.1  # test voltage in open loop, as a fraction of the largest voltage
POINTS_NEEDED = 64
LIST_PERIODS_S = 0.5


def _settles(bench: Bench) -> None:
    for level in (bench.some_level, bench.some_level / 2):
        status = bench.settle(level)
        if abs(status.target_level - level) > 1e-4:  # noqa: PLR2004 - its last decimal
            differs(f"TARGET {level:g}", f"{status.target_level:g}")
        if status.level is not None:
            _expect_near(bench, level, status.level)
    bench.wait(0.3)
    bench.expect_state("HOLD")


def _expect_near(bench: Bench, due_level: float, measured_level: float) -> None:
    shipped = PlateLimits()
    least = shipped.deviation_level / shipped.level * bench.limits.level
    allowed = max(shipped.tolerance * due_level, least)
    if abs(measured_level - due_level) > allowed:
        differs(f"{due_level:g} {bench.unit} within {allowed:g}", f"{measured_level:g}")


def _begins_with_a_ramp(bench: Bench) -> None:
    bench.ask("OUTP OFF")
    bench.ask(f"AMPL {bench.some_level:.4f}")
    bench.expect_state("RAMP")
    bench.wait_for("HOLD")
    bench.ask("AMPL 0")
    bench.expect_state("RAMP")


def _refused_changes_nothing(bench: Bench) -> None:
    status = bench.settle(bench.some_level)
    for body in ("AMPL 9999999", "AMPL nan", "AMPL", "FOO", "OUTP ON", "DRIV 1,1"):
        if bench.run(body).code == wire.OK:
            differs(Message("'{body}' to be refused", body=body), "code 0")
        bench.expect_unchanged(body, status)


def _zero_ends_off(bench: Bench) -> None:
    bench.settle(bench.some_level)
    status = bench.settle(0)
    if status.target_level or status.voltage_v:
        differs("TARGET 0 and VOLTAGE 0 when the plate is off", wire.format_status(status))
    bench.ask("AMPL 0")
    bench.expect_state("OFF")


def _off_at_once(bench: Bench) -> None:
    for body in ("OUTP OFF", "OUTP 0", "*RST"):
        bench.settle(bench.some_level)
        bench.ask(body)
        bench.expect_state("OFF")


def _watchdog(bench: Bench) -> None:
    bench.settle(bench.some_level)
    bench.wait(
        bench.limits.watchdog_ms / 1000 + WATCHDOG_LATE_S,
        lambda: bench.answers_to(b"*IDN?\nnoise\n>7 STAT?*0000\n"),
    )
    bench.expect_state("WDOG")
    bench.expect_state("WDOG")


def _watchdog_and_repetitions(bench: Bench) -> None:
    bench.settle(bench.some_level)
    frame = bench.frame("LIM?")
    bench.wait(1.5 * bench.limits.watchdog_ms / 1000, lambda: bench.reply_to(frame))
    bench.expect_state("HOLD")


def _watchdog_clears(bench: Bench) -> None:
    for body, state in (("OUTP OFF", "OFF"), ("*RST", "OFF"), ("AMPL 0", "OFF")):
        _watchdog(bench)
        bench.ask(body)
        bench.expect_state(state)
    _watchdog(bench)
    bench.settle(bench.some_level)


def _open_loop(bench: Bench) -> None:
    frequency_hz = bench.settle(bench.some_level).frequency_hz
    voltage_v = OPEN_LOOP_SHARE * bench.limits.voltage_v
    bench.ask(f"DRIV {frequency_hz:.1f},{voltage_v:.3f}")
    status = bench.expect_state("OPEN")
    if (
        abs(status.frequency_hz - frequency_hz) > 1
        or abs(status.voltage_v - voltage_v) > 0.01 * voltage_v
        or status.target_level
    ):
        differs(
            Message(
                "TARGET 0, {frequency_hz:.1f} Hz and {voltage_v:.3f} V",
                frequency_hz=frequency_hz,
                voltage_v=voltage_v,
            ),
            wire.format_status(status),
        )
    bench.settle(bench.some_level)
    bench.ask(f"DRIV {frequency_hz:.1f},{voltage_v:.3f}")
    bench.settle(0)


def _list_limits(bench: Bench) -> None:
    lists = bench.lists()
    if lists.points < POINTS_NEEDED:
        differs(
            Message("room for at least {points_needed} amplitudes", points_needed=POINTS_NEEDED),
            str(lists.points),
        )


def _list_is_filled(bench: Bench) -> None:
    lists = bench.lists()
    bench.ask("*RST")
    for body, code in (
        ("LIST:AMPL 2,0.1", wire.OUT_OF_RANGE),
        ("LIST:AMPL 0,0.1", wire.OUT_OF_RANGE),
        ("LIST:AMPL 1", wire.MISSING_PARAMETER),
        ("LIST:AMPL 1,0.1,0.2,0.3", wire.OK),
        ("LIST:AMPL 1.5,0.1", wire.OUT_OF_RANGE),
        ("LIST:AMPL 5,0.1", wire.OUT_OF_RANGE),
        ("LIST:AMPL 4,0,0,0,0,0,0,0,0", wire.OK),
        ("LIST:AMPL 4,0,0,0,0,0,0,0,0,0", wire.DATA_TYPE),
        ("LIST:AMPL 12,9999", wire.OUT_OF_RANGE),
        ("LIST:AMPL 12,0,,0", wire.DATA_TYPE),
    ):
        bench.expect_code(body, code)
    for first in range(12, lists.points + 1):
        bench.ask(f"LIST:AMPL {first},0.1")
    bench.expect_code(f"LIST:AMPL {lists.points + 1},0.1", wire.OUT_OF_RANGE)
    bench.ask("*RST")
    bench.expect_code("LIST:AMPL 2,0.1", wire.OUT_OF_RANGE)


def _list_waits_for_hold(bench: Bench) -> None:
    play = _list_command(bench)
    bench.expect_code(play, wire.SETTINGS_CONFLICT)
    bench.ask(f"AMPL {bench.some_level:.4f}")
    bench.expect_code(play, wire.SETTINGS_CONFLICT)
    bench.wait_for("HOLD")
    count, times = play.split(" ")[1].split(",", 1)
    bench.expect_code(f"LIST:PLAY {int(count) + 1},{times}", wire.SETTINGS_CONFLICT)
    bench.ask(play)


def _list_times(bench: Bench) -> None:
    lists = bench.lists()
    step_ms, edge_ms = 10 * lists.step_ms, lists.edge_ms
    bench.settle(bench.some_level)
    for body in (
        f"LIST:PLAY 1,{step_ms:.3f},{edge_ms:.3f}",
        f"LIST:PLAY 2,{lists.step_ms - 0.01:.3f},{edge_ms:.3f}",
        f"LIST:PLAY 2,{step_ms:.3f},{edge_ms - 0.01:.3f}",
        f"LIST:PLAY 2,{step_ms:.3f},{step_ms + 0.01:.3f}",
        f"LIST:PLAY 2,{1000 * bench.limits.on_time_s + 1:.0f},{edge_ms:.3f}",
    ):
        bench.expect_code(body, wire.OUT_OF_RANGE)
    bench.expect_code(f"LIST:PLAY 2,{step_ms:.3f}", wire.MISSING_PARAMETER)


def _list_plays(bench: Bench) -> None:
    play = _list_command(bench)
    bench.settle(bench.some_level)
    bench.ask(play)
    status = bench.expect_state("LIST")
    if abs(status.target_level - bench.some_level) > 1e-4:  # noqa: PLR2004 - its last decimal
        differs(
            Message("TARGET {level:g}, the mean of the amplitude list", level=bench.some_level),
            f"{status.target_level:g}",
        )
    bench.expect_code("LIST:AMPL 1,0.1", wire.SETTINGS_CONFLICT)
    bench.expect_code(play, wire.SETTINGS_CONFLICT)
    bench.wait(LIST_PERIODS_S)
    status = bench.expect_state("LIST")
    if status.level is not None:
        _expect_near(bench, bench.some_level, status.level)
    bench.settle(bench.some_level)
    bench.ask(play)
    bench.settle(0)


def _stop_ends_a_list(bench: Bench) -> None:
    play = _list_command(bench)
    bench.settle(bench.some_level)
    bench.ask(play)
    bench.send(wire.STOP)
    bench.expect_state("OFF")
    bench.expect_code(play, wire.SETTINGS_CONFLICT)


def _list_command(bench: Bench) -> str:
    """Write a list of amplitudes around the test amplitude; return the command to play it."""
    lists = bench.lists()
    bench.ask("*RST")
    bench.ask(f"LIST:AMPL 1,{1.2 * bench.some_level:.4f},{0.8 * bench.some_level:.4f}")
    return f"LIST:PLAY 2,{max(5 * lists.step_ms, lists.edge_ms):.3f},{lists.edge_ms:.3f}"


RULES: tuple[tuple[str, Callable[[Bench], None]], ...] = (
    ("after AMPL, the amplitude settles within 2 s and is then held", _settles),
    ("a new amplitude begins with a ramp", _begins_with_a_ramp),
    ("a refused command does not change the plate", _refused_changes_nothing),
    ("AMPL 0 switches the output off", _zero_ends_off),
    ("OUTP OFF and *RST switch off at once", _off_at_once),
    ("the watchdog silences the plate when no correct frame arrives", _watchdog),
    ("repeated frames reset the watchdog", _watchdog_and_repetitions),
    ("the next command to the plate ends the state WDOG", _watchdog_clears),
    ("DRIV applies the commanded frequency and voltage", _open_loop),
    ("an amplitude list can store 64 amplitudes", _list_limits),
    ("the amplitudes of a list can only be set in order and within the limits", _list_is_filled),
    (
        "an amplitude list is played only if it is complete and the plate has settled",
        _list_waits_for_hold,
    ),
    ("amplitude lists with times outside the limits are rejected", _list_times),
    ("an amplitude list is played, and its mean is reported", _list_plays),
    ("the stop byte ! ends an amplitude list", _stop_ends_a_list),
)
