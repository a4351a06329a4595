"""Data of other laboratories: any quantity, any names, long and wide, Excel, SPSS, BIDS."""

import zipfile

import numpy as np
import openpyxl
import pandas as pd
import pyreadstat
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import savemat

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.meaning.mapping import beside, parse_mapping, write_mapping
from slipscale.analysis.reading.meaning.units import factor
from slipscale.analysis.tasks.difference.yes_no import step_sizes
from slipscale.faults import UserError

pytestmark = pytest.mark.usefixtures("without_models")

LEVELS = (20.0, 200.0, 2000.0, 20_000.0)


def mapping(**changed):
    columns = {"participant": "subject", "stimulus": "sound_pressure", "response": "loudness"}
    rest = {
        key: changed.pop(key) for key in ("stimulus_words", "levels", "table") if key in changed
    }
    columns = {k: v for k, v in (columns | changed).items() if v}
    table = {"columns": columns, "stimulus": rest.get("stimulus_words", {"unit": "µPa"})}
    return parse_mapping(table | {k: rest[k] for k in ("levels", "table") if k in rest}, "here")


def rows(people="abc", levels=LEVELS):
    return [
        {"subject": who, "sound_pressure": level, "loudness": (n + 1) * level**0.6}
        for n, who in enumerate(people)
        for level in levels
    ]


def written(tmp_path, kind, frame):
    path = tmp_path / f"data.{kind}"
    if kind == "csv":
        frame.to_csv(path, index=False)
    elif kind == "tsv":
        frame.to_csv(path, index=False, sep="\t", decimal=",")
    elif kind == "xlsx":
        frame.to_excel(path, index=False)
    elif kind == "mat":
        savemat(path, {"T": {name: frame[name].to_numpy() for name in frame}})
    elif kind == "json":
        path.write_text(frame.to_json(orient="records"))
    else:
        pyreadstat.write_sav(frame, str(path))
    return path


@pytest.mark.parametrize("kind", ["csv", "tsv", "xlsx", "sav"])
def test_one_table_reads_alike_from_every_kind_of_file(tmp_path, kind):
    data = load(written(tmp_path, kind, pd.DataFrame(rows())), mapping())
    expected = [row["loudness"] for row in rows()]
    assert list(data.estimates["estimate"]) == pytest.approx(expected)
    assert sorted(set(data.estimates["level"])) == list(LEVELS)
    assert data.people == {"a", "b", "c"}
    assert (data.quantity.name, data.quantity.unit) == ("sound pressure", "µPa")
    assert data.quantity.value(20) == "20 µPa"
    assert data.problems == ()


@pytest.mark.parametrize("kind", ["csv", "tsv", "xlsx", "sav"])
def test_a_wide_table_reads_as_the_long_one(tmp_path, kind):
    wide = pd.DataFrame(rows()).pivot_table("loudness", "subject", "sound_pressure").reset_index()
    wide = wide.rename(columns={level: f"p{level:.0f}" for level in LEVELS})
    levels = {f"p{level:.0f}": level for level in LEVELS}
    found = mapping(stimulus="", response="", levels=levels, stimulus_words={"name": "pressure"})
    data = load(written(tmp_path, kind, wide), found)
    assert list(data.estimates["estimate"]) == pytest.approx([row["loudness"] for row in rows()])
    assert data.quantity.name == "pressure"


@pytest.mark.parametrize("decimal", [None, ","])
@pytest.mark.parametrize("kind", ["xlsx", "sav", "mat", "json"])
def test_numbers_that_a_program_stored_have_one_reading(tmp_path, kind, decimal):
    """As text, 1.125 next to 3 could be 1125, and with decimal commas it was."""
    values = [3.0, 1.125, 4.375, 9.0]
    frame = pd.DataFrame(rows("abc", (1, 2, 4, 8))).assign(loudness=values * 3)
    table = {"decimal": decimal} if decimal else {}
    data = load(written(tmp_path, kind, frame), mapping(table=table))
    assert list(data.estimates["estimate"]) == values * 3
    assert sorted(set(data.estimates["level"])) == [1, 2, 4, 8]


def test_text_in_a_workbook_says_nothing_of_its_numbers(tmp_path):
    frame = pd.DataFrame(rows(levels=(1.125, 2.25, 4, 8)))
    frame["loudness"] = [f"{value:.1f}".replace(".", ",") for value in frame["loudness"]]
    data = load(written(tmp_path, "xlsx", frame), mapping())
    assert sorted(set(data.estimates["level"])) == [1.125, 2.25, 4, 8]
    assert data.estimates["estimate"].iloc[0] == 1.1


def test_a_point_in_text_next_to_whole_numbers_stays_ambiguous(tmp_path):
    frame = pd.DataFrame(rows()).assign(loudness=[540, 540, "1.080", 540] * 3)
    with pytest.raises(UserError, match=r"'1\.080' could be 1080 or 1\.080"):
        load(written(tmp_path, "xlsx", frame), mapping())


@pytest.mark.parametrize("factor", [1e-9, 1e-6, 1.0, 1e6])
def test_levels_stay_apart_whatever_the_unit(tmp_path, factor):
    """In metres all amplitudes were 0; in Pa they merged."""
    levels = [factor * level for level in (0.1 + 0.2, 0.3, 0.5, 1.2)]
    path = written(tmp_path, "csv", pd.DataFrame(rows(levels=levels)))
    assert load(path, mapping()).estimates["level"].nunique() == 3


def test_metres_in_a_column_of_micrometres_are_refused(table_by_hand):
    path = table_by_hand("participant_id,amplitude_um_pp,estimate\na,0.0000012,3\na,0,1\n")
    with pytest.raises(UserError, match=r"1.2e-06 µm is less than.*for another unit, name it"):
        load(path)


def test_a_missing_column_is_answered_with_the_nearest_name(tmp_path):
    path = written(tmp_path, "csv", pd.DataFrame(rows()))
    with pytest.raises(UserError, match=r"no column loudnes;.*Nearest: loudness for loudnes"):
        load(path, mapping(response="loudnes"))


def test_psychopy_s_own_csv_reads(table_by_hand):
    text = (
        "subject,sound_pressure,loudness,trials.thisN,\n"
        "p1,,,,\np1,20,5,0,\np1,200,,1,\np1,2000,50,2,\n"
    )
    data = load(table_by_hand(text, encoding="utf-8-sig"), mapping())
    assert data.counts["unanswered"] == 1
    assert data.counts["analysed"] == 2
    assert data.problems == ("study.csv: 1 rows with neither stimulus nor response were skipped",)


def test_a_single_table_has_no_task(tmp_path, table_by_hand):
    path = written(tmp_path, "csv", pd.DataFrame(rows()))
    own = table_by_hand("participant_id,amplitude_um_pp,estimate\na,1,3\n")
    for table, found in ((path, mapping()), (own, None)):
        with pytest.raises(UserError, match=r"--task a: .* is a single table; expected a folder"):
            load(table, found, task="a")


def test_yes_and_no_read_as_one_table(table_by_hand):
    text = "subject,base,level,felt\na,2,1,yes\na,2,2,no\nb,2,1,Yes\nb,2,2,NO\n"
    found = mapping(stimulus="level", response="", answer="felt", reference="base")
    data = load(table_by_hand(text), found)
    assert list(data.differences["difference_felt"]) == [1, 0, 1, 0]
    assert list(data.differences["catch"]) == [False, True, False, True]
    alone = load(table_by_hand(text), mapping(stimulus="level", response="", answer="felt"))
    # A size is the stimulus less the reference, which without a column is none.
    assert set(alone.differences["level"]) == {0.0}
    assert list(step_sizes(alone.differences)) == [1, 2, 1, 2]
    assert list(step_sizes(data.differences)) == [-1, 0, -1, 0]


@pytest.mark.parametrize("unit", [1e-12, 1e-6, 1.0, 1e9])
def test_sizes_of_any_unit_are_told_apart_and_rounding_makes_none(table_by_hand, unit):
    """0.3 - 0.2 and 0.2 - 0.1 differ in floating point."""
    rows = [f"a,{unit * low!r},{unit * high!r},yes" for low, high in ((0.1, 0.2), (0.2, 0.3))]
    text = "\n".join(["subject,base,level,felt", *rows, f"a,{unit * 0.1!r},{unit * 0.1!r},no"])
    found = mapping(stimulus="level", response="", answer="felt", reference="base")
    steps = load(table_by_hand(text), found).differences
    assert sorted(set(step_sizes(steps))) == pytest.approx([0.0, 0.1 * unit], rel=1e-9)


def test_a_group_goes_with_its_participants(tmp_path):
    frame = pd.DataFrame(rows()).assign(age=["young"] * 8 + ["old"] * 4)
    data = load(written(tmp_path, "csv", frame), mapping(group="age"))
    assert data.participants.set_index("participant_id")["age"].to_dict() == {
        "a": "young",
        "b": "young",
        "c": "old",
    }
    assert data.problems == (
        "Group 'old' has only one participant, so its spread cannot be estimated.",
    )


def test_a_second_factor_within_participants_is_analysed_one_condition_at_a_time(tmp_path):
    frame = pd.concat(
        [pd.DataFrame(rows()).assign(ear=ear) for ear in ("left", "both")], ignore_index=True
    )
    path = written(tmp_path, "csv", frame)
    with pytest.raises(UserError, match=r"participant a has both and left in column ear.*--only"):
        load(path, mapping(group="ear"))
    assert len(load(path, mapping(table={"only": {"ear": "left"}})).estimates) == 12
    for wrong in ("right", ["left", "right"]):
        with pytest.raises(
            UserError, match="no row has 'right' in column ear; expected one of both, left"
        ):
            load(path, mapping(table={"only": {"ear": wrong}}))
    assert len(load(path, mapping(table={"only": {"ear": ["left", "both"]}})).estimates) == 24


def test_what_map_writes_is_what_load_reads(tmp_path):
    path = written(tmp_path, "csv", pd.DataFrame(rows()).assign(ear=["l", "r", "b"] * 4, sex="f"))
    found = mapping(table={"decimal": ".", "only": {"ear": ["l", "b"], "sex": "f"}})
    assert write_mapping(found, path).name == "analysis.toml"
    assert beside(path) == found
    assert load(path).quantity == found.quantity
    with pytest.raises(UserError, match="already exists with different content"):
        write_mapping(mapping(trial="n"), path)


@pytest.mark.parametrize(
    "table,words",
    [
        (
            {"columns": {"participant": "a"}},
            "needs --stimulus and --response .*found --participant",
        ),
        ({"columns": {"participant": "a", "stimulus": "a", "response": "b"}}, "a is used twice"),
        (
            {"columns": {"participant": "a", "stimulus": "s", "response": "b", "reference": "c"}},
            "estimates needs --stimulus and --response .*--reference",
        ),
        (
            {"columns": {"participant": "a", "response": "b"}, "levels": {"x": 1}},
            "wide table needs --levels.*found --participant, --response",
        ),
        (
            {"columns": {"participant": "a"}, "levels": {"x": 1, "y": 1}},
            "a different level for each",
        ),
        ({"columns": {"participant": "a"}, "levels": {"x": -1e200}}, "expected -1e\\+100 or more"),
        ({"column": {}}, "unknown key"),
    ],
)
def test_a_mapping_that_does_not_fit_says_why(table, words):
    with pytest.raises(UserError, match=words):
        parse_mapping(table, "here")


def test_a_level_below_nothing_is_refused(tmp_path):
    frame = pd.DataFrame(rows(levels=(-10.0, 0.0, 10.0)))
    with pytest.raises(UserError, match="sound pressure of -10 µPa; expected 0 or more"):
        load(written(tmp_path, "csv", frame), mapping())


def test_decibels_are_spoken_of(tmp_path):
    found = mapping(stimulus_words={"unit": "dB SPL"})
    (sentence,) = load(written(tmp_path, "csv", pd.DataFrame(rows())), found).problems
    assert "is already a logarithm" in sentence


def workbook(tmp_path, change, name="data.xlsx"):
    book = openpyxl.Workbook()
    sheet = book.active
    for row in [["subject", "sound_pressure", "loudness"], ["a", 20, 1], ["a", 200, 2]]:
        sheet.append(row)
    change(book)
    book.save(tmp_path / name)
    return tmp_path / name


@pytest.mark.parametrize(
    "change,name,words",
    [
        (lambda book: book.active.merge_cells("A2:B3"), "data.xlsx", "cells A2:B3 are merged"),
        (lambda book: book, "data.xlsm", "in the format .xlsm"),
        (lambda book: book.active.delete_rows(1, 3), "data.xlsx", "none with rows"),
    ],
)
def test_a_workbook_that_is_no_table_says_why(tmp_path, change, name, words):
    with pytest.raises(UserError, match=words):
        load(workbook(tmp_path, change, name), mapping())


def test_a_workbook_with_a_sheet_named_reads(tmp_path):
    def two(book):
        sheet = book.create_sheet("notes")
        sheet.append(["made by"])
        sheet.append(["me"])

    path = workbook(tmp_path, two)
    with pytest.raises(UserError, match=r"'Sheet', 'notes'.*--sheet"):
        load(path, mapping())
    assert len(load(path, mapping(table={"sheet": "Sheet"})).estimates) == 2


@pytest.mark.parametrize("suffix", ["xlsx", "sav", "jasp"])
@pytest.mark.parametrize("content", [b"", b"not one", b"PK\x03\x04" + bytes(40)])
def test_a_file_that_is_not_what_its_name_says_is_refused(tmp_path, suffix, content):
    path = tmp_path / f"data.{suffix}"
    path.write_bytes(content)
    with pytest.raises(UserError, match=f"data.{suffix}"):
        load(path, mapping())


def test_levels_are_told_in_another_prefix_of_their_unit(table_by_hand):
    text = "subject,level,loudness\n" + "".join(
        f"{who},{level},{level // 100 + 1}\n" for who in "abc" for level in (200, 2000)
    )
    words = {"stimulus": {"unit": "µPa", "in_unit": "mPa"}}
    columns = {"participant": "subject", "stimulus": "level", "response": "loudness"}
    data = load(table_by_hand(text), parse_mapping({"columns": columns, **words}, "x"))
    assert sorted(set(data.estimates["level"])) == [0.2, 2.0]
    assert data.quantity.unit == "mPa"
    assert data.quantity.column == "level_mPa"


@pytest.mark.parametrize("unit, wanted", [("µPa", "Hz"), ("dB", "Pa"), ("", "m"), ("°C", "K")])
def test_units_that_do_not_convert_are_one_sentence(unit, wanted):
    columns = {"participant": "who", "stimulus": "level", "response": "loudness"}
    table = {"columns": columns, "stimulus": {"unit": unit, "in_unit": wanted}}
    with pytest.raises(UserError, match=f"cannot be converted to {wanted}; expected the same unit"):
        parse_mapping(table, "x")


@given(
    st.sampled_from(["m", "Pa", "cd/m²", "Hz"]),
    st.sampled_from(["", "m", "µ", "k"]),
    st.sampled_from(["", "n", "M", "u"]),
)
def test_there_and_back_is_one(base, one, other):
    there, back = factor(one + base, other + base), factor(other + base, one + base)
    assert there * back == pytest.approx(1.0, rel=1e-12)


def test_a_weber_fraction_is_one_of_the_reference(table_by_hand):
    """Of one reference, 2, a fraction is half the difference: its slope is twice as steep."""
    rng = np.random.default_rng(1)
    rows = [
        f"{who},2,{level},{'yes' if rng.random() < 0.1 + 0.35 * (level - 2) else 'no'}"
        for who in "abcde"
        for level in (2, 3, 4)
        for _ in range(6)
    ]
    text = "\n".join(["subject,base,level,felt", *rows])
    found = mapping(stimulus="level", response="", answer="felt", reference="base")
    difference = analyse(load(table_by_hand(text), found)).inference.difference
    assert difference.weber.log_odds_per_unit == pytest.approx(
        2 * difference.psychometric.log_odds_per_unit, rel=1e-5
    )


def test_a_blank_cell_in_the_last_corner_of_a_sheet_makes_no_million_rows(tmp_path):
    def corner(book):
        book.active["XFD1048576"].value = " "

    (plain, used) = (
        workbook(tmp_path, change, name)
        for change, name in ((lambda _: None, "plain.xlsx"), (corner, "used.xlsx"))
    )
    whole, found = load(plain, mapping()).estimates, load(used, mapping()).estimates
    assert found.drop(columns="file").equals(whole.drop(columns="file"))


def test_a_range_merged_to_the_last_corner_is_refused_at_once(tmp_path):
    path = workbook(tmp_path, lambda _: None)
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(tmp_path / "m.xlsx", "w") as new:
        for part in old.namelist():
            text = old.read(part)
            merged = b'</sheetData><mergeCells><mergeCell ref="A2:XFD1048576"/></mergeCells>'
            new.writestr(part, text.replace(b"</sheetData>", merged))
    with pytest.raises(UserError, match="cells A2:XFD1048576 are merged"):
        load(tmp_path / "m.xlsx", mapping())


def test_a_sheet_of_too_many_cells_is_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr("slipscale.analysis.reading.programs.spreadsheets.MOST_CELLS", 5)
    with pytest.raises(UserError, match=r"sheet '.*': .* or more than 5 cells; expected"):
        load(workbook(tmp_path, lambda _: None), mapping())


@pytest.mark.parametrize("negative,refused", [(3, False), (4, True), (12, True)])
def test_answers_below_zero_are_not_left_out_as_if_they_were_typing_errors(
    tmp_path, negative, refused
):
    """On a scale from -50 to 50, the means of the positive answers were printed."""
    table = pd.DataFrame(rows())
    table.loc[table.index[:negative], "loudness"] *= -1
    path = written(tmp_path, "csv", table)
    if not refused:
        assert len(load(path, mapping()).estimates) == len(table) - negative
        return
    with pytest.raises(UserError, match=rf": {negative} of the \d+ numbers are below 0"):
        load(path, mapping())


@pytest.mark.parametrize("separator", [";", ",", "\t"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_a_first_line_for_excel_is_no_header(tmp_path, separator, mark):
    table = pd.DataFrame(rows()).to_csv(index=False, sep=separator)
    path = tmp_path / "data.csv"
    path.write_text(f"{mark}sep={separator}\n{table}", encoding="utf-8")
    plain = tmp_path / "plain.csv"
    plain.write_text(table, encoding="utf-8")
    found, whole = (load(each, mapping()).estimates for each in (path, plain))
    assert found["estimate"].equals(whole["estimate"])
    assert list(found["line"]) == list(whole["line"] + 1)
