import errno
import hashlib
import json
import multiprocessing
import os
import signal
import sys
import threading
import zlib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.experiments.journal import journal as module
from slipscale.experiments.journal import keeper
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.journal.locks import is_being_written
from slipscale.experiments.journal.reading import DAMAGED, has_begun, read_records, read_whole
from slipscale.experiments.journal.record import Record, decode, encode, sealed
from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock

VALUES = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text()
VALUES = VALUES.filter(lambda value: value not in (float("inf"), float("-inf")))
KEYS = st.text(st.characters(codec="utf-8"), min_size=1).filter(
    lambda key: key not in ("n", "t", "kind", "crc")
)


def written(path: Path, *kinds: str) -> Path:
    with Journal.create(path, VirtualClock()) as journal:
        for kind in kinds:
            journal.write(kind, format=2, words='it said "less" — glissé\n')
    return path


@given(st.dictionaries(KEYS, VALUES), st.integers(0, 10**6))
def test_what_is_encoded_comes_back(data, number):
    record = Record(number=number, time_s=1.5, kind="done", data=data)
    line = encode(record)
    assert decode(line)[0] == record
    assert line.count(b"\n") == 1
    json.loads(line)  # one object of plain JSON a line: other programs can read it


def test_a_line_is_compact_json_in_plain_letters_with_the_checksum_last():
    line = encode(
        Record(number=3, time_s=0.25, kind="done", data={"words": "glissé", "of": [1, 2]})
    )
    body = '{"n":3,"t":0.25,"kind":"done","words":"glissé","of":[1,2]'
    # Computed by zlib's crc32 of the object without its checksum.
    assert line.decode() == f'{body},"crc":"{zlib.crc32((body + "}").encode()):08x}"}}\n'


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_a_number_that_json_does_not_know_is_never_written(value):
    with pytest.raises(ValueError, match="JSON"):
        encode(Record(number=0, time_s=0.0, kind="done", data={"value": value}))


def test_data_may_hold_a_checksum_of_their_own():
    record = Record(number=0, time_s=0.0, kind="done", data={"a": {"b": 1, "crc": "0"}})
    assert decode(encode(record))[0] == record


@given(st.data())
def test_any_changed_byte_is_noticed(data):
    line = encode(Record(number=3, time_s=0.25, kind="done", data={"value": "42.5"}))
    place = data.draw(st.integers(0, len(line) - 1))
    byte = data.draw(st.integers(0, 255).filter(lambda value: value != line[place]))
    with pytest.raises((ValueError, KeyError)):
        decode(line[:place] + bytes([byte]) + line[place + 1 :])


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


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace(b"\n", b"\r\n"),
        lambda text: b"\xef\xbb\xbf" + text,
        lambda text: text + text.splitlines(keepends=True)[-1],
        lambda text: b"\xef\xbb\xbf" + text.replace(b"\n", b"\r\n"),
        lambda text: text + b"\n\r\n",
        lambda text: text.replace(b"\n", b"\n\n"),
        lambda text: b"\n" + text,
    ],
    ids=[
        *("CRLF", "byte order mark", "repeated last line", "both ends"),
        *("blank lines at the end", "a blank line after each", "a blank line before"),
    ],
)
def test_what_git_mail_and_editors_add_is_no_damage(tmp_path, change):
    path = written(tmp_path / "a.jsonl", "header", "begin", "done")
    whole = read_records(path)[0]
    path.write_bytes(change(path.read_bytes()))
    assert read_records(path)[0] == whole
    with Journal.reopen(path, VirtualClock(7.0)) as journal:
        journal.write("resume")
    assert [record.kind for record in read_records(path)[0]] == [
        *("header", "begin", "done", "resume")
    ]


def test_damage_in_the_middle_is_refused_with_its_line(tmp_path):
    path = written(tmp_path / "a.jsonl", "header", "begin", "done")
    path.write_bytes(path.read_bytes().replace(b'"begin"', b'"bogus"'))
    with pytest.raises(UserError, match=r"a\.jsonl, line 2: damaged"):
        read_records(path)


@pytest.mark.parametrize(
    "order, line, reason",
    [
        ((0, 2, 1, 3), 2, "record 2 is not in its original position"),
        ((0, 1, 1, 2), 3, "record 1 is also on line 2: repeated"),
        ((0, 2, 3), 2, "expected record 1, found 2: one or more were removed"),
        ((1, 2, 3), 1, "expected record 0, found 1: one or more were removed"),
    ],
)
def test_lines_in_another_order_missing_or_repeated_are_refused(tmp_path, order, line, reason):
    """Each line is whole by itself; only its number tells that it does not stand in its place."""
    path = written(tmp_path / "a.jsonl", "header", "begin", "done", "end")
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[place] for place in order))
    with pytest.raises(UserError, match=rf"line {line}: .*{reason}"):
        read_records(path)


@pytest.fixture(scope="module")
def long_journal(tmp_path_factory):
    path = written(tmp_path_factory.mktemp("long") / "a.jsonl", "header", *["note"] * 60)
    return path, path.read_bytes().splitlines(keepends=True), read_whole(path).records


@given(data=st.data())
def test_a_line_copied_or_moved_anywhere_costs_no_record(long_journal, data):
    path, lines, whole = long_journal
    line = data.draw(st.integers(0, 60), label="line")
    place = data.draw(st.integers(0, 61), label="place")
    copied = [*lines[:place], lines[line], *lines[place:]]
    if data.draw(st.booleans(), label="moved"):
        del copied[line + (place <= line)]
    path.write_bytes(b"".join(copied))
    reading = read_whole(path)
    assert reading.records == whole
    assert len(reading.damage) == (copied != lines)


def test_of_two_records_with_one_number_the_one_counts_that_its_neighbours_confirm(long_journal):
    """Another journal's line in place of ours, and ours elsewhere."""
    path, lines, whole = long_journal
    _, foreign = sealed(Record(number=30, time_s=1.0, kind="note", data={}), "0" * 32)
    path.write_bytes(b"".join([*lines[:30], foreign, *lines[31:], lines[30]]))
    reading = read_whole(path)
    assert reading.records == whole
    assert [each.line for each in reading.damage] == [31, 62]


def test_two_edited_lines_cost_two_records(long_journal):
    path, lines, whole = long_journal
    changed = [
        line.replace(b"glis", b"slip") if n in (20, 40) else line for n, line in enumerate(lines)
    ]
    path.write_bytes(b"".join(changed))
    reading = read_whole(path)
    assert [each.line for each in reading.damage] == [21, 41]
    assert [r.kind for r in reading.records].count(DAMAGED) == 2
    assert [r for r in reading.records if r.kind != DAMAGED] == [
        r for r in whole if r.number not in (20, 40)
    ]


@pytest.mark.parametrize("damaged", [b"{}\n", b'{"n":2,"crc":"00000000"}\n'])
def test_a_last_line_that_is_whole_but_wrong_is_refused_not_cut_off(tmp_path, damaged):
    path = written(tmp_path / "a.jsonl", "header", "begin")
    path.write_bytes(path.read_bytes() + damaged)
    with pytest.raises(UserError, match=r"line 3: damaged .*\(the checksum does not match\)"):
        read_records(path)


def test_a_foreign_file_is_refused(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("hello\nworld\n")
    with pytest.raises(UserError, match="line 1: damaged or not a journal") as refusal:
        read_records(path)
    assert str(refusal.value).endswith("expected one JSON record per line, as the session wrote it")


@pytest.mark.parametrize("kind, form", [("header", 3), ("header", 1), ("done", 2)])
def test_a_journal_of_another_form_is_refused(tmp_path, kind, form):
    path = tmp_path / "a.jsonl"
    path.write_bytes(encode(Record(number=0, time_s=0.0, kind=kind, data={"format": form})))
    with pytest.raises(UserError, match=rf"journal {path}: expected a Slipscale journal of format"):
        read_records(path)


@pytest.mark.parametrize("touch", [read_records, lambda path: Journal.reopen(path, None)])
def test_a_journal_that_is_not_there_is_named(tmp_path, touch):
    path = tmp_path / "a.jsonl"
    with pytest.raises(UserError, match=rf"journal {path}: No such file"):
        touch(path)


@pytest.mark.parametrize("place", ["file/a.jsonl", "file/sub-01/a.jsonl"])
def test_where_no_folder_can_be_made_the_journal_is_named(tmp_path, place):
    (tmp_path / "file").write_text("")
    path = tmp_path / place
    with pytest.raises(UserError, match=rf"journal {path}: "):
        Journal.create(path, None)
    assert not has_begun(path)


def test_where_nobody_may_look_the_journal_is_named(tmp_path):
    path = tmp_path / ("a" * 300)  # too long a name for any file system
    with pytest.raises(UserError, match=rf"journal {path}: "):
        has_begun(path)


def test_a_journal_has_begun_with_its_first_byte(tmp_path):
    path = tmp_path / "a.jsonl"
    assert not has_begun(path)
    path.write_bytes(b"")
    assert not has_begun(path)
    path.write_bytes(b"{")
    assert has_begun(path)


def test_a_journal_is_being_written_as_long_as_it_is_open(tmp_path):
    path = tmp_path / "a.jsonl"
    assert not is_being_written(path)
    with Journal.create(path, VirtualClock()) as journal:
        journal.write("header", format=2)
        assert is_being_written(path)
    assert not is_being_written(path)


def test_records_are_dated_by_the_clock_and_numbered_from_0(tmp_path):
    clock = VirtualClock()
    with Journal.create(tmp_path / "a.jsonl", clock) as journal:
        journal.write("header", format=2)
        clock.sleep(2.5)
        journal.write("done")
    records, _ = read_records(tmp_path / "a.jsonl")
    assert [(record.number, record.time_s) for record in records] == [(0, 0.0), (1, 2.5)]


def test_a_journal_is_read_again_only_where_a_record_was_not_finished(tmp_path, monkeypatch):
    """Else each record would cost as much as all before it."""
    readings = []
    monkeypatch.setattr(
        module, "read_records", lambda path: readings.append(1) or read_records(path)
    )
    with Journal.create(tmp_path / "a.jsonl", VirtualClock()) as journal:
        for _ in range(3):
            journal.write("header", format=2)
    with Journal.reopen(tmp_path / "a.jsonl", VirtualClock()) as journal:
        for _ in range(3):
            journal.write("done")
    assert readings == [1, 1]  # each when it was opened


@pytest.mark.skipif(os.name != "posix", reason="only there can a folder be synchronised")
def test_a_new_file_s_name_is_durable_before_the_first_record(tmp_path, monkeypatch):
    synchronised = []
    monkeypatch.setattr(os, "fsync", lambda file: synchronised.append(os.fstat(file).st_ino))
    with Journal.create(tmp_path / "a.jsonl", VirtualClock()):
        assert synchronised == [tmp_path.stat().st_ino]


def test_an_existing_run_is_never_overwritten_and_is_named(tmp_path):
    path = written(tmp_path / "a.jsonl", "header")
    before = path.read_bytes()
    with pytest.raises(UserError, match=rf"{path}; .*resume it: slipscale resume$"):
        Journal.create(path, VirtualClock())
    assert path.read_bytes() == before


def test_a_file_that_died_before_its_first_record_can_be_used(tmp_path):
    path = tmp_path / "a.jsonl"
    path.write_bytes(b'{"n":0,"t"')
    with Journal.create(path, VirtualClock()) as journal:
        journal.write("header", format=2)
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
        journal.write("header", format=2)
        other = context.Process(target=_try_to_write, args=(str(path), answer))
        other.start()
        assert "another session is writing to it" in answer.get(timeout=300)
        other.join()


@pytest.mark.skipif(os.name == "nt", reason="/dev/full is a Unix device")
def test_a_full_disk_is_one_sentence_and_leaves_the_journal_whole(tmp_path, monkeypatch):
    path = tmp_path / "a.jsonl"
    with Journal.create(path, VirtualClock()) as journal:
        journal.write("header", format=2)

        def full(_descriptor):
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(os, "fsync", full)
        with pytest.raises(UserError, match=r"No space left on device.*then slipscale resume$"):
            journal.write("done", value=1)
    assert [record.kind for record in read_records(path)[0]] == ["header"]


@pytest.mark.skipif(sys.platform == "win32", reason="limits of a file's size are Unix'")
def test_a_full_disk_is_one_sentence_and_costs_only_the_line_that_had_no_room(tmp_path):
    import resource

    path = tmp_path / "a.jsonl"
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    with Journal.create(path, VirtualClock()) as journal:
        journal.write("header", format=2)
        whole = path.read_bytes()
        resource.setrlimit(resource.RLIMIT_FSIZE, (len(whole) + 40, hard))
        try:
            for _ in range(2):
                with pytest.raises(UserError, match="cannot write"):  # a limit, not the disk
                    journal.write("done", value="x" * 100)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        assert path.read_bytes() == whole
        journal.write("done", value="x" * 100)
    assert [record.kind for record in read_records(path)[0]] == ["header", "done"]


@pytest.mark.parametrize(
    "code, remedy",
    [(errno.ENOSPC, "free some space"), (errno.EIO, "check the disk"), (errno.EROFS, "check the")],
)
def test_the_remedy_is_that_of_the_fault(tmp_path, monkeypatch, code, remedy):
    with Journal.create(tmp_path / "a.jsonl", VirtualClock()) as journal:
        journal.write("header", format=2)

        def fail(_line):
            raise OSError(code, os.strerror(code))

        monkeypatch.setattr(journal, "_put", fail)
        with pytest.raises(UserError, match=f"on disk: {remedy}.*, then slipscale resume"):
            journal.write("note")


@pytest.mark.parametrize("code", [errno.EIO, errno.EROFS])
def test_a_disk_that_is_gone_is_one_sentence_also_when_the_journal_is_closed(
    tmp_path, monkeypatch, code
):
    """Neither can the record be written then, nor what is half written be cut off."""
    journal = Journal.create(tmp_path / "a.jsonl", VirtualClock())
    journal.write("header", format=2)

    class Gone:
        closed = False
        tell, fileno, close = journal._stream.tell, journal._stream.fileno, journal._stream.close

        def write(self, _line):
            raise OSError(code, os.strerror(code))

        truncate = write

    monkeypatch.setattr(journal, "_stream", Gone())
    with pytest.raises(UserError, match=os.strerror(code)), journal:
        journal.write("note")


def test_a_journal_that_never_began_leaves_no_file(tmp_path):
    path = tmp_path / "sourcedata" / "sub-01" / "a.jsonl"
    Journal.create(path, VirtualClock()).close()
    assert list(tmp_path.rglob("*")) == [tmp_path / "sourcedata"]


def test_a_journal_that_never_began_leaves_others_as_they_were(tmp_path):
    other = written(tmp_path / "b.jsonl", "header")
    Journal.create(tmp_path / "a.jsonl", VirtualClock()).close()
    assert list(tmp_path.iterdir()) == [other]


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


def failing(code):
    def fail(_descriptor):
        raise OSError(code, os.strerror(code))

    return fail


def test_a_disk_that_fails_behind_an_appended_record_is_told_at_the_barrier(tmp_path, monkeypatch):
    """What it has not confirmed is cut off: a later record must not stand behind a gap."""
    path = tmp_path / "a.jsonl"
    with Journal.create(path, VirtualClock()) as journal:
        journal.write("header", format=2)
        monkeypatch.setattr(os, "fsync", failing(errno.EIO))
        journal.append("done", value=1)
        with pytest.raises(UserError, match="before the last are on disk: check the disk"):
            journal.wait_for(2)
        monkeypatch.undo()
        assert [record.kind for record in journal.records] == ["header"]
        journal.write("note")
    assert [record.kind for record in read_records(path)[0]] == ["header", "note"]


@pytest.mark.parametrize("told_by", ["append", "check", "close"])
def test_a_disk_that_failed_is_told_by_whatever_comes_next(tmp_path, monkeypatch, told_by):
    journal = Journal.create(tmp_path / "a.jsonl", VirtualClock())
    journal.write("header", format=2)
    monkeypatch.setattr(os, "fsync", failing(errno.ENOSPC))
    journal.append("done")
    journal._keeper._thread.join(timeout=300)
    words = ["done"] if told_by == "append" else []
    with pytest.raises(UserError, match="free some space"):
        getattr(journal, told_by)(*words)
    monkeypatch.undo()
    journal.close()
    assert [record.kind for record in read_records(journal.path)[0]] == ["header"]


def test_a_disk_that_hangs_is_not_waited_for_for_ever(tmp_path, monkeypatch):
    freed = threading.Event()
    with Journal.create(tmp_path / "a.jsonl", VirtualClock()) as journal:
        journal.write("header", format=2)
        monkeypatch.setattr(keeper, "PATIENCE_S", 0.05)
        monkeypatch.setattr(os, "fsync", lambda _descriptor: freed.wait(300))
        with pytest.raises(UserError, match=r"timed out.*check the disk"):
            journal.write("done")
        freed.set()


def test_a_signal_at_any_moment_of_a_wait_leaves_all_that_was_appended(tmp_path, monkeypatch):
    """The next barrier hands over again what the signal kept from the thread."""
    want = keeper.Keeper.want
    # A run in the background inherits an ignored SIGINT.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    monkeypatch.setattr(keeper.Keeper, "want", lambda *_: signal.raise_signal(signal.SIGINT))
    with Journal.create(tmp_path / "a.jsonl", VirtualClock()) as journal:
        with pytest.raises(KeyboardInterrupt):
            journal.append("header", format=2)
        signal.signal(signal.SIGINT, before)
        monkeypatch.setattr(keeper.Keeper, "want", want)
        journal.wait_for(1)
        assert journal._keeper.kept.records == 1


def on_its_way(tmp_path, *, kept_after):
    """Return a journal of which record 2 was not written by a disk that lost its power."""
    path = tmp_path / "a.jsonl"
    with Journal.create(path, VirtualClock()) as journal:
        journal.write("header", format=2)
        journal.append("begin", kept=1)
        journal.append("done")
        journal.append("begin", kept=kept_after)
        journal.append("done")
    lines = path.read_bytes().splitlines(keepends=True)
    lines[2] = bytes(len(lines[2]))
    path.write_bytes(b"".join(lines))
    return path


def test_what_follows_a_record_on_its_way_to_the_disk_is_a_torn_end(tmp_path):
    path = on_its_way(tmp_path, kept_after=2)
    with Journal.reopen(path, VirtualClock()) as journal:
        assert [record.kind for record in journal.records] == ["header", "begin"]
        journal.write("done")
    assert len(read_records(path)[0]) == 3


def test_a_record_that_was_on_disk_and_is_not_any_more_is_damage(tmp_path):
    path = on_its_way(tmp_path, kept_after=3)
    with pytest.raises(UserError, match="line 3: damaged"):
        read_records(path)


def test_each_hash_covers_all_records_before_it(tmp_path):
    """Computed here from the lines as they stand in the file."""
    path = written(tmp_path / "a.jsonl", "header", "begin", "done")
    before = ""
    for line in path.read_text(encoding="utf-8").splitlines():
        body, _, tail = line.rpartition(',"hash":"')
        before = hashlib.sha256(f"{before}\n{body}}}".encode()).hexdigest()[:32]
        assert tail.startswith(f'{before}"')


def test_a_reopened_journal_goes_on_with_the_chain(tmp_path):
    path = written(tmp_path / "a.jsonl", "header", "begin")
    with Journal.reopen(path, VirtualClock()) as journal:
        journal.write("done")
    assert len(read_records(path)[0]) == 3


@pytest.mark.parametrize("kept", ["the end", "the beginning"])
def test_a_sector_that_a_crashed_disk_did_not_write_is_a_torn_line(tmp_path, kept):
    path = written(tmp_path / "a.jsonl", "header", "begin")
    whole = path.read_bytes()
    last = encode(Record(number=2, time_s=0.0, kind="done", data={"words": "x" * 900}))
    zeros = bytes(512)
    torn = zeros + last[512:] if kept == "the end" else last[:512] + zeros
    path.write_bytes(whole + torn)
    assert read_records(path)[1] == len(whole)
    with Journal.reopen(path, VirtualClock()) as journal:
        journal.write("done")
    assert len(read_records(path)[0]) == 3
