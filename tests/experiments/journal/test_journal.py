import json
import multiprocessing
import os
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.journal.journal import Journal, Record, decode, encode, read_records
from faults import UserError
from hardware.clock import VirtualClock

VALUES = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text()
VALUES = VALUES.filter(lambda value: value not in (float("inf"), float("-inf")))
KEYS = st.text(st.characters(codec="utf-8"), min_size=1).filter(
    lambda key: key not in ("n", "t", "kind", "crc")
)


def written(path: Path, *kinds: str) -> Path:
    with Journal.create(path, VirtualClock()) as journal:
        for kind in kinds:
            journal.write(kind, format=1, words='it said "less" — glissé\n')
    return path


@given(st.dictionaries(KEYS, VALUES), st.integers(0, 10**6))
def test_what_is_encoded_comes_back(data, number):
    record = Record(number=number, time_s=1.5, kind="done", data=data)
    line = encode(record)
    assert decode(line, number) == record
    assert line.count(b"\n") == 1
    json.loads(line)  # one object of plain JSON a line: other programs can read it


@given(st.data())
def test_any_changed_byte_is_noticed(data):
    line = encode(Record(number=3, time_s=0.25, kind="done", data={"value": "42.5"}))
    place = data.draw(st.integers(0, len(line) - 1))
    byte = data.draw(st.integers(0, 255).filter(lambda value: value != line[place]))
    with pytest.raises((ValueError, KeyError)):
        decode(line[:place] + bytes([byte]) + line[place + 1 :], 3)


def test_a_journal_cut_at_any_byte_keeps_every_whole_record(tmp_path):
    whole = written(tmp_path / "a.jsonl", "header", "begin", "done").read_bytes()
    ends = [place + 1 for place, byte in enumerate(whole) if byte == ord("\n")]
    cut = tmp_path / "cut.jsonl"
    for length in range(len(whole) + 1):
        cut.write_bytes(whole[:length])
        records, kept = read_records(cut)
        assert len(records) == sum(end <= length for end in ends)
        assert kept == max([end for end in ends if end <= length], default=0)


def test_reopening_cuts_the_torn_line_and_goes_on(tmp_path):
    path = written(tmp_path / "a.jsonl", "header", "done")
    whole = path.read_bytes()
    path.write_bytes(whole + b'{"n":2,"t":0.1,"ki')
    with Journal.reopen(path, VirtualClock(7.0)) as journal:
        assert [record.kind for record in journal.records] == ["header", "done"]
        journal.write("resume")
    assert [record.kind for record in read_records(path)[0]] == ["header", "done", "resume"]
    assert path.read_bytes().startswith(whole)


def test_damage_in_the_middle_is_refused_with_its_line(tmp_path):
    path = written(tmp_path / "a.jsonl", "header", "begin", "done")
    path.write_bytes(path.read_bytes().replace(b'"begin"', b'"bogus"'))
    with pytest.raises(UserError, match=r"a\.jsonl, line 2: damaged"):
        read_records(path)


@pytest.mark.parametrize(
    "order, line", [((0, 2, 1, 3), 2), ((0, 1, 1, 2), 3), ((0, 2, 3), 2), ((1, 2, 3), 1)]
)
def test_lines_in_another_order_missing_or_repeated_are_refused(tmp_path, order, line):
    """Each line is whole by itself; only its number tells that it does not stand in its place."""
    path = written(tmp_path / "a.jsonl", "header", "begin", "done", "end")
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[place] for place in order))
    with pytest.raises(UserError, match=rf"line {line}: .*expected record {line - 1}\)"):
        read_records(path)


def test_a_foreign_file_is_refused(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("hello\nworld\n")
    with pytest.raises(UserError, match="line 1: damaged or not a journal"):
        read_records(path)


def test_an_existing_run_is_never_overwritten_and_is_named(tmp_path):
    path = written(tmp_path / "a.jsonl", "header")
    before = path.read_bytes()
    with pytest.raises(UserError, match=str(path)):
        Journal.create(path, VirtualClock())
    assert path.read_bytes() == before


def test_a_file_that_died_before_its_first_record_can_be_used(tmp_path):
    path = tmp_path / "a.jsonl"
    path.write_bytes(b'{"n":0,"t"')
    with Journal.create(path, VirtualClock()) as journal:
        journal.write("header", format=1)
    assert len(read_records(path)[0]) == 1


def _try_to_write(path, answer):
    try:
        Journal.reopen(Path(path), VirtualClock())
    except UserError as error:
        answer.put(str(error))


def test_a_second_writer_is_refused(tmp_path):
    path = tmp_path / "a.jsonl"
    context = multiprocessing.get_context("spawn")
    answer = context.Queue()
    with Journal.create(path, VirtualClock()) as journal:
        journal.write("header", format=1)
        other = context.Process(target=_try_to_write, args=(str(path), answer))
        other.start()
        assert "another session is writing it" in answer.get(timeout=60)
        other.join()


@pytest.mark.skipif(os.name == "nt", reason="/dev/full is a Unix device")
def test_a_full_disk_is_one_sentence_and_leaves_the_journal_whole(tmp_path, monkeypatch):
    path = tmp_path / "a.jsonl"
    with Journal.create(path, VirtualClock()) as journal:
        journal.write("header", format=1)

        def full(_descriptor):
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(os, "fsync", full)
        with pytest.raises(UserError, match="No space left on device"):
            journal.write("done", value=1)
    assert [record.kind for record in read_records(path)[0]] == ["header"]


@pytest.mark.skipif(sys.platform == "win32", reason="limits of a file's size are Unix'")
def test_a_full_disk_is_one_sentence_and_costs_only_the_line_that_had_no_room(tmp_path):
    import resource  # noqa: PLC0415  Unix only

    path = tmp_path / "a.jsonl"
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    with Journal.create(path, VirtualClock()) as journal:
        journal.write("header", format=1)
        whole = path.read_bytes()
        resource.setrlimit(resource.RLIMIT_FSIZE, (len(whole) + 40, hard))
        try:
            for _ in range(2):
                with pytest.raises(UserError, match="cannot write"):
                    journal.write("done", value="x" * 100)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        assert path.read_bytes() == whole
        journal.write("done", value="x" * 100)
    assert [record.kind for record in read_records(path)[0]] == ["header", "done"]


def test_a_journal_that_never_began_leaves_no_file(tmp_path):
    path = tmp_path / "sub-01" / "a.jsonl"
    Journal.create(path, VirtualClock()).close()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("reached", [0, 10, None], ids=["nothing", "a part", "all"])
@pytest.mark.parametrize("times", [1, 2])
def test_a_signal_while_writing_leaves_a_journal_that_can_be_read(
    tmp_path, monkeypatch, reached, times
):
    """A Ctrl-C most often finds the session waiting for the disk; "stop" is written after it."""
    path = written(tmp_path / "a.jsonl", "header", "begin")
    with Journal.reopen(path, VirtualClock()) as journal:
        whole = os.fsync

        def interrupted(descriptor):
            whole(descriptor)
            if reached is not None:
                os.ftruncate(descriptor, before + reached)
            raise KeyboardInterrupt

        monkeypatch.setattr(os, "fsync", interrupted)
        for _ in range(times):
            before = path.stat().st_size
            with pytest.raises(KeyboardInterrupt):
                journal.write("done", value=7)
        monkeypatch.setattr(os, "fsync", whole)
        journal.write("stop")
        kept = [record.kind for record in journal.records]
    assert kept == [record.kind for record in read_records(path)[0]]
    # An answer that reached the disk is kept.
    assert kept == ["header", "begin", *["done"] * (times if reached is None else 0), "stop"]
