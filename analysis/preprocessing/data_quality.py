"""Flag participants with unusual data, and exclude them only if the study requires it.

The study file sets the thresholds, and the flags that lead to exclusion, before the data are
examined.
"""

from __future__ import annotations

from collections.abc import Callable
from math import factorial
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.preprocessing.normalisation import (
    cell_means,
    items,
    log_cell_means,
)
from slipscale.analysis.preprocessing.residuals import residuals, slopes_per_participant
from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY
from slipscale.analysis.reading.trial_tables import factor_columns
from slipscale.experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.experiments.study.analysis_choices import QualityFlag, Thresholds

#: Largest probability of a flag by chance, for flags that are based on a test.
RARE = 0.05
#: With at most this many amplitudes, no participant is flagged as constant.
FEW_LEVELS = 2
#: Smallest number of trials for which drift is computed.
TRIALS_FOR_DRIFT = 8

#: Smallest number of catch steps for the flag: after a single one, too many attentive participants
#: would be flagged.
CATCHES = 2

#: Descriptions of the flags, keyed by flag; ``q`` is a placeholder for the quantity.
MEANINGS = {
    "non_monotone": "mean estimates {q.shrink} from one {q.level} to the next",
    "constant": "very few distinct numbers",
    "zeros": "many estimates of zero",
    "timed_out": "many trials without an answer in time",
    "fast": "answers too fast to be deliberate",
    "outlying": "estimates far from the participant's own pattern",
    "unreliable": "the first and second halves of the repetitions disagree",
    "drift": "estimates grow or shrink over the session",
    "false_alarms": '"yes" when nothing changed',
    "faults": "plate faults, or {q.stimuli} that were presented again before the answer",
}
#: Fields of `Thresholds` on which each flag depends.
LIMITS: dict[QualityFlag, tuple[str, ...]] = {
    "non_monotone": ("falling_steps",),
    "constant": ("distinct_numbers",),
    "zeros": ("zero_share",),
    "timed_out": ("timed_out_share",),
    "fast": ("fast_share", "fast_s"),
    "outlying": ("outlier_sd",),
    "unreliable": ("reliability",),
    "drift": ("drift_factor",),
    "false_alarms": ("false_alarm_share",),
    "faults": ("fault_share",),
}


def measures(data: Dataset, thresholds: Thresholds) -> pd.DataFrame:
    """Compute the measures on which flags are based, with one row per participant.

    Returns
    -------
    DataFrame
        One column per flag, indexed by ``participant_id``. The measures are counts, proportions, a
        factor (``drift``) and a correlation (``unreliable``); NaN if the data are insufficient.
    """
    answers, trials = data.answers, data.estimates
    people = pd.Index(sorted(data.people), name=PARTICIPANT)
    found = pd.DataFrame(index=people)
    if len(trials):
        by = trials.groupby(PARTICIPANT, observed=True)
        means = cell_means(trials)
        steps = np.diff(means.to_numpy(float), axis=1) * (-1 if data.quantity.falls else 1)
        falling = (steps < 0).sum(1).astype(float)
        if thresholds.falling_steps is None:
            falling = np.where(falling >= rarely_falling(means.shape[1]), falling, 0.0)
        found["non_monotone"] = _indexed(falling, means)
        # With few amplitudes, one number per amplitude is not suspicious.
        levels = by["level"].nunique()
        found["constant"] = by["estimate"].nunique().where(levels > FEW_LEVELS)
        felt = trials[trials["level"] > 0]
        found["zeros"] = _share(felt, felt["estimate"] == 0)
        found["fast"] = _share(trials, trials["response_time"] < thresholds.fast_s)
        found = found.join(_patterns(trials, thresholds))
    if len(answers):
        found["timed_out"] = _share(answers, answers["timed_out"])
        found["faults"] = _share(answers, answers["faulty"])
    catches = data.differences[data.differences["catch"]] if len(data.differences) else None
    if catches is not None and len(catches):
        share = _share(catches, catches["difference_felt"] == 1)
        several = catches.groupby(PARTICIPANT, observed=True).size() >= CATCHES
        found["false_alarms"] = share.where(several)
    return found.reindex(columns=list(MEANINGS), index=people)


def rarely_falling(levels: int) -> int:
    """Return the smallest number of decreases with a chance probability of at most 1 in 20.

    If a participant feels no difference, every order of the means is equally likely, so the number
    of orders with a given number of decreases is an Eulerian number. If a participant feels a
    difference, decreases are less likely.

    >>> [rarely_falling(levels) for levels in (2, 3, 4, 5, 8)]
    [2, 3, 3, 4, 6]
    """
    orders = [1]
    for n in range(2, levels + 1):
        before = [0, *orders, 0]
        orders = [(k + 1) * before[k + 1] + (n - k) * before[k] for k in range(n)]
    as_rare = [k for k in range(levels) if sum(orders[k:]) <= RARE * factorial(levels)]
    return min(as_rare, default=levels)


def _indexed(values: np.ndarray, like: pd.DataFrame) -> pd.Series[float]:
    return pd.Series(values, index=like.index.astype(str))


def _share(rows: pd.DataFrame, which: pd.Series[bool]) -> pd.Series[float]:
    return which.astype(float).groupby(rows[PARTICIPANT], observed=True).mean()


def _patterns(trials: pd.DataFrame, thresholds: Thresholds) -> pd.DataFrame:
    """Compute outliers, drift and split-half correlation from logarithms.

    Conditions of factors are not unusual patterns, so items replace amplitudes, and drift is
    computed within a participant's conditions.
    """
    positive = trials[trials["estimate"] > 0]
    condition = positive.groupby(factor_columns(positive) or PARTICIPANT, observed=True).ngroup()
    positive = positive.assign(level=items(positive).astype(float))
    logs = log_cell_means(positive)
    columns: dict[str, pd.Series[float]] = {}
    if not len(positive):
        return pd.DataFrame(columns)
    work = positive.assign(log=np.log(positive["estimate"]))
    who = logs.index.get_indexer(pd.Index(work[PARTICIPANT]))
    what = logs.columns.get_indexer(pd.Index(work["level"]))
    people = len(logs)
    left = residuals(work, logs)
    outlying = np.abs(left) > thresholds.outlier_sd * _spreads(left, what)
    # With two participants, residuals mirror each other, so outliers cannot be identified.
    columns["outlying"] = _indexed(
        np.where(people >= FEWEST, np.bincount(who, outlying, people), np.nan), logs
    )
    counts = np.bincount(who, minlength=people)
    position = work.groupby(PARTICIPANT, observed=True).cumcount().to_numpy(dtype=np.float64)
    slopes, p = slopes_per_participant(
        who, np.asarray(position, float), left, people, np.asarray(condition, np.intp)
    )
    drift = np.where(
        (counts >= TRIALS_FOR_DRIFT) & (p < RARE), np.exp(np.abs(slopes) * (counts - 1)), np.nan
    )
    columns["drift"] = _indexed(drift, logs)
    columns["unreliable"] = _indexed(_split_half(work, who, what, logs), logs)
    return pd.DataFrame(columns)


def _spreads(left: np.ndarray, what: np.ndarray) -> np.ndarray:
    """Return a robust standard deviation for scaling each residual.

    The spread is larger at small amplitudes, so a common spread would flag half of the participants
    with many answers. With few people, the spread at a single amplitude is uncertain. The result
    combines both: it is the square root of the mean of two variances, one of the residuals at all
    amplitudes and one of the residuals at the same amplitude.
    """
    pooled = _robust_sd(left)
    places, at = np.unique(what, return_inverse=True)
    own = np.array([_robust_sd(left[at == number]) for number in range(len(places))])
    spreads = np.sqrt((own**2 + pooled**2) / 2)[at]
    return np.where(spreads > TINY, spreads, np.inf)


def _robust_sd(values: np.ndarray) -> float:
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))


def _split_half(
    work: pd.DataFrame, who: np.ndarray, what: np.ndarray, logs: pd.DataFrame
) -> np.ndarray:
    """Correlate amplitude means in the first and second half of each participant's repetitions."""
    people, kinds = logs.shape
    cell = who * kinds + what
    total = np.bincount(cell, minlength=people * kinds)
    nth = work.groupby([PARTICIPANT, "level"], observed=True).cumcount().to_numpy()
    half = (2 * nth >= total[cell]).astype(int)
    key = half * people * kinds + cell
    sums = np.bincount(key, work["log"], 2 * people * kinds)
    counts = np.bincount(key, minlength=2 * people * kinds)
    with np.errstate(invalid="ignore", divide="ignore"):
        first, second = (sums / counts).reshape(2, people, kinds)
        first = first - first.mean(axis=1, keepdims=True)
        second = second - second.mean(axis=1, keepdims=True)
        below = np.sqrt((first**2).sum(1) * (second**2).sum(1))
        return np.where(below > TINY, (first * second).sum(1) / below, np.nan)


#: Functions that select the flagged participants from measures and thresholds, keyed by flag. NaN
#: is never flagged. Add each new flag to
#: `slipscale.experiments.study.analysis_choices.QualityFlag` as well.
DECISIONS: dict[str, Callable[[pd.Series[float], Thresholds], pd.Series[bool]]] = {
    "non_monotone": lambda m, t: m >= (t.falling_steps or 1),
    "constant": lambda m, t: m <= t.distinct_numbers,
    "zeros": lambda m, t: m > t.zero_share,
    "timed_out": lambda m, t: m > t.timed_out_share,
    "fast": lambda m, t: m > t.fast_share,
    "outlying": lambda m, _: m >= 1,
    "unreliable": lambda m, t: m < t.reliability,
    "drift": lambda m, t: m > t.drift_factor,
    "false_alarms": lambda m, t: m > t.false_alarm_share,
    "faults": lambda m, t: m > t.fault_share,
}


def flags(measured: pd.DataFrame, thresholds: Thresholds) -> pd.DataFrame:
    """Return a Boolean table of flags, with the shape of ``measured``."""
    return pd.DataFrame(
        {name: decide(measured[name], thresholds) for name, decide in DECISIONS.items()},
        index=measured.index,
    ).astype(bool)
