"""What the screens show and when they end, without a window."""

from dataclasses import replace

import pytest

from slipscale.experiments.languages.texts import languages, load_texts
from slipscale.experiments.participants.psychopy_window.keyboard import Key, claim
from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.participants.psychopy_window.waiting import Stopping
from slipscale.experiments.participants.psychopy_window.window import hand_over
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.questions.text import TextQuestion
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.replies import BACK, Reply
from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.screens.entry import CLEAR, ENTER, ERASE
from slipscale.experiments.steps.steps import Ask, Explore, Instruct, Rest

TEXTS = load_texts("en")
NUMBER = Ask(name="x", question=NumberQuestion(prompt="How slippery?"), time_limit_s=10.0)
YES_NO = Ask(name="x", question=YesNoQuestion(prompt="Different?"))


def words(shown):
    """Return all that a scene says."""
    return " | ".join(item.content for item in shown if isinstance(item, scene.Text))


def filled(shown):
    """Return the filled fraction of a scene's bar."""
    track, done = (item for item in shown if isinstance(item, scene.Box))
    return done.width / track.width


@pytest.mark.parametrize(
    "elapsed_s, said", [(0.0, "another 5 s"), (4.2, "another 1 s"), (5.0, "space")]
)
def test_exploring_says_how_long_it_lasts_at_least(elapsed_s, said):
    screen = screen_for(Explore(text="Stroke.", minimum_s=5.0), TEXTS)
    assert said in words(screen.scene(elapsed_s))


def test_the_space_bar_works_from_the_minimum_on():
    screen = screen_for(Explore(text="Stroke.", minimum_s=5.0), TEXTS)
    assert screen.press(" ", 4.99) is None
    assert screen.press(" ", 5.0) == Reply()


def test_the_countdown_runs_from_full_to_empty():
    screen = screen_for(Explore(text="Stroke.", maximum_s=10.0), TEXTS)
    assert filled(screen.scene(0.0)) == 1.0
    assert filled(screen.scene(7.5)) == 0.25
    assert "3 s left" in words(screen.scene(7.5))
    assert screen.expire(9.99) is None
    assert screen.expire(10.0) == Reply(timed_out=True)


def test_without_a_maximum_nothing_counts_down():
    screen = screen_for(Explore(text="Stroke."), TEXTS)
    assert "left" not in words(screen.scene(100.0))
    assert screen.expire(1e6) is None


def test_a_break_shows_the_progress_and_the_time_it_lasts():
    screen = screen_for(Rest(text="Relax.", done=7, total=28, minimum_s=30.0), TEXTS)
    assert "7 of 28" in words(screen.scene(1.0))
    assert "29 s" in words(screen.scene(1.0))
    assert filled(screen.scene(1.0)) == 0.25


def test_an_answer_given_in_time_counts_and_a_late_one_does_not():
    screen = screen_for(NUMBER, TEXTS)
    screen.press("7", 9.0)
    assert screen.press("\r", 10.0) is None
    assert screen.press("\r", 9.99) == Reply(value=7.0)


def test_a_wrong_entry_is_explained_until_the_next_key():
    screen = screen_for(NUMBER, TEXTS)
    for character in "7a\r":
        screen.press(character, 1.0)
    assert "“7a” is not a number" in words(screen.scene(1.0))
    assert screen.rejected == ["7a"]
    screen.press("7", 1.0)
    assert "not a number" not in words(screen.scene(1.0))


def test_what_is_typed_is_shown():
    screen = screen_for(NUMBER, TEXTS)
    for character in "12,5":
        screen.press(character, 1.0)
    assert "12,5" in words(screen.scene(1.0))
    screen.erase()
    assert "12,5" not in words(screen.scene(1.0))


def test_a_choice_shows_every_option_beside_its_key():
    options = (("a", "a guess"), ("b", "certain"))
    screen = screen_for(Ask(name="x", question=ChoiceQuestion(prompt="?", options=options)), TEXTS)
    assert "1 | a guess | 2 | certain" in words(screen.scene(0.0))


TOUCH = {**TEXTS, "window.touch": "yes"}
MANY = Ask(
    name="x",
    question=ChoiceQuestion(prompt="?", options=tuple((f"c{n}", f"word {n}") for n in range(40))),
)


def touched(screen, *labels):
    """Touch what presses each of these; return how the screen ended."""
    outcome = None
    for label in labels:
        areas = [a for a in screen.scene(1.0) if isinstance(a, scene.Area) and a.presses == label]
        pressed = scene.pressed_at(screen.scene(1.0), areas[0].x, areas[0].y)
        assert pressed == label
        for character in pressed:
            key = Key("character", character, 0.0)
            outcome = hand_over(key, screen, 1.0)
    return outcome


def test_every_key_of_the_number_pad_enters_what_it_shows():
    screen = screen_for(NUMBER, TOUCH)
    assert touched(screen, *"1234567890.5") is None
    assert screen.typed == "1234567890.5"
    assert touched(screen, ERASE, ERASE, ENTER) == Reply(value=1234567890.0)


def test_the_decimal_sign_of_the_number_pad_is_the_languages():
    french = {**load_texts("fr"), "window.touch": "yes"}
    screen = screen_for(NUMBER, french)
    assert touched(screen, "2", ",", "5", ENTER) == Reply(value=2.5)


def test_on_a_touch_screen_all_is_answered_by_touch_and_by_keys_alike():
    assert touched(screen_for(YES_NO, TOUCH), "y").value is True
    assert touched(screen_for(Instruct(text="Read."), TOUCH), " ") == Reply()
    assert touched(screen_for(Rest(text="Relax.", done=1, total=2), TOUCH), " ") == Reply()
    options = (("a", "a guess"), ("b", "certain"))
    few = Ask(name="x", question=ChoiceQuestion(prompt="?", options=options))
    assert touched(screen_for(few, TOUCH), "2").value == "b"
    assert screen_for(YES_NO, TOUCH).press("n", 1.0).value is False


def test_without_a_touch_screen_a_click_answers_nothing_but_a_long_list():
    for step in (NUMBER, YES_NO, Instruct(text="Read."), Explore(text="Stroke.")):
        areas = [a for a in screen_for(step, TEXTS).scene(1.0) if isinstance(a, scene.Area)]
        assert areas == []
    assert touched(screen_for(MANY, TEXTS), f"{CLEAR}3", ENTER).value == "c2"


def test_a_touch_beside_every_key_presses_nothing():
    assert scene.pressed_at(screen_for(NUMBER, TOUCH).scene(1.0), 0.6, 0.45) == ""


def test_a_key_to_go_on_is_drawn_when_it_works():
    screen = screen_for(Explore(text="Stroke.", minimum_s=5.0), TOUCH)
    drawn = [
        any(isinstance(item, scene.Area) for item in screen.scene(elapsed_s))
        for elapsed_s in (1.0, 6.0)
    ]
    assert drawn == [False, True]


@pytest.mark.parametrize("place", range(40))
def test_a_long_list_shows_the_answer_that_is_moved_to(place):
    screen = screen_for(MANY, TEXTS)
    screen.move(-1)
    for _ in range(place):
        screen.move(-1)
    shown = screen.scene(1.0)
    assert f"word {place}" in words(shown).split(" | ")
    assert screen.press(ENTER, 1.0).value == f"c{place}"


def test_a_held_arrow_key_moves_on_and_a_held_enter_answers_nothing():
    screen = screen_for(MANY, TEXTS)
    for _ in range(3):
        hand_over(Key("turn", "", 0.0, repeated=True, notches=-1), screen, 1.0)
    assert hand_over(Key("character", ENTER, 0.0, repeated=True), screen, 1.0) is None
    assert hand_over(Key("character", ENTER, 0.0), screen, 1.0).value == "c2"


@pytest.mark.parametrize("language", languages())
def test_the_keys_shown_are_the_keys_that_work(language):
    texts = load_texts(language)
    for screen in (screen_for(YES_NO, texts), Stopping(texts)):
        caps = [t.content for t in screen.scene(0.0) if isinstance(t, scene.Text) and t.bold]
        assert [screen.press(cap, 0.0).value for cap in caps] == [True, False]


@pytest.mark.parametrize("language", languages())
@pytest.mark.parametrize(
    "step",
    [
        Instruct(title="T", text="A text.\n\nOf two paragraphs."),
        Explore(text="Stroke.", minimum_s=3, maximum_s=9),
        Rest(text="Relax.", done=0, total=0, minimum_s=3),
        NUMBER,
        YES_NO,
        Ask(name="x", question=TextQuestion(prompt="What?")),
        MANY,
        replace(NUMBER, back=True),
    ],
)
@pytest.mark.parametrize("touch", ["no", "yes"])
def test_every_screen_fits_the_design_area_in_every_language(step, language, touch):
    texts = {**load_texts(language), "window.touch": touch}
    for elapsed_s in (0.0, 2.5, 9.0):
        for item in screen_for(step, texts).scene(elapsed_s):
            assert abs(item.y) <= 0.5
            assert abs(item.x) <= 0.65


@pytest.mark.parametrize("touch", ["no", "yes"])
def test_backspace_in_an_empty_field_returns_to_the_question_before(touch):
    texts = {**TEXTS, "window.touch": touch}
    erase = Key("erase", "", 1.0)
    assert hand_over(erase, screen_for(NUMBER, texts), 1.0) is None  # nothing is before it
    screen = screen_for(replace(NUMBER, back=True), texts)
    screen.press("7", 1.0)
    assert hand_over(erase, screen, 1.0) is None
    assert hand_over(replace(erase, repeated=True), screen, 1.0) is None  # held since the digit
    assert hand_over(erase, screen, 1.0) == Reply(value=BACK)
    said = TEXTS["window.back_touch" if touch == "yes" else "window.back"]
    assert said in [item.content for item in screen.scene(0.0) if isinstance(item, scene.Text)]


def test_a_fast_typist_s_presses_keep_their_own_stamps():
    assert claim(2, [1.003, 1.009], last_poll_s=1.0, poll_s=1.016) == [1.003, 1.009]


def test_a_press_made_elsewhere_long_ago_is_not_taken_for_this_one():
    assert claim(1, [0.2, 1.003], last_poll_s=1.0, poll_s=1.016) == [1.003]


def test_a_stamp_from_the_future_is_left_for_its_own_key():
    assert claim(1, [1.003, 1.030], last_poll_s=1.0, poll_s=1.016) == [1.003]


def test_where_a_stamp_is_missing_none_is_guessed():
    assert claim(2, [1.003], last_poll_s=1.0, poll_s=1.016) == []
    assert claim(1, [], last_poll_s=1.0, poll_s=1.016) == []


def test_a_held_key_neither_answers_nor_hands_in_an_entry():
    yes = Key("character", "y", 1.0, repeated=True)
    assert hand_over(yes, screen_for(YES_NO, TEXTS), 1.0) is None
    number = screen_for(NUMBER, TEXTS)
    hand_over(Key("character", "7", 1.0, repeated=True), number, 1.0)
    assert hand_over(Key("character", "\r", 1.0, repeated=True), number, 1.0) is None
    assert hand_over(Key("character", "\r", 1.0), number, 1.0) == Reply(value=7.0)


def test_a_key_from_before_the_screen_is_no_answer_to_it():
    screen = screen_for(YES_NO, TEXTS)
    assert hand_over(Key("character", "y", 1.0), screen, -0.001) is None
    assert hand_over(Key("character", "y", 1.0), screen, 0.001) == Reply(value=True)
