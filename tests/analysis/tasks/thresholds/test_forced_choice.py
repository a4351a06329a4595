"""Thresholds from trials of forced choice: recovered, and honest where there are too few."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.psychometric_function import Answers
from slipscale.analysis.statistics.psychometrics.thresholds import fit_threshold, threshold_values
from slipscale.analysis.tasks.thresholds.figures import within_answers
from slipscale.analysis.tasks.thresholds.reading import COLUMNS
from slipscale.analysis.tasks.thresholds.sentences import POOLED, answers, remarks
from slipscale.analysis.tasks.thresholds.statistics import thresholds
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

pytestmark = pytest.mark.usefixtures("without_simulated_fits")

LEVELS = (0.02, 0.05, 0.1, 0.2, 0.4)
SLOPE, LAPSE = 2.0, 0.02


def trials(
    people, *, method="two_interval", task="t", standard=1.2, seed=3, each=40, levels=LEVELS
):
    """Return answers of observers: {name: threshold at half-way, µm peak to peak}."""
    rng = np.random.default_rng(seed)
    guess = {"two_interval": 1 / 2, "three_interval": 1 / 3}[method]
    curve = CURVES["weibull"]
    rows = []
    for who, threshold in people.items():
        for level in np.repeat(levels, each):
            z = float(curve.inverse(np.array(0.5))) + SLOPE * np.log(level / threshold)
            p = guess + (1 - guess - LAPSE) * float(curve.distribution(np.array(z)))
            rows.append(
                {
                    "participant_id": who,
                    "task": task,
                    "method": method,
                    "trial": len(rows) + 1,
                    "catch": False,
                    "standard_level": standard,
                    "track_level": float(level),
                    "correct": bool(rng.random() < p),
                }
            )
    frame = pd.DataFrame(rows).reindex(columns=list(COLUMNS))
    return frame.assign(participant_id=pd.Categorical(frame["participant_id"]))


@pytest.mark.parametrize("method", ["two_interval", "three_interval"])
def test_the_populations_threshold_and_weber_fraction_are_recovered(method):
    rng = np.random.default_rng(11)
    truth = np.exp(rng.normal(np.log(0.1), 0.25, 8))
    people = {f"sub-{number:02d}": value for number, value in enumerate(truth)}
    (found,) = thresholds(trials(people, method=method))
    own = np.array([each.function.threshold_level.value for each in found.participants])
    error = np.log(own) - np.log(truth)
    assert abs(error.mean()) < 3 * error.std(ddof=1) / np.sqrt(8)
    assert found.population.n == 8
    assert found.weber_fraction.value == pytest.approx(
        found.population.threshold_level.value / 1.2, rel=1e-9
    )
    low, high = found.weber_fraction.interval
    assert low < np.exp(np.log(truth).mean()) / 1.2 < high


def test_catch_trials_are_counted_and_take_no_part_in_a_participants_own_fit():
    plain = trials({"sub-01": 0.1})
    catches = plain.head(6).assign(track_level=5.0, correct=[False] * 5 + [True], catch=True)
    (found,) = thresholds(pd.concat([plain, catches], ignore_index=True))
    (alone,) = thresholds(plain)
    (one,), (other,) = found.participants, alone.participants
    assert (one.catch_trials, one.catch_correct) == (6, 1)
    assert (one.trials, one.function) == (other.trials, other.function)


LAPSES_UNKNOWN = "Without catch trials, the lapse rate"


def test_a_participant_without_an_own_threshold_is_named_and_counts_in_the_populations():
    people = {"sub-01": 0.1, "sub-02": 0.12, "sub-03": 0.09, "sub-04": 1e-6}
    frame = trials(people)
    frame.loc[frame["participant_id"] == "sub-04", "correct"] = True
    (found,) = thresholds(frame)
    assert isinstance(found.participants[3].function, NotComputed)
    assert found.population.n == 4
    assert LAPSES_UNKNOWN in " ".join(remarks(found, 0.95, PLATE_AMPLITUDE))
    caught = replace(found, participants=(replace(found.participants[0], catch_trials=4),))
    assert LAPSES_UNKNOWN not in " ".join(remarks(caught, 0.95, PLATE_AMPLITUDE))
    compared = " ".join(remarks(replace(found, method="comparison"), 0.95, PLATE_AMPLITUDE))
    assert "just noticeable difference is too small (by 6 %" in compared


def test_a_poor_fit_is_explained_if_each_curve_pools_conditions():
    (found,) = thresholds(trials({"sub-01": 0.1, "sub-02": 0.12, "sub-03": 0.09}))
    people = tuple(
        replace(each, fit=SimpleNamespace(p=0.01 if place else 0.5, simulations=1))
        for place, each in enumerate(found.participants)
    )
    poor = replace(found, participants=people)
    text = "2 of 3 individual curves fit poorly (p < .05)"
    assert remarks(poor, 0.95, PLATE_AMPLITUDE)[0] == f"{text}."
    several = replace(poor.population, sd_log_slope=NotComputed("one slope"))
    first, *_ = remarks(replace(poor, population=several), 0.95, PLATE_AMPLITUDE)
    assert first == f"{text}{POOLED}."


def test_the_answer_has_a_threshold_for_each_condition_and_names_the_tests_result():
    people, parts = ("sub-01", "sub-02", "sub-03", "sub-04"), []
    for hz, threshold in (("80", 0.1), ("180", 0.2), ("400", 0.1)):
        own = trials(dict.fromkeys(people, threshold), standard=np.nan, seed=int(hz))
        parts.append(own.assign(**{"factor: frequency_hz": hz}))
    (found,) = thresholds(pd.concat(parts, ignore_index=True))
    by_frequency, pooled = answers(found, 0.95, PLATE_AMPLITUDE)
    values, tests = by_frequency.split(" Thresholds ")
    assert re.fullmatch(
        r"Detection threshold \(t\) by frequency: 0.0998 µm, 95% CI \[0.0\d+, 0.1\d+\] \(80 Hz\); "
        r"0.210 µm, .* \(180 Hz\); 0.0965 µm, .* \(400 Hz\)\.",
        values,
    )
    assert re.fullmatch(
        r"differed between 80 Hz and 180 Hz \(p [=<] .001\) and between 180 Hz and 400 Hz "
        r"\(p [=<] .001\), and could not be shown to differ, because "
        r"there are too few participants to test it, between 80 Hz and 400 Hz \(p = .\d+\), "
        r"after Holm's correction\.",
        tests,
    )
    assert pooled.startswith("Detection threshold (t), averaged over frequency: 0.")
    untested = replace(
        found.population, factors=(), sd_log_slope=NotComputed("one slope is fitted")
    )
    (alone,) = answers(replace(found, population=untested), 0.95, PLATE_AMPLITUDE)
    assert alone.startswith("Detection threshold (t), averaged over sessions and conditions: ")


@pytest.mark.parametrize(
    "sd, words", [(0.0, "estimated to be equal"), (0.3, "is a factor of 1.35")]
)
def test_equal_slopes_are_called_equal(sd, words):
    (found,) = thresholds(trials({"sub-01": 0.1, "sub-02": 0.12, "sub-03": 0.09}))
    own = replace(found, population=replace(found.population, sd_log_slope=sd))
    assert f"participants' slopes {'are ' if sd == 0 else ''}{words}" in " ".join(
        remarks(own, 0.95, PLATE_AMPLITUDE)
    )


def test_two_participants_have_thresholds_and_no_population():
    (found,) = thresholds(trials({"sub-01": 0.1, "sub-02": 0.1}))
    assert isinstance(found.population, NotComputed)
    assert isinstance(found.weber_fraction, NotComputed)
    assert found.participants[0].function.threshold_level.value > 0


def test_detection_has_no_standard_and_no_weber_fraction():
    (found,) = thresholds(trials({"sub-01": 0.1}, standard=np.nan))
    assert found.standard_level is None
    assert "standard" in found.participants[0].weber_fraction.reason


def test_each_task_is_analysed_by_itself():
    both = [trials({"sub-01": 0.1}, task="a"), trials({"sub-01": 0.3}, task="b")]
    first, second = thresholds(pd.concat(both, ignore_index=True))
    assert (first.task, second.task) == ("a", "b")
    a, b = (each.participants[0].function.threshold_level.value for each in (first, second))
    assert a < b


def test_without_trials_it_is_said():
    empty = trials({"sub-01": 0.1}).head(0)
    assert thresholds(empty) == NotComputed("no trials of forced choice")


def test_a_drawn_curve_reaches_what_was_observed_at_the_outermost_level():
    rows = trials({"p": 0.1}).assign(correct=lambda frame: frame["track_level"] > 0.05)
    (found,) = thresholds(rows)
    line = found.participants[0].function
    assert line.lapse > 0.005
    assert within_answers(line, rows).lapse == 0
    missed = rows.assign(correct=rows["correct"] & (rows.index % 10 > 0))
    assert within_answers(line, missed) == line


def test_a_threshold_beyond_the_presented_levels_is_called_extrapolated():
    """An observer near chance got a threshold of 19.6 from levels of 1 to 6, without a word."""
    rng = np.random.default_rng(5)
    people = [
        trials({"sub-01": 0.1}, standard=np.nan, seed=1),
        trials({"sub-02": 0.1}, standard=np.nan, seed=2),
    ]
    chance = trials({"sub-03": 0.1}, standard=np.nan, seed=3)
    top = chance["track_level"] == chance["track_level"].max()
    share = np.where(top, 0.65, 0.5)
    people.append(chance.assign(correct=rng.random(len(chance)) < share))
    (found,) = thresholds(pd.concat(people, ignore_index=True))
    beyond = [each.participant for each in found.participants if each.extrapolated]
    text = " ".join(remarks(found, 0.95, PLATE_AMPLITUDE))
    levels = chance.loc[~chance["catch"], "track_level"]
    assert found.participants[0].presented_levels == (levels.min(), levels.max())
    for each in found.participants:
        told = f"{each.participant}'s threshold, " in text
        assert told is (each.participant in beyond)
    last = found.participants[-1]
    assert last.extrapolated
    assert last.function.threshold_level.value == pytest.approx(0.4537, abs=0.01)
    assert "sub-01" not in beyond


def test_a_most_likely_threshold_beyond_the_levels_is_refused_alone_and_among_many():
    easy = Answers.of_trials([1.0] * 20 + [2.0] * 20, [False] * 2 + [True] * 38)
    usual = Answers.of_trials([1.0] * 20 + [2.0] * 20, [False] * 9 + [True] * 11 + [True] * 20)
    assert "below" in fit_threshold(easy).reason
    values = threshold_values([easy, usual], method="two_interval", curve="weibull")
    assert np.isnan(values).tolist() == [True, False]
    assert values[1] == pytest.approx(fit_threshold(usual).threshold_level.value, rel=1e-3)
