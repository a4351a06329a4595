"""Several tables and folders are one table; what could not be read is named and counted."""

import io
import sys
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from slipscale import commands
from slipscale.analysis.load import load
from slipscale.analysis.reading.foreign.names import people_in_names
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.faults import UserError

pytestmark = pytest.mark.usefixtures("without_models")

ROWS = pd.DataFrame({"level": [1, 2, 4, 8] * 3, "loud": [2.0, 4.5, 7.0, 12.5] * 3})


def mapping(pattern="", table=None, **columns):
    columns = {"stimulus": "level", "response": "loud"} | columns
    shape = {} if pattern is None else {"participant_from_name": pattern}
    return parse_mapping({"columns": columns, "shape": shape, "table": table or {}}, "here")


def folder(tmp_path, count=4):
    for number in range(count):
        ROWS.assign(loud=ROWS["loud"] + number).to_csv(tmp_path / f"p{number}.csv", index=False)
    return tmp_path


@pytest.mark.parametrize(
    "names, labels",
    [
        (["s1.csv", "s10.csv"], ["s1", "s10"]),
        (
            ["s01_detect_2026-03-01_10h12.05.123", "s02_detect_2026-03-02_11h13.05.9"],
            ["s01", "s02"],
        ),
        (["01_x_2026_Mar_01_1012", "02_x_2026_Mar_02_1013"], ["01", "02"]),
        (["subject-1.csv", "subject-2.csv"], ["subject-1", "subject-2"]),
        (["a/data.csv", "b/data.csv"], ["a", "b"]),
        (["run_anna_2.csv", "run_bert_2.csv", "run_anna_2.tsv"], ["anna", "bert", "anna"]),
    ],
)
def test_the_participant_is_the_part_of_the_names_that_differs(names, labels):
    assert people_in_names([Path(name) for name in names], "") == labels


def test_two_parts_that_differ_need_a_pattern():
    paths = [Path(f"p{who}_{ses}.csv") for who in "12" for ses in "ab"]
    with pytest.raises(UserError, match="more than one part of the file names differs"):
        people_in_names(paths, "")
    assert people_in_names(paths, "(p[0-9])_") == ["p1", "p1", "p2", "p2"]
    with pytest.raises(UserError, match=r"p1_a.csv: the name does not match"):
        people_in_names(paths, "(q)")
    with pytest.raises(UserError, match="pattern with one group"):
        mapping("p[0-9]")


def test_a_damaged_file_is_named_and_left_out(tmp_path, capsys):
    folder(tmp_path)
    (tmp_path / "p2.csv").write_text('level,"loud\n1,2\n')
    (tmp_path / "p3.csv").write_text("level\n1\n")
    data = load(tmp_path, mapping())
    assert data.people == {"p0", "p1"}
    assert data.left_out == ("p2.csv", "p3.csv")
    first, second = data.problems
    assert first.startswith("left out: ")
    assert "p2.csv: line 1, the header, has an unmatched" in first
    assert "p3.csv: no column loud" in second
    words = ["--participant-from-name", "--stimulus", "level", "--response", "loud", "--json"]
    out = ["--out", str(tmp_path / "out")]
    assert commands.main(["analyse", str(tmp_path), *words, *out]) == 1
    assert "p2.csv" in capsys.readouterr().err
    (tmp_path / "p2.csv").unlink()
    (tmp_path / "p3.csv").unlink()
    assert commands.main(["analyse", str(tmp_path), *words, *out]) == 0


def test_a_file_named_twice_is_rejected_and_a_copy_is_noted(tmp_path, capsys):
    folder(tmp_path, 3)
    first, copy = tmp_path / "p0.csv", tmp_path / "p3.csv"
    words = ["--participant-from-name", "--stimulus", "level", "--response", "loud"]
    assert commands.main(["analyse", str(first), str(first), *words]) == 2
    assert "p0.csv: this file is named twice" in capsys.readouterr().err
    copy.write_bytes(first.read_bytes())
    (note,) = [each for each in load(tmp_path, mapping()).problems if "content" in each]
    assert note.startswith("p3.csv has the same content as p0.csv")


def test_a_folder_without_a_readable_table_says_why(tmp_path):
    folder(tmp_path)
    with pytest.raises(UserError, match=r"p0.csv: no column loudness; found level, loud"):
        load(tmp_path, mapping(response="loudness"))


@pytest.mark.parametrize("in_names", [True, False])
def test_labels_that_differ_in_zeros_are_not_silently_two_people(tmp_path, in_names):
    """Of one file they are refused; labels from several files have no file in common."""

    def read(*people):
        folder = tmp_path / "_".join(people)
        folder.mkdir()
        for place, who in enumerate(people):
            frame = pd.DataFrame({"level": [1, 2, 4], "rating": [1, 5, 9]})
            if not in_names:
                frame["who"] = who
            frame.to_csv(folder / (f"{who}.csv" if in_names else f"{place}.csv"), index=False)
        own = {"participant_from_name": ""} if in_names else {"participant": "who"}
        return load(folder, stimulus="level", response="rating", **own)

    with pytest.raises(UserError, match="'01' and '1' represent the same number"):
        read("01", "1", "2")
    data = read("s01", "s1")
    assert data.people == {"s01", "s1"}
    (note,) = [each for each in data.problems if "same number" in each]
    assert note.startswith("all files, column")
    assert not [each for each in read("a", "b").problems if "column" in each]


def test_unfinished_and_empty_runs_are_counted(tmp_path):
    folder(tmp_path)
    ROWS.head(5).to_csv(tmp_path / "p4.csv", index=False)
    ROWS.head(0).to_csv(tmp_path / "p5.csv", index=False)
    data = load(tmp_path, mapping())
    assert data.people == {"p0", "p1", "p2", "p3", "p4"}
    assert data.problems == (
        "1 of 6 files have no rows: p5.csv",
        "1 of 6 files have fewer rows than the usual 12 and may be unfinished runs: p4.csv (5)",
    )


def test_the_most_frequent_ending_of_a_folder_is_read(tmp_path):
    folder(tmp_path, 3)
    (tmp_path / "notes.txt").write_text("seen 3 people\n")
    (tmp_path / "p0.log").write_text("started")
    results = tmp_path / "derivatives" / "slipscale"
    results.mkdir(parents=True)
    (results / "table3.csv").write_text("a\n1\n")
    data = load(tmp_path, mapping())
    assert [source.name for source in data.sources] == ["p0.csv", "p1.csv", "p2.csv"]
    assert "only the 3 files with the ending .csv are read, not 1 other tables" in data.problems[0]


def test_files_without_a_participant_need_an_option(tmp_path):
    paths = sorted(folder(tmp_path).glob("*.csv"))
    with pytest.raises(
        UserError, match=r"no option names the participants.*--participant-from-name"
    ):
        load(paths, mapping(None))
    assert load(paths, mapping()).people == {"p0", "p1", "p2", "p3"}
    assert load(paths[:1], mapping(None)).people == {"p0"}
    with pytest.raises(UserError, match="several tables need options"):
        load(paths)


def test_standard_input_is_a_table(tmp_path, monkeypatch):
    content = ROWS.assign(who=list("abc") * 4).to_csv(index=False).encode()
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(content)))
    data = load("-", mapping(None, participant="who"))
    assert data.people == {"a", "b", "c"}
    assert len(data.estimates) == 12


def test_rows_of_a_questionnaire_are_people(tmp_path):
    frame = pd.DataFrame({"r1": [1, 2, 3], "r2": [2, 4, 6], "r4": [4, 8, 13]})
    frame.to_csv(tmp_path / "wide.csv", index=False)
    found = parse_mapping({"levels": {"r1": 1, "r2": 2, "r4": 4}}, "here")
    data = load(tmp_path / "wide.csv", found)
    assert data.people == {"row 1", "row 2", "row 3"}
    assert "each row is analysed as one" in data.problems[0]


PLAIN = ROWS.assign(who=list("abc") * 4)


@pytest.mark.parametrize(
    "content, columns",
    [
        # PsyToolkit: cells separated by blanks, without a header.
        (
            "\n".join(f"{who}  {level} {loud} " for level, loud, who in PLAIN.to_numpy()),
            {"participant": "1", "stimulus": "2", "response": "3"},
        ),
        # R's write.table: quoted names, and row numbers without a name.
        (
            '"level" "loud" "who"\n'
            + "\n".join(
                f'"{place}" {level} {loud} "{who}"'
                for place, (level, loud, who) in enumerate(PLAIN.to_numpy(), start=1)
            ),
            {"participant": "who"},
        ),
        # Gorilla: the last line.
        (PLAIN.to_csv(index=False) + "END OF FILE\n", {"participant": "who"}),
        (PLAIN.to_csv(index=False) + "END OF FILE,,\n", {"participant": "who"}),
    ],
)
def test_text_of_other_programs_is_read(tmp_path, content, columns):
    (tmp_path / "data.txt").write_text(content)
    shape = {} if "who" in columns.values() else {"header": False}
    named = {"stimulus": "level", "response": "loud"} | columns
    data = load(tmp_path / "data.txt", parse_mapping({"columns": named, "shape": shape}, "here"))
    assert data.people == {"a", "b", "c"}
    assert sorted(data.estimates["estimate"]) == sorted(PLAIN["loud"])
    assert data.problems == ()
