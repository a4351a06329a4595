"""Compute which conclusions follow from a published table, per column and across columns.

The module `report` formats the results as text and JSON.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from slipscale.analysis.published.printed_numbers import RULES, Interval
from slipscale.analysis.reconstruction.data_sets.marginals import Marginals, marginals
from slipscale.analysis.reconstruction.table.published_table import CONVENTIONS, Design, Scale
from slipscale.analysis.reconstruction.table.words import assumptions, in_words

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.partition import Wanted
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
    from slipscale.analysis.reconstruction.inference.conclusions import Conclusion
    from slipscale.analysis.reconstruction.inference.distributions import Distribution

# Exact distributions are computed only if the state tables, counted once per goal, have at most
# this number of cells.
MARGINAL_CELLS = 5_000_000
# Ordered samples are counted without a request only if this takes at most this number of additions.
ORDERED_ADDITIONS = 6_000_000_000
# They are also not counted without a request if they have more than this number of parts.
ORDERED_PARTS = 10_000
# Maximum number of pairs of sum and sum of squares to list if the data sets were not counted.
SHOWN_SUMS = 100


@dataclass(frozen=True, kw_only=True)
class OrderStatistic:
    """Exact minimum, maximum and mean of one order statistic over all data sets."""

    rank: int
    minimum: float
    maximum: float
    mean: float


@dataclass(frozen=True, kw_only=True)
class Variant:
    """Number of data sets under one SD convention and one rounding rule.

    `multisets` is None if the data sets were not counted; `reason` states why.
    """

    sd_convention: str
    rounding: str
    multisets: int | None
    reason: str


@dataclass(frozen=True, kw_only=True)
class ColumnAnswer:
    """All results for one column of the table.

    Parameters
    ----------
    label, sd_convention, rounding : str
        Label, SD convention and rounding rule of the column.
    printed : str
        All numbers printed for the column, as text.
    reason : str
        Reason why no data set is consistent with the column, or an empty string.
    multisets : int or None
        Number of data sets, ignoring the order of participants, or None if the data sets were not
        counted.
    ordered : int or None
        Number of data sets, counting different orders of participants separately, or None if
        counting takes too long.
    grim, grimmer : bool
        Whether the mean passes GRIM and the SD passes GRIMMER.
    sums : tuple of (Fraction, Fraction)
        Sums and sums of squares that match the published numbers, in the unit of the scale.
    order_statistics : tuple of OrderStatistic
        Order statistics of the ratings; empty if no data set exists or the computation takes too
        long.
    variants : tuple of Variant
        Counts under all SD conventions and rounding rules, if these were requested.
    scale_is_printed : bool
        Whether the table states at least one end of the scale.
    assumptions : tuple of str
        Descriptions of the assumptions about the column.
    refused : str
        Reason why the data sets were not counted, or an empty string.
    not_drawn : str
        Reason why the data sets were counted but cannot be sampled, or an empty string.
    witness : tuple of float
        A verified data set; empty if the data sets were counted or the search found none.
    log10_estimate : float or None
        Approximate log10 of the number of data sets (saddle-point method), if the data sets were
        not counted.
    """

    label: str
    sd_convention: str
    rounding: str
    printed: str
    reason: str
    multisets: int | None
    ordered: int | None
    grim: bool
    grimmer: bool
    sums: tuple[tuple[Fraction, Fraction], ...]
    order_statistics: tuple[OrderStatistic, ...] = ()
    variants: tuple[Variant, ...] = ()
    scale_is_printed: bool = True
    assumptions: tuple[str, ...] = ()
    refused: str = ""
    not_drawn: str = ""
    witness: tuple[float, ...] = ()
    log10_estimate: float | None = None

    @property
    def consistent(self) -> bool | None:
        """Whether any data set is consistent with the column, or None if this is unknown."""
        if self.multisets is None:
            return True if self.witness else None
        return self.multisets > 0


@dataclass(frozen=True, kw_only=True)
class Across:
    """All results that compare columns.

    Parameters
    ----------
    bounds : tuple of Conclusion
        Conclusions that cover all data sets and pairings. If there are too many data sets to list,
        only sums and sums of squares are used for the bounds.
    not_listed : tuple of str
        Labels of the columns whose data sets cannot all be listed.
    distributions : tuple of Distribution
        Distributions of test statistics, estimated from uniform samples.
    """

    bounds: tuple[Conclusion, ...]
    not_listed: tuple[str, ...]
    distributions: tuple[Distribution, ...]


def column_answer(solutions: Solutions, measure: str, *, variants: bool = False) -> ColumnAnswer:
    """Return the results for a column.

    If `variants` is true, the results include the counts under every SD convention and rounding
    rule.
    """
    counted = all_variants(solutions) if variants else ()
    if solutions.refused:
        return _uncounted(solutions, counted)
    column, found = solutions.column, solutions.targets
    worth = solutions.consistent and worth_marginals(solutions, measure)
    return ColumnAnswer(
        label=column.label,
        sd_convention=column.sd_convention,
        rounding=column.rounding,
        printed=in_words(column),
        reason=solutions.reason,
        multisets=solutions.multisets,
        ordered=solutions.ordered if worth_ordering(solutions, measure) else None,
        grim=found.grim,
        grimmer=found.grimmer,
        scale_is_printed=column.scale_is_printed,
        assumptions=tuple(assumptions(column)),
        sums=moments(solutions),
        order_statistics=(
            order_statistics(marginals(solutions, measure), column.scale) if worth else ()
        ),
        variants=counted,
        not_drawn=_not_drawn(solutions, measure) if solutions.consistent else "",
    )


def _uncounted(solutions: Solutions, variants: tuple[Variant, ...]) -> ColumnAnswer:
    from slipscale.analysis.reconstruction.data_sets.saddle_point import log10_multisets

    column, found = solutions.column, solutions.targets
    return ColumnAnswer(
        label=column.label,
        sd_convention=column.sd_convention,
        rounding=column.rounding,
        printed=in_words(column),
        reason="",
        multisets=None,
        ordered=None,
        grim=found.grim,
        grimmer=found.grimmer,
        scale_is_printed=column.scale_is_printed,
        assumptions=tuple(assumptions(column)),
        sums=moments(solutions) if len(found.wanted) <= SHOWN_SUMS else (),
        variants=variants,
        refused=solutions.refused,
        witness=tuple(float(column.scale.value(v)) for v in solutions.witness),
        log10_estimate=log10_multisets(found),
    )


def _not_drawn(solutions: Solutions, measure: str) -> str:
    return solutions.not_ordered if measure == "ordered" else solutions.not_drawn


def worth_marginals(solutions: Solutions, measure: str = "multisets") -> bool:
    """Return whether exact distributions of ratings can be computed quickly."""
    if _not_drawn(solutions, measure) or solutions.listed_apart:
        return False
    tasks = solutions.ordered_problems if measure == "ordered" else solutions.problems
    cells = sum((task.bytes // 8) * len(task.goals) for task in tasks)
    return cells <= MARGINAL_CELLS


def worth_ordering(solutions: Solutions, measure: str) -> bool:
    """Return whether to count ordered samples, which is done on request or if it is quick."""
    if _not_drawn(solutions, measure):
        return False
    if solutions.listed_apart or measure == "ordered":
        return True
    n, values = solutions.column.n, solutions.column.scale.steps + 1
    if solutions.ordered_parts > ORDERED_PARTS:
        return False
    cells = sum(task.bytes // 8 for task in solutions.ordered_problems)
    return cells * n * values <= ORDERED_ADDITIONS


def moments(solutions: Solutions) -> tuple[tuple[Fraction, Fraction], ...]:
    """Return the sums and sums of squares that match the published numbers, in the scale's unit."""
    low, step = solutions.column.scale.minimum, solutions.column.scale.step
    return tuple(
        (
            m.n * low + step * m.total,
            m.n * low**2 + 2 * low * step * m.total + step**2 * m.squares,
        )
        for m in solutions.targets.moments
    )


def order_statistics(found: Marginals, scale: Scale) -> tuple[OrderStatistic, ...]:
    """Return the sharp bounds and the mean of each order statistic over all data sets."""
    rows = []
    for rank in range(1, found.n + 1):
        chances = found.order_statistic(rank)
        mean = sum(p * scale.value(v) for v, p in chances.items())
        rows.append(
            OrderStatistic(
                rank=rank,
                minimum=float(scale.value(min(chances))),
                maximum=float(scale.value(max(chances))),
                mean=float(mean),
            )
        )
    return tuple(rows)


def all_variants(solutions: Solutions) -> tuple[Variant, ...]:
    """Count the data sets under every combination of SD convention and rounding rule."""
    rows = []
    known: dict[tuple[tuple[Wanted, ...], tuple[Interval, ...]], tuple[int | None, str]] = {}
    for convention in CONVENTIONS:
        for rule in RULES:
            other = solutions.under(convention, rule)
            # Rounding rules that admit the same sums, extremes, medians, frequencies and quartiles
            # admit the same data sets.
            quartiles = (other.column.lower_quartile, other.column.upper_quartile)
            key = other.targets.wanted, tuple(q.values(rule) for q in quartiles if q)
            if key not in known or not other.targets.wanted:
                known[key] = (
                    (None, other.refused) if other.refused else (other.multisets, other.reason)
                )
            count, reason = known[key]
            rows.append(
                Variant(sd_convention=convention, rounding=rule, multisets=count, reason=reason)
            )
    return tuple(rows)


def across(
    columns: Sequence[Solutions],
    design: Design,
    measure: str,
    seed: int,
    tell: Callable[[str], None] = lambda _: None,
) -> Across:
    """Compare columns; return bounds and, if all columns can be sampled, distributions.

    The function `tell` is called with a description of the current step.

    Raises
    ------
    UserError
        If the columns cannot be compared.
    """
    if design == "independent":
        from slipscale.analysis.reconstruction.inference.independent import independent_conclusions

        return Across(
            bounds=tuple(independent_conclusions(columns)), not_listed=(), distributions=()
        )
    from slipscale.analysis.reconstruction.counts.listing import LISTED
    from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
    from slipscale.analysis.reconstruction.inference.conclusions import conclusions, of_moments
    from slipscale.analysis.reconstruction.inference.distributions import distributions

    long = tuple(s.column.label for s in columns if s.not_drawn or s.multisets > LISTED)
    drawable = not any(_not_drawn(s, measure) for s in columns)
    samplers = [Sampler(solutions, measure) for solutions in columns] if drawable else []
    bounds = of_moments(columns) if long else conclusions(samplers, tell)
    tell("distributions over uniform samples")
    drawn = distributions(samplers, seed) if drawable else []
    return Across(bounds=tuple(bounds), not_listed=long, distributions=tuple(drawn))


def seconds_across(columns: Sequence[Solutions], design: Design) -> float:
    """Estimate the run time of `across` in seconds, for progress messages."""
    from slipscale.analysis.reconstruction.counts.listing import LISTED
    from slipscale.analysis.reconstruction.inference.conclusions import seconds_to_conclude

    if design == "independent" or any(s.not_drawn or s.multisets > LISTED for s in columns):
        return 0.0
    return seconds_to_conclude([s.multisets for s in columns])
