"""The weighted up-down method, in which every answer changes the level.

Kaernbach 1991, Perception & Psychophysics 49, 227-229, doi:10.3758/BF03214307: the level converges
to the proportion correct p for which ``down p = up (1 - p)``. For 75 % correct, steps up are three
times as large as steps down.
"""

from __future__ import annotations

from slipscale.experiments.protocol_parts.adaptive.up_down import Scale, UpDown
from slipscale.faults import UserError


def weighted(
    *,
    start_level: float,
    lowest_level: float,
    highest_level: float,
    steps_up: tuple[float, ...],
    target: float = 0.75,
    scale: Scale = "log10",
) -> UpDown:
    """Return the weighted up-down rule that converges to a given proportion correct.

    For the other parameters and the errors raised, see `UpDown`.

    Parameters
    ----------
    target : float
        Proportion correct to which the level converges, between 0 and 1.

    Examples
    --------
    >>> rule = weighted(start_level=1, lowest_level=0.01, highest_level=2, steps_up=(0.3,))
    >>> round(1 / rule.down_to_up, 9)
    3.0
    """
    if not 0 < target < 1:
        raise UserError(
            "weighted up-down: target is {target:g}, expected between 0 and 1", target=target
        )
    return UpDown(
        start_level=start_level,
        lowest_level=lowest_level,
        highest_level=highest_level,
        steps_up=steps_up,
        down_to_up=(1 - target) / target,
        scale=scale,
    )
