"""The screen of a visual analogue scale, without a window."""

import pytest

from slipscale.experiments.languages.texts import languages, load_texts
from slipscale.experiments.participants.psychopy_window.keyboard import Key
from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.participants.psychopy_window.window import hand_over
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.questions.visual_analogue import (
    DONE,
    LINE_LENGTH,
    LINE_Y,
    VisualAnalogueQuestion,
)
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.steps import Ask

TEXTS = load_texts("en")


@pytest.fixture
def make():
    """Return a function that makes the screen of a line."""

    def make_screen(limit_s=None, texts=TEXTS, **about):
        question = VisualAnalogueQuestion(
            **{
                "prompt": "How slippery?",
                "left": "not at all",
                "right": "extremely",
                "resolution": 0.5,
                "key_step": 2.0,
                "start": 30.0,
                "start_shown": False,
                **about,
            }
        )
        return screen_for(Ask(name="rating", question=question, time_limit_s=limit_s), texts)

    return make_screen


def mark(screen):
    """Return where the mark is drawn, in hundredths of the line, or None."""
    found = [
        item
        for item in screen.scene(1.0)
        if isinstance(item, scene.Box) and (item.y, item.colour) == (LINE_Y, "accent")
    ]
    return round(100 * (found[0].x / LINE_LENGTH + 0.5), 6) if found else None


def words(screen):
    return " | ".join(item.content for item in screen.scene(1.0) if isinstance(item, scene.Text))


def click(screen, place, *, dragged=False, y=LINE_Y, at_s=1.0):
    return screen.point(LINE_LENGTH * (place / 100 - 0.5), y, at_s, dragged=dragged)


def test_the_line_is_empty_until_the_first_press_and_then_begins_at_its_start(make):
    screen = make()
    assert mark(screen) is None
    screen.move(1)
    assert mark(screen) == 32.0


def test_a_start_that_is_shown_is_no_answer_until_the_mark_was_put(make):
    screen = make(start_shown=True)
    assert mark(screen) == 30.0
    assert screen.press(" ", 1.0) is None
    assert "place the mark" in words(screen)
    screen.move(1)
    screen.move(-1)
    assert "place the mark" not in words(screen)
    assert screen.press(" ", 1.0) == Reply(value=30.0)


@pytest.mark.parametrize("key", [" ", "\r"])
def test_by_keys_alone_the_mark_is_moved_and_handed_in(make, key):
    screen = make()
    for kind, notches in (("move", 1), ("turn", 5), ("move", -1), ("turn", -5), ("move", 1)):
        assert hand_over(Key(kind, "", 0.0, notches=notches), screen, 1.0) is None
    assert hand_over(Key("character", key, 0.0), screen, 1.0) == Reply(value=32.0)


def test_a_click_puts_the_mark_to_the_nearest_place_and_one_below_hands_it_in(make):
    screen = make()
    assert click(screen, 61.3) is None
    assert mark(screen) == 61.5
    click(screen, 80.2, dragged=True)
    assert screen.point(0.0, DONE.y, 1.0, dragged=True) is None  # the hand slid there
    assert screen.point(0.0, DONE.y, 1.0, dragged=False) == Reply(value=80.0)


def test_a_click_elsewhere_is_none(make):
    screen = make()
    assert click(screen, 50.0, y=0.3) is None
    assert click(screen, 120.0) is None
    assert mark(screen) is None


@pytest.mark.parametrize("notches, place", [(1_000_000, 100.0), (-1_000_000, 0.0)])
def test_the_mark_stays_on_the_line(make, notches, place):
    screen = make()
    screen.move(notches)
    assert mark(screen) == place
    click(screen, 103.0 if notches > 0 else -3.0)
    assert mark(screen) == place


def test_every_place_reached_is_one_of_the_resolution_s(make):
    screen = make(resolution=0.1, key_step=0.1, start=0.0)
    for _ in range(3):
        screen.move(1)
    assert screen.press(" ", 1.0) == Reply(value=0.3)


def test_a_mark_put_too_late_is_none(make):
    screen = make(limit_s=5.0)
    screen.move(1)
    assert screen.press(" ", 5.0) is None
    assert screen.expire(5.0) == Reply(timed_out=True)
    assert screen.expire(4.99) is None


def test_after_an_interruption_the_mark_is_where_it_was(make):
    screen = make()
    assert screen.typed == ""
    screen.move(4)
    again = make()
    again.offer(screen.typed)
    assert mark(again) == mark(screen) == 38.0
    fresh = make()
    fresh.offer("")
    assert mark(fresh) is None


def test_a_mouse_is_needed_here_and_for_no_number(make):
    assert make().pointed
    assert not screen_for(Ask(name="x", question=NumberQuestion(prompt="?")), TEXTS).pointed


@pytest.mark.parametrize("language", languages())
def test_both_words_stand_at_their_ends(make, language):
    texts = load_texts(language)
    left = texts["visual_analogue_scale.left"]
    right = texts["visual_analogue_scale.right"]
    shown = make(texts=texts, left=left, right=right).scene(0.0)
    place = {item.content: item.x for item in shown if isinstance(item, scene.Text)}
    assert place[left] < -0.3 < 0.3 < place[right]
