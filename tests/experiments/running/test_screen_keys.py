"""Which texts a screen shows."""

import pytest

from slipscale.experiments.running.screen_check import every_screen
from slipscale.experiments.running.screen_keys import keyed_screens
from slipscale.experiments.steps.screens.scene import Text
from slipscale.experiments.study.file import read_study
from slipscale.experiments.study.run_plan import RunPlan

PROTOCOL = 'protocol = "descending_difference"'


def plan_of(name, language="en"):
    study, text = read_study(name)
    return RunPlan(
        study_name=name,
        study_text=text,
        participant="01",
        seed=study.seed,
        language=language,
        mode="participant",
    )


@pytest.mark.parametrize("name", ["biet2007", "matching", "visual_analogue_scale"])
def test_screens_are_those_of_the_session(name):
    plan = plan_of(name)
    found = list(keyed_screens(plan))
    assert [(s.task, s.step, s.scene, s.faults) for s in found] == [
        (s.task, s.step, s.scene, s.faults) for s in every_screen(plan)
    ]
    assert all(len(screen.keys) == len(screen.scene) for screen in found)


@pytest.mark.parametrize("language", ["en", "fr"])
def test_each_text_on_a_screen_has_its_key(language):
    plan = plan_of("biet2007", language)
    texts, welcome = plan.texts(), next(keyed_screens(plan))
    shown = [
        (item.content, keys)
        for item, keys in zip(welcome.scene, welcome.keys, strict=True)
        if isinstance(item, Text)
    ]
    assert shown[0] == (texts["session.welcome_title"], ("session.welcome_title",))
    assert [keys for _, keys in shown[1:]] == [
        ("session.welcome",),
        ("window.press_space", "window.key_space"),
    ]


def test_answers_in_a_list_have_the_key_of_the_list():
    text = read_study("biet2007")[1].replace(
        'protocol = "descending_difference"',
        'protocol = "descending_difference"\nconfidence = true',
    )
    screens = keyed_screens(replace_text(plan_of("biet2007"), text))
    keys = {key for screen in screens for each in screen.keys for key in each}
    assert {"descending_difference.confidence", "descending_difference.confidence_options"} <= keys


def replace_text(plan, text):
    return RunPlan(
        study_name=plan.study_name,
        study_text=text,
        participant="01",
        seed=plan.seed,
        language="en",
        mode="participant",
    )
