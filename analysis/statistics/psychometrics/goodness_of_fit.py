"""How well a psychometric function fits its answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY, few
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics import psychometric_fit as likelihood
from slipscale.analysis.statistics.psychometrics.psychometric_fit import Counts
from slipscale.analysis.statistics.psychometrics.psychometric_function import Answers
from slipscale.analysis.statistics.psychometrics.thresholds import (
    LARGEST_LAPSE,
    counts_of,
    model_of,
    side_by_side,
)
from slipscale.experiments.protocols.adaptive.simulated_runs import simulated_runs

if TYPE_CHECKING:
    from slipscale.analysis.statistics.psychometrics.psychometric_fit import Array
    from slipscale.analysis.statistics.psychometrics.psychometric_function import (
        PsychometricFunction,
    )
    from slipscale.experiments.protocols.adaptive.interleaved import Interleaved


#: Simulated runs of an adaptive rule.
RUNS = 200


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
    tracks: Interleaved | None = None,
    generating: PsychometricFunction | None = None,
    largest_lapse: float = LARGEST_LAPSE,
    simulations: int = 1000,
    seed: int = 2001,
) -> GoodnessOfFit | NotComputed:
    """Test a curve by its deviance, against data sets simulated from it and fitted anew.

    Wichmann and Hill 2001, Percept. Psychophys. 63, 1293-1313: with few answers per level the
    deviance is not chi-square distributed, so its distribution is simulated. If an adaptive rule
    chose the levels, each simulated data set has the levels that the rule gives it, from the
    posterior's curve: few adaptive answers make the likeliest curve too steep, and data simulated
    from it too regular. Of 80 runs of a staircase of 60 trials 5 had p < .05 this way, 9 from the
    likeliest curve; at the observed levels 21 of 100.

    Parameters
    ----------
    fitted : PsychometricFunction
        `fit_threshold`'s, with the same ``largest_lapse``.
    tracks : Interleaved, optional
        The rule that chose the levels, before its first trial; default: they were fixed. The
        number of simulations is then at most `RUNS`, and ``generating`` is needed.
    generating : PsychometricFunction, optional
        `fit_threshold_by_posterior`'s of the same answers.
    """
    repeated = int((answers.trials > 1).sum())
    needed = FEWEST + 1
    if repeated < needed:
        return NotComputed(few("levels with more than one answer", repeated, needed))
    model = model_of(fitted.method, fitted.curve, fitted.share, largest_lapse)
    counts = counts_of(answers, model)
    proportion = fitted.proportion(answers.levels_um_pp)
    observed = float(deviance(counts, proportion[None])[0])
    rng = np.random.default_rng(seed)
    if tracks is None or generating is None:
        drawn = rng.binomial(
            answers.trials.astype(int),
            np.clip(proportion, 0, 1),
            size=(simulations, proportion.size),
        )
        simulated = Counts(
            np.broadcast_to(counts.u, drawn.shape),
            drawn.astype(float),
            np.broadcast_to(counts.trials, drawn.shape),
        )
    else:
        simulations = min(simulations, RUNS)
        runs = simulated_runs(tracks, generating.proportion, simulations, rng)
        simulated = side_by_side(
            [counts_of(Answers.of_trials(*map(list, run)), model) for run in runs]
        )
    again = model.proportion(likelihood.fit(model, simulated).theta, simulated.u)
    # The observed data set is one of those that the curve could have given.
    as_far = int((deviance(simulated, again) >= observed - TINY).sum())
    return GoodnessOfFit(
        deviance=observed, p=(1 + as_far) / (1 + simulations), simulations=simulations
    )


def deviance(counts: Counts, proportion: Array) -> Array:
    """Return the deviance of answers from proportions, shape (sets,)."""
    # A level without answers, which only fills a row, has no deviance.
    own = counts.log_likelihood(counts.correct / np.maximum(counts.trials, 1))
    return 2 * (own - counts.log_likelihood(proportion))
