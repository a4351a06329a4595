"""Published tables: what is read, and what is refused with a sentence."""

from __future__ import annotations

import re
from contextlib import suppress
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.table.table_files import from_csv, from_toml
from slipscale.analysis.reconstruction.table.words import assumptions, in_words
from slipscale.faults import UserError

GOOD = """
[scale]
minimum = 0
maximum = 10
[[column]]
label = "a"
n = 5
mean = 2.40
sd = "1.14"
"""


def test_a_bare_number_keeps_its_printed_decimals():
    assert from_toml(GOOD).columns[0].mean.text == "2.40"


def test_csv_and_toml_say_the_same():
    text = "label,n,mean,sd,scale_maximum\na,5,2.40,1.14,10\n"
    assert from_csv(text).columns == from_toml(GOOD).columns


def test_numbers_are_read_as_papers_print_them(column):
    text = "label;n;mean;sd;scale_minimum;scale_maximum\na;5;\u22122,40;1,14;\u221210;10\n"
    assert from_csv(text).columns == (
        column(5, "-2.40", "1.14", minimum=-10, maximum=10).model_copy(
            update={"label": "a", "assumed": ("step", "sd_convention")}
        ),
    )


def test_what_is_not_printed_is_named_as_assumed():
    text = "label,n,mean,sd,scale_minimum,scale_step\na,5,2.40,1.14,0,\n"
    (column,) = from_csv(text).columns
    assert column.assumed == ("maximum", "step", "sd_convention")
    assert "from 0, maximum not printed, step not printed" in in_words(column)
    said = "; ".join(assumptions(column))
    assert "in steps of 1 (no step is stated)" in said
    # By hand: no rating lies farther from the mean than 1.145 √5 = 2.56 allows, so 5 at most.
    assert "scale ends that are derived from the SD: maximum 5" in said
    assert "divides by n - 1 (no divisor is stated)" in said


@pytest.mark.parametrize(
    "old, new, said",
    [
        ("n = 5", "n = 1", "line 7, n of item 1 of column: .*expected 2 or more, got 1"),
        ("n = 5", 'n = "five"', "line 7, n of item 1 of column: .*whole number.*, got 'five'"),
        ("n = 5", "", "line 5, n of item 1 of column: is missing"),
        (
            "mean = 2.40",
            "mean = nan",
            "line 8, mean of item 1 of column: .*decimal number.*, got 'nan'",
        ),
        ("mean = 2.40", "mean = 1e999999", "line 8, mean of item 1 of column: .*got '1e999999'"),
        ("mean = 2.40", "mean = [2]", "line 8, mean of item 1 of column: .*decimal number"),
        ('sd = "1.14"', 'sd = "-1"', "line 9, sd of item 1 of column: expected 0 or more"),
        (
            "minimum = 0",
            "minimum = 10",
            "line 2, scale: maximum must be above minimum 10, but is 10",
        ),
        ("minimum = 0", "minimum = 0\nstep = 3", "does not divide"),
        ("minimum = 0", "minimum = 0\nstep = 0", "step must be above 0, but is 0"),
        ("minimum = 0", 'minimum = 0\nstep = "1/0"', "such as 1, 0.5 or 1/3, got '1/0'"),
        ("minimum = 0", "minimum = 0\nstop = 3", "line 4, scale.stop: unknown key"),
        ('label = "a"', 'label = "a"\nsd_convention = "robust"', "'sample' or 'population'"),
        ('label = "a"', 'label = "a"\nrounding = "up"', "'half_even' or 'truncated', got 'up'"),
        (
            'label = "a"',
            'label = "a"\nmode = 3',
            "line 7, mode of item 1 of column: unknown key",
        ),
        ('label = "a"', 'label = "a"\namplitude_um_pp = [1]', "line 7, .*expected a number"),
        ("\n[scale]", "column = [1, 2]\n[scale]", "is not TOML"),
        ("[scale]", "[scale", "not TOML"),
    ],
)
def test_a_wrong_entry_is_refused_with_line_key_and_what_was_expected(old, new, said):
    with pytest.raises(UserError, match=said):
        from_toml(GOOD.replace(old, new))


def test_columns_that_are_no_tables_are_refused():
    with pytest.raises(UserError, match=r"line 1, item 2 of column: expected a table, got 2"):
        from_toml("column = [1, 2]\n[scale]\nmaximum = 10")


def test_every_fault_of_a_csv_file_is_told_at_once_with_its_line():
    text = (
        "label,n,mean,mode,mode,scale_maximum,scale_step\n"
        "a,5,2.4,1,1,10,1\n"
        "b,1,x,1,1,10,3\n"
        "\n"
        "c,5,2.4,1,1,10\n"
    )
    with pytest.raises(UserError) as caught:
        from_csv(text, "t.csv")
    lines = str(caught.value).splitlines()
    expected = [
        "t.csv has 5 faults:",
        "  line 1, mode: expected one of label, n, mean, mean_percent, sum, sd, ",
        "  line 3, mean: expected a decimal number such as 12.75, got 'x'",
        "  line 3, n: expected 2 or more, got '1'",
        "  line 3, scale: step 3 does not divide the scale from 0 to 10; expected a whole number",
        "  line 5: the header has 7 cells, but the row has 6",
    ]
    for line, beginning in zip(lines, expected, strict=True):
        assert line.startswith(beginning)


@pytest.mark.parametrize(
    "text, said",
    [
        ("label,n,mean,sd,scale_maximum\n" + "a" * 200_000, "is not CSV: field larger than"),
        ("n,n,mean,sd,scale_maximum\n1,2,3,4,5", "line 1, n: occurs 2 times"),
        ("n,mean,sd,scale_maximum\n", "has no rows"),
        ("", "has no rows"),
    ],
    ids=["cell", "twice", "no row", "nothing"],
)
def test_a_csv_file_that_is_no_table_is_refused(text, said):
    with pytest.raises(UserError, match=said):
        from_csv(text)


@pytest.mark.parametrize(
    "facts, said",
    [
        ({"mean": "11.2"}, "mean 11.2 lies outside the scale from 0 to 10"),
        ({"sd": "11.50"}, "sd 11.50 is impossible on a scale from 0 to 10"),
        ({"observed_minimum": "4", "observed_maximum": "3"}, "contradict each other"),
        ({"median": "-2", "maximum_deviation": "12"}, "median -2 lies .* maximum_deviation 12 is"),
    ],
)
def test_a_number_that_no_ratings_have_is_a_finding_and_no_mistake(column, facts, said):
    solutions = Solutions(column(**{"n": 5, "mean": "2.40", "sd": "1.14", "maximum": 10} | facts))
    assert not solutions.consistent
    assert re.search(said, solutions.reason)
    assert solutions.targets.grim == ("mean" not in facts)


PIECES = st.sampled_from(
    [
        "n",
        "mean",
        "sd",
        "scale_maximum",
        "scale",
        "column",
        "=",
        ",",
        ";",
        "\n",
        '"',
        "1",
        "5",
        "2.40",
        "[[",
        "]]",
        "[",
        "]",
        "{",
        "}",
        "1e999999",
        "\u2212",
        "9" * 400,
        "'",
        "\x00",
    ]
)


@given(
    text=st.text() | st.lists(PIECES, max_size=40).map("".join),
    begun=st.sampled_from(["", GOOD, "n,mean,sd,scale_maximum\n5,2.4,1.1,9\n"]),
    read=st.sampled_from([from_toml, from_csv]),
)
def test_any_text_is_a_table_or_a_users_mistake(text, begun, read):
    with suppress(UserError):
        assert read(begun + text).columns


def test_no_sum_of_squares_of_the_right_parity_is_a_grimmer_reason(column):
    assert "GRIMMER" in Solutions(column(5, "2.40", "1.00", maximum=10)).reason


def test_a_mean_of_items_has_steps_as_fine_as_the_items_make_it():
    text = """
[scale]
minimum = 1
maximum = 7
items = 3
[[column]]
n = 4
mean = "3.25"
sd = "1.26"
"""
    (column,) = from_toml(text).columns
    assert (column.scale.step, column.scale.steps) == (Fraction(1, 3), 18)
    header = "n,mean,sd,scale_minimum,scale_maximum,scale_items\n"
    (row,) = from_csv(header + "4,3.25,1.26,1,7,3\n").columns
    assert row.scale == column.scale
    (direct,) = from_toml(text.replace("items = 3", 'step = "1/3"')).columns
    assert Solutions(column).multisets == Solutions(direct).multisets > 0


@pytest.mark.parametrize("items", ["0", "-2", "1.5", '"three"'])
def test_items_that_are_no_number_of_items_are_refused(items):
    text = f"[scale]\nmaximum = 7\nitems = {items}\n[[column]]\nn = 4\nmean = 3.25\nsd = 1.26\n"
    with pytest.raises(UserError, match=r"line 3, scale\.items"):
        from_toml(text)
