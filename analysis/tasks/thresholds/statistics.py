"""Estimate thresholds and Weber fractions from forced choice and constant stimuli."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from slipscale.analysis.reading.task_tables import by_task
from slipscale.analysis.statistics.not_computed import NotComputed, computed, fold
from slipscale.analysis.statistics.psychometrics.goodness_of_fit import (
    GoodnessOfFit,
    goodness_of_fit,
)
from slipscale.analysis.statistics.psychometrics.psychometric_function import (
    Answers,
    Estimate,
    PsychometricFunction,
)
from slipscale.analysis.statistics.psychometrics.thresholds import (
    fit_threshold,
    fit_threshold_by_posterior,
)
from slipscale.analysis.statistics.statistic import Family, Inputs, Named, Statistic
from slipscale.analysis.tasks.effects.groups.statistics import membership
from slipscale.analysis.tasks.thresholds.friction_axis import FrictionThreshold, friction_threshold
from slipscale.analysis.tasks.thresholds.population_threshold import (
    PopulationThreshold,
    population_threshold,
    population_weber,
    weber_fraction,
)
from slipscale.analysis.tasks.thresholds.reading import TRIALS
from slipscale.analysis.tasks.thresholds.reversals import Reversals, reversals
from slipscale.analysis.tasks.thresholds.rules import rules_of
from slipscale.analysis.tasks.thresholds.slopes_by_condition import (
    SlopesByCondition,
    slopes_by_condition,
)
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES, OTHER_AXIS
from slipscale.experiments.protocol_parts.adaptive.interleaved import Interleaved
from slipscale.experiments.study.analysis_choices import AnalysisChoices

#: Curve for comparisons, a function of the amplitude below and above the standard.
COMPARED = "comparison"
CURVE_OF = {COMPARED: "normal"}


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticipantThreshold:
    """The psychometric function of one participant.

    Parameters
    ----------
    participant : str
        Label of the participant.
    trials, correct : int
        Number of main trials, and number answered correctly.
    catch_trials, catch_correct : int
        Number of catch trials, and number answered correctly. Catch trials are not part of this
        fit.
    function : PsychometricFunction or NotComputed
        Posterior medians of threshold and slope, and posterior means of lapse and guess rates.
    weber_fraction : Estimate or NotComputed
        Threshold divided by the standard.
    fit : GoodnessOfFit or NotComputed
        Goodness of fit of the maximum-likelihood function.
    presented_levels : tuple of float
        Lowest and highest level in main trials, µm peak to peak; NaN without trials.
    """

    participant: str
    trials: int
    correct: int
    catch_trials: int
    catch_correct: int
    function: PsychometricFunction | NotComputed
    weber_fraction: Estimate | NotComputed
    fit: GoodnessOfFit | NotComputed
    presented_levels: tuple[float, float]

    @property
    def extrapolated(self) -> bool:
        """Whether the threshold lies outside the presented levels, as of an observer at chance."""
        low, high = self.presented_levels
        found = computed(self.function)
        return found is not None and not low <= found.threshold_level.value <= high


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskThresholds:
    """Results for a forced-choice task.

    Parameters
    ----------
    task : str
        Task label, as in file names.
    method : str
        A key of `slipscale.analysis.statistics.psychometrics.psychometric_function.METHODS`.
    curve : str
        A key of `slipscale.experiments.protocol_parts.adaptive.curves.CURVES`.
    standard_level : float or None
        Level of the standard, µm peak to peak. None for detection tasks, or if trials have
        different standards.
    participants : tuple of ParticipantThreshold
        Results of each participant, in the order of participant names.
    population : PopulationThreshold or NotComputed
        Population threshold or, for a comparison, point of subjective equality.
    weber_fraction : Estimate or NotComputed
        Population threshold divided by the standard. For a comparison, half the distance between
        the 25 % and 75 % points is divided by the standard.
    reversals : Reversals or NotComputed
        Mean levels at the last reversals, if requested in the study file.
    slopes : tuple of SlopesByCondition
        Slopes of comparisons in the conditions of each factor.
    friction : FrictionThreshold or NotComputed
        Population threshold as a change in measured friction, if requested in the study file.
    """

    task: str
    method: str
    curve: str
    standard_level: float | None
    participants: tuple[ParticipantThreshold, ...]
    population: PopulationThreshold | NotComputed
    weber_fraction: Estimate | NotComputed
    reversals: Reversals | NotComputed
    friction: FrictionThreshold | NotComputed
    slopes: tuple[SlopesByCondition, ...] = ()


def thresholds(
    trials: pd.DataFrame,
    choices: AnalysisChoices | None = None,
    *,
    study_text: str = "",
    group_of: Mapping[str, str] | None = None,
) -> tuple[TaskThresholds, ...] | NotComputed:
    """Return the thresholds for each task.

    Parameters
    ----------
    trials : DataFrame
        Result of `slipscale.analysis.tasks.thresholds.reading.read_choices`.
    choices : AnalysisChoices, optional
        Analysis choices of the study: confidence level, curve, threshold share and largest lapse
        rate.
    study_text : str
        Text of the study file, which defines the adaptive rules; empty if unknown.
    group_of : Mapping, optional
        Group of each participant.
    """
    if not len(trials):
        return NotComputed("no trials of forced choice")
    choices = choices or AnalysisChoices()
    rules = rules_of(study_text) if trials["track"].notna().any() else {}
    return tuple(
        _task(task, rows, choices, rules.get(task), group_of) for task, rows in by_task(trials)
    )


def curve_of(method: str, choices: AnalysisChoices) -> str:
    """Return the curve that the study chooses, or the default on the axis that it chooses."""
    curve = choices.threshold_curve or CURVE_OF.get(method, "weibull")
    logarithmic = choices.axis == "logarithmic"
    if choices.axis and CURVES[curve].logarithmic != logarithmic:
        return OTHER_AXIS[curve]
    return curve


def _task(
    task: str,
    rows: pd.DataFrame,
    choices: AnalysisChoices,
    rule: Interleaved | None,
    group_of: Mapping[str, str] | None,
) -> TaskThresholds:
    method = str(rows["method"].iloc[0])
    curve = curve_of(method, choices)
    standards = rows["standard_level"].dropna().unique()
    standard = float(standards[0]) if len(standards) == 1 and standards[0] > 0 else None
    population = population_threshold(rows, choices, method=method, curve=curve, group_of=group_of)
    return TaskThresholds(
        task=task,
        method=method,
        curve=curve,
        standard_level=standard,
        participants=tuple(
            _participant(str(who), own, standard, rule, curve=curve, choices=choices)
            for who, own in rows.groupby(PARTICIPANT, observed=True)
        ),
        population=population,
        weber_fraction=NotComputed("there is no single standard above 0")
        if standard is None
        else fold(population, lambda found: population_weber(found, method, standard), NotComputed),
        reversals=reversals(
            rows[~rows["catch"]], rule, choices.threshold_reversals, choices.confidence
        ),
        friction=friction_threshold(rows, choices, method=method, curve=curve),
        slopes=tuple(
            slopes_by_condition(
                rows[~rows["catch"]], method=method, curve=curve, confidence=choices.confidence
            )
        ),
    )


def _participant(
    who: str,
    rows: pd.DataFrame,
    standard: float | None,
    rule: Interleaved | None,
    *,
    curve: str,
    choices: AnalysisChoices,
) -> ParticipantThreshold:
    method = str(rows["method"].iloc[0])
    catches, main = rows[rows["catch"]], rows[~rows["catch"]]
    function: PsychometricFunction | NotComputed = NotComputed("no main trials")
    fit: GoodnessOfFit | NotComputed = NotComputed("no function was fitted")
    weber: Estimate | NotComputed = NotComputed("no function was fitted")
    if len(main):
        answers = Answers.of_trials(main["track_level"].tolist(), main["correct"].tolist())
        share, confidence = choices.threshold_share, choices.confidence
        function = fit_threshold_by_posterior(
            answers, method=method, curve=curve, share=share, confidence=confidence
        )
        if function:
            likeliest = fit_threshold(answers, method=method, curve=curve, share=share)
            adaptive = bool(main["track"].notna().any())
            fit = _fit(likeliest, function, answers, rule, adaptive=adaptive)
            weber = (
                NotComputed("there is no single standard above 0")
                if standard is None
                else weber_fraction(function, standard)
            )
    return ParticipantThreshold(
        participant=who,
        trials=len(main),
        correct=_correct(main, method),
        catch_trials=len(catches),
        catch_correct=_correct(catches, method),
        function=function,
        weber_fraction=weber,
        fit=fit,
        presented_levels=(float(main["track_level"].min()), float(main["track_level"].max())),
    )


def _fit(
    likeliest: PsychometricFunction | NotComputed,
    function: PsychometricFunction | NotComputed,
    answers: Answers,
    rule: Interleaved | None,
    *,
    adaptive: bool,
) -> GoodnessOfFit | NotComputed:
    """Return the goodness of fit, taking the adaptive rule into account."""
    if isinstance(likeliest, NotComputed):
        return likeliest
    if not adaptive:
        return goodness_of_fit(likeliest, answers)
    if rule is None or isinstance(function, NotComputed):
        return NotComputed(
            "the levels were adapted to the answers by a rule that the data do not record"
        )
    return goodness_of_fit(likeliest, answers, tracks=rule, generating=function)


def _correct(rows: pd.DataFrame, method: str) -> int:
    """Count correct answers, except those to comparisons that are equal to the standard."""
    if method != COMPARED:
        return int(rows["correct"].sum())
    more = rows["track_level"] - rows["standard_level"]
    return int((rows["correct"] & (more > 0)).sum() + (~rows["correct"] & (more < 0)).sum())


def _contrast_ps(found: tuple[TaskThresholds, ...]) -> list[float]:
    return [
        each.p
        for task in found
        if task.population
        for factor in task.population.factors
        for each in factor.contrasts
    ] + [
        each.log_ratio.p
        for task in found
        for factor in task.slopes
        for each in factor.contrasts
        if each.log_ratio
    ]


class _Thresholds(Statistic[tuple[TaskThresholds, ...]]):
    key = "thresholds"
    meaning = "thresholds of forced choice"
    families = (
        Family(
            name="thresholds by group, session and condition", corrected=True, read=_contrast_ps
        ),
    )
    methods = (
        "Thresholds come from psychometric functions with a lapse rate [[wichmann2001]]. The "
        "population threshold comes from a hierarchical model of all participants' answers: "
        "individual thresholds, assumed to be normally distributed on the curve's axis, are "
        "integrated out, as are the logarithms of individual slopes if there is one session and "
        "condition. The lapse rate is shared across participants and also informed by catch "
        "trials. Thresholds for a factor are averaged over the other factors. Intervals are "
        "profile-likelihood intervals with a t quantile. Slopes of comparisons in several "
        "conditions are compared by paired t tests of their logarithms, fitted without lapses, "
        "with Holm's correction. Individual thresholds are posterior medians, with the lapse rate "
        "integrated out."
    )
    conclusions = (
        Named(
            "*.population.factors.*.contrasts.*.p_holm",
            "{0[0]}: thresholds differ between {2[0]} and {2[1]} ({1}, Holm)",
        ),
        Named("*.slopes.*.contrasts.*.p_holm", "{0[0]}: slopes differ ({1}, Holm)"),
    )
    headlines = (
        Named("*.population.threshold_level.value", "{0[0]}: threshold, {q.unit_in_short}"),
        Named("*.population.sd", "{0[0]}: SD across participants, log10 units"),
        Named("*.weber_fraction.value", "{0[0]}: Weber fraction"),
    )

    def compute(self, inputs: Inputs) -> tuple[TaskThresholds, ...] | NotComputed:
        groups = computed(membership(inputs.data))
        return thresholds(
            inputs.data.of(TRIALS),
            inputs.data.choices,
            study_text=inputs.data.study_text,
            group_of={} if groups is None else {str(who): group for who, group in groups.items()},
        )


THRESHOLDS = _Thresholds()
