"""Compare growth functions of amplitude and of predicted friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.json_form import record, renamed
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    mean_over_participants,
)
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.power_law import exponents
from slipscale.analysis.tasks.estimation.growth.growth_models import (
    MODELS,
    GrowthComparison,
    compare,
)
from slipscale.analysis.tasks.estimation.growth.individual_winners import individual_winners
from slipscale.stimuli.surface import VirtualSurface, peak_from_pp

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.preprocessing.log_transform import Prepared

#: Predicted reductions in friction below this value are treated as rounding errors.
NO_REDUCTION = 1e-9
#: Largest amplitude (µm peak to peak) for predictions. Above about 8 µm, the predicted reduction in
#: friction exceeds 1.
LARGEST_UM_PP = 20.0
#: Largest number of participants for whom individual model comparisons are listed.
INDIVIDUALS_AT_MOST = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionGrowth:
    """Growth of estimates with the reduction in friction predicted by the squeeze-film model.

    Parameters
    ----------
    comparison : GrowthComparison
        Comparison of functions that relate estimates to the predicted reduction in friction.
    exponent : MeanOverParticipants or NotComputed
        Mean exponent of the power functions that relate each participant's estimates to the
        predicted reduction in friction.
    reduction : Mapping
        Predicted reduction in friction (0 to 1) by amplitude (µm peak to peak).
    shared_load : Mapping
        Smallest and largest reduction at each amplitude, as predicted by the model in
        `slipscale.stimuli.film.shared_load`, which has not been validated.
    """

    comparison: GrowthComparison
    exponent: MeanOverParticipants | NotComputed
    reduction: Mapping[float, float]
    shared_load: Mapping[float, tuple[float, float]]

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return {**record(self.comparison), **renamed(self, comparison="")}


@dataclass(frozen=True, slots=True, kw_only=True)
class IndividualGrowth:
    """The best growth function of each participant.

    Parameters
    ----------
    best : Mapping
        Number of participants for whom each model is best.
    undecided : int
        Number of participants whose trials do not discriminate between models.
    participants : Mapping
        Best model of each participant, or None if the trials do not discriminate between models.
    """

    best: Mapping[str, int]
    undecided: int
    participants: Mapping[str, str | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Growth:
    """Growth functions of amplitude and of predicted friction, and each participant's best one.

    ``friction`` is None if the stimuli are not plate amplitudes.
    """

    of_level: GrowthComparison
    friction: FrictionGrowth | NotComputed | None
    individual: IndividualGrowth | NotComputed

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, friction="" if self.friction is None else "friction")


def growth(data: Prepared) -> Growth | NotComputed:
    """Compare growth functions of amplitude and of predicted friction, and for each participant."""
    if data.refused:
        return NotComputed(data.zero_sentence)
    found = compare(data.logs, data.quantity)
    if isinstance(found, NotComputed):
        return found
    return Growth(
        of_level=found,
        friction=against_friction(data.logs, data.choices.confidence)
        if data.quantity.of_plate
        else None,
        individual=_individual(data),
    )


def _individual(data: Prepared) -> IndividualGrowth | NotComputed:
    if len(data.logs) > INDIVIDUALS_AT_MOST:
        return NotComputed(
            f"computed only for studies with up to {INDIVIDUALS_AT_MOST} participants"
        )
    winners = individual_winners(data.trials)
    return IndividualGrowth(
        best={name: sum(w == name for w in winners.values()) for name in MODELS},
        undecided=sum(w is None for w in winners.values()),
        participants=winners,
    )


@lru_cache(maxsize=1000)
def predicted_reduction(level: float) -> float:
    """Return the relative reduction in friction, 1 - µ'/µ, predicted by the squeeze-film model.

    The prediction uses the full Reynolds equation (3) and equation (15), with the roughness and the
    frequency in the paper's Section IV (h_r = 0.6 µm, 30.5 kHz) and a normal force of 0.5 N; see
    `VirtualSurface.predicted_relative_friction`.
    """
    return 1.0 - VirtualSurface(level=level).predicted_relative_friction()


def _shared_load_reduction(level: float) -> tuple[float, float]:
    from slipscale.stimuli.film.shared_load import band

    least, most = band(peak_from_pp(level))
    return 1 - most, 1 - least


def against_friction(logs: pd.DataFrame, confidence: float = 0.95) -> FrictionGrowth | NotComputed:
    """Compare growth functions of the reduction in friction predicted by the squeeze-film model.

    Parameters
    ----------
    logs : DataFrame, shape (participants, amplitudes)
        Mean natural logarithms of estimates; amplitudes without a predicted reduction are omitted.
    confidence : float
        Confidence level of the exponent's interval.
    """
    amplitudes = logs.columns.to_numpy(float)
    sensible = bool((amplitudes <= LARGEST_UM_PP).all())
    reductions = np.array([predicted_reduction(float(a)) for a in amplitudes if sensible])
    if not sensible or (reductions > 1).any():
        return NotComputed(
            f"amplitudes up to {amplitudes.max():g} µm are beyond the film model, which would "
            "predict a friction reduction above 1"
        )
    above = reductions > NO_REDUCTION
    if len(np.unique(reductions[above])) < above.sum():
        return NotComputed("two amplitudes have the same predicted friction")
    table = logs.loc[:, above].set_axis(reductions[above], axis=1)
    found = compare(table)
    if isinstance(found, NotComputed):
        return found
    slopes = exponents(table)["exponent"].to_numpy(float)
    return FrictionGrowth(
        comparison=found,
        exponent=mean_over_participants(slopes, confidence),
        reduction={float(a): float(r) for a, r in zip(amplitudes, reductions, strict=True)},
        shared_load={float(a): _shared_load_reduction(float(a)) for a in amplitudes},
    )
