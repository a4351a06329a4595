"""Represent a result that could not be computed, so that code can handle "a result or a reason".

A reason is falsy and a result is truthy, so code that needs only the result uses ``if result:``.
Code that also needs the reason uses `fold` or ``isinstance``. Use `computed` for results that can
be falsy themselves, such as a number or an empty tuple.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

T = TypeVar("T")
S = TypeVar("S")


@dataclass(frozen=True, slots=True)
class NotComputed:
    """A missing result and the reason why it is missing.

    Parameters
    ----------
    reason : str
        Part of a sentence, without a full stop.
    """

    reason: str

    def __bool__(self) -> Literal[False]:
        """Return False, so that a missing result is falsy."""
        return False


def computed(result: T | NotComputed) -> T | None:
    """Return a result; None if there is none."""
    return None if isinstance(result, NotComputed) else result


def all_computed(results: Iterable[T | NotComputed]) -> list[T]:
    """Return the results that were computed."""
    return [each for each in results if not isinstance(each, NotComputed)]


def missing(results: Iterable[object]) -> list[NotComputed]:
    """Return the missing results, with their reasons."""
    return [each for each in results if isinstance(each, NotComputed)]


def fold(result: T | NotComputed, read: Callable[[T], S], otherwise: Callable[[str], S]) -> S:
    """Apply ``read`` to a result, or ``otherwise`` to the reason why there is none."""
    return otherwise(result.reason) if isinstance(result, NotComputed) else read(result)
