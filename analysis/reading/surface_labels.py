"""Parse surface labels (amplitudes or texture names) in comparison tables."""

from __future__ import annotations

from slipscale.stimuli.quantity import Quantity


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
