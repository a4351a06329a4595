"""Published tables: what is read, and what is refused with a sentence."""

from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from analysis.reconstruction.published_table import from_csv, from_toml
from analysis.reconstruction.solutions import Solutions
from faults import UserError

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


@pytest.mark.parametrize(
    "old, new, said",
    [
        ("n = 5", "n = 1", "n is 1, expected 2 or more"),
        ("n = 5", 'n = "five"', "whole number"),
        ("n = 5", "", "n is missing"),
        ("mean = 2.40", 'mean = "11.2"', "outside the scale"),
        ("mean = 2.40", 'mean = "2,40"', "not a decimal number"),
        ("mean = 2.40", "mean = nan", "not a decimal number"),
        ('sd = "1.14"', 'sd = "-1"', "impossible"),
        ("minimum = 0", "minimum = 10", "not above minimum"),
        ("minimum = 0", "minimum = 0\nstep = 3", "does not divide"),
        ("minimum = 0", "minimum = 0\nstep = 0", "expected a number above 0"),
        ("minimum = 0", "minimum = 0\nstop = 3", "unknown key 'stop'"),
        ('label = "a"', 'label = "a"\nsd_convention = "robust"', "expected sample or population"),
        ('label = "a"', 'label = "a"\nrounding = "up"', "expected one of"),
        ('label = "a"', 'label = "a"\nmode = 3', "unknown key 'mode'"),
        (
            'label = "a"',
            'label = "a"\nobserved_minimum = "4"\nobserved_maximum = "3"',
            "contradict",
        ),
        ("[scale]", "[scale", "not TOML"),
    ],
)
def test_a_wrong_entry_is_refused_with_what_where_and_why(old, new, said):
    with pytest.raises(UserError, match=said.replace("(", r"\(")):
        from_toml(GOOD.replace(old, new))


@settings(max_examples=40)
@given(text=st.text(), read=st.sampled_from([from_toml, from_csv]))
def test_any_text_is_a_table_or_a_users_mistake(text, read):
    with suppress(UserError):
        assert read(text).columns


def test_no_sum_of_squares_of_the_right_parity_is_a_grimmer_reason(column):
    assert "GRIMMER" in Solutions(column(5, "2.40", "1.00", maximum=10)).reason
