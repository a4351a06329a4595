"""Test whether the exponent of magnitude estimates agrees with the Weber fraction.

Ekman's law states that a just noticeable difference is a constant fraction *k* of the sensation.
For a power function with exponent *n* and a Weber fraction *w*

    k = (1 + w)^n - 1,    n = log(1 + k) / log(1 + w)

According to Teghtsoonian (1971, Psychological Review 78, 71-80), *k* is near 0.03 for every sense,
so steep power functions imply fine discrimination.

Only Weber fractions from choices by magnitude are compared. Half-way between chance and best
performance, d' is 0.95 in two-interval forced choice, but 2.32 in oddity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.preprocessing.sufficiency import FEWEST, few
from slipscale.analysis.statistics.mean_over_participants import mean_over_participants
from slipscale.analysis.statistics.not_computed import NotComputed, all_computed, missing
from slipscale.analysis.statistics.power_law import exponents
from slipscale.analysis.statistics.psychometrics.psychometric_function import (
    METHODS,
    Estimate,
    estimate,
)
from slipscale.analysis.statistics.statistic import Inputs, Statistic
from slipscale.analysis.tasks.thresholds.statistics import THRESHOLDS, TaskThresholds

#: Value of k according to Teghtsoonian.
EKMAN = 0.03
#: Range of k, computed from published Weber fractions and exponents of nine continua, from
#: brightness (0.079 and 0.33) to vibration at 60 Hz (0.036 and 0.95).
PUBLISHED = (0.025, 0.035)
#: The interval of k agrees with the law if it lies within this factor of `EKMAN` and overlaps the
#: published range. This factor is our choice; it is not published.
FACTOR = 2.0

Verdict = Literal["agrees", "does not agree", "undecided"]


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnExponentAndWeber:
    """The exponent and the Weber fraction of one participant."""

    participant: str
    exponent: float
    weber_fraction: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ExponentAndWeber:
    """Comparison of exponent and Weber fraction across participants who have both.

    Parameters
    ----------
    task : str
        Label of the task from which the Weber fraction is estimated.
    standard_level : float
        Amplitude of the standard, µm peak to peak.
    participants : tuple of OwnExponentAndWeber
        Values of each participant.
    exponent : Estimate
        Mean exponent with its t-based interval.
    weber_fraction : Estimate
        Weber fraction of the population; see `TaskThresholds.weber_fraction`.
    expected_exponent : Estimate
        Exponent computed from the Weber fraction and its interval, with k = 0.03.
    ekman_fraction : Estimate
        Estimate of k from these participants, with a t-based interval computed on log(1 + k).
    verdict : {"agrees", "does not agree", "undecided"}
        "agrees" if the interval of k lies within a factor of 2 of 0.03 and overlaps the published
        range (0.025 to 0.035); "does not agree" if the whole interval lies outside the published
        range; otherwise "undecided".
    grows : bool
        Whether the whole interval of the exponent is above 0.
    """

    task: str
    standard_level: float
    participants: tuple[OwnExponentAndWeber, ...]
    exponent: Estimate
    weber_fraction: Estimate
    expected_exponent: Estimate
    ekman_fraction: Estimate
    verdict: Verdict
    grows: bool


def exponent_and_weber(
    prepared: Prepared | None,
    tasks: tuple[TaskThresholds, ...] | NotComputed,
    confidence: float = 0.95,
) -> tuple[ExponentAndWeber, ...] | NotComputed:
    """Compare exponent and Weber fraction for each task that yields Weber fractions.

    Parameters
    ----------
    prepared : Prepared or None
        Magnitude estimates; None if there are none.
    tasks : tuple of TaskThresholds or NotComputed
        Result of `slipscale.analysis.tasks.thresholds.statistics.thresholds`.
    """
    if prepared is None:
        return NotComputed("no magnitude estimates")
    if isinstance(tasks, NotComputed):
        return NotComputed(f"no Weber fraction ({tasks.reason})")
    if prepared.refused:
        return NotComputed(prepared.zero_sentence)
    own = exponents(prepared.logs)["exponent"].dropna()
    by_name = {str(who): float(value) for who, value in own.items()}
    compared = [(task.task, _task(task, by_name, confidence)) for task in tasks]
    if found := all_computed(each for _, each in compared):
        return tuple(found)
    return NotComputed(
        "; ".join(f"{task}: {why.reason}" for task, each in compared for why in missing([each]))
    )


def _task(
    task: TaskThresholds, exponent_of: dict[str, float], confidence: float
) -> ExponentAndWeber | NotComputed:
    if task.standard_level is None:
        return NotComputed("there is no standard above 0, so there is no Weber fraction")
    if not METHODS[task.method].by_magnitude:
        return NotComputed(
            "the Weber fraction of oddity cannot be compared, because the odd one of three "
            "surfaces is found less easily than the larger of two with the same difference"
        )
    people = tuple(
        OwnExponentAndWeber(
            participant=each.participant,
            exponent=exponent_of[each.participant],
            weber_fraction=each.weber_fraction.value,
        )
        for each in task.participants
        if each.participant in exponent_of and each.weber_fraction
    )
    if len(people) < FEWEST:
        return NotComputed(few("participants with an exponent and a Weber fraction", len(people)))
    own = np.array([each.exponent for each in people])
    weber = np.array([each.weber_fraction for each in people])
    exponent = mean_over_participants(own, confidence)
    log_ekman = mean_over_participants(own * np.log1p(weber), confidence)
    whole = task.weber_fraction
    if not (exponent and whole and log_ekman):
        return missing([exponent, whole, log_ekman])[0]
    fraction = np.array([whole.value, *whole.interval])
    with np.errstate(divide="ignore"):  # a fraction of 0 gives an infinite exponent
        expected = np.log1p(EKMAN) / np.log1p(fraction)
    ekman = np.expm1([log_ekman.mean, *log_ekman.interval])
    return ExponentAndWeber(
        task=task.task,
        standard_level=task.standard_level,
        participants=people,
        exponent=estimate(np.array([exponent.mean, *exponent.interval]), confidence),
        weber_fraction=whole,
        # A larger Weber fraction corresponds to a smaller exponent.
        expected_exponent=estimate(expected[[0, 2, 1]], confidence),
        ekman_fraction=estimate(ekman, confidence),
        verdict=_verdict(float(ekman[1]), float(ekman[2])),
        grows=exponent.interval.low > 0,
    )


def _verdict(low: float, high: float) -> Verdict:
    if high < PUBLISHED[0] or low > PUBLISHED[1]:
        return "does not agree"
    if low >= EKMAN / FACTOR and high <= EKMAN * FACTOR:
        return "agrees"
    return "undecided"


class _ExponentAndWeber(Statistic[tuple[ExponentAndWeber, ...]]):
    key = "exponent_and_weber"
    meaning = "agreement of exponent and Weber fraction (Ekman's law)"
    methods = (
        "Exponents of magnitude estimation and Weber fractions of the same participants were "
        "compared by Ekman's law, according to which a just noticeable difference is about 3 % of "
        "the sensation [[teghtsoonian1971]]."
    )

    def compute(self, inputs: Inputs) -> tuple[ExponentAndWeber, ...] | NotComputed:
        return exponent_and_weber(
            inputs.prepared, inputs.found[THRESHOLDS], inputs.data.choices.confidence
        )


EXPONENT_AND_WEBER = _ExponentAndWeber()
