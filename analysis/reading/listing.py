"""Words that sentences share."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

#: Where a list of participants is cut.
LISTED = 6


def listed(names: Iterable[str], most: int = LISTED) -> str:
    """Return names for a sentence, cut where they are many.

    >>> listed("abcdefgh")
    'a, b, c, d, e, f and 2 more'
    """
    everyone = list(names)
    more = len(everyone) - most
    return ", ".join(everyone[:most]) + (f" and {more} more" if more > 0 else "")
