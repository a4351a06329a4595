"""Fit a linear mixed model for the exponent, and check whether the fit is reliable."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.json_form import renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY, few
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from statsmodels.regression.mixed_linear_model import MixedLM, MixedLMResults

    from slipscale.analysis.preprocessing.log_transform import Prepared

    #: A fit, its optimiser and its warnings.
    Attempt = tuple[MixedLMResults, str, list[str]]

#: Largest number of participants. With more participants, the fit takes minutes, and the t interval
#: of the slopes gives the same result.
AT_MOST = 200
#: Optimisers of statsmodels, tried until two converge to the same maximum. Each optimiser fails on
#: some data, or reports convergence although another optimiser finds a better fit (on the R
#: reference data, lbfgs stops before it reaches lme4's maximum).
OPTIMISERS = ("bfgs", "lbfgs", "powell")
#: Log likelihoods closer than this value are treated as the same maximum.
SAME_MAXIMUM = 1e-3
#: Gain in log likelihood below which a search that continues another one has ended.
NO_GAIN = 1e-4
#: Diagonal elements of the random effects' Cholesky factor below this value, in residual standard
#: deviations, are treated as being at their bound. lme4's `isSingular` uses 1e-4 by default.
AT_ITS_BOUND = 1e-2
BOUND_SENTENCE = "an estimated variance or correlation is on the boundary of its range"


@dataclass(frozen=True, slots=True, kw_only=True)
class MixedModel:
    """A mixed model of log estimates on log amplitude, with random intercepts and slopes.

    Parameters
    ----------
    intercept, exponent : float
        Fixed effects: the natural logarithm of the normalised estimate at 1 µm peak to peak, and
        the exponent of the power function.
    se : float
        Standard error of the exponent.
    interval : ConfidenceInterval
        t-based interval for the exponent, with n - 1 degrees of freedom.
    sd_intercept, sd_exponent, sd_residual : float
        Standard deviations of the two random effects and of the residual.
    log_likelihood_reml : float
        Restricted log likelihood.
    converged : bool
        Whether the optimiser reported convergence.
    at_bound : bool
        Whether a variance or correlation is at the bound of its range.
    optimiser : str
        Name of the optimiser that found the returned fit.
    warnings : tuple of str
        Warnings that statsmodels issued for the returned fit.
    n, trials : int
        Number of participants, and number of trials above 0 µm.
    """

    intercept: float
    exponent: float
    se: float
    interval: ConfidenceInterval
    sd_intercept: float
    sd_exponent: float
    sd_residual: float
    log_likelihood_reml: float
    converged: bool
    at_bound: bool
    optimiser: str
    warnings: tuple[str, ...]
    n: int
    trials: int

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, interval="ci")


def mixed_model(data: Prepared) -> MixedModel | NotComputed:
    """Fit a linear mixed model of log estimate on log amplitude, with random effects (REML).

    statsmodels fits random intercepts and slopes to trials above 0 µm. Several `OPTIMISERS` are
    tried, and the fit with the highest likelihood is returned. The interval for the slope uses the
    t distribution with n - 1 degrees of freedom. The normal distribution that statsmodels uses
    gives intervals that are too narrow for twelve people. Standard errors of variances are not
    reported, because the values from statsmodels are not usable.
    """
    from scipy import stats

    frame, why = _frame(data)
    if why:
        return NotComputed(why)
    try:
        fit, optimiser, warned = likeliest(frame, "ly ~ lx", "~lx")
    except (np.linalg.LinAlgError, ValueError) as error:
        return NotComputed(f"the model could not be fitted ({error})")
    se = float(fit.bse_fe["lx"])
    centre = _centre(frame)
    spread = fit.cov_re.to_numpy(float)
    at_one_um = np.array([1.0, -centre])
    if not np.isfinite(se):
        return NotComputed("the model could not be fitted (no standard error was obtained)")
    n = frame["who"].nunique()
    slope = float(fit.fe_params["lx"])
    half = float(stats.t.ppf((1 + data.choices.confidence) / 2, n - 1)) * se
    return MixedModel(
        intercept=float(fit.fe_params["Intercept"]) - centre * slope,
        exponent=slope,
        se=se,
        interval=ConfidenceInterval(slope - half, slope + half, data.choices.confidence),
        sd_intercept=float(np.sqrt(max(at_one_um @ spread @ at_one_um, 0.0))),
        sd_exponent=float(np.sqrt(max(spread[1, 1], 0.0))),
        sd_residual=float(np.sqrt(fit.scale)),
        log_likelihood_reml=float(fit.llf),
        converged=bool(fit.converged),
        at_bound=singular(fit),
        optimiser=optimiser,
        warnings=tuple(warned),
        n=n,
        trials=len(frame),
    )


def _frame(data: Prepared) -> tuple[pd.DataFrame, str | None]:
    """Return the data to fit (amplitudes above 0 µm), and the reason if no model can be fitted."""
    trials = data.trials[(data.trials["level"] > 0) & data.trials["log"].notna()]
    frame = pd.DataFrame(
        {
            "ly": trials["log"],
            "lx": np.log(trials["level"]),
            "who": trials[PARTICIPANT],
        }
    )
    n = frame["who"].nunique()
    around = frame["ly"] - frame.groupby("who", observed=True)["ly"].transform("mean")
    reasons: dict[str, bool] = {
        data.zero_sentence: data.refused,
        few("participants", n): n < FEWEST,
        few(f"{data.quantity.levels} above 0", frame["lx"].nunique(), 2): frame["lx"].nunique() < 2,  # noqa: PLR2004
        f"there are {n} participants, but at most {AT_MOST} are supported; for more, use "
        "power_law, whose estimate is the same, with a t interval across participants": n > AT_MOST,
        f"there are at most two estimates above {data.quantity.value(0)} per participant, so "
        "there are no residuals": len(frame) <= 2 * n,
        "the estimates of each participant are all the same": len(frame) > 0
        and float(np.ptp(around)) <= TINY,
    }
    return frame, next((text for text, holds in reasons.items() if holds), None)


def _centre(frame: pd.DataFrame) -> float:
    return float(frame["lx"].mean())


def singular(fit: MixedLMResults) -> bool:
    """Return whether a variance or correlation of the random effects is at its bound."""
    variances, axes = np.linalg.eigh(fit.cov_re.to_numpy(float) / fit.scale)
    factor = np.linalg.qr((axes * np.sqrt(np.clip(variances, 0, None))).T, mode="r")
    return bool(np.abs(np.diag(factor)).min() < AT_ITS_BOUND)


def likeliest(
    frame: pd.DataFrame, fixed: str, random: str
) -> tuple[MixedLMResults, str, list[str]]:
    """Return the fit with the highest likelihood, its optimiser and its statsmodels warnings.

    Parameters
    ----------
    frame : DataFrame
        Data with the columns ``ly``, ``lx`` and ``who``, and any other columns in the formulas.
    fixed, random : str
        Formulas for the fixed effects and for participants' random effects.
    """
    # statsmodels.formula.api is not used, because it loads all of statsmodels, which is slow.
    from statsmodels.regression.mixed_linear_model import MixedLM

    # Without centring, intercept and slope can be so strongly correlated (as with logarithms of
    # nanometres) that an optimiser stops early. Centring does not change the likelihood.
    centred = frame.assign(lx=frame["lx"] - _centre(frame))
    model = MixedLM.from_formula(fixed, centred, groups="who", re_formula=random)
    attempts: list[Attempt] = []
    for optimiser in OPTIMISERS:
        attempts += _attempt(model, optimiser)
        reached = [float(fit.llf) for fit, _, _ in attempts if fit.converged]
        if len(reached) == 2 and abs(reached[0] - reached[1]) < SAME_MAXIMUM:  # noqa: PLR2004
            break
    if not attempts:
        raise ValueError("no optimiser found a likelihood")
    # If the best search ended without convergence, others continue from its end. One that converges
    # can still be short of the maximum, so the next must gain nothing.
    highest, gain = _highest(attempts), 0.0
    for optimiser in OPTIMISERS * 2:
        if highest.converged and gain < NO_GAIN:
            break
        attempts += _attempt(model, optimiser, start=highest.params_object)
        before, highest = highest, _highest(attempts)
        gain = float(highest.llf - before.llf)
    best = [attempt for attempt in attempts if attempt[0].llf > highest.llf - SAME_MAXIMUM]
    return next((attempt for attempt in best if attempt[0].converged), best[0])


def _attempt(model: MixedLM, optimiser: str, start: object = None) -> list[Attempt]:
    """Return the result of one search, or nothing if it failed or diverged."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            fit = model.fit(reml=True, method=[optimiser], start_params=start)
            fit.bse_fe  # noqa: B018 - computed on first use, and it warns
        except np.linalg.LinAlgError:
            return []  # without a standard error; another optimiser may give one
    messages = sorted({str(w.message).splitlines()[0] for w in caught})
    # If an optimiser diverges, it returns no likelihood.
    return [(fit, optimiser, messages)] if np.isfinite(fit.llf) else []


def _highest(attempts: Sequence[Attempt]) -> MixedLMResults:
    return max((fit for fit, _, _ in attempts), key=lambda fit: float(fit.llf))
