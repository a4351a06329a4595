"""Any file ends in a result or in one sentence, and no row of a table is lost without a count."""

import re

import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from slipscale.analysis.load import load
from slipscale.analysis.reading.foreign.proposal import described
from slipscale.faults import UserError

WHO = {"participant": "who", "stimulus": "level"}
LAYOUTS = (
    {},
    WHO | {"answer": "said"},
    WHO | {"answer": "said", "alternatives": 2, "group": "cond"},
    WHO | {"answer": "said", "factor": "cond", "trial": "n"},
    WHO | {"answer": "said", "reference": "n"},
    WHO | {"answer": "said", "rows_of": "cond=x,y"},
    WHO | {"response": "n", "only": {"cond": ["x"]}},
    WHO | {"yes_count": "k", "n": "n"},
    WHO | {"percent": "k", "n": "20"},
    {"participant": "who", "stimulus": "size", "levels": {"k": 1.0, "n": 2.0}},
    {"people_in_columns": True, "stimulus": "level"},
    {"matrix": "wins"},
    {"matrix": "dissimilarities", "participant": "who"},
    {"participant": "who", "first": "who2", "second": "cond", "chosen": "said"},
    {"participant": "who", "first": "who2", "second": "cond", "dissimilarity": "n"},
    {"quadruple": "k,n,level,line", "answer": "said"},
    {"participant": "1", "stimulus": "2", "answer": "3", "no_header": True},
    {"participant_from_name": "", "stimulus": "level:dB", "answer": "said"},
)
NAMES = ("who", "level", "said", "cond", "k", "n", "who2", "line", "file", "", "1", "2", "3")
CELLS = st.sampled_from(
    [
        *("", "0", "1", "2", "4.5", "-1", "1,5", "1.080", "50%", "1e400", "nan", "inf", "NA"),
        *("n/a", "yes", "no", "x", "y", "p1", "p1 ", "P1", "01", "Mean", "é", "#x", '"', " "),
    ]
)
TABLES = st.builds(
    lambda names, rows, mark, above, end: (
        above + "\n".join(mark.join(row[: len(names)]) for row in ([*names], *rows)) + end
    ),
    st.lists(st.sampled_from(NAMES), min_size=1, max_size=8, unique=True),
    st.lists(st.lists(CELLS, min_size=8, max_size=8), max_size=8),
    st.sampled_from(",;\t| "),
    st.sampled_from(("", "", "", "# by hand\n", "Loudness\n\n", "sep=;\n", "\n")),
    st.sampled_from(("\n", "", "\n\n", "\n# end\n", "\r\n")),
)
CONTENTS = st.one_of(
    TABLES.map(str.encode),
    st.builds(str.encode, TABLES, st.sampled_from(("utf-16", "utf-16-le", "utf-16-be", "utf-32"))),
    st.builds(
        lambda head, rest: head + rest,
        st.sampled_from((b"", b"PK\3\4", b"\x1f\x8b\x08", b"BZh9", b"[{", b'{"a":', b"\xff\xfe")),
        st.binary(max_size=60),
    ),
)
ENDINGS = (
    *(".csv", ".txt", ".tsv", ".json", ".jsonl", ".xlsx", ".mat", ".sav", ".dta", ".gz", ".zip"),
    *(".csv.gz", ".ods", ""),
)
MANY = settings(
    deadline=None,
    max_examples=150,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


@MANY
@given(CONTENTS, st.sampled_from(ENDINGS), st.sampled_from(LAYOUTS))
def test_any_content_in_any_layout_ends_in_a_result_or_one_sentence(
    tmp_path, content, ending, layout
):
    path = tmp_path / f"table{ending}"
    path.write_bytes(content)
    for read in (lambda: load(path, **layout), lambda: described([path])):
        try:
            read()
        except UserError as error:
            sentence = str(error)
            assert sentence
            assert "Traceback" not in sentence


def left_out(problems):
    """Return numbers of rows that notes count as left out; a row may be in several of them."""
    counts, lines = [], set()
    for text in problems:
        if found := re.search(r"(\d+) of \d+ trials without|(\d+) rows with neither", text):
            counts.append(int(found[1] or found[2]))
        elif re.search(r"omitted|skipped|is kept", text):
            (listed,) = re.findall(r"lines? ([\d, and]+)", text)[:1]
            lines |= {int(number) for number in re.findall(r"\d+", listed)}
    return [*counts, len(lines)]


ANSWERS = {
    "response": st.sampled_from(("3", "0", "4.5", "", "n/a", "NA", "high")),
    "answer": st.sampled_from(("yes", "no", "", "n/a", "NA")),
}


@pytest.mark.parametrize("mark, kind", [(",", "response"), (",", "answer"), (";", "answer")])
@pytest.mark.parametrize("alternatives", [None, 2])
@MANY
@given(st.data())
def test_rows_used_and_rows_left_out_are_all_rows(tmp_path, kind, mark, alternatives, data):
    cells = (
        st.sampled_from(("a", "b", "NA", "", " ")),
        st.sampled_from(("1", "2", "4.5", "", "n/a", "NA", "far")),
        ANSWERS[kind],
    )
    rows = data.draw(st.lists(st.tuples(*cells), max_size=9))
    path = tmp_path / "table.csv"
    path.write_text("\n".join(map(mark.join, [("who", "level", "said"), *rows])) + "\n")
    try:
        found = load(path, **WHO, **{kind: "said"}, alternatives=alternatives)
    except UserError:
        return
    # Blank lines at the end of a file need no note.
    blank = next((n for n, row in enumerate(rows[::-1]) if "".join(row).strip()), len(rows))
    lost = len(rows) - len(found)
    counts = left_out(found.problems)
    counts += [found.counts.get(name, 0) for name in ("unanswered", "difference_unanswered")]
    assert max(counts) <= lost <= sum(counts) + blank, (rows, found.problems)


def test_a_frame_with_an_unexpected_number_of_rows_is_refused(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text('who,level,said\n"a"b",1,yes\nc,2,no\n"d",3,yes\n')
    with pytest.raises(UserError, match="line 2 has an unmatched quotation mark"):
        load(path, **WHO, answer="said")


def test_a_table_without_rows_is_described(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("who,level,said\n")
    assert len(described([path]).frame) == 0
    assert pd.DataFrame(described([path]).frame).columns.tolist() == ["who", "level", "said"]


@pytest.mark.parametrize(
    "text, matrix",
    [
        ("who,1\n1,\n", None),
        (",a,b\na,,2\nb,2,\n", "dissimilarities"),
        (",a,b\na,9,2\nb,2,9\n", "similarities"),
    ],
)
def test_a_square_table_may_have_blank_cells(tmp_path, text, matrix):
    path = tmp_path / "square.csv"
    path.write_text(text, encoding="utf-8")
    assert dict(described([path]).given).get("matrix") == matrix
