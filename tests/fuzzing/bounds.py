"""Limit an input to 2 s of processor time and 500 MB of memory; requires POSIX."""

from __future__ import annotations

import resource
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

MOST_S = 2.0
MOST_BYTES = 500 * 2**20
# Processor time after which the system ends a process that Python cannot interrupt.
ENDED_AFTER_S = 20


class TooLong(BaseException):
    """Error for too much processor time, which ``except Exception`` does not catch."""


def _too_long(*_: object) -> None:
    raise TooLong


@contextmanager
def limited_memory() -> Iterator[None]:
    """Limit the process to 500 MB more than it uses now; larger requests raise MemoryError.

    Memory that earlier inputs did not release counts too, so that growing caches are detected.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    held = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (held + MOST_BYTES, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


@contextmanager
def limited_time() -> Iterator[None]:
    """Raise `TooLong` after 2 s of processor time.

    Raises
    ------
    TooLong
        Immediately, or after code that cannot be interrupted.
    """
    began_s = time.process_time()
    soft, hard = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (int(began_s) + ENDED_AFTER_S, hard))
    handler = signal.signal(signal.SIGPROF, _too_long)
    signal.setitimer(signal.ITIMER_PROF, MOST_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, handler)
        resource.setrlimit(resource.RLIMIT_CPU, (soft, hard))
    if time.process_time() - began_s > MOST_S:
        raise TooLong
