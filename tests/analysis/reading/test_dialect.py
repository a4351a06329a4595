"""Encoding, separator and decimal mark of tables by hand: decided once, from the whole file."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.dialect import decimal_of, in_points
from slipscale.faults import UserError

pytestmark = pytest.mark.usefixtures("without_models")

AMPLITUDES = ("0", "0,5", "1,2", "2,3")
HEADER = ("participant_id", "amplitude_um_pp", "estimate")


def french(separator=";", estimates=None, quote=""):
    """Return 12 people by 4 amplitudes as Excel in French writes them: mean 62,3 at 2,3 µm."""
    rows = [HEADER]
    for person in range(12):
        for number, amplitude in enumerate(AMPLITUDES):
            value = f"{15.3 + 10 * number + 17 * (number == 3) + person - 5.5:.1f}"
            rows.append((f"p{person}", amplitude, value.replace(".", ",")))
    return "\n".join(
        separator.join(f"{quote}{cell}{quote}" if "," in cell else cell for cell in row)
        for row in rows
    )


@pytest.mark.parametrize(
    "separator,quote", [(";", ""), (";", '"'), ("\t", ""), ("\t", '"'), (",", '"')]
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_one_bad_cell_takes_no_decimal_comma_with_it(table_by_hand, separator, quote, encoding):
    """48 rows and one `?`: n = 12 at each amplitude, and the mean at the largest 62.3."""
    text = french(separator, quote=quote) + f"\np0{separator}0{separator}?\n"
    data = load(table_by_hand(text, encoding=encoding))
    by_amplitude = data.estimates.groupby("level")["estimate"]
    assert by_amplitude.size().to_dict() == {0.0: 12, 0.5: 12, 1.2: 12, 2.3: 12}
    assert by_amplitude.mean()[2.3] == pytest.approx(62.3)
    (sentence,) = data.problems
    assert "line 50, column estimate: '?' instead of a number" in sentence


def test_a_bad_cell_leaves_the_table_that_is_written_as_it_was(table_by_hand):
    clean = analyse(table_by_hand(french(), "a.csv"), normalise="none").table3
    spoilt = analyse(table_by_hand(french() + "\np0;0;?\n", "b.csv"), normalise="none").table3
    assert spoilt.equals(clean)
    assert list(clean["n"]) == [12, 12, 12, 12]


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_comma_that_may_part_thousands_is_refused_where_nothing_decides(table_by_hand, separator):
    text = "\n".join(separator.join(row) for row in [HEADER, ("a", "1", "1,000"), ("a", "2", "2")])
    with pytest.raises(UserError, match=r"'1,000' could be 1000 or 1\.000.*no other number"):
        load(table_by_hand(text))


@pytest.mark.parametrize(
    "other,value",
    [("0,5", 1.0), ("0.5", 1000.0), ("12,25", 1.0), ("1,000,000", 1000.0), ("1.500,5", 1.0)],
)
def test_another_number_of_the_file_decides(table_by_hand, other, value):
    text = "\n".join(";".join(row) for row in [HEADER, ("a", other, "1,000"), ("a", "2", "2")])
    assert load(table_by_hand(text)).estimates["estimate"].iloc[0] == value


def test_thousands_in_quotes_between_commas(table_by_hand):
    text = ",".join(HEADER) + '\na,0.5,"1,234.5"\na,1,2\n'
    assert load(table_by_hand(text)).estimates["estimate"].iloc[0] == 1234.5


@pytest.mark.parametrize("written", ["1.234,5", "1 234,5", "1\u202f234,5", "1'234,5", "1234,5"])
def test_marks_between_thousands_are_no_part_of_the_number(table_by_hand, written):
    text = ";".join(HEADER) + f"\na;0,5;{written}\n"
    assert load(table_by_hand(text)).estimates["estimate"].iloc[0] == 1234.5


def test_both_marks_as_often_are_refused(table_by_hand):
    text = ";".join(HEADER) + "\na;0,5;1.5\n"
    with pytest.raises(UserError, match=r"'1.5' in column estimate.*'0,5' in\s+column amplitude"):
        load(table_by_hand(text))


def test_a_column_of_which_more_than_a_few_cells_fail_stops(table_by_hand):
    rows = [f"a,{n},{n}" for n in range(1, 9)]
    for wrong, stops in ((3, False), (4, True)):
        text = "\n".join([",".join(HEADER), *rows, *["b,1,many"] * wrong])
        path = table_by_hand(text, f"{wrong}.csv")
        if stops:
            with pytest.raises(UserError, match=r"line 10, column estimate: 'many' and 3 others"):
                load(path)
        else:
            assert len(load(path).problems) == wrong


def test_signs_for_a_missing_number_do_not_stop(table_by_hand):
    text = "\n".join([",".join(HEADER), *[f"a,{n},." for n in range(9)], "a,1,2"])
    assert load(table_by_hand(text)).counts["unanswered"] == 9


def test_windows_1252_is_read_and_said(table_by_hand):
    data = load(table_by_hand(",".join(HEADER) + "\nÉlodie,1,2\n", encoding="cp1252"))
    assert data.people == {"Élodie"}
    assert "read as Windows-1252" in data.problems[0]


NUMBERS = st.integers(-(10**9), 10**9).map(lambda n: n / 1000)


@given(NUMBERS, st.sampled_from(",."), st.booleans())
def test_a_number_written_in_a_dialect_is_read_as_that_number(value, decimal, thousands):
    text = f"{value:{',' if thousands else ''}.3f}"
    if decimal == ",":
        text = text.translate(str.maketrans(",.", ".,"))
    assert float(in_points(text, decimal)) == value


@given(st.lists(NUMBERS, min_size=1), st.sampled_from(",."))
def test_the_decimal_mark_of_numbers_with_one_decimal_is_found(values, decimal):
    cells = {f"{value:.1f}".replace(".", decimal): 1 for value in values}
    assert decimal_of({"x": cells}, name="x.csv") == decimal


@pytest.mark.parametrize("word", ["NA", "NaN", "null"])
def test_an_identifier_that_programs_write_for_a_missing_one_is_left_out_and_named(
    table_by_hand, word
):
    rows = [f"a,{n},{n}" for n in (1, 2, 3)] + [f"{word},{n},{n}" for n in (1, 2)]
    data = load(table_by_hand("\n".join([",".join(HEADER), *rows])))
    assert data.people == {"a"}
    assert f"lines 5 and 6: participant_id is '{word}'" in data.problems[0]


def test_an_identifier_in_quotes_is_a_name(table_by_hand):
    rows = ["a,1,1", '"NA",1,2', "NA,1,3", "null,1,4"]
    data = load(table_by_hand("\n".join([",".join(HEADER), *rows])))
    assert data.people == {"a", "NA"}
    assert list(data.estimates["estimate"]) == [1, 2]
    assert "lines 4 and 5: participant_id is 'NA', 'null'" in data.problems[0]


@pytest.mark.parametrize("part", ["block", "session", "run"])
@pytest.mark.parametrize("names", [("1", "2", "3"), ("A", "B", "C")])
def test_trials_that_are_numbered_anew_in_each_part_are_no_doubles(table_by_hand, part, names):
    rows = [f"participant_id,{part},trial,amplitude_um_pp,estimate"]
    rows += [f"{w},{p},{t},{t},{t}{ord(w)}" for w in "abc" for p in names for t in (1, 2, 3, 4)]
    data = load(table_by_hand("\n".join(rows)))
    assert len(data.estimates) == len(rows) - 1 == 36
    assert data.problems == ()
    doubled = load(table_by_hand("\n".join([*rows, rows[-1]]), "doubled.csv"))
    assert len(doubled.estimates) == 36
    assert "occurs twice" in doubled.problems[0]
