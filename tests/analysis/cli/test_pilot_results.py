"""A pilot of every shipped study prints its chief result."""

import re

import pytest

from slipscale import commands
from slipscale.analysis.reporting.terminal import print_answers
from slipscale.experiments.study.file import shipped_studies

#: Study -> what its result begins with, and has a number after it.
RESULTS = {
    "biet2007": r"exponents of participants' power functions of amplitude averaged \d",
    "biet2008": r"Constant stimuli around 5 mm \(constantstimuli\): .* Weber fraction \.\d",
    "constant_stimuli": r"Difference threshold at 1\.2 µm \(constantstimuli\): \d",
    "detection_threshold": r"Detection threshold \(detectionthreshold\): \d",
    "difference_threshold": r"Difference threshold at 1\.2 µm \(differencethreshold\): \d",
    "isleyen2020": r"force light against firm: geometric means in a ratio of \d",
    "magnitude_production": r"Magnitude production .* an exponent of \d",
    "matching": r"0\.8 µm \(peak to peak\) was matched by \d",
    "paired_comparison": r"to the most slippery, with scale values: .*\d",
    "ratio_to_standard": r"power functions of amplitude averaged \d",
    "saleem2020": r"power functions of spatial period averaged −\d",
    "textures_demo": r"The two amplitudes did not differ reliably \(Wilcoxon's test, p = \.\d",
    "visual_analogue_scale": r"mean places on the line from 0 \(left\) to 100 were \d",
}


def test_every_shipped_study_has_its_result():
    assert sorted(RESULTS) == shipped_studies()


@pytest.mark.parametrize("study, result", RESULTS.items(), ids=RESULTS)
def test_the_chief_result_of_every_shipped_study_is_printed(
    shipped_pilot, monkeypatch, capsys, study, result
):
    monkeypatch.setenv("COLUMNS", "1000")
    print_answers(shipped_pilot(study)[1])
    assert re.search(result, capsys.readouterr().out)


def test_a_pilot_prints_results_on_standard_output_and_progress_on_standard_error(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "1000")
    assert commands.main(["pilot", "matching", "--participants", "3", "--seed", "1"]) == 0
    said = capsys.readouterr()
    assert re.search(RESULTS["matching"], said.out)
    assert "simulated participants" not in said.out
    assert "simulated participants" in said.err
