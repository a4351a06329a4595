"""What an analysis does otherwise than its frozen plan: `analysis.preregistration` finds it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal[
    "bundle",
    "study",
    "data",
    "participants",
    "dates",
    "exclusions",
    "normalisation",
    "tests",
    "options",
    "versions",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Deviation:
    """One thing that is otherwise than planned.

    Parameters
    ----------
    kind : str
        What it concerns.
    what : str
        One sentence: what was planned, and what is there.
    """

    kind: Kind
    what: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanCheck:
    """An analysis beside its plan.

    Parameters
    ----------
    plan : str
        The bundle's name.
    frozen_utc : str
        When it was frozen, as it says.
    digest : str
        SHA-256 of the plan, which its page prints.
    deviations : tuple of Deviation
        None: the analysis is the planned one.
    """

    plan: str
    frozen_utc: str
    digest: str
    deviations: tuple[Deviation, ...]
