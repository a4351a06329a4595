"""Factors that are crossed with the levels of a study."""

import itertools
import math
import re
from collections import Counter
from dataclasses import replace

import pytest

from slipscale.analysis.load import load
from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.participants.simulated_people.bare_run import bare_run
from slipscale.experiments.participants.simulated_people.growth import people_for
from slipscale.experiments.running.begin_or_resume import plate_for
from slipscale.experiments.running.rehearsal import _answer
from slipscale.experiments.steps.replies import Voided
from slipscale.experiments.steps.steps import Ask, EndTrial, Instruct, Present
from slipscale.experiments.study.factors import conditions_of, ordered
from slipscale.experiments.study.file import parse_study, study_text
from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock

STUDY = """
name = "crossed"
title = "Period, speed and direction"
vary = "spatial_period_mm"
spatial_periods_mm = [3.0, 5.0]
[stimulus]
mean_um_pp = 1.0
depth_um_pp = 1.0
waveform = "square"
finger_speed_mm_s = 50.0
[[factors]]
name = "finger_speed_mm_s"
levels = [20.0, 50.0]
[[factors]]
name = "direction"
levels = ["left", "right"]
[factors.instructions.en]
left = "Stroke to the left."
right = "Stroke to the right."
[[tasks]]
protocol = "magnitude_estimation"
practice = 0
[[tasks]]
protocol = "constant_stimuli"
standard_mm = 3.0
repetitions = 1
practice = 0
"""


@pytest.fixture
def crossed_run(plan):
    people = people_for(parse_study(STUDY, "crossed.toml"))
    return plan(STUDY, seed=3, population=people.model_dump_json())


def rows(folder, task):
    (path,) = folder.glob(f"sub-*/beh/*_task-{task}_*_beh.tsv")
    header, *lines = [line.split("\t") for line in path.read_text().splitlines()]
    return [dict(zip(header, line, strict=True)) for line in lines]


def test_each_condition_has_all_levels_and_its_columns_and_survives_a_kill(
    crossed_run, laboratory, tmp_path
):
    laboratory.folder = tmp_path / "whole"
    assert laboratory.run(crossed_run) == "complete"
    build_dataset(laboratory.folder)
    whole = rows(laboratory.folder, "magnitudeestimation")
    seen = Counter((r["finger_speed_mm_s"], r["direction"], r["spatial_period_mm"]) for r in whole)
    assert set(seen.values()) == {1}
    assert len(seen) == crossed_run.planned_trials() / 2 == 8
    assert [row["trial"] for row in whole] == [str(number) for number in range(1, 9)]
    assert "finger_speed_mm_s" in rows(laboratory.folder, "constantstimuli")[0]
    assert sorted(load(laboratory.folder).estimates["level"].unique()) == [3, 5]
    path = crossed_run.journal_path(laboratory.folder)
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[: len(lines) // 3]))
    assert laboratory.run(crossed_run) == "complete"
    build_dataset(laboratory.folder)
    assert rows(laboratory.folder, "magnitudeestimation") == whole


def test_simulated_people_feel_less_where_the_study_says_so(crossed_run):
    halved = STUDY.replace('"right"]', '"right"]\nsimulated = { right = 0.5 }')
    half = people_for(parse_study(halved, "crossed.toml"))
    felt = {
        (people.effects, step.trial.factors["direction"], step.trial.number): answer.value
        for people in (half, half.model_copy(update={"effects": ()}))
        for step, answer, _ in bare_run(crossed_run, people)
        if isinstance(step, Ask) and step.name == "estimate"
    }
    for (effects, direction, number), value in felt.items():
        share = 0.5 if effects and direction == "right" else 1.0
        assert value == pytest.approx(share * felt[(), direction, number], abs=0.51)


def test_simulated_people_can_differ_in_growth_and_in_the_effect_itself(crossed_run):
    text = STUDY.replace(
        '"right"]', '"right"]\nsimulated_growth = { right = 2 }\nsimulated_sd = 0.3'
    )
    people = people_for(parse_study(text, "crossed.toml"))
    alike = people.model_copy(update={"effect_sds": ()})
    assert alike.in_condition(50.0, {"direction": "right"}, dict[str, float]().__getitem__) == 25
    own = {"effect of direction left": 1.0, "effect of direction right": -1.0}
    for level, percent in (("left", 50 * math.exp(0.3)), ("right", 25 * math.exp(-0.3))):
        found = people.in_condition(50.0, {"direction": level}, own.__getitem__)
        assert found == pytest.approx(percent)
    felt = [
        [step.answer for step in bare_run(crossed_run, each) if isinstance(step.step, Ask)]
        for each in (people, alike)
    ]
    assert felt[0] != felt[1]


def test_a_condition_is_told_before_it_and_changes_the_stimulus(crossed_run):
    told, speeds, directions = [], [], []
    steps = crossed_run.tasks()[0][0].steps(crossed_run.study.tasks[0], crossed_run.context("m"))
    answer = None
    for _ in range(100):
        try:
            step = steps.send(answer)
        except StopIteration:
            break
        answer = _answer(step, 0.0)
        if isinstance(step, Instruct) and step.text.startswith("Stroke to"):
            told.append(step.text)
        if isinstance(step, Present):
            factors = step.trial.factors
            assert step.surface.made.finger_speed_mm_s == factors["finger_speed_mm_s"]
            assert told[-1] == f"Stroke to the {factors['direction']}."
            speeds.append(factors["finger_speed_mm_s"])
            directions.append(factors["direction"])
    assert len(told) == 4
    assert Counter(zip(speeds, directions, strict=True)).most_common(1)[0][1] == 2


def test_a_voided_trial_of_a_later_condition_is_repeated_in_that_condition(crossed_run):
    steps = crossed_run.tasks()[0][0].steps(crossed_run.study.tasks[0], crossed_run.context("m"))
    answer, ended = None, []
    while True:
        try:
            step = steps.send(answer)
        except StopIteration:
            break
        answer = _answer(step, 0.0)
        if isinstance(step, EndTrial):
            ended.append(step.trial)
            if step.trial.number == 3:
                answer = Voided(trials=(3,))
    numbers = [(trial.number, trial.repeats) for trial in ended]
    assert numbers[:6] == [(1, None), (2, None), (3, None), (4, None), (5, 3), (6, None)]
    assert ended[4].factors["direction"] == ended[2].factors["direction"]
    assert ended[5].factors != ended[4].factors


def test_over_participants_each_condition_follows_each_other_equally_often(crossed_run):
    conditions = conditions_of(crossed_run.study.factors)
    pairs, first = Counter(), Counter()
    for row in range(4):
        context = replace(crossed_run.context("m"), row=row)
        labels = [each.label for each in ordered(conditions, context)]
        first[labels[0]] += 1
        pairs.update(itertools.pairwise(labels))
    assert set(first.values()) == {1}
    assert len(pairs) == 12
    assert set(pairs.values()) == {1}


@pytest.mark.parametrize(
    "old, new, said",
    [
        ('"left", "right"]', '"left", "left"]', "expected different values"),
        ('name = "direction"', 'name = "phase"', "'phase' is already a column of every task"),
        ('name = "direction"', 'name = "level"', "'level' is already a column of every task"),
        (
            'name = "direction"',
            'name = "catch"',
            "the protocol's column 'catch' has the name of a factor",
        ),
        ('"finger_speed_mm_s"\nl', '"spatial_period_mm"\nl', "spatial_period_mm is already varied"),
        ("[20.0, 50.0]", "[20.0, 360.0]", "reproduces only 19.5% of a sinusoidal depth"),
        ("[20.0, 50.0]", '["slow", "fast"]', "expected numbers, not 'slow'"),
        ('right = "Stroke to the right."', "", "expected a text in 'en' for each level"),
        ("left = ", "up = ", "unknown levels up; expected levels of the factor"),
    ],
)
def test_factors_that_contradict_the_study_are_refused(old, new, said):
    assert old in STUDY
    with pytest.raises(UserError, match=said):
        parse_study(STUDY.replace(old, new), "crossed.toml")


@pytest.mark.parametrize(
    "old, new, said",
    [
        ("second_voltage_v_peak", "voltage", "requires a factor named second_voltage_v_peak"),
        ("[0.0, 100.0]", "[0.0, 151.0]", "to be numbers from 0 to 150 V peak"),
        ("[0.0, 100.0]", '["off", "on"]', "to be numbers from 0 to 150 V peak"),
    ],
)
def test_a_second_actuator_has_a_factor_with_levels_within_its_limit(old, new, said):
    text = study_text("vezzoli2015").replace(old, new).replace("{ 100 = 0.7 }", "{}")
    with pytest.raises(UserError, match=re.escape(said)):
        parse_study(text, "vezzoli2015")


@pytest.mark.parametrize(
    "study, spec, said",
    [
        ("vezzoli2015", "scpi:COM1", "has a [second_plate]"),
        ("vezzoli2015", "pair:mock+mock+mock", "expected two SPECs"),
        ("vezzoli2015", "pair:mock+", "expected two SPECs"),
        ("biet2007", "pair:mock+mock", "no ["),
    ],
)
def test_a_study_with_a_second_actuator_needs_a_pair_and_no_other_study_does(
    study, spec, said, plan
):
    made = plan(study_text(study), study_name=study)
    with pytest.raises(UserError, match=re.escape(said)):
        plate_for(made, spec, VirtualClock())
