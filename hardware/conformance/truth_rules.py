"""Check that the board's reports are accurate. The plate vibrates.

The measured amplitude, the drive voltage and the command are compared with each other. If a board
has no vibration sensor, only the rules for the voltage apply. Errors that affect all of the board's
reports are detected by the guided tests (`slipscale.hardware.conformance.guided`).
"""

from __future__ import annotations

from collections.abc import Callable

from slipscale.faults.message import Message
from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.conformance.bench import Bench, NotApplicable, NotProved, differs

READINGS = 12
RANG_DOWN_S = 0.25  # 7 time constants of a plate with Q = 3,400 at 30.5 kHz
# Allowed sensor noise: a fraction of the commanded amplitude or, if larger, of the largest
# amplitude (0.05 µm if the largest amplitude is 2.5 µm).
SILENT_SHARE, SILENT_OF_LARGEST = 0.05, 0.02
AGREES = 0.1  # relative tolerance for amplitudes and voltages that should be the same
# Tolerance of the mean of many readings in HOLD (docs/reference/board-protocol.md), as a fraction
# of the commanded or of the largest amplitude.
BAND, BAND_OF_LARGEST = 0.025, 0.01
RAMP_SHARE = 0.8  # largest voltage at the start of a ramp, as a fraction of the settled voltage
STEP_MS = 200.0
VOLTAGE_ROUNDING = 1e-3
PROBES_S = (0.1, 0.3, 0.5, 0.7)  # the middle of each step of a list
# Amplitudes of a list, relative to their mean; an inverted, clipped or flat list would differ.
LIST_SHARES = (1.6, 0.4, 1.0, 1.0)
PROBE_AGREES = 0.25
LONG_LATE_S = 2.0


def mean_level(bench: Bench) -> float:
    """Return the mean of several readings. Raises NotApplicable if the board has no sensor."""
    readings = [bench.status().level for _ in range(READINGS)]
    known = [each for each in readings if each is not None]
    if len(known) < len(readings):
        raise NotApplicable("the board has no vibration sensor")
    return sum(known) / len(known)


def expect_silent(bench: Bench, after: str) -> None:
    """Check that voltage and amplitude are zero after the plate has rung down."""
    bench.wait(RANG_DOWN_S)
    status = bench.status()
    if status.voltage_v:
        differs(Message("VOLTAGE 0 after {after}", after=after), f"{status.voltage_v:g}")
    if status.level is None:
        return
    left_level = mean_level(bench)
    if left_level > max(SILENT_SHARE * bench.some_level, SILENT_OF_LARGEST * bench.limits.level):
        differs(
            Message("a plate at rest after {after}", after=after), f"{left_level:.3f} {bench.unit}"
        )


def expect_held(bench: Bench, level: float) -> None:
    """Check that the mean of many readings in HOLD agrees with a level, within the tolerance."""
    held_level = mean_level(bench)
    if abs(held_level - level) > max(BAND * level, BAND_OF_LARGEST * bench.limits.level):
        differs(
            Message(
                "a mean amplitude of {level:g} {unit} in state HOLD, within 2.5 %",
                level=level,
                unit=bench.unit,
            ),
            f"{held_level:.3f}",
        )


def _hold_is_true(bench: Bench) -> None:
    for level in (bench.some_level, bench.some_level / 2):
        bench.settle(level)
        expect_held(bench, level)


def _off_is_silent(bench: Bench) -> None:
    for body in ("OUTP OFF", "*RST", "AMPL 0"):
        bench.settle(bench.some_level)
        if body == "AMPL 0":
            bench.settle(0)
        else:
            bench.ask(body)
        expect_silent(bench, body)


def _stop_is_silent(bench: Bench) -> None:
    bench.settle(bench.some_level)
    bench.send(wire.STOP)
    expect_silent(bench, "!")


def _stop_ends_open_loop(bench: Bench) -> None:
    _open_loop(bench)
    bench.send(wire.STOP)
    bench.expect_state("OFF")
    expect_silent(bench, "! in open loop")


def _watchdog_is_silent(bench: Bench) -> None:
    bench.settle(bench.some_level)
    _unheard(bench)
    expect_silent(bench, "the watchdog")


def _watchdog_in_open_loop(bench: Bench) -> None:
    _open_loop(bench)
    _unheard(bench)
    expect_silent(bench, "the watchdog in open loop")


def _watchdog_in_a_list(bench: Bench) -> None:
    play(bench, [1.2, 0.8])
    _unheard(bench)
    expect_silent(bench, "the watchdog in a list")


def _watchdog_on_a_ramp(bench: Bench) -> None:
    """Check that the watchdog acts if the host stops sending during a ramp."""
    bench.ask(f"AMPL {bench.some_level:.4f}")
    _unheard(bench)


def _ramps(bench: Bench) -> None:
    settled_v = bench.settle(bench.some_level).voltage_v
    bench.settle(0)
    bench.ask(f"AMPL {bench.some_level:.4f}")
    rising_v = bench.status().voltage_v
    if rising_v > RAMP_SHARE * settled_v:
        differs(
            Message(
                "less than {ramp_share:.0%} of the settled {settled_v:.3f} V directly after AMPL",
                ramp_share=RAMP_SHARE,
                settled_v=settled_v,
            ),
            Message("{rising_v:.3f} V: a step", rising_v=rising_v),
        )
    bench.wait_for("HOLD")
    bench.ask("AMPL 0")
    if not bench.status().voltage_v:
        differs("a voltage above 0 directly after AMPL 0", "0: a step")
    bench.wait_for("OFF")


def _open_loop_is_true(bench: Bench) -> None:
    held = bench.settle(bench.some_level)
    _drive(bench, held.frequency_hz, held.voltage_v)
    same_level = mean_level(bench)
    if abs(same_level - bench.some_level) > max(
        AGREES * bench.some_level, SILENT_OF_LARGEST * bench.limits.level
    ):
        differs(
            Message(
                "{level:g} {unit} at the frequency and voltage reported in HOLD",
                level=bench.some_level,
                unit=bench.unit,
            ),
            f"{same_level:.3f}",
        )
    _drive(bench, held.frequency_hz, held.voltage_v / 2)
    half_level = mean_level(bench)
    if abs(half_level - same_level / 2) > max(
        AGREES * same_level, SILENT_OF_LARGEST * bench.limits.level
    ):
        differs(
            Message(
                "{same_level:.3f} {unit} with half the voltage",
                same_level=same_level / 2,
                unit=bench.unit,
            ),
            f"{half_level:.3f}",
        )
    away_hz = bench.limits.frequency_max_hz
    _drive(bench, away_hz, held.voltage_v / 2)
    away_level = mean_level(bench)
    if away_level > half_level / 2:
        differs(
            Message("less than half of this amplitude at {away_hz:g} Hz", away_hz=away_hz),
            f"{away_level:.3f}",
        )


def _list_reaches_its_largest(bench: Bench) -> None:
    """Check that the largest amplitude of a list is reached, also if several commands write it."""
    for shares in ([1.6, *[0.4] * 2, 1.6], [*[0.6] * 12, *[1.8] * 6]):
        held = bench.settle(bench.some_level)
        play(bench, shares)
        bench.wait(4 * len(shares) * bench.lists().step_ms * 5 / 1000)
        due_v = held.voltage_v * max(shares)
        got_v = bench.expect_state("LIST").voltage_v
        if abs(got_v - due_v) > AGREES * due_v:
            differs(
                Message("{due_v:.3f} V at the largest amplitude of the list", due_v=due_v),
                f"{got_v:.3f} V",
            )


def _list_keeps_time(bench: Bench) -> None:
    """Interrupt a list at several times, and compare the voltage with the point played then."""
    for share, probe_s in zip(LIST_SHARES, PROBES_S, strict=True):
        held = bench.settle(bench.some_level)
        due_level = share * bench.some_level
        play(bench, LIST_SHARES, step_ms=STEP_MS)
        bench.wait(probe_s)
        bench.ask(f"AMPL {due_level:.4f}")
        got_v, due_v = bench.status().voltage_v, held.voltage_v * share
        if abs(got_v - due_v) > PROBE_AGREES * held.voltage_v:
            differs(
                Message(
                    "{due_v:.3f} V {probe_s:.0f} ms after LIST:PLAY",
                    due_v=due_v,
                    probe_s=probe_s * 1000,
                ),
                f"{got_v:.3f} V",
            )


def _on_time(bench: Bench) -> None:
    if not bench.long:
        raise NotProved(
            Message(
                "this check takes {on_time_s:g} s; add --long",
                on_time_s=bench.limits.on_time_s,
            )
        )
    bench.settle(bench.some_level)
    bench.wait(bench.limits.on_time_s + LONG_LATE_S)
    bench.expect_state("LONG")
    expect_silent(bench, "the maximum on-time")


def settle_at_largest(bench: Bench) -> wire.BoardStatus:
    """Command the largest amplitude, check the drive voltage, and return the status.

    A load on the plate raises the voltage to its limit.
    """
    bench.ask(f"AMPL {bench.limits.level:.4f}")
    bench.wait(1.0)
    status = bench.expect_state("HOLD", "SAT")
    if status.voltage_v > bench.limits.voltage_v * (1 + VOLTAGE_ROUNDING):
        differs(
            Message("at most {limit_v:g} V peak (LIM?)", limit_v=bench.limits.voltage_v),
            f"{status.voltage_v:.3f} V",
        )
    return status


def _unheard(bench: Bench) -> None:
    """Wait for the watchdog time without sending a correct frame."""
    bench.wait(bench.limits.watchdog_ms / 1000 + 0.15, lambda: bench.answers_to(b"*IDN?\n"))
    bench.expect_state("WDOG")


def _drive(bench: Bench, frequency_hz: float, voltage_v: float) -> None:
    bench.ask(f"DRIV {frequency_hz:.1f},{voltage_v:.3f}")
    bench.wait(RANG_DOWN_S)


def _open_loop(bench: Bench) -> None:
    held = bench.settle(bench.some_level)
    _drive(bench, held.frequency_hz, held.voltage_v)
    bench.expect_state("OPEN")


def play(
    bench: Bench, shares: list[float] | tuple[float, ...], *, step_ms: float | None = None
) -> None:
    """Present the mean of a list of amplitudes until the plate has settled, then play the list.

    ``shares`` contains the amplitudes as fractions of the test amplitude.
    """
    lists = bench.lists()
    mean_level = bench.some_level * sum(shares) / len(shares)
    points = [f"{share * bench.some_level:.4f}" for share in shares]
    bench.ask("*RST")
    bench.settle(round(mean_level, 4))
    for first in range(0, len(points), wire.POINTS_A_LINE):
        words = ",".join(points[first : first + wire.POINTS_A_LINE])
        bench.ask(f"LIST:AMPL {first + 1},{words}")
    step_ms = step_ms or max(5 * lists.step_ms, lists.edge_ms)
    bench.ask(f"LIST:PLAY {len(points)},{step_ms:.3f},{lists.edge_ms:.3f}")


RULES: tuple[tuple[str, Callable[[Bench], object]], ...] = (
    ("the mean amplitude in HOLD is within 2.5 % of TARGET", _hold_is_true),
    ("the drive voltage stays within the board's limit", settle_at_largest),
    ("amplitude changes are ramps, not steps", _ramps),
    ("OFF is silent", _off_is_silent),
    ("the stop byte ! leaves the plate silent", _stop_is_silent),
    ("the stop byte ! ends open-loop operation", _stop_ends_open_loop),
    ("WDOG is silent", _watchdog_is_silent),
    ("the watchdog also silences the plate in open-loop operation", _watchdog_in_open_loop),
    ("the watchdog also silences the plate during an amplitude list", _watchdog_in_a_list),
    ("the watchdog also silences the plate during a ramp", _watchdog_on_a_ramp),
    ("after DRIV, the board applies the voltage that it reports", _open_loop_is_true),
    ("an amplitude list reaches its largest amplitude", _list_reaches_its_largest),
    ("an amplitude list is played in order and on time", _list_keeps_time),
    ("the plate is switched off after the maximum on-time", _on_time),
)
