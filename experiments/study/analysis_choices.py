"""Choices for the analysis, which are fixed in the study file before anyone sees the data.

The choices form the ``[analysis]`` table of a study file. All keys are optional. The report states
which choices were fixed in advance.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from slipscale.faults.frozen_table import FrozenTable, setting
from slipscale.faults.message import Message

Normalisation = Literal[
    "none",
    "scale_top",
    "grand_maximum",
    "participant_maximum",
    "participant_largest_trial",
    "top_stimulus",
    "modulus_equalisation",
    "standard_referenced",
]
ZeroRule = Literal["exclude", "refuse", "half_minimum"]
SdConvention = Literal["sample", "population"]
QualityFlag = Literal[
    "non_monotone",
    "constant",
    "zeros",
    "timed_out",
    "fast",
    "outlying",
    "unreliable",
    "drift",
    "false_alarms",
    "faults",
]
#: Flags that depend on how estimates vary with amplitude. If flagged participants were excluded,
#: only participants who show the tested effect would remain.
OF_THE_OUTCOME = ("non_monotone",)
Test = Literal[
    "rm_anova",
    "friedman",
    "pairwise",
    "page_trend",
    "linear_trend",
    "power_law",
    "growth",
    "bayesian_growth",
    "mixed_model",
    "robust_exponent",
    "order",
    "reliability",
    "sessions",
    "groups",
    "factors",
    "difference",
    "thresholds",
    "scales",
    "matching",
    "ratings",
    "rating_conditions",
    "ratios",
    "productions",
    "similarity",
    "same_different",
    "limits",
    "identification",
    "pointing",
    "exponent_and_weber",
]
Primary = Literal["ranks", "logarithms"]
ThresholdCurve = Literal["weibull", "log_logistic", "log_normal", "gumbel", "logistic", "normal"]
#: Curves that are functions of the logarithm of the level.
LOGARITHMIC = ("weibull", "log_logistic", "log_normal")
Axis = Literal["linear", "logarithmic"]
Share = Annotated[float, Field(ge=0, le=1)]


class Thresholds(FrozenTable):
    """Criteria that flag a participant's data; only flags in ``exclusions`` exclude data."""

    falling_steps: Annotated[int, Field(ge=1)] | None = setting(
        None,
        "Raise the flag `non_monotone` if the mean estimate decreases on at least this number of "
        "steps from one amplitude to the next. The default (3 of 3 steps, 4 of 4, 5 of 6) is "
        "reached by at most 1 in 20 participants who feel no difference.",
        unit="steps",
    )
    distinct_numbers: Annotated[int, Field(ge=1)] = setting(
        2,
        "Raise the flag `constant` if a participant gives at most this number of different "
        "estimates for three or more amplitudes.",
        unit="different estimates",
    )
    zero_share: Share = setting(
        0.25,
        "Raise the flag `zeros` if more than this proportion of the estimates for amplitudes above "
        "0 are zero.",
    )
    timed_out_share: Share = setting(
        0.1, "Raise the flag `timed_out` if more than this proportion of trials has no answer."
    )
    fast_share: Share = setting(
        0.05,
        "Raise the flag `fast` if more than this proportion of answers is faster than fast_s.",
    )
    fast_s: Annotated[float, Field(gt=0)] = setting(
        0.2, "Response time below which an answer counts as fast."
    )
    outlier_sd: Annotated[float, Field(gt=0)] = setting(
        4.5,
        "Raise the flag `outlying` if an estimate deviates from the participant's own pattern by "
        "more than this number of robust standard deviations. A robust standard deviation is "
        "1.4826 times the median absolute deviation of the log residuals. The variance at the "
        "estimate's own amplitude and the variance across all amplitudes are averaged.",
        unit="robust standard deviations",
    )
    reliability: Annotated[float, Field(ge=-1, le=1)] = setting(
        0.5,
        "Raise the flag `unreliable` if the correlation between the first and second halves of the "
        "repetitions is smaller than this value.",
        unit="correlation, -1 to 1",
    )
    drift_factor: Annotated[float, Field(gt=1)] = setting(
        2.0,
        "Raise the flag `drift` if estimates increase or decrease by more than this factor from "
        "the first trial to the last, and the change is significant (p < .05).",
        unit="factor",
    )
    false_alarm_share: Share = setting(
        0.5,
        "Raise the flag `false_alarms` if more than this proportion of catch steps is answered "
        '"yes".',
    )
    fault_share: Share = setting(
        0.25,
        "Raise the flag `faults` if more than this proportion of trials has a plate fault or a "
        "repeated presentation.",
    )


def _no_outcome(flags: tuple[QualityFlag, ...]) -> tuple[QualityFlag, ...]:
    if wrong := [flag for flag in flags if flag in OF_THE_OUTCOME]:
        raise ValueError(
            Message(
                "{wrong} selects participants by the tested effect and makes pure noise "
                "significant; remove it: the report shows the results without the flagged "
                "participants as a sensitivity analysis",
                wrong=wrong[0],
            )
        )
    return flags


class AnalysisChoices(FrozenTable):
    """The ``[analysis]`` table of a study file."""

    normalisation: Normalisation | None = setting(
        None,
        "Method that puts the estimates of all participants on a common scale; default: "
        "scale_top if every trial has a scale top, otherwise grand_maximum.",
    )
    zero_rule: ZeroRule = setting(
        "exclude", "Treatment of zero estimates before taking logarithms."
    )
    standard_deviation: SdConvention = setting(
        "sample",
        "Standard deviation in Table III: sample divides by n - 1, and population divides by n.",
    )
    exclusions: Annotated[tuple[QualityFlag, ...], AfterValidator(_no_outcome)] = setting(
        (), "Flags that exclude a participant from every analysis."
    )
    thresholds: Thresholds = setting(
        Thresholds(), "Thresholds at which a participant's data are flagged."
    )
    primary: Primary = setting(
        "ranks",
        "Primary analysis, on which the report's answer and the power analysis are based. ranks: "
        "Friedman test and Holm-corrected pairwise Wilcoxon tests, which include estimates of "
        "zero. logarithms: repeated-measures ANOVA and Holm-corrected pairwise t-tests. All "
        "other tests are reported as secondary.",
    )
    tests: tuple[Test, ...] | None = setting(
        None,
        'Tests to run; default: all tests. Tests that are not listed are reported as "not chosen".',
    )
    confidence: Annotated[float, Field(gt=0.5, lt=1)] = setting(
        0.95, "Confidence level of all intervals.", unit="share, 0 to 1"
    )
    equivalence_ratio: Annotated[float, Field(gt=1, allow_inf_nan=False)] = setting(
        1.25,
        "Two amplitudes count as equivalent if the ratio of their geometric means lies between "
        "1/x and x, where x is this value (two one-sided tests). The default is the limit for "
        "bioequivalence, 0.80 to 1.25; set the smallest ratio that matters in your study.",
        unit="ratio",
    )
    group: str | None = setting(
        None,
        "Column of participants.tsv that contains each participant's group, for comparisons of "
        "groups; default: the column `group`, if it exists.",
    )
    axis: Axis | None = setting(
        None,
        "Axis of all threshold curves: the level itself (linear) or its logarithm. A normal "
        "function of the logarithm suits thresholds at which the just noticeable difference grows "
        "with the level. Default: logarithmic for forced choice, in which a level of 0 means "
        "guessing; linear for yes-no answers, whose catch trials have a level of 0, and for "
        "comparisons on both sides of a standard.",
    )
    threshold_curve: ThresholdCurve | None = setting(
        None,
        "Psychometric function for thresholds: weibull, log_logistic and log_normal are "
        "functions of the logarithm of the level; gumbel, logistic and normal are functions of "
        "the level itself. Default: weibull, or normal if comparisons lie on both sides of a "
        "standard.",
    )
    threshold_share: Annotated[float, Field(gt=0, lt=1)] = setting(
        0.5,
        "Height of the psychometric curve at the threshold, corrected for guesses and lapses: "
        "0.5 is halfway between the asymptotes.",
        unit="share, 0 to 1",
    )
    threshold_reversals: Annotated[int, Field(strict=True, ge=2, multiple_of=2)] | None = setting(
        None,
        "Number of final reversals per track whose mean is also reported as a staircase "
        "threshold (Levitt 1971); must be even. By default, no staircase threshold is reported.",
        unit="reversals",
    )
    threshold_friction: Literal["level_means", "trials"] | None = setting(
        None,
        "Also report thresholds in measured friction. trials: the psychometric curve is a function "
        "of each trial's change in the coefficient of friction. level_means: the curve is a "
        "function of the mean change per participant and level, so that noise in single "
        "measurements does not flatten the curve. By default, these thresholds are not reported.",
    )
    largest_lapse: Annotated[float, Field(ge=0, lt=0.5)] = setting(
        0.2,
        "Upper bound of the lapse rate that participants share in the population model; catch "
        "trials help to estimate it.",
        unit="share, 0 to 0.5",
    )
    codebook: str | None = setting(
        None,
        "Path of the codebook for verbal reports, relative to the data set; default: the shipped "
        "codebook.",
    )

    @model_validator(mode="after")
    def _one_axis(self) -> Self:
        curve = self.threshold_curve
        if self.axis and curve and (curve in LOGARITHMIC) != (self.axis == "logarithmic"):
            raise ValueError(
                Message(
                    "threshold_curve {curve} is not on a {axis} axis; remove one of them",
                    curve=curve,
                    axis=self.axis,
                )
            )
        return self
