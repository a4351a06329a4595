"""Interpret surface labels in comparison tables: an amplitude or a texture name."""

from __future__ import annotations


def amplitude_of(label: str) -> float | None:
    """Return the amplitude of a label in µm peak to peak; None for a texture name.

    >>> amplitude_of("0.50"), amplitude_of("fine")
    (0.5, None)
    """
    try:
        return float(label)
    except ValueError:
        return None


def plain(label: str) -> str:
    """Return an amplitude in the common table format; return other labels unchanged.

    >>> plain("0.50"), plain("fine")
    ('0.5', 'fine')
    """
    amplitude = amplitude_of(label)
    return label if amplitude is None else f"{amplitude:g}"
