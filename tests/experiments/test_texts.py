import re

import pytest

from experiments.texts import languages, load_texts
from faults import UserError


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
