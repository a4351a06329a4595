"""A kind of text that the campaign tries, and one such text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path
    from random import Random


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A text, and what is done with it.

    Parameters
    ----------
    name : str
        The file's.
    content : bytes
    use : callable
        Reads and uses it; returns whether it was taken, and not refused in a sentence.
    """

    name: str
    content: bytes
    use: Callable[[], bool]


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """A kind of text.

    Parameters
    ----------
    title : str
        In the page's words.
    prepared : callable
        Given an empty folder, returns what draws a case from random numbers. What all texts
        share, such as a whole data set, is made once.
    """

    title: str
    prepared: Callable[[Path], Callable[[Random], Case]]
