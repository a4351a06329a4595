"""A kind of text for the campaign, and one text of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A text, and how to use it.

    Parameters
    ----------
    name : str
        The file's name.
    content : bytes
    use : callable
        Reads and uses the text; returns whether it was accepted, as opposed to rejected with an
        error message.
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
        Title on the documentation page.
    prepared : callable
        Given an empty folder, returns a function that draws a case from random numbers. Data
        shared by all texts, such as a complete data set, are made once.
    """

    title: str
    prepared: Callable[[Path], Callable[[Random], Case]]
