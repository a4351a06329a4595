import re

import pytest

from slipscale.experiments.languages.texts import languages, load_texts
from slipscale.faults import UserError


@pytest.mark.parametrize("language", languages())
def test_every_language_has_the_same_texts_with_the_same_blanks(language):
    english, other = load_texts("en"), load_texts(language)
    assert other.keys() == english.keys()
    for key, text in english.items():
        assert set(re.findall(r"{\w+}", text)) == set(re.findall(r"{\w+}", other[key])), key


def test_a_study_replaces_a_text():
    texts = load_texts("en", {"magnitude_estimation": {"explore": "Stroke it twice."}})
    assert texts["magnitude_estimation.explore"] == "Stroke it twice."


def test_a_misspelt_text_is_refused_by_name():
    with pytest.raises(UserError, match=r"session\.wellcome"):
        load_texts("en", {"session": {"wellcome": "Hello"}})


def test_an_unknown_language_is_refused_with_the_known_ones():
    with pytest.raises(UserError, match="en, fr"):
        load_texts("tlh")


@pytest.mark.parametrize(
    "section, key, text",
    [
        ("magnitude_estimation", "explore", "{amplitude}"),
        ("magnitude_estimation", "standard", "{modulus:d}"),
        ("magnitude_estimation", "estimate", "50 % {"),
        ("window", "empty", "{}"),
        ("window", "yes_key", "n"),
        ("window", "yes_key", "yes"),
        ("window", "no_key", "1"),
        ("descending_difference", "confidence_options", ""),
        ("descending_difference", "confidence_options", "sure | sure"),
        ("descending_difference", "confidence_options", "0|1|2|3|4|5|6|7|8|9"),
    ],
)
def test_a_text_that_would_fail_in_a_session_is_refused_before_it(section, key, text):
    with pytest.raises(UserError, match=f"{section}.*{key}"):
        load_texts("en", {section: {key: text}})


def test_every_faulty_text_is_told_at_once():
    with pytest.raises(UserError, match=r"session\.rest.*window\.full.*yes_key"):
        load_texts("en", {"session": {"rest": "{x}"}, "window": {"full": "}", "yes_key": ""}})


def test_a_replacement_may_use_the_blanks_of_its_text():
    own = {"window": {"progress": "{total}: {done}"}}
    assert load_texts("en", own)["window.progress"].format(done=1, total=2) == "2: 1"


def test_one_key_for_yes_and_no_is_refused():
    with pytest.raises(UserError, match="two different letters"):
        load_texts("en", {"window": {"yes_key": "n"}})
