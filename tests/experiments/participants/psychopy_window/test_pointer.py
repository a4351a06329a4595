"""The window's pointer as a finger: moved by a hand outside the program, read in millimetres."""

import shutil
import subprocess
import sys
import time

import pytest

from slipscale.experiments.languages.texts import load_texts
from slipscale.experiments.participants.psychopy_window import PsychoPyWindow
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.contact.registry import open_source
from slipscale.hardware.contact.source import Surroundings

pytestmark = [
    pytest.mark.window,
    pytest.mark.skipif(
        not sys.platform.startswith("linux") or not shutil.which("xdotool"),
        reason="the pointer is moved by xdotool, under X11",
    ),
]


PATIENCE_S = 60.0


def moved_to(window, x, y):
    """Move the pointer to a place of the screen, and wait until the window has heard of it."""
    heard = []
    window.display.handle.push_handlers(on_mouse_motion=lambda *_: heard.append(True))
    subprocess.run(["xdotool", "mousemove", str(x), str(y)], check=True)
    end_s = time.monotonic() + PATIENCE_S
    window.hold("", lambda: heard or time.monotonic() > end_s)
    window.display.handle.pop_handlers()
    assert heard


def test_the_pointer_is_where_the_hand_moved_it(display):
    clock = SystemClock()
    window = PsychoPyWindow(texts=load_texts("en"), clock=clock, pilot=True, full_screen=True)
    around = Surroundings(clock=clock, finger=window.finger)
    source = open_source("position", "mouse:mm_per_pixel=0.5", around)
    assert source.take() == []  # no window is open
    with window:
        assert source.take() == []  # it has not moved yet
        moved_to(window, 100, 100)
        places = []
        for x, y in ((640, 400), (740, 400), (740, 300)):  # the middle, right of it, then up
            moved_to(window, x, y)
            places.append(source.take()[0].values)
    first, right, up = places
    assert first == pytest.approx((0.0, 0.0), abs=1.0)
    assert right[0] - first[0] == pytest.approx(50.0, abs=1.0)
    assert up[1] - right[1] == pytest.approx(50.0, abs=1.0)
