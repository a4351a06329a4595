"""Which protocol: the sessions' own answers, the analysis' own thresholds, the same minutes."""

import csv
import json
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from slipscale import commands
from slipscale.analysis.load import load
from slipscale.analysis.planning.protocols.answers import answers_of, read_answers
from slipscale.analysis.planning.protocols.conditions import _rows
from slipscale.analysis.planning.protocols.output import sentences
from slipscale.analysis.planning.protocols.precision import protocol_precision, thresholds_of
from slipscale.analysis.planning.protocols.studies import filling, protocol_study
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.psychometric_function import Answers
from slipscale.analysis.statistics.psychometrics.thresholds import fit_threshold
from slipscale.analysis.tasks.thresholds.statistics import CURVE_OF, curve_of
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.experiments.study.factors import Factor
from slipscale.experiments.study.file import study_text
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError

PEOPLE = Population()


@cache
def study(name):
    return protocol_study(name)


def two_sided(folder):
    """Return a constant-stimuli study with comparisons below and above the standard."""
    text = study_text("constant_stimuli")
    for old, new in {
        "[1.2, 1.23, 1.26, 1.32, 1.4, 1.6]": "[1.0, 1.1, 1.15, 1.2, 1.25, 1.3, 1.4]",
        "[1.23, 1.26, 1.32, 1.4, 1.6]": "[1.0, 1.1, 1.15, 1.25, 1.3, 1.4]",
        '"forced_choice"': '"yes_no"',
        "repetitions = 20": "repetitions = 12",
    }.items():
        assert old in text
        text = text.replace(old, new)
    file = folder / "two_sided.toml"
    file.write_text(text, encoding="utf-8")
    return str(file)


@pytest.mark.parametrize("name", ["difference_threshold", "two sided"])
def test_thresholds_are_those_of_a_pilot_s_data_set(name, tmp_path):
    """Everybody's, but for where the search stops: the same people, the report's own function."""
    name = two_sided(tmp_path) if name == "two sided" else name
    plans = pilot_plans(name, participants=3, seed=4, language=None, population=PEOPLE)
    run_pilot(tmp_path / "pilot", plans, spec="mock", tell=lambda _: None)
    rows = load(tmp_path / "pilot").trials["forced_choices"]
    expected = []
    for _, own in rows[~rows["catch"]].groupby("participant_id", observed=True):
        method = own["method"].iloc[0]
        answers = Answers.of_trials(own["track_level"].tolist(), own["correct"].tolist())
        fitted = fit_threshold(answers, method=method, curve=CURVE_OF.get(method, "weibull"))
        if isinstance(fitted, NotComputed):
            expected.append(np.nan)
        elif method == "comparison":  # half the distance between 25 and 75 % of a normal curve
            jumps = isinstance(fitted.slope, NotComputed) and "jump" in fitted.slope.reason
            expected.append(np.nan if jumps else 0.6744897501960817 / fitted.slope_value)
        else:
            expected.append(fitted.threshold_level.value)
    answered = answers_of(protocol_study(name), 3, 4, PEOPLE).people
    assert len(expected) == 3
    found = thresholds_of(answered, AnalysisChoices())
    assert found == pytest.approx(expected, rel=1e-4, nan_ok=True)
    assert np.isfinite(expected).any()


def test_thresholds_are_planned_on_the_axis_and_at_the_share_of_the_study():
    study = protocol_study("difference_threshold")
    answered = answers_of(study, 3, 4, PEOPLE).people
    values = []
    for asked in ({"axis": "linear"}, {"axis": "logarithmic"}, {"threshold_share": 0.8}):
        choices = AnalysisChoices(**asked)
        curve, share = curve_of("two_interval", choices), choices.threshold_share
        expected = [
            fit_threshold(each.answers, method="two_interval", curve=curve, share=share)
            for each in answered
        ]
        levels = [each.threshold_level.value if each else np.nan for each in expected]
        found = thresholds_of(answered, choices)
        assert found == pytest.approx(levels, rel=1e-4, nan_ok=True)
        values.append(found)
    assert study.choices == AnalysisChoices()
    text = study.text + '\n[analysis]\naxis = "linear"\n'
    assert replace(study, text=text).choices.axis == "linear"
    assert np.nanmin(values[2] / values[1]) > 1.02
    assert not np.allclose(values[0], values[1], rtol=1e-3, equal_nan=True)


def test_a_study_is_filled_up_to_the_minutes_and_not_beyond():
    for name in ("biet2007", "detection_threshold"):
        filled = filling(study(name), 4.0, PEOPLE)
        more = filled.with_number(filled.number + 8)
        assert filled.minutes(PEOPLE) == pytest.approx(4.0, rel=0.12)
        assert more.minutes(PEOPLE) > 4.0
        assert f"{filled.amount} = {filled.number}" in filled.text


@pytest.mark.parametrize("name", ["biet2007", "detection_threshold", "constant_stimuli"])
def test_minutes_that_an_error_suggests_are_enough(name):
    with pytest.raises(UserError) as error:
        filling(study(name), 0.01, PEOPLE)
    suggested = float(re.search(r"takes about ([\d.]+) minutes", str(error.value))[1])
    assert filling(study(name), suggested, PEOPLE).number == 1


def test_what_a_study_answers_is_told_by_its_tasks():
    assert study("biet2007").quantity == "exponent"
    assert study("detection_threshold").quantity == "detection threshold"
    assert study("constant_stimuli").quantity == "difference threshold at 1.2 µm"


def test_more_people_and_more_minutes_are_more_precise():
    short, long = (filling(study("biet2007"), minutes, PEOPLE) for minutes in (2.5, 10.0))
    few, many = protocol_precision(short, [6, 24], studies=200, seed=1, population=PEOPLE)
    (longer,) = protocol_precision(long, [6], studies=200, seed=1, population=PEOPLE)
    assert many.half_width_percent < 0.6 * few.half_width_percent
    assert longer.half_width_percent < few.half_width_percent
    assert longer.trials > few.trials


def test_a_study_in_which_nobody_answers_has_no_interval_and_that_is_said():
    nobody = Population(habits={"dropout": 1.0})
    (row,) = protocol_precision(
        study("detection_threshold").with_number(4), [3], studies=2, seed=1, population=nobody
    )
    assert row.without == 1.0
    assert np.isnan(row.half_width_percent)
    assert "no study yields an interval" in " ".join(sentences([row], 5.0, "nobody"))


def test_the_comparison_is_told_in_words_and_written(capsys, tmp_path):
    words = ["power", "biet2007", "--protocols", "detection_threshold", "--minutes", "4"]
    more = ["--studies", "2", "--participants", "4,3"]
    assert commands.main([*words, *more, "--out", str(tmp_path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "…" not in said
    assert "the same simulated people (population 'biet2007') and as many trials" in said
    assert "exponent, 3 participants: biet2007 estimates it to within ±" in said
    assert "answer different questions" in said
    with (tmp_path / "protocols.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    told = json.loads((tmp_path / "protocols.json").read_text(encoding="utf-8"))["rows"]
    assert [row["study"] for row in rows] == ["detection_threshold"] * 2 + ["biet2007"] * 2
    assert float(rows[0]["half_width_percent"]) == told[0]["half_width_percent"]
    assert (tmp_path / "protocols.svg").stat().st_size > 1000


@pytest.mark.parametrize(
    "words, expected",
    [
        (["--protocols", "paired_comparison"], "paired_comparison: no task ("),
        (["--protocols", "matching"], "matching: no task ("),
        (["--protocols", "no-such-study"], "no-such-study"),
        (["--protocols", "detection_threshold", "--minutes", "1"], "--minutes 1: "),
        (["--protocols", "detection_threshold", "--minutes", "-3"], "--minutes -3"),
        (["--protocols", "detection_threshold", "--minutes", "nan"], "--minutes nan"),
        (["--minutes", "5"], "--minutes 5: expected --protocols as well"),
        (["--protocols", "detection_threshold", "--effect", "0.5"], "--effect cannot be combined"),
        (["--protocols", "detection_threshold", "--looks", "3"], "--looks cannot be combined"),
        (["--protocols", "detection_threshold", "--participants", "2"], "--participants 2"),
    ],
)
def test_nonsense_is_refused_in_one_sentence(capsys, words, expected):
    assert commands.main(["power", "biet2007", *words]) == 2
    said = capsys.readouterr().err
    assert expected in said
    assert "expected" in said
    assert said.count("\n") == 1


def test_a_protocol_without_simulated_answers_is_refused_in_a_sentence(capsys, monkeypatch):
    monkeypatch.setattr(RunPlan, "simulated_answers", lambda _: {})
    assert commands.main(["power", "detection_threshold", "--protocols", "biet2007"]) == 2
    said = capsys.readouterr().err
    assert "no simulated participant can answer" in said
    assert said.count("\n") == 1


def test_a_study_is_refused_by_its_name():
    with pytest.raises(UserError, match="--protocols matching: no task "):
        protocol_study("matching")


def test_an_exponent_of_ratios_is_the_slope_of_logarithms_without_catch_trials():
    amplitudes = [0.0, 0.3, 0.6, 2.3, 1.2]
    rows = pd.DataFrame(
        {
            "comparison_level": amplitudes * 2,
            "ratio": [0.1, *((each / 1.2) ** 0.8 for each in amplitudes[1:4]), 5.0] * 2,
            "catch": ["false"] * 4 + ["true"] + ["false"] * 4 + ["true"],
        }
    )
    answered = read_answers(study("ratio_to_standard"), rows)
    assert answered.exponent == pytest.approx(0.8)
    assert study("ratio_to_standard").quantity == "exponent"


BY_CONDITION = """
name = "hands"
title = "Hands"
seed = 1
participants = 4
amplitudes_um_pp = [0.0, 1.2, 2.3]
[[factors]]
name = "speed"
levels = [5.0, 10.0]
[[factors]]
name = "hand"
levels = ["left", "right"]
simulated = { left = 3.0 }
[[tasks]]
protocol = "constant_stimuli"
standard_um_pp = 1.2
comparisons_um_pp = [1.21, 1.23, 1.26, 1.32, 1.4, 1.6]
repetitions = 8
"""


def test_thresholds_by_condition_have_a_power(tmp_path, capsys):
    """A sensation three times as strong: thresholds are lower on the left, for everybody."""
    (tmp_path / "hands.toml").write_text(BY_CONDITION)
    command = ["power", str(tmp_path / "hands.toml"), "--participants", "6", "--studies", "1"]
    assert commands.main([*command, "--out", str(tmp_path / "out")]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "hand: 6 participants or more reach a power of 0.8." in said
    assert "speed: no effect is simulated" in said
    rows = list(csv.DictReader((tmp_path / "out" / "conditions.csv").read_text().splitlines()))
    assert [(row["factor"], row["first"], row["second"]) for row in rows] == [
        ("speed", "5", "10"),
        ("hand", "left", "right"),
    ]
    assert float(rows[1]["change"]) == pytest.approx(3, rel=0.5)
    assert commands.main([*command, "--repetitions", "3"]) == 2
    assert "--repetitions cannot be combined with the thresholds" in capsys.readouterr().err


def test_results_do_not_depend_on_the_folder_of_the_study_file(tmp_path):
    minutes = []
    for folder in (tmp_path, tmp_path / "elsewhere"):
        folder.mkdir(exist_ok=True)
        (folder / "hands.toml").write_text(BY_CONDITION)
        minutes.append(protocol_study(str(folder / "hands.toml")).minutes(Population()))
    assert minutes[0] == minutes[1]


def test_conditions_are_compared_by_paired_t_tests_averaged_over_other_factors():
    values = np.random.default_rng(3).normal(size=(300, 6, 2, 3))
    values[..., 1] += 1
    values[0, 0, 0, 0] = np.nan
    factors = [Factor(name="a", levels=("x", "y")), Factor(name="b", levels=("p", "q", "r"))]
    found = {
        (row.factor, row.first, row.second): row
        for row in _rows(values, factors, 0.05, logarithmic=True)
    }
    p = stats.ttest_rel(values[1:, :, 0].mean(axis=2), values[1:, :, 1].mean(axis=2), axis=1).pvalue
    assert found["a", "x", "y"].power.value == pytest.approx((p < 0.05).mean(), abs=1 / 300)
    assert found["b", "p", "q"].power.value > found["b", "p", "r"].power.value
    assert found["b", "p", "q"].change == pytest.approx(np.e, rel=0.15)
