"""Represent a result that could not be computed, and the reason for this.

`NotComputed` is falsy, so ``if result:`` is enough for code that needs only the result. If the
reason is also needed, call `fold` or check the type with ``isinstance``. Use `computed` for results
that can themselves be falsy, such as a number or an empty tuple.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal, TypeVar

T = TypeVar("T")
S = TypeVar("S")


@dataclass(frozen=True, slots=True)
class NotComputed:
    """A result that is missing, with the reason.

    Parameters
    ----------
    reason : str
        Reason for the missing result, written as a clause without a full stop.
    """

    reason: str

    def __bool__(self) -> Literal[False]:
        """Return False, so that a missing result is falsy."""
        return False


def computed(result: T | NotComputed) -> T | None:
    """Return the result, or None if it was not computed."""
    return None if isinstance(result, NotComputed) else result


def all_computed(results: Iterable[T | NotComputed]) -> list[T]:
    """Return only the results that were computed."""
    return [each for each in results if not isinstance(each, NotComputed)]


def missing(results: Iterable[object]) -> list[NotComputed]:
    """Return the missing results, which contain the reasons."""
    return [each for each in results if isinstance(each, NotComputed)]


def fold(result: T | NotComputed, read: Callable[[T], S], otherwise: Callable[[str], S]) -> S:
    """Return ``read(result)``, or ``otherwise(reason)`` if the result was not computed."""
    return otherwise(result.reason) if isinstance(result, NotComputed) else read(result)
