"""A study of magnitude estimates and thresholds, from its tables to the report's section."""

import json

import pytest

from slipscale.analysis import json_form
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reporting.files import draw
from slipscale.analysis.reporting.page import render
from slipscale.analysis.tasks.exponent_and_weber.declaration import section_of
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.bare_dataset import write_simulated
from slipscale.experiments.running.pilot import pilot_plans

pytestmark = pytest.mark.usefixtures("without_simulated_fits")

STUDY = """
name = "both"
title = "Estimates and thresholds"
language = "en"
seed = 5
participants = 4
amplitudes_um_pp = [0.3, 0.6, 1.2, 2.0]
[plate]
tolerance = 0.01
tolerance_um_pp = 0.015
[[tasks]]
protocol = "magnitude_estimation"
[[tasks]]
protocol = "difference_threshold"
standard_um_pp = 1.2
tracks = 1
most_trials = 30
"""


def analysed(folder, participants):
    study = folder / "both.toml"
    study.write_text(STUDY, encoding="utf-8")
    people = Population(noise=5.0)
    plans = pilot_plans(
        str(study), participants=participants, seed=1, language=None, population=people
    )
    write_simulated(folder / "data", plans, people, sessions=False)
    return analyse(folder / "data")


@pytest.fixture(scope="module")
def analysis(tmp_path_factory):
    return analysed(tmp_path_factory.mktemp("both"), 4)


def test_both_stand_on_one_page_with_a_figure_and_a_plain_sentence(analysis):
    (found,) = analysis.inference.exponent_and_weber
    assert len(found.participants) == 4
    assert found.exponent.value == pytest.approx(analysis.inference.power_law.exponent)
    assert found.weber_fraction.value == pytest.approx(
        analysis.inference.thresholds[0].weber_fraction.value
    )
    figures = draw(analysis)
    assert "exponent_and_weber_differencethreshold" in figures
    section = section_of(analysis, {"exponent_and_weber_differencethreshold": "<svg></svg>"})
    page = " ".join(str(block) for block in section.blocks)
    assert section.gist[0].startswith("4 participants have both: the exponent is")
    assert "Exponents and Weber fractions of 4 participants" in page
    assert render(analysis, {}, {}).count("4 participants have both") == 1
    (written,) = json.loads(json_form.text(analysis.inference))["exponent_and_weber"]
    assert written["verdict"] == found.verdict
    assert written["participants"][0]["participant"] == "sub-01"


def test_two_people_are_too_few_and_the_section_says_so(tmp_path):
    section = section_of(analysed(tmp_path, 2), {})
    (said,) = section.blocks
    assert "were not compared: differencethreshold: too few participants with an exponent" in said
