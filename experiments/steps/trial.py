"""Trial to which a step belongs, with the levels of its factors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Phase = Literal["practice", "main"]
Value = str | float | bool | None


def factor_level(value: Value) -> str:
    """Format a factor level as text that can be used in keys.

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
        Label of the task in the data set, such as "magnitudeestimation" (only letters and digits).
    number : int
        Number of the trial in the order of presentation within the task, from 1. A repeated trial
        gets a new number.
    total : int
        Expected number of trials in the task, including practice.
    phase : {"practice", "main"}
        Practice trials are recorded but not analysed.
    factors : Mapping
        Values of the protocol's columns in the data set, such as "block" or "series".
    repeats : int or None
        Number of the voided trial that this trial repeats.
    """

    task: str
    number: int
    total: int
    phase: Phase = "main"
    factors: Mapping[str, Value] = field(default_factory=dict)
    repeats: int | None = None
