"""A pilot of every shipped study prints its chief result."""

import re
from pathlib import Path

import pytest

from slipscale import commands
from slipscale.analysis.reporting.terminal import print_answers
from slipscale.experiments.study.file import shipped_studies

#: Study -> what its result begins with, and has a number after it.
RESULTS = {
    "biet2007": r"exponent of participants' power functions of amplitude was \d",
    "constant_stimuli": r"Difference threshold at 1\.2 µm: \d",
    "detection_threshold": r"Detection threshold: \d",
    "difference_threshold": r"Difference threshold at 1\.2 µm: \d",
    "magnitude_production": r"Magnitude production, .* an exponent of \d",
    "matching": r"0\.8 µm \(peak to peak\) was matched by \d",
    "meyer2015": r"d' by the differencing model was (at least )?\d",
    "paired_comparison": r"to the most slippery, scale values \(Bradley-Terry model, natural log "
    r"odds of a choice, mean 0\) were −?\d\.\d\d \(1 µm\), ",
    "ratio_to_standard": r"power functions of amplitude was \d",
    "textures_demo": r"between the two amplitudes \(Wilcoxon signed-rank test, p = \.\d",
    "visual_analogue_scale": r"mean positions on the line from 0 \(left\) to 100 \(right\) were \d",
}


# Pilots of published experiments take minutes: their results are in this table.
TABLE = Path(__file__).parents[3] / "docs" / "tutorials" / "published-studies.toml"
STUDIES = [name for name in shipped_studies() if f"[{name}]" not in TABLE.read_text("utf-8")]


def test_every_shipped_study_has_its_result():
    assert sorted(RESULTS) == sorted([*STUDIES, "meyer2015"])


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
