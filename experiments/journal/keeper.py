"""Flush an open file to disk in a thread while the session continues.

The rules are:

- The caller writes to the file; the thread only flushes the file to disk. A killed process
  therefore loses no data, and a power failure can lose only data that are not yet flushed.
- Each flush covers all data written before the flush began.
- The thread ends when a flush fails. The flush is not repeated, because a second flush can report
  success although data were lost. The caller reads the error from `failure`, truncates the file and
  starts a new thread.
- The thread and its caller share only single values and no lock, because a signal may interrupt the
  caller at any point.
"""

from __future__ import annotations

import os
from queue import Empty, SimpleQueue
from threading import Thread
from typing import NamedTuple

# If the disk takes longer, it counts as failed: the session ends and the plate is switched off.
PATIENCE_S = 30.0
ENDS_S = 1.0


class Mark(NamedTuple):
    """Position between two records: the number of records before it, and the file offset."""

    records: int
    length: int


class Keeper:
    """A separate thread that flushes a file to disk.

    Parameters
    ----------
    descriptor : int
        Descriptor of the open file.
    kept : Mark
        Position in the file up to which all data are already on disk.

    Attributes
    ----------
    kept : Mark
        Position up to which all data have been flushed to disk so far.
    wanted : Mark
        Position up to which the caller requested flushing, by calling `want`.
    failure : BaseException or None
        The error that ended the thread.
    """

    def __init__(self, descriptor: int, kept: Mark) -> None:
        self.kept = self.wanted = kept
        self.failure: BaseException | None = None
        self._descriptor = descriptor
        self._handed: SimpleQueue[Mark | None] = SimpleQueue()
        self._woken: SimpleQueue[None] = SimpleQueue()
        self._thread = Thread(target=self._run, name="journal", daemon=True)
        self._thread.start()

    def want(self, mark: Mark) -> None:
        """Let the thread flush all data before ``mark`` to disk."""
        self._handed.put(mark)
        self.wanted = mark

    def wait(self, records: int) -> bool:
        """Wait until ``records`` records are on disk or flushing fails; return False on timeout."""
        while self.failure is None and self.kept.records < records:
            try:
                self._woken.get(timeout=PATIENCE_S)
            except Empty:
                return False
        return True

    def stop(self) -> None:
        """Wait at most `ENDS_S` seconds for the thread to finish."""
        self._handed.put(None)
        self._thread.join(ENDS_S)

    def _run(self) -> None:
        for mark in iter(self._next, None):
            try:
                os.fsync(self._descriptor)
            except BaseException as error:  # noqa: BLE001 - the caller raises it
                self.failure = error
                break
            else:
                self.kept = mark
            finally:
                self._woken.put(None)

    def _next(self) -> Mark | None:
        """Return the latest submitted mark, and wait for one if there is none."""
        mark = self._handed.get()
        while mark is not None and not self._handed.empty():
            mark = self._handed.get()
        return mark
