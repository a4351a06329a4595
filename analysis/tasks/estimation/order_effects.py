"""Estimate drift across trials and carry-over from the previous surface."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from slipscale.analysis.json_form import OurName, record
from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.preprocessing.sufficiency import FEWEST, few
from slipscale.analysis.statistics.arrays import Array
from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.estimation.jackknife import jackknife
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

#: An effect is not identifiable if the other columns leave less than this fraction of its variance.
IDENTIFIABLE = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class OrderEffects:
    """Order effects on log estimates, adjusted for amplitude and for each other.

    Parameters
    ----------
    log_slope_per_trial : MeanOverParticipants or NotComputed
        Change in the log estimate per trial (drift).
    log_slope_per_level_before : MeanOverParticipants or NotComputed
        Change in the log estimate per µm peak to peak of the previous surface (carry-over).
    """

    log_slope_per_trial: MeanOverParticipants | NotComputed
    log_slope_per_level_before: MeanOverParticipants | NotComputed

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return {
            "position": {
                "unit": "natural logarithm per trial",
                **record(self.log_slope_per_trial),
            },
            "carry_over": {
                "unit": OurName("natural logarithm per unit_of_level"),
                **record(self.log_slope_per_level_before),
            },
        }


def order_effects(data: Prepared) -> OrderEffects | NotComputed:
    """Test whether estimates depend on the trial's position or on the previous surface.

    All log estimates are fitted by least squares, with a mean for each participant, a mean for each
    amplitude (in each condition), a slope for position and a slope for the previous amplitude.
    Trials without a previous amplitude (first trials and trials after a texture) are omitted.
    Separate fits would confuse carry-over with drift, because position and previous surface are
    correlated within a participant. Standard errors come from a jackknife across participants;
    tests and intervals use the t distribution with n - 1 degrees of freedom.
    """
    if data.refused:
        return NotComputed(data.zero_sentence)
    if why := not_identifiable(data.trials, data.quantity):
        return NotComputed(why)
    trials = data.trials
    before = trials["before_level"]
    here = (before.notna() & trials["log"].notna()).to_numpy()
    who, _ = pd.factorize(trials.loc[here, PARTICIPANT])
    people = int(who.max()) + 1 if len(who) else 0
    if people < FEWEST:
        why = few("participants", people)
        return OrderEffects(
            log_slope_per_trial=NotComputed(why), log_slope_per_level_before=NotComputed(why)
        )
    shown = trials.loc[here, "item"].to_numpy()
    columns = [
        *(shown == item for item in np.unique(shown)[1:]),
        trials.loc[here, "position"].to_numpy(float),
        before[here].to_numpy(float),
        trials.loc[here, "log"].to_numpy(float),
    ]
    products = _products([_within(column, who, people) for column in columns], who, people)
    slopes = [_slope(products, place, data) for place in (-3, -2)]
    return OrderEffects(log_slope_per_trial=slopes[0], log_slope_per_level_before=slopes[1])


def not_identifiable(trials: pd.DataFrame, quantity: Quantity = PLATE_AMPLITUDE) -> str | None:
    """Return the reason why order and amplitude cannot be separated, or None if they can."""
    who, _ = pd.factorize(trials[PARTICIPANT])
    in_turn = np.argsort(who, kind="stable")
    amplitudes, who = trials["level"].to_numpy(float)[in_turn], who[in_turn]
    counts = np.bincount(who)
    people = len(counts)
    inside = who[1:] == who[:-1]
    steps, whose = np.diff(amplitudes)[inside], who[1:][inside]
    rising = np.bincount(whose, steps < 0, people) == 0
    falling = np.bincount(whose, steps > 0, people) == 0
    if (rising & falling).all():
        return few(quantity.levels, min(people, 1), 2)
    if (rising | falling).all():
        return (
            f"not identifiable, because every participant's rows are sorted by {quantity.name}, "
            "which is confounded with order (was the table sorted?)"
        )
    alike = people > 1 and (counts == counts[0]).all()
    if alike and (amplitudes.reshape(people, -1) == amplitudes[: counts[0]]).all():
        return (
            "not identifiable, because every participant had the same order, which is confounded "
            f"with {quantity.name}"
        )
    return None


def _within(column: Array, who: NDArray[np.intp], people: int) -> Array:
    """Subtract each participant's mean from a column."""
    means = np.bincount(who, column, people) / np.bincount(who, minlength=people)
    return np.asarray(column - means[who])


def _products(design: Sequence[Array], who: NDArray[np.intp], people: int) -> Array:
    """Return sums of products of the design columns, shape (people, columns, columns)."""
    width = len(design)
    products = np.empty((people, width, width))
    for row in range(width):
        for column in range(row, width):
            sums = np.bincount(who, design[row] * design[column], people)
            products[:, row, column] = products[:, column, row] = sums
    return products


def _slope(products: Array, place: int, data: Prepared) -> MeanOverParticipants | NotComputed:
    """Return the adjusted slope of the log estimate (last column) on one column of the design."""
    width = products.shape[1]
    total = products.sum(axis=0)
    target = width + place
    others = [column for column in range(width - 1) if column != target]
    own = total[target, target]
    left = (
        own
        - total[target, others]
        @ np.linalg.pinv(total[np.ix_(others, others)])
        @ (total[others, target])
    )
    if not left > IDENTIFIABLE * max(own, np.finfo(float).tiny):
        return NotComputed(
            f"not identifiable, because order and {data.quantity.name} are confounded for every "
            "participant"
        )

    def solve(sums: Array) -> Array:
        inverse = np.linalg.pinv(sums[..., :-1, :-1], rcond=1e-10, hermitian=True)
        return np.asarray((inverse @ sums[..., :-1, -1:])[..., target, 0])

    return jackknife(
        float(solve(total)), solve(total - products), confidence=data.choices.confidence
    )
