"""Normalise estimates to a common scale, using named rules.

The paper states only that estimates "were multiplied in order to bring them to 100" (Section IV-B).
Several rules fit this sentence; docs/how-to/your-data.md compares them.
Every rule except ``modulus_equalisation`` divides by a positive number, so zeros remain zeros and
the exponents of participants' power functions do not change.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

import numpy as np
import pandas as pd

from slipscale.analysis.reading.cells import listed
from slipscale.analysis.reading.trial_tables import factor_columns
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """A normalisation rule.

    Parameters
    ----------
    divisor : callable
        Function that returns each trial's divisor; NaN or 0 if the rule does not apply.
    top : float
        Value to which an estimate equal to the divisor is normalised.
    most : float
        Largest possible mean of a participant.
    formula : str
        Description for the report, in which ``q`` is a placeholder for the quantity.
    needs : str
        Data that the rule requires, for the error message if they are missing.
    unit : str
        Unit of the result for axis labels, in which ``q`` is a placeholder for the quantity.
    """

    divisor: Callable[[pd.DataFrame], pd.Series[float]]
    top: float = 100.0
    most: float = inf
    formula: str
    needs: str = "a positive estimate from each participant"
    unit: str = "% of the scale"

    @property
    def end(self) -> float | None:
        """End of the scale of normalised estimates; None if the scale remains open."""
        return None if self.top == 1 else self.top


def cell_means(trials: pd.DataFrame, column: str | list[str] = "estimate") -> pd.DataFrame:
    """Return each participant's arithmetic mean at each amplitude.

    Returns
    -------
    DataFrame, shape (participants, amplitudes)
        Participants in rows and amplitudes (µm peak to peak) in columns, both sorted; NaN if there
        is no estimate. If ``column`` is a list, the result has one such block of columns per name.
    """
    cells = trials.groupby([PARTICIPANT, "level"], observed=True, sort=True)
    means = cells[column].mean()
    return pd.DataFrame(means.unstack("level"))  # noqa: PD010 - the index already exists


def means_over_conditions(trials: pd.DataFrame, column: str) -> pd.DataFrame:
    """Return each participant's mean of condition means at each amplitude.

    Every condition has the same weight. If a participant lacks a condition in which others judged
    the amplitude, the mean is missing, because it would be that of the other conditions only.
    Factors whose levels nobody judged completely differ between participants, and then only a
    participant's own conditions count.

    Parameters
    ----------
    trials : DataFrame
        Without factor columns, the result is that of `cell_means`.
    """
    names = [name for name in factor_columns(trials) if len(trials[name].unique()) > 1]
    if not names:
        return cell_means(trials, column)
    cells = trials.groupby([PARTICIPANT, "level", *names], observed=True, sort=True)
    means = cells[column].mean().unstack(names)  # noqa: PD010 - the index already exists
    there = means.notna()
    own = there.groupby(PARTICIPANT, observed=True).any()
    wanted = there.groupby("level").transform("any")
    if not own.all(axis=1).any():
        wanted &= there.groupby(PARTICIPANT, observed=True).transform("any")
    found = means.mean(axis=1).mask((wanted & ~there).any(axis=1))
    return pd.DataFrame(found.unstack("level"))  # noqa: PD010 - as above


def items(trials: pd.DataFrame) -> pd.Series[int]:
    """Return the number of each trial's item: its combination of amplitude and condition.

    Trials of the same item are repetitions. Without factors, items are amplitudes.
    """
    return trials.groupby(["level", *factor_columns(trials)], observed=True).ngroup()


def log_cell_means(trials: pd.DataFrame, column: str = "estimate") -> pd.DataFrame:
    """Return each participant's mean natural logarithm at each amplitude, omitting zeros.

    Returns
    -------
    DataFrame, shape (participants, amplitudes)
        See `cell_means`.
    """
    positive = trials[trials[column] > 0]
    return cell_means(positive.assign(log=np.log(positive[column])), "log")


def _spread(trials: pd.DataFrame, per_participant: pd.Series[float]) -> pd.Series[float]:
    """Assign each participant's value to all of their trials."""
    codes = trials[PARTICIPANT].astype("category")
    lookup = per_participant.reindex(codes.cat.categories).to_numpy(float)
    return pd.Series(lookup[codes.cat.codes.to_numpy()], index=trials.index)


def _constant(trials: pd.DataFrame, value: float) -> pd.Series[float]:
    return pd.Series(value, index=trials.index, dtype=float)


def _grand_maximum(trials: pd.DataFrame) -> pd.Series[float]:
    return _constant(trials, float(np.nanmax(cell_means(trials).to_numpy())))


def _participant_maximum(trials: pd.DataFrame) -> pd.Series[float]:
    return _spread(trials, cell_means(trials).max(axis=1))


def _participant_largest_trial(trials: pd.DataFrame) -> pd.Series[float]:
    return _spread(trials, trials.groupby(PARTICIPANT, observed=True)["estimate"].max())


def _top_stimulus(trials: pd.DataFrame) -> pd.Series[float]:
    means = cell_means(trials)
    return _spread(trials, means[means.columns.max()])


def _modulus_equalisation(trials: pd.DataFrame) -> pd.Series[float]:
    logs = log_cell_means(trials).mean(axis=1)
    return _spread(trials, np.exp(logs - logs.mean()))


RULES: dict[str, Rule] = {
    # Free magnitude estimation (Stevens 1975, Psychophysics).
    "none": Rule(
        divisor=lambda trials: _constant(trials, 1.0),
        top=1.0,
        formula="estimates as given",
        unit="as given",
    ),
    # Rescaling to a common scale (ASTM E1697).
    "scale_top": Rule(
        divisor=lambda trials: trials["scale_top"],
        formula="each estimate divided by the declared top of its participant's scale, times 100",
        needs="a declared top of the scale above 0 in every trial (column scale_top)",
        unit="% of the declared top of the scale",
    ),
    # A literal reading of the paper.
    "grand_maximum": Rule(
        divisor=_grand_maximum,
        formula="all estimates are multiplied by one factor, so that the largest participant "
        "mean at any {q.level} becomes 100",
        needs="a positive estimate",
        unit="% of the largest participant mean",
    ),
    # This rule is common in haptics. It forces the spread towards 0 at the top of the scale.
    "participant_maximum": Rule(
        divisor=_participant_maximum,
        formula="each participant's largest mean at any {q.level} becomes 100",
        most=100.0,
        unit="% of the participant's maximum",
    ),
    # This rule is common in haptics. The divisor grows with the number of repetitions.
    "participant_largest_trial": Rule(
        divisor=_participant_largest_trial,
        formula="each participant's largest single estimate becomes 100",
        most=100.0,
        unit="% of the participant's largest estimate",
    ),
    # The strongest stimulus serves as the reference.
    "top_stimulus": Rule(
        divisor=_top_stimulus,
        formula="each participant's mean at the largest {q.level} becomes 100",
        needs="a positive mean for each participant at the largest amplitude",
        unit="% of the estimate at the largest {q.level}",
    ),
    # Zeros stay zero, and are left out of the mean logarithms (Lane, Catania and Stevens 1961,
    # Journal of the Acoustical Society of America 33, 160-167).
    "modulus_equalisation": Rule(
        divisor=_modulus_equalisation,
        top=1.0,
        formula="logarithm minus the participant's mean logarithm plus the grand mean logarithm; "
        "the group's geometric means do not change",
        unit="equalised modulus",
    ),
    # External modulus (Stevens 1956, American Journal of Psychology 69, 1-25; ASTM E1697).
    "standard_referenced": Rule(
        divisor=lambda trials: trials["modulus"],
        formula="each estimate divided by the number given to the standard, times 100",
        needs="a number above 0 for the standard in every trial (column modulus)",
        unit="% of the standard",
    ),
}


def default_rule(trials: pd.DataFrame) -> str:
    """Return ``scale_top`` if the top of the scale is declared in every trial.

    Otherwise, the rule is ``grand_maximum``.
    """
    tops = trials["scale_top"]
    return "scale_top" if len(tops) and bool((tops > 0).all()) else "grand_maximum"


def divisors(trials: pd.DataFrame, rule: str) -> pd.Series[float]:
    """Return the divisor for each trial, or NaN if the rule does not apply."""
    if rule not in RULES:
        raise UserError(
            "normalisation '{rule}': expected one of {rules}", rule=rule, rules=", ".join(RULES)
        )
    if not len(trials):
        return pd.Series(dtype=float)
    values = RULES[rule].divisor(trials).astype(float)
    return values.where(values > 0)


def normalise(trials: pd.DataFrame, rule: str) -> pd.Series[float]:
    """Return normalised estimates.

    Parameters
    ----------
    trials : DataFrame
        `slipscale.analysis.reading.dataset.Dataset.estimates`.
    rule : str
        A key of `RULES`.

    Raises
    ------
    UserError
        If the rule does not exist, or if participants lack data that the rule requires.
    """
    below = divisors(trials, rule)
    if below.isna().any():
        who = sorted(trials.loc[below.isna(), PARTICIPANT].astype(str).unique())
        raise UserError(
            "normalisation '{rule}' requires {needs} (missing for {incomplete}); with these data, "
            "expected one of {usable_rules}",
            rule=rule,
            needs=RULES[rule].needs,
            incomplete=listed(who),
            usable_rules=", ".join(normalise_by_all(trials)),
        )
    return _scaled(trials, rule, below)


def normalise_by_all(trials: pd.DataFrame) -> dict[str, pd.Series[float]]:
    """Normalise estimates with every applicable rule, in the order of `RULES`."""
    found = {name: divisors(trials, name) for name in RULES}
    return {
        name: _scaled(trials, name, below)
        for name, below in found.items()
        if not below.isna().any()
    }


def _scaled(trials: pd.DataFrame, rule: str, below: pd.Series[float]) -> pd.Series[float]:
    # Multiplying before dividing keeps 58 on a scale of 100 exactly 58.
    return trials["estimate"] * RULES[rule].top / below


def complete(cells: pd.DataFrame) -> pd.DataFrame:
    """Return the participants who have a value at every amplitude."""
    return cells.dropna()
