"""The same answers in the forms of files that people have give the same table."""

import bz2
import gzip
import io
import json
import lzma
import zipfile

import openpyxl
import pandas as pd
import pytest

from slipscale.analysis.load import load
from slipscale.analysis.reading.foreign.proposal import described
from slipscale.faults import UserError

GIVEN = {"participant": "who", "stimulus": "level", "answer": "correct", "alternatives": 2}
ROWS = [
    (who, level, turn % 2) for who in ("p1", "p2") for level in (1, 2.5, 4) for turn in range(4)
]
FRAME = pd.DataFrame(ROWS, columns=["who", "level", "correct"])
CSV = FRAME.to_csv(index=False)
MARKDOWN = "| who | level | correct |\n|:---|---:|---:|\n" + "".join(
    f"| {who} | {level} | {answer} |\n" for who, level, answer in ROWS
)


def lines(**options):
    return FRAME.to_json(**options).encode()


def zipped(**files):
    stored = io.BytesIO()
    with zipfile.ZipFile(stored, "w") as archive:
        for name, text in files.items():
            archive.writestr(f"{name}.csv", text)
    return stored.getvalue()


FORMS = {
    "lines.jsonl": lines(orient="records", lines=True),
    "lines.ndjson": lines(orient="records", lines=True),
    "columns.json": lines(),
    "index.json": lines(orient="index"),
    "split.json": lines(orient="split"),
    "table.json": lines(orient="table"),
    "lists.json": json.dumps(FRAME.to_dict("list")).encode(),
    "pipe.txt": FRAME.to_csv(index=False, sep="|").encode(),
    "markdown.md": MARKDOWN.encode(),
    "german.csv": FRAME.to_csv(index=False, sep=";", decimal=",").encode("utf-8-sig"),
    "low_first.csv": CSV.encode("utf-16-le"),
    "high_first.csv": CSV.encode("utf-16-be"),
    "marked_32.csv": CSV.encode("utf-32"),
    "s.csv.gz": gzip.compress(CSV.encode()),
    "s.csv.bz2": bz2.compress(CSV.encode()),
    "s.csv.xz": lzma.compress(CSV.encode()),
    "s.zip": zipped(s=CSV),
    "ending_left_out.csv": gzip.compress(CSV.encode()),
    "row_names.csv": (
        '"who","level","correct"\n'
        + "".join(
            f'"r{n}","{who}",{level},{answer}\n' for n, (who, level, answer) in enumerate(ROWS)
        )
    ).encode(),
    "row_numbers.csv": (
        "who,level,correct\n" + FRAME.set_index(FRAME.index + 1).to_csv(header=False)
    ).encode(),
}
#: Lines above the header, and what the note says about them.
ABOVE = {
    "hash": ("# by the laboratory, 2019\n# version 3\n" + CSV, "lines 1 and 2: above the header"),
    "percent": ("% by the laboratory\n" + CSV, "line 1: above the header"),
    "title": ("Loudness of tones\n\n" + CSV, "line 1: above the header"),
    "padded": ("Loudness,,\n,,\n" + CSV, "line 1: above the header"),
    "several": ("Study: loudness\nDay: Monday, 10 June\n" + CSV, "lines 1 and 2: above the header"),
    "end": (CSV + "# end of the run\n", "line 26: a comment; skipped"),
}


def read(folder, name, content):
    path = folder / name
    path.write_bytes(content)
    return load(path, **GIVEN)


def answers(data):
    rows = data.trials["forced_choices"]
    return rows[["participant_id", "track_level", "correct"]].astype(str).to_numpy().tolist()


EXPECTED = [[who, str(float(level)), str(bool(answer))] for who, level, answer in ROWS]


@pytest.mark.parametrize("name", FORMS)
def test_a_form_gives_the_answers_of_the_table(tmp_path, name):
    assert answers(read(tmp_path, name, FORMS[name])) == EXPECTED
    assert dict(described([tmp_path / name]).given)["participant"] == "who"


def test_a_stata_file_gives_the_answers_of_the_table(tmp_path):
    FRAME.to_stata(tmp_path / "data.dta", write_index=False)
    assert answers(load(tmp_path / "data.dta", **GIVEN)) == EXPECTED


@pytest.mark.parametrize("name", ABOVE)
def test_lines_above_the_header_are_skipped_and_counted(tmp_path, name):
    text, note = ABOVE[name]
    data = read(tmp_path, "data.csv", text.encode())
    assert answers(data) == EXPECTED
    (problem,) = data.problems
    assert note in problem


def test_a_header_that_numpy_wrote_as_a_comment_is_the_header(tmp_path):
    for text in (CSV, FRAME.assign(who=FRAME["who"].str[1:]).to_csv(index=False, sep=" ")):
        assert len(read(tmp_path, "data.csv", f"# {text}".encode())) == len(ROWS)


def test_a_first_column_that_is_called_by_a_hash_is_no_comment(tmp_path):
    text = FRAME.rename_axis("#").to_csv()
    assert answers(read(tmp_path, "data.csv", text.encode())) == EXPECTED


def test_the_participant_in_the_name_of_a_compressed_file_has_no_ending(tmp_path):
    for who in ("s1", "s2"):
        (tmp_path / f"{who}.csv.gz").write_bytes(gzip.compress(b"level,correct\n1,0\n2,1\n"))
    given = GIVEN | {"participant": None, "participant_from_name": ""}
    assert load(tmp_path, **given).people == {"s1", "s2"}


#: Content of a file that cannot be read, and the way that is named, keyed by file name. Compressed
#: files contain the time, so they must not be part of the name of a test.
REFUSED = {
    "two.zip": (zipped(a=CSV, b=CSV), "contains a.csv, b.csv; expected one table"),
    "cut.csv.gz": (FORMS["s.csv.gz"][:-9], "cannot be unpacked"),
    "x.ods": (b"PK", 'pandas.read_excel("x.ods", engine="odf")'),
    "x.rds": (gzip.compress(b"RDX3"), 'readRDS("x.rds")'),
    "x.parquet": (b"PAR1", 'pandas.read_parquet("x.parquet")'),
    "x.jasp": (b"PK", "export the data from JASP as CSV"),
    "rows.json": (b"[[1, 2], [3, 4]]", "orient='records'"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_is_refused_with_the_way(tmp_path, name):
    content, message = REFUSED[name]
    with pytest.raises(UserError) as caught:
        read(tmp_path, name, content)
    assert message in str(caught.value)


def workbook(folder, change, above=()):
    book = openpyxl.Workbook()
    for row in [*above, FRAME.columns.tolist(), *ROWS]:
        book.active.append(row)
    change(book.active)
    book.save(folder / "data.xlsx")
    return folder / "data.xlsx"


def only_first(sheet):
    """Leave the participant only in the first row of each block."""
    for row in range(2, 2 + len(ROWS)):
        if (row - 2) % 12:
            sheet.cell(row, 1).value = None


def merge(sheet):
    sheet.merge_cells("A2:A13")
    sheet.merge_cells("B14:B17")


def test_a_workbook_with_a_title_and_merged_blocks_gives_the_answers(tmp_path):
    def titled(sheet):
        sheet.merge_cells("A1:C1")
        sheet.merge_cells("A3:A14")

    assert answers(load(workbook(tmp_path, merge), **GIVEN)) == EXPECTED
    assert answers(load(workbook(tmp_path, titled, above=[["Loudness"]]), **GIVEN)) == EXPECTED


def test_an_identifier_in_the_first_row_of_each_block_is_repeated_and_counted(tmp_path):
    text = "\n".join(
        line if number in (0, 1, 13) else line[line.index(",") :]
        for number, line in enumerate(CSV.splitlines())
    )
    for data in (
        load(workbook(tmp_path, only_first), **GIVEN),
        read(tmp_path, "d.csv", text.encode()),
    ):
        assert answers(data) == EXPECTED
        assert "who is only in the first row of each block, so the 22 rows" in data.problems[0]


def test_missing_identifiers_are_not_repeated(tmp_path):
    text = CSV.replace("p1,4.0", ",4.0")
    data = read(tmp_path, "data.csv", text.encode())
    assert (len(data), "there is no who" in data.problems[0]) == (20, True)


def test_levels_in_the_first_row_of_each_block_are_refused(tmp_path):
    text = "who,level,correct\n" + "p1,1,0\np1,,1\np1,,1\np1,2,1\np1,,0\np1,,1\n"
    with pytest.raises(UserError, match="4 of 6 answers have no level"):
        read(tmp_path, "data.csv", text.encode())


def test_formulas_without_values_are_refused_if_their_column_is_read(tmp_path):
    def in_column(column):
        return lambda sheet: setattr(sheet.cell(3, column), "value", "=1+1")

    with pytest.raises(UserError, match="cell B3 in column level contains a formula"):
        load(workbook(tmp_path, in_column(2)), **GIVEN)
    assert len(load(workbook(tmp_path, in_column(5)), **GIVEN)) == len(ROWS)


@pytest.mark.parametrize("cell", ["{:.1f}%", "{:.0f} %", "{:.1f}"])
def test_percentages_may_have_a_percent_sign(tmp_path, cell):
    (tmp_path / "data.csv").write_text(
        "who,level,pc,n\n" + "".join(f"a,{k},{cell.format(50 + 10 * k)},20\n" for k in range(1, 4))
    )
    data = load(tmp_path / "data.csv", participant="who", stimulus="level", percent="pc", n="n")
    felt = data.differences["difference_felt"]
    assert (len(felt), felt.sum()) == (60, 12 + 14 + 16)


def test_proportions_are_not_percentages(tmp_path):
    (tmp_path / "data.csv").write_text("who,level,pc,n\na,1,0.2,20\na,2,0.4,20\na,3,0.45,20\n")
    with pytest.raises(UserError, match=r"largest percentage is 0\.45, so these are probably"):
        load(tmp_path / "data.csv", participant="who", stimulus="level", percent="pc", n="n")


def test_a_comma_at_the_end_of_each_row_is_no_row_name(tmp_path):
    text = "who,level,correct\n" + "".join(f"{','.join(map(str, row))},\n" for row in ROWS)
    with pytest.raises(UserError, match="line 2 has 4 cells, expected 3"):
        read(tmp_path, "data.csv", text.encode())


@pytest.mark.parametrize("name", ["line", "file"])
def test_a_column_with_a_reserved_name_is_refused_if_it_is_read(tmp_path, name):
    text = FRAME.assign(**{name: 7}).to_csv(index=False).encode()
    assert answers(read(tmp_path, "data.csv", text)) == EXPECTED
    with pytest.raises(UserError, match=f"called {name}"):
        load(tmp_path / "data.csv", **GIVEN | {"stimulus": name})


@pytest.mark.parametrize(
    "cell",
    [
        '<c r="B2"><v>NaN</v></c>',
        '<c r="B2" t="s"><v>99999</v></c>',
        '<c r="ZZZZZZ2"><v>1</v></c>',
        "<c/>" * 300_000,
    ],
    ids=["NaN", "no such text", "no such column", "a row of 300,000 cells"],
)
@pytest.mark.parametrize("row", [3, 999_999_999])
def test_a_sheet_that_excel_cannot_hold_is_refused(tmp_path, cell, row):
    book = workbook(tmp_path, lambda _: None)
    changed = tmp_path / "changed.xlsx"
    with zipfile.ZipFile(book) as old, zipfile.ZipFile(changed, "w") as new:
        for part in old.namelist():
            text = old.read(part)
            if part == "xl/worksheets/sheet1.xml":
                more = f'<row r="{row}">{cell}</row></sheetData>'.encode()
                text = text.replace(b"</sheetData>", more)
            new.writestr(part, text)
    with pytest.raises(UserError, match=r"not a readable Excel workbook|larger than Excel's own"):
        load(changed, **GIVEN)


def test_merged_cells_that_hide_other_values_are_refused(tmp_path):
    def hide(sheet):
        merge(sheet)
        sheet._cells[(3, 1)] = openpyxl.cell.Cell(sheet, 3, 1, "another")

    book = workbook(tmp_path, hide)
    with pytest.raises(
        UserError, match="the merged cells A2:A13 hide other values, first in row 3"
    ):
        load(book, **GIVEN)
