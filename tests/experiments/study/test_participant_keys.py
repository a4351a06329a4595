"""A laboratory's own keys: one hand on the plate, the other on a keypad, a box or a pedal."""

import pytest

from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.steps import Ask, Explore, Instruct, Rest
from slipscale.experiments.study.file import parse_study, study_text
from slipscale.faults import UserError

TEXT = study_text("biet2007")
KEYPAD = '\n[keys]\ngo_on = "enter"\nyes = "+"\nno = "-"\n'


@pytest.fixture
def texts(plan):
    return lambda keys="", language="en": plan(text=TEXT + keys, language=language).texts()


def shown(screen):
    return " ".join(part.content for part in screen.scene(0.0) if hasattr(part, "content"))


STEPS = [
    Instruct(text="Read."),
    Instruct(text="The end.", last=True),
    Explore(text="Stroke."),
    Rest(text="Rest.", done=1, total=2),
]


@pytest.mark.parametrize("step", STEPS)
def test_the_space_bar_goes_on_where_nothing_is_said(texts, step):
    screen = screen_for(step, texts())
    assert "the space bar" in shown(screen)
    assert screen.press("\r", 1.0) is None
    assert screen.press(" ", 1.0)


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("language, name", [("en", "Enter"), ("fr", "Entrée")])
def test_a_keypads_enter_goes_on_and_is_named(texts, step, language, name):
    screen = screen_for(step, texts(KEYPAD, language))
    assert name in shown(screen)
    assert screen.press(" ", 1.0) is None
    assert screen.press("\r", 1.0)


def test_a_pedal_is_named_by_what_it_sends(texts):
    screen = screen_for(STEPS[0], texts('\n[keys]\ngo_on = "b"\n'))
    assert "Press B to continue" in shown(screen)
    assert screen.press("B", 1.0)


def test_yes_and_no_are_the_keypads_and_shown(texts):
    question = Ask(name="felt", question=YesNoQuestion(prompt="?"))
    screen = screen_for(question, texts(KEYPAD))
    assert {"+", "-"} <= set(shown(screen).split())
    assert screen.press("y", 1.0) is None
    assert screen.press("+", 1.0).value is True
    assert screen_for(question, texts(KEYPAD)).press("-", 1.0).value is False


@pytest.mark.parametrize(
    "keys",
    [
        'go_on = "spacebar"',
        'go_on = ""',
        'go_on = "\\t"',
        "go_on = 1",
        'yes = "1"',
        'yes = "1"\nno = "1"',
        'yes = "n"\nno = "N"',
        'yes = "12"\nno = "3"',
        'yes = " "\nno = "3"',
        'escape = "x"',
        'again = "go"',
        'go_on = "x"\nagain = "X"',
    ],
)
def test_keys_that_no_screen_could_hear_are_faults(keys):
    with pytest.raises(UserError, match="keys"):
        parse_study(f"{TEXT}\n[keys]\n{keys}\n", "s")


def test_a_studys_own_texts_do_not_move_the_key(texts):
    own = '\n[texts.en.window]\ngo_on_key = "q"\npress_space = "Tap the pad."\n'
    screen = screen_for(STEPS[0], texts(own))
    assert "Tap the pad." in shown(screen)
    assert screen.press(" ", 1.0)


def test_a_touch_screen_is_said_once_and_keys_still_work(texts):
    screen = screen_for(STEPS[0], texts("\n[keys]\ntouch = true\n", "fr"))
    assert "Continuer" in shown(screen)
    assert screen.press(" ", 1.0)
    with pytest.raises(UserError, match=r"keys\.touch: expected true or false"):
        parse_study(TEXT + '\n[keys]\ntouch = "yes"\n', "mine.toml")


def test_the_key_that_asks_to_feel_again_is_never_the_one_that_goes_on(texts):
    assert texts("")["window.again_key"] == "r"
    assert texts('[keys]\ngo_on = "R"\n')["window.again_key"] == "a"
    assert texts('[keys]\nagain = "5"\n')["window.again_key"] == "5"
