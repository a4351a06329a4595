"""Parse the arguments of the driver board's commands."""

from __future__ import annotations

import re

from slipscale.hardware.backends.serial_board import protocol as wire

NUMBER = re.compile(r"[+-]?\d{1,7}(\.\d{1,6})?")


class Refusal(Exception):
    """Raised if the board answers a command with an error code."""

    def __init__(self, code: int) -> None:
        super().__init__(wire.MEANINGS[code])
        self.code = code


def split(text: str, fewest: int, most: int) -> list[str]:
    """Split arguments; raise `Refusal` if there are fewer than ``fewest`` or more than ``most``."""
    arguments = text.split(",") if text else []
    if len(arguments) < fewest:
        raise Refusal(wire.MISSING_PARAMETER)
    if len(arguments) > most:
        raise Refusal(wire.DATA_TYPE)
    return arguments


def within(text: str, lowest: float, highest: float) -> float:
    """Parse a number within bounds."""
    if not NUMBER.fullmatch(text):
        raise Refusal(wire.DATA_TYPE)
    if not lowest <= float(text) <= highest:
        raise Refusal(wire.OUT_OF_RANGE)
    return float(text)


def whole(text: str, lowest: int, highest: int) -> int:
    """Parse an integer within bounds."""
    value = within(text, lowest, highest)
    if not value.is_integer():
        raise Refusal(wire.OUT_OF_RANGE)
    return int(value)
