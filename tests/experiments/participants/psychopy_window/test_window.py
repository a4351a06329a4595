"""The real window, driven by synthetic key presses as a person's hand would drive it."""

from __future__ import annotations

import itertools
import shutil
import subprocess
import sys
import threading
import time
from dataclasses import replace

import pytest

from slipscale.experiments.languages.texts import load_texts
from slipscale.experiments.participants.base import StopRequested, Unfinished
from slipscale.experiments.participants.psychopy_window import PsychoPyWindow, scene
from slipscale.experiments.participants.psychopy_window.entry import CLEAR, ENTER, ERASE
from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.steps.questions import (
    ChoiceQuestion,
    NumberQuestion,
    TextQuestion,
    YesNoQuestion,
)
from slipscale.experiments.steps.steps import Ask, Explore, Instruct, Rest
from slipscale.faults import UserError
from slipscale.hardware.clock import SystemClock

pytestmark = [
    pytest.mark.window,
    pytest.mark.skipif(
        not sys.platform.startswith("linux") or not shutil.which("xdotool"),
        reason="key presses come from xdotool, under X11",
    ),
]

NUMBER = Ask(name="estimate", question=NumberQuestion(prompt="How slippery?"))
TEXT = Ask(name="verbal_report", question=TextQuestion(prompt="What?"))
YES_NO = Ask(name="difference", question=YesNoQuestion(prompt="A difference?"))
CHOICE = Ask(
    name="confidence",
    question=ChoiceQuestion(prompt="Sure?", options=(("guess", "a guess"), ("sure", "sure"))),
)


@pytest.fixture(scope="module")
def window(display):
    with PsychoPyWindow(
        texts=load_texts("fr"), clock=SystemClock(), pilot=True, full_screen=False
    ) as opened:
        yield opened


PRESSING = []


class Hand:
    """Presses keys, each line once the window has drawn a few more frames, if ``ready()``."""

    def __init__(self, *lines, ready=lambda: True):
        self._lines = list(lines)
        self._ready = ready
        self._frames = 0
        self._busy = None
        self._gives_up_s = time.perf_counter() + 20

    def __call__(self):
        """Serve as the session's watch: called at every frame."""
        assert time.perf_counter() < self._gives_up_s, "the window did not come to an end"
        self._frames += 1
        if self._busy and self._busy.poll() is None:
            self._frames = 0
        elif self._lines and self._frames > 3 and self._ready():
            self._busy = subprocess.Popen(["xdotool", *self._lines.pop(0).split()])
            PRESSING.append(self._busy)
            self._frames = 0

    @property
    def done(self):
        """Whether all was pressed and the window had time to hear it."""
        return not self._lines and self._busy.poll() is not None and self._frames > 3


@pytest.fixture(autouse=True)
def _no_key_stays_down(request):
    yield
    while PRESSING:
        PRESSING.pop().wait()
    if "window" in request.fixturenames:
        opened = request.getfixturevalue("window")
        opened._await_release(lambda: None)
        opened.unfinished = Unfinished()


@pytest.mark.parametrize(
    "keys, value",
    [
        ("key 1 2 period 5 Return", 12.5),
        ("key 1 2 comma 5 Return", 12.5),
        ("key KP_1 KP_2 KP_Decimal KP_5 KP_Enter", 12.5),
        ("key 1 2 8 BackSpace BackSpace 5 Return", 15.0),
    ],
)
def test_a_number_is_typed_on_either_block_with_comma_or_point(window, keys, value):
    reply = window.perform(NUMBER, Hand(keys))
    assert reply.value == value
    assert reply.rejected == ()
    assert not reply.timed_out


def test_a_wrong_number_is_explained_kept_and_asked_again(window):
    reply = window.perform(NUMBER, Hand("key a b Return minus 3 Return", "key 4 Return"))
    assert reply.value == 4.0
    assert reply.rejected == ("ab", "-3")


def test_a_french_keyboard_types_what_is_printed_on_its_keys(window):
    subprocess.run(["setxkbmap", "fr"], check=True)  # a French keyboard: its 2 is é, its A our Q
    try:
        hand = Hand("key a eacute ccedilla agrave q ugrave exclam Return")
        assert window.perform(TEXT, hand).value == "aéçàqù!"
        assert window.perform(CHOICE, Hand("key eacute")).value == "sure"
        reply = window.perform(NUMBER, Hand("key 1 2 comma 5 Return"))
        assert (reply.value, reply.time_source) == (12.5, "ptb")
    finally:
        subprocess.run(["setxkbmap", "us"], check=True)


def test_yes_and_no_are_one_key_each(window):
    assert window.perform(YES_NO, Hand("key o")).value is True
    assert window.perform(YES_NO, Hand("key n")).value is False


def test_another_key_is_not_an_answer_to_yes_or_no(window):
    reply = window.perform(YES_NO, Hand("key y", "key o"))
    assert (reply.value, reply.rejected) == (True, ("y",))


def test_a_number_key_chooses(window):
    assert window.perform(CHOICE, Hand("key 2")).value == "sure"
    assert window.perform(CHOICE, Hand("key KP_1")).value == "guess"


def test_the_space_bar_goes_on_and_other_keys_do_not(window):
    reply = window.perform(Instruct(text="Read."), Hand("key a Return", "key space"))
    assert reply.value is None
    assert reply.response_time_s > 0


def test_exploring_lasts_at_least_its_minimum(window):
    reply = window.perform(
        Explore(text="Stroke.", minimum_s=0.6), Hand("key space", *["key space"] * 40)
    )
    assert reply.response_time_s >= 0.6


def test_exploring_ends_at_its_maximum_by_itself(window):
    reply = window.perform(Explore(text="Stroke.", maximum_s=0.3), lambda: None)
    assert reply.timed_out
    assert reply.response_time_s is None


def test_a_break_lasts_at_least_its_minimum(window):
    step = Rest(text="Relax.", done=3, total=28, minimum_s=0.5)
    assert window.perform(step, Hand(*["key space"] * 40)).response_time_s >= 0.5


def test_a_question_ends_when_its_time_is_up(window):
    step = Ask(name="x", question=NumberQuestion(prompt="Quick!"), time_limit_s=0.4)
    reply = window.perform(step, Hand("key 5"))
    assert reply.timed_out
    assert reply.value is None
    assert reply.response_time_s is None


def test_escape_and_yes_stop_the_session(window):
    with pytest.raises(StopRequested):
        window.perform(NUMBER, Hand("key 1 Escape", "key o"))


def test_escape_and_no_come_back_to_what_was_typed(window):
    reply = window.perform(NUMBER, Hand("key 4 Escape", "key n", "key 2 Return"))
    assert reply.value == 42.0


def test_the_question_whether_to_stop_costs_no_time(window):
    step = Ask(name="x", question=NumberQuestion(prompt="Quick!"), time_limit_s=1.5)
    later_s = time.perf_counter() + 1.8
    hand = Hand("key Escape", "key n", "key 7 Return")
    hand._ready = lambda: len(hand._lines) != 2 or time.perf_counter() > later_s
    reply = window.perform(step, hand)
    assert reply.value == 7.0
    assert reply.response_time_s < 1.5


def test_what_watch_raises_passes_and_what_was_typed_is_offered_when_performed_anew(window):
    hand = Hand("key 8 x Return", "key 9 1 comma")

    class Faulted(Exception):
        pass

    def watch():
        hand()
        if hand.done:
            raise Faulted

    with pytest.raises(Faulted):
        window.perform(NUMBER, watch)
    assert window.unfinished == Unfinished(entry="91,", rejected=("8x",))
    window.perform(Explore(text="Stroke again.", maximum_s=0.1), lambda: None)
    window.unfinished = Unfinished(entry="91,", rejected=("8x",))  # as the session hands it back
    reply = window.perform(NUMBER, Hand("key BackSpace 5 Return"))
    assert (reply.value, reply.rejected) == (915.0, ("8x",))
    assert window.perform(NUMBER, Hand("key 5 Return")).value == 5.0


def clicks(window, step, *presses):
    """Return where to click, in pixels of the screen, for what is drawn of a step."""
    drawn = screen_for(step, window._texts).scene(1.0)
    unit = window.display._unit
    handle = window.display.handle
    left, top = handle.get_location()
    for label in presses:
        area = next(a for a in drawn if isinstance(a, scene.Area) and a.presses == label)
        x = left + handle.width / 2 + area.x * unit
        y = top + handle.height / 2 - area.y * unit
        yield f"mousemove {round(x)} {round(y)} click 1"


def test_a_number_is_entered_on_the_pad_by_the_mouse(window, monkeypatch):
    monkeypatch.setattr(window, "_texts", {**window._texts, "window.touch": "yes"})
    keys = clicks(window, NUMBER, "4", "2", ERASE, ",", "5", ENTER)
    reply = window.perform(NUMBER, Hand(*keys))
    assert (reply.value, reply.rejected) == (4.5, ())
    assert reply.time_source == "window"
    read = Instruct(text="Lisez.")
    assert window.perform(read, Hand(*clicks(window, read, " "))).value is None


def test_what_the_operator_types_is_no_key_of_the_participants(window):
    step = replace(NUMBER, by="operator", time_limit_s=1.5)
    hand = Hand("key 5 Return", "key Escape", "key n")
    reply = window.perform(step, hand)
    assert (reply.value, reply.timed_out) == (None, True)
    shown = [item.content for item in window.display._shown if hasattr(item, "content")]
    assert "Dites votre nombre à voix haute." in shown


def test_one_of_many_answers_is_clicked_or_reached_by_arrow_keys_or_number(window):
    options = tuple((f"c{n}", f"mot {n}") for n in range(1, 21))
    step = Ask(name="many", question=ChoiceQuestion(prompt="?", options=options))
    clicked = clicks(window, step, f"{CLEAR}3", ENTER)
    assert window.perform(step, Hand(*clicked)).value == "c3"
    assert window.perform(step, Hand("key Down Down Down Up Return")).value == "c2"
    assert window.perform(step, Hand("key Down", "click 5", "key KP_Enter")).value == "c2"
    reply = window.perform(step, Hand("key KP_4 KP_2 KP_Enter", "key KP_1 KP_7 KP_Enter"))
    assert (reply.value, reply.rejected) == ("c17", ("42",))


def test_watch_is_called_at_every_frame(window):
    calls = []
    window.perform(
        Explore(text="Stroke.", maximum_s=0.5), lambda: calls.append(time.perf_counter())
    )
    gaps = [after - before for before, after in itertools.pairwise(calls)]
    assert len(calls) > 5
    assert max(gaps) < 0.4


def test_a_key_held_from_before_answers_nothing(window):
    window.perform(Explore(text="Stroke.", maximum_s=0.3), Hand("keydown o"))
    assert window._keyboard.held
    released = threading.Timer(0.9, subprocess.run, [["xdotool", "keyup", "o"]])
    released.start()
    # One key may still be swallowed as typed before the question was shown.
    hand = Hand("key n", "key n", "key n", ready=lambda: not window._keyboard.held)
    reply = window.perform(YES_NO, hand)
    released.join()
    assert (reply.value, reply.rejected) == (False, ())
    assert reply.onset_s > 0


def test_what_was_typed_before_a_question_is_no_answer_to_it(window):
    subprocess.run(["xdotool", "key", "8", "8", "Return"], check=True)
    assert window.perform(NUMBER, Hand("key 3 Return")).value == 3.0


def test_two_hundred_fast_keys_all_arrive_in_order(window):
    text = "0123456789" * 20
    reply = window.perform(TEXT, Hand(f"type --delay 5 {text}", "key Return"))
    assert reply.value == text


def test_response_times_come_from_the_key_s_own_stamp(window):
    reply = window.perform(NUMBER, Hand("key 5 Return"))
    assert reply.time_source == "ptb"


def test_a_scripted_key_takes_the_same_path_and_says_where_its_time_is_from(window):
    typed = iter(["", *"12,5\r"])  # the first call comes before the first frame

    def watch():
        window.display.handle.dispatch_event("on_text", next(typed))

    reply = window.perform(NUMBER, watch)
    assert (reply.value, reply.time_source) == (12.5, "window")


def test_holding_lasts_until_told(window):
    frames = iter(range(100))
    window.hold("One moment.", lambda: next(frames) >= 5)
    assert next(frames) == 6


def test_lost_keyboard_focus_is_noticed_and_comes_back_with_a_click(window):
    from pyglet.libs.x11 import xlib  # noqa: PLC0415  opens the display

    handle, shown = window.display.handle, []
    assert window.focused
    subprocess.run(["xdotool", "mousemove", "640", "400"], check=True)
    nobody = 0
    xlib.XSetInputFocus(handle._x_display, nobody, xlib.RevertToParent, xlib.CurrentTime)
    assert not window.focused
    window.perform(
        Explore(text="Stroke.", maximum_s=0.2), lambda: shown.extend(window.display._shown)
    )
    assert any("Le clavier n'est pas actif" in getattr(item, "content", "") for item in shown)
    window.perform(Explore(text="Stroke.", maximum_s=0.3), Hand("click 1"))
    assert window.focused


def test_a_screen_that_does_not_exist_is_refused_with_those_there_are(display):
    participant = PsychoPyWindow(texts=load_texts("en"), clock=SystemClock(), pilot=False, screen=3)
    with pytest.raises(UserError, match=r"screen 3: .* 0 \(1280 x 800\)"), participant:
        pass


def test_without_a_display_the_remedy_is_named(display, monkeypatch):
    monkeypatch.delenv("DISPLAY")
    participant = PsychoPyWindow(texts=load_texts("en"), clock=SystemClock(), pilot=False)
    with pytest.raises(UserError, match="xvfb-run"), participant:
        pass
