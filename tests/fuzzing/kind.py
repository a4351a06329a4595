"""Define kinds of input for the fuzzing campaign."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """Input file, and a function that uses it.

    Parameters
    ----------
    name : str
        The file's name.
    content : bytes
    use : callable
        Reads and uses the file; returns True if the file was accepted, and False if it was rejected
        with an error message.
    """

    name: str
    content: bytes
    use: Callable[[], bool]


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """Kind of input file.

    Parameters
    ----------
    title : str
        Title on the documentation page.
    prepared : callable
        Takes an empty folder, in which it creates files that all cases share, such as a data set,
        and returns a function that creates a random case.
    """

    title: str
    prepared: Callable[[Path], Callable[[Random], Case]]
