"""Prepare estimates for inference: take logarithms and number the trials.

The spread of estimates is proportional to their size, and scaling to a maximum reduces the spread
at the top of the scale. Inference therefore uses logarithms or ranks. Zeros have no logarithm; an
explicit rule defines how they are treated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from slipscale.analysis.preprocessing.normalisation import (
    complete,
    items,
    means_over_conditions,
)
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class PositiveEstimates:
    """Estimates after applying a zero rule (NaN if excluded), with a sentence about the rule."""

    values: pd.Series[float]
    sentence: str
    refused: bool = False


def _exclude(values: pd.Series[float]) -> PositiveEstimates:
    count = int((values <= 0).sum())
    return PositiveEstimates(
        values=values.where(values > 0),
        sentence=f"Estimates of zero: {count}. Analyses of log estimates exclude zeros and "
        "describe only estimates above zero; rank-based tests use every estimate.",
    )


def _refuse(values: pd.Series[float]) -> PositiveEstimates:
    count = int((values <= 0).sum())
    return PositiveEstimates(
        values=values.where(values > 0),
        sentence=f"Estimates of zero: {count}. The zero rule is 'refuse', so no results are "
        "computed on logarithms.",
        refused=True,
    )


def _half_minimum(values: pd.Series[float]) -> PositiveEstimates:
    half = float(values[values > 0].min()) / 2
    count = int((values <= 0).sum())
    return PositiveEstimates(
        values=values.where(values > 0, half),
        sentence=f"Estimates of zero: {count}. Zeros were replaced by {half:.4g}, half the "
        "smallest positive normalised estimate, before logarithms were taken (zero rule: "
        "half_minimum).",
    )


#: Functions that apply a zero rule to normalised estimates, keyed by rule.
ZERO_RULES: dict[str, Callable[[pd.Series[float]], PositiveEstimates]] = {
    "exclude": _exclude,
    "refuse": _refuse,
    "half_minimum": _half_minimum,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Prepared:
    """Estimates prepared for inference.

    Parameters
    ----------
    trials : DataFrame
        Analysed trials. Columns: ``normalised``; ``log``, the natural logarithm (NaN if excluded);
        ``position`` and ``before_level``, see `order_of`; ``item``, see `items`; ``repetition``,
        counted from 1 within the amplitude.
    cells : DataFrame, shape (participants, amplitudes)
        Participants' mean normalised estimates.
    logs : DataFrame, shape (participants, amplitudes)
        Participants' mean logarithms.
    zeros : int
        Number of estimates that are zero.
    zero_sentence : str
        Sentence on how zeros were treated; empty if there are no zeros.
    refused : bool
        Whether results on logarithms are omitted, because there are estimates of zero and the zero
        rule is "refuse".
    quantity : Quantity
        Quantity of the amplitudes.
    """

    trials: pd.DataFrame
    cells: pd.DataFrame
    logs: pd.DataFrame
    zeros: int
    zero_sentence: str
    refused: bool
    choices: AnalysisChoices
    quantity: Quantity = PLATE_AMPLITUDE

    @property
    def whole(self) -> pd.DataFrame:
        """Mean estimates of participants who have an estimate at every amplitude."""
        return complete(self.cells)

    @property
    def whole_logs(self) -> pd.DataFrame:
        """Mean logarithms for participants with a value at every amplitude in `logged`."""
        return complete(self.logs[self.logged])

    @property
    def logged(self) -> list[float]:
        """Amplitudes (µm peak to peak) at which at least one participant has a mean logarithm."""
        return [float(value) for value in self.logs.columns[self.logs.notna().any()]]

    @property
    def geometric(self) -> bool:
        """Whether geometric means can be computed under the zero rule."""
        return not self.refused and bool(self.logged)

    @property
    def without_log(self) -> frozenset[float]:
        """Amplitudes (µm peak to peak) at which the logarithm of an estimate is missing (NaN)."""
        left_out = self.trials["log"].isna()
        return frozenset(self.trials.loc[left_out, "level"].astype(float))


def order_of(trials: pd.DataFrame, shown: pd.Series[float]) -> pd.DataFrame:
    """Return the columns on the order of presentation.

    ``position`` is counted from 1 within the participant. ``before_level`` is the amplitude of the
    run's previous trial, or NaN if there is none.

    Parameters
    ----------
    trials : DataFrame
        All main trials, with and without an answer, in order of presentation.
    shown : Series
        Presented amplitude, NaN for textures.
    """
    runs = [trials[name] for name in (PARTICIPANT, "session", "run")]
    position = trials.groupby(PARTICIPANT, observed=True, sort=False).cumcount() + 1
    before = shown.groupby(runs, observed=True).shift()
    return pd.DataFrame({"position": position, "before_level": before})


def prepare(
    estimates: pd.DataFrame, choices: AnalysisChoices, quantity: Quantity = PLATE_AMPLITUDE
) -> Prepared:
    """Prepare trials for inference.

    Parameters
    ----------
    estimates : DataFrame
        Trials with their ``normalised`` estimate, in order of presentation. Without the columns
        of `order_of`, every trial was answered.
    choices : AnalysisChoices
        Analysis choices. Only the zero rule is applied here; all choices are copied to the result.
    quantity : Quantity
        Quantity of the amplitudes.
    """
    values = estimates["normalised"]
    zeros = int((values <= 0).sum())
    positive = (
        ZERO_RULES[choices.zero_rule](values)
        if zeros
        else PositiveEstimates(values=values, sentence="")
    )
    by_cell = estimates.groupby([PARTICIPANT, "level"], observed=True, sort=False)
    if "position" not in estimates:
        estimates = estimates.join(order_of(estimates, estimates["level"]))
    trials = estimates.assign(
        log=np.log(positive.values),
        repetition=by_cell.cumcount() + 1,
        item=items(estimates),
    )
    return Prepared(
        trials=trials,
        cells=means_over_conditions(trials, "normalised"),
        logs=means_over_conditions(trials, "log"),
        zeros=zeros,
        zero_sentence=positive.sentence,
        refused=positive.refused,
        choices=choices,
        quantity=quantity,
    )
