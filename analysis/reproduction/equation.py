"""Compare both sides of equations, as printed.

The value of an item is the relative difference between the equation as printed (with its signs,
factors and units) and a separate evaluation: quadrature, a numerical derivative or differences. A
value of 0 means that the print is right. If the print is wrong, the reason states the correction.
Definitions, laws of a material, and identities between our functions agree by construction.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from slipscale.analysis.reproduction.comparison import Outcome, item

#: Differences below this are rounding errors of the numerical evaluation.
NOTHING = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """Comparison of the two sides of an equation.

    Parameters
    ----------
    difference : callable
        Function that returns the relative difference; see `apart`.
    reason : str
        How the equation was evaluated, or what is wrong in the print.
    definition : bool
        Whether both sides agree by construction: a definition, or an identity of our functions.
    also : tuple of int
        Other equations that the same comparison covers.
    """

    difference: Callable[[], float]
    reason: str
    definition: bool = False
    also: tuple[int, ...] = ()


def items(checks: Mapping[int, Check]) -> dict[str, Callable[[], Outcome]]:
    """Return one item per check, keyed by name, such as ``eq.14``."""
    return {
        f"eq.{number}": item(
            check.difference,
            "equal",
            "relative difference",
            check.reason,
            rule=no_difference,
            by_construction=check.definition,
            covers=tuple(f"eq.{each}" for each in (number, *check.also)),
        )
        for number, check in checks.items()
    }


def no_difference(_published: str, ours: float) -> bool:
    """Return whether both sides of an equation are equal."""
    return ours == 0


def apart(one: object, other: object) -> float:
    """Return the largest difference relative to the largest value; 0 if it is only rounding."""
    import numpy as np

    first, second = np.broadcast_arrays(np.asarray(one, float), np.asarray(other, float))
    scale = max(float(np.abs(first).max()), float(np.abs(second).max()))
    found = float(np.abs(first - second).max()) / scale if scale else 0.0
    return found if found > NOTHING else 0.0
