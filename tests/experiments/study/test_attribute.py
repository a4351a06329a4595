"""The attribute that is judged, in prompts, columns and quantity."""

import pytest

from slipscale.experiments.dataset.schema import columns
from slipscale.experiments.languages.texts import languages, shipped_texts
from slipscale.experiments.protocols.registry import load_protocol
from slipscale.experiments.study.file import parse_study, study_text
from slipscale.faults import UserError
from slipscale.stimuli.attributes import ATTRIBUTES

BIET = study_text("biet2007")
BRIGHT = """
[attribute_words.en]
adjective = "bright"
noun = "brightness"
[attribute_words.fr]
adjective = "brillante"
noun = "brillance"
masculine = "brillant"
plural = "brillantes"
"""


@pytest.mark.parametrize("language", languages())
@pytest.mark.parametrize("attribute", ATTRIBUTES)
def test_every_listed_attribute_has_words_and_leaves_no_place_open(attribute, language):
    words = ATTRIBUTES[attribute][language]
    texts = shipped_texts(language, words)
    assert not [text for text in texts.values() if "<" in text]
    assert words.adjective in texts["difference_threshold.more.question"]
    assert texts.keys() == shipped_texts(language).keys()


def test_the_attribute_is_in_prompts_columns_and_titles(plan):
    run = plan('attribute = "roughness"\n' + BIET)
    assert run.texts()["magnitude_estimation.estimate"] == "How rough is this surface?"
    estimation, quantity = load_protocol("magnitude_estimation"), run.study.quantity
    assert estimation.titled(quantity) == "Magnitude estimation of roughness"
    described = columns(estimation, quantity=quantity)
    assert described["estimate"].description.startswith("Magnitude estimate of roughness")
    assert "amplitude_um_pp" in described
    assert run.study.quantity_notes("quantity")["quantity"]["judged"] == "roughness"


def test_words_of_an_attribute_that_is_not_listed_are_the_studys(plan):
    text = 'attribute = "brightness"\n' + BIET + BRIGHT
    texts = {language: plan(text, language=language).texts() for language in languages()}
    assert texts["en"]["constant_stimuli.yes_no.title"] == "Is the second one more bright?"
    assert texts["fr"]["magnitude_estimation.title"] == "Est-ce brillant ?"
    with pytest.raises(UserError, match=r"expected one of .*roughness.*\[attribute_words.en\]"):
        parse_study('attribute = "brightness"\n' + BIET, "bright.toml")
