"""Answers in tables of other laboratories: forced choices, comparisons, counts, conditions."""

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.analysis.tasks.difference.declaration import ANALYSIS as DIFFERENCES
from slipscale.analysis.tasks.difference.statistics import DIFFERENCE
from slipscale.analysis.tasks.thresholds import sentences
from slipscale.analysis.tasks.thresholds.statistics import THRESHOLDS, thresholds
from slipscale.analysis.writing.numbers import bracketed, significant, unit_number
from slipscale.analysis.writing.task_names import task_name
from slipscale.faults import UserError

pytestmark = pytest.mark.usefixtures("without_models")


def mapping(*, stimulus=None, answers=None, **columns):
    columns = {"participant": "who", "stimulus": "level", **columns}
    table = {"columns": columns, "stimulus": stimulus or {"unit": "mPa"}}
    return parse_mapping(table | {"answers": answers or {}}, "here")


def compared(standards=(20, 100)):
    """Four people's comparisons, whose just noticeable difference is a share of the standard."""
    rng = np.random.default_rng(4)
    rows = [
        {"who": who, "level": standard * part, "std": standard, "more": "yes" if more else "no"}
        for who in "abcd"
        for standard in standards
        for part in np.repeat([0.7, 0.8, 0.9, 1.1, 1.2, 1.3], 6)
        for more in [rng.normal(part, 0.15) > 1]
    ]
    return pd.DataFrame(rows).sample(frac=1, random_state=1)


def written(tmp_path, frame):
    frame.to_csv(tmp_path / "data.csv", index=False)
    return tmp_path / "data.csv"


@pytest.mark.parametrize(
    "unit, labels",
    [("mPa", ["answers_20mPa", "answers_100mPa"]), ("Pa", ["answers_0.02Pa", "answers_0.1Pa"])],
)
def test_every_standard_has_its_own_point_of_subjective_equality(tmp_path, unit, labels):
    """All together, their point was 56.8 mPa, near neither."""
    found = mapping(answer="more", reference="std", stimulus={"unit": "mPa", "in_unit": unit})
    analysis = analyse(load(written(tmp_path, compared()), found))
    results = analysis.inference.found(THRESHOLDS)
    assert [each.task for each in results] == labels
    factor = 1 if unit == "mPa" else 1e-3
    for each, standard in zip(results, (20, 100), strict=True):
        assert each.standard_level == pytest.approx(standard * factor)
        assert each.population.threshold_level.value == pytest.approx(standard * factor, rel=0.1)
        assert task_name("Constant stimuli", each.task) == "Constant stimuli"


def test_differences_from_several_standards_are_not_pooled(tmp_path):
    frame = compared().query("level > std").assign(more="yes")
    found = mapping(answer="more", reference="std", answers={"alternatives": 2})
    choices = load(written(tmp_path, frame), found).trials["forced_choices"]
    levels = choices.groupby("task")["track_level"].unique().map(sorted)
    assert levels["answers_20mPa"] == pytest.approx([2, 4, 6])
    assert levels["answers_100mPa"] == pytest.approx([10, 20, 30])
    alone = load(written(tmp_path, frame.query("std == 20")), found).trials["forced_choices"]
    assert set(alone["task"]) == {"answers"}


def test_a_standard_in_every_trial_is_refused(tmp_path):
    found = mapping(answer="more", reference="std")
    path = written(tmp_path, compared(range(10, 100)))
    with pytest.raises(UserError, match=r"column std: 90 different standards; .*--only std="):
        load(path, found)


def test_trials_of_choices_without_an_answer_are_counted(tmp_path):
    frame = compared(standards=(20,)).reset_index(drop=True)
    frame.loc[:2, "more"] = ""
    frame.loc[3:4, "std"] = None
    data = load(written(tmp_path, frame), mapping(answer="more", reference="std"))
    assert len(data.trials["forced_choices"]) == len(frame) - 5
    assert data.problems == (
        "data.csv: 5 of 144 trials without an answer, a level or a standard are omitted",
    )


def test_blank_yes_no_answers_and_levels_are_counted(tmp_path):
    frame = pd.DataFrame({"who": list("abc") * 8, "level": [2, 4, 6, 8] * 6, "felt": [0, 1] * 12})
    frame = frame.astype({"level": float, "felt": float})
    frame.loc[:2, "felt"] = None
    frame.loc[3:4, "level"] = None
    data = load(written(tmp_path, frame), mapping(answer="felt"))
    assert "data.csv: 5 of 24 trials without an answer, a level or a standard are omitted" in (
        data.problems
    )


def test_the_answers_of_one_person_give_their_own_threshold(tmp_path):
    """The terminal named only too few participants."""
    levels = np.repeat([1.0, 2, 3, 4, 5, 6], 12)
    felt = (np.random.default_rng(3).logistic(3.5, 0.5, len(levels)) < levels).astype(int)
    frame = pd.DataFrame({"who": "a", "level": levels, "felt": felt})
    analysis = analyse(load(written(tmp_path, frame), mapping(answer="felt")))
    (text,) = DIFFERENCES.answers(analysis)
    own = analysis.inference.found(DIFFERENCE).thresholds["a"]
    assert own.threshold_level.value == pytest.approx(3.5, abs=0.4)
    assert text.startswith(f"Threshold of a, the only participant: {own.threshold_level.value:.2f}")
    assert "too few" not in text


@pytest.mark.parametrize(
    "name, unit, note",
    [("dbl", "", 0), ("level", "dB SPL", 1), ("gain_db", "", 1), ("x", "dBA", 1)],
)
def test_only_decibels_are_noted_as_logarithms(tmp_path, name, unit, note):
    frame = compared(standards=(20,)).rename(columns={"level": name})
    found = parse_mapping(
        {
            "columns": {"participant": "who", "stimulus": name, "answer": "more"},
            "stimulus": {"unit": unit} if unit else {"name": name},
        },
        "here",
    )
    problems = load(written(tmp_path, frame), found).problems
    assert sum("already a logarithm" in each for each in problems) == note


def of_conditions():
    rng = np.random.default_rng(4)
    return pd.DataFrame(
        {"who": who, "level": level, "cond": cond, "hit": int(rng.random() < right)}
        for who in "abcde"
        for cond, half in (("low", 2), ("high", 6))
        for level in np.repeat([1, 2, 4, 8], 10)
        for right in [1 - 0.5 * np.exp(-((level / half) ** 1.5))]
    )


def test_thresholds_of_a_forced_choice_are_compared_between_conditions(tmp_path):
    found = mapping(answer="hit", factor="cond", answers={"alternatives": 2})
    analysis = analyse(load(written(tmp_path, of_conditions()), found))
    (factor,) = analysis.inference.found(THRESHOLDS)[0].population.factors
    assert factor.name == "cond"
    high, low = (each.threshold_level.value for each in factor.levels)
    assert high > 2 * low
    assert factor.contrasts[0].p < 0.01


def test_yes_no_answers_are_compared_between_conditions(tmp_path):
    analysis = analyse(
        load(written(tmp_path, of_conditions()), mapping(answer="hit", factor="cond"))
    )
    (found,) = analysis.inference.found(THRESHOLDS)
    (factor,) = found.population.factors
    high, low = (each.threshold_level.value for each in factor.levels)
    assert high > low + 1
    assert factor.contrasts[0].p < 0.01


def test_a_factor_that_differs_between_people_is_refused_with_the_option_for_groups():
    frame = compared(standards=(20,))
    frame["age"] = frame["who"].map(lambda who: "old" if who == frame["who"].iloc[0] else "young")
    assert frame["age"].nunique() == 2
    given = {"participant": "who", "stimulus": "level", "answer": "more", "factor": "age"}
    with pytest.raises(UserError, match=r"column age: .* no factor; .* use --group age"):
        load(frame, **given)


def decibels(*, alternatives):
    generator = np.random.default_rng(1)
    rows = [
        (who, level, int(generator.random() < 0.5 + 0.5 / (1 + np.exp(30 - level))))
        for who in "abc"
        for level in (20, 25, 30, 35, 40)
        for _ in range(20)
    ]
    frame = pd.DataFrame(rows, columns=["who", "level", "correct"])
    given = {"participant": "who", "stimulus": "level:dB", "answer": "correct"}
    return load(frame, **given, alternatives=alternatives)


def test_levels_in_decibels_have_a_linear_axis():
    data = decibels(alternatives=2)
    assert (data.choices.axis, len(data.problems)) == ("linear", 1)
    assert "already a logarithm, so curves have a linear axis unless --axis" in data.problems[0]
    assert thresholds(data.trials["forced_choices"], data.choices)[0].curve == "gumbel"


def test_an_axis_that_is_stated_applies_to_decibels(tmp_path):
    found = mapping(stimulus={"unit": "dB"}, answer="more", reference="std")
    assert load(written(tmp_path, compared(standards=(20,))), found).choices.axis == "linear"
    stated = parse_mapping(
        found.model_dump(exclude_unset=True) | {"analysis": {"axis": "logarithmic"}}, "here"
    )
    data = load(written(tmp_path, compared(standards=(20,))), stated)
    assert (data.choices.axis, data.problems) == ("logarithmic", ())


def test_two_people_have_points_of_equality_in_each_condition():
    generator = np.random.default_rng(1)
    two = pd.DataFrame(
        {"who": who, "level": level, "cond": cond, "more": int(generator.normal(level, 1) > point)}
        for who in "ab"
        for cond, point in (("low", 1), ("high", 2))
        for level in np.repeat([-1, 0, 1, 2, 3, 4], 10)
    )
    data = load(two, participant="who", stimulus="level:mm", answer="more", factor="cond")
    (found,) = thresholds(data.trials["forced_choices"], data.choices)
    (by,) = found.slopes
    by_condition, own = sentences.answers(found, 0.95, data.quantity)
    assert "point of subjective equality" in by_condition
    assert "the mean of the participants' own curves" in by_condition
    assert by.points_level == pytest.approx({"low": 1, "high": 2}, abs=0.3)
    for label, level in by.points_level.items():
        assert f"{significant(level)} mm ({label})" in by_condition
    assert own.count("point of subjective equality of") == 2


def test_an_interval_without_a_limit_is_said_in_words():
    ends = (0.172, float("inf"))
    assert bracketed(ends, lambda value: unit_number(value, 3)) == "[.172, no upper limit]"
    assert bracketed((float("-inf"), 2.0)) == "[no lower limit, 2.00]"
    assert unit_number(float("inf")) == "–"
