"""The attribute that is judged, in prompts, columns and quantity."""

import pytest

from slipscale.analysis.statistics.repeated_measures.omnibus import page_trend_of
from slipscale.analysis.writing.verdicts import page_sentence
from slipscale.experiments.dataset.schema import columns
from slipscale.experiments.languages.texts import languages, shipped_texts
from slipscale.experiments.participants.simulated_people.bare_run import bare_run
from slipscale.experiments.participants.simulated_people.growth import people_for
from slipscale.experiments.protocol_parts.registry import load_protocol
from slipscale.experiments.steps.replies import Adjusted, Reply
from slipscale.experiments.steps.steps import Ask
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
    assert run.study.quantity_notes()["quantity"]["judged"] == "roughness"


def test_words_of_an_attribute_that_is_not_listed_are_the_studys(plan):
    text = 'attribute = "brightness"\n' + BIET + BRIGHT
    texts = {language: plan(text, language=language).texts() for language in languages()}
    assert texts["en"]["constant_stimuli.yes_no.title"] == "Is the second one more bright?"
    assert texts["fr"]["magnitude_estimation.title"] == "Est-ce brillant ?"
    with pytest.raises(UserError, match=r"expected one of .*roughness.*\[attribute_words.en\]"):
        parse_study('attribute = "brightness"\n' + BIET, "bright.toml")


FALLING = """
name = "falling"
title = "Roughness falls with the period"
attribute = "roughness"
attribute_falls = true
vary = "spatial_period_mm"
spatial_periods_mm = [2.0, 4.0, 8.0]
stimulus = { waveform = "square", mean_um_pp = 1.0, depth_um_pp = 1.0, finger_speed_mm_s = 50.0 }
[[tasks]]
protocol = "difference_threshold"
tracks = 1
most_trials = 4
catch_trials = 4
practice = 0
standard_mm = 4.0
start_mm = 2.0
lowest_mm = 0.2
highest_mm = 4.0
[[tasks]]
protocol = "constant_stimuli"
label = "choice"
practice = 0
repetitions = 5
standard_mm = 4.0
[[tasks]]
protocol = "constant_stimuli"
label = "yesno"
question = "yes_no"
practice = 0
repetitions = 5
standard_mm = 4.0
[[tasks]]
protocol = "matching"
practice = 0
references_mm = [4.0]
lowest_mm = 2.0
highest_mm = 8.0
step_mm = 0.2
nearest_start_mm = 0.4
furthest_start_mm = 1.0
[[tasks]]
protocol = "descending_difference"
"""


def test_where_the_attribute_falls_questions_seek_less_and_people_answer_so(plan):
    run = plan(FALLING, seed=2)
    texts, more = run.texts(), []
    assert texts["difference_threshold.more.question"] == "Which one was less rough?"
    assert texts["difference_threshold.less.question"] == "Which one was more rough?"
    assert texts["constant_stimuli.yes_no.question"].startswith("Was the second less rough")
    easy, matched, reports = [], [], set()
    for step, answer, _ in bare_run(run, people_for(run.study)):
        value = answer.value if isinstance(answer, Reply) else None
        if isinstance(answer, Adjusted):
            matched.append(value)
        if not isinstance(step, Ask) or not step.trial:
            continue
        given = step.trial.factors
        if step.name == "verbal_report":
            reports.add(value)
        if given.get("target_interval") and given["catch"]:
            easy.append(value == given["target_interval"])
        if step.trial.task in ("choice", "yesno") and given["comparison_level"] != 4.0:
            chosen = value if isinstance(value, bool) else value == given["comparison_interval"]
            more.append(chosen == (given["comparison_level"] > 4.0))
    assert len(easy) == 4
    assert all(easy)
    assert (len(more), sum(more)) == (20, pytest.approx(19, abs=1))
    assert all(3.0 < level < 5.4 for level in matched)
    assert reports
    assert all("more rough" in each for each in reports)  # levels go down
    assert run.study.quantity_notes()["quantity"]["falls"] is True
    assert run.study.quantity.more == "less rough"


def test_trends_of_an_attribute_that_falls_are_tested_downwards():
    import numpy as np
    import pandas as pd

    quantity = parse_study(FALLING, "falling.toml").quantity
    table = pd.DataFrame(np.arange(12.0).reshape(4, 3)[:, ::-1] + 1, columns=[2.0, 4.0, 8.0])
    falls = page_trend_of(table, 0, quantity)
    assert falls.p < 0.01
    assert page_trend_of(table, 0).p > 0.9
    assert page_sentence("Estimates", falls, 0.95, "period", quantity).startswith("Estimates fell")
