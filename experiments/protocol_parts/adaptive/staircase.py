"""The transformed staircase: k correct answers in a row lower the level, and one error raises it.

With equal steps, a staircase does not converge to Levitt's proportions (70.7 % for two-down
one-up), because the proportion depends on the step size. With García-Pérez's step ratios, the
proportion is independent of the step size (García-Pérez 1998, Vision Research 38, 1861-1881,
doi:10.1016/S0042-6989(97)00340-4, abstract).
"""

from __future__ import annotations

from slipscale.experiments.protocol_parts.adaptive.up_down import Scale, UpDown
from slipscale.faults import UserError

#: Size of a step down relative to a step up, keyed by the number of consecutive correct answers
#: before a step down. Staircases with these sizes converge to 77.85, 80.35, 83.15 and 85.84 %
#: correct.
STEP_RATIOS = {1: 0.2845, 2: 0.5488, 3: 0.7393, 4: 0.8415}


def staircase(
    *,
    start_level: float,
    lowest_level: float,
    highest_level: float,
    steps_up: tuple[float, ...],
    down_after: int = 2,
    scale: Scale = "log10",
    down_to_up: float | None = None,
    until_first_error: bool = False,
) -> UpDown:
    """Return the k-down-1-up rule, by default with García-Pérez's step ratio.

    For the other parameters and the errors raised, see `UpDown`.

    Parameters
    ----------
    down_after : int
        k: 1 to 4.
    down_to_up : float, optional
        Size of a step down relative to the step up; 1 for equal steps, as in Levitt (1971).

    Examples
    --------
    >>> rule = staircase(start_level=1, lowest_level=0.01, highest_level=2, steps_up=(0.2,))
    >>> round(rule.target, 4)
    0.8035
    >>> levitt = staircase(
    ...     start_level=1, lowest_level=0.01, highest_level=2, steps_up=(0.2,), down_to_up=1.0
    ... )
    >>> round(levitt.target, 4)
    0.7071
    """
    if down_after not in STEP_RATIOS:
        raise UserError(
            "staircase: down_after is {down_after}, expected one of {step_ratios}",
            down_after=down_after,
            step_ratios=", ".join(map(str, STEP_RATIOS)),
        )
    return UpDown(
        start_level=start_level,
        lowest_level=lowest_level,
        highest_level=highest_level,
        steps_up=steps_up,
        down_to_up=STEP_RATIOS[down_after] if down_to_up is None else down_to_up,
        down_after=down_after,
        scale=scale,
        until_first_error=until_first_error,
    )
