"""Run guided tests of a driver board with a load and external instruments.

These tests check properties that a board could report incorrectly. A person (`Assistant`) puts a
load on the plate and reads a vibrometer and an oscilloscope. Do not use a finger as the load,
because the plate vibrates. Use a soft pad that lowers the reading by about 10 to 20 %.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Protocol

from slipscale.faults import UserError
from slipscale.hardware.calibration.keep_alive import typed
from slipscale.hardware.conformance.bench import Bench, differs
from slipscale.hardware.conformance.table import Verdict, judged
from slipscale.hardware.conformance.truth_rules import (
    LIST_SHARES,
    expect_held,
    play,
    settle_at_largest,
)

# Tolerance for a second instrument, which may be calibrated differently: a fraction of the
# amplitude or, if larger, of the largest amplitude (0.05 µm if the largest amplitude is 2.5 µm).
SEEN, SEEN_OF_LARGEST = 0.1, 0.02
SWING_S = 2.0
NEEDS_A_PERSON = "it needs a person, a load and a second instrument; add --guided"
STEP_MS = 200.0


class Assistant(Protocol):
    """Interface for the person who places the load and reads the instruments."""

    def load(self, *, on: bool) -> None:
        """Put the load on the plate, or remove the load."""

    def level(self) -> float:
        """Return the vibrometer's reading at an antinode, in the board's unit."""

    def swing(self, duration_s: float) -> tuple[float, float]:
        """Return the vibrometer's smallest and largest reading during ``duration_s``."""

    def volts_peak(self) -> float:
        """Return the oscilloscope's reading at the plate, in V peak."""


class Terminal:
    """Person who answers questions at the terminal.

    While a question waits for an answer, the board's status is queried, so that the watchdog does
    not switch the plate off.
    """

    def __init__(self, bench: Bench) -> None:
        self._bench = bench

    def load(self, *, on: bool) -> None:
        """Ask the person to put the load on the plate or to remove it."""
        act = "put the soft load on the plate" if on else "take the load off the plate"
        self._typed(f"{act}, then press Enter: ")

    def level(self) -> float:
        """Ask for the vibrometer's reading."""
        return self._number(f"the vibrometer's reading in {self._bench.unit}: ")

    def swing(self, duration_s: float) -> tuple[float, float]:
        """Ask for the vibrometer's smallest and largest amplitude."""
        watch = f"a texture plays; watch the vibrometer's envelope for {duration_s:g} s"
        return (
            self._number(f"{watch}. The smallest amplitude in {self._bench.unit}: "),
            self._number(f"the largest amplitude in {self._bench.unit}: "),
        )

    def volts_peak(self) -> float:
        """Ask for the oscilloscope's reading."""
        return self._number("the oscilloscope's reading at the plate in V peak: ")

    def _number(self, question: str) -> float:
        while True:
            try:
                value = float(self._typed(question).replace(",", "."))
            except ValueError:
                value = math.nan
            if math.isfinite(value) and value >= 0:
                return value
            print("expected a number, 0 or more")

    def _typed(self, question: str) -> str:
        try:
            return typed(question, self._bench.status)
        except EOFError:
            raise UserError("plate conform --guided: standard input has ended") from None


def _amplitude(bench: Bench, assistant: Assistant) -> None:
    for level in (bench.some_level, bench.some_level / 2):
        bench.settle(level)
        _expect_level(bench, level, assistant.level())


def _volts(bench: Bench, assistant: Assistant) -> None:
    status = bench.settle(bench.some_level)
    _expect_seen(status.voltage_v, assistant.volts_peak(), "V peak at the plate", 0.1)


def _silence(bench: Bench, assistant: Assistant) -> None:
    for body in ("OUTP OFF", "*RST"):
        bench.settle(bench.some_level)
        bench.ask(body)
        bench.wait(0.3)
        _expect_level(bench, 0, assistant.level(), f" after {body}")


def _loaded(bench: Bench, assistant: Assistant) -> None:
    assistant.load(on=True)
    try:
        for level in (bench.some_level, bench.some_level / 2):
            bench.settle(level)
            expect_held(bench, level)
            bench.settle(0)
        bench.settle(bench.some_level)
        _expect_level(bench, bench.some_level, assistant.level(), " with the load")
    finally:
        assistant.load(on=False)


def _saturates(bench: Bench, assistant: Assistant) -> None:
    """Check that a loaded plate either reports SAT or truly holds the largest amplitude in HOLD."""
    assistant.load(on=True)
    try:
        if settle_at_largest(bench).state == "HOLD":
            expect_held(bench, bench.limits.level)
    finally:
        assistant.load(on=False)


def _texture(bench: Bench, assistant: Assistant) -> None:
    play(bench, LIST_SHARES, step_ms=STEP_MS)
    smallest, largest = assistant.swing(SWING_S)
    _expect_level(bench, min(LIST_SHARES) * bench.some_level, smallest, " at the minimum", factor=2)
    _expect_level(bench, max(LIST_SHARES) * bench.some_level, largest, " at the maximum", factor=2)


def _expect_level(
    bench: Bench, due: float, seen: float, when: str = "", *, factor: float = 1
) -> None:
    noise = factor * SEEN_OF_LARGEST * bench.limits.level
    _expect_seen(due, seen, f"{bench.unit}{when}", noise)


def _expect_seen(due: float, seen: float, what: str, noise: float) -> None:
    if abs(seen - due) > max(SEEN * due, noise):
        differs(f"{due:g} {what} on the second instrument", f"{seen:g}")


STEPS: tuple[tuple[str, Callable[[Bench, Assistant], None]], ...] = (
    ("a vibrometer confirms the commanded amplitude", _amplitude),
    ("an oscilloscope confirms the reported voltage", _volts),
    ("a vibrometer measures no vibration when the board is off", _silence),
    ("a loaded plate in state HOLD has the commanded amplitude", _loaded),
    ("a loaded plate at the largest amplitude reports HOLD or SAT", _saturates),
    ("a vibrometer confirms the extreme amplitudes of an amplitude list", _texture),
)


def guide(bench: Bench, assistant: Assistant) -> Iterator[Verdict]:
    """Perform the guided tests with an assistant. The plate is off before and after the tests.

    Raises
    ------
    PlateFault
        If communication fails.
    """
    bench.greet()
    for rule, step in STEPS:
        yield judged(bench, rule, _with(assistant, step))


def _with(
    assistant: Assistant, step: Callable[[Bench, Assistant], None]
) -> Callable[[Bench], None]:
    return lambda bench: step(bench, assistant)


def unguided() -> Iterator[Verdict]:
    """Return the verdicts on the guided tests if nobody performs them."""
    for rule, _ in STEPS:
        yield Verdict(rule=rule, outcome="not proved", detail=NEEDS_A_PERSON)
