"""How long from the command to the first screen, beside a bare script with PsychoPy and a window.

Usage: .venv/bin/python benchmarks/first_screen.py [--runs 5] [COMMAND ...]
COMMAND is what opens our window; by default a script that does nothing else. Each run has a fresh
virtual screen (Xvfb), and is over when the first pixel of the window is drawn: both sides are
timed by the same eye, outside them. They take turns, so that a busy machine is fair to both.
"""

from __future__ import annotations

import argparse
import ctypes
import ctypes.util
import os
import signal
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Self

ROOT = Path(__file__).resolve().parent.parent
LIMIT_S = 120.0
LEAST_TO_SEE = 20  # of 255: the window's dark grey is seen, the empty screen's black is not

BARE = """
from psychopy import visual
window = visual.Window(size=(1280, 800), color="grey", checkTiming=False)
visual.TextStim(window, text="Welcome").draw()
window.flip()
import time; time.sleep(60)
"""

OURS = """
from slipscale.experiments.participants.psychopy_window import PsychoPyWindow
from slipscale.experiments.protocols.steps import Instruct
from slipscale.experiments.languages.texts import load_texts
from slipscale.hardware.clock import SystemClock
with PsychoPyWindow(texts=load_texts("en"), clock=SystemClock(), pilot=False) as window:
    window.perform(Instruct(text="Welcome"), lambda: None)
"""


class Screen:
    """A virtual screen and an eye on it."""

    def __enter__(self) -> Self:
        reading, writing = os.pipe()
        self._server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(writing), "-screen", "0", "1280x800x24"],
            pass_fds=[writing],
            stderr=subprocess.DEVNULL,
        )
        os.close(writing)
        with os.fdopen(reading) as answer:
            self.name = f":{answer.readline().strip()}"
        self._x11 = ctypes.CDLL(ctypes.util.find_library("X11"))
        self._x11.XOpenDisplay.restype = ctypes.c_void_p
        self._x11.XGetImage.restype = ctypes.c_void_p
        self._x11.XGetPixel.restype = ctypes.c_ulong
        self._x11.XDefaultRootWindow.restype = ctypes.c_ulong
        self._display = ctypes.c_void_p(self._x11.XOpenDisplay(self.name.encode()))
        self._root = ctypes.c_ulong(self._x11.XDefaultRootWindow(self._display))
        return self

    def __exit__(self, *_about: object) -> None:
        self._x11.XCloseDisplay(self._display)
        self._server.terminate()
        self._server.wait()

    def drawn(self) -> bool:
        """Return whether anything but black is seen near the screen's middle."""
        every_plane, z_pixmap = ctypes.c_ulong(0xFFFFFFFF), 2
        image = ctypes.c_void_p(
            self._x11.XGetImage(self._display, self._root, 200, 700, 1, 1, every_plane, z_pixmap)
        )
        pixel = self._x11.XGetPixel(image, 0, 0)
        self._x11.XFree(image)
        return bool(max(pixel >> shift & 0xFF for shift in (0, 8, 16)) >= LEAST_TO_SEE)


def first_screen_s(command: list[str]) -> float:
    """Return the time in s from starting a command to its first pixel."""
    with Screen() as screen:
        environment = os.environ | {"DISPLAY": screen.name}
        began_s = time.perf_counter()
        process = subprocess.Popen(
            command,
            cwd=ROOT,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            while not screen.drawn():
                time.sleep(0.005)
                if process.poll() is not None:
                    sys.exit(f"{' '.join(command)} ended with {process.returncode}, no screen")
                if time.perf_counter() - began_s > LIMIT_S:
                    sys.exit(f"{' '.join(command)}: no screen after {LIMIT_S:g} s")
            return time.perf_counter() - began_s
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def main() -> None:
    """Time both in turns and print the ratio."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("command", nargs=argparse.REMAINDER)
    options = parser.parse_args()
    bare = [sys.executable, "-c", BARE]
    ours = options.command or [sys.executable, "-c", OURS]
    first_screen_s(bare)  # files into the cache, for both
    times: dict[str, list[float]] = {"bare": [], "ours": []}
    for _ in range(options.runs):
        times["bare"].append(first_screen_s(bare))
        times["ours"].append(first_screen_s(ours))
    for name, measured_s in times.items():
        spread = " ".join(f"{value_s:.2f}" for value_s in measured_s)
        print(f"{name}  median {statistics.median(measured_s):.2f} s  ({spread})")
    for what, take in (("medians", statistics.median), ("fastest", min)):
        print(f"ours / bare, {what}  {take(times['ours']) / take(times['bare']):.2f}")


if __name__ == "__main__":
    main()
