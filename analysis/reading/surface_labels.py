"""Parse surface labels in comparison tables, which are amplitudes or texture names."""

from __future__ import annotations


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
    """Write an amplitude in the usual format of tables; return other labels unchanged.

    >>> plain("0.50"), plain("fine")
    ('0.5', 'fine')
    """
    amplitude = amplitude_of(label)
    return label if amplitude is None else f"{amplitude:g}"
