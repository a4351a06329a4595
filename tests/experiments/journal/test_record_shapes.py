"""Records of any shape, with their checksums and hashes recomputed: read, or told in a sentence."""

import json
import os

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from experiments.dataset.bids import build_dataset
from experiments.dataset.rendering import render
from experiments.dataset.runs import read_runs
from experiments.journal.journal import Journal
from experiments.journal.record import Record, chained, decode, encode
from experiments.journal.record_shapes import checked
from experiments.journal.run_record import read_plan
from faults import UserError
from hardware.clock import VirtualClock

VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3)
    ),
    max_leaves=6,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory, record_runs):
    return record_runs(tmp_path_factory.mktemp("fuzz"), "01")


class Recorded:
    """A journal's path and records; it prints short, for Hypothesis."""

    def __init__(self, path):
        self.path = path
        lines = path.read_bytes().splitlines(keepends=True)
        self.records = [decode(line)[0] for line in lines]


@pytest.fixture(scope="module")
def journal(folder):
    return Recorded(folder / "sourcedata/sub-01/sub-01_run-01_journal.jsonl")


def places(value, path=()):
    """Yield the path of every entry in nested plain data."""
    inner = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value)
        if isinstance(value, list)
        else ()
    )
    for key, each in inner:
        yield (*path, key)
        yield from places(each, (*path, key))


def changed(data, path, how, value):
    data = json.loads(json.dumps(data))
    *way, last = path
    target = data
    for key in way:
        target = target[key]
    if how == "remove":
        del target[last]
    elif how == "rename" and isinstance(target, dict):
        target["x" + str(last)] = target.pop(last)
    else:
        target[last] = value
    return data


@settings(
    max_examples=int(os.environ.get("SLIPSCALE_FUZZ", "200")),  # more in a campaign
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    which=st.integers(0, 10**6),
    entry=st.integers(0, 10**6),
    how=st.sampled_from(["set", "remove", "rename", "kind"]),
    kind=st.sampled_from(
        ["begin", "done", "void", "end", "header", "resume", "answered_again", "unfinished"]
    ),
    value=VALUES,
)
def test_no_record_with_mended_hashes_ends_in_anything_but_a_sentence(
    folder, journal, *, which, entry, how, kind, value
):
    path, records = journal.path, journal.records
    victim = records[which % len(records)]
    entries = list(places(victim.data))
    new = victim.data
    if how != "kind" and entries:
        kind = victim.kind
        new = changed(victim.data, entries[entry % len(entries)], how, value)
    lines, before = [], ""
    mutant = Record(number=victim.number, time_s=victim.time_s, kind=kind, data=new)
    for record in records:
        made = chained(mutant if record is victim else record, before)
        before = made.hash
        lines.append(encode(made))
    path.write_bytes(b"".join(lines))
    runs, problems = read_runs(folder)
    files, unfit = render(runs)
    assert files or problems or unfit
    try:
        plan, kept = read_plan(path)
        from experiments.session.session import _past  # noqa: PLC0415

        assert _past(kept) is not None
        plan.tasks()
    except UserError:
        pass


def test_every_record_that_a_session_writes_has_its_shape(journal):
    records = journal.records
    kept, damage = checked(records)
    assert damage == []
    assert kept == records


@pytest.mark.parametrize(
    "kind, data, reason",
    [
        ("begin", {}, "step: field required"),
        ("begin", {"step": 0, "what": {"type": "Jump", "trial": None}}, "no step is called 'Jump'"),
        ("done", {"step": 0, "answer": {"type": "Reply", "value": [1]}}, "value"),
        ("done", {"step": 0, "answer": {"type": "Reply", "mood": 1}}, "Reply has no 'mood'"),
        ("void", {"task": "a", "trial": "1", "reason": ""}, "trial: input should be a valid int"),
    ],
)
def test_a_wrong_shape_is_named_by_its_entry(journal, kind, data, reason):
    records = journal.records
    wrong = Record(number=1, time_s=0.0, kind=kind, data=data)
    _, damage = checked([records[0], wrong])
    assert reason in damage[0].reason


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
def test_steps_out_of_order_are_named(journal, kinds, line):
    records = journal.records
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


def test_a_session_may_write_kinds_that_this_version_does_not_know(tmp_path, journal):
    records = journal.records
    path = tmp_path / "sourcedata/sub-01/sub-01_run-01_journal.jsonl"
    with Journal.create(path, VirtualClock()) as new:
        for record in records:
            new.write(record.kind, **record.data)
            if record.number == 5:
                new.write("typed", text="4")
    assert build_dataset(tmp_path) == []
