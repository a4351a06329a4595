"""Represent deviations from a frozen analysis plan; see `analysis.preregistration`."""

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
    """One deviation from the plan.

    Parameters
    ----------
    kind : str
        What the deviation concerns.
    what : str
        One sentence: what was planned, and what was done.
    """

    kind: Kind
    what: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanCheck:
    """An analysis compared with its plan.

    Parameters
    ----------
    plan : str
        Name of the bundle.
    frozen_utc : str
        Time at which the plan was frozen, according to the plan.
    digest : str
        SHA-256 of the plan, as printed on its page.
    deviations : tuple of Deviation
        Deviations; empty if the analysis follows the plan.
    """

    plan: str
    frozen_utc: str
    digest: str
    deviations: tuple[Deviation, ...]
