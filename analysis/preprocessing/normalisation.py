"""Normalise estimates to a common scale, using named rules.

The paper states only that estimates "were multiplied in order to bring them to 100" (Section IV-B).
Several rules fit this sentence; docs/how-to/your-data.md compares them.
Every rule except ``modulus_equalisation`` divides by a positive number, so zeros remain zeros and
the exponents of participants' power functions do not change.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from slipscale.analysis.reading.cells import listed
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
    formula : str
        Description for the report, in which ``q`` is a placeholder for the quantity.
    zeros : str
        How the rule treats estimates of zero.
    table3 : str
        Whether this rule could have produced the paper's Table III, and why.
    source : str
        Reference that describes the rule.
    needs : str
        Data that the rule requires, for the error message if they are missing.
    unit : str
        Unit of the result for axis labels, in which ``q`` is a placeholder for the quantity.
    """

    divisor: Callable[[pd.DataFrame], pd.Series[float]]
    top: float = 100.0
    formula: str
    zeros: str = "stay zero"
    table3: str
    source: str
    needs: str = "a positive estimate from each participant"
    unit: str = "% of the scale"


def cell_means(trials: pd.DataFrame, column: str | list[str] = "estimate") -> pd.DataFrame:
    """Return each participant's arithmetic mean at each amplitude.

    Returns
    -------
    DataFrame, shape (participants, amplitudes)
        Participants in rows and amplitudes (µm peak to peak) in columns, both sorted; NaN if there
        is no estimate. If ``column`` is a list, the result has one such block of columns per name.
    """
    cells = trials.groupby([PARTICIPANT, "amplitude_um_pp"], observed=True, sort=True)
    means = cells[column].mean()
    return pd.DataFrame(means.unstack("amplitude_um_pp"))  # noqa: PD010 - the index already exists


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
    "none": Rule(
        divisor=lambda trials: _constant(trials, 1.0),
        top=1.0,
        formula="estimates as given",
        table3="possible, if all participants were instructed to use 0 to 100",
        source="Stevens (1975), free magnitude estimation",
        unit="as given",
    ),
    "scale_top": Rule(
        divisor=lambda trials: trials["scale_top"],
        formula="each estimate divided by the declared top of its participant's scale, times 100",
        table3="possible, because no participant's largest estimate has to be 100",
        source="ASTM E1697, rescaling to a common scale",
        needs="a declared top of the scale above 0 in every trial (column scale_top)",
        unit="% of the declared top of the scale",
    ),
    "grand_maximum": Rule(
        divisor=_grand_maximum,
        formula="all estimates are multiplied by one factor, so that the largest participant "
        "mean at any {q.level} becomes 100",
        table3="possible, because all participants have the same factor; at 2.3 µm, the mean and "
        "the maximum deviation add up to 100.00, so one participant may have reached 100",
        source="a literal reading of the paper",
        needs="a positive estimate",
        unit="% of the largest participant mean",
    ),
    "participant_maximum": Rule(
        divisor=_participant_maximum,
        formula="each participant's largest mean at any {q.level} becomes 100",
        table3="impossible: nobody was above 72 at 1.2 µm, so everyone would have 100 at 2.3 µm, "
        "and the mean would be 100, not 81.33",
        source="common in haptics; forces the spread towards 0 at the top of the scale",
        unit="% of the participant's maximum",
    ),
    "participant_largest_trial": Rule(
        divisor=_participant_largest_trial,
        formula="each participant's largest single estimate becomes 100",
        table3="impossible with one trial per surface, for the same reason as with "
        "participant_maximum; possible with several trials",
        source="common in haptics; the divisor grows with the number of repetitions",
        unit="% of the participant's largest estimate",
    ),
    "top_stimulus": Rule(
        divisor=_top_stimulus,
        formula="each participant's mean at the largest {q.level} becomes 100",
        table3="impossible: the standard deviation at 2.3 µm would be 0, not 10.76",
        source="referencing to the strongest stimulus",
        needs="a positive mean for each participant at the largest amplitude",
        unit="% of the estimate at the largest {q.level}",
    ),
    "modulus_equalisation": Rule(
        divisor=_modulus_equalisation,
        top=1.0,
        formula="logarithm minus the participant's mean logarithm plus the grand mean logarithm; "
        "the group's geometric means do not change",
        zeros="stay zero, and are left out of the mean logarithms",
        table3="cannot be decided from the table, which gives no geometric means",
        source="Lane, Catania and Stevens (1961), Journal of the Acoustical Society of America "
        "33, 160-167",
        unit="equalised modulus",
    ),
    "standard_referenced": Rule(
        divisor=lambda trials: trials["modulus"],
        formula="each estimate divided by the number given to the standard, times 100",
        table3="not the paper's procedure: the paper mentions no standard",
        source="Stevens (1956), American Journal of Psychology 69, 1-25; ASTM E1697, external "
        "modulus",
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
        raise UserError(f"normalisation '{rule}': expected one of {', '.join(RULES)}")
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
            f"normalisation '{rule}' requires {RULES[rule].needs} (missing for "
            f"{listed(who)}); with these data, expected one of "
            f"{', '.join(normalise_by_all(trials))}"
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
