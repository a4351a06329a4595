"""What a surface is called in tables of comparisons: an amplitude, or a texture's name."""

from __future__ import annotations


def amplitude_of(label: str) -> float | None:
    """Return the amplitude that a label is, µm peak to peak; None of a texture's name.

    >>> amplitude_of("0.50"), amplitude_of("fine")
    (0.5, None)
    """
    try:
        return float(label)
    except ValueError:
        return None
