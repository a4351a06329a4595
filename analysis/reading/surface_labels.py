"""Interpret surface labels in tables of comparisons: an amplitude, or a texture's name."""

from __future__ import annotations


def amplitude_of(label: str) -> float | None:
    """Return the amplitude of a label, µm peak to peak; None for a texture's name.

    >>> amplitude_of("0.50"), amplitude_of("fine")
    (0.5, None)
    """
    try:
        return float(label)
    except ValueError:
        return None


def plain(label: str) -> str:
    """Return an amplitude in the format of all tables; return other labels unchanged.

    >>> plain("0.50"), plain("fine")
    ('0.5', 'fine')
    """
    amplitude = amplitude_of(label)
    return label if amplitude is None else f"{amplitude:g}"
