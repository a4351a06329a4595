"""What stands in place of a result that the data do not allow."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class NotComputed:
    """No result, and why.

    Parameters
    ----------
    reason : str
        Part of a sentence, without a full stop.
    """

    reason: str
