"""Thresholds by forced choice and constant stimuli: participants', the population's, Weber's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.preprocessing.sufficiency import FEWEST, few
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.goodness_of_fit import (
    GoodnessOfFit,
    goodness_of_fit,
)
from slipscale.analysis.statistics.psychometrics.psychometric_function import (
    Answers,
    Estimate,
    PsychometricFunction,
    estimate,
)
from slipscale.analysis.statistics.psychometrics.thresholds import (
    fit_threshold,
    fit_threshold_by_posterior,
    fit_threshold_by_psignifit,
)
from slipscale.analysis.statistics.statistic import Statistic
from slipscale.analysis.tasks.thresholds.population_threshold import (
    PopulationThreshold,
    population_threshold,
    weber_fraction,
)
from slipscale.analysis.tasks.thresholds.reading import TRIALS
from slipscale.analysis.tasks.thresholds.rules import rules_of
from slipscale.experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd

    from slipscale.experiments.protocols.adaptive.interleaved import Interleaved

#: A comparison's curve runs over the amplitude itself: it lies below and above the standard.
COMPARED = "comparison"
CURVE_OF = {COMPARED: "normal"}


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticipantThreshold:
    """One participant's psychometric function.

    Parameters
    ----------
    participant : str
        Who.
    trials, correct : int
        Main trials of the plan or rule, and those answered correctly.
    catch_trials, catch_correct : int
        Trials that show whether attention holds; not part of the fit.
    function : PsychometricFunction or NotComputed
        Medians of a posterior, lapse rate and slope integrated: what all that follows rests on.
    maximum_likelihood, psignifit : PsychometricFunction or NotComputed
        The same answers fitted in the two ways that are usual, for comparison.
    weber_fraction : Estimate or NotComputed
        Threshold over standard.
    fit : GoodnessOfFit or NotComputed
        How well the likeliest function fits.
    """

    participant: str
    trials: int
    correct: int
    catch_trials: int
    catch_correct: int
    function: PsychometricFunction | NotComputed
    maximum_likelihood: PsychometricFunction | NotComputed
    psignifit: PsychometricFunction | NotComputed
    weber_fraction: Estimate | NotComputed
    fit: GoodnessOfFit | NotComputed


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskThresholds:
    """What a task of forced choice shows.

    Parameters
    ----------
    task : str
        The task's label in file names.
    method : str
        A key of `slipscale.analysis.statistics.psychometrics.psychometric_function.METHODS`.
    standard_um_pp : float or None
        With which surfaces were compared, µm peak to peak; None in detection, where the others
        are still, and where standards differ.
    participants : tuple of ParticipantThreshold
        In the order of their names.
    population : PopulationThreshold or NotComputed
        Every participant counts as one; of a comparison the point of subjective equality.
    weber_fraction : Estimate or NotComputed
        Geometric mean of the participants', with Student's interval.
    """

    task: str
    method: str
    standard_um_pp: float | None
    participants: tuple[ParticipantThreshold, ...]
    population: PopulationThreshold | NotComputed
    weber_fraction: Estimate | NotComputed


def thresholds(
    choices: pd.DataFrame,
    confidence: float = 0.95,
    *,
    study_text: str = "",
    psignifit: bool = False,
) -> tuple[TaskThresholds, ...] | NotComputed:
    """Return the thresholds of every task of forced choice.

    Parameters
    ----------
    choices : DataFrame
        `slipscale.analysis.tasks.thresholds.reading.read_choices`'s trials.
    study_text : str
        The study file, which states the rules of adaptive tasks; empty if it is not known.
    psignifit : bool
        Whether to fit by psignifit too, which takes a second a participant and task.
    """
    if not len(choices):
        return NotComputed("no trials of forced choice")
    rules = rules_of(study_text) if choices["track"].notna().any() else {}
    return tuple(
        _task(str(task), rows, confidence, rules.get(str(task)), psignifit=psignifit)
        for task, rows in choices.groupby("task", sort=True)
    )


def _task(
    task: str,
    rows: pd.DataFrame,
    confidence: float,
    rule: Interleaved | None,
    *,
    psignifit: bool,
) -> TaskThresholds:
    method = str(rows["method"].iloc[0])
    standards = rows["standard_um_pp"].dropna().unique()
    standard = float(standards[0]) if len(standards) == 1 and standards[0] > 0 else None
    people = tuple(
        _participant(str(who), own, method, standard, confidence, rule=rule, psignifit=psignifit)
        for who, own in rows.groupby(PARTICIPANT, observed=True)
    )
    population = population_threshold([each.function for each in people], confidence)
    return TaskThresholds(
        task=task,
        method=method,
        standard_um_pp=standard,
        participants=people,
        population=population,
        weber_fraction=_mean_weber([each.weber_fraction for each in people], confidence),
    )


def _participant(
    who: str,
    rows: pd.DataFrame,
    method: str,
    standard: float | None,
    confidence: float,
    *,
    rule: Interleaved | None,
    psignifit: bool,
) -> ParticipantThreshold:
    catches, main = rows[rows["catch"]], rows[~rows["catch"]]
    likeliest: PsychometricFunction | NotComputed = NotComputed("no main trials")
    function = theirs = likeliest
    fit: GoodnessOfFit | NotComputed = NotComputed("no function was fitted")
    weber: Estimate | NotComputed = NotComputed("no function was fitted")
    if len(main):
        answers = Answers.of_trials(main["level_um_pp"].tolist(), main["correct"].tolist())
        curve = CURVE_OF.get(method, "weibull")
        likeliest = fit_threshold(answers, method=method, curve=curve, confidence=confidence)
        function = theirs = likeliest
        if likeliest:
            function = fit_threshold_by_posterior(
                answers, method=method, curve=curve, confidence=confidence
            )
            theirs = (
                fit_threshold_by_psignifit(
                    answers, method=method, curve=curve, confidence=confidence
                )
                if psignifit
                else NotComputed("not asked for")
            )
            adaptive = bool(main["track"].notna().any())
            fit = _fit(likeliest, function, answers, rule, adaptive=adaptive)
        if function:
            weber = (
                NotComputed("there is no one standard above 0")
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
        maximum_likelihood=likeliest,
        psignifit=theirs,
        weber_fraction=weber,
        fit=fit,
    )


def _fit(
    likeliest: PsychometricFunction,
    function: PsychometricFunction | NotComputed,
    answers: Answers,
    rule: Interleaved | None,
    *,
    adaptive: bool,
) -> GoodnessOfFit | NotComputed:
    """Return how well the likeliest function fits, by the rule that chose the levels."""
    if not adaptive:
        return goodness_of_fit(likeliest, answers)
    if rule is None or isinstance(function, NotComputed):
        return NotComputed("levels followed the answers by a rule that the data do not state")
    return goodness_of_fit(likeliest, answers, tracks=rule, generating=function)


def _correct(rows: pd.DataFrame, method: str) -> int:
    """Count correct answers; a comparison equal to the standard has none."""
    if method != COMPARED:
        return int(rows["correct"].sum())
    more = rows["level_um_pp"] - rows["standard_um_pp"]
    return int((rows["correct"] & (more > 0)).sum() + (~rows["correct"] & (more < 0)).sum())


def _mean_weber(
    fractions: Sequence[Estimate | NotComputed], confidence: float
) -> Estimate | NotComputed:
    from scipy import stats  # noqa: PLC0415 - half a second's import

    logs = np.log([each.value for each in fractions if each])
    if len(logs) < FEWEST:
        return NotComputed(few("participants with a Weber fraction", len(logs)))
    half = float(stats.t.ppf((1 + confidence) / 2, len(logs) - 1) * stats.sem(logs))
    mean = float(logs.mean())
    return estimate(np.exp([mean, mean - half, mean + half]), confidence)


THRESHOLDS: Statistic[tuple[TaskThresholds, ...]] = Statistic(
    key="thresholds",
    meaning="thresholds of forced choice",
    compute=lambda inputs: thresholds(
        inputs.data.of(TRIALS),
        inputs.data.choices.confidence,
        study_text=inputs.data.study_text,
        psignifit=inputs.psignifit,
    ),
    headlines={
        r"([^ ]+)(?: - .+)?\.population\.threshold_um_pp\.value": "{0}: threshold, µm p-p",
        r"([^ ]+)(?: - .+)?\.population\.sd": "{0}: SD over people, log10 units",
        r"([^ ]+)(?: - .+)?\.weber_fraction\.value": "{0}: Weber fraction",
    },
)
