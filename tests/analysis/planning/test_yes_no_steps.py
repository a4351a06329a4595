"""Catch steps in planning: the session's own answers, and what their number tells."""

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from slipscale import commands
from slipscale.analysis.planning.power.answers import rows
from slipscale.analysis.planning.power.design import design_of
from slipscale.analysis.planning.power.grid import Condition
from slipscale.analysis.planning.power.run_grid import run_grid, shards
from slipscale.analysis.planning.power.shard import Looks
from slipscale.analysis.planning.power.yes_no_steps import (
    CATCH_WIDTH,
    D_PRIME_LOW,
    StepAnswers,
    StepTask,
    precision,
    simulate_steps,
)
from slipscale.analysis.tasks.difference.proportions import exact_interval
from slipscale.experiments.participants.simulated_people.bare_run import bare_run
from slipscale.experiments.participants.simulated_people.habits import Habits
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.pilot import pilot_plans
from slipscale.experiments.steps.steps import Ask, Present
from slipscale.experiments.study.file import read_study

REFERENCE = Path(__file__).parents[2] / "data" / "power_reference" / "catch_steps.csv"
STUDY, TEXT = read_study("biet2007")
DESIGN = design_of(STUDY, TEXT, Population(), 0.05)
# Steps that are missed now and then, and people who lapse and give up.
PEOPLE = Population(noise=9.0, habits=Habits(lapses=0.1, dropout=0.3))


def test_the_study_s_own_series_is_found():
    assert DESIGN.steps == StepTask(
        descent_level=(2.3, 1.2, 0.5, 0.0), series=1, catch_steps=1, trials_after=8
    )


def test_more_catch_steps_are_more_trials_before_the_estimates():
    task = DESIGN.task_of(Condition(participants=8, catch_steps=4))
    assert task.trials_before == DESIGN.task.trials_before + 3
    assert DESIGN.task_of(Condition(participants=8)) == DESIGN.task


def sessions(people, participants):
    """Return (removed µm, "yes") of every step of people who answer the protocol itself."""
    found = []
    plans = pilot_plans(
        "biet2007", participants=participants, seed=5, language="en", population=people
    )
    for plan in plans:
        removed = None
        for step, answer, _ in bare_run(plan, people):
            if isinstance(step, Present) and step.trial and step.lead_in:
                before = step.lead_in[0].surface.level
                removed = round(before - step.surface.level, 6)
            if isinstance(step, Ask) and step.name == "difference_felt":
                found.append((removed, bool(answer.value)))
    return np.array(found)


def test_steps_are_noticed_as_often_as_in_sessions_within_the_error():
    theirs = sessions(PEOPLE, 700)
    ours = simulate_steps(
        DESIGN.steps, participants=700, studies=20, population=PEOPLE, rng=np.random.default_rng(1)
    )
    removed, felt = ours.removed_level.round(6), ours.felt
    assert sorted(set(theirs[:, 0])) == [0.0, 0.5, 0.7, 1.1]
    for size in (0.0, 0.5, 0.7, 1.1):
        p = theirs[theirs[:, 0] == size, 1]
        q = felt[(removed == size) & ~np.isnan(felt)]
        error = np.sqrt(q.mean() * (1 - q.mean()) / len(p))
        assert abs(p.mean() - q.mean()) < 4 * error, size
        assert 0.05 < q.mean() < 0.95
        # Who gives up answers no more, in both.
        assert len(p) / 700 == pytest.approx(len(q) / 700 / 20, abs=0.06)


def test_the_width_is_the_report_s_interval_of_one_answer_each():
    """Eight people, one catch step each, two of whom say yes: Clopper and Pearson's own."""
    removed = np.tile([1.1, 0.0], (1, 8, 1))
    felt = np.stack([np.ones(8), np.arange(8) < 2], axis=1)[None].astype(float)
    told = precision(StepAnswers(removed_level=removed, felt=felt), 0.95)
    expected = exact_interval(2, 8)
    assert told[CATCH_WIDTH].mean == pytest.approx((expected.high - expected.low) / 2)
    assert told[D_PRIME_LOW].n == 1


def reference():
    with REFERENCE.open() as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


@pytest.mark.parametrize("case", reference(), ids=lambda case: f"{case['catch_steps']:g}")
def test_steps_and_intervals_are_those_of_r_s_simulation_of_the_same_model(case):
    """Model and interval written once more in R: tests/data/power_reference/catch_steps.R."""
    studies, people = 400, int(case["participants"])
    answers = simulate_steps(
        replace(DESIGN.steps, catch_steps=int(case["catch_steps"])),
        participants=people,
        studies=studies,
        population=Population(noise=case["noise"]),
        rng=np.random.default_rng(2),
    )
    sizes = {"felt_1": 1.1, "felt_2": 0.7, "felt_3": 0.5, "felt_catch": 0.0}
    for name, size in sizes.items():
        q = answers.felt[answers.removed_level.round(6) == size].mean()
        # People differ: a share's error is that of people, not of answers.
        error = np.sqrt(max(q * (1 - q), 1e-4) / (studies * people))
        assert abs(q - case[name]) < 4 * error, name
    told = precision(answers, 0.95)[CATCH_WIDTH]
    assert abs(told.mean - case["half_width"]) < 4 * np.hypot(told.error, case["error"])


def test_without_catch_steps_nothing_is_told():
    task = replace(DESIGN.steps, catch_steps=0)
    answers = simulate_steps(
        task, participants=6, studies=3, population=Population(), rng=np.random.default_rng(1)
    )
    told = precision(answers, 0.95)
    assert told[CATCH_WIDTH].n == told[D_PRIME_LOW].n == 0


def test_more_catch_steps_tell_false_alarms_more_precisely():
    wanted = [Condition(participants=8, catch_steps=number) for number in (1, 4)]
    outcomes = run_grid(shards(DESIGN, wanted, studies=5, seed=1))
    few, many = rows(DESIGN, wanted, outcomes, looks=Looks())
    assert many.steps[CATCH_WIDTH].mean < 0.8 * few.steps[CATCH_WIDTH].mean
    assert many.steps[D_PRIME_LOW].mean > few.steps[D_PRIME_LOW].mean


def test_what_catch_steps_tell_is_written_as_figure_and_columns(capsys, tmp_path):
    words = ["power", "biet2007", "--participants", "4,5", "--catch-steps", "1,2"]
    assert commands.main([*words, "--studies", "2", "--out", str(tmp_path)]) in {0, 1}
    assert "Catch steps: half-width of the interval" in capsys.readouterr().out
    assert (tmp_path / "catch_steps.svg").stat().st_size > 1000
    with (tmp_path / "power.csv").open(encoding="utf-8") as file:
        found = list(csv.DictReader(file))
    assert {row["catch_steps"] for row in found} == {"1", "2"}
    assert all(0 < float(row["catch_yes_half_width"]) <= 0.5 for row in found)
    assert "lower bound of d" in (tmp_path / "power.html").read_text(encoding="utf-8")
