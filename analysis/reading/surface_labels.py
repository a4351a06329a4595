"""Parse, format and sort labels of surfaces (amplitudes or texture names) and conditions."""

from __future__ import annotations

import re

from slipscale.stimuli.quantity import Quantity

NUMBER = re.compile(r"\d+(?:\.\d+)?")


def amplitude_of(label: str) -> float | None:
    """Return the amplitude in µm peak to peak, or None for a texture name.

    >>> amplitude_of("0.50"), amplitude_of("fine")
    (0.5, None)
    """
    try:
        return float(label)
    except ValueError:
        return None


def plain(label: str) -> str:
    """Format a label that is an amplitude as in the tables; return other labels unchanged.

    >>> plain("0.50"), plain("fine")
    ('0.5', 'fine')
    """
    amplitude = amplitude_of(label)
    return label if amplitude is None else f"{amplitude:g}"


def with_unit(label: str, quantity: Quantity) -> str:
    """Write an amplitude with its unit; return other labels unchanged.

    >>> from slipscale.stimuli.quantity import PLATE_AMPLITUDE
    >>> with_unit("0.50", PLATE_AMPLITUDE), with_unit("fine", PLATE_AMPLITUDE)
    ('0.5 µm', 'fine')
    """
    amplitude = amplitude_of(label)
    return label if amplitude is None else quantity.value(amplitude)


def numbers_first(label: object) -> tuple[bool, float, str]:
    """Return a sort key that puts numeric labels first, in numerical order.

    >>> sorted(["10", "b", "2.5", "a"], key=numbers_first)
    ['2.5', '10', 'a', 'b']
    """
    try:
        return False, float(str(label)), ""
    except ValueError:
        return True, 0.0, str(label)


def padded(label: str) -> str:
    """Pad the numbers in a label with zeros, so that sorting puts 80 before 320.

    >>> sorted(["f-320", "f-80"], key=padded)
    ['f-80', 'f-320']
    """
    return NUMBER.sub(lambda number: f"{float(number[0]):020.6f}", label)
