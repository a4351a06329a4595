"""Warn about biases that simulations found in population thresholds.

In the table of `benchmarks.population_thresholds` (docs/validation/measured/statistics.md), every
coverage of a 95 % interval below .93 or above .97 is explained by a bias in `CAUTIONS`. Biases of
just noticeable differences come from 120 simulated data sets per case, as in the tests of
`friction_axis`: 6 people who never lapse, with 20 comparisons at each of 5 levels.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from slipscale.analysis.tasks.thresholds.statistics import COMPARED, TaskThresholds
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES


class Caution(NamedTuple):
    """A known bias, and the tasks that it affects.

    Parameters
    ----------
    text : str
        Sentence without a final full stop, in which ``{covered}`` is replaced with the coverage.
    applies : callable
        Function that returns whether the bias affects a task.
    observers : tuple of str
        Rows of the benchmark table that show the effect of this bias on coverage.
    coverage : tuple of (int, float)
        Pairs of the number of people and the coverage of 95 % intervals. Empty if the coverage is
        between .93 and .97.
    """

    text: str
    applies: Callable[[TaskThresholds], bool]
    observers: tuple[str, ...] = ()
    coverage: tuple[tuple[int, float], ...] = ()

    def __str__(self) -> str:
        """Return the sentence."""
        parts = [f"{share:.0%} of studies with {people} people" for people, share in self.coverage]
        return f"{self.text.format(covered=' and '.join(parts).replace('%', ' %'))}."


def _without_catches(task: TaskThresholds) -> bool:
    return not any(each.catch_trials for each in task.participants)


CAUTIONS = (
    Caution(
        "If sensation does not grow evenly across the comparison levels, the point of subjective "
        "equality is shifted (by 2 % of the standard in simulations); 95 % intervals then contain "
        "the true value in only {covered}",
        lambda task: task.method == COMPARED,
        ("equality: normal of the logarithm, fitted with normal",),
        ((12, 0.9), (24, 0.83)),
    ),
    Caution(
        "If psychometric curves depend on the level rather than its logarithm, the threshold is "
        "too low (by 6 % in simulations, and by 3 to 6 % if d' is proportional to the level); 95 % "
        "intervals then contain the true value in only {covered}",
        lambda task: task.method != COMPARED and CURVES[task.curve].logarithmic,
        ("threshold: Gumbel, fitted with Weibull",),
        ((12, 0.89), (24, 0.84)),
    ),
    Caution(
        "If people lapse in 5 % of trials, intervals from few people are wider than necessary: in "
        "simulations, 95 % intervals contain the true value in {covered}",
        lambda task: task.method != COMPARED,
        ("threshold: d' in proportion to the level, fitted with Weibull",),
        ((6, 0.97),),
    ),
    Caution(
        "Without catch trials, the lapse rate of people who never lapse is overestimated on "
        "average, and their threshold is too low (by 1 to 3 % in simulations)",
        lambda task: task.method != COMPARED and _without_catches(task),
    ),
    Caution(
        "Without catch trials, the lapse rate of people who never lapse is overestimated on "
        "average, and their just noticeable difference is too small (by 6 % in simulations with 6 "
        "people and 100 answers each; by 11 % if it is a difference in friction, measured with "
        "error). With 20 catch trials per person, the estimate is unbiased",
        lambda task: task.method == COMPARED and _without_catches(task),
    ),
)
