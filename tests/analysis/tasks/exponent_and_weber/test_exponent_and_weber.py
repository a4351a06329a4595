"""The exponent beside the Weber fraction: what is expected, and when they agree."""

import math

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.preprocessing.log_transform import prepare
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.psychometric_function import Estimate
from slipscale.analysis.tasks.exponent_and_weber.declaration import sentence
from slipscale.analysis.tasks.exponent_and_weber.statistics import (
    EKMAN,
    PUBLISHED,
    exponent_and_weber,
)
from slipscale.analysis.tasks.thresholds.statistics import ParticipantThreshold, TaskThresholds
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

AMPLITUDES = np.array([0.3, 0.6, 1.2, 2.3])
NONE = NotComputed("not part of this test")


def estimates(exponents):
    """Return estimates that follow each participant's power function without noise."""
    rows = [
        (f"sub-{who:02d}", a, 10 * a**exponent)
        for who, exponent in enumerate(exponents)
        for a in AMPLITUDES
    ]
    frame = pd.DataFrame(rows, columns=["participant_id", "level", "normalised"])
    frame["participant_id"] = frame["participant_id"].astype("category")
    return prepare(frame.assign(session="", run="1"), AnalysisChoices())


def of_all(fractions):
    there = np.log([each for each in fractions if each is not None])
    if len(there) < 3:
        return NONE
    mean, half = there.mean(), 2.776 * there.std(ddof=1) / len(there) ** 0.5
    low, high = (float(np.exp(mean + side * half)) for side in (-1, 1))
    interval = ConfidenceInterval(low, high, 0.95)
    return Estimate(value=float(np.exp(mean)), interval=interval)


def task(fractions, standard=1.2):
    people = tuple(
        ParticipantThreshold(
            participant=f"sub-{who:02d}",
            trials=60,
            correct=45,
            catch_trials=0,
            catch_correct=0,
            function=NONE,
            weber_fraction=NONE
            if fraction is None
            else Estimate(value=fraction, interval=ConfidenceInterval(0, 1, 0.95)),
            fit=NONE,
            presented_levels=(0.02, 0.4),
        )
        for who, fraction in enumerate(fractions)
    )
    return TaskThresholds(
        task="difference",
        method="two_interval",
        curve="weibull",
        standard_level=standard,
        participants=people,
        population=NONE,
        weber_fraction=of_all(fractions),
        reversals=NONE,
        friction=NONE,
    )


#: Small differences between people, so that intervals are narrow.
SPREAD = np.array([0.97, 0.99, 1.0, 1.01, 1.03])


def test_published_exponents_and_weber_fractions_give_the_published_constant():
    """Vibration at 60 Hz: 0.036 and 0.95; brightness: 0.079 and 0.33 (Teghtsoonian 1971)."""
    for weber, exponent, constant in ((0.036, 0.95, 0.034), (0.079, 0.33, 0.025)):
        (found,) = exponent_and_weber(estimates(exponent * SPREAD), (task(weber * SPREAD[::-1]),))
        assert found.ekman_fraction.value == pytest.approx(constant, abs=6e-4)
        assert found.verdict == "agrees"
        assert PUBLISHED[0] <= round(found.ekman_fraction.value, 3) <= PUBLISHED[1]


def test_the_expected_exponent_falls_as_the_weber_fraction_rises():
    (found,) = exponent_and_weber(estimates(0.8 * SPREAD), (task(0.04 * SPREAD),))
    low, high = found.weber_fraction.interval
    assert found.expected_exponent.value == pytest.approx(math.log(1.03) / math.log(1.04), rel=1e-3)
    assert found.expected_exponent.interval.low == pytest.approx(
        math.log1p(EKMAN) / math.log1p(high)
    )
    assert found.expected_exponent.interval.high == pytest.approx(
        math.log1p(EKMAN) / math.log1p(low)
    )
    # With its own k, a participant's exponent is what the law says.
    one = found.participants[0]
    assert (one.exponent, one.weber_fraction) == pytest.approx((0.8 * 0.97, 0.04 * 0.97))


@pytest.mark.parametrize(
    "exponents,fractions,verdict",
    [
        (0.75 * SPREAD, 0.04 * SPREAD, "agrees"),
        (2.0 * SPREAD, 0.04 * SPREAD, "does not agree"),
        (0.2 * SPREAD, 0.04 * SPREAD, "does not agree"),
        (0.75 * SPREAD**20, 0.04 * SPREAD[::-1] ** 20, "agrees"),
        (0.75 * SPREAD**30, 0.04 * SPREAD**30, "undecided"),
    ],
)
def test_the_verdict_follows_the_interval(exponents, fractions, verdict):
    (found,) = exponent_and_weber(estimates(exponents), (task(fractions),))
    assert found.verdict == verdict
    assert {"agrees": "agrees with", "does not agree": "does not agree with"}.get(
        verdict, "can be neither shown"
    ) in sentence(found, 0.95, PLATE_AMPLITUDE)


def test_an_exponent_that_may_be_none_is_said_to_be_so():
    (found,) = exponent_and_weber(estimates([-0.3, 0.4, -0.2, 0.3, 0.1]), (task(0.04 * SPREAD),))
    assert not found.grows
    assert "so the data do not show that sensation increases with the amplitude" in sentence(
        found, 0.95, PLATE_AMPLITUDE
    )
    (found,) = exponent_and_weber(estimates(0.75 * SPREAD), (task(0.04 * SPREAD),))
    assert "not shown" not in sentence(found, 0.95, PLATE_AMPLITUDE)


@pytest.mark.parametrize(
    "tasks,words",
    [
        (NotComputed("no trials of forced choice"), "no Weber fraction (no trials"),
        ((task([0.04] * 5, standard=None),), "difference: there is no standard above 0"),
        ((task([0.04, None, None, None, 0.05]),), "a Weber fraction (2; at least 3 are needed)"),
    ],
)
def test_what_cannot_be_compared_says_why(tasks, words):
    found = exponent_and_weber(estimates(0.75 * SPREAD), tasks)
    assert isinstance(found, NotComputed)
    assert words in found.reason


def test_thresholds_alone_have_no_exponent():
    assert exponent_and_weber(None, (task([0.04] * 5),)) == NotComputed("no magnitude estimates")
