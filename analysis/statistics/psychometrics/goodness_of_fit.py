"""How well a psychometric function fits its answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY, few
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics import psychometric_fit as likelihood
from slipscale.analysis.statistics.psychometrics.psychometric_fit import Counts
from slipscale.analysis.statistics.psychometrics.thresholds import (
    LARGEST_LAPSE,
    counts_of,
    model_of,
)

if TYPE_CHECKING:
    from slipscale.analysis.statistics.psychometrics.psychometric_fit import Array
    from slipscale.analysis.statistics.psychometrics.psychometric_function import (
        Answers,
        PsychometricFunction,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class GoodnessOfFit:
    """How far answers lie from a fitted curve.

    Parameters
    ----------
    deviance : float
        Twice the log likelihood that a curve through every proportion would gain.
    p : float
        Share of data sets simulated from the curve, and fitted anew, with at least this deviance.
    simulations : int
        How many.
    """

    deviance: float
    p: float
    simulations: int


def goodness_of_fit(
    fitted: PsychometricFunction,
    answers: Answers,
    *,
    largest_lapse: float = LARGEST_LAPSE,
    simulations: int = 1000,
    seed: int = 2001,
) -> GoodnessOfFit | NotComputed:
    """Test a curve by its deviance, against data sets simulated from it and fitted anew.

    Wichmann and Hill 2001, Percept. Psychophys. 63, 1293-1313: with few answers a level the
    deviance is not chi-square distributed, so its distribution is simulated.

    Parameters
    ----------
    fitted : PsychometricFunction
        `fit_threshold`'s, with the same ``largest_lapse``.
    """
    repeated = int((answers.trials > 1).sum())
    needed = FEWEST + 1
    if repeated < needed:
        return NotComputed(few("levels with more than one answer", repeated, needed))
    model = model_of(fitted.method, fitted.curve, fitted.share, largest_lapse)
    counts = counts_of(answers, model)
    proportion = fitted.proportion(answers.levels_um_pp)
    observed = float(deviance(counts, proportion[None])[0])
    drawn = np.random.default_rng(seed).binomial(
        answers.trials.astype(int), np.clip(proportion, 0, 1), size=(simulations, proportion.size)
    )
    simulated = Counts(
        np.broadcast_to(counts.u, drawn.shape),
        drawn.astype(float),
        np.broadcast_to(counts.trials, drawn.shape),
    )
    again = model.proportion(likelihood.fit(model, simulated).theta, simulated.u)
    # The observed data set is one of those that the curve could have given.
    as_far = int((deviance(simulated, again) >= observed - TINY).sum())
    return GoodnessOfFit(
        deviance=observed, p=(1 + as_far) / (1 + simulations), simulations=simulations
    )


def deviance(counts: Counts, proportion: Array) -> Array:
    """Return the deviance of answers from proportions, shape (sets,)."""
    own = counts.log_likelihood(counts.correct / counts.trials)
    return 2 * (own - counts.log_likelihood(proportion))
