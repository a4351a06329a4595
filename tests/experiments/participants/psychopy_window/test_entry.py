import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.languages.texts import languages, load_texts
from experiments.participants.psychopy_window.entry import (
    ENTER,
    Accepted,
    KeyEntry,
    Refused,
    TypedEntry,
    entry_for,
    judge_number,
)
from experiments.protocols.steps import (
    ChoiceQuestion,
    NumberQuestion,
    TextQuestion,
    WholeNumberQuestion,
    YesNoQuestion,
)
from faults import UserError

NUMBER = NumberQuestion(prompt="How slippery?")
TEXT = TextQuestion(prompt="What?", max_length=5)
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
    assert judge_number(typed) == Accepted(value)


@pytest.mark.parametrize(
    "typed, reason",
    [
        ("", "empty"), ("   ", "empty"), ("abc", "not_a_number"), ("1e3", "not_a_number"),
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
    assert judge_number("0") == Accepted(0.0)
    assert judge_number("0", positive=True).reason == "window.not_positive"
    assert judge_number("0.01", positive=True) == Accepted(0.01)


def test_no_entry_yields_a_negative_zero():
    assert math.copysign(1.0, judge_number("-0,0").value) == 1.0


@given(st.decimals(min_value=0, max_value=10**9, places=2))
def test_every_number_with_two_decimals_survives_typing_with_point_and_comma(value):
    assert judge_number(f"{value:f}") == Accepted(float(value))
    assert judge_number(f"{value:f}".replace(".", ",")) == Accepted(float(value))


@given(st.text(max_size=30))
def test_whatever_is_typed_is_either_a_finite_answer_or_explained(typed):
    verdict = judge_number(typed)
    if isinstance(verdict, Accepted):
        assert math.isfinite(verdict.value)
        assert verdict.value >= 0
    else:
        assert verdict.entry == typed
        for language in languages():
            assert load_texts(language)[verdict.reason].format(**verdict.blanks)


def test_the_last_character_is_taken_back():
    entry = TypedEntry(NUMBER)
    type_in(entry, "125")
    entry.erase()
    entry.press(",")
    assert type_in(entry, "5\r") == Accepted(12.5)


def test_nothing_is_taken_back_from_nothing():
    entry = TypedEntry(NUMBER)
    entry.erase()
    assert entry.content == ""


def test_a_refused_entry_leaves_an_empty_line():
    entry = TypedEntry(NUMBER)
    assert type_in(entry, "7a\r") == Refused("7a", "window.not_a_number", {"entry": "7a"})
    assert entry.content == ""


@given(st.text(st.characters(codec="utf-8", exclude_categories=["C", "Z"]), min_size=1, max_size=5))
def test_free_text_is_kept_word_for_word(words):
    entry = TypedEntry(TEXT)
    assert type_in(entry, words + ENTER) == Accepted(words)


def test_free_text_that_is_blank_is_asked_for_again():
    assert type_in(TypedEntry(TEXT), "  \r") == Refused("  ", "window.empty")


def test_text_beyond_the_room_there_is_is_said_and_what_was_typed_stays():
    entry = TypedEntry(TEXT)
    assert type_in(entry, "éàçùôx") == Refused("", "window.full")
    assert entry.content == "éàçùô"


def test_control_characters_are_no_text():
    entry = TypedEntry(TEXT)
    type_in(entry, "a\t\x1b\x7fb")
    assert entry.content == "ab"


@pytest.mark.parametrize("language, yes, no", [("en", "y", "n"), ("fr", "o", "n")])
def test_yes_and_no_are_the_language_s_own_keys_in_either_case(language, yes, no):
    question = YesNoQuestion(prompt="Different?")
    for key, value in ((yes, True), (yes.upper(), True), (no, False), (no.upper(), False)):
        assert entry_for(question, load_texts(language)).press(key) == Accepted(value)


def test_another_key_is_refused_with_the_keys_there_are():
    verdict = entry_for(YesNoQuestion(prompt="Different?"), TEXTS).press("x")
    assert verdict == Refused("x", "window.other_key", {"keys": "y, n"})


@pytest.mark.parametrize("key, code", [("1", "guess"), ("2", "sure"), ("é", "sure")])
def test_a_number_key_chooses_also_unshifted_on_a_french_keyboard(key, code):
    question = ChoiceQuestion(prompt="?", options=(("guess", "a guess"), ("sure", "sure")))
    assert entry_for(question, TEXTS).press(key) == Accepted(code)


@pytest.mark.parametrize("key", ["0", "3", "a", "ç", ENTER])
def test_a_number_without_an_option_chooses_nothing(key):
    question = ChoiceQuestion(prompt="?", options=(("guess", "a guess"), ("sure", "sure")))
    assert isinstance(entry_for(question, TEXTS).press(key), Refused)


@pytest.mark.parametrize("count", [0, 10])
def test_a_choice_without_a_number_key_for_each_option_is_refused(count):
    question = ChoiceQuestion(prompt="?", options=tuple((str(n), "") for n in range(count)))
    with pytest.raises(UserError, match=f"{count} options, expected 1 to 9"):
        entry_for(question, TEXTS)


def test_a_key_entry_has_nothing_to_take_back():
    entry = KeyEntry({"y": True})
    entry.erase()
    assert entry.press("y") == Accepted(value=True)


AGE = WholeNumberQuestion(prompt="How old?", minimum=18, maximum=99)


@pytest.mark.parametrize("typed, value", [("18", 18.0), ("99", 99.0), (" 034 ", 34.0)])
def test_a_whole_number_within_its_bounds_is_accepted(typed, value):
    assert type_in(TypedEntry(AGE), typed + ENTER) == Accepted(value)


@pytest.mark.parametrize(
    "typed", ["17", "100", "34,5", "34.0", "-34", "abc", "\u0663\u0664", "9" * 20, "1e2"]
)
def test_another_entry_is_refused_with_the_bounds(typed):
    refused = type_in(TypedEntry(AGE), typed + ENTER)
    assert refused == Refused(
        typed, "window.out_of_bounds", {"entry": typed, "minimum": "18", "maximum": "99"}
    )
    for language in languages():
        assert "99" in load_texts(language)[refused.reason].format(**refused.blanks)


def test_an_empty_whole_number_is_asked_for_again():
    assert type_in(TypedEntry(AGE), ENTER).reason == "window.empty"
