"""Records of any shape, with their checksums and hashes recomputed: told by entry and line."""

from dataclasses import replace

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.journal.reading import read_whole
from slipscale.experiments.journal.record import Record, decode, encode, sealed
from slipscale.experiments.journal.record_shapes import checked
from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock


@pytest.fixture(scope="module")
def folder(tmp_path_factory, record_runs):
    return record_runs(tmp_path_factory.mktemp("fuzz"), "01")


@pytest.fixture(scope="module")
def records(folder):
    path = folder / "sourcedata/sub-01/sub-01_run-01_journal.jsonl"
    return [decode(line)[0] for line in path.read_bytes().splitlines(keepends=True)]


def test_every_record_that_a_session_writes_has_its_shape(folder):
    records = read_whole(folder / "sourcedata/sub-01/sub-01_run-01_journal.jsonl").records
    kept, damage = checked(records)
    assert damage == []
    assert kept == records


@pytest.mark.parametrize(
    "kind, data, reason",
    [
        ("begin", {}, "step: is missing"),
        ("begin", {"step": 0, "what": {"type": "Jump", "trial": None}}, "unknown step 'Jump'"),
        ("done", {"step": 0, "answer": {"type": "Reply", "value": [1]}}, "value"),
        ("done", {"step": 0, "answer": {"type": "Reply", "mood": 1}}, "Reply has no 'mood'"),
        ("void", {"task": "a", "trial": "1", "reason": ""}, "trial: expected a whole number"),
    ],
)
def test_a_wrong_shape_is_named_by_its_entry(records, kind, data, reason):
    wrong = Record(number=1, time_s=0.0, kind=kind, data=data)
    _, damage = checked([records[0], wrong])
    assert reason in damage[0].reason


def test_a_record_of_another_version_names_that_version(tmp_path, records):
    header = replace(records[0], hash="", data={**records[0].data, "software": {"slipscale": "9"}})
    written, first = sealed(header, "")
    newer = Record(number=1, time_s=0.0, kind="begin", data={"step": 0, "what": {"type": "Jump"}})
    path = tmp_path / "sub-01_run-01_journal.jsonl"
    path.write_bytes(first + sealed(newer, written.hash)[1])
    with pytest.raises(UserError, match=r"line 2: not a record of this .* version 9, which began"):
        read_plan(path)


@pytest.mark.parametrize("time_s", [1e308, -1e308, float("nan")])
def test_a_time_that_no_session_has_is_named(records, time_s):
    """The plate's twin, gone on with there, would be computed at that time."""
    _, damage = checked([records[0], replace(records[1], time_s=time_s)])
    assert damage[0].line == 2
    assert "expected the time since the run began" in damage[0].reason


def test_a_number_that_no_float_can_hold_is_damage_of_its_line(records):
    """It would be written into a table as a number."""
    line = encode(replace(records[1], hash="", data={"step": 10**400, "what": {}}))
    with pytest.raises(ValueError, match="a number has more than 300 digits"):
        decode(line)


@pytest.mark.parametrize(
    "kinds, line",
    [("hBBe", 3), ("hDe", 2), ("hBDeB", 5), ("hhe", 2)],
    ids=[
        "begins twice with another number",
        "done unbegun",
        "goes on after its end",
        "two headers",
    ],
)
def test_steps_out_of_order_are_named(records, kinds, line):
    header, begin, done, end = records[0], records[1], records[2], records[-1]
    made = []
    for number, letter in enumerate(kinds):
        record = {"h": header, "B": begin, "D": done, "e": end}[letter]
        data = dict(record.data)
        if letter == "B" and number == 2:
            data["step"] = 5
        made.append(Record(number=number, time_s=0.0, kind=record.kind, data=data))
    _, damage = checked(made)
    assert damage[0].line == line


def test_a_session_may_write_kinds_that_this_version_does_not_know(tmp_path, records):
    path = tmp_path / "sourcedata/sub-01/sub-01_run-01_journal.jsonl"
    with Journal.create(path, VirtualClock()) as new:
        for record in records:
            new.write(record.kind, **record.data)
            if record.number == 5:
                new.write("typed", text="4")
    assert build_dataset(tmp_path) == []
