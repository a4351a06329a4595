"""Answers of other laboratories: no code is guessed, no row is lost in silence."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from slipscale import commands
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.answer_codes import as_answers
from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.analysis.reporting.sections.summary import answers
from slipscale.analysis.tasks.thresholds.statistics import THRESHOLDS
from slipscale.faults import UserError

pytestmark = pytest.mark.usefixtures("without_models", "without_simulated_fits")


def mapping(answers=None, **columns):
    known = {"participant": "who", "stimulus": "size", "answer": "felt"} | columns
    columns = {key: value for key, value in known.items() if value}
    return parse_mapping({"columns": columns, "answers": answers or {}}, "here")


def table(tmp_path, codes, **more):
    """Ten people, three sizes, ten answers each; `codes` are no and yes."""
    random = np.random.default_rng(1)
    rows = [
        {"who": f"p{who}", "size": size, "felt": codes[int(random.random() < size / 4)]}
        for who in range(10)
        for size in (1.0, 2.0, 3.0)
        for _ in range(10)
    ]
    path = tmp_path / "answers.csv"
    pd.DataFrame(rows).assign(**more).to_csv(path, index=False)
    truth = pd.Series([row["felt"] == codes[1] for row in rows])
    return path, truth


@pytest.mark.parametrize(
    "codes", [(0, 1), ("no", "yes"), ("N", "Y"), ("nein", "ja"), ("non", "oui"), ("False", "True")]
)
def test_obvious_codes_are_read_whole(tmp_path, codes):
    path, truth = table(tmp_path, codes)
    found = load(path, mapping()).differences["difference_felt"]
    assert list(found) == list(truth.astype(float))


@pytest.mark.parametrize("codes", [(2, 1), (-1, 1), ("left", "right"), ("A", "B")])
def test_other_codes_need_to_be_declared_and_lose_no_row_then(tmp_path, codes):
    path, truth = table(tmp_path, codes)
    with pytest.raises(UserError, match=f"column felt: the answers are .*'{str(codes[1]).lower()}"):
        load(path, mapping())
    found = load(path, mapping({"yes": str(codes[1])})).differences["difference_felt"]
    assert list(found) == list(truth.astype(float))


def test_counts_are_no_answers(tmp_path):
    path = tmp_path / "counts.csv"
    pd.DataFrame(
        [{"who": w, "size": s, "felt": 3 * s + w} for w in range(5) for s in range(1, 7)]
    ).to_csv(path, index=False)
    with pytest.raises(UserError, match="for counts of yes answers, use --yes-count and --n"):
        load(path, mapping())


def test_counts_read_as_so_many_answers(tmp_path):
    path = tmp_path / "counts.csv"
    rows = [("a", 1.0, 2, 10), ("a", 2.0, 7, 10), ("b", 1.0, 0, 8), ("b", 2.0, 8, 8)]
    pd.DataFrame(rows, columns=["who", "size", "k", "of"]).to_csv(path, index=False)
    found = load(path, mapping(answer="", yes_count="k", n="of")).differences
    sums = found.groupby(["participant_id", "level_before"], observed=True)["difference_felt"].agg(
        ["sum", "count"]
    )
    assert [tuple(row) for row in sums.to_numpy()] == [(2, 10), (7, 10), (0, 8), (8, 8)]


def test_a_count_above_n_is_refused_with_its_line(tmp_path):
    path = tmp_path / "counts.csv"
    pd.DataFrame({"who": ["a"], "size": [1.0], "k": [11], "of": [10]}).to_csv(path, index=False)
    with pytest.raises(UserError, match="line 2: k is 11 and of is 10; expected whole numbers"):
        load(path, mapping(answer="", yes_count="k", n="of"))


def test_the_report_speaks_in_the_datas_own_word_for_yes(tmp_path, page):
    path, _ = table(tmp_path, ("slower", "faster"))
    found = analyse(load(path, mapping({"yes": "faster"})))
    assert answers(found)[0].startswith("The probability of “faster” depended on size")
    shown = page(found).partition("<main")[2].partition("All tests")[0]
    assert "“yes”" not in shown
    # A number or a letter is no word.
    assert mapping({"yes": "2"}).quantity.yes == "yes"


@pytest.mark.parametrize("codes", [("no", "yes"), ("False", "True"), (0, 1), ("wrong", "correct")])
@pytest.mark.parametrize("other,times", [("perhaps", 1), ("0.5", 2), ("3", 40)])
def test_no_code_is_left_out_because_it_is_rare(tmp_path, codes, other, times):
    path, truth = table(tmp_path, codes)
    yes = str(codes[1])
    path.write_text(path.read_text().replace(f",{yes}\n", f",{other}\n", times))
    with pytest.raises(UserError, match=rf"'{other}' \({times} times\).*--missing CODE"):
        load(path, mapping())
    with pytest.raises(UserError, match=rf"meaning of .*'{other}' \({times} times\).*--no CODE"):
        load(path, mapping({"yes": yes}))
    data = load(path, mapping({"yes": yes, "missing": other}))
    assert len(data.differences) == len(truth) - times
    assert data.differences["difference_felt"].sum() == truth.sum() - times
    (said,) = [line for line in data.problems if "means that there is no answer" in line]
    assert said.startswith(f"column felt: {times} of {len(truth)} trials are left out")
    data = load(path, mapping({"yes": yes, "no": [str(codes[0]), other]}))
    assert list(data.differences["difference_felt"]).count(0.0) == (~truth).sum() + times


def test_a_column_that_mixes_codings_is_rejected_with_the_counts(tmp_path):
    """A file had TRUE and FALSE for answers and 0 for none: 2.54 became 3.04."""
    path, truth = table(tmp_path, ("FALSE", "TRUE"))
    path.write_text(path.read_text().replace(",FALSE\n", ",0\n", 7))
    counts = {"true": truth.sum(), "false": (~truth).sum() - 7, "0": 7}
    with pytest.raises(UserError) as refused:
        load(path, mapping())
    for code, times in counts.items():
        assert f"'{code}' ({times} times)" in str(refused.value)


def test_a_declared_code_that_never_occurs_is_refused(tmp_path):
    path, _ = table(tmp_path, (1, 2))
    with pytest.raises(UserError, match=r"'3' does not occur; found '[12]'"):
        load(path, mapping({"yes": "3"}))


def forced_choice(tmp_path, threshold):
    """Twelve people who choose one of two: Weibull, 75 % right at about the threshold."""
    random = np.random.default_rng(5)
    sizes = np.repeat([0.05, 0.1, 0.2, 0.4, 0.8, 1.2], 40)
    rows = pd.DataFrame(
        {
            "who": np.repeat([f"p{i:02}" for i in range(12)], len(sizes)),
            "size": np.tile(sizes, 12),
        }
    )
    right = 0.5 + 0.5 * stats.weibull_min.cdf(rows["size"], 2.0, scale=threshold / 0.8326)
    path = tmp_path / "choices.csv"
    rows.assign(felt=(random.random(len(rows)) < right).astype(int)).to_csv(path, index=False)
    return path


def test_a_forced_choice_has_its_guess_rate(tmp_path):
    data = load(forced_choice(tmp_path, 0.4), mapping({"alternatives": 2}))
    choices = data.trials["forced_choices"]
    assert set(choices["method"]) == {"two_interval"}
    assert not len(data.differences)
    (task,) = analyse(data).inference.thresholds
    assert task.population.threshold_level.value == pytest.approx(0.4, rel=0.1)


def test_answers_that_look_like_guessing_are_remarked(tmp_path):
    data = load(forced_choice(tmp_path, 0.4), mapping())
    assert any("add --alternatives 2" in line for line in data.problems)
    path, _ = table(tmp_path, ("no", "yes"))
    assert not any("--alternatives" in line for line in load(path, mapping()).problems)


def test_stimuli_below_and_above_the_reference_are_comparisons(tmp_path):
    random = np.random.default_rng(3)
    rows = pd.DataFrame(
        {
            "who": np.repeat([f"p{i}" for i in range(8)], 280),
            "size": np.tile(np.repeat([0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3], 40), 8),
            "standard": 1.0,
        }
    )
    more = stats.norm.cdf(rows["size"], 1.05, 0.15)
    path = tmp_path / "comparison.csv"
    rows.assign(felt=(random.random(len(rows)) < more).astype(int)).to_csv(path, index=False)
    data = load(path, mapping(reference="standard"))
    assert set(data.trials["forced_choices"]["method"]) == {"comparison"}
    (task,) = analyse(data).inference.thresholds
    assert task.standard_level == 1.0
    # The point of subjective equality is 1.05.
    assert task.population.threshold_level.value == pytest.approx(1.05, abs=0.02)


def test_the_command_states_the_option_that_is_missing(tmp_path, capsys):
    path, _ = table(tmp_path, (2, 1))
    words = ["analyse", str(path), "--participant", "who", "--stimulus", "size", "--answer", "felt"]
    assert commands.main(words) == 2
    assert "for example --yes 1" in capsys.readouterr().err


@pytest.mark.parametrize(
    "codes, example",
    [(["not felt"] * 3 + ["was felt"], "--yes 'not felt'"), (["-1"] * 3 + ["1"], "--yes 1")],
)
def test_the_example_of_a_code_can_be_pasted_and_is_usual(codes, example):
    frame = pd.DataFrame({"felt": codes, "file": 0, "line": range(4)})
    with pytest.raises(UserError, match=f"for example {example},"):
        as_answers(frame, "felt", [], Problems())


def signed(tmp_path, comparison, standard):
    """Twelve people who answer yes to comparisons above the standard, more often at a distance."""
    random = np.random.default_rng(3)
    rows = [
        {
            "who": f"p{who}",
            "size": comparison + step,
            "base": standard,
            "felt": "yes" if random.random() < stats.norm.cdf(step / 1.5) else "no",
        }
        for who in range(12)
        for step in (-4.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0)
        for _ in range(8)
    ]
    path = tmp_path / "signed.csv"
    pd.DataFrame(rows).to_csv(path, index=False)
    return path


def test_comparisons_around_a_standard_have_a_point_of_equality_in_the_table_s_words(tmp_path):
    found = answers(analyse(load(signed(tmp_path, 10.0, 10.0), mapping(reference="base"))))
    (sentence,) = [each for each in found if "point of subjective equality" in each]
    assert "half of the answers are “yes”" in sentence


@pytest.mark.parametrize("columns", [{"reference": "base"}, {}])
def test_offsets_to_both_sides_have_a_point_of_equality_and_no_catch_trials(tmp_path, columns):
    """Level 0 was a catch trial, so that d' was printed."""
    data = load(signed(tmp_path, 0.0, 0.0), mapping(**columns))
    assert not data.trials["forced_choices"]["catch"].any()
    (found,) = analyse(data).inference.found(THRESHOLDS)
    assert found.population.threshold_level.value == pytest.approx(0.0, abs=0.2)
    # The half-width of a normal distribution with an SD of 1.5.
    assert found.population.half_width_level.value == pytest.approx(1.5 * 0.6745, rel=0.2)


def test_offsets_of_a_forced_choice_are_refused_with_the_way_to_continue(tmp_path):
    choice = mapping(answers={"alternatives": 2})
    with pytest.raises(UserError, match=r"size of -4.*omit --alternatives"):
        load(signed(tmp_path, 0.0, 0.0), choice)
