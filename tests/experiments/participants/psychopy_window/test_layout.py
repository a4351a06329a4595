"""Scenes that cannot be read are found without a window."""

from typing import get_args

import pytest

from slipscale.experiments.languages.texts import load_texts
from slipscale.experiments.participants.psychopy_window.layout import contrast, faults, lay
from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.running.study_commands import validate
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.questions.visual_analogue import VisualAnalogueQuestion
from slipscale.experiments.steps.screens.scene import COLOURS, Box, Text, Theme
from slipscale.experiments.steps.steps import Ask
from slipscale.experiments.study.file import shipped_studies
from slipscale.faults import UserError

LONG = "Please say how often you touch smooth things with your bare finger. " * 4


def test_letters_are_as_wide_and_high_as_the_window_draws_them():
    """The numbers are those of the window itself, 1280 x 800, in heights of the screen."""
    one = lay(Text(content="How slippery is this surface?", y=0.2, size=0.06, width=1.2))
    assert one.right - one.left == pytest.approx(0.7925, rel=0.02)
    many = lay(Text(content="word " * 60, y=0.0, size=0.042, width=1.15))
    assert many.right - many.left == pytest.approx(1.125, rel=0.03)
    assert many.top - many.bottom == pytest.approx(0.345, rel=0.06)
    assert many.fits


def test_a_prompt_that_does_not_fit_at_its_smallest_size_is_named():
    question = ChoiceQuestion(prompt=LONG, options=(("a", "often"), ("b", "never")))
    (fault,) = faults(screen_for(Ask(name="x", question=question), load_texts("en")).scene(0.0))
    assert fault.startswith("'Please say how often you touch smooth")
    assert fault.endswith("is too long for its place on the screen")


def test_answers_that_run_into_each_other_are_named():
    options = tuple((str(n), f"{n} {LONG}") for n in range(3))
    question = ChoiceQuestion(prompt="?", options=options)
    told = list(faults(screen_for(Ask(name="x", question=question), load_texts("en")).scene(0.0)))
    assert any(each.endswith("overlap") for each in told)


def test_letters_too_faint_on_what_lies_behind_them_are_named(monkeypatch):
    monkeypatch.setitem(COLOURS["dark"], "quiet", (90, 92, 95))
    on_key = Box(x=0, y=0, width=1, height=0.1, colour="accent")
    faint = Text(content="Press", y=0.3, colour="quiet")
    told = list(faults((on_key, Text(content="Clear", y=0.0, colour="ground"), faint)))
    assert told == ["'Press': its contrast is 2.2 to 1, expected at least 4.5 to 1"]


@pytest.mark.parametrize("language", ["en", "fr"])
@pytest.mark.parametrize("lines", [1, 2, 3])
def test_the_countdown_of_a_line_scale_is_clear_of_the_question(language, lines):
    prompt = " ".join(["Quelle est la force du frottement que vous sentez ?"] * lines)
    question = VisualAnalogueQuestion(
        prompt=prompt,
        left="faible",
        right="forte",
        resolution=1,
        key_step=1,
        start=50,
        start_shown=True,
    )
    step = Ask(name="x", question=question, time_limit_s=4.0)
    assert list(faults(screen_for(step, load_texts(language)).scene(0.0))) == []


@pytest.mark.parametrize(
    "words, font", [("كيف", "Noto Sans Arabic"), ("滑りますか", "Noto Sans CJK, Noto Sans CJK JP")]
)
def test_letters_that_the_font_lacks_are_named_with_a_font_that_has_them(words, font):
    (fault,) = faults((Text(content=words, y=0.0),))
    assert f"(fonts that contain these letters: {font})" in fault


STUDY = """name = "mine"
title = "Mine"
amplitudes_um_pp = [0.0, 1.2]
[[about_you]]
name = "touching"
prompt = {{ en = "{en}", fr = "{fr}" }}
options = ["often", "never"]
[[tasks]]
protocol = "magnitude_estimation"
"""


@pytest.mark.parametrize("en, fr, language", [(LONG, "?", "en"), ("?", LONG, "fr")])
def test_validate_names_what_cannot_be_read_in_any_language(tmp_path, en, fr, language):
    file = tmp_path / "mine.toml"
    file.write_text(STUDY.format(en=en, fr=fr), encoding="utf-8")
    with pytest.raises(
        UserError, match=f"(?s)cannot be shown properly.*{language}: 'Please say how often"
    ):
        validate(str(file))


@pytest.mark.parametrize("name", shipped_studies())
def test_every_screen_of_the_shipped_studies_can_be_read(name):
    assert "no fault" in validate(name)


@pytest.mark.parametrize("theme", get_args(Theme))
def test_every_text_of_a_theme_is_dark_or_light_enough_on_both_of_its_grounds(theme):
    for behind in ("ground", "field"):
        for letters in ("text", "quiet"):
            assert contrast(letters, behind, theme) >= 4.5, (letters, behind)
    assert contrast("accent", "ground", theme) >= 3  # WCAG 2.2, 1.4.11
