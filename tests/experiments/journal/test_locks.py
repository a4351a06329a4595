import os
import socket

import portalocker
import pytest

from slipscale.experiments.journal import locks
from slipscale.experiments.journal.journal import Journal
from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock


@pytest.fixture
def path(tmp_path):
    with Journal.create(tmp_path / "a.jsonl", VirtualClock()) as journal:
        journal.write("header", format=2)
    return tmp_path / "a.jsonl"


@pytest.fixture
def no_locks(monkeypatch):
    """A file system without locks, as some network drives are."""

    def refuse(_stream, _flags):
        raise portalocker.LockException(OSError(95, "Operation not supported"))

    monkeypatch.setattr(portalocker, "lock", refuse)


def claim(path, host, process):
    locks.lock_file(path).write_text(f"{host}\n{process}\n")


def test_the_lock_file_names_host_and_process_and_goes_with_the_session(path):
    with Journal.reopen(path, VirtualClock()):
        held = locks.lock_file(path).read_text().split()
        assert held == [socket.gethostname(), str(os.getpid())]
    assert not locks.lock_file(path).exists()


def test_without_locks_a_journal_can_be_written_and_is_not_running_now(path, no_locks):
    assert not locks.is_being_written(path)
    with Journal.reopen(path, VirtualClock()) as journal:
        journal.write("end")
    with path.open("rb") as stream:
        assert not locks.has_locks(stream)


def test_without_locks_the_lock_file_of_a_living_process_keeps_others_out(path, no_locks):
    claim(path, socket.gethostname(), os.getppid())
    assert locks.is_being_written(path)
    with pytest.raises(UserError, match=rf"process {os.getppid()} on .*delete .*a\.jsonl\.lock"):
        Journal.reopen(path, VirtualClock())


def test_what_a_crash_left_behind_keeps_nobody_out(path, no_locks):
    claim(path, socket.gethostname(), 2**22 + 1)  # above Linux' largest process number
    assert not locks.is_being_written(path)
    Journal.reopen(path, VirtualClock()).close()


def test_where_there_are_locks_they_know_better_than_a_file_of_this_computer(path):
    claim(path, socket.gethostname(), os.getppid())
    assert not locks.is_being_written(path)


@pytest.mark.parametrize("sign", [-1, 1], ids=["past", "future"])
def test_another_computer_is_believed_as_long_as_it_writes(path, sign):
    claim(path, "elsewhere", 1)
    assert locks.is_being_written(path)
    stale = locks.lock_file(path).stat().st_mtime + sign * (locks.STALE_S + 60)
    os.utime(locks.lock_file(path), (stale, stale))
    assert not locks.is_being_written(path)


@pytest.mark.parametrize("text", ["", "host", "host seven", "\0"])
def test_a_lock_file_that_says_nothing_is_no_lock(path, no_locks, text):
    locks.lock_file(path).write_text(text)
    assert not locks.is_being_written(path)


def test_two_that_begin_at_once_do_not_both_write(path, no_locks):
    """Where another has just claimed the lock file, and not named it yet, nobody else may."""
    claimed = path.with_name(f"{path.name}.lock.new")
    claimed.touch()
    with pytest.raises(UserError, match="another session is about to write to it"):
        Journal.reopen(path, VirtualClock())
    assert claimed.exists()


def test_a_claim_that_a_crash_left_behind_keeps_nobody_out(path, no_locks):
    claimed = path.with_name(f"{path.name}.lock.new")
    claimed.touch()
    old = claimed.stat().st_mtime - locks.CLAIM_S - 1
    os.utime(claimed, (old, old))
    with Journal.reopen(path, VirtualClock()):
        assert not claimed.exists()
        assert locks.lock_file(path).read_text().split()[1] == str(os.getpid())


def test_who_has_the_systems_lock_waits_for_no_claim(path):
    path.with_name(f"{path.name}.lock.new").touch()
    Journal.reopen(path, VirtualClock()).close()


def test_who_is_refused_leaves_the_other_lock_file_as_it_was(path, no_locks):
    claim(path, socket.gethostname(), os.getppid())
    with pytest.raises(UserError, match="another session is writing to it"):
        Journal.reopen(path, VirtualClock())
    assert locks.lock_file(path).read_text().split()[1] == str(os.getppid())
    assert not path.with_name(f"{path.name}.lock.new").exists()


@pytest.mark.parametrize("days", [-400, 400])
def test_a_wrong_date_on_this_computer_takes_no_journal_from_another(path, monkeypatch, days):
    """The lock file's age is told by the drive's own clock."""
    claim(path, "elsewhere", 1)
    now_s = locks.time.time()
    monkeypatch.setattr(locks.time, "time", lambda: now_s + days * 86_400)
    with pytest.raises(UserError, match="another session is writing to it"):
        Journal.reopen(path, VirtualClock())
