"""Compare ratings between the levels of experimental factors.

A participant's rating at a level of a factor is the mean across the other factors and across the
surfaces that the participant rated at every level. Levels are compared by Friedman's test and, in
pairs, by signed-rank tests. All other analyses treat each condition as a separate task
(`slipscale.analysis.reading.task_tables`). Ordered categories are not fitted by a cumulative model,
because statsmodels supports no such model with random effects, and intervals without random effects
are too narrow. Interactions between factor and surface are not tested.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import pandas as pd

from slipscale.analysis.reading.surface_labels import numbers_first
from slipscale.analysis.reading.task_tables import BEFORE_CONDITION
from slipscale.analysis.reading.trial_tables import FACTOR
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.repeated_measures.omnibus import Friedman, friedman_of
from slipscale.analysis.statistics.repeated_measures.pairwise import TIED_DECIMALS
from slipscale.analysis.statistics.statistic import Family, Inputs, Named, Statistic
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.tasks.ratings.pairs import RatedPair, corrected, pairs_of
from slipscale.analysis.tasks.ratings.statistics import TRIALS, ends_of
from slipscale.analysis.writing import html
from slipscale.analysis.writing.factor_words import factor_level, factor_name
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import (
    DASH,
    bracketed,
    cell,
    level_of,
    number,
    p_value,
    unit_number,
)
from slipscale.analysis.writing.task_names import task_name
from slipscale.analysis.writing.verdicts import DIFFERED, verdict
from slipscale.experiments.dataset.schema import PARTICIPANT

TITLE = "Ratings by condition"


@dataclass(frozen=True, slots=True, kw_only=True)
class FactorRatings:
    """Comparison of ratings between the levels of one factor.

    Parameters
    ----------
    task, factor : str
    friedman : Friedman or NotComputed
        Test of all levels; not computed for two levels.
    pairs : tuple of RatedPair
        Pairwise comparisons of levels, Holm-corrected across all factors and tasks.
        ``from_surface`` and ``to_surface`` contain levels of the factor.
    """

    task: str
    factor: str
    friedman: Friedman | NotComputed
    pairs: tuple[RatedPair, ...]


def rating_conditions(
    trials: pd.DataFrame, confidence: float = 0.95
) -> tuple[FactorRatings, ...] | NotComputed:
    """Return a comparison for each task and factor."""
    named = [str(name) for name in trials.columns if str(name).startswith(FACTOR)]
    main = trials[~trials["catch"].astype(bool)] if len(trials) else trials
    found = [
        _compared(str(task), name, rows, confidence)
        for task, rows in (main.groupby(BEFORE_CONDITION) if named else ())
        for name in named
        if len(rows[name].unique()) > 1
    ]
    if not found:
        return NotComputed("no ratings in several conditions")
    pairs = corrected(each.pairs for each in found)
    return tuple(replace(each, pairs=own) for each, own in zip(found, pairs, strict=True))


def _compared(task: str, name: str, rows: pd.DataFrame, confidence: float) -> FactorRatings:
    cells = rows.assign(level=rows[name].astype(str)).pivot_table(
        index=[PARTICIPANT, "surface"], columns="level", values="rating", observed=True
    )
    # Means are rounded, because equal means can differ in the last bits and would not be tied.
    table = cells.dropna().groupby(PARTICIPANT, observed=True).mean().round(TIED_DECIMALS)
    table = table[sorted(table.columns, key=numbers_first)]
    people = rows[PARTICIPANT].nunique()
    low, high = ends_of(rows)
    return FactorRatings(
        task=task,
        factor=name.removeprefix(FACTOR),
        friedman=friedman_of(table, people - len(table)),
        pairs=pairs_of(table, confidence, high - low),
    )


def sentences(analysis: Analysis) -> list[str]:
    """Return a sentence for each task and factor."""
    confidence = analysis.dataset.choices.confidence
    return [
        f"{task_name('Ratings', each.task)}, {factor_name(each.factor)}: {'; '.join(parts)}."
        for each in analysis.inference[CONDITIONS] or ()
        if (parts := list(_parts(each, confidence)))
    ]


def _parts(found: FactorRatings, confidence: float) -> Iterator[str]:
    test = found.friedman
    if test:
        verb = verdict(DIFFERED, test.p, confidence, test.n - 1)
        yield (
            f"mean ratings {verb} between levels (Friedman's test, χ²({test.df}, n = {test.n}) = "
            f"{number(test.chi2)}, {p_value(test.p)}, Kendall's W = {unit_number(test.kendalls_w)})"
        )
    for pair in found.pairs:
        change = pair.difference
        if change:
            yield (
                f"{factor_level(found.factor, pair.to_surface)} minus "
                f"{factor_level(found.factor, pair.from_surface)}: {number(change.mean)}, "
                f"{level_of(confidence)} CI {bracketed(change.interval, number)}, "
                f"{p_value(pair.p_wilcoxon_holm)} (Wilcoxon's test, Holm, n = {pair.participants})"
            )


def section(analysis: Analysis) -> ReportSection:
    """Return the section with a table of all comparisons; it is empty without factors."""
    written = ReportSection(TITLE)
    rows = [
        [
            task_name("Ratings", each.task),
            factor_name(each.factor),
            factor_level(each.factor, pair.from_surface),
            factor_level(each.factor, pair.to_surface),
            str(pair.participants),
            cell(pair.difference, lambda mean: number(mean.mean)),
            cell(pair.difference, lambda mean: bracketed(mean.interval, number)),
            p_value(pair.p_wilcoxon_holm) if pair.difference else DASH,
        ]
        for each in analysis.inference[CONDITIONS] or ()
        for pair in each.pairs
    ]
    if rows:
        head = ("Task", "Factor", "From", "To", "n", "Difference", "CI", "p (Wilcoxon, Holm)")
        note = (
            "Differences between participants' mean ratings of the surfaces rated at every level "
            "of the factor, with t-based intervals and signed-rank tests, Holm-corrected across "
            "all rows."
        )
        written.blocks.append(html.table(html.columns(*head, left=4), rows, note))
    return written


class _Conditions(Statistic[tuple[FactorRatings, ...]]):
    key = "rating_conditions"
    meaning = "ratings compared between the levels of factors: Friedman's and pairwise tests"
    families = (
        Family(
            name="ratings by factor, Friedman's test",
            read=lambda tasks: [each.friedman.p for each in tasks if each.friedman],
        ),
        Family(
            name="ratings by factor, Wilcoxon's test",
            corrected=True,
            read=lambda tasks: [pair.p_wilcoxon for each in tasks for pair in each.pairs],
        ),
    )
    methods = (
        "For each factor, participants' mean ratings of the surfaces that they rated at every "
        "level were compared by Friedman's test and, in pairs of levels, by Wilcoxon signed-rank "
        "tests with Holm's correction across all of these pairs."
    )
    conclusions = (
        Named("*.friedman.p", "{0}: ratings differ between conditions (Friedman's test)"),
        Named("*.pairs.*.p_wilcoxon_holm", "{0}: {1[0]} and {1[1]} differ (Wilcoxon's test, Holm)"),
    )

    def compute(self, inputs: Inputs) -> tuple[FactorRatings, ...] | NotComputed:
        return rating_conditions(inputs.data.of(TRIALS), inputs.data.choices.confidence)


CONDITIONS = _Conditions()
