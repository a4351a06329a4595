"""How a study's data will be analysed, frozen in the study file before anything is looked at.

The ``[analysis]`` table of a study. All keys are optional; what is left out keeps the default
given here, and the report says which choices were frozen and which were not.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

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
Flag = Literal[
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
Test = Literal[
    "rm_anova",
    "friedman",
    "pairwise",
    "page_trend",
    "linear_trend",
    "power_law",
    "growth",
    "mixed_model",
    "order",
    "reliability",
    "difference",
]
Share = Annotated[float, Field(ge=0, le=1)]


class Thresholds(BaseModel):
    """When a participant's data is flagged (a flag excludes only where ``exclusions`` says so)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    #: non_monotone: steps, from one amplitude to the next, on which the mean estimate falls.
    falling_steps: Annotated[int, Field(ge=1)] = 1
    #: constant: this many distinct numbers or fewer.
    distinct_numbers: Annotated[int, Field(ge=1)] = 2
    #: zeros: a larger share of estimates that are zero.
    zero_share: Share = 0.25
    #: timed_out: a larger share of trials without an answer.
    timed_out_share: Share = 0.1
    #: fast: a larger share of answers under ``fast_s`` seconds.
    fast_share: Share = 0.05
    fast_s: Annotated[float, Field(gt=0)] = 0.2
    #: outlying: an estimate this many robust standard deviations (1.4826 MAD of the logarithmic
    #: residuals, all participants) from the participant's own pattern.
    outlier_sd: Annotated[float, Field(gt=0)] = 4.0
    #: unreliable: correlation between the first and second half of the repetitions under this.
    reliability: Annotated[float, Field(ge=-1, le=1)] = 0.5
    #: drift: estimates grow or shrink by more than this factor from first to last trial.
    drift_factor: Annotated[float, Field(gt=1)] = 2.0
    #: false_alarms: a larger share of catch steps answered "yes".
    false_alarm_share: Share = 0.5
    #: faults: a larger share of trials with a plate fault or presented again.
    fault_share: Share = 0.25


class AnalysisChoices(BaseModel):
    """The ``[analysis]`` table of a study file."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    #: How estimates are brought to one scale. Left out: scale_top where every trial has one,
    #: else grand_maximum.
    normalisation: Normalisation | None = None
    #: What becomes of estimates of zero where a logarithm is taken.
    zero_rule: ZeroRule = "exclude"
    #: The convention of the standard deviation in Table III.
    standard_deviation: SdConvention = "sample"
    #: Flags that exclude a participant from every analysis, before anything is looked at.
    exclusions: tuple[Flag, ...] = ()
    thresholds: Thresholds = Thresholds()
    #: The tests to run; left out: all. The others are reported as "not chosen".
    tests: tuple[Test, ...] | None = None
    #: Confidence of every interval.
    confidence: Annotated[float, Field(gt=0.5, lt=1)] = 0.95
    #: Resamples and seed of the bootstrap.
    bootstrap_resamples: Annotated[int, Field(ge=200, le=100_000)] = 5000
    bootstrap_seed: Annotated[int, Field(ge=0)] = 2007
    #: A code book for verbal reports, relative to the data set; left out: the shipped one.
    codebook: str | None = None
