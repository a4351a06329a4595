"""The real window, driven by synthetic key presses as a person's hand would drive it."""

from __future__ import annotations

import shutil
import subprocess
import sys
import time
from dataclasses import replace

import pytest

from slipscale.experiments.languages.texts import load_texts
from slipscale.experiments.participants.base import StopRequested, Unfinished
from slipscale.experiments.participants.psychopy_window import PsychoPyWindow
from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.questions.text import TextQuestion
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.screens.entry import CLEAR, ENTER, ERASE
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


PATIENCE_S = 300.0


class HandsClock(SystemClock):
    """The computer's clock; or, while it is stopped, one that only the hand advances."""

    stopped_s = None

    def now(self):
        return super().now() if self.stopped_s is None else self.stopped_s


@pytest.fixture(scope="module")
def window(display):
    with PsychoPyWindow(
        texts=load_texts("fr"), clock=HandsClock(), pilot=True, full_screen=False
    ) as opened:
        yield opened


@pytest.fixture
def stopped(window, monkeypatch):
    """Stop the window's clock, so that no frame and no key takes time; return it."""
    monkeypatch.setattr(window._keyboard, "_stamps", None)  # they are on the computer's clock
    monkeypatch.setattr(window._clock, "stopped_s", window._clock.now())
    return window._clock


PRESSING = []


class Hand:
    """Presses keys, each line once the window has drawn a few more frames.

    A number instead of a line advances the stopped ``clock`` by so many seconds.
    """

    def __init__(self, *lines, clock=None):
        self._lines = list(lines)
        self._clock = clock
        self._frames = 0
        self._busy = None
        self._gives_up_s = time.perf_counter() + PATIENCE_S

    def __call__(self):
        """Serve as the session's watch: called at every frame."""
        assert time.perf_counter() < self._gives_up_s, "the window did not come to an end"
        self._frames += 1
        # The hand before this one may not have released its key yet.
        if any(each.poll() is None for each in PRESSING):
            self._frames = 0
        elif self._lines and self._frames > 3:
            line = self._lines.pop(0)
            if isinstance(line, float):
                self._clock.stopped_s += line
            else:
                self._busy = subprocess.Popen(["xdotool", *line.split()])
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
        assert window.perform(NUMBER, Hand("key 1 2 comma 5 Return")).value == 12.5
        stamped(window)
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


WAITING = [
    Explore(text="Stroke.", minimum_s=0.6),
    Rest(text="Relax.", done=3, total=28, minimum_s=0.6),
]


@pytest.mark.parametrize("step", WAITING, ids=["exploring", "a break"])
def test_exploring_and_a_break_last_at_least_their_minimum(window, stopped, step):
    hand = Hand("key space", 0.5, "key space", 0.25, "key space", clock=stopped)
    assert window.perform(step, hand).response_time_s == pytest.approx(0.75)


def test_exploring_ends_at_its_maximum_by_itself(window, stopped):
    reply = window.perform(Explore(text="Stroke.", maximum_s=0.3), Hand(0.5, clock=stopped))
    assert reply.timed_out
    assert reply.response_time_s is None


def test_a_question_ends_when_its_time_is_up(window, stopped):
    step = Ask(name="x", question=NumberQuestion(prompt="Quick!"), time_limit_s=0.4)
    reply = window.perform(step, Hand("key 5", 0.5, clock=stopped))
    assert reply.timed_out
    assert reply.value is None
    assert reply.response_time_s is None


def test_escape_and_yes_stop_the_session(window):
    with pytest.raises(StopRequested):
        window.perform(NUMBER, Hand("key 1 Escape", "key o"))


def test_escape_and_no_come_back_to_what_was_typed(window):
    reply = window.perform(NUMBER, Hand("key 4 Escape", "key n", "key 2 Return"))
    assert reply.value == 42.0


def test_the_question_whether_to_stop_costs_no_time(window, stopped):
    step = Ask(name="x", question=NumberQuestion(prompt="Quick!"), time_limit_s=1.5)
    hand = Hand(0.5, "key Escape", 1.8, "key n", 0.25, "key 7 Return", clock=stopped)
    reply = window.perform(step, hand)
    assert reply.value == 7.0
    assert reply.response_time_s == pytest.approx(0.75)


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
    window.perform(Explore(text="Stroke again."), Hand("key space"))
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


def test_what_the_operator_types_is_no_key_of_the_participants(window, stopped):
    step = replace(NUMBER, by="operator", time_limit_s=1.5)
    hand = Hand("key 5 Return", "key Escape", "key n", 2.0, clock=stopped)
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


def test_watch_is_called_at_every_frame(window, monkeypatch):
    happened = []
    flip = window.display.flip
    monkeypatch.setattr(window.display, "flip", lambda: happened.append("frame") or flip())
    hand = Hand("key space")
    window.perform(Explore(text="Stroke."), lambda: happened.append("watch") or hand())
    assert len(happened) > 5
    assert {*happened[::2]} == {"watch"}
    assert {*happened[1::2]} == {"frame"}


def test_a_key_held_from_before_answers_nothing(window, stopped):
    window.perform(Explore(text="Stroke.", maximum_s=0.3), Hand("keydown o", 0.5, clock=stopped))
    assert window._keyboard.held
    # While it is held, it repeats: characters without a press, every half second.
    repeating = iter([0.5] * 4)
    hand = Hand("keyup o", "key n", clock=stopped)

    def watch():
        if (later_s := next(repeating, None)) is None:
            hand()
            return
        window.display.handle.dispatch_event("on_text", "o")
        stopped.stopped_s += later_s

    reply = window.perform(YES_NO, watch)
    assert (reply.value, reply.rejected) == (False, ())


def test_what_was_typed_before_a_question_is_no_answer_to_it(window):
    subprocess.run(["xdotool", "key", "8", "8", "Return"], check=True)
    assert window.perform(NUMBER, Hand("key 3 Return")).value == 3.0


def test_two_hundred_fast_keys_all_arrive_in_order(window):
    text = "0123456789" * 20
    reply = window.perform(TEXT, Hand(f"type --delay 5 {text}", "key Return"))
    assert reply.value == text


def stamped(window):
    """Answer until an answer has its key's own stamp: a busy machine can deliver stamps late."""
    end_s = time.perf_counter() + PATIENCE_S
    while window.perform(NUMBER, Hand("key 5 Return")).time_source != "ptb":
        assert time.perf_counter() < end_s, "no key is stamped"


def test_response_times_come_from_the_key_s_own_stamp(window):
    stamped(window)


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
    from pyglet.libs.x11 import xlib

    handle, shown = window.display.handle, []
    assert window.focused
    subprocess.run(["xdotool", "mousemove", "640", "400"], check=True)
    nobody = 0
    xlib.XSetInputFocus(handle._x_display, nobody, xlib.RevertToParent, xlib.CurrentTime)
    assert not window.focused
    hand = Hand("click 1", "key space")

    def watch():
        shown.extend(window.display._shown)
        hand()

    window.perform(Explore(text="Stroke."), watch)
    assert any("Le clavier n’est pas actif" in getattr(item, "content", "") for item in shown)
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
