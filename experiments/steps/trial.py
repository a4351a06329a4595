"""The trial to which a step belongs, and the trial's factors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Phase = Literal["practice", "main"]
Value = str | float | bool | None


def factor_level(value: Value) -> str:
    """Return the text of a factor level that is used in keys.

    >>> factor_level(50.0), factor_level("left")
    ('50', 'left')
    """
    return f"{value:g}" if isinstance(value, float) else str(value)


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """The trial to which a step belongs.

    Parameters
    ----------
    task : str
        The data set's task label, letters and digits only ("magnitudeestimation").
    number : int
        1, 2, ... in order of presentation within the task; a repeated trial gets a new number.
    total : int
        Expected number of trials in the task, including practice.
    phase : {"practice", "main"}
        Practice trials are recorded but not analysed.
    factors : Mapping
        The protocol's own columns of the data set ("block", "series", ...).
    repeats : int or None
        Number of the voided trial that this trial repeats.
    """

    task: str
    number: int
    total: int
    phase: Phase = "main"
    factors: Mapping[str, Value] = field(default_factory=dict)
    repeats: int | None = None
