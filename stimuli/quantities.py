"""Check that physical values are finite and in range."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from slipscale.faults import UserError
from slipscale.faults.message import Message

Array = npt.NDArray[np.float64]
Number = float | Array

MICRO, MILLI = 1e-6, 1e-3


def positive(name: str, value: npt.ArrayLike, unit: str, *, maximum: float = np.inf) -> Array:
    """Convert values to an array of floats, after checking that all are positive.

    Raises
    ------
    UserError
        If a value is not finite, is not greater than 0, or is greater than ``maximum``. The message
        contains the quantity, the first invalid value and the range.
    """
    return _within(name, value, unit, (0.0, maximum), open_below=True)


def not_negative(name: str, value: npt.ArrayLike, unit: str, *, maximum: float = np.inf) -> Array:
    """Convert values to an array of floats, after checking that no value is negative."""
    return _within(name, value, unit, (0.0, maximum), open_below=False)


def between(name: str, value: npt.ArrayLike, unit: str, low: float, high: float) -> Array:
    """Convert values to an array of floats, after checking that all are from low to high."""
    return _within(name, value, unit, (low, high), open_below=False)


def single(
    name: str,
    value: npt.ArrayLike,
    unit: str,
    check: Callable[[str, npt.ArrayLike, str], Array] = positive,
) -> float:
    """Convert a value to a float, after checking that it is one number, and positive by default."""
    array = check(name, value, unit)
    if array.ndim:
        raise _no_number(name, value, unit)
    return float(array)


def _no_number(name: str, value: object, unit: str) -> UserError:
    return UserError(
        "{name} is {value}, expected a number of {unit}", name=name, value=repr(value), unit=unit
    )


def _within(
    name: str,
    value: npt.ArrayLike,
    unit: str,
    bounds: tuple[float, float],
    *,
    open_below: bool,
) -> Array:
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise _no_number(name, value, unit) from None
    low, high = bounds
    good = np.isfinite(array) & (array <= high) & ((array > low) if open_below else (array >= low))
    if not np.all(good):
        bad = array[~good].flat[0] if array.ndim else float(array)
        lower = f"above {low:g}" if open_below else Message("{low:g} or more", low=low)
        upper = Message(", at most {high:g}", high=high) if np.isfinite(high) else ""
        raise UserError(
            "{name} is {bad:g} {unit}, expected a finite value {lower}{upper} {unit}",
            name=name,
            bad=bad,
            unit=unit,
            lower=lower,
            upper=upper,
        )
    return array
