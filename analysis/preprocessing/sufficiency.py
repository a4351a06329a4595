"""Define the minimum number of participants, and a message for insufficient data."""

from __future__ import annotations

#: Relative differences below this value are treated as rounding errors.
TINY = 1e-12
#: Minimum number of participants for a test.
FEWEST = 3


def few(what: str, there: int, needed: int = FEWEST) -> str:
    """Return a message about insufficient data.

    >>> few("amplitudes", 1, 2)
    'too few amplitudes (1; at least 2 are needed)'
    """
    return f"too few {what} ({there}; at least {needed} are needed)"
