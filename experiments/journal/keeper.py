"""A thread that takes what was written to an open file to the disk, while the session goes on.

The rules, for the journal that hands records over:

- The caller writes, in order; the thread only waits for the disk. So a killed process loses nothing
  that was written, and only a power cut could lose what the thread has not yet confirmed.
- One wait for the disk covers all that was written before it began.
- The first failure ends the thread, because a second attempt can succeed although data are lost.
  The caller finds it in `failure`, and begins another thread after it has cut the file.
- The thread shares single values with its caller, and no lock: a signal may interrupt the caller
  anywhere.
"""

from __future__ import annotations

import os
from queue import Empty, SimpleQueue
from threading import Thread
from typing import NamedTuple

# A disk that takes longer is taken for dead: the session ends, and the plate is silenced.
PATIENCE_S = 30.0
ENDS_S = 1.0


class Mark(NamedTuple):
    """A place between two records: how many there are before it, and its place in the file."""

    records: int
    length: int


class Keeper:
    """Waits for the disk in a thread.

    Parameters
    ----------
    descriptor : int
        The open file.
    kept : Mark
        What is on the disk already.

    Attributes
    ----------
    kept : Mark
        What is on the disk now.
    wanted : Mark
        What was handed over.
    failure : BaseException or None
        Why no more will be.
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
        """Hand over all that was written before a mark."""
        self._handed.put(mark)
        self.wanted = mark

    def wait(self, records: int) -> bool:
        """Return once so many records are on disk, or never will be; False if the disk hangs."""
        while self.failure is None and self.kept.records < records:
            try:
                self._woken.get(timeout=PATIENCE_S)
            except Empty:
                return False
        return True

    def stop(self) -> None:
        """End the thread once it has nothing left to do; one that hangs is left behind."""
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
        """Return the last mark handed over until now; wait for one if there is none."""
        mark = self._handed.get()
        while mark is not None and not self._handed.empty():
            mark = self._handed.get()
        return mark
