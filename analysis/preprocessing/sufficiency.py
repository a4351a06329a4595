"""Define the minimum number of participants, and a message for insufficient data."""

from __future__ import annotations

#: Relative differences below this value are treated as rounding errors.
TINY = 1e-12
#: Minimum number of participants for a test.
FEWEST = 3
#: With so few degrees of freedom of the error, a test has hardly any power.
FEW_DF = 3


def few_degrees(df: float) -> bool:
    """Return whether a test with these degrees of freedom can hardly detect a difference."""
    return df <= FEW_DF


def few(what: str, there: int, needed: int = FEWEST) -> str:
    """Return a message about insufficient data.

    >>> few("amplitudes", 1, 2)
    'too few amplitudes (1; at least 2 are needed)'
    """
    return f"too few {what} ({there}; at least {needed} are needed)"
