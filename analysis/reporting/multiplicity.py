"""List every test in the report, with families, corrections and numbers of significant tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.json_form import Unchanged, renamed
from slipscale.analysis.statistics.holm import holm
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

if TYPE_CHECKING:
    from slipscale.analysis.statistics.statistic import Inference
    from slipscale.experiments.study.analysis_choices import Primary


@dataclass(frozen=True, slots=True, kw_only=True)
class FamilyOfTests:
    """A family of tests and its number of significant tests.

    Parameters
    ----------
    name : str
        Hypothesis and method.
    primary : bool
        Whether the family belongs to the study's primary analysis.
    corrected : bool
        Whether Holm's correction is applied within the family. False for a family of one test.
    tests : int
        Number of tests with a result.
    below : int
        Number of significant tests; Holm-corrected within the family if ``corrected``.
    below_over_all : int
        Number of significant tests after Holm's correction across all families.
    """

    name: str
    primary: bool
    corrected: bool
    tests: int
    below: int
    below_over_all: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Multiplicity:
    """Counts of tests and of significant tests in the report.

    Parameters
    ----------
    families : tuple of FamilyOfTests
        Families with a result.
    tests : int
        Total number of tests.
    level : float
        Significance level, 1 - confidence.
    """

    families: tuple[FamilyOfTests, ...]
    tests: int
    level: float

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, level=Unchanged("level"))


def multiplicity(
    inference: Inference,
    primary: Primary,
    confidence: float,
    quantity: Quantity = PLATE_AMPLITUDE,
) -> Multiplicity:
    """List all families of tests, and count the significant tests in each.

    Parameters
    ----------
    primary : {"ranks", "logarithms"}
        The study's primary analysis.
    confidence : float
        Confidence level of the study; the level of every test is 1 - confidence.
    quantity : Quantity
        Stimulus quantity, inserted into the names of the families.
    """
    level = round(1 - confidence, 12)
    tested = [
        (family, [p for p in family.read(found) if np.isfinite(p)])
        for statistic in inference.declared
        if (found := inference.found(statistic)) is not None
        for family in statistic.families
    ]
    over_all = iter(holm([p for _, ps in tested for p in ps]))
    families = []
    for family, ps in tested:
        within = holm(ps) if family.corrected else ps
        survive = [next(over_all) for _ in ps]
        if ps:
            families.append(
                FamilyOfTests(
                    name=family.name.format(q=quantity),
                    primary=family.primary == primary,
                    corrected=family.corrected and len(ps) > 1,
                    tests=len(ps),
                    below=sum(p < level for p in within),
                    below_over_all=sum(p < level for p in survive),
                )
            )
    return Multiplicity(
        families=tuple(families), tests=sum(len(ps) for _, ps in tested), level=level
    )
