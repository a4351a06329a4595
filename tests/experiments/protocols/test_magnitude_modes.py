"""Visual analogue scale, ratio to a standard and magnitude production: what is planned."""

from collections import Counter
from itertools import pairwise

import pytest

from slipscale.experiments.dataset.schema import columns
from slipscale.experiments.participants.simulated_people.bare_run import bare_run
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.protocols.magnitude_production import PROTOCOL as MADE
from slipscale.experiments.running.rehearsal import dry_run, surfaces
from slipscale.experiments.steps.columns import TrialRecord
from slipscale.experiments.steps.steps import Adjust, Ask, EndBlock, Explore, Present, Rest
from slipscale.experiments.study.file import study_text
from slipscale.faults import UserError

EVERY_TWO = ("standard_every_trials = 1", "standard_every_trials = 2")
PRODUCTION = (  # of the shipped study, the first task alone
    '\n[[tasks]]\nprotocol = "magnitude_estimation"\nrepetitions = 3\nscale_top = "declared"\n'
    "practice = 1\n"
)


def short(name, *changes):
    text = study_text(name)
    if name == "magnitude_production":
        changes = ((PRODUCTION, ""), *changes)
    for long, new in changes:
        assert long in text
        text = text.replace(long, new)
    return text


def main_trials(made, kind=Present):
    return [
        step for step in dry_run(made) if isinstance(step, kind) and step.trial
        if step.trial.phase == "main"
    ]  # fmt: skip


def test_a_line_s_mark_starts_anywhere_and_the_row_says_where(plan):
    made = plan(short("visual_analogue_scale", ("repetitions = 3", "repetitions = 100")))
    starts = []
    for ask in main_trials(made, Ask):
        assert ask.trial.factors["cursor_start"] == ask.question.start
        assert not ask.question.start_shown
        starts.append(ask.question.start)
    assert min(starts) < 3
    assert max(starts) > 97
    assert 45 < sum(starts) / len(starts) < 55
    assert all(start == round(start) for start in starts)


@pytest.mark.parametrize("start, place", [("left", 0.0), ("middle", 50.0), ("right", 100.0)])
def test_a_fixed_start_is_the_same_in_each_trial(plan, start, place):
    text = short(
        "visual_analogue_scale",
        ('cursor_start = "random"', f'cursor_start = "{start}"'),
        ("cursor_shown = false", "cursor_shown = true"),
    )
    asked = main_trials(plan(text), Ask)
    assert {(each.question.start, each.question.start_shown) for each in asked} == {(place, True)}


def test_catch_trials_are_marked_and_outside_the_plan(plan):
    for study, amplitude in (("visual_analogue_scale", 0.0), ("ratio_to_standard", 1.2)):
        shown = [each for each in main_trials(plan(study_text(study))) if each.interval != 1]
        catch = [each for each in shown if each.trial.factors["catch"]]
        assert [each.surface.level for each in catch] == [amplitude] * 2
        rest = Counter(each.surface.level for each in shown if each not in catch)
        assert set(rest.values()) == {3}


def test_catch_trials_come_at_any_place_among_the_main_trials(plan):
    text = short("ratio_to_standard", ("catch_trials = 2", "catch_trials = 1"))
    places = Counter()
    for seed in range(200):
        asked = [step.trial for step in main_trials(plan(text, seed=seed), Ask)]
        (place,) = (n for n, trial in enumerate(asked) if trial.factors["catch"])
        places[place] += 1
    assert set(places) == set(range(13))
    assert max(places.values()) < 35  # of some 15 each


def test_as_many_catch_trials_as_others_come_in_any_pattern(plan):
    """Of 24 marks in any order 6 pairs of neighbours, about, are two catch trials."""
    text = short("ratio_to_standard", ("catch_trials = 2", "catch_trials = 12"))
    pairs = 0
    for seed in range(20):
        asked = [step.trial.factors["catch"] for step in main_trials(plan(text, seed=seed), Ask)]
        assert sum(asked) == 12
        pairs += sum(one and other for one, other in pairwise(asked[:20]))
    assert 75 < pairs < 115  # 20 runs, 19 pairs of neighbours, each with probability 0.239


def test_a_line_takes_textures_and_a_ratio_plain_surfaces_alone(plan):
    texture = (
        '\n[[textures]]\nname = "ridges"\nspatial_period_mm = 5.0\nmean_um_pp = 1.0\n'
        "depth_um_pp = 0.5\nfinger_speed_mm_s = 50.0\n\n[[tasks]]"
    )
    line = plan(short("visual_analogue_scale", ("\n[[tasks]]", texture)))
    assert {each.surface.label for each in main_trials(line)} == {"S1", "S2", "S3", "S4", "T1"}
    task = '\n[[tasks]]\nprotocol = "magnitude_estimation"\n'
    both = short("ratio_to_standard", ("\n[[tasks]]", texture), ("\n[masking", f"{task}\n[masking"))
    made = [each for each in main_trials(plan(both)) if each.trial.task == "ratiotostandard"]
    assert {each.surface.label for each in made} == {"S0", "S1", "S2", "S3", "S4"}


def test_felt_in_each_trial_the_standard_is_its_first_interval(plan):
    shown = main_trials(plan(study_text("ratio_to_standard")))
    pairs = list(zip(shown[::2], shown[1::2], strict=True))
    for first, second in pairs:
        assert (first.interval, first.surface.level) == (1, 1.2)
        assert second.interval == 2
        factors = second.trial.factors
        assert factors["comparison_level"] == second.surface.level
        assert factors["standard_level"] == 1.2


def test_felt_less_often_the_standard_comes_before_every_so_many_trials_and_after_rests(plan):
    """A block of practice, one of main trials, a rest after every third trial."""
    text = short(
        "ratio_to_standard",
        EVERY_TWO,
        ("practice = 1", "practice = 1\nrest_every_trials = 3"),
        ('"blocked"', '"simple"'),
    )
    order = ""
    for step in dry_run(plan(text)):
        if isinstance(step, Present):
            order += "S" if step.trial is None else "t"
        elif isinstance(step, Rest):
            order += "r"
        elif isinstance(step, EndBlock):
            order += "|"
    assert order.count("r") == 5
    assert order.count("t") == 18
    for stretch in order.replace("|", "r").split("r"):
        if stretch:
            assert stretch == "".join("S" * (n % 2 == 0) + "t" for n in range(stretch.count("t")))


def test_each_number_is_produced_from_low_as_often_as_from_high(plan):
    made = plan(short("magnitude_production"))
    turned = [step for step in main_trials(made) if step.interval == 2]
    found = Counter((t.trial.factors["number"], t.trial.factors["began"]) for t in turned
                    if not t.trial.factors["catch"])  # fmt: skip
    assert found == {(n, b): 2 for n in (7.0, 10.0, 14.0, 20.0) for b in ("low", "high")}
    for step in turned:
        start = step.surface.level
        low = step.trial.factors["began"] == "low"
        assert 0.1 <= start <= 0.65 if low else 1.75 <= start <= 2.3
    (catch,) = (t.trial for t in turned if t.trial.factors["catch"])
    assert catch.factors["number"] == catch.factors["modulus"] == 10.0


def test_the_participant_reads_the_number_and_never_an_amplitude(plan):
    for step in main_trials(plan(short("magnitude_production")), Adjust):
        assert step.text.split()[-1] == f"{step.trial.factors['number']:g}"
    texts = [s.text for s in dry_run(plan(short("magnitude_production"))) if isinstance(s, Explore)]
    assert not any("0.8" in text for text in texts)


def test_all_that_can_be_turned_to_is_known_beforehand(plan):
    found = {each.level for each in surfaces(plan(short("magnitude_production")))}
    assert {0.1, 0.8, 2.3} <= found


@pytest.mark.parametrize(
    "study, change, said",
    [
        (
            "visual_analogue_scale",
            ("resolution = 1.0", "resolution = 0.7"),
            "expected a number that divides 100",
        ),
        ("visual_analogue_scale", ("resolution = 1.0", "resolution = 0.0"), "expected 0.1 or more"),
        ("visual_analogue_scale", ("resolution = 1.0", "resolution = 20.0"), "10 or less"),
        (
            "visual_analogue_scale",
            ("resolution = 1.0", "resolution = 5.0"),
            r"key_step.*expected a multiple of the resolution \(5\)",
        ),
        ("visual_analogue_scale", ('"random"', '"top"'), "'left', 'middle', 'right' or 'random'"),
        ("visual_analogue_scale", ("cursor_shown = false", "cursor_shown = 0"), "cursor_shown"),
        ("ratio_to_standard", ("standard_um_pp = 1.2", ""), "standard_um_pp"),
        ("ratio_to_standard", ("standard_um_pp = 1.2", "standard_um_pp = 0.0"), "above 0"),
        ("ratio_to_standard", ("standard_um_pp = 1.2", "standard_um_pp = 2.6"), "2.6 is beyond"),
        (
            "ratio_to_standard",
            ("standard_every_trials = 1", "standard_every_trials = 0"),
            "expected 1 or more",
        ),
        ("magnitude_production", ("numbers = [7.0, 10.0, 14.0, 20.0]", ""), "numbers"),
        ("magnitude_production", ("[7.0, 10.0, 14.0, 20.0]", "[5.0]"), "at least 2"),
        ("magnitude_production", ("[7.0, 10.0, 14.0, 20.0]", "[5.0, 5.0]"), "different numbers"),
        ("magnitude_production", ("[7.0, 10.0, 14.0, 20.0]", "[0.0, 5.0]"), "above 0"),
        ("magnitude_production", ("standard_um_pp = 0.8", "standard_um_pp = 0.1"), "between lowe"),
        ("magnitude_production", ("highest_um_pp = 2.3", "highest_um_pp = 3.1"), "3.1 is beyond"),
        ("magnitude_production", ("step_um_pp = 0.05", "step_um_pp = 1.2"), "at most half"),
        ("magnitude_production", ("lowest_um_pp = 0.1", "lowest_um_pp = 0.0"), "above 0"),
    ],
)
def test_what_cannot_be_is_one_sentence_of_the_study(plan, study, change, said):
    with pytest.raises(UserError, match=said):
        plan(short(study, change)).study  # noqa: B018 - parsed when it is looked at


def answers(made, name, **people):
    return [
        (step.trial, answer)
        for step, answer, _ in bare_run(made, Population(**people))
        if isinstance(step, Ask | Adjust) and step.name == name and step.trial.phase == "main"
    ]


def test_without_noise_a_ratio_of_the_standard_to_itself_is_one(plan):
    for every in (1, 2):
        text = short(
            "ratio_to_standard", (EVERY_TWO[0], f"standard_every_trials = {every}")
        )  # fmt: skip
        judged = answers(plan(text), "ratio", trial_to_trial=0.0)
        catches = [answer.value for trial, answer in judged if trial.factors["catch"]]
        others = {t.factors["comparison_level"]: a.value for t, a in judged}
        assert catches == [1.0, 1.0]
        assert others[0.3] < others[0.6] < 1 < others[1.8] <= others[2.3]


def test_without_noise_the_standard_s_own_number_is_produced_as_the_standard(plan):
    for trial, answer in answers(plan(short("magnitude_production")), "produced_level",
                                 trial_to_trial=0.0):  # fmt: skip
        if trial.factors["number"] == trial.factors["modulus"]:
            assert abs(answer.value - 0.8) <= 0.05


def test_a_person_who_shortens_the_range_produces_nearer_to_the_standard(plan):
    def spread(regression):
        made = answers(
            plan(short("magnitude_production")),
            "produced_level",
            trial_to_trial=0.0,
            habits={"regression": regression},
        )
        values = [answer.value for _, answer in made]
        return max(values) - min(values)

    assert spread(0.5) < 0.7 * spread(0.0)


def test_a_person_drawn_to_the_start_puts_the_mark_nearer_to_it(plan):
    made = plan(study_text("visual_analogue_scale"))
    free = answers(made, "rating")
    drawn = answers(made, "rating", habits={"anchoring": 0.5})
    assert len(free) == 14
    for (trial, one), (_, other) in zip(free, drawn, strict=True):
        start = trial.factors["cursor_start"]
        assert abs(abs(one.value - start) / 2 - abs(other.value - start)) <= 1.0


def test_who_lapses_leaves_the_plate_where_it_began(plan):
    lapsing = answers(plan(short("magnitude_production")), "produced_level", habits={"lapses": 1})
    assert all(len(answer.trace) == 1 for _, answer in lapsing)


def test_who_means_a_number_beyond_the_plate_leaves_it_at_its_bound_and_the_row_says_so(plan):
    text = short("magnitude_production", ("[7.0, 10.0, 14.0, 20.0]", "[0.5, 100.0]"))
    bound = columns(MADE)["bound"].value
    for trial, answer in answers(plan(text), "produced_level"):
        if not trial.factors["catch"]:
            end = 0.1 if trial.factors["number"] < 1 else 2.3
            assert abs(answer.value - end) < 0.05
            assert len(answer.trace) < 2.2 / 0.05 + 2  # and turns on no more
            record = TrialRecord(trial=trial, answers={"produced_level": {"value": answer.value}})
            assert bound(record) == ("lowest" if end < 1 else "highest")
    inside = TrialRecord(trial=trial, answers={"produced_level": {"value": 1.0}})
    assert bound(inside) == "none"
    assert bound(TrialRecord(trial=trial)) is None


def test_a_production_that_takes_too_long_comes_again(plan):
    text = short("magnitude_production", ("limit_s = 120.0", "limit_s = 6.0"))
    made = answers(plan(text), "produced_level")
    missed = [trial.number for trial, answer in made if answer.timed_out and not trial.repeats]
    assert missed
    assert missed == sorted(trial.repeats for trial, _ in made if trial.repeats)
