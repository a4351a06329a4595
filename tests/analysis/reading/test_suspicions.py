"""What is probably not data in a table by hand: refused, or noted and kept."""

import pandas as pd
import pytest

from slipscale.analysis.load import load
from slipscale.analysis.reading.dialect import decimal_of
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.analysis.reading.suspicions import check_levels
from slipscale.faults import UserError

HEADER = "participant_id,amplitude_um_pp,estimate"
LEVELS = (0.5, 1.2, 2.3)


def written(tmp_path, rows):
    path = tmp_path / "data.csv"
    path.write_text("\n".join([HEADER, *(",".join(map(str, row)) for row in rows)]) + "\n")
    return path


def rated(who, factor=1.0, times=1):
    return [
        (who, level, round(10 * factor * level + number, 2))
        for number in range(times)
        for level in LEVELS
    ]


@pytest.mark.parametrize("name", ["Mean", "average", "Total", "Std. dev.", "Mittelwert", "Moyenne"])
def test_a_row_that_summarises_the_table_is_refused(tmp_path, name):
    rows = [*rated("a"), *rated("b"), (name, 0.5, 3.0)]
    with pytest.raises(UserError, match=f"'{name}' is probably a summary row"):
        load(written(tmp_path, rows))


def test_initials_are_no_summary(tmp_path):
    assert load(written(tmp_path, [*rated("SD"), *rated("N"), *rated("SE")])).people == {
        "SD", "N", "SE",
    }  # fmt: skip


@pytest.mark.parametrize("other", ["01", "1.0", "1."])
def test_one_number_in_two_spellings_is_refused(tmp_path, other):
    with pytest.raises(UserError, match=f"'1' and '{other}' represent the same number"):
        load(written(tmp_path, [*rated("1"), *rated("2"), *rated(other)]))


def test_labels_that_differ_in_case_only_are_noted(tmp_path):
    data = load(written(tmp_path, [*rated("p1"), *rated("P1", 2)]))
    assert data.people == {"p1", "P1"}
    assert any("'p1' and 'P1' differ only in case" in each for each in data.problems)


def test_a_code_for_a_missing_answer_is_noted_and_kept(tmp_path):
    rows = [*rated("a"), *rated("b"), ("a", 0.5, 999), ("b", 0.5, 999)]
    data = load(written(tmp_path, rows))
    (note,) = [each for each in data.problems if "999" in each]
    assert note == (
        "data.csv: 2 answers are 999, and the next largest answer is 23; if 999 means a missing "
        "answer, "
        "write n/a"
    )
    assert (data.estimates["estimate"] == 999).sum() == 2


def test_a_large_honest_number_is_not_noted(tmp_path):
    rows = [("a", 0.5, 300), ("a", 1.2, 500), ("a", 2.3, 999)]
    assert load(written(tmp_path, rows)).problems == ()


def test_answers_that_were_pasted_twice_or_copied_are_noted(tmp_path):
    one, two = rated("a", times=3), rated("b", 2.0, times=3)
    data = load(written(tmp_path, [*one, *one, *two]))
    assert (
        "data.csv: the last 9 answers of a repeat the first 9; check whether they were pasted twice"
        in data.problems
    )
    copied = [("b", level, estimate) for _, level, estimate in one]
    data = load(written(tmp_path, [*one, *copied]))
    assert (
        "data.csv: a and b have the same 9 answers in the same order; check whether they were "
        "copied" in data.problems
    )
    assert load(written(tmp_path, [*one, *two])).problems == ()


def test_a_point_that_may_part_thousands_is_refused():
    cells = {"estimate": {"1.080": 1, "540": 1}}
    with pytest.raises(UserError, match=r"'1\.080' could be 1080 or 1\.080"):
        decimal_of(cells, name="data.csv")
    # Decimals that a program wrote: all of them, or another number that decides.
    assert decimal_of({"estimate": {"1.080": 1, "2.540": 1}}, name="data.csv") == "."
    assert decimal_of(cells | {"level": {"0.5": 1}}, name="data.csv") == "."
    assert decimal_of(cells | {"level": {"0,5": 1}}, name="data.csv") == ","


def test_a_thousands_point_is_a_thousand_if_the_decimal_mark_is_stated(tmp_path):
    path = tmp_path / "data.csv"
    pd.DataFrame({"who": ["a", "b"], "level": [1, 2], "told": ["1.080", "540"]}).to_csv(
        path, index=False, sep=";"
    )
    table = {"columns": {"participant": "who", "stimulus": "level", "response": "told"}}
    mapping = parse_mapping(table | {"table": {"decimal": ","}}, "here")
    assert list(load(path, mapping).estimates["estimate"]) == [1080, 540]


@pytest.mark.parametrize("code, levels", [(999, LEVELS), (-999, (-2, -1, 0, 1, 2))])
def test_a_level_that_is_a_code_for_a_missing_value_is_refused(tmp_path, code, levels):
    path = tmp_path / "coded.csv"
    rows = [f"{who},{level},{said}" for who in "abc" for level in levels for said in "0011"]
    path.write_text("\n".join(["who,level,said", *rows, f"a,{code},1"]))
    options = {"participant": "who", "stimulus": "level:mm", "answer": "said"}
    with pytest.raises(UserError, match=f"the level {code} is probably a code for a missing"):
        load(path, **options)
    path.write_text("\n".join(["who,level,said", *rows]))
    load(path, **options)


def test_trial_numbers_that_restart_are_refused_instead_of_dropping_answers(tmp_path):
    path = tmp_path / "restarting.csv"
    trials = [
        f"{who},{block},{n},{n % 3 + 1},{n}" for who in "ab" for block in (1, 2) for n in range(9)
    ]
    path.write_text("\n".join(["who,part,number,level,loud", *trials]) + "\n")
    options = {"participant": "who", "stimulus": "level:mm", "response": "loud"}
    with pytest.raises(UserError, match=r"18 of 36 answers .*--block"):
        load(path, trial="number", **options)
    assert len(load(path, trial="number", block="part", **options).estimates) == 36


def test_a_code_that_is_the_only_level_below_0_is_refused():
    others = [1.0, 2.0, 4.0, 8.0]
    with pytest.raises(UserError, match="the level -99 is probably a code for a missing value"):
        check_levels(pd.Series([*others, -99.0]), "data.csv")
    check_levels(pd.Series([*others, -99.0, -50.0]), "data.csv")
    check_levels(pd.Series([*others, 99.0]), "data.csv")
