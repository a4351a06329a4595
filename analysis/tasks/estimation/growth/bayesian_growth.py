"""Fit a hierarchical Bayesian power function, which shrinks exponents towards the group mean.

The extra ``slipscale[bayes]`` is required. For the model, see `hierarchical_sampler`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.json_form import renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, few
from slipscale.analysis.statistics.arrays import Array
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.regression import fit_lines
from slipscale.analysis.tasks.estimation.growth.hierarchical_sampler import (
    SEED,
    Draws,
    Trials,
    sample,
)
from slipscale.experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from slipscale.analysis.preprocessing.log_transform import Prepared

PREDICTIONS = 400  # number of data sets drawn from the posterior for the checks
#: Chains agree if the potential scale reduction is below this limit (Vehtari et al. 2021, Bayesian
#: Anal. 16, 667-718).
LARGEST_R_HAT = 1.01
#: Largest number of participants. In larger studies, shrinkage is small and sampling takes minutes.
AT_MOST = 500


@dataclass(frozen=True, slots=True, kw_only=True)
class IndividualExponent:
    """The exponent of a participant, by least squares and from the model.

    Parameters
    ----------
    participant : str
        Label of the participant.
    least_squares : float
        Least-squares exponent of the participant's trials, or NaN if they have only one amplitude.
    exponent, interval : float, ConfidenceInterval
        Posterior mean, shrunk towards the group, and its credible interval.
    """

    participant: str
    least_squares: float
    exponent: float
    interval: ConfidenceInterval

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, interval="ci")


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictiveCheck:
    """Posterior predictive check of one statistic of the data.

    Parameters
    ----------
    observed, predicted : float
        Statistic in the observed data, and its mean across predicted data sets.
    p : float
        Proportion of predicted data sets in which the statistic is at least as large as observed. A
        value near 0 or 1 means that the model does not reproduce this aspect of the data.
    """

    observed: float
    predicted: float
    p: float


@dataclass(frozen=True, slots=True, kw_only=True)
class BayesianGrowth:
    """The posterior of the hierarchical power function.

    Parameters
    ----------
    exponent, interval : float, ConfidenceInterval
        Posterior mean of the group exponent B, and its equal-tailed credible interval.
    sd_exponent, sd_exponent_interval : float, ConfidenceInterval
        Posterior mean of the standard deviation tb of participants' exponents, and its credible
        interval.
    sd_residual : float
        Posterior mean of the standard deviation s of a single log estimate.
    individuals : tuple of IndividualExponent
        Exponent of each participant, in the order of participant names.
    shrinkage : float
        Shrinkage of exponents towards the group, from 0 (none) to 1 (complete): 1 minus the slope
        of the model's exponents on the least-squares exponents.
    checks : Mapping
        Posterior predictive checks by name. ``curvature`` describes deviations from a straight line
        in log-log coordinates; ``largest_residual`` and ``kurtosis`` describe outliers;
        ``spread_ratio`` is the spread of the residuals at the largest stimulus relative to the
        smallest.
    r_hat : float
        Largest potential scale reduction factor of any parameter.
    effective_draws : int
        Smallest effective sample size of any parameter.
    divergences : int
        Number of divergent transitions.
    n, trials : int
        Number of participants, and number of trials with a stimulus above 0.
    """

    exponent: float
    interval: ConfidenceInterval
    sd_exponent: float
    sd_exponent_interval: ConfidenceInterval
    sd_residual: float
    individuals: tuple[IndividualExponent, ...]
    shrinkage: float
    checks: Mapping[str, PredictiveCheck]
    r_hat: float
    effective_draws: int
    divergences: int
    n: int
    trials: int

    @property
    def converged(self) -> bool:
        """Whether the chains agree and the sampler had no divergences."""
        return self.r_hat < LARGEST_R_HAT and self.divergences == 0

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, interval="ci", sd_exponent_interval="sd_exponent_ci")


def bayesian_growth(data: Prepared) -> BayesianGrowth | NotComputed:
    """Draw from the posterior of the hierarchical power function, using NumPyro.

    Raises
    ------
    ModuleNotFoundError
        The extra ``bayes`` is not installed.
    """
    trials = _trials(data)
    if isinstance(trials, NotComputed):
        return trials
    draws = sample(trials)
    return _summary(trials, draws, data.choices.confidence)


def _trials(data: Prepared) -> Trials | NotComputed:
    if data.refused:
        return NotComputed(data.zero_sentence)
    rows = data.trials[(data.trials["level"] > 0) & data.trials["log"].notna()]
    people = rows[PARTICIPANT].astype("category").cat.remove_unused_categories()
    log_x = np.log(rows["level"].to_numpy(float))
    log_y = rows["log"].to_numpy(float)
    names = tuple(str(name) for name in people.cat.categories)
    reasons = {
        few("participants", len(names)): len(names) < FEWEST,
        few(f"{data.quantity.levels} above 0", len(np.unique(log_x)), 2): len(np.unique(log_x)) < 2,  # noqa: PLR2004
        f"there are {len(names)} participants, but at most {AT_MOST} are supported": len(names)
        > AT_MOST,
        f"there are at most two estimates above {data.quantity.value(0)} per participant, so "
        "there are no residuals": len(rows) <= 2 * len(names),
    }
    if why := next((text for text, holds in reasons.items() if holds), None):
        return NotComputed(why)
    return Trials(
        log_y=log_y - log_y.mean(),
        log_x=log_x - log_x.mean(),
        who=np.asarray(people.cat.codes, np.int64),
        names=names,
    )


def _summary(trials: Trials, draws: Draws, confidence: float) -> BayesianGrowth:
    from numpyro import diagnostics

    values = draws.values
    judged = [values[name] for name in ("A", "B", "ta", "tb", "s", "half_r", "own")]
    r_hat = max(float(np.max(diagnostics.split_gelman_rubin(each))) for each in judged)
    effective = min(float(np.min(diagnostics.effective_sample_size(each))) for each in judged)

    def interval(drawn: Array) -> ConfidenceInterval:
        tail = (1 - confidence) / 2
        low, high = np.quantile(drawn, [tail, 1 - tail])
        return ConfidenceInterval(float(low), float(high), confidence)

    own = values["own"][..., 1].reshape(-1, len(trials.names))
    alone = _least_squares(trials)
    known = np.isfinite(alone)
    kept = own.mean(axis=0)
    return BayesianGrowth(
        exponent=float(values["B"].mean()),
        interval=interval(values["B"]),
        sd_exponent=float(values["tb"].mean()),
        sd_exponent_interval=interval(values["tb"]),
        sd_residual=float(values["s"].mean()),
        individuals=tuple(
            IndividualExponent(
                participant=name,
                least_squares=float(alone[place]),
                exponent=float(kept[place]),
                interval=interval(own[:, place]),
            )
            for place, name in enumerate(trials.names)
        ),
        shrinkage=float(np.clip(1 - fit_lines(alone[known], kept[known]).slope, 0, 1)),
        checks=predictive_checks(trials, draws),
        r_hat=r_hat,
        effective_draws=int(effective),
        divergences=draws.divergences,
        n=len(trials.names),
        trials=len(trials.log_y),
    )


def _least_squares(trials: Trials) -> Array:
    slopes = [
        fit_lines(trials.log_x[trials.who == i], trials.log_y[trials.who == i]).slope
        for i in range(len(trials.names))
    ]
    return np.array(slopes, float)


def predictive_checks(trials: Trials, draws: Draws) -> dict[str, PredictiveCheck]:
    """Compare residual statistics of the observed data with those of predicted data sets.

    Residuals are computed from the participants' lines in the same posterior draw (realised
    discrepancies; Gelman, Meng and Stern 1996, Statistica Sinica 6, 733-807).
    """
    rng = np.random.default_rng(SEED)
    own = draws.values["own"].reshape(-1, len(trials.names), 2)
    sd = draws.values["s"].reshape(-1)
    chosen = rng.choice(len(sd), min(PREDICTIONS, len(sd)), replace=False)
    lines = own[chosen][:, trials.who, 0] + own[chosen][:, trials.who, 1] * trials.log_x
    observed = (trials.log_y - lines) / sd[chosen, None]
    predicted = rng.standard_normal(observed.shape)
    found = {}
    for name, statistic in STATISTICS.items():
        seen, drawn = statistic(observed, trials.log_x), statistic(predicted, trials.log_x)
        found[name] = PredictiveCheck(
            observed=float(seen.mean()),
            predicted=float(drawn.mean()),
            p=float((drawn >= seen).mean()),
        )
    return found


def _curvature(z: Array, log_x: Array) -> Array:
    """Return the coefficient of (log x)² after removing any linear component."""
    design = np.stack([np.ones_like(log_x), log_x], axis=1)
    square = log_x**2
    bend = square - design @ np.linalg.lstsq(design, square, rcond=None)[0]
    size = (bend**2).sum()
    # Two stimuli cannot show curvature.
    return np.asarray(z @ bend / size if size > len(bend) * 1e-12 else np.zeros(len(z)))


def _spread_ratio(z: Array, log_x: Array) -> Array:
    return np.asarray(
        z[:, log_x == log_x.max()].std(axis=1) / z[:, log_x == log_x.min()].std(axis=1)
    )


#: Name of a posterior predictive check -> statistic of standardised residuals.
STATISTICS = {
    "curvature": _curvature,
    "largest_residual": lambda z, _: np.abs(z).max(axis=1),
    "kurtosis": lambda z, _: (z**4).mean(axis=1),
    "spread_ratio": _spread_ratio,
}
