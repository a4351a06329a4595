"""Simulated people: the same answers whichever way they are asked, and smooth curves."""

from pathlib import Path

import numpy as np
import pytest

from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.participants.simulated_people.bare_run import bare_run
from slipscale.experiments.participants.simulated_people.habits import REALISTIC
from slipscale.experiments.participants.simulated_people.population import (
    POPULATIONS,
    Population,
    curves,
    read_population,
)
from slipscale.experiments.participants.simulated_people.respondent import Respondent
from slipscale.experiments.running.pilot import gave_up, pilot_plans, run_simulated
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.replies import Adjusted, Reply
from slipscale.experiments.steps.steps import Ask, Explore, Instruct
from slipscale.experiments.steps.trial import Trial
from slipscale.faults import UserError

# Everybody drops out or lapses with the one or the other.
HABITUAL = Population(
    name="habitual", habits=REALISTIC.model_copy(update={"lapses": 0.2, "dropout": 0.5})
)


def answers_of(steps):
    return [
        (step.name, answer.value, answer.response_time_s)
        for step, answer, _ in steps
        if isinstance(step, Ask)
    ]


def asked(records):
    """Return the questions of a journal, each with its answer."""
    begun = {r.data["step"]: r.data["what"] for r in records if r.kind == "begin"}
    done = [(begun[r.data["step"]], r.data["answer"]) for r in records if r.kind == "done"]
    return [
        (what["name"], answer["value"], answer["response_time_s"])
        for what, answer in done
        if what["type"] == "Ask"
    ]


@pytest.mark.parametrize(
    "study, population",
    [
        ("biet2007", Population()),
        ("biet2007", HABITUAL),
        ("constant_stimuli", HABITUAL),
        ("visual_analogue_scale", HABITUAL),
        ("ratio_to_standard", HABITUAL),
    ],
    ids=["default", "habitual", "intervals", "line", "standard"],
)
def test_the_bare_path_gives_the_answers_of_a_full_session(tmp_path, study, population):
    plans = pilot_plans(study, participants=5, seed=3, language="en", population=population)
    for plan in plans:
        run_simulated(tmp_path, plan, "mock")
        records = read_plan(plan.journal_path(tmp_path))[1]
        assert answers_of(bare_run(plan, population)) == asked(records)


def test_the_bare_path_turns_the_plate_as_a_full_session_does(tmp_path):
    plans = pilot_plans("matching", participants=3, seed=3, language="en", population=HABITUAL)
    for plan in plans:
        run_simulated(tmp_path, plan, "mock")
        turned = [
            [level for _, level in record.data["answer"]["trace"]]
            for record in read_plan(plan.journal_path(tmp_path))[1]
            if record.kind == "done" and "trace" in (record.data["answer"] or {})
        ]
        bare = [
            [level for _, level in answer.trace]
            for _, answer, _ in bare_run(plan, HABITUAL)
            if isinstance(answer, Adjusted)
        ]
        assert bare == turned
        assert sum(map(len, turned)) > 10 * len(turned)


def test_a_pilot_of_people_with_habits_is_the_same_wherever_it_was_cut(tmp_path):
    plan, other = pilot_plans(
        "biet2007", participants=2, seed=4, language="en", population=HABITUAL
    )
    for each in (plan, other):
        run_simulated(tmp_path / "whole", each, "mock")
        lines = each.journal_path(tmp_path / "whole").read_bytes().splitlines(keepends=True)
        expected = asked(read_plan(each.journal_path(tmp_path / "whole"))[1])
        for kept in range(5, len(lines) - 1, 13):
            path = each.journal_path(tmp_path / f"cut{kept}")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(b"".join(lines[:kept]))
            run_simulated(tmp_path / f"cut{kept}", each, "mock")
            assert asked(read_plan(path)[1]) == expected, f"cut after {kept} records"


def test_who_drops_out_is_not_asked_on_when_the_pilot_is_called_again(tmp_path):
    everybody = Population(habits=HABITUAL.habits.model_copy(update={"dropout": 1.0}))
    (plan,) = pilot_plans("biet2007", participants=1, seed=4, language="en", population=everybody)
    run_simulated(tmp_path, plan, "mock")
    path = plan.journal_path(tmp_path)
    once = path.read_bytes()
    assert gave_up(read_plan(path)[1])
    run_simulated(tmp_path, plan, "mock")
    assert path.read_bytes() == once


def question(number=1):
    return Ask(
        name="estimate",
        question=NumberQuestion(prompt="?"),
        trial=Trial(task="t", number=number, total=4),
    )


ANSWERS = {("t", "estimate"): lambda _step, person: person.estimate()}


def person(**changes):
    return Respondent(**{"seed": 1, "participant": "01", "answers": ANSWERS} | changes)


def test_a_question_that_a_protocol_repeats_in_a_trial_is_answered_anew():
    one, step, given = person(), question(), []
    explored = Explore(text="", trial=step.trial)
    one.memory.begin(explored)
    one.memory.feels(explored, 1.2)
    for _ in range(8):
        # Asked twice before it is over, as after a plate fault: the same answer.
        assert one.answer(step) == one.answer(step)
        given.append(one.answer(step))
        one.memory.over(step, given[-1])
    assert len({reply.response_time_s for reply in given}) == 8
    assert len({reply.value for reply in given}) > 2
    other = person()
    other.memory.feels(explored, 1.2)
    assert given[0] == other.answer(step)


def test_a_surface_that_is_explored_again_after_a_fault_is_explored_as_it_was():
    one = person()
    first, second = (Explore(text="", trial=Trial(task="t", number=1, total=1)) for _ in range(2))
    one.memory.now = first
    before = one.exploration_s(first)
    one.memory.over(first, Reply(response_time_s=before))
    one.memory.now = question()
    assert one.exploration_s(first) == before
    one.memory.now = second
    assert one.exploration_s(second) != before


def test_people_read_by_the_word_at_their_own_pace():
    short, long = Instruct(text="go on"), Instruct(text="word " * 238)
    people = [person(participant=f"{n:02d}") for n in range(40)]
    read = np.array([[p.read(step).response_time_s for step in (short, long)] for p in people])
    assert np.median(read[:, 1]) == pytest.approx(61, rel=0.08)  # Brysbaert 2019, and one screen
    assert (read[:, 0] < 2.5).all()
    assert np.std(np.log(read[:, 1])) == pytest.approx(0.14, abs=0.05)


def test_a_person_s_curve_is_smooth_and_their_own():
    """Without noise, neighbours differ little, however many amplitudes there are."""
    quiet = Population(shared=0.6, trial_to_trial=0.0)
    known = curves(quiet)
    amplitudes = np.linspace(0.0, 2.3, 93)
    turns = np.array([known.turns(amplitude) for amplitude in amplitudes])
    assert (turns**2).sum(axis=1) == pytest.approx(np.ones(93))
    rng = np.random.default_rng(2)
    deviates = turns @ rng.normal(size=(2, 2000))
    assert np.abs(np.diff(deviates, axis=0)).max() < 0.2
    assert deviates.std(axis=1) == pytest.approx(np.ones(93), abs=0.07)
    ends = np.corrcoef(deviates[0], deviates[-1])[0, 1]
    assert ends == pytest.approx(quiet.shared - quiet.own, abs=0.07)


def test_the_shipped_populations_are_read_by_name_and_others_from_a_file(tmp_path):
    assert read_population("biet2007") == Population()
    assert all(read_population(name).name == name for name in POPULATIONS)
    assert read_population("realistic").habits.rounding > 0
    file = tmp_path / "ours.toml"
    file.write_text('name = "ours"\ncriterion = 1.0\n[habits]\nlapses = 0.05\n')
    ours = read_population(str(file))
    assert (ours.criterion, ours.habits.lapses, ours.habits.rounding) == (1.0, 0.05, 0.0)


@pytest.mark.parametrize(
    "text, said",
    [
        ("shared = 0.9\ntrial_to_trial = 0.2\n", "a sum of at most 1"),
        ("[habits]\nlapses = 1.5\n", "lapses"),
        ("[habits]\ndropout = nan\n", "dropout"),
        (
            "amplitude_um_pp = [2, 1]\nmean_sensation = [9, 9]\nsd_sensation = [1, 1]\n",
            "ascend",
        ),
        ("mean_sensation = [50.0]\n", "the same number of values"),
        ("sd_sensation = [60.0, 8.0, 8.0, 8.0]\n", "no distribution"),
        ("unknown = 1\n", "unknown"),
    ],
)
def test_an_impossible_population_is_refused_in_a_sentence(tmp_path, text, said):
    file = tmp_path / "wrong.toml"
    file.write_text(text)
    with pytest.raises(UserError, match=said):
        read_population(str(file))


def test_a_population_that_there_is_not_is_refused_with_those_there_are():
    with pytest.raises(UserError, match=r"biet2007, realistic"):
        read_population("nobody")


def test_the_page_on_simulated_people_names_every_habit_with_its_realistic_value():
    page = (Path(__file__).parents[4] / "docs" / "explanation" / "simulated-people.md").read_text(
        encoding="utf-8"
    )
    for name, value in REALISTIC.model_dump().items():
        assert f"| `{name}` | {value:g} |" in page


@pytest.mark.parametrize("bias, low, high", [(0.0, 0.42, 0.58), (1.0, 0.78, 0.9)])
def test_a_liking_for_the_last_interval_is_the_share_of_answers_for_it(bias, low, high):
    """Of equal surfaces; with a bias of one unit of noise it is the normal's 0.84."""
    people = Population(threshold_sigma=0.0, habits={"interval_bias": bias})
    one = person(population=people)
    last = 0
    for number in range(600):
        trial = Trial(task="t", number=number, total=600)
        step = Ask(name="estimate", question=NumberQuestion(prompt="?"), trial=trial)
        one.memory.begin(step)
        for interval in (1, 2):
            one.memory.feels(Explore(text="", trial=trial, interval=interval), 1.2)
        last += one.pick(one.impressions)
    assert low < last / 600 < high


def test_a_question_that_nobody_answers_is_refused_in_a_sentence():
    with pytest.raises(UserError, match="no simulated participant can answer 'estimate'"):
        Respondent(seed=1, participant="01").answer(question())
