"""Tables by hand as people leave them, by the thousand: read, or refused in a sentence.

A campaign of all such tests: ``make fuzz TEXTS=100000``.
"""

import os

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from analysis.reading.load import load
from analysis.reading.mapping import parse_mapping
from faults import UserError

EXAMPLES = int(os.environ.get("SLIPSCALE_FUZZ", "150"))
NAMES = ("participant_id", "amplitude_um_pp", "estimate")
OTHER_NAMES = (
    "trial",
    "block",
    "session",
    "phase",
    "flag",
    "texture",
    "response_time",
    "scale_top",
)
NUMBER = st.one_of(
    st.floats(0, 1e5, allow_nan=False).map(lambda x: f"{x:.3g}"),
    st.integers(0, 10**6).map(lambda n: f"{n:,}"),
    st.integers(0, 10**6).map(lambda n: f"{n:,}".replace(",", " ")),
    st.integers(0, 10**6).map(lambda n: f"{n:,}".replace(",", "\u202f")),
    st.floats(0, 1e5, allow_nan=False).map(lambda x: f"{x:,.2f}"),
)
ODD = st.sampled_from(
    [
        *("", " ", "n/a", "NA", "?", "-", ".", ",", "#DIV/0!", "TRUE", "yes", "=A1", "1e999", "-3"),
        *("1,000", "1.000", "12e", "٣", "½", "\ufeff1", "\x1f", "9" * 5000, "1" + "0" * 400),
        *('"', '"a', 'a"b', '""', "a\nb", "é", "µ", "\u2028"),
    ]
)
WHO = st.one_of(st.sampled_from(["a", "b", "Élodie", "01", "NA", '"NA"', "null", " a "]), ODD)


@st.composite
def tables(draw):
    """A header, rows mostly of its length, in a dialect, in an encoding: as bytes."""
    separator = draw(st.sampled_from([";", "\t", ","]))
    comma = draw(st.booleans())
    names = [*NAMES, *draw(st.lists(st.sampled_from(OTHER_NAMES), max_size=3))]
    if draw(st.integers(0, 9)) == 0:
        place = draw(st.integers(0, len(names) - 1))
        names[place] = draw(st.sampled_from(['"' + names[place], "", names[0], "x" * 300]))
    rows = [separator.join(names)]
    for _ in range(draw(st.integers(0, 8))):
        cells = [draw(WHO)]
        for _ in names[1:]:
            cell = draw(NUMBER) if draw(st.integers(0, 5)) else draw(ODD)
            if comma:
                cell = cell.translate(str.maketrans(",.", ".,"))
            if separator in cell and draw(st.integers(0, 7)):
                cell = f'"{cell}"'
            cells.append(cell)
        if draw(st.integers(0, 11)) == 0:
            cells = cells[: draw(st.integers(0, len(cells)))]
        rows.append(separator.join(cells))
    text = draw(st.sampled_from(["\n", "\r\n", "\r"])).join(rows)
    encoding = draw(st.sampled_from(["utf-8", "utf-8-sig", "cp1252", "utf-16", "utf-16-le"]))
    content = text.encode(encoding, "replace")
    return (
        content[: draw(st.integers(0, len(content)))] if draw(st.integers(0, 9)) == 0 else content
    )


MAPPING = parse_mapping(
    {"columns": {"participant": NAMES[0], "stimulus": NAMES[1], "answer": NAMES[2]}}, "here"
)


@settings(
    max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck), database=None
)
@given(tables(), st.sampled_from([None, MAPPING]))
def test_a_table_by_hand_reads_or_is_refused_in_a_sentence(tmp_path_factory, content, mapping):
    path = tmp_path_factory.getbasetemp() / "fuzz.csv"
    path.write_bytes(content)
    try:
        data = load(path, mapping)
    except UserError as error:
        assert str(path) in str(error) or path.name in str(error)  # noqa: PT017 - either is right
        return
    assert data.counts["analysed"] == len(data.estimates) <= data.counts["estimation_rows"]


def test_an_unpaired_quote_in_a_header_is_a_sentence(table_by_hand):
    for separator in "\t;,":
        text = separator.join(NAMES).replace("amp", '"amp') + "\n" + separator.join("a12") + "\n"
        with pytest.raises(UserError, match="line 1, the header, has a quotation mark without"):
            load(table_by_hand(text, f"{ord(separator)}.tsv"))


def test_a_number_of_thousands_of_digits_is_a_cell_that_is_none(table_by_hand):
    text = ",".join(NAMES) + "\na,1,2\na,2," + "9" * 5000 + "\n"
    data = load(table_by_hand(text))
    assert data.counts["unanswered"] == 1
    assert len(data.problems[0]) < 300
