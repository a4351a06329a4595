"""How much data a result needs, and what to say where there is less."""

from __future__ import annotations

#: Differences below this, relative, are rounding.
TINY = 1e-12
#: Fewer participants than this give no test.
FEWEST = 3


def few(what: str, there: int, needed: int = FEWEST) -> str:
    """Say of what there is too little.

    >>> few("amplitudes", 1, 2)
    'amplitudes: 1 (at least 2 are needed)'
    """
    return f"{what}: {there} (at least {needed} are needed)"
