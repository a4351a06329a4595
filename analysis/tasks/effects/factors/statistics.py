"""Analyse the effect of factors, such as speed or force, on magnitude estimates.

A factor is a column declared in ``[[factors]]`` of the study file or with the option ``--factor``.
Each factor is analysed together with the level, averaged over the other factors. There are three
analyses, with increasingly strong assumptions: t-based intervals for participants' changes in
exponent and in level; an analysis of variance of the participants with complete data; and a mixed
model of all trials, in which intercept, exponent and condition effects differ between participants.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from slipscale.analysis.json_form import renamed
from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.preprocessing.normalisation import cell_means
from slipscale.analysis.preprocessing.sufficiency import FEWEST, few
from slipscale.analysis.reading.surface_labels import numbers_first
from slipscale.analysis.reading.trial_tables import FACTOR, factor_columns
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    holm_of,
    mean_over_participants,
)
from slipscale.analysis.statistics.mixed_model import AT_MOST, likeliest, singular
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.power_law import exponents
from slipscale.analysis.statistics.repeated_measures.two_way import Effect, two_way
from slipscale.analysis.statistics.statistic import Family, Inputs, Named, Statistic
from slipscale.experiments.dataset.schema import PARTICIPANT

#: Term of the mixed model for each difference between conditions.
TERMS = {"exponent": "lx:condition", "log_ratio": "condition"}


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedEffect:
    """A fixed effect in the mixed model, with a t-based interval (n - 1 degrees of freedom)."""

    value: float
    se: float
    interval: ConfidenceInterval
    p: float

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, interval="ci")


@dataclass(frozen=True, slots=True, kw_only=True)
class MixedFit:
    """Properties of the fitted mixed model.

    ``at_bound`` is True if a variance or correlation is at its bound, which means that the fit is
    singular. ``converged`` is False if no optimiser reported convergence.
    """

    log_likelihood_reml: float
    converged: bool
    at_bound: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionChange:
    """Comparison of a condition with the first condition.

    Parameters
    ----------
    condition : str
    exponent : MeanOverParticipants or NotComputed
        Mean change in participants' exponents from the first condition.
    log_ratio : MeanOverParticipants or NotComputed
        Mean difference in log estimates from the first condition, at the levels that a participant
        judged in both conditions.
    exponent_p_holm, log_ratio_p_holm : float or None
        p-values, Holm-corrected across the conditions of the factor.
    mixed_exponent, mixed_log_ratio : FixedEffect or NotComputed
        Differences estimated by the mixed model. The log ratio is the difference in log estimates
        at the mean log level.
    """

    condition: str
    exponent: MeanOverParticipants | NotComputed
    log_ratio: MeanOverParticipants | NotComputed
    exponent_p_holm: float | None = None
    log_ratio_p_holm: float | None = None
    mixed_exponent: FixedEffect | NotComputed
    mixed_log_ratio: FixedEffect | NotComputed


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionMeans:
    """Geometric means of a condition and their numbers of participants, keyed by level."""

    condition: str
    n: int
    geometric_means: Mapping[float, float]
    ns: Mapping[float, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoWay:
    """Analysis of variance by factor and level.

    Parameters
    ----------
    n : int
        Number of participants who have an estimate for every level in every condition.
    factor, amplitude, interaction : Effect
        Effects with Greenhouse-Geisser-corrected degrees of freedom.
    """

    n: int
    factor: Effect
    of_level: Effect
    interaction: Effect

    @property
    def effects(self) -> tuple[Effect, Effect, Effect]:
        """Effects of factor, level and interaction, in the row order of the report's table."""
        return self.factor, self.of_level, self.interaction


@dataclass(frozen=True, slots=True, kw_only=True)
class FactorEffects:
    """The effects of one factor."""

    factor: str
    conditions: tuple[ConditionMeans, ...]
    anova: TwoWay | NotComputed
    mixed: MixedFit | NotComputed
    changes: tuple[ConditionChange, ...]


def factor_effects(inputs: Inputs) -> tuple[FactorEffects, ...] | NotComputed:
    """Return the effects of all factors, or the reason why they could not be computed."""
    prepared = inputs.prepared
    if prepared is None:
        return NotComputed("no magnitude estimates")
    named = factor_columns(prepared.trials)
    crossed = [name for name in named if len(prepared.trials[name].unique()) > 1]
    if not crossed:
        return NotComputed("no factor is crossed with the levels")
    if prepared.refused:
        return NotComputed(prepared.zero_sentence)
    confidence = inputs.data.choices.confidence
    return tuple(_of_factor(prepared, name, confidence) for name in crossed)


def _of_factor(prepared: Prepared, column: str, confidence: float) -> FactorEffects:
    conditions = prepared.trials[column].astype(str)
    logs = {
        label: cell_means(prepared.trials[conditions == label], "log").reindex(
            columns=prepared.logged
        )
        for label in sorted(conditions.unique(), key=numbers_first)
    }
    whole = pd.concat(logs, axis=1).dropna()
    mixed = _mixed(prepared, conditions, list(logs), confidence)
    effects = two_way(whole, confidence, f"every {prepared.quantity.level} in every condition")
    return FactorEffects(
        factor=column.removeprefix(FACTOR),
        conditions=tuple(
            ConditionMeans(
                condition=label,
                n=len(table),
                geometric_means=dict(
                    zip(prepared.logged, np.exp(table.mean()).tolist(), strict=True)
                ),
                ns=dict(zip(prepared.logged, table.notna().sum().tolist(), strict=True)),
            )
            for label, table in logs.items()
        ),
        anova=effects
        if isinstance(effects, NotComputed)
        else TwoWay(n=len(whole), factor=effects[0], of_level=effects[1], interaction=effects[2]),
        mixed=mixed if isinstance(mixed, NotComputed) else mixed[0],
        changes=_changes(logs, mixed if isinstance(mixed, NotComputed) else mixed[1], confidence),
    )


def _changes(
    logs: Mapping[str, pd.DataFrame],
    mixed: Mapping[tuple[str, str], FixedEffect] | NotComputed,
    confidence: float,
) -> tuple[ConditionChange, ...]:
    first, *others = logs
    slopes = {label: exponents(table)["exponent"] for label, table in logs.items()}
    found = []
    for label in others:
        # Levels that a participant judged in both conditions.
        ratio = (logs[label] - logs[first]).mean(axis=1).dropna()
        steeper = (slopes[label] - slopes[first]).dropna()
        by_model = [
            mixed if isinstance(mixed, NotComputed) else mixed[label, what] for what in TERMS
        ]
        found.append(
            ConditionChange(
                condition=label,
                exponent=mean_over_participants(steeper.to_numpy(float), confidence),
                log_ratio=mean_over_participants(ratio.to_numpy(float), confidence),
                mixed_exponent=by_model[0],
                mixed_log_ratio=by_model[1],
            )
        )
    exponent_ps = holm_of([each.exponent for each in found])
    ratio_ps = holm_of([each.log_ratio for each in found])
    return tuple(
        replace(each, exponent_p_holm=exponent_p, log_ratio_p_holm=ratio_p)
        for each, exponent_p, ratio_p in zip(found, exponent_ps, ratio_ps, strict=True)
    )


def mixed_changes(prepared: Prepared, factor: str) -> Mapping[tuple[str, str], FixedEffect]:
    """Return the mixed model's changes from a factor's first level, by level and key of `TERMS`.

    The mapping is empty if the model cannot be fitted.
    """
    conditions = prepared.trials[f"{FACTOR}{factor}"].astype(str)
    labels = sorted(conditions.unique(), key=numbers_first)
    found = _mixed(prepared, conditions, labels, prepared.choices.confidence)
    return {} if isinstance(found, NotComputed) else found[1]


def _mixed(
    prepared: Prepared, conditions: pd.Series[str], labels: list[str], confidence: float
) -> tuple[MixedFit, Mapping[tuple[str, str], FixedEffect]] | NotComputed:
    """Fit ``ly ~ lx * condition`` by REML, with random effects of lx and condition."""
    from scipy import stats

    usable = (prepared.trials["level"] > 0) & prepared.trials["log"].notna()
    rows = prepared.trials[usable]
    frame = pd.DataFrame(
        {
            "ly": rows["log"],
            "lx": np.log(rows["level"]),
            "who": rows[PARTICIPANT].astype(str),
            "condition": pd.Categorical(conditions[usable], labels),
        }
    )
    n, levels = frame["who"].nunique(), frame["lx"].nunique()
    reasons = {
        few("participants", n): n < FEWEST,
        f"there are {n} participants, but at most {AT_MOST} can be fitted": n > AT_MOST,
        few(f"{prepared.quantity.levels} above 0", levels, 2): levels < 2,  # noqa: PLR2004
        "there are too few trials per participant for residuals": len(frame) <= 2 * len(labels) * n,
    }
    if why := next((text for text, holds in reasons.items() if holds), ""):
        return NotComputed(why)
    try:
        fit, _, _ = likeliest(frame, "ly ~ lx * condition", "~ lx + condition")
    except (np.linalg.LinAlgError, ValueError) as error:
        return NotComputed(f"the model could not be fitted ({error})")
    quantile = float(stats.t.ppf((1 + confidence) / 2, n - 1))
    found = {}
    for label in labels[1:]:
        for what, term in TERMS.items():
            name = f"{term}[T.{label}]"
            value, se = float(fit.fe_params[name]), float(fit.bse_fe[name])
            if not np.isfinite(se):
                return NotComputed("the model could not be fitted (no standard error was obtained)")
            ends = ConfidenceInterval(value - quantile * se, value + quantile * se, confidence)
            p = float(2 * stats.t.sf(abs(value / se), n - 1))
            found[label, what] = FixedEffect(value=value, se=se, interval=ends, p=p)
    properties = MixedFit(
        log_likelihood_reml=float(fit.llf), converged=bool(fit.converged), at_bound=singular(fit)
    )
    return properties, found


def _anova_ps(found: tuple[FactorEffects, ...]) -> list[float]:
    return [p for each in found if each.anova for p in _ps(each.anova)]


def _ps(anova: TwoWay) -> tuple[float, float]:
    return anova.factor.p, anova.interaction.p


def _change_ps(found: tuple[FactorEffects, ...]) -> list[float]:
    changes = [change for each in found for change in each.changes]
    parts = [part for each in changes for part in (each.exponent, each.log_ratio)]
    return [part.p for part in parts if isinstance(part, MeanOverParticipants)]


class _Factors(Statistic[tuple[FactorEffects, ...]]):
    key = "factors"
    meaning = (
        "factors crossed with the levels: analysis of variance, changes between conditions, "
        "and mixed model"
    )
    title = "Factors"
    families = (
        Family(name="factors, analysis of variance", read=_anova_ps),
        Family(name="changes between conditions", corrected=True, read=_change_ps),
    )
    methods = (
        "Each factor was tested together with {q.name} in a within-participant analysis of "
        "variance of mean log estimates with the Greenhouse–Geisser correction [[greenhouse1959]]. "
        "Each other condition was compared with the first condition by t tests of participants' "
        "differences in mean log estimate and in exponent, with Holm's correction [[holm1979]]. A "
        "mixed model of all trials, in which the intercept, exponent and condition effects vary "
        "between participants, was fitted by restricted maximum likelihood [[laird1982]]."
    )
    conclusions = (
        Named("*.anova.factor.p", "{0} conditions differ (analysis of variance)"),
        Named("*.anova.interaction.p", "growth differs between {0} conditions"),
    )

    compute = staticmethod(factor_effects)


FACTORS = _Factors()
