"""Analyse the answers and verbal reports of the descending difference task.

Without catch steps, "yes" is confounded with response bias, and d' cannot be computed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from slipscale.analysis.json_form import record, renamed
from slipscale.analysis.preprocessing.sufficiency import few
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval, key_of
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    mean_over_participants,
    unbounded,
)
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.psychometric_function import (
    Answers,
    PsychometricFunction,
)
from slipscale.analysis.statistics.psychometrics.thresholds import fit_threshold
from slipscale.analysis.tasks.difference.coder_agreement import CoderAgreement
from slipscale.analysis.tasks.difference.probit import DPrimeOfSize, d_primes
from slipscale.analysis.tasks.difference.proportions import clustered_interval
from slipscale.analysis.tasks.difference.step_size_curve import PsychometricCurve, psychometric
from slipscale.analysis.tasks.difference.verbal_coding import Codebook
from slipscale.analysis.tasks.difference.verbal_reports import VerbalReports, code_reports
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.study.analysis_choices import Axis
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

#: With fewer steps or catch steps, d' of one participant depends mainly on the correction.
TRIALS_FOR_OWN = 20
#: Step sizes are equal if they differ by less than this fraction of the largest level.
SAME_SIZE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class StepAnswers:
    """Answers to steps between the same two amplitudes, with an interval for the "yes" rate."""

    from_level: float
    to_level: float
    n: int
    yes: int
    interval: ConfidenceInterval

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, interval="" if self.interval is None else key_of(self.interval))


@dataclass(frozen=True, slots=True, kw_only=True)
class CatchAnswers:
    """Answers to catch steps, with an interval for the "yes" rate (None without catch steps)."""

    n: int
    yes: int
    interval: ConfidenceInterval | None

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, interval="" if self.interval is None else key_of(self.interval))


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensitivity:
    """Yes/no counts, with d' and the criterion c after the log-linear correction."""

    hits: int
    changes: int
    false_alarms: int
    catches: int
    d_prime: float
    criterion: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SignalDetection:
    """Signal-detection results for the descending difference task.

    Parameters
    ----------
    pooled : Sensitivity
        Sensitivity computed from the pooled answers of all participants.
    by_size : tuple of DPrimeOfSize or NotComputed
        d' for each step size, from a probit model that includes participant effects.
    all_sizes : DPrimeOfSize or NotComputed
        d' from the same model for all step sizes combined.
    mean_d_prime : MeanOverParticipants or NotComputed
        Mean of individual d' values, if all participants have `TRIALS_FOR_OWN` steps and catch
        steps.
    participants : Mapping
        Individual d' and criterion, keyed by participant.
    """

    pooled: Sensitivity
    by_size: tuple[DPrimeOfSize, ...] | NotComputed
    all_sizes: DPrimeOfSize | NotComputed
    mean_d_prime: MeanOverParticipants | NotComputed
    participants: Mapping[str, Sensitivity]

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        pooled = record(self.pooled)
        return {
            "pooled_d_prime": pooled.pop("d_prime"),
            "pooled_criterion": pooled.pop("criterion"),
            **pooled,
            "by_size": self.by_size,
            "all_sizes": self.all_sizes,
            "mean_of_participants": self.mean_d_prime,
            "participants": self.participants,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """Numbers of participants whose answers agree with the paper's finding.

    Parameters
    ----------
    n : int
        Number of participants.
    felt_a_difference, felt_every_change : int
        Number of participants who felt at least one change, and number who felt every change.
    said_less_slippery : int
        Number of participants who reported that the surface became less slippery.
    """

    n: int
    felt_a_difference: int
    felt_every_change: int
    said_less_slippery: int

    @property
    def all_felt_a_difference(self) -> bool:
        """Whether every participant felt at least one change."""
        return self.n > 0 and self.felt_a_difference == self.n

    @property
    def all_said_less_slippery(self) -> bool:
        """Whether every participant reported that the surface became less slippery."""
        return self.n > 0 and self.said_less_slippery == self.n

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self) | {
            "all_felt_a_difference": self.all_felt_a_difference,
            "all_said_less_slippery": self.all_said_less_slippery,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class DescendingDifference:
    """All results of the descending difference task.

    Parameters
    ----------
    steps : tuple of StepAnswers
        Answers to steps with a change in amplitude, in descending order of amplitude.
    catch : CatchAnswers
        Answers to catch steps, in which the amplitude does not change.
    signal_detection, psychometric, verbal_reports, finding : object
        Results of the individual analyses; see their classes.
    weber : PsychometricCurve or NotComputed
        Proportion of "yes" answers as a function of the step size, as a Weber fraction.
    thresholds : Mapping
        Threshold of each participant, halfway between the "yes" rates for catch steps and for the
        largest steps. NotComputed for participants with fewer than `TRIALS_FOR_OWN` answers.
    participants : int
        Number of participants who answered.
    answers_per_participant_and_step : float
        Mean number of answers per participant and step.
    coders : CoderAgreement, NotComputed or None
        Agreement between coders; None if the data set has no codes from human coders.
    """

    steps: tuple[StepAnswers, ...]
    catch: CatchAnswers
    signal_detection: SignalDetection | NotComputed
    psychometric: PsychometricCurve | NotComputed
    weber: PsychometricCurve | NotComputed
    thresholds: Mapping[str, PsychometricFunction | NotComputed]
    verbal_reports: VerbalReports | NotComputed
    finding: Finding
    participants: int
    answers_per_participant_and_step: float
    coders: CoderAgreement | NotComputed | None = None

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        detection = self.signal_detection
        keys = renamed(self, coders="" if self.coders is None else "coders")
        d_prime = detection.pooled.d_prime if detection else detection
        return {"steps": keys.pop("steps"), "catch": keys.pop("catch"), "d_prime": d_prime, **keys}


def d_prime(hits: float, signals: float, false_alarms: float, noises: float) -> tuple[float, float]:
    """Return d' and the criterion c for a yes/no task, with the log-linear correction.

    The correction adds 0.5 to hits and to false alarms, and 1 to the counts of signal and noise
    trials (Hautus 1995, Behavior Research Methods, Instruments, & Computers 27, 46-51), so that d'
    is always finite.

    >>> d, c = d_prime(10, 20, 10, 20)
    >>> round(d, 12), round(c, 12)
    (0.0, 0.0)
    """
    from scipy.special import ndtri

    hit = float(ndtri((hits + 0.5) / (signals + 1)))
    alarm = float(ndtri((false_alarms + 0.5) / (noises + 1)))
    return hit - alarm, 0.0 - (hit + alarm) / 2


def analyse_differences(
    steps: pd.DataFrame,
    book: Codebook,
    confidence: float = 0.95,
    quantity: Quantity = PLATE_AMPLITUDE,
    axis: Axis = "linear",
) -> DescendingDifference | NotComputed:
    """Return all results of the descending difference task except coder agreement.

    Parameters
    ----------
    steps : DataFrame
        `slipscale.analysis.reading.dataset.Dataset.differences`.
    book : Codebook
        Codebook for the verbal reports.
    confidence : float
        Confidence level of every interval.
    quantity : Quantity
        Quantity of the presented stimuli.
    axis : {"linear", "logarithmic"}
        Axis of the curves.
    """
    if not len(steps):
        words = quantity.yes_no
        return NotComputed(f"no {words.trials[1]} of {words.task} were answered")
    changes = steps[~steps["catch"]]
    catches = steps[steps["catch"]]
    by_step = changes.groupby(["level_before", "level"])
    rows = [
        StepAnswers(
            from_level=float(own["level_before"].iloc[0]),
            to_level=float(own["level"].iloc[0]),
            n=len(own),
            yes=int(own["difference_felt"].sum()),
            interval=interval_of(own, confidence),
        )
        for _, own in reversed(list(by_step))
    ]
    catch_n, catch_yes = len(catches), int(catches["difference_felt"].sum())
    return DescendingDifference(
        steps=tuple(rows),
        catch=CatchAnswers(
            n=catch_n,
            yes=catch_yes,
            interval=interval_of(catches, confidence) if catch_n else None,
        ),
        signal_detection=signal_detection(changes, catches, confidence, quantity),
        psychometric=psychometric(steps, confidence, quantity=quantity, axis=axis),
        weber=psychometric(steps, confidence, "weber_fraction", quantity, axis),
        thresholds=own_thresholds(steps, confidence, axis),
        verbal_reports=code_reports(changes, book),
        finding=finding(changes, book),
        participants=int(steps[PARTICIPANT].nunique()),
        answers_per_participant_and_step=_repetitions(changes),
    )


def interval_of(answers: pd.DataFrame, confidence: float) -> ConfidenceInterval:
    """Return the interval for the proportion of "yes", adjusted for repeated answers."""
    own = answers.groupby(answers[PARTICIPANT].astype(str))["difference_felt"].agg(["sum", "size"])
    return clustered_interval(own["sum"].to_numpy(float), own["size"].to_numpy(float), confidence)


def _repetitions(changes: pd.DataFrame) -> float:
    cells = changes.groupby([PARTICIPANT, "level_before", "level"], observed=True)
    return float(cells.size().mean()) if len(changes) else 0.0


def signal_detection(
    changes: pd.DataFrame, catches: pd.DataFrame, confidence: float, quantity: Quantity
) -> SignalDetection | NotComputed:
    """Return d' and c, pooled and for each participant with steps and catch steps."""
    if not len(catches):
        return NotComputed(
            f"there are no {quantity.yes_no.catch[1]}, so sensitivity cannot be separated "
            f"from a tendency to answer “{quantity.yes}”"
        )
    if not len(changes):
        return NotComputed(
            f"there are no {quantity.yes_no.trials[1]} in which the {quantity.name} changed"
        )
    signals = changes.groupby(changes[PARTICIPANT].astype(str))["difference_felt"].agg(
        ["sum", "size"]
    )
    noises = catches.groupby(catches[PARTICIPANT].astype(str))["difference_felt"].agg(
        ["sum", "size"]
    )
    both = signals.add_suffix("_signal").join(noises.add_suffix("_noise"), how="inner")
    own = {
        str(who): _sensitivity(*row)
        for who, row in zip(both.index, both.to_numpy(int).tolist(), strict=True)
    }
    answers = pd.concat([catches, changes])
    sizes = step_sizes(answers)
    felt = answers["difference_felt"].to_numpy(float)
    who = pd.factorize(answers[PARTICIPANT].astype(str))[0]
    by_size = d_primes(sizes, felt, who, confidence)
    together = d_primes((sizes != 0).astype(float), felt, who, confidence)
    return SignalDetection(
        pooled=_sensitivity(
            int(changes["difference_felt"].sum()),
            len(changes),
            int(catches["difference_felt"].sum()),
            len(catches),
        ),
        by_size=by_size,
        all_sizes=together
        if isinstance(together, NotComputed)
        else replace(together[0], removed_level=float("nan")),
        mean_d_prime=_mean_of_own(own, confidence, quantity),
        participants=own,
    )


def step_sizes(steps: pd.DataFrame) -> NDArray[np.float64]:
    """Return step sizes in µm peak to peak, rounded so that equal steps compare as equal.

    >>> step_sizes(
    ...     pd.DataFrame(
    ...         {"level_before": [2.3, 3e-9], "level": [1.2, 1e-9]}
    ...     )
    ... ).tolist()
    [1.1, 0.0]
    """
    levels = steps[["level_before", "level"]].to_numpy(float)
    removed = levels[:, 0] - levels[:, 1]
    largest = float(np.abs(levels).max(initial=0.0))
    if not largest:
        return np.zeros(len(levels))
    decimals = -math.ceil(math.log10(largest * SAME_SIZE))
    # Python rounds in decimal. NumPy rounds by multiplying and dividing, which turns 1e-12 into
    # 1.0000000000000002e-12.
    return np.array([round(size, decimals) + 0.0 for size in removed.tolist()])


def own_thresholds(
    steps: pd.DataFrame, confidence: float, axis: Axis = "linear"
) -> dict[str, PsychometricFunction | NotComputed]:
    """Return each participant's threshold, or the reason why there is none.

    The rate of false alarms is estimated from catch steps. Without them, it is 0: a free rate would
    absorb "yes" answers to weak steps, and raise the threshold.
    """
    sizes = pd.Series(np.abs(step_sizes(steps)), index=steps.index)
    found: dict[str, PsychometricFunction | NotComputed] = {}
    for who, own in steps.groupby(steps[PARTICIPANT].astype(str)):
        if len(own) < TRIALS_FOR_OWN:
            found[str(who)] = NotComputed(few("answers for a threshold", len(own), TRIALS_FOR_OWN))
            continue
        felt = (own["difference_felt"] == 1).tolist()
        found[str(who)] = fit_threshold(
            Answers.of_trials(sizes[own.index].tolist(), felt),
            method="yes_no" if (sizes[own.index] == 0).any() else "detection",
            curve="log_logistic" if axis == "logarithmic" else "logistic",
            confidence=confidence,
        )
    return found


def _mean_of_own(
    own: Mapping[str, Sensitivity], confidence: float, quantity: Quantity = PLATE_AMPLITUDE
) -> MeanOverParticipants | NotComputed:
    """Return the mean of individual d' values, unless a participant has too few steps."""
    fewest = min((min(each.changes, each.catches) for each in own.values()), default=0)
    if fewest < TRIALS_FOR_OWN:
        return NotComputed(
            f"individual d' values require at least {TRIALS_FOR_OWN} {quantity.yes_no.trials[1]} "
            f"with a change and {TRIALS_FOR_OWN} without per participant (fewest here: {fewest}); "
            "with fewer, the correction for counts of 0 shrinks d' towards 0"
        )
    everyone = own.values()
    return unbounded(
        mean_over_participants(np.array([each.d_prime for each in everyone]), confidence),
        below=any(not each.hits or each.false_alarms == each.catches for each in everyone),
        above=any(each.hits == each.changes or not each.false_alarms for each in everyone),
    )


def _sensitivity(hits: int, changes: int, false_alarms: int, catches: int) -> Sensitivity:
    sensitivity, criterion = d_prime(hits, changes, false_alarms, catches)
    return Sensitivity(
        hits=hits,
        changes=changes,
        false_alarms=false_alarms,
        catches=catches,
        d_prime=sensitivity,
        criterion=criterion,
    )


def finding(changes: pd.DataFrame, book: Codebook) -> Finding:
    """Count the participants who confirm the paper's finding.

    "All of the subjects feel clearly the difference during the test, and they immediately say
    that it is 'less slippery'" (Section IV-B).
    """
    felt = changes["difference_felt"].groupby(changes[PARTICIPANT].astype(str)).agg(["max", "min"])
    n = len(felt)
    reports = changes[(changes["difference_felt"] == 1) & (changes["verbal_report"] != "")]
    meanings = reports["verbal_report"].astype(str).map(book.meaning)
    less = reports[PARTICIPANT].astype(str)[meanings == "less_slippery"].nunique()
    return Finding(
        n=n,
        felt_a_difference=int((felt["max"] == 1).sum()),
        felt_every_change=int((felt["min"] == 1).sum()),
        said_less_slippery=less,
    )
