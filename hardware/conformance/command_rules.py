"""Check that a board follows the protocol's rules for commands, arguments and errors."""

from __future__ import annotations

from collections.abc import Callable

from slipscale.faults.message import Message
from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.conformance.bench import Bench, differs

QUEUE = 8
NO_NUMBERS = (
    "nan", "inf", "-inf", "1e0", "1E0", "0x1", ".5", "1.", "+", "-", "--1", " 1", "1 ", "1_0", "",
    "00000001", "0.1234567", "O", "1;1",
)  # fmt: skip
NUMBERS_OF_ZERO = ("0", "+0", "-0", "0.0", "0000000", "0.000000", "-0000000.000000")
NOT_HEADERS = (
    "FOO",
    "stat?",
    "*idn?",
    "Ampl 0",
    "STAT",
    "STATUS?",
    "SYSTEM:ERR?",
    " STAT?",
    "*IDN",
)
TOO_MANY = ("AMPL 0,0", "OUTP OFF,1", "STAT? 1", "*IDN? 1", "*RST 1", "LIM? 1", "SYST:ERR? 1")
TOO_FEW = ("AMPL", "AMPL ", "DRIV", "OUTP")
OTHER_WORDS = ("ON", "off", "1", "OF", "00", "OFF ")


def _headers(bench: Bench) -> None:
    for body in NOT_HEADERS:
        bench.expect_code(body, wire.UNDEFINED_HEADER)


def _missing(bench: Bench) -> None:
    for body in (*TOO_FEW, f"DRIV {bench.limits.frequency_min_hz:.1f}"):
        bench.expect_code(body, wire.MISSING_PARAMETER)


def _surplus(bench: Bench) -> None:
    for body in (*TOO_MANY, f"DRIV {bench.limits.frequency_min_hz:.1f},0,0"):
        bench.expect_code(body, wire.DATA_TYPE)


def _no_numbers(bench: Bench) -> None:
    for text in NO_NUMBERS:
        # A single empty argument counts as no argument.
        body = f"AMPL {text}" if text else f"DRIV ,{text}"
        bench.expect_code(body, wire.DATA_TYPE)


def _numbers(bench: Bench) -> None:
    for text in NUMBERS_OF_ZERO:
        bench.ask(f"AMPL {text}")
        bench.expect_state("OFF")


def _words(bench: Bench) -> None:
    for word in OTHER_WORDS:
        bench.expect_code(f"OUTP {word}", wire.OUT_OF_RANGE)
    for word in ("OFF", "0"):
        bench.ask(f"OUTP {word}")


def _board_limits(bench: Bench) -> None:
    limits = bench.limits
    within_hz = 0.5 * (limits.frequency_min_hz + limits.frequency_max_hz)
    for body in (
        f"AMPL {limits.level + 0.01:.4f}",
        "AMPL -0.0001",
        "AMPL 9999999",
        f"DRIV {limits.frequency_min_hz - 1:.1f},0",
        f"DRIV {limits.frequency_max_hz + 1:.1f},0",
        f"DRIV {within_hz:.1f},{limits.voltage_v + 0.01:.3f}",
        f"DRIV {within_hz:.1f},-0.001",
    ):
        bench.expect_code(body, wire.OUT_OF_RANGE)
    bench.expect_state("OFF")


def _order_of_errors(bench: Bench) -> None:
    bench.expect_code("FOO 1,nan", wire.UNDEFINED_HEADER)
    bench.expect_code("AMPL nan,nan", wire.DATA_TYPE)
    bench.expect_code("DRIV nan", wire.MISSING_PARAMETER)
    bench.expect_code("DRIV 1,nan", wire.OUT_OF_RANGE)
    bench.expect_code("DRIV nan,9999", wire.DATA_TYPE)


def _errors_in_order(bench: Bench) -> None:
    bench.ask("*RST")
    bench.expect_code("FOO", wire.UNDEFINED_HEADER)
    bench.expect_code("OUTP ON", wire.OUT_OF_RANGE)
    bench.expect_code("AMPL", wire.MISSING_PARAMETER)
    for code in (wire.UNDEFINED_HEADER, wire.OUT_OF_RANGE, wire.MISSING_PARAMETER, wire.OK):
        _expect_error(bench, code)


def _error_overflow(bench: Bench) -> None:
    bench.ask("*RST")
    bench.expect_code("FOO", wire.UNDEFINED_HEADER)
    bench.expect_code("AMPL", wire.MISSING_PARAMETER)
    for _ in range(QUEUE - 1):
        bench.expect_code("OUTP ON", wire.OUT_OF_RANGE)
    for code in (wire.MISSING_PARAMETER, *[wire.OUT_OF_RANGE] * (QUEUE - 1), wire.OK):
        _expect_error(bench, code)


def _reset_forgets_errors(bench: Bench) -> None:
    bench.expect_code("FOO", wire.UNDEFINED_HEADER)
    bench.ask("*RST")
    _expect_error(bench, wire.OK)


def _expect_error(bench: Bench, code: int) -> None:
    error, expected = bench.ask("SYST:ERR?"), f'{code},"{wire.MEANINGS[code]}"'
    if error != expected:
        differs(Message("the error {expected}", expected=expected), error)


RULES: tuple[tuple[str, Callable[[Bench], None]], ...] = (
    ("only the protocol's headers are accepted", _headers),
    ("a missing argument causes error -109", _missing),
    ("an extra argument causes error -104", _surplus),
    ("anything except a plain decimal number causes error -104", _no_numbers),
    ("numbers may have a sign, leading zeros and six decimals", _numbers),
    ("OUTP accepts OFF and 0", _words),
    ("values outside the board's limits cause error -222", _board_limits),
    ("the first error of a command is reported", _order_of_errors),
    ("errors are read oldest first", _errors_in_order),
    ("a ninth error replaces the oldest", _error_overflow),
    ("*RST clears all errors", _reset_forgets_errors),
)
