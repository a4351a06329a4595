"""A data set and its journals: what was changed in either is found; damage costs its place."""

import csv
import json
import shutil

import pandas as pd
import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.journals import journals, read_runs
from slipscale.experiments.dataset.rendering import render
from slipscale.experiments.dataset.tsv import cell
from slipscale.experiments.dataset.verification import verify
from slipscale.experiments.journal.record import Record, decode, encode, sealed
from slipscale.experiments.study.file import study_text
from tests.fuzzing.recorded import record

TABLE = "sub-01/beh/sub-01_task-magnitudeestimation_run-01_beh.tsv"
JOURNAL = "sourcedata/sub-01/sub-01_run-01_journal.jsonl"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory, record_runs):
    """Two participants' runs and their tables, recorded once."""
    folder = record_runs(tmp_path_factory.mktemp("recorded"), "01", "02", mode="participant")
    build_dataset(folder)
    return folder


@pytest.fixture(scope="module")
def runs_of_all(tmp_path_factory):
    """A short run of every protocol, each in a data set of its own."""
    folder = tmp_path_factory.mktemp("protocols")
    return folder, record(folder)


@pytest.fixture
def dataset(recorded, tmp_path):
    return shutil.copytree(recorded, tmp_path / "data")


def lines_of(dataset):
    return (dataset / JOURNAL).read_bytes().splitlines(keepends=True)


def put(dataset, lines):
    (dataset / JOURNAL).write_bytes(b"".join(lines))


def told(problems):
    return [str(problem) for problem in problems]


def test_what_was_just_built_agrees_with_its_journals(dataset):
    assert verify(dataset) == []


def test_a_cell_edited_by_hand_is_named_by_file_and_row(dataset):
    table = dataset / TABLE
    rows = table.read_text(encoding="utf-8").split("\n")
    cells = rows[4].split("\t")
    was, cells[7] = cells[7], "99.5"
    rows[4] = "\t".join(cells)
    table.write_text("\n".join(rows), encoding="utf-8")
    assert told(verify(dataset)) == [f"{TABLE}: row 5: estimate is '99.5'; the journal has {was!r}"]


def test_rows_removed_and_rows_added_are_named(dataset):
    table = dataset / TABLE
    rows = table.read_text(encoding="utf-8").split("\n")
    table.write_text("\n".join(rows[:-2]) + "\n", encoding="utf-8")
    (problem,) = verify(dataset)
    assert (problem.file, problem.place) == (TABLE, f"row {len(rows) - 1}")
    assert problem.what.startswith("is missing")
    table.write_text("\n".join([*rows[:-1], rows[-2], ""]), encoding="utf-8")
    (problem,) = verify(dataset)
    assert problem.what.startswith("the row is not in the journal")


def test_a_row_removed_in_the_middle_is_one_difference(dataset):
    table = dataset / TABLE
    rows = table.read_text(encoding="utf-8").split("\n")
    table.write_text("\n".join(rows[:5] + rows[6:]), encoding="utf-8")
    (problem,) = verify(dataset)
    assert problem.place == "row 6"
    assert problem.what.startswith("is missing")


def test_a_participant_edited_and_a_table_without_journal_are_named(dataset):
    people = dataset / "participants.tsv"
    people.write_text(people.read_text().replace("\tyes", "\tno", 1))
    stray = dataset / TABLE.replace("01", "07").replace("run-07", "run-01")
    stray.parent.mkdir(parents=True)
    shutil.copy(dataset / TABLE, stray)
    assert told(verify(dataset)) == [
        "participants.tsv: row 2: complete is 'no'; the journal has 'yes'",
        f"{stray.relative_to(dataset).as_posix()}: is not in any journal",
    ]


def test_a_journal_without_tables_is_named_until_the_data_set_is_built(dataset):
    shutil.rmtree(dataset / "sub-02")
    assert {problem.file.split("_task")[0] for problem in verify(dataset)} == {"sub-02/beh/sub-02"}
    assert build_dataset(dataset) == []
    assert verify(dataset) == []


def test_a_sidecar_edited_is_named_by_its_entry(dataset):
    path = (dataset / TABLE).with_suffix(".json")
    path.write_text(path.read_text().replace('"seed": 2007', '"seed": 2008'))
    (problem,) = verify(dataset)
    assert problem.place == "seed"


def one_flipped_bit(lines, place):
    line = bytearray(lines[place])
    line[len(line) // 2] ^= 1
    return [*lines[:place], bytes(line), *lines[place + 1 :]]


def test_a_flipped_bit_anywhere_is_named_and_costs_no_more_than_the_trials_beside_it(
    dataset, places
):
    lines = lines_of(dataset)
    whole = pd.read_csv(dataset / TABLE, sep="\t", keep_default_na=False).set_index("trial")
    for place in places(lines):
        put(dataset, one_flipped_bit(lines, place))
        runs, problems = read_runs(dataset)
        assert problems
        assert problems[0].file == JOURNAL
        assert problems[0].place == f"line {place + 1}"
        assert len(runs) == 2
        trials = runs[0].gathered.trials
        damaged = [
            row.trial.number for rows in trials.values() for row in rows if "damaged" in row.flags
        ]
        assert len(damaged) <= 2
        for row in trials.get("magnitudeestimation", []):
            if "damaged" not in row.flags:
                assert row.answer("estimate") == float(whole["estimate"][row.trial.number])
    assert sum(map(len, trials.values())) == 12


@pytest.mark.parametrize("protocol", ["constant_stimuli", "paired_comparison", "matching"])
def test_a_flipped_bit_in_a_trial_of_several_intervals_blocks_nobody(runs_of_all, protocol, places):
    """Also where what was presented is lost, and the exploration of it is not."""
    folder, plans = runs_of_all
    dataset, path = folder / protocol, plans[protocol].journal_path(folder / protocol)
    lines = path.read_bytes().splitlines(keepends=True)
    try:
        for place in places(lines):
            path.write_bytes(b"".join(one_flipped_bit(lines, place)))
            (run,), problems = read_runs(dataset)
            assert problems[0].place == f"line {place + 1}"
            assert render([run])[1] == []
            rows = [row for rows in run.gathered.trials.values() for row in rows]
            assert sum("damaged" in row.flags for row in rows) <= 2
    finally:
        path.write_bytes(b"".join(lines))


@pytest.mark.parametrize("torn", [True, False], ids=["torn alone", "damaged, without tables"])
def test_a_header_that_nothing_replaces_blocks_nobody_else(dataset, torn):
    lines = lines_of(dataset)
    if not torn:
        shutil.rmtree(dataset / "sub-01")
    put(dataset, [lines[0][:30]] if torn else one_flipped_bit(lines, 0))
    problem, *tables, kept = build_dataset(dataset)
    assert problem.file == JOURNAL
    assert "the first record is" in problem.what
    assert [each.what for each in tables] == 2 * torn * [
        "the table is kept, but its journal is missing"
    ]
    assert (kept.file, kept.place) == ("participants.tsv", "sub-01")
    people = pd.read_csv(dataset / "participants.tsv", sep="\t")
    assert list(people["participant_id"]) == ["sub-01", "sub-02"]
    assert (dataset / TABLE).exists() == torn  # all that is left of that run


@pytest.mark.parametrize("lost", [1, 2], ids=["header", "the next too"])
def test_a_run_without_its_header_is_read_with_what_its_sidecar_says(dataset, lost):
    people = (dataset / "participants.tsv").read_bytes()
    tables = {path: path.read_bytes() for path in dataset.glob("sub-01/beh/*_beh.tsv")}
    lines = lines_of(dataset)
    put(dataset, one_flipped_bit(lines, 0) if lost == 1 else lines[lost:])
    problems = told(build_dataset(dataset))
    assert f"{JOURNAL}: line 1: the header's content was taken from the run's sidecar" in problems
    assert any("damaged" in problem for problem in problems)
    same = [path.read_bytes() == content for path, content in tables.items()]
    assert sum(same) == (2 if lost == 1 else 1)
    flagged = [path.read_text().count("\tdamaged") for path in tables]
    assert sorted(flagged) == ([0, 0] if lost == 1 else [0, 1])
    assert (dataset / "participants.tsv").read_bytes() == people
    notes = json.loads((dataset / TABLE).with_suffix(".json").read_text())["Slipscale"]
    assert any(line.startswith("line 1: ") for line in notes["damaged"])
    assert told(build_dataset(dataset)) == problems  # and again: nothing is worn away
    assert verify(dataset)


def test_a_study_file_that_was_edited_replaces_no_header(dataset):
    put(dataset, one_flipped_bit(lines_of(dataset), 0))
    study = dataset / "code" / "study.toml"
    study.write_text(study.read_text() + "# later\n")
    runs, problems = read_runs(dataset)
    assert len(runs) == 1
    assert "the first record is damaged" in told(problems)[0]


def test_one_word_changed_with_its_checksum_mended_is_found(dataset):
    lines = lines_of(dataset)
    place = next(i for i, line in enumerate(lines) if b'"value":' in line and i > 40)
    record, _ = decode(lines[place])
    data = json.loads(json.dumps(record.data))
    data["answer"]["value"] = 77.0
    changed = Record(
        number=record.number, time_s=record.time_s, kind="done", data=data, hash=record.hash
    )
    put(dataset, [*lines[:place], encode(changed), *lines[place + 1 :]])
    reason = "damaged: the hash does not match"
    assert f"{JOURNAL}: line {place + 1}: {reason}" in told(verify(dataset))[0]


def test_removed_moved_and_repeated_records_are_found(dataset):
    lines = lines_of(dataset)
    for tampered in (
        lines[:30] + lines[34:],
        lines[:30] + lines[32:34] + lines[30:32] + lines[34:],
        lines[:34] + lines[30:34] + lines[34:],
    ):
        put(dataset, tampered)
        assert any(problem.file == JOURNAL for problem in verify(dataset))


def test_a_line_copied_to_an_earlier_place_is_named_and_costs_no_trial(dataset):
    before = read_runs(dataset)[0][0].gathered
    lines = lines_of(dataset)
    put(dataset, [*lines[:30], lines[-20], *lines[30:]])
    runs, (problem,) = read_runs(dataset)
    assert problem.place == "line 31"
    assert runs[0].gathered == before


def test_a_cut_tail_is_found_and_building_keeps_the_tables(dataset):
    lines = lines_of(dataset)
    before = (dataset / TABLE).read_bytes()
    put(dataset, lines[:-10])
    expected = (
        f"{JOURNAL}: the end of the journal is missing: it has {len(lines) - 10} records, "
        f"but had {len(lines)} when its tables were made"
    )
    assert expected in told(verify(dataset))
    assert told(build_dataset(dataset)) == [expected]
    assert (dataset / TABLE).read_bytes() == before
    assert expected in told(verify(dataset))


@pytest.mark.parametrize(
    "file, column",
    [("participants.json", "mode"), ("task-magnitudeestimation_beh.json", "phase")],
)
def test_slipscales_own_words_can_change_between_versions_and_codes_cannot(dataset, file, column):
    path = dataset / file
    content = json.loads(path.read_text(encoding="utf-8"))
    levels = content[column]["Levels"]
    content[column]["Levels"] = dict.fromkeys(levels, "words of an earlier version")
    path.write_text(json.dumps(content), encoding="utf-8")
    assert verify(dataset) == []
    content[column]["Levels"] = {"other": "code"}
    path.write_text(json.dumps(content), encoding="utf-8")
    assert [each.place for each in verify(dataset)] == [f"{column}: Levels"]


@pytest.mark.parametrize(
    "file, was, changed, entry",
    [
        ("dataset_description.json", '"Name": "', '"Name": "My ', "Name"),
        ("task-magnitudeestimation_beh.json", '"Units": "s"', '"Units": "ms"', "Units"),
        ("participants.json", '"woman": "', '"woman": "never ', "Levels"),
    ],
)
def test_an_edited_description_is_named_by_its_entry(dataset, file, was, changed, entry):
    path = dataset / file
    text = path.read_text(encoding="utf-8")
    assert was in text
    path.write_text(text.replace(was, changed, 1), encoding="utf-8")
    (problem,) = verify(dataset)
    assert problem.file == file
    assert problem.place.endswith(entry)


def test_a_journal_forged_with_all_its_hashes_is_told_by_the_sidecar(dataset):
    lines = lines_of(dataset)
    before, forged = "", []
    for line in lines:
        record, _ = decode(line)
        if record.number > 60 and "value" in (record.data.get("answer") or {}):
            record.data["answer"]["value"] = 1.0
        made, sound = sealed(record, before)
        forged.append(sound)
        before = made.hash
    put(dataset, forged)
    assert "differ from the records from which the tables were made" in told(verify(dataset))[0]


def test_a_journal_under_another_participants_name_is_not_taken_for_hers(dataset):
    other = dataset / JOURNAL.replace("sub-01", "sub-03")
    other.parent.mkdir()
    shutil.copy(dataset / JOURNAL, other)
    (problem,) = build_dataset(dataset)
    assert "restore that name" in problem.what


def test_sidecars_tell_what_was_in_use_after_each_resume(laboratory, plan):
    person = plan(mode="participant")
    laboratory.run(person)
    path = person.journal_path(laboratory.folder)
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[:60]))
    laboratory.run(person, spec="mock:fault=lost@9")
    build_dataset(laboratory.folder)
    sidecar = (laboratory.folder / TABLE).with_suffix(".json")
    notes = json.loads(sidecar.read_text(encoding="utf-8"))["Slipscale"]
    (resume,) = notes["resumes"]
    assert resume["plate_spec"] == "mock:fault=lost@9"
    assert set(resume) == {
        *("time_s", "resumed_utc", "plate_spec", "plate", "masking_noise", "software"),
        *("texts_hash", "contact"),
    }
    assert notes["journal"]["records"] == len(path.read_bytes().splitlines())


def test_a_table_that_is_not_text_is_a_problem_of_its_file(dataset):
    (dataset / TABLE).write_bytes(b"\xff\xfe\x00")
    (problem,) = [each for each in verify(dataset) if each.file == TABLE]
    assert problem.what.startswith("cannot be read ('utf-8' codec")


def rows_of(path):
    return csv.DictReader(path.read_text(encoding="utf-8").splitlines(), delimiter="\t")


@pytest.mark.parametrize("intervals", [False, True])
def test_the_row_of_a_surface_that_was_presented_again_describes_what_was_rated(
    laboratory, plan, intervals
):
    plan = plan(study_text("detection_threshold"), study_name="two") if intervals else plan()
    laboratory.run(plan, spec="mock:fault=lost@read_back/40")
    build_dataset(laboratory.folder)
    (again, *_) = laboratory.records(plan, "represented")
    answer = again.data["answer"]
    prefix = f"interval{again.data['interval']}_" if intervals else ""
    readback = f"{prefix}readback_um_pp" if intervals else "amplitude_readback_um_pp"
    (row,) = [
        row
        for path in laboratory.folder.glob("sub-01/beh/*_beh.tsv")
        for row in rows_of(path)
        if "represented" in row["flag"]
    ]
    assert row[readback] == cell(answer["readback_level"])
    if intervals:
        assert row[f"{prefix}onset"] == cell(answer["onset_s"], "s")
    else:
        onsets = [
            event["onset"]
            for path in laboratory.folder.glob("sub-01/beh/*_events.tsv")
            for event in rows_of(path)
        ]
        assert onsets.count(cell(answer["onset_s"], "s")) == 1
    assert row[f"{prefix}exploration_time"] != "n/a"


@pytest.mark.parametrize("more", [b"", b"{}\n"])
def test_a_copy_beside_a_journal_is_named_with_what_it_holds(tmp_path, record_runs, more):
    folder = record_runs(tmp_path / "data", "01")
    build_dataset(folder)
    (journal,) = journals(folder)
    own = journal.read_bytes().count(b"\n")
    copy = journal.with_name(f"{journal.stem} (conflicted copy).jsonl")
    copy.write_bytes(journal.read_bytes() + more)
    (folder / "sub-01 (1)").mkdir()
    told = [str(each) for each in verify(folder)]
    assert len(told) == 2
    assert told[0].startswith("sub-01 (1): is not used; it seems to be a copy")
    assert f"({own + len(more) // 3} records here, {own} in the original)" in told[1]


@pytest.mark.parametrize(
    "name",
    [
        "old.jsonl",
        "sourcedata/sub-02/x.jsonl",
        "sourcedata/sub-01/sub-01_run-01_journal.jsonl.bak",
        "sourcedata/sub-01/sub-01_run-01_journal.jsonl~",
    ],
)
def test_records_of_a_session_in_another_file_are_named(tmp_path, record_runs, name):
    folder = record_runs(tmp_path / "data", "01")
    build_dataset(folder)
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).write_bytes(journals(folder)[0].read_bytes())
    (told,) = map(str, verify(folder))
    assert told.startswith(f"{name}: is not used")


@pytest.mark.parametrize("name", ["._sub-01_run-01_journal.jsonl", ".DS_Store"])
def test_hidden_files_of_macos_are_no_journals(tmp_path, record_runs, name):
    folder = record_runs(tmp_path / "data", "01")
    (folder / "sourcedata/sub-01" / name).write_bytes(b"\0\5\26\7\0\2")
    build_dataset(folder)
    assert verify(folder) == []
