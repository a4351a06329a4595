"""Groups compared: against R, and what is said where there is nothing to compare."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.preprocessing.log_transform import prepare
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.analysis.reporting.files import draw
from slipscale.analysis.reporting.sections.summary import answers
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.effects.groups.declaration import group_sentences
from slipscale.analysis.tasks.effects.groups.statistics import compare_groups
from slipscale.analysis.tasks.effects.groups.welch import welch
from slipscale.commands import main
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.faults import UserError
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

pytestmark = pytest.mark.usefixtures("without_models")

DATA = Path(__file__).parents[3] / "data"
R = json.loads((DATA / "r_reference" / "comparisons.json").read_text())["orthodont"]
COLUMNS = {"participant": "Subject", "stimulus": "age", "response": "distance", "group": "Sex"}


@pytest.fixture(scope="module")
def orthodont():
    return analyse(
        load(DATA / "foreign" / "orthodont.csv", parse_mapping({"columns": COLUMNS}, ""))
    )


@pytest.mark.parametrize("part, expected", [("exponents", "exponent"), ("levels", "level")])
def test_welch_s_comparison_is_r_s(orthodont, part, expected):
    (pair,) = getattr(orthodont.inference.groups, part).pairs
    for name in ("t", "df", "p", "difference"):
        assert getattr(pair, name) == pytest.approx(R[expected][name], rel=1e-8), name
    assert list(pair.interval) == pytest.approx(R[expected]["ci"], rel=1e-8)


def test_the_mixed_analysis_of_variance_is_r_s_in_groups_of_unequal_size(orthodont):
    found = orthodont.inference.groups.anova
    for name in ("F", "df1", "df2", "p"):
        assert getattr(found.group, name) == pytest.approx(R["group"][name], rel=1e-8), name
    epsilon = R["interaction"]["epsilon_gg"]
    assert found.epsilon_gg == pytest.approx(epsilon, rel=1e-8)
    assert pytest.approx(R["interaction"]["F"], rel=1e-8) == found.interaction.F
    assert found.interaction.df1 == pytest.approx(R["interaction"]["df1"] * epsilon, rel=1e-8)
    assert found.interaction.df2 == pytest.approx(R["interaction"]["df2"] * epsilon, rel=1e-8)


def test_welch_s_analysis_of_three_groups_is_r_s(orthodont):
    slopes = orthodont.individuals.set_index("participant_id")["exponent"].sort_index()
    thirds = {name: slopes.to_numpy()[start::3] for start, name in enumerate("abc")}
    found = welch(thirds, 0.95)
    for name in ("F", "df1", "df2", "p"):
        assert getattr(found, name) == pytest.approx(R["thirds"][name], rel=1e-8), name
    assert [(pair.first, pair.second) for pair in found.pairs] == [
        ("a", "b"),
        ("a", "c"),
        ("b", "c"),
    ]


def test_sentences_and_tables_name_groups_effect_sizes_and_exact_p(orthodont, page):
    texts = group_sentences(orthodont.inference.groups, 0.95, PLATE_AMPLITUDE)
    assert texts[0] == "Groups were defined by Sex: Female (n = 11), Male (n = 16)."
    assert "Welch's F(1, 23.48) = 3.68, p = .067, η² = .11, 95% CI [.00, .34]" in texts[1]
    assert "Hedges' g = −1.15 [−1.95, −0.33]" in texts[2]
    assert "F(2.43, 60.69) = 1.65, p = .195" in texts[3]
    assert "Female – Male" in page(orthodont)


def prepared(sizes, rng, slope=lambda _: 0.5):
    rows = [
        (f"{group}{i}", a, np.exp(rng.normal(3 + slope(group) * np.log(a), 0.2)))
        for group, size in sizes.items()
        for i in range(size)
        for a in (0.5, 1.2, 2.3)
    ]
    frame = pd.DataFrame(rows, columns=["participant_id", "level", "normalised"])
    frame["participant_id"] = frame["participant_id"].astype("category")
    who = frame["participant_id"].cat.categories
    group_of = pd.Series([name[0] for name in who], index=who, name="hand")
    return prepare(frame.assign(session="", run="1"), AnalysisChoices()), group_of


def test_the_answer_names_what_groups_differ_in_and_figure_1_gives_each_its_means(orthodont):
    told = answers(orthodont)
    assert told[0].startswith("Geometric means of ")
    assert sum("between groups, Welch's F(" in text for text in told) == 2
    for name, mean in (("fig15", "arithmetic"), ("growth_means", "geometric")):
        (axes,) = draw(orthodont)[name].axes
        labels = [container.get_label().partition(",")[0] for container in axes.containers]
        assert labels == [f"{mean} mean of Female", f"{mean} mean of Male"]


def test_groups_that_grow_differently_differ_in_exponent_and_interaction():
    slopes = {"a": 0.3, "b": 1.2}
    found = compare_groups(*prepared({"a": 12, "b": 12}, np.random.default_rng(1), slopes.get))
    assert found.exponents.p < 0.001
    assert found.anova.interaction.p < 0.001
    low, high = found.exponents.pairs[0].interval
    assert low < -0.9 < high


def test_groups_too_small_are_left_out_and_named():
    data, group_of = prepared({"a": 4, "b": 5, "c": 1, "d": 2}, np.random.default_rng(2))
    group_of = group_of.drop("a0")
    found = compare_groups(data, group_of)
    assert found.n == {"a": 3, "b": 5}
    assert (found.left_out, found.without_group) == (("c", "d"), 1)
    (first, *_) = group_sentences(found, 0.95, PLATE_AMPLITUDE)
    assert first.endswith("groups too small to compare: c, d; 1 participant in no group.")


@pytest.mark.parametrize("sizes", [{"a": 5, "b": 1}, dict.fromkeys("abcdefghij", 1)])
def test_a_group_of_one_and_ten_groups_of_one_are_one_sentence(sizes):
    found = compare_groups(*prepared(sizes, np.random.default_rng(3)))
    assert isinstance(found, NotComputed)
    there = sum(size >= 3 for size in sizes.values())
    assert found.reason.startswith(f"too few groups of 3 participants or more ({there}; at least 2")
    assert "smaller: " in found.reason


def test_ten_groups_of_one_in_a_foreign_table_are_one_note(tmp_path):
    path = tmp_path / "data.csv"
    rows = [(f"p{i}", a, a + i, f"g{i}") for i in range(10) for a in (1, 2, 3)]
    pd.DataFrame(rows, columns=["who", "level", "said", "g"]).to_csv(path, index=False)
    columns = {"participant": "who", "stimulus": "level", "response": "said", "group": "g"}
    problems = load(path, parse_mapping({"columns": columns}, "")).problems
    (problem,) = problems
    assert problem.endswith("in groups of one participant: g0, g1, g2, g3, g4, g5 and 4 more.")


def test_a_second_factor_is_refused_in_one_sentence(tmp_path, capsys):
    path = tmp_path / "data.csv"
    path.write_text("who,level,said,g,h\n")
    words = ["analyse", str(path), "--participant", "who", "--stimulus", "level"]
    assert main([*words, "--response", "said", "--group", "g", "--group", "h"]) == 2
    assert "--group is given twice; expected only once" in capsys.readouterr().err
    with pytest.raises(UserError, match=r"columns\.group"):
        parse_mapping({"columns": COLUMNS | {"group": [f"f{i}" for i in range(10)]}}, "here")


def test_the_group_of_a_data_set_is_the_column_that_the_study_names(dataset):
    folder = dataset(participants=6, choices='group = "hand"')
    lines = [f"sub-{n:02d}\t{'left' if n % 2 else 'right'}\t{n % 3}" for n in range(1, 7)]
    (folder / "participants.tsv").write_text("\n".join(["participant_id\thand\tgroup", *lines]))
    found = analyse(folder).inference.groups
    assert (found.column, found.n) == ("hand", {"left": 3, "right": 3})


def test_a_column_of_groups_that_is_not_there_is_named(dataset):
    folder = dataset(participants=3, choices='group = "hand"')
    with pytest.raises(UserError, match=r"no column 'hand', the value of analysis.group; found"):
        analyse(folder)


def test_groups_of_one_value_each_have_no_test():
    same = {"a": np.array([1.0, 1.0, 1.0]), "b": np.array([1.0, 2.0, 3.0])}
    assert "group 'a': all participants have the same value" in welch(same, 0.95).reason
