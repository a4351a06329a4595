"""Measure the error of recorded key presses, with and without the device's time stamps.

Usage: xvfb-run -s "-screen 0 1280x800x24" .venv/bin/python benchmarks/response_times.py

A thread presses keys at random times through the X test extension and records the times; the
window records them as in a session. The keyboard's own delay (scanning and USB, about 5 to 30 ms
depending on the model) is not included, because software cannot observe it.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import os
import threading
import time

import numpy as np

from slipscale.experiments.languages.texts import load_texts
from slipscale.experiments.participants.psychopy_window import PsychoPyWindow
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.steps import Ask
from slipscale.hardware.clock import SystemClock

PRESSES = 200
KEYCODE_Y = 29  # On a PC keyboard under X11.


class Finger:
    """Simulated finger that presses a key at a random time after each request."""

    def __init__(self, clock: SystemClock) -> None:
        self._clock = clock
        self._x11 = ctypes.CDLL(ctypes.util.find_library("X11"))
        self._xtst = ctypes.CDLL(ctypes.util.find_library("Xtst"))
        self._x11.XOpenDisplay.restype = ctypes.c_void_p
        self._display = ctypes.c_void_p(self._x11.XOpenDisplay(os.environ["DISPLAY"].encode()))
        self._random = np.random.default_rng(1)
        self.pressed_s = float("nan")

    def press(self) -> None:
        """Press after 50 to 90 ms, so that every phase of a frame occurs; record the time."""
        time.sleep(0.05 + 0.04 * self._random.random())
        self.pressed_s = self._clock.now()
        self._send(down=True)
        time.sleep(0.03)
        self._send(down=False)

    def _send(self, *, down: bool) -> None:
        self._xtst.XTestFakeKeyEvent(self._display, KEYCODE_Y, int(down), ctypes.c_ulong(0))
        self._x11.XFlush(self._display)


def lags_ms(*, precise_times: bool) -> tuple[np.ndarray, set[str]]:
    """Return recorded minus true press times in ms, and the source of the times."""
    clock = SystemClock()
    finger = Finger(clock)
    step = Ask(name="x", question=YesNoQuestion(prompt="?"))
    lags, sources = [], set()
    with PsychoPyWindow(
        texts=load_texts("en"), clock=clock, pilot=False, precise_times=precise_times
    ) as window:
        for _ in range(PRESSES):
            frames = 0
            hand = threading.Thread(target=finger.press)

            def watch(hand: threading.Thread = hand) -> None:
                nonlocal frames
                frames += 1
                if frames == 2:  # The question is on the screen.
                    hand.start()

            window._await_release(lambda: None)  # noqa: SLF001  so that frame 2 is the question's
            reply = window.perform(step, watch)
            hand.join()
            lags.append((reply.onset_s + reply.response_time_s - finger.pressed_s) * 1000)  # type: ignore[operator]
            sources.add(reply.time_source)
    return np.array(lags), sources


def main() -> None:
    for precise_times in (True, False):
        lags, sources = lags_ms(precise_times=precise_times)
        low, middle, high = np.percentile(lags, [2.5, 50, 97.5])
        print(
            f"{'/'.join(sorted(sources)):<10} n = {lags.size}  median {middle:.2f} ms  "
            f"95 % in {low:.2f} to {high:.2f} ms  SD {lags.std(ddof=1):.2f} ms"
        )


if __name__ == "__main__":
    main()
