"""Run the guard: a process that switches an output off when its session ends or stops.

The session (`slipscale.hardware.output.guard`) starts the guard before the first output, and writes
lines to its standard input:

====================  ==========================================================================
the first             the pickled function that returns the `Switch`, in hexadecimal
``+``, ``-``          the output may be on from now on; it is confirmed off
empty                 a heartbeat, as is any other line
``[n, method, ...]``  call a method of the switch with the remaining texts
``.``                 the session ends, and the output is confirmed off
====================  ==========================================================================

The guard answers in JSON: ``{"n": n, "answer": text}`` or ``{"n": n, "fault": record}``. Every
`ALIVE_S`, it writes ``{}`` as a sign of life. Rules:

- If the output may be on and no line arrives for `WATCHDOG_S`, the guard switches it off and
  reports ``{"tripped_s": seconds}``. The session continues once it beats again.
- If standard input ends while the output may be on, the guard switches it off and exits. It repeats
  failed attempts for `TRIES_S`.
- Ctrl-C, a closed terminal and signals to the session's process group do not reach the guard.
"""

from __future__ import annotations

import json
import os
import pickle
import signal
import sys
import time
from collections.abc import Iterable
from contextlib import suppress
from queue import Empty, SimpleQueue
from threading import Thread
from typing import TYPE_CHECKING, BinaryIO

from slipscale.hardware.errors import GuardLost, PlateFault

if TYPE_CHECKING:
    from slipscale.hardware.output.unattended import Switch

WATCHDOG_S = 0.7
GRACE_S = 0.05  # for lines that arrived while this process was not running
RETRY_S, TRIES_S = 0.2, 600.0
ALIVE_S = 0.5
IGNORED = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGTSTP", "SIGPIPE", "SIGBREAK")

ON, OFF, END = b"+", b"-", b"."


class GuardProcess:
    """State of the guard.

    Parameters
    ----------
    switch : Switch
        What switches the output off.
    answers : BinaryIO
        Stream to the session.
    """

    def __init__(self, switch: Switch, answers: BinaryIO) -> None:
        self._switch = switch
        self._answers = answers
        self._lines: SimpleQueue[bytes | None] = SimpleQueue()
        self._heard_s = time.monotonic()
        self._armed = self._tripped = False

    def serve(self, lines: Iterable[bytes]) -> None:
        """Carry out the session's lines until it ends, and leave the output off."""
        Thread(target=self._read, args=(lines,), daemon=True).start()
        while (line := self._next()) not in (None, END):
            if line in (ON, OFF):
                self._armed = line == ON
            elif line:
                self._call(line)
        end_s = time.monotonic() + TRIES_S
        on = line is None and self._armed and not self._tripped
        while on and not self._is_off() and time.monotonic() < end_s:
            time.sleep(RETRY_S)

    def _read(self, lines: Iterable[bytes]) -> None:
        for line in lines:
            self._heard_s = time.monotonic()
            self._lines.put(line.rstrip())
        self._lines.put(None)

    def _next(self) -> bytes | None:
        """Return the next line, or None at the end; switch the output off while none arrives."""
        while True:
            wait_s = None
            if self._armed and not self._tripped:
                wait_s = max(self._heard_s + WATCHDOG_S - time.monotonic(), GRACE_S)
            try:
                line = self._lines.get(timeout=wait_s)
            except Empty:
                self._trip()
            else:
                # A session that goes on may switch the output on; one that ended left it off.
                self._tripped = self._tripped and line is None
                return line

    def _trip(self) -> None:
        silent_s = time.monotonic() - self._heard_s
        if silent_s < WATCHDOG_S:
            return
        if self._is_off():
            self._tripped = True
            tell(self._answers, {"tripped_s": silent_s})

    def _is_off(self) -> bool:
        """Switch the output off; return whether it is off."""
        try:
            self._switch.switch_off()
        except Exception:  # noqa: BLE001 - a defect must not end the attempts
            return False
        return True

    def _call(self, line: bytes) -> None:
        number, method, *words = json.loads(line)
        try:
            answer = {"answer": getattr(self._switch, method)(*words)}
        except Exception as error:  # noqa: BLE001 - a defect must not end the guard
            answer = {"fault": _as_fault(error).record()}
        tell(self._answers, {"n": number, **answer})


def _as_fault(error: Exception) -> PlateFault:
    if isinstance(error, PlateFault):
        return error
    return GuardLost("the guard process failed ({error})", error=repr(error))


def tell(answers: BinaryIO, answer: dict[str, object]) -> None:
    """Write an answer to the session; if the session has ended, its lines end as well."""
    with suppress(OSError):
        answers.write(json.dumps(answer).encode() + b"\n")
        answers.flush()


def live(answers: BinaryIO) -> None:
    """Give signs of life until this process ends."""
    while True:
        time.sleep(ALIVE_S)
        tell(answers, {})


def main() -> None:
    """Serve the session that started this process."""
    for name in IGNORED:
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    # Libraries may print, which must not reach the session.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    try:
        opens = pickle.loads(bytes.fromhex(sys.stdin.buffer.readline().decode()))  # noqa: S301
        switch = opens()
    except Exception as error:  # noqa: BLE001 - the session reports it
        tell(answers, {"n": 0, "fault": _as_fault(error).record()})
        return
    tell(answers, {"n": 0, "answer": ""})
    Thread(target=live, args=(answers,), daemon=True).start()
    GuardProcess(switch, answers).serve(sys.stdin.buffer)


if __name__ == "__main__":
    main()
