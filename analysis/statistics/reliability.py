"""Estimate the test-retest reliability of log estimates from variance components."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from slipscale.analysis.json_form import renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY, few
from slipscale.analysis.statistics.arrays import Array
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.variance_components import reml_components
from slipscale.experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.preprocessing.log_transform import Prepared

#: Correlations this close to 1 are treated as 1, for which Fisher's z is infinite.
CLOSE_TO_ONE = 1 - 1e-9
CELL = [PARTICIPANT, "item"]
#: Largest number of REML fits in the jackknife; each omits one group of participants.
GROUPS = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class IntraclassCorrelation:
    """An intraclass correlation.

    The interval is None if the value or any jackknife value reaches 1.
    """

    value: float
    interval: ConfidenceInterval | None

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, interval="ci")


@dataclass(frozen=True, slots=True, kw_only=True)
class Reliability:
    """Test-retest reliability of log estimates, with the variance components.

    The model of log estimates is: amplitude mean + participant + participant x amplitude +
    repetition. Reliability is the proportion of variance that is due to participants and to their
    interaction with amplitude. The variance between amplitude means is excluded, because the study
    chose the amplitudes. If a study has factors, each combination of amplitude and condition takes
    the place of an amplitude.

    Parameters
    ----------
    single, mean : IntraclassCorrelation
        Reliability of a single estimate, and of the mean of a participant's repetitions at an
        amplitude.
    variance_participants, variance_interaction, variance_repetitions : float
        Variance components of the log estimates, each at least 0.
    n, of_levels, trials : int
        Numbers of participants, amplitudes and trials.
    repetitions : float
        Number of repetitions per participant and amplitude, or its harmonic mean if the numbers
        differ.
    method : {"mean squares", "REML"}
        Estimation method. REML is used if the number of estimates is not the same for every
        participant and amplitude.
    """

    single: IntraclassCorrelation
    mean: IntraclassCorrelation
    variance_participants: float
    variance_interaction: float
    variance_repetitions: float
    n: int
    of_levels: int
    repetitions: float
    trials: int
    method: Literal["mean squares", "REML"]


def reliability(data: Prepared) -> Reliability | NotComputed:
    """Return intraclass correlations across repetitions, from variance components.

    If every participant has the same number of estimates above zero at every amplitude, components
    are computed from mean squares (Searle, Casella and McCulloch 1992, Variance Components, ch. 4).
    Otherwise, variance components are estimated from all estimates by restricted maximum
    likelihood. Intervals use a jackknife of Fisher's z across participants, because a participant's
    estimates at different amplitudes are not independent.
    """
    if data.refused:
        return NotComputed(data.zero_sentence)
    usable = data.trials.loc[data.trials["log"].notna(), [*CELL, "log"]]
    cells = usable.groupby(CELL, observed=True)["log"]
    counts = cells.size().unstack(fill_value=0)  # noqa: PD010 - a Series has no pivot_table
    if not len(counts) or counts.to_numpy().max() < 2:  # noqa: PLR2004
        return NotComputed(
            "there are no repetitions, and reliability requires at least two estimates per "
            f"{data.quantity.stimulus}"
        )
    n, k = counts.shape
    if n < FEWEST:
        return NotComputed(few("participants with estimates above zero", n))
    trials = counts.to_numpy(float)
    balanced = trials.min() == trials.max()
    repetitions: float
    if balanced:
        repetitions = int(trials.max())
        whole, without = _by_mean_squares(usable, (n, k, repetitions))
    else:
        filled = trials[trials > 0]
        repetitions = float(filled.size / (1 / filled).sum())
        means = cells.mean().unstack().to_numpy()  # noqa: PD010
        around = (usable["log"] - cells.transform("mean")) ** 2
        squares = around.groupby(usable[CELL[0]], observed=True).sum().to_numpy()
        whole, without = _by_reml(means, trials, squares)
    if whole[2] <= TINY:
        return NotComputed(
            "every repetition gave the same estimate, so there is no variance within participants"
        )
    single, mean = (
        _coefficient(whole, without, r, data.choices.confidence) for r in (1.0, repetitions)
    )
    return Reliability(
        single=single,
        mean=mean,
        variance_participants=max(float(whole[0]), 0.0),
        variance_interaction=max(float(whole[1]), 0.0),
        variance_repetitions=float(whole[2]),
        n=n,
        of_levels=k,
        repetitions=repetitions,
        trials=len(usable),
        method="mean squares" if balanced else "REML",
    )


def _by_mean_squares(usable: pd.DataFrame, shape: tuple[int, int, int]) -> tuple[Array, Array]:
    """Return the variance components for all participants, and with each one omitted in turn."""
    n, k, repetitions = shape
    block = usable.sort_values(CELL, kind="stable")["log"].to_numpy(float).reshape(shape)
    squares = _sums_of_squares(block)
    # Omitting one of n values reduces their sum of squares by n / (n - 1) times the square of that
    # value's deviation from the mean.
    own = squares * [n / (n - 1), n / (n - 1), 1.0]
    without = _components(squares.sum(axis=0) - own, n - 1, k, repetitions)
    return _components(squares.sum(axis=0), n, k, repetitions), without


def _by_reml(means: Array, counts: Array, squares: Array) -> tuple[Array, Array]:
    """Return REML variance components for all participants, and with each group omitted in turn."""
    whole = reml_components(means, counts, squares)
    if whole[2] <= TINY:
        return whole, whole[None]
    group = np.arange(len(means)) % GROUPS
    start = (whole[:2] / whole[2] + 1e-3).tolist()
    without = [
        reml_components(means[kept], counts[kept], squares[kept], (start,))
        for kept in (group != left for left in range(min(len(means), GROUPS)))
    ]
    return whole, np.array(without)


def _sums_of_squares(block: Array) -> Array:
    """Return sums of squares per participant: between participants, interaction and repetitions."""
    _, k, repetitions = block.shape
    cells = block.mean(axis=2)
    centred = cells - cells.mean(axis=0)
    people = centred.mean(axis=1)
    return np.column_stack(
        [
            k * repetitions * people**2,
            repetitions * ((centred - people[:, None]) ** 2).sum(axis=1),
            ((block - cells[..., None]) ** 2).sum(axis=(1, 2)),
        ]
    )


def _components(squares: Array, n: int, k: int, repetitions: int) -> Array:
    people = squares[..., 0] / (n - 1)
    within = squares[..., 2] / (n * k * (repetitions - 1))
    interaction = squares[..., 1] / ((n - 1) * (k - 1)) if k > 1 else within
    return np.stack(
        [(people - interaction) / (k * repetitions), (interaction - within) / repetitions, within],
        axis=-1,
    )


def _coefficient(
    whole: Array, without: Array, r: float, confidence: float
) -> IntraclassCorrelation:
    from scipy import stats

    def ratio(components: Array) -> Array:
        between = components[..., 0] + components[..., 1]
        below = between + components[..., 2] / r
        return np.asarray(np.clip(between / below, -CLOSE_TO_ONE, 1.0))

    value, each = float(ratio(whole)), ratio(without)
    if max(value, float(each.max())) >= CLOSE_TO_ONE:
        return IntraclassCorrelation(value=value, interval=None)
    n = len(each)
    z = np.arctanh(each)
    pseudo = n * np.arctanh(value) - (n - 1) * z
    half = float(stats.t.ppf((1 + confidence) / 2, n - 1) * pseudo.std(ddof=1) / n**0.5)
    low, high = (float(np.tanh(pseudo.mean() + sign * half)) for sign in (-1, 1))
    return IntraclassCorrelation(value=value, interval=ConfidenceInterval(low, high, confidence))
