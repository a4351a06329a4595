"""Accents, third level and Compose, wherever the pointer is: a real window, real keys."""

from __future__ import annotations

import itertools
import shutil
import subprocess
import sys
import time

import pytest

from slipscale.experiments.languages.texts import load_texts
from slipscale.experiments.participants.psychopy_window import PsychoPyWindow
from slipscale.experiments.steps.questions.text import TextQuestion
from slipscale.experiments.steps.steps import Ask
from slipscale.hardware.clock import SystemClock

pytestmark = [
    pytest.mark.window,
    pytest.mark.skipif(
        not sys.platform.startswith("linux") or not shutil.which("xdotool"),
        reason="key presses come from xdotool, under X11",
    ),
]

TEXT = Ask(name="verbal_report", question=TextQuestion(prompt="What?"))
LAYOUTS = {
    "fr": ("dead_circumflex e dead_diaeresis i", "êï"),
    "de": ("dead_acute e dead_grave a dead_circumflex o", "éàô"),
    "es": ("dead_acute a dead_grave o dead_diaeresis u", "áòü"),
}
# The key that has the character on its third level, and the character.
THIRD_LEVEL = {"fr": ("agrave", "@"), "de": ("q", "@"), "es": ("2", "@")}
PATIENCE_S = 300.0
INSIDE, OUTSIDE = ("640", "400"), ("1279", "799")


@pytest.fixture(scope="module", params=[True, False], ids=["full screen", "windowed"])
def window(display, request):
    with PsychoPyWindow(
        texts=load_texts("fr"),
        clock=SystemClock(),
        pilot=True,
        full_screen=request.param,
        size=(800, 600),
    ) as opened:
        yield opened


@pytest.fixture(autouse=True)
def _layout_of_the_others(display):
    yield
    subprocess.run(["setxkbmap", "-layout", "us", "-option", ""], check=True)


def type_at(window, *words):
    """Press keys, and Return, once the question is on the screen; return the reply."""
    frames, pressing = itertools.count(), []
    end_s = time.monotonic() + PATIENCE_S

    def watch():
        frame = next(frames)
        if frame == 5:
            pressing.append(subprocess.Popen(["xdotool", *words, "key", "Return"]))
        assert time.monotonic() < end_s, "nothing was typed"

    reply = window.perform(TEXT, watch)
    pressing[0].wait()
    return reply


def point(place):
    subprocess.run(["xdotool", "mousemove", *place], check=True)


@pytest.mark.parametrize("place", [INSIDE, OUTSIDE], ids=["pointer inside", "pointer outside"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_dead_key_gives_its_letter_the_accent(window, layout, place):
    keys, said = LAYOUTS[layout]
    subprocess.run(["setxkbmap", layout], check=True)
    point(place)
    assert type_at(window, "key", *keys.split()).value == said


@pytest.mark.parametrize("layout", THIRD_LEVEL)
def test_altgr_gives_the_third_level(window, layout):
    key, said = THIRD_LEVEL[layout]
    subprocess.run(["setxkbmap", layout], check=True)
    point(INSIDE)
    altgr = ("keydown", "ISO_Level3_Shift", "key", key, "keyup", "ISO_Level3_Shift")
    assert type_at(window, *altgr).value == said


@pytest.mark.parametrize("layout", LAYOUTS)
def test_compose_joins_two_letters(window, layout):
    subprocess.run(["setxkbmap", "-layout", layout, "-option", "compose:menu"], check=True)
    point(INSIDE)
    assert type_at(window, "key", "Multi_key", "o", "e").value == "œ"


def test_a_character_that_is_composed_takes_the_time_of_a_key(window):
    subprocess.run(["setxkbmap", "fr"], check=True)
    point(INSIDE)
    end_s = time.monotonic() + PATIENCE_S
    while True:  # until stamps are not late, as they can be on a busy machine
        reply = type_at(window, "key", "dead_circumflex", "e")
        assert reply.value == "ê"
        if reply.time_source == "ptb":
            break
        assert time.monotonic() < end_s, "no key is stamped"
