"""Round levels to the precision with which stimuli are presented."""

from __future__ import annotations

#: Number of decimals of levels and information gains. Sums of floats differ in their last bits
#: between machines, but levels must be the same, so that a run can be resumed on another machine.
DECIMALS = 9


def rounded(level: float) -> float:
    """Return a level, in µm peak to peak, rounded to the precision with which it is presented.

    >>> rounded(0.1 + 0.2)
    0.3
    """
    return round(level, DECIMALS)
