"""Fit a simulated population to a data set; parameters that cannot be fitted keep their defaults.

Estimates are normalised to 0-100 as in the analysis. At each amplitude, the mid-ranks of the
estimates are converted to standard normal deviates. Their variance is divided into differences
between trials, between people's intercepts, and between people's exponents. The correlation between
deviates at distant amplitudes separates intercepts from exponents.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from slipscale.analysis.preprocessing.data_quality import TRIALS_FOR_DRIFT
from slipscale.analysis.preprocessing.sufficiency import FEWEST
from slipscale.analysis.tasks.estimation.statistics import ORDER
from slipscale.analysis.tasks.kind import Analysis
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.participants.simulated_people.habits import ROUND_TO_PERCENT
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.faults import UserError

#: Smallest proportion of the variance for each component, because a proportion of 0 is unrealistic.
LEAST_SHARE = 0.02
#: Probability that an estimate is a multiple of 5 % of the scale by chance.
ROUND_BY_CHANCE = 1 / ROUND_TO_PERCENT


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedPopulation:
    """A fitted population, with the source of each parameter.

    Parameters
    ----------
    population : Population
    fitted : Mapping
        Description of the data from which each parameter was estimated, keyed by field name.
    assumed : tuple of str
        Fields that the data do not determine; they keep the shipped defaults.
    """

    population: Population
    fitted: Mapping[str, str]
    assumed: tuple[str, ...]

    @property
    def sentences(self) -> tuple[str, ...]:
        """One line per fitted parameter, and one line with all assumed parameters."""
        values = self.population.model_dump()
        lines = [
            f"fitted   {name} = {_shown(_value(values, name))}, from {source}"
            for name, source in self.fitted.items()
        ]
        return (*lines, f"assumed  default values of {', '.join(self.assumed)}")


def fit_population(analysis: Analysis) -> FittedPopulation:
    """Fit a population to a data set's analysis.

    Raises
    ------
    UserError
        If there are fewer than three participants or fewer than two amplitudes, if a mean estimate
        is not between 0 and 100, or if all participants have the same estimate at an amplitude.
    """
    cells = analysis.cells.dropna()
    name = analysis.dataset.name
    if len(cells) < FEWEST or cells.shape[1] < 2:  # noqa: PLR2004
        raise UserError(
            "--from {name}: {people} people with an estimate at each of {amplitudes} "
            "amplitudes; expected at least {fewest} people and 2 amplitudes",
            name=name,
            people=len(cells),
            amplitudes=cells.shape[1],
            fewest=FEWEST,
        )
    mean, sd = cells.mean().to_numpy(float), cells.std(ddof=1).to_numpy(float)
    if (mean <= 0).any() or (mean >= 100).any() or (sd <= 0).any():  # noqa: PLR2004
        raise UserError(
            "--from {name}: with the normalisation '{rule}', mean estimates range from "
            "{lowest_mean:.3g} to {highest_mean:.3g}, and the smallest standard deviation "
            "between people is {lowest_sd:.3g}; expected means between 0 and 100 and standard "
            "deviations above 0, as with --normalise scale_top or grand_maximum",
            name=name,
            rule=analysis.rule,
            lowest_mean=mean.min(),
            highest_mean=mean.max(),
            lowest_sd=sd.min(),
        )
    found: dict[str, Any] = {
        "amplitude_um_pp": tuple(cells.columns.to_numpy(float).tolist()),
        "mean_sensation": tuple(np.round(mean, 4).tolist()),
        "sd_sensation": tuple(np.round(sd, 4).tolist()),
    }
    origins = dict.fromkeys(found, f"{len(cells)} people, normalised by {analysis.rule}")
    trials = analysis.estimates[analysis.estimates[PARTICIPANT].isin(cells.index)]
    for fit in FITS:
        values, source = fit(analysis, trials, found)
        found |= values
        origins |= dict.fromkeys(values, source)
    habits = {key.partition(".")[2]: found.pop(key) for key in list(found) if "." in key}
    population = Population.model_validate({"name": f"fitted to {name}", **found, "habits": habits})
    # `levels` is never assumed: `origins` lists it as `amplitude_um_pp`.
    every = set(Population.model_fields) - {"name", "habits", "levels"}
    return FittedPopulation(
        population=population, fitted=origins, assumed=tuple(sorted(every - set(origins)))
    )


Fit = tuple[dict[str, "Any"], str]


def _variance(_: Analysis, trials: pd.DataFrame, found: Mapping[str, Any]) -> Fit:
    """Estimate the variance between people and, if trials are repeated, between trials."""
    deviates = _deviates(trials)
    who, what = trials[PARTICIPANT].astype(str), trials["level"]
    cells = deviates.groupby([who, what]).mean().unstack()  # noqa: PD010 - the index is made
    counts = deviates.groupby([who, what]).count().to_numpy()
    values: dict[str, Any] = {}
    trial = Population().trial_to_trial
    if (counts > 1).all():
        within = deviates - deviates.groupby([who, what]).transform("mean")
        trial = float((within**2).sum() / (counts - 1).sum() / deviates.var())
        trial = float(np.clip(trial, LEAST_SHARE, 1 - LEAST_SHARE))
        values["trial_to_trial"] = round(trial, 4)
    observed = np.corrcoef(cells.to_numpy(float), rowvar=False)
    # Averaging trials reduces only the trial component; correlations come from the person's
    # component.
    steady = (1 - trial) / (1 - trial + trial / counts.mean())
    shares = np.linspace(LEAST_SHARE, 1 - LEAST_SHARE, 97) * (1 - trial)
    misfit = [
        ((observed - np.cos(_angles(found, share, trial)) * steady) ** 2)[
            ~np.eye(len(observed), dtype=bool)
        ].sum()
        for share in shares
    ]
    values["shared"] = round(float(shares[int(np.argmin(misfit))]), 4)
    return values, "correlations of deviations at different amplitudes, between and within people"


def _angles(found: Mapping[str, Any], shared: float, trial: float) -> np.ndarray:
    known = {name: found[name] for name in ("amplitude_um_pp", "mean_sensation", "sd_sensation")}
    people = Population(**known, shared=shared, trial_to_trial=trial)
    turned = np.array([people.angle(amplitude) for amplitude in people.levels])
    return np.asarray(turned[:, None] - turned)


def _deviates(trials: pd.DataFrame) -> pd.Series[float]:
    """Rank the estimates at each amplitude, and convert the ranks to standard normal deviates."""
    from scipy.special import ndtri

    by = trials.groupby("level", observed=True)["normalised"]
    ranks, counts = by.rank(), by.transform("count")
    places: pd.Series[float] = ((ranks - 0.5) / counts).map(lambda share: float(ndtri(share)))
    return places


def _times(_: Analysis, trials: pd.DataFrame, _found: Mapping[str, Any]) -> Fit:
    times = trials[trials["response_time"] > 0]
    by = np.log(times["response_time"]).groupby(times[PARTICIPANT].astype(str))
    if len(by) < FEWEST or by.count().min() < FEWEST:
        return {}, ""
    means, within = by.mean(), by.std(ddof=1)
    error = (within**2 / by.count()).mean()
    return {
        "answer_s": round(float(np.exp(means.median())), 4),
        "answer_sigma": round(float(np.sqrt((within**2).mean())), 4),
        "pace_sigma": round(float(np.sqrt(max(means.var(ddof=1) - error, 0.0))), 4),
    }, "response times"


def _tops(_: Analysis, trials: pd.DataFrame, _found: Mapping[str, Any]) -> Fit:
    tops = trials.groupby(trials[PARTICIPANT].astype(str))["scale_top"].first()
    if not (tops > 0).all():
        return {}, ""
    return {"scale_tops": tuple(sorted(tops.astype(float).tolist()))}, "declared scale tops"


def _rounding(_: Analysis, trials: pd.DataFrame, _found: Mapping[str, Any]) -> Fit:
    if not (trials["scale_top"] > 0).all():
        return {}, ""
    hundredths = 100 * trials["estimate"] / trials["scale_top"]
    steps = hundredths / ROUND_TO_PERCENT
    share = float((np.abs(steps - steps.round()) < 1e-6).mean())  # noqa: PLR2004 - floats
    excess = (share - ROUND_BY_CHANCE) / (1 - ROUND_BY_CHANCE)
    return {"habits.rounding": round(max(excess, 0.0), 4)}, (
        f"the proportion of estimates that are round numbers ({share:.0%})"
    )


def _order(analysis: Analysis, trials: pd.DataFrame, _found: Mapping[str, Any]) -> Fit:
    order = analysis.inference[ORDER]
    each = trials.groupby(trials[PARTICIPANT].astype(str)).size()
    # With few trials, an order effect is not fitted, even if its interval excludes 0.
    if not order or each.min() < TRIALS_FOR_DRIFT:
        return {}, ""
    values: dict[str, Any] = {}
    drift, before = order.log_slope_per_trial, order.log_slope_per_level_before
    if before and not before.interval.low < 0 < before.interval.high:
        values["habits.carry_over"] = round(before.mean, 4)
    if drift and drift.interval.high < 0:
        values["habits.fatigue"] = round(min(-drift.mean, 0.1), 4)
    return values, "order effects whose interval excludes 0"


#: Functions that each fit some parameters of a population, and describe the data used.
FITS: tuple[Callable[[Analysis, pd.DataFrame, Mapping[str, Any]], Fit], ...] = (
    _variance,
    _times,
    _tops,
    _rounding,
    _order,
)


def _value(values: Mapping[str, Any], name: str) -> object:
    field, _, habit = name.partition(".")
    return values[field][habit] if habit else values[field]


def _shown(value: object) -> str:
    if isinstance(value, tuple | list):
        return ", ".join(f"{each:g}" for each in value)
    return f"{value:g}"
