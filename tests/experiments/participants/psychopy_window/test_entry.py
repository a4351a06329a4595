import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.experiments.languages.texts import languages, load_texts
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.questions.comparison import ComparisonQuestion
from slipscale.experiments.steps.questions.number import NumberQuestion, judge_number
from slipscale.experiments.steps.questions.text import TextQuestion
from slipscale.experiments.steps.questions.whole_number import WholeNumberQuestion
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.screens.entry import (
    CLEAR,
    ENTER,
    KeyEntry,
    Refused,
)
from slipscale.faults import UserError

NUMBER = NumberQuestion(prompt="How slippery?")
TEXT = TextQuestion(prompt="What?", max_length=5)
AGE = WholeNumberQuestion(prompt="Age?", minimum=18, maximum=99)
TEXTS = load_texts("en")


def type_in(entry, characters):
    """Type characters; return what the last one led to."""
    verdict = None
    for character in characters:
        verdict = entry.press(character)
    return verdict


@pytest.mark.parametrize(
    "typed, value",
    [
        ("7", 7.0), ("12.5", 12.5), ("12,5", 12.5), (".5", 0.5), (",5", 0.5), ("3.", 3.0),
        (" 8 ", 8.0), ("+4", 4.0), ("007", 7.0), ("0", 0.0), ("-0", 0.0), ("0,125", 0.125),
        ("1234,5", 1234.5), ("12.125", 12.125),
    ],
)  # fmt: skip
def test_a_number_is_read_as_people_type_it(typed, value):
    assert judge_number(typed) == Reply(value=value)


@pytest.mark.parametrize(
    "typed, reason",
    [
        ("abc", "not_a_number"), ("1e3", "not_a_number"),
        ("nan", "not_a_number"), ("inf", "not_a_number"), ("1 000", "not_a_number"),
        ("1.2.3", "not_a_number"), ("1,2,3", "not_a_number"), (",", "not_a_number"),
        ("--1", "not_a_number"), ("5%", "not_a_number"), ("٣", "not_a_number"),
        ("0x10", "not_a_number"), ("1_000", "not_a_number"),
        ("1,000", "thousands"), ("12,345,678", "thousands"),
        ("-0.1", "too_small"), ("-5", "too_small"), ("9" * 400, "too_large"),
        ("12345678901234567890", "too_many_digits"), ("0.10000000000000001", "too_many_digits"),
    ],
)  # fmt: skip
def test_what_is_no_number_is_refused_with_its_reason(typed, reason):
    verdict = judge_number(typed)
    assert isinstance(verdict, Refused)
    assert verdict.reason == f"window.{reason}"
    assert verdict.entry == typed


def test_zero_is_an_answer_unless_a_positive_number_is_asked_for():
    assert judge_number("0") == Reply(value=0.0)
    assert judge_number("0", positive=True).reason == "window.not_positive"
    assert judge_number("0.01", positive=True) == Reply(value=0.01)


def test_no_entry_yields_a_negative_zero():
    assert math.copysign(1.0, judge_number("-0,0").value) == 1.0


@given(st.decimals(min_value=0, max_value=10**9, places=2))
def test_every_number_with_two_decimals_survives_typing_with_point_and_comma(value):
    assert judge_number(f"{value:f}") == Reply(value=float(value))
    assert judge_number(f"{value:f}".replace(".", ",")) == Reply(value=float(value))


@given(st.text(max_size=30))
def test_whatever_is_typed_is_either_a_finite_answer_or_explained(typed):
    verdict = judge_number(typed)
    if isinstance(verdict, Reply):
        assert math.isfinite(verdict.value)
        assert verdict.value >= 0
    else:
        assert verdict.entry == typed
        for language in languages():
            assert load_texts(language)[verdict.reason].format(**verdict.blanks)


def test_the_last_character_is_taken_back():
    entry = NUMBER.entry(TEXTS)
    type_in(entry, "125")
    entry.erase()
    entry.press(",")
    assert type_in(entry, "5\r") == Reply(value=12.5)


def test_nothing_is_taken_back_from_nothing():
    entry = NUMBER.entry(TEXTS)
    entry.erase()
    assert entry.content == ""


def test_a_refused_entry_leaves_an_empty_line():
    entry = NUMBER.entry(TEXTS)
    assert type_in(entry, "7a\r") == Refused("7a", "window.not_a_number", {"entry": "7a"})
    assert entry.content == ""


@given(st.text(st.characters(codec="utf-8", exclude_categories=["C", "Z"]), min_size=1, max_size=5))
def test_free_text_is_kept_word_for_word(words):
    entry = TEXT.entry(TEXTS)
    assert type_in(entry, words + ENTER) == Reply(value=words)


@pytest.mark.parametrize("question", [TEXT, NUMBER, AGE])
@pytest.mark.parametrize("typed", ["", "  "])
def test_a_blank_line_is_asked_for_again(question, typed):
    assert type_in(question.entry(TEXTS), f"{typed}\r") == Refused(typed, "window.empty")


def test_text_beyond_the_room_there_is_is_said_and_what_was_typed_stays():
    entry = TEXT.entry(TEXTS)
    assert type_in(entry, "éàçùôx") == Refused("", "window.full")
    assert entry.content == "éàçùô"


def test_control_characters_are_no_text():
    entry = TEXT.entry(TEXTS)
    type_in(entry, "a\t\x1b\x7fb")
    assert entry.content == "ab"


@pytest.mark.parametrize("language, yes, no", [("en", "y", "n"), ("fr", "o", "n")])
def test_yes_and_no_are_the_language_s_own_keys_in_either_case(language, yes, no):
    question = YesNoQuestion(prompt="Different?")
    for key, value in ((yes, True), (yes.upper(), True), (no, False), (no.upper(), False)):
        assert question.entry(load_texts(language)).press(key) == Reply(value=value)


def test_another_key_is_refused_with_the_keys_there_are():
    verdict = YesNoQuestion(prompt="Different?").entry(TEXTS).press("x")
    assert verdict == Refused("x", "window.other_key", {"keys": "y, n"})


@pytest.mark.parametrize("key, code", [("1", "guess"), ("2", "sure"), ("é", "sure")])
def test_a_number_key_chooses_also_unshifted_on_a_french_keyboard(key, code):
    question = ChoiceQuestion(prompt="?", options=(("guess", "a guess"), ("sure", "sure")))
    assert question.entry(TEXTS).press(key) == Reply(value=code)


@pytest.mark.parametrize("key", ["0", "3", "a", "ç", ENTER])
def test_a_number_without_an_option_chooses_nothing(key):
    question = ChoiceQuestion(prompt="?", options=(("guess", "a guess"), ("sure", "sure")))
    assert isinstance(question.entry(TEXTS).press(key), Refused)


@pytest.mark.parametrize(
    "question",
    [
        ChoiceQuestion(prompt="?", options=()),
        ComparisonQuestion(prompt="?", options=tuple(str(n) for n in range(10))),
    ],
)
def test_options_without_number_keys_are_refused(question):
    with pytest.raises(UserError, match=f"{len(question.options)} options, expected 1 to 9"):
        question.entry(TEXTS)


@pytest.fixture
def many():
    """Return the entry of a question with twelve answers, a to l."""
    options = tuple((letter, letter.upper()) for letter in "abcdefghijkl")
    return ChoiceQuestion(prompt="?", options=options).entry(TEXTS)


@pytest.mark.parametrize(
    "typed, code", [("1", "a"), ("12", "l"), ("02", "b"), ("é", "b"), (f"11{CLEAR}3", "c")]
)
def test_one_of_many_is_named_by_its_number_and_enter(many, typed, code):
    assert type_in(many, typed) is None
    assert many.press(ENTER) == Reply(value=code)


@pytest.mark.parametrize(
    "turns, code",
    [([-1], "a"), ([1], "l"), ([-1, -1], "b"), ([-1, -5, 1], "e"), ([-1, 1], "a"), ([-50], "l")],
)
def test_one_of_many_is_moved_to_with_the_arrow_keys_or_the_wheel(many, turns, code):
    for notches in turns:
        many.turn(notches)
    assert many.press(ENTER) == Reply(value=code)


@pytest.mark.parametrize("typed", ["0", "13", "99", "00"])
def test_a_number_that_none_of_many_has_is_refused_and_kept(many, typed):
    refused = type_in(many, typed + ENTER)
    assert (refused.entry, refused.reason) == (typed, "window.out_of_bounds")
    assert refused.blanks == {"entry": typed, "minimum": "1", "maximum": "12"}
    assert many.press(ENTER).reason == "window.empty"


@pytest.mark.parametrize("key", ["x", "+", "\u0663", " "])
def test_what_is_no_digit_leaves_the_number_of_one_of_many_as_it_is(many, key):
    many.press("1")
    assert many.press(key).entry == f"1{key}"
    assert many.press(ENTER) == Reply(value="a")
    many.press("2")
    assert many.press("3").entry == "123"
    many.erase()
    assert many.content == "1"


def test_a_key_entry_has_nothing_to_take_back():
    entry = KeyEntry({"y": True})
    entry.erase()
    assert entry.press("y") == Reply(value=True)


@pytest.mark.parametrize("typed, value", [("18", 18.0), ("99", 99.0), (" 034 ", 34.0)])
def test_a_whole_number_within_its_bounds_is_accepted(typed, value):
    assert type_in(AGE.entry(TEXTS), typed + ENTER) == Reply(value=value)


@pytest.mark.parametrize(
    "typed", ["17", "100", "34,5", "34.0", "-34", "abc", "\u0663\u0664", "9" * 20, "1e2"]
)
def test_another_entry_is_refused_with_the_bounds(typed):
    refused = type_in(AGE.entry(TEXTS), typed + ENTER)
    assert refused == Refused(
        typed, "window.out_of_bounds", {"entry": typed, "minimum": "18", "maximum": "99"}
    )
    for language in languages():
        assert "99" in load_texts(language)[refused.reason].format(**refused.blanks)
