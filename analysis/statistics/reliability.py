"""Test-retest reliability of log estimates, by components of variance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.json_form import renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY, few
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from slipscale.analysis.preprocessing.log_transform import Prepared

    Array = NDArray[np.float64]

#: A correlation this close to 1 has no finite Fisher's z.
CLOSE_TO_ONE = 1 - 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class IntraclassCorrelation:
    """An intraclass correlation; no interval where a participant left out makes it 1."""

    value: float
    interval: ConfidenceInterval | None

    def json_form(self) -> Mapping[str, object]:
        """Return the result under its keys."""
        return renamed(self, interval="ci")


@dataclass(frozen=True, slots=True, kw_only=True)
class Reliability:
    """How much of the variance of log estimates is the participants'.

    Log estimate = mean of the amplitude + participant + participant x amplitude + repetition.
    The amplitudes are what the study chose: differences between them are no reliability.

    Parameters
    ----------
    single, mean : IntraclassCorrelation
        Of one estimate, and of the mean of a participant's repetitions at an amplitude.
    variance_participants, variance_interaction, variance_repetitions : float
        Components, squared natural logarithms; not below 0.
    n, amplitudes, repetitions : int
        Of the complete block that they are computed from.
    """

    single: IntraclassCorrelation
    mean: IntraclassCorrelation
    variance_participants: float
    variance_interaction: float
    variance_repetitions: float
    n: int
    amplitudes: int
    repetitions: int


def reliability(data: Prepared) -> Reliability | NotComputed:
    """Return intraclass correlations over repetitions, by components of variance.

    Components from the mean squares of the complete block of participants, amplitudes and
    repetitions (Searle, Casella and McCulloch 1992, Variance Components, ch. 4). Intervals are a
    jackknife over participants on Fisher's z, Student's n - 1 degrees of freedom, because a
    participant's amplitudes are not independent targets. An estimate of zero is no repetition;
    people who lack one are left out.
    """
    if data.refused:
        return NotComputed(data.zero_sentence)
    block, why = _block(data)
    if why:
        return NotComputed(why)
    n, k, repetitions = block.shape
    squares = _sums_of_squares(block)
    whole = _components(squares.sum(axis=0), n, k, repetitions)
    if whole[2] <= TINY:
        return NotComputed(
            "every repetition gave the same estimate: no spread within to compare with"
        )
    # Leaving one of n out of a sum of squares around their mean takes n / (n - 1) of its own.
    own = squares * [n / (n - 1), n / (n - 1), 1.0]
    without = _components(squares.sum(axis=0) - own, n - 1, k, repetitions)
    single, mean = (
        _coefficient(whole, without, r, data.choices.confidence) for r in (1, repetitions)
    )
    return Reliability(
        single=single,
        mean=mean,
        variance_participants=max(float(whole[0]), 0.0),
        variance_interaction=max(float(whole[1]), 0.0),
        variance_repetitions=float(whole[2]),
        n=n,
        amplitudes=k,
        repetitions=repetitions,
    )


def _block(data: Prepared) -> tuple[Array, str | None]:
    """Return log estimates, shape (participants, amplitudes, repetitions), and why there are none.

    The most frequent number of repetitions counts; more are cut, who has fewer is left out.
    """
    nothing = np.empty((0, 0, 0))
    cell = [PARTICIPANT, "amplitude_um_pp"]
    usable = data.trials.loc[data.trials["log"].notna(), [*cell, "log"]]
    sizes = usable.groupby(cell, observed=True).size()
    if not len(sizes) or sizes.max() < 2:  # noqa: PLR2004
        return nothing, (
            f"no repetitions: reliability needs two estimates of a {data.quantity.stimulus} or more"
        )
    repetitions = int(sizes[sizes >= 2].mode().iloc[0])  # noqa: PLR2004
    nth = usable.groupby(cell, observed=True).cumcount()
    rows = usable.assign(nth=nth)[nth < repetitions]
    table = rows.pivot_table(
        index=PARTICIPANT, columns=["amplitude_um_pp", "nth"], values="log", observed=True
    )
    amplitudes = table.columns.get_level_values(0)
    # Counted: an amplitude that nobody repeated has fewer columns.
    present = table.notna().T.groupby(amplitudes).sum().eq(repetitions).T
    # An amplitude that hardly anybody has whole would leave nobody.
    kept = present.columns[present.mean() >= 0.5]  # noqa: PLR2004
    table = table.loc[:, amplitudes.isin(kept)].dropna()
    n, k = len(table), len(kept)
    if n < FEWEST or k < 1:
        return nothing, few("participants with every repetition above zero", n)
    return table.to_numpy(float).reshape(n, k, repetitions), None


def _sums_of_squares(block: Array) -> Array:
    """Return each participant's sums of squares: between people, interaction, repetitions."""
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
    """Return the components participant, participant x amplitude, repetition; may be below 0."""
    people = squares[..., 0] / (n - 1)
    within = squares[..., 2] / (n * k * (repetitions - 1))
    interaction = squares[..., 1] / ((n - 1) * (k - 1)) if k > 1 else within
    return np.stack(
        [(people - interaction) / (k * repetitions), (interaction - within) / repetitions, within],
        axis=-1,
    )


def _coefficient(whole: Array, without: Array, r: int, confidence: float) -> IntraclassCorrelation:
    from scipy import stats  # noqa: PLC0415 - a second's import

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
