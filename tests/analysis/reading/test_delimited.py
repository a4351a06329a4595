"""Tables as people and programs leave them: missing cells, lines without a row, quotation marks."""

import csv
import io

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipscale.analysis.load import load
from slipscale.analysis.reading import delimited
from slipscale.analysis.reading.delimited import LISTED_PROBLEMS, Problems, read_tables
from slipscale.faults import UserError

HEADER = "participant_id,trial,amplitude_um_pp,estimate\n"
ROWS = "".join(
    f"{who},{trial},{amplitude},{10 * trial}\n"
    for who in "ab"
    for trial, amplitude in enumerate((0, 0.5, 1.2, 2.3), start=1)
)


@pytest.mark.parametrize(
    "missing", ["NA", "NaN", "nan", "#N/A", "N/A", "NULL", "None", "<NA>", "n/a", "", " ", " NA "]
)
def test_what_programs_write_for_a_missing_number_is_a_missing_number(table_by_hand, missing):
    data = load(table_by_hand(HEADER + ROWS.replace("a,3,1.2,30", f"a,3,1.2,{missing}")))
    assert data.counts["unanswered"] == 1
    assert data.counts["analysed"] == 7
    assert data.problems == ()


def test_a_data_set_that_went_through_r_reads_as_before(dataset):
    folder = dataset(participants=3)
    before = load(folder)
    for path in folder.glob("sub-*/beh/*_beh.tsv"):
        path.write_text(path.read_text().replace("n/a", "NA"))
    after = load(folder)
    assert after.problems == before.problems == ()
    pd.testing.assert_frame_equal(after.estimates, before.estimates)


def test_a_verbal_report_na_is_what_was_said(dataset):
    own = [dataset.difference_row(1, 2.3, 1.2, "yes", verbal_report="NA")]
    own.append(dataset.difference_row(2, 1.2, 0.5, "NA"))
    data = load(dataset(participants=1, differences={"01": own}))
    assert list(data.differences["verbal_report"]) == ["NA"]
    assert data.counts["difference_unanswered"] == 1
    assert data.problems == ()


def test_empty_lines_are_skipped_and_named_and_later_lines_keep_their_number(table_by_hand):
    text = HEADER + ROWS.replace("a,3", "\na,3").replace("b,1", ",,,\n  \nb,1")
    data = load(table_by_hand(text.replace("b,3,1.2,30", "b,3,1.2,oops") + "\n\n,,,\n"))
    assert data.problems[0] == "study.csv, lines 4, 7 and 8: empty; skipped"
    assert "study.csv, line 11, column estimate: 'oops'" in data.problems[1]
    assert len(data.problems) == 2
    assert data.counts["analysed"] == 7


def test_empty_lines_at_the_end_are_not_spoken_of(table_by_hand):
    assert load(table_by_hand(HEADER + ROWS + "\n \n,,,\n")).problems == ()


def test_a_header_may_come_late_and_come_back(table_by_hand):
    data = load(table_by_hand("\n\n" + HEADER + ROWS + HEADER + "c,1,0.5,oops\n"))
    assert data.problems[0] == "study.csv, line 12: a repeated header; skipped"
    assert "line 13, column estimate: 'oops'" in data.problems[1]
    assert sorted(data.estimates["participant_id"].unique()) == ["a", "b"]


def test_a_table_in_which_every_second_line_is_empty_reads(table_by_hand):
    """What Python writes on Windows without ``newline=""``."""
    path = table_by_hand("")
    path.write_bytes((HEADER + ROWS).replace("\n", "\r\r\n").encode())
    data = load(path)
    assert len(data.estimates) == 8
    assert "lines 2, 4, 6" in data.problems[0]


def test_lines_after_a_cell_of_two_lines_keep_their_number(table_by_hand):
    text = HEADER + ROWS.replace("a,1", '"a\nz",1').replace("b,3,1.2,30", "b,3,1.2,oops")
    data = load(table_by_hand(text))
    assert "line 9, column estimate: 'oops'" in data.problems[0]
    assert sorted(data.estimates["participant_id"].unique()) == ["a", "a z", "b"]


@pytest.mark.parametrize(
    "old,new,words",
    [
        ("a,3,1.2,30", 'a,3,"1.2"', "line 4 has 3 cells, expected 4.*truncated"),
        ("a,3,1.2,30", 'a,3,"1.2",30,1', "line 4 has 5 cells, expected 4.*a ',' inside a cell"),
        ("a,3,1.2,30", "a,3,1.2,30,1", "line 4 has 5 cells"),
        ("a,1,0,10\na,2,0.5,20", "a,1,0,10,1\na,2,0.5", "line 2 has 5 cells"),
        ("b,1,0,10\nb,2,0.5,20", "b,1,0\nb,2,0.5,20,1", "line 6 has 3 cells"),
        ("a,3", '"a,3', "line 4 has an unmatched quotation mark"),
        ("a,3", '"a"x,3', "line 4 has 4 cells|line 4 has an unmatched quotation mark"),
    ],
)
def test_a_row_of_another_length_is_refused_with_its_line(table_by_hand, old, new, words):
    """In quotes or not; and where a row too long makes up for one too short."""
    text = (HEADER + ROWS).replace(old, new)
    if '"a"x' in new:
        text += "c,1,0\n"
    with pytest.raises(UserError, match=words):
        load(table_by_hand(text))


def test_the_file_with_the_ragged_rows_is_named_among_its_neighbours(dataset):
    folder = dataset(participants=3)
    path = next(folder.glob("sub-02/beh/*_beh.tsv"))
    lines = path.read_text().splitlines()
    lines[3], lines[5] = lines[3].rpartition("\t")[0], lines[5] + "\tn/a"
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(UserError, match=r"sub-02_task.*line 4 has 14 cells, expected 15"):
        load(folder)


def test_blanks_around_names_make_no_other_names(table_by_hand):
    text = HEADER + ROWS.replace("a,2", " a ,2").replace("b,1", "   ,1")
    data = load(table_by_hand(text.replace("trial,", " trial ,")))
    assert sorted(data.estimates["participant_id"].unique()) == ["a", "b"]
    assert data.problems == ("study.csv, line 6: omitted, because there is no participant_id",)


def test_a_label_that_is_a_number_with_gaps_stays_as_it_was_written(table_by_hand):
    text = HEADER.replace("trial", "session") + "01,02,0,5\n01,,0.5,6\n"
    data = load(table_by_hand(text))
    assert list(data.estimates["session"]) == ["02", ""]
    assert list(data.estimates["participant_id"]) == ["01", "01"]


def test_a_space_after_every_comma_is_a_habit_of_hands(table_by_hand):
    text = (HEADER + ROWS).replace(",", ", ").replace(" 0.5,", ' "0.5",')
    assert list(load(table_by_hand(text)).estimates["level"][:2]) == [0.0, 0.5]


@pytest.mark.parametrize("said", ["TRUE", "true"])
def test_a_truth_is_no_number(table_by_hand, said):
    for rows in (ROWS, "", "c,2,0.5,\n"):
        data = load(table_by_hand(HEADER + rows + f"c,1,0.5,{said}\n"))
        assert "instead of a number" in data.problems[0]
        assert "c" not in set(data.estimates["participant_id"])


def test_a_cell_in_a_message_is_short_and_on_one_line(table_by_hand):
    text = HEADER + ROWS.replace("a,3,1.2,30", 'a,3,1.2,"five\nor ' + 500 * "x" + '"')
    (sentence,) = load(table_by_hand(text)).problems
    assert "'five or xxx" in sentence
    assert "\n" not in sentence
    assert len(sentence) < 200


def test_phases_other_than_practice_count_as_main_and_are_named(table_by_hand):
    text = HEADER.replace("trial", "phase") + "a,Practice,0,5\na,warm-up,0,6\na,MAIN,0,7\n"
    data = load(table_by_hand(text))
    assert data.counts["practice"] == 1
    assert data.counts["analysed"] == 2
    assert data.problems[0].startswith("Phase 'warm-up': its 1 trials are analysed as main trials")


def test_more_columns_than_a_screen_holds_read_without_a_warning(table_by_hand):
    names = [f"q{n}" for n in range(150)]
    text = HEADER.replace("\n", "," + ",".join(names) + "\n")
    for body in ("", "a,1,0.5,3" + 150 * ",x" + "\n"):
        path = table_by_hand(text + body)
        assert len(load(path).answers) == body.count("\n")
        frame, _ = read_tables([path], path.parent, separator=",")
    assert {"q0", "q149", "file", "line"} <= set(frame)


def test_many_sentences_are_counted_and_only_a_dozen_made():
    problems = Problems()
    problems.add_many(["one"] * LISTED_PROBLEMS, "a kind", total=1_000_000)
    assert problems.sentences[-1] == "... and 999988 more of this kind (a kind)"


CELL = st.text(st.characters(codec="utf-8", exclude_characters="\0\r\ufeff"), max_size=6)


@settings(max_examples=150, deadline=None)
@given(
    st.lists(st.tuples(CELL.map("x{}".format), CELL, CELL), min_size=1, max_size=6),
    st.sampled_from("\t,;"),
)
def test_whatever_is_in_the_cells_rows_and_lines_are_those_of_the_csv_module(
    tmp_path_factory, rows, separator
):
    """Quotation marks, separators and line ends inside cells; empty lines between rows."""
    text = io.StringIO()
    writer = csv.writer(text, delimiter=separator, lineterminator="\n", quoting=csv.QUOTE_ALL)
    places = []
    text.write(separator.join(("one", "two", "three")) + "\n")
    for number, row in enumerate(rows):
        if number % 2:
            text.write("\n")
        places.append(text.getvalue().count("\n") + 1)
        writer.writerow(row)
    path = tmp_path_factory.mktemp("any") / "any.csv"
    path.write_text(text.getvalue(), encoding="utf-8", newline="")
    frame, _ = read_tables([path], path.parent, separator=separator)
    assert list(frame["line"]) == places
    expected = [["" if c in ("", "n/a") else c for c in row] for row in rows]
    found = frame[["one", "two", "three"]]
    if all(pd.api.types.is_string_dtype(found[name]) for name in found):
        assert found.fillna("").to_numpy().tolist() == np.array(expected, object).tolist()


CELLS = st.sampled_from(["1", "-2", "2.5", "n/a", "", "x", "True", "1e3", "007", "NA"])


@settings(max_examples=60, deadline=None)
@given(st.lists(st.lists(st.tuples(CELLS, CELLS), max_size=4), min_size=1, max_size=5))
def test_files_read_in_parts_are_those_read_at_once(tmp_path_factory, files):
    folder = tmp_path_factory.mktemp("parts")
    paths = [folder / f"{number}.tsv" for number in range(len(files))]
    for path, rows in zip(paths, files, strict=True):
        path.write_text("a\tb\n" + "".join(f"{a}\t{b}\n" for a, b in rows))
    whole, _ = read_tables(paths, folder, columns=("a", "b"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(delimited, "PART_BYTES", 1)
        parts, _ = read_tables(paths, folder, columns=("a", "b"))
    pd.testing.assert_frame_equal(parts, whole)
