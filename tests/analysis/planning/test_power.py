"""Power: the population's own numbers, the report's tests at scale, R's simulation, the command."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from slipscale import commands
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.planning.power.answers import (
    Assurance,
    as_json,
    fewest,
    largest_effect,
    rows,
    sentence,
)
from slipscale.analysis.planning.power.design import design_of
from slipscale.analysis.planning.power.grid import Condition, conditions, values_of
from slipscale.analysis.planning.power.run_grid import run_grid, shards
from slipscale.analysis.planning.power.shard import Looks, Shard, at_once, excluded, one_by_one
from slipscale.analysis.planning.power.terminal import print_power, summary
from slipscale.analysis.planning.simulated.dataset import simulated_dataset
from slipscale.analysis.planning.simulated.estimates import Ratings, Task, simulate_ratings
from slipscale.analysis.planning.simulated.fast_tests import factor_p, pairwise, tables
from slipscale.analysis.statistics.repeated_measures.two_way import two_way
from slipscale.experiments.participants.simulated_people.bare_run import bare_run
from slipscale.experiments.participants.simulated_people.habits import REALISTIC
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.pilot import pilot_plans
from slipscale.experiments.steps.steps import Ask, Present
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.experiments.study.file import parse_study, read_study, study_text
from slipscale.faults import UserError

AMPLITUDES = (0.0, 0.5, 1.2, 2.3)
REFERENCE = Path(__file__).parents[2] / "data" / "power_reference" / "power.csv"
STUDY, TEXT = read_study("biet2007")


def design(population=None, text=TEXT, **choices):
    study = parse_study(text, "study.toml")
    made = design_of(study, text, population or Population(), 0.05)
    return replace(made, choices=made.choices.model_copy(update=choices))


def simulated(made, condition, studies, seed=1):
    return simulate_ratings(
        made.task_of(condition),
        participants=condition.participants,
        studies=studies,
        population=condition.people(made.population),
        rng=np.random.default_rng(seed),
    )


def found_in(made, ratings):
    return at_once(made, tables(ratings, AMPLITUDES, made.rule, made.choices.zero_rule))


def test_simulated_estimates_have_table_iii_s_means_and_spreads():
    """The numbers are the paper's (Table III), typed here once more."""
    ratings = simulated(design(), Condition(participants=200), 50)
    values = ratings.means(4).reshape(-1, 4)
    assert values.mean(axis=0) == pytest.approx([12.75, 19.58, 56.25, 81.33], abs=0.5)
    assert values.std(axis=0) == pytest.approx([12.75, 8.11, 8.82, 10.76], abs=0.5)
    assert (values == values.round()).all()


def reference():
    with REFERENCE.open() as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


@pytest.mark.parametrize(
    "case",
    reference(),
    ids=lambda case: f"N{case['participants']:g}-{case['effect']:g}-{case['dropout']:g}",
)
def test_power_is_that_of_r_s_simulation_of_the_same_model(case):
    """Model and tests written once more in R: tests/data/power_reference/power.R."""
    condition = Condition(
        participants=int(case["participants"]),
        repetitions=int(case["repetitions"]),
        effect=case["effect"],
        lapses=case["lapses"],
        dropout=case["dropout"],
        exponent=case["exponent"],
    )
    studies = 2000
    made = design()
    outcome = Shard(design=made, condition=condition, number=0, studies=studies, seed=3).compute()
    names = {"friedman": "friedman", "p01": "0 - 0.5", "p12": "0.5 - 1.2", "p23": "1.2 - 2.3"}
    for theirs, ours in names.items():
        p, q = case[theirs] / case["studies"], outcome.power(ours).value
        middle = (p + q) / 2
        error = np.sqrt(middle * (1 - middle) * (1 / studies + 1 / case["studies"]))
        assert abs(p - q) < 4 * error + 0.002, ours
    assert outcome.widths["exponent"].mean == pytest.approx(case["half_width"], rel=0.04)


def as_analysed(made, ratings):
    """Return what `analyse` itself finds in each study: test -> list of bool."""
    told = []
    for number in range(len(ratings.percent)):
        data = simulated_dataset(ratings, number, AMPLITUDES, made.choices, declared=made.declared)
        inference = analyse(data).inference
        p = {"friedman": inference.friedman.p, "rm_anova": inference.rm_anova.p_gg}
        for each in inference.pairwise:
            primary = made.choices.primary
            name = f"{each.from_level:g} - {each.to_level:g}"
            p[name] = each.ranks.p_holm if primary == "ranks" else each.logs.p_holm
        half = (inference.power_law.interval.high - inference.power_law.interval.low) / 2
        told.append(({name: value < 0.05 for name, value in p.items()}, half))
    return told


@pytest.mark.parametrize(
    "choices",
    [
        {"primary": "logarithms", "normalisation": "grand_maximum"},
        {"primary": "ranks", "normalisation": "modulus_equalisation", "zero_rule": "half_minimum",
         "exclusions": ("unreliable",)},
    ],
    ids=lambda choices: choices["normalisation"],
)  # fmt: skip
def test_the_fast_tests_decide_as_analyse_does_study_by_study(choices):
    """With the study's normalisation, zero rule and exclusions; ties alone may differ."""
    named = ("friedman", "rm_anova", "pairwise", "power_law")
    made = design(tests=named, **choices)
    people = Population(habits=REALISTIC.model_copy(update={"dropout": 0.15}))
    ratings = simulated(
        replace(made, population=people),
        Condition(participants=9, effect=0.5, dropout=0.15, lapses=0.02),
        2,
    )
    each = as_analysed(made, ratings)
    kept = excluded(made, ratings) if made.choices.exclusions else ratings
    for number, (told, half) in enumerate(each):
        one = Ratings(
            amplitude=kept.amplitude[[number]],
            percent=kept.percent[[number]],
            scale_top=kept.scale_top[[number]],
        )
        outcome = found_in(made, one)
        for name, count in outcome.found.items():
            if name in told and (" - " not in name or made.choices.primary == "logarithms"):
                assert bool(count) == told[name], name
        assert outcome.widths["exponent"].mean == pytest.approx(half)


def test_the_fast_path_is_the_full_sessions_power_within_its_error():
    """The same people through the protocol itself, answer by answer, at half the effect."""
    people = Condition(participants=8, effect=0.5, lapses=0.1).people(Population(habits=REALISTIC))
    studies, participants = 40, 8
    percent = np.empty((studies, participants, 4))
    amplitude = np.empty((studies, participants, 4), int)
    tops = np.empty((studies, participants))
    for study in range(studies):
        plans = pilot_plans(
            "biet2007", participants=participants, seed=study, language="en", population=people
        )
        for who, plan in enumerate(plans):
            surface, rated = None, []
            for step, answer, _ in bare_run(plan, people):
                if isinstance(step, Present):
                    surface = step.surface.level
                if isinstance(step, Ask) and step.name == "scale_top":
                    tops[study, who] = answer.value
                rating = isinstance(step, Ask) and step.name == "estimate"
                if rating and step.trial.phase == "main":
                    rated.append((AMPLITUDES.index(surface), answer.value))
            amplitude[study, who], values = zip(*rated, strict=True)
            percent[study, who] = 100 * np.array(values) / tops[study, who]
    sessions = found_in(
        design(), Ratings(amplitude=amplitude, percent=percent.round(6), scale_top=tops)
    )
    fast = Shard(
        design=design(people),
        condition=Condition(participants=8, lapses=0.1),
        number=0,
        studies=1000,
        seed=1,
    ).compute()
    assert 0.2 < fast.power("1.2 - 2.3").value < 0.9
    for name in sessions.found:
        share = fast.power(name).value
        error = np.sqrt(max(share * (1 - share), 0.01) / studies)
        assert abs(sessions.power(name).value - share) < 3.5 * error, name


def test_a_test_without_a_fast_form_is_computed_study_by_study():
    made = design(tests=("page_trend", "friedman"))
    outcome = Shard(
        design=made, condition=Condition(participants=5), number=0, studies=6, seed=1
    ).compute()
    assert set(outcome.found) == {"page_trend", "friedman"}
    assert outcome.found["page_trend"] == 6


@pytest.mark.parametrize("n, power", [(5, 0.0), (6, 0.9**6 + 0.1**6)])
def test_power_of_a_population_made_by_hand_is_the_binomial_s(n, power):
    """Nine in ten feel more, by sizes that never tie.

    Of six, Wilcoxon's p is 2/64 where all agree, and 4/64 at the least where one does not; of
    five it is 2/32 at the least.
    """
    rng = np.random.default_rng(6)
    up = np.where(rng.random((4000, n)) < 0.9, 1, -1)
    values = np.stack([np.full((4000, n), 50.0), 50 + up * np.arange(1, n + 1)], axis=2)
    ratings = Ratings(
        amplitude=np.broadcast_to([0, 1], values.shape),
        percent=values,
        scale_top=np.full((4000, n), 100.0),
    )
    p = pairwise(tables(ratings, (1.0, 2.0), "scale_top", "exclude"), "ranks")
    share = (p < 0.05).mean()
    assert share == pytest.approx(power, abs=4 * np.sqrt(power * (1 - power) / 4000))


def computed(wanted, studies=150, **options):
    made = design()
    looks = options.pop("looks", Looks())
    outcomes = run_grid(shards(made, wanted, studies=studies, seed=2007, looks=looks), **options)
    return made, outcomes


def test_more_participants_have_more_power_and_narrower_intervals():
    small, large = Condition(participants=10), Condition(participants=40)
    _, outcomes = computed([small, large])
    assert outcomes[large].power("0 - 0.5").value > outcomes[small].power("0 - 0.5").value
    for name in ("exponent", "mean at 1.2"):
        assert outcomes[large].widths[name].mean < outcomes[small].widths[name].mean


def test_the_fewest_are_those_from_which_on_the_target_holds():
    wanted = [Condition(participants=n, effect=effect) for n in (6, 60) for effect in (1.0, 0.1)]
    made, outcomes = computed(wanted, studies=60)
    found = fewest(rows(made, wanted, outcomes, looks=Looks()), 0.8)
    assert {others.effect: size for others, size in found.items()} == {1.0: 60, 0.1: None}


def test_assurance_lies_between_the_power_of_a_small_and_of_a_large_effect():
    known, most = Assurance(mean=0.8, sd=0.3), largest_effect(design())
    effects = known.effects(most)
    assert sum(weight for _, weight in effects) == pytest.approx(1)
    assert sum(effect * weight for effect, weight in effects) == pytest.approx(0.8, abs=0.06)
    assert all(0 <= effect <= most for effect, _ in effects)
    one = Condition(participants=36, effect=0.8)
    every = [one, *(replace(one, effect=effect) for effect, _ in effects)]
    made, outcomes = computed(list(dict.fromkeys(every)))
    (row,) = rows(made, [one], outcomes, looks=Looks(), assurance=known)
    assert 0 < row.assurance < row.weakest.value


@pytest.mark.parametrize(
    "axis, words, values",
    [
        ("participants", ["8:40:16"], (8, 24, 40)),
        ("participants", ["8", "12,10"], (8, 10, 12)),
        ("repetitions", ["1:4"], (1, 2, 3, 4)),
        ("effect", ["1,0.5"], (0.5, 1.0)),
        ("lapses", ["0:0.1:0.05"], (0.0, 0.05, 0.1)),
    ],
)
def test_axes_are_lists_and_ranges(axis, words, values):
    assert values_of(axis, words) == values


def test_lapses_and_dropout_that_leave_nobody_are_refused():
    axes = {"participants": (8,), "lapses": (0.5,), "dropout": (0.5,)}
    with pytest.raises(UserError, match="no genuine answers remain"):
        conditions(axes)


@pytest.mark.parametrize(
    "words",
    [
        ["--participants", "-5"],
        ["--participants", "2", "20"],
        ["--participants", ""],
        ["--participants", "8:4"],
        ["--participants", "8.5"],
        ["--participants", "many"],
        ["--repetitions", "0"],
        ["--repetitions", "1000000000"],
        ["--effect", "-1"],
        ["--effect", "nan"],
        ["--effect", "9"],
        ["--lapses", "1.2"],
        ["--dropout", "-0.1"],
        ["--studies", "0"],
        ["--seed", "-1"],
        ["--alpha", "0"],
        ["--alpha", "nan"],
        ["--target", "1"],
        ["--looks", "0"],
        ["--looks", "9"],
        ["--jobs", "0"],
        ["--order", "alphabetical"],
        ["--order", ","],
        ["--catch-steps", "-1"],
        ["--catch-steps", "1.5"],
        ["--shard", "5/4"],
        ["--shard", "1/2"],
        ["--assurance", "1"],
        ["--population", "nobody"],
        ["no-such-study"],
        [""],
    ],
)
def test_nonsense_is_refused_in_a_sentence_that_names_it(capsys, words):
    assert commands.main(["power", *words]) == 2
    said = capsys.readouterr().err
    assert "expected" in said
    assert words[0] in said or f"'{words[-1]}'" in said
    assert said.count("\n") == 1


def test_catch_steps_of_a_study_without_a_descending_series_are_refused(capsys, tmp_path):
    text = study_text("biet2007")
    first, _, rest = text.partition('[[tasks]]\nprotocol = "descending_difference"')
    file = tmp_path / "only.toml"
    file.write_text(first + rest[rest.index("[[tasks]]") :])
    assert commands.main(["power", str(file), "--catch-steps", "2"]) == 2
    said = capsys.readouterr().err
    assert "--catch-steps 2: biet2007 has no descending difference" in said
    assert said.count("\n") == 1


def test_all_nonsense_is_named_at_once(capsys):
    assert commands.main(["power", "--alpha", "5", "--studies", "0"]) == 2
    said = capsys.readouterr().err
    assert "--alpha 5.0: expected a proportion above 0 and below 1" in said
    assert "--studies 0: expected 1 or more" in said


def test_a_grid_of_hours_is_refused_unless_it_is_wanted(capsys):
    words = ["power", "--participants", "200", "--repetitions", "10", "--studies", "30000000"]
    assert commands.main(words) == 2
    assert "add --yes" in capsys.readouterr().err


def test_a_protocol_without_simulated_ratings_is_refused(capsys, tmp_path):
    text = study_text("biet2007")
    first, _, rest = text.partition('[[tasks]]\nprotocol = "magnitude_estimation"')
    file = tmp_path / "only.toml"
    file.write_text(first + rest[rest.index("[[about_you]]") :])
    assert commands.main(["power", str(file)]) == 2
    assert "no task uses magnitude_estimation" in capsys.readouterr().err


def test_the_command_says_how_many_and_exits_1_where_none_suffices(capsys):
    words = ["power", "--studies", "40", "--json", "--participants"]
    assert commands.main([*words, "60"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["enough"][0]["participants"] == 60
    assert found["conditions"][0]["false_alarms"]["friedman"]["value"] < 0.2
    assert commands.main([*words, "4"]) == 1


def test_everything_is_written_as_a_page_figures_and_tables(capsys, tmp_path):
    out = tmp_path / "plan"
    words = ["power", "--studies", "60", "--participants", "6,12", "--effect", "1,0.5"]
    commands.main([*words, "--looks", "2", "--assurance", "1,0.2", "--out", str(out)])
    said = " ".join(capsys.readouterr().out.split())
    assert "For the application: With 1" in said
    assert "95 % Monte Carlo interval" in said
    names = {path.name for path in out.iterdir()}
    assert names == {"power.html", "power.csv", "power.json", "power.svg", "power.png",
                     "precision.svg", "precision.png"}  # fmt: skip
    page = (out / "power.html").read_text(encoding="utf-8")
    assert "For the application" in page
    assert page.count("<svg") == 2
    with (out / "power.csv").open() as file:
        lines = list(csv.DictReader(file))
    told = json.loads((out / "power.json").read_text())["conditions"]
    assert len(lines) == sum(len(each["power"]) for each in told)
    for line in lines:
        (same,) = (each for each in told if (each["participants"], each["effect"]) == (
            int(line["participants"]), float(line["effect"])))  # fmt: skip
        assert float(line["power"]) == same["power"][line["test"]]["value"]


def test_the_choices_that_need_a_standard_are_refused():
    study = STUDY.model_copy(
        update={"analysis": AnalysisChoices(normalisation="standard_referenced")}
    )
    with pytest.raises(UserError, match="requires a standard"):
        design_of(study, TEXT, Population(), 0.05)


CROSSED = f"""{TEXT}
[[factors]]
name = "direction"
levels = ["left", "right", "both"]
simulated = {{ right = 0.5 }}
[[factors]]
name = "hand"
levels = ["left", "right"]
"""


def test_the_effect_and_the_interaction_of_each_factor_have_a_power():
    wanted = [Condition(participants=6)]
    made = design(text=CROSSED)
    found = rows(made, wanted, run_grid(shards(made, wanted, studies=40, seed=1)), looks=Looks())
    power = {name: share.value for name, share in found[0].power.items()}
    assert power["direction"] > 0.9
    assert max(power["direction x amplitude"], power["hand"], power["hand x amplitude"]) < 0.2
    assert "direction" in found[0].decisive
    assert "hand" not in found[0].decisive
    told = " ".join(summary(made, found, 0.8))
    assert "for hand, hand x amplitude, so these values are false" in told
    assert "direction x amplitude: no change in growth is simulated, but the top" in told
    assert "the same effect of direction and hand. Power is lower if people differ" in told
    assert "was assumed to be equal in all people" in sentence(made, found[0])
    told_json = as_json(made, found, 0.8)
    assert told_json["equal_effects"] == ["direction", "hand"]
    assert "Set simulated_sd" in str(told_json["warning"])
    spread = replace(
        made, population=made.population.model_copy(update={"effect_sds": (("direction", 0.1),)})
    )
    assert as_json(spread, found, 0.8)["equal_effects"] == ["hand"]
    assert found[0].condition.people(made.population).effects == (("direction", "right", 0.5),)
    none = Condition(participants=6, effect=0).people(made.population)
    assert none.effects == (("direction", "right", 1.0),)


@pytest.mark.parametrize(
    "name, unit, suffix, exponent",
    [("voltage", "V", "v_peak", 2.0), ("acceleration", "m/s²", "m_s2_peak", 0.89)],
    ids=["voltage", "acceleration"],
)
def test_levels_in_another_unit_are_not_read_as_micrometres(capsys, name, unit, suffix, exponent):
    """Rest and the plate's maximum feel like the paper's ends, between them by a power function."""
    text = f"""
name = "other"
title = "Another quantity"
{name}s_{suffix} = [0.0, 30.0, 60.0]
[quantity]
name = "{name}"
unit = "{unit}"
convention = "peak"
[plate]
{name}_{suffix} = 100.0
[[tasks]]
protocol = "magnitude_estimation"
repetitions = 1
"""
    made = design(text=text)
    means = simulated(made, Condition(participants=100), 40).means(3).mean(axis=(0, 1))
    expected = 12.75 + (81.33 - 12.75) * np.array([0.0, 0.3, 0.6]) ** exponent
    assert means == pytest.approx(expected, abs=1.0)
    wanted = [Condition(participants=12)]
    found = rows(made, wanted, run_grid(shards(made, wanted, studies=200, seed=1)), looks=Looks())
    assert "30 - 60" in found[0].power
    print_power(made, found, 0.8)
    assert "µm" not in capsys.readouterr().out


def test_the_mixed_model_s_changes_have_a_power_if_the_study_names_the_model():
    made = design(text=CROSSED, tests=("friedman", "factors"))
    changes = ("direction left", "direction right", "hand right")
    assert list(made.mixed_tests) == [
        f"{each}{crossed}, mixed model" for each in changes for crossed in ("", " x amplitude")
    ]
    people = Condition(participants=6)
    found = Shard(design=made, condition=people, number=0, studies=4, seed=1).compute().found
    assert found["direction right, mixed model"] == 4
    assert found["hand right, mixed model"] < 4
    data = simulated_dataset(
        simulated(made, people, 1), 0, AMPLITUDES, made.choices,
        declared=True, conditions=made.task.conditions,
    )  # fmt: skip
    change = analyse(data).inference.factors[0].changes[1]
    one = one_by_one(made, simulated(made, people, 1))
    assert one["direction right, mixed model"] == (change.mixed_log_ratio.p < 0.05)
    assert not design(text=CROSSED).mixed_tests


def test_the_simulated_people_do_not_depend_on_how_they_are_analysed():
    usual, other = (
        Shard(design=made, condition=Condition(participants=5), number=0, studies=9, seed=1)
        for made in (design(), design(confidence=0.9, primary="logarithms", zero_rule="refuse"))
    )
    assert usual.random_seed == other.random_seed
    assert usual.digest != other.digest
    assert usual.random_seed != replace(usual, seed=2).random_seed
    assert usual.random_seed == replace(usual, looks=Looks(number=2)).random_seed


def test_numbers_of_factors_are_not_cut_off_in_the_terminal(capsys):
    wanted = [Condition(participants=12)]
    made = design(text=CROSSED)
    found = rows(made, wanted, run_grid(shards(made, wanted, studies=20, seed=1)), looks=Looks())
    print_power(made, found, 0.8)
    assert "…" not in capsys.readouterr().out


def test_without_factors_the_random_numbers_are_as_before_factors_had_power():
    assert "factors" not in design().identity["task"]
    assert "factors" in design(text=CROSSED).identity["task"]


def test_simulated_people_have_the_conditions_of_the_session_and_its_effects():
    """By name of the condition: exponents differ by the factor stated, and people by their SD."""
    text = CROSSED.replace("0.5 }", "0.5 }\nsimulated_growth = { both = 1.5 }")
    made = design(text=text.replace("right = 0.5", "right = 0.5, left = 0.8"))
    made = replace(made, task=replace(made.task, practice=2))
    ratings = simulated(made, Condition(participants=40), 5)
    assert ratings.percent.shape == (5, 40, 24)
    conditions, felt = made.task.conditions, {}
    for number, each in enumerate(conditions):
        for place, amplitude in enumerate(AMPLITUDES):
            here = (ratings.condition == number) & (ratings.amplitude == place)
            assert here.sum() == 5 * 40
            felt[each["direction"], each["hand"], amplitude] = ratings.percent[here].mean()
    assert felt["right", "left", 2.3] / felt["left", "left", 2.3] == pytest.approx(
        0.5 / 0.8, rel=0.02
    )
    # The mean of a power is near the power of the mean if people differ little.
    assert felt["both", "right", 2.3] == pytest.approx(100 * 0.8133**1.5, abs=3)
    people = made.population.model_copy(update={"effect_sds": (("hand", 0.3),)})
    differing = simulated(replace(made, population=people), Condition(participants=400), 1)
    logs = np.log(np.maximum(differing.by_amplitude(differing.percent, 4)[..., 2], 1))
    hands = np.array([each["hand"] == "left" for each in conditions])[differing.condition]
    left = differing.by_amplitude(hands, 4)[..., 2]
    of_left, of_right = (np.where(left == it, logs, 0).sum(axis=0) / 3 for it in (True, False))
    assert np.std(of_left - of_right) == pytest.approx(0.3 * 2**0.5, rel=0.2)


def test_power_of_two_factors_is_that_of_the_noncentral_f_distribution():
    """Two levels each, so no correction for sphericity: F(1, n - 1, n effect² / variance)."""
    studies, n, shift, crossed = 4000, 10, 0.6, 1.0
    rng = np.random.default_rng(5)
    cells = rng.normal(size=(studies, n, 2, 2)) + rng.normal(size=(studies, n, 1, 1))
    cells += np.array([[0.0, 0.0], [shift, shift + crossed]])
    p_main, p_crossed = factor_p(cells.reshape(studies, n, 4), [2])
    # The mean over the second factor differs by `shift + crossed / 2`, with a variance of 1; the
    # difference of differences has a variance of 4.
    for p, noncentrality in (
        (p_main, n * (shift + crossed / 2) ** 2),
        (p_crossed, n * crossed**2 / 4),
    ):
        power = stats.ncf.sf(stats.f.ppf(0.95, 1, n - 1), 1, n - 1, noncentrality)
        assert (p < 0.05).mean() == pytest.approx(
            power, abs=4 * (power * (1 - power) / studies) ** 0.5
        )


def test_a_factors_p_values_are_the_report_s():
    cells = np.random.default_rng(6).normal(size=(1, 9, 3, 2, 4))
    p = [float(each[0]) for each in factor_p(cells.reshape(1, 9, 24), [3, 2])]
    for place, size in enumerate((3, 2)):
        table = cells[0].mean(axis=2 - place).reshape(9, -1)
        columns = pd.MultiIndex.from_product([range(size), range(4)])
        effects = two_way(pd.DataFrame(table, columns=columns), 0.95, "every level")
        assert p[2 * place : 2 * place + 2] == pytest.approx([effects[0].p, effects[2].p], rel=1e-6)


def test_a_task_knows_what_comes_before_and_after_it():
    assert design().task == Task(levels=AMPLITUDES, repetitions=1, practice=1, trials_before=4)
