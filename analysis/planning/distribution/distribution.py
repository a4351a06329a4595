"""Summarise simulated studies: the spread of each result, and how often conclusions hold."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.planning.distribution.names import CONCLUSIONS, HEADLINES, said
from slipscale.analysis.planning.distribution.numbers import TABLE3, ResultName, cell_name
from slipscale.analysis.planning.power.outcome import Share

if TYPE_CHECKING:
    from slipscale.analysis.planning.distribution.many_studies import ManyStudies, StudyResult
    from slipscale.stimuli.quantity import Quantity

PERCENTILES = (5, 50, 95)


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Distribution of a numeric result across simulated studies.

    Parameters
    ----------
    name : ResultName
        See `slipscale.analysis.planning.distribution.numbers.Findings`.
    studies : int
        Number of studies that produced the result.
    p5, median, p95 : float
    """

    name: ResultName
    studies: int
    p5: float
    median: float
    p95: float

    @property
    def varies(self) -> bool:
        """Whether the 5th and 95th percentiles differ."""
        return self.p5 < self.p95


@dataclass(frozen=True, slots=True, kw_only=True)
class Conclusion:
    """A conclusion, and the proportion of studies in which it holds.

    Parameters
    ----------
    name : ResultName
        See `slipscale.analysis.planning.distribution.numbers.Findings`.
    words : str
    share : Share
        Proportion of studies in which the conclusion holds. A study that could not be analysed
        counts as a study in which the conclusion does not hold.
    """

    name: ResultName
    words: str
    share: Share


@dataclass(frozen=True, slots=True, kw_only=True)
class Distribution:
    """Distribution of all results across simulated studies.

    Parameters
    ----------
    study, title : str
        Name and title of the study.
    quantity : Quantity
        Quantity and unit of the levels.
    participants : int
        Participants per study.
    population : str
        The simulated population.
    seed : int
        Seed from which the seeds of all studies are derived.
    normalisation : str
        Normalisation rule; empty if the study sets none.
    sessions : str
        Reason why full sessions were simulated; empty for the fast simulation.
    results : tuple of StudyResult
        One per study.
    numbers : tuple of Spread
    conclusions : tuple of Conclusion
    """

    study: str
    title: str
    quantity: Quantity
    participants: int
    population: str
    seed: int
    normalisation: str
    sessions: str
    results: tuple[StudyResult, ...]
    numbers: tuple[Spread, ...]
    conclusions: tuple[Conclusion, ...]

    @property
    def refused(self) -> Mapping[str, int]:
        """Number of studies that could not be analysed, keyed by reason."""
        return Counter(each.refused for each in self.results if each.refused)

    @property
    def by_name(self) -> dict[ResultName, Spread]:
        """The numeric results, keyed by name."""
        return {spread.name: spread for spread in self.numbers}

    @property
    def levels(self) -> list[float]:
        """Amplitudes in Table III, ascending; empty if there are no magnitude estimates."""
        names = (spread.name.at((TABLE3, "*", "mean")) for spread in self.numbers)
        return sorted(float(str(name[0])) for name in names if name)

    @property
    def headlines(self) -> list[tuple[Spread, str]]:
        """The most important results, with descriptions."""
        known = [(said(spread.name, HEADLINES, self.quantity), spread) for spread in self.numbers]
        known.sort(key=lambda each: each[0][0])
        return [
            (spread, words)
            for (place, words), spread in known
            if place < len(HEADLINES) and spread.varies
        ]

    def cell(self, level: float, statistic: str) -> Spread | None:
        """Return the distribution of one Table III cell, or None if no study has a value."""
        return self.by_name.get(cell_name(level, statistic))

    def values(self, name: ResultName) -> list[float]:
        """Return the value of a numeric result from each study that has one."""
        found = [each.found.numbers.get(name) for each in self.results]
        return [value for value in found if value is not None]


def distribution(studies: ManyStudies, found: Sequence[StudyResult]) -> Distribution:
    """Compute how the results are distributed across simulated studies."""
    plan = studies.plans[0]
    numbers = dict.fromkeys(name for each in found for name in each.found.numbers)
    conclusions = dict.fromkeys(name for each in found for name in each.found.conclusions)
    concluded = [
        (
            said(name, CONCLUSIONS, plan.study.quantity),
            name,
            sum(each.found.conclusions.get(name, False) for each in found),
        )
        for name in conclusions
    ]
    concluded.sort(key=lambda each: each[0][0])
    return Distribution(
        study=plan.study.name,
        title=plan.study.title,
        quantity=plan.study.quantity,
        participants=studies.people,
        population=studies.population.name,
        seed=plan.seed,
        normalisation=plan.study.analysis.normalisation or "",
        sessions=studies.why_sessions,
        results=tuple(found),
        numbers=tuple(_spread(name, found) for name in numbers),
        conclusions=tuple(
            Conclusion(name=name, words=words, share=Share.of(count, len(found)))
            for (_, words), name, count in concluded
        ),
    )


def _spread(name: ResultName, found: Sequence[StudyResult]) -> Spread:
    values = [each.found.numbers[name] for each in found if name in each.found.numbers]
    p5, median, p95 = np.percentile(values, PERCENTILES).tolist()
    return Spread(name=name, studies=len(values), p5=p5, median=median, p95=p95)
