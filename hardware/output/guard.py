"""Start and use a guard: the process that switches the output off when the session cannot.

The guard is needed by devices without a watchdog. It runs in its own session of the operating
system, so Ctrl-C, a closed terminal and the death of this process do not end it. While the output
may be on, a thread of this process sends heartbeats, unless the session itself hangs: it must give
a sign of life (`Guard.attend`) every ``attention_s`` seconds. A stopped or killed process sends no
heartbeats. In return, the guard gives signs of life. A guard that stands still is killed, and the
next command starts another one, which switches the output off. For the rules of the guard, see
`slipscale.hardware.output.guard_process`.
"""

from __future__ import annotations

import json
import pickle
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue
from threading import Event, Lock, Thread
from typing import IO, Any

from slipscale.hardware.errors import Frozen, GuardLost, PlateTimeout, fault_of
from slipscale.hardware.output.guard_process import END, OFF, ON, WATCHDOG_S
from slipscale.hardware.output.unattended import Switch

MODULE = "slipscale.hardware.output.guard_process"
BEAT_S = 0.1
ANSWER_S = 10.0  # longer than an instrument's time-outs while a connection is opened
END_S = 5.0
#: A guard that gives no sign of life for so many heartbeats stands still. Beats are counted, not
#: seconds, because this process may have stood still itself.
STILL_BEATS = 30
ENDED = "the guard process ended"
# Windows: neither the console nor its Ctrl-C reaches the guard.
DETACHED: dict[str, Any] = (
    {"creationflags": 0x0000_0008 | 0x0000_0200}
    if sys.platform == "win32"
    else {"start_new_session": True}
)


class Guard:
    """Guard process of one output.

    Parameters
    ----------
    opens : callable
        Function that returns the `Switch` in the guard process; it must be possible to pickle it.
    attention_s : float
        Time without `attend` after which the heartbeats stop; 0 means never.
    keeps : tuple of int
        File descriptors that the guard inherits, except on Windows.

    Raises
    ------
    GuardLost
        If the process does not start.
    """

    def __init__(
        self, opens: Callable[[], Switch], *, attention_s: float, keeps: tuple[int, ...] = ()
    ) -> None:
        self._attention_s = attention_s
        self._attended_s = time.monotonic()
        self._armed = False
        self._tries = False  # It still tries to switch the output off after `end`.
        self._tripped_s = 0.0
        self._number = 0
        self._heard = 0  # lines from the guard
        self._answers: SimpleQueue[dict[str, Any]] = SimpleQueue()
        self._writing = Lock()
        self._over = Event()
        # Without -P, a file of the current folder could replace the package.
        inherited: dict[str, Any] = {} if sys.platform == "win32" else {"pass_fds": keeps}
        self._process: subprocess.Popen[bytes] = subprocess.Popen(  # noqa: S603 - our own module
            [sys.executable, "-P", "-m", MODULE],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            **DETACHED,
            **inherited,
        )
        self._send(pickle.dumps(opens).hex().encode())
        Thread(target=self._read, args=(self._process.stdout,), daemon=True).start()
        Thread(target=self._beat, daemon=True).start()
        self._answer()

    @property
    def process_id(self) -> int:
        """Process id of the guard."""
        return self._process.pid

    @property
    def ended(self) -> bool:
        """Whether the guard process has ended."""
        return not self._tries and self._process.poll() is not None

    def attend(self) -> None:
        """Record that the session is alive."""
        self._attended_s = time.monotonic()

    def check(self) -> None:
        """Raise `Frozen` if the guard switched the output off, `GuardLost` if it ended."""
        if self._tripped_s:
            raise Frozen(
                "this session stood still for more than {watchdog_s:g} s while the plate was on, "
                "so the guard switched it off",
                watchdog_s=WATCHDOG_S,
            )
        if self._armed and self.ended:
            raise GuardLost(ENDED)

    def arm(self, armed: bool) -> None:
        """Inform the guard whether the output may be on; raise `GuardLost` if it ended."""
        if armed == self._armed:
            return
        self._tripped_s, self._armed = 0.0, armed
        if armed:
            self._send(ON)
        else:
            with suppress(GuardLost):  # A guard that ended is missed at the next command.
                self._send(OFF)

    def call(self, method: str, *words: str) -> str:
        """Call a method of the `Switch`. Raises `PlateFault`."""
        self._number += 1
        self._send(json.dumps([self._number, method, *words]).encode())
        return self._answer()

    def end(self, *, confirmed_off: bool) -> None:
        """End the guard; unless the output is confirmed off, the guard first switches it off."""
        self._over.set()
        self._tries = self._armed and not confirmed_off
        with suppress(GuardLost, OSError):
            if not self._tries:
                self._send(END)
            with self._writing:
                self._pipe.close()
        if self._tries:  # It may try for minutes, so nobody waits for it.
            self._process.returncode = 0
            return
        try:
            self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self.kill()

    def kill(self) -> None:
        """End the guard at once, because another one takes its place."""
        self._over.set()
        with suppress(GuardLost, OSError):
            self._process.returncode = None
            self._process.kill()
            self._process.wait()
            with self._writing:
                self._pipe.close()

    @property
    def _pipe(self) -> IO[bytes]:
        if self._process.stdin is None:
            raise GuardLost(ENDED)
        return self._process.stdin

    def _send(self, line: bytes) -> None:
        try:
            with self._writing:
                self._pipe.write(line + b"\n")
                self._pipe.flush()
        except (OSError, ValueError) as error:  # ValueError: the pipe is closed
            raise GuardLost(ENDED) from error

    def _answer(self) -> str:
        """Return the answer to the last call. Raises `PlateFault`."""
        end_s = time.monotonic() + ANSWER_S
        while True:
            try:
                answer = self._answers.get(timeout=max(end_s - time.monotonic(), 0.0))
            except Empty:
                raise PlateTimeout("the guard process does not answer") from None
            if "over" in answer:
                raise GuardLost(ENDED)
            if answer.get("n") == self._number:  # A signal may have interrupted an earlier call.
                if "fault" in answer:
                    raise fault_of(answer["fault"])
                return str(answer["answer"])

    def _read(self, answers: IO[bytes]) -> None:
        with answers:
            for line in answers:
                self._heard += 1
                answer = json.loads(line)
                if "tripped_s" in answer:
                    self._tripped_s = answer["tripped_s"]
                elif answer:
                    self._answers.put(answer)
        self._answers.put({"over": True})

    def _beat(self) -> None:
        heard = silent = 0
        with suppress(GuardLost):  # `check` and `call` report it.
            while not self._over.wait(BEAT_S):
                silent = silent + 1 if heard == self._heard else 0
                heard = self._heard
                if heard and silent > STILL_BEATS:
                    self._process.kill()
                    return
                silent_s = time.monotonic() - self._attended_s
                if self._armed and not (self._attention_s and silent_s > self._attention_s):
                    self._send(b"")
