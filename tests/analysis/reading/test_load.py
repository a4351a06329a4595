"""Reading data sets: what is kept, what is left out, and what is said about it."""

import shutil

import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.delimited import read_tables
from slipscale.analysis.tasks.difference.verbal_coding import SHIPPED
from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
from slipscale.faults import UserError

pytestmark = pytest.mark.usefixtures("without_models")

TIDY = "participant_id,amplitude_um_pp,estimate\n"


def test_practice_and_voided_trials_are_counted_and_not_analysed(dataset):
    rows = dataset.default_estimates(1)
    rows[0] |= {"phase": "practice"}
    rows[1] |= {"flag": "paused;voided"}
    rows[2] |= {"estimate": "n/a", "flag": "timed_out"}
    data = load(dataset(rows={"01": rows}))
    assert data.counts["practice"] == 1
    assert data.counts["voided"] == 1
    assert data.counts["timed_out"] == data.counts["unanswered"] == 1
    assert data.counts["analysed"] == len(data.estimates) == 6 * 8 - 3
    assert len(data.answers) == 6 * 8 - 2


def test_the_sidecars_say_whose_data_with_which_seeds(dataset):
    data = load(dataset(participants=2, mode="pilot"))
    assert data.mode == "pilot"
    assert data.details["seed"] == ("1", "2")
    assert data.details["software"] == ("slipscale 0.1.0",)
    assert data.name == "A test study"


def test_pilot_and_participant_records_do_not_mix(dataset):
    folder = dataset(participants=2, mode={"01": "pilot", "02": "participant"})
    with pytest.raises(UserError, match=r"mixed \('participant' in sub-02.*'pilot' in sub-01"):
        load(folder)


def test_bulk_reading_gives_what_pandas_gives_file_by_file(dataset):
    folder = dataset(participants=5)
    paths = sorted(folder.glob("sub-*/beh/*_beh.tsv"))
    # A quoted cell takes the other road.
    text = paths[2].read_text().replace("n/a\n", '"a ""b"""\n', 1)
    paths[2].write_text(text)
    ours, _ = read_tables(paths, folder)
    theirs = pd.concat(
        [pd.read_csv(p, sep="\t", na_values=["n/a"]) for p in paths], ignore_index=True
    )
    assert [paths[i] for i in ours["file"].unique()] == paths
    for column in ("trial", "amplitude_um_pp", "estimate", "scale_top"):
        pd.testing.assert_series_equal(ours[column], theirs[column], check_dtype=False)
    assert list(ours["line"][:8]) == list(range(2, 10))


def test_text_in_a_number_column_is_named_by_file_line_and_column(dataset):
    rows = dataset.default_estimates(3)
    rows[4] |= {"estimate": "forty"}
    rows[5] |= {"estimate": -3}
    data = load(dataset(rows={"03": rows}))
    text, negative = data.problems
    assert "sub-03_task-magnitudeestimation_run-01_beh.tsv, line 6, column estimate" in text
    assert "'forty' instead of a number" in text
    assert "line 7" in negative
    assert "0 or more" in negative
    assert data.counts["unanswered"] == 2


def test_a_doubled_trial_is_kept_once_and_named(dataset):
    rows = dataset.default_estimates(1)
    rows.append(rows[3] | {"estimate": 99})
    data = load(dataset(rows={"01": rows}))
    assert any("line 10: trial 4 of sub-01 occurs twice" in p for p in data.problems)
    assert 99 not in set(data.estimates["estimate"])


def test_a_truncated_file_is_refused_with_its_line(dataset):
    folder = dataset(participants=2)
    path = folder / "sub-02/beh/sub-02_task-magnitudeestimation_run-01_beh.tsv"
    path.write_text(path.read_text()[:-25])
    with pytest.raises(UserError, match=r"sub-02.*line 9 has \d+ cells, expected 15.*truncated"):
        load(folder)


@pytest.mark.parametrize(
    "content, message",
    [
        (b"", "the file is empty"),
        (TIDY.encode() + b"1,0,caf\x81\n", "line 2 is not UTF-8"),
        (TIDY.encode() + b"1,0,\x00\n", "line 2 contains a null byte"),
        (b"subject,amplitude,rating\n1,0,3\n", "no column participant_id, amplitude_um_pp"),
        (TIDY.encode() + b"1,0\n", "line 2 has 2 cells, expected 3"),
    ],
)
def test_foreign_files_are_refused_in_a_sentence(tmp_path, content, message):
    path = tmp_path / "x.csv"
    path.write_bytes(content)
    with pytest.raises(UserError, match=message):
        load(path)


def test_an_empty_folder_says_what_was_expected(tmp_path):
    with pytest.raises(UserError, match="no data found; expected files like sub-01/beh"):
        load(tmp_path)


def test_psychopy_s_csv_reads_mark_trailing_comma_and_all(table_by_hand):
    path = table_by_hand(
        "participant_id,amplitude_um_pp,estimate,\n01,0,10,\n01,0.5,,\n", encoding="utf-8-sig"
    )
    data = load(path)
    assert list(data.estimates["participant_id"].astype(str)) == ["01"]
    assert data.counts["unanswered"] == 1
    assert "Unnamed: 3" not in data.answers


def test_excel_s_semicolons_and_decimal_commas_read(table_by_hand):
    path = table_by_hand("participant_id;amplitude_um_pp;estimate\na;0,5;12,25\n")
    assert list(load(path).estimates[["level", "estimate"]].iloc[0]) == [0.5, 12.25]


def test_unknown_analysis_keys_in_the_study_are_all_named(dataset):
    folder = dataset(choices='normalisation = "best"\nzero_rul = "exclude"')
    with pytest.raises(UserError, match=r"normalisation.*zero_rul"):
        load(folder)


def test_frozen_choices_are_read(dataset):
    data = load(dataset(choices='normalisation = "top_stimulus"\nexclusions = ["constant"]'))
    assert data.frozen == ("exclusions", "normalisation")
    assert data.choices.normalisation == "top_stimulus"


def test_choices_count_as_frozen_only_in_the_file_that_the_sessions_ran_with(dataset, page):
    folder = dataset(choices='normalisation = "scale_top"')
    assert load(folder).unchanged
    assert "before data collection" in page(analyse(folder))
    study = folder / "code" / "study.toml"
    text = study.read_bytes()
    study.write_bytes(text.replace(b"\n", b"\r\n"))
    assert load(folder).unchanged
    study.write_bytes(text + b'zero_rule = "half_minimum"\n')
    edited = analyse(folder)
    assert edited.dataset.unchanged is False
    assert any("not the study file of the sessions" in p for p in edited.problems)
    assert "before data collection" not in page(edited)


def test_every_file_that_results_depend_on_is_hashed(dataset):
    folder = dataset(choices='codebook = "code/codebook.toml"')
    shutil.copy(SHIPPED, folder / "code" / "codebook.toml")
    codes = folder / "code" / "verbal_codes.tsv"
    codes.write_text("verbal_report\tcoder\tcategory\n", encoding="utf-8")
    names = {source.name for source in load(folder).sources}
    assert names >= {
        "code/study.toml",
        "code/codebook.toml",
        "code/verbal_codes.tsv",
        "dataset_description.json",
    }


def test_the_digest_depends_on_content_and_not_on_the_folder(dataset, tmp_path):
    folder = dataset()
    before = load(folder).sha256
    folder.rename(tmp_path / "elsewhere")
    assert load(tmp_path / "elsewhere").sha256 == before
    path = next((tmp_path / "elsewhere").glob("sub-01/beh/*_beh.tsv"))
    path.write_text(path.read_text().replace("2.0", "2.1", 1))
    assert load(tmp_path / "elsewhere").sha256 != before


@settings(max_examples=60, deadline=None)
@given(st.binary(max_size=200))
def test_any_bytes_read_or_are_refused_in_a_sentence(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("any") / "any.csv"
    path.write_bytes(TIDY.encode() + content)
    try:
        load(path)
    except UserError as error:
        assert str(path) in str(error)  # noqa: PT017 - whether it raises is not the point


@pytest.fixture(scope="module")
def piloted(tmp_path_factory):
    """A data set as a pilot leaves it: journals and tables."""
    folder = tmp_path_factory.mktemp("pilot") / "data"
    plans = pilot_plans("biet2007", participants=2, seed=1, language=None)
    run_pilot(folder, plans, tell=lambda _: None)
    return folder


def test_journals_without_tables_and_rows_edited_by_hand_are_named(piloted, tmp_path):
    folder = shutil.copytree(piloted, tmp_path / "data")
    assert not [each for each in load(folder).problems if "journal" in each]
    shutil.rmtree(folder / "sub-02")
    (table,) = folder.glob("sub-01/beh/*magnitude*_beh.tsv")
    table.write_text(table.read_text().replace("\tmain\t", "\tpractice\t", 1))
    problems = load(folder).problems
    assert (  # row 1 is the header, rows 2 to 5 are practice
        f"{table.relative_to(folder).as_posix()}: row 6: phase is 'practice'; "
        "the journal has 'main'"
    ) in problems
    assert sum("sub-02" in each and "data build writes it" in each for each in problems) == 6


def test_a_damaged_trial_is_left_out_and_its_journal_named(piloted, tmp_path):
    folder = shutil.copytree(piloted, tmp_path / "data")
    whole = load(folder)
    (journal,) = folder.glob("sourcedata/sub-01/*.jsonl")
    lines = journal.read_bytes().splitlines(keepends=True)
    place = max(i for i, line in enumerate(lines) if b'"name":"estimate"' in line) + 1
    lines[place] = lines[place].replace(b'"Reply"', b'"Rep1y"')
    journal.write_bytes(b"".join(lines))
    # The table still has the answer: building leaves it, and says so.
    assert any("the table was left unchanged" in each.what for each in build_dataset(folder))
    kept = load(folder)
    assert kept.counts["analysed"] == whole.counts["analysed"]
    assert any(f"line {place + 1}: damaged" in each for each in kept.problems)
    assert any("estimate is" in each and "the journal has 'n/a'" in each for each in kept.problems)
    # Without the table the answer is lost.
    for table in folder.glob("sub-01/beh/*magnitudeestimation*_beh.tsv"):
        table.unlink()
    build_dataset(folder)
    data = load(folder)
    assert data.counts["analysed"] == whole.counts["analysed"] - 1
    assert any(f"line {place + 1}: damaged" in each for each in data.problems)


def test_journals_with_no_table_at_all_say_how_to_make_them(piloted, tmp_path):
    shutil.copytree(piloted / "sourcedata", tmp_path / "data" / "sourcedata")
    with pytest.raises(UserError, match="no tables; to create them, run slipscale data build"):
        load(tmp_path / "data")


def test_rows_that_cannot_be_read_are_named_before_sidecars_that_do_not_exist(dataset):
    rows = [row | {"estimate": -1} for row in dataset.default_estimates(1)[:3]]
    folder = dataset(participants=1, rows={"01": rows})
    for path in folder.glob("sub-*/beh/*.json"):
        path.unlink()
    assert "this sidecar does not exist" in load(folder).problems[-1]
    with pytest.raises(UserError, match=r"nothing to analyse .*line 2, column estimate: '-1'"):
        analyse(load(folder))
