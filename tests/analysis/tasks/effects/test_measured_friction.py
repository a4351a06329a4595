"""Ratings against measured friction: known lines are found again, and what has none is named."""

import json
import math

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from slipscale.analysis.pipeline import analyse
from slipscale.analysis.preprocessing.log_transform import prepare
from slipscale.analysis.reporting.files import write_analysis
from slipscale.analysis.reporting.multiplicity import multiplicity
from slipscale.analysis.statistics.measured_friction import measured_friction
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.effects.friction.declaration import sentence
from slipscale.experiments.study.analysis_choices import AnalysisChoices

pytestmark = pytest.mark.usefixtures("without_models")

COEFFICIENTS = [0.8, 0.75, 0.6, 0.4, 0.78, 0.62]
AMPLITUDES = [0.0, 0.5, 1.2, 2.3, 0.5, 1.2]


def trials(slopes, *, noise=0.0, coefficients=COEFFICIENTS, seed=1):
    """Return trials of people whose logarithm falls with friction, each by their slope."""
    rng = np.random.default_rng(seed)
    rows = [
        {
            "participant_id": f"sub-{who:02d}", "session": "", "run": "1", "trial": trial,
            "level": amplitude, "friction_coefficient": coefficient,
            "estimate": math.exp(3 + slope * coefficient + noise * rng.normal()),
        }
        for who, slope in enumerate(slopes, start=1)
        for trial, (amplitude, coefficient) in enumerate(
            zip(AMPLITUDES, coefficients, strict=True), start=1
        )
    ]  # fmt: skip
    frame = pd.DataFrame(rows).astype({"participant_id": "category"})
    return frame.assign(normalised=frame["estimate"], block="")


def found_in(frame):
    return measured_friction(prepare(frame, AnalysisChoices()))


def test_known_slopes_are_found_again_and_averaged_over_participants():
    slopes = [-2.0, -3.0, -5.5, -4.0]
    found = found_in(trials(slopes))
    assert [line.slope for line in found.participants] == pytest.approx(slopes)
    assert [line.correlation for line in found.participants] == pytest.approx([-1.0] * 4)
    expected = stats.ttest_1samp(slopes, 0.0)
    assert found.slope.mean == pytest.approx(np.mean(slopes))
    assert tuple(found.slope.interval) == pytest.approx(tuple(expected.confidence_interval(0.95)))


def test_a_participants_intervals_are_scipys():
    frame = trials([-3.0, -4.0, -2.0], noise=0.4)
    own = frame[frame["participant_id"] == "sub-01"]
    line = found_in(frame).participants[0]
    x, y = own["friction_coefficient"], np.log(own["estimate"])
    assert tuple(line.correlation_interval) == pytest.approx(
        tuple(stats.pearsonr(x, y).confidence_interval())
    )
    regression = stats.linregress(x, y)
    half = stats.t.ppf(0.975, 4) * regression.stderr
    assert tuple(line.slope_interval) == pytest.approx(
        (regression.slope - half, regression.slope + half)
    )


def test_the_mean_slope_covers_the_true_one_at_its_level():
    inside = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        low, high = found_in(trials(rng.normal(-4, 1, 8), noise=0.3, seed=seed)).slope.interval
        inside += low <= -4 <= high
    assert inside >= 33  # 0.95 of 40, less four standard errors


def test_participants_without_a_line_are_named():
    frame = trials([-3.0, -4.0, -2.0, -3.0])
    frame.loc[frame["participant_id"] == "sub-02", "friction_coefficient"] = 0.7
    frame.loc[
        (frame["participant_id"] == "sub-04") & (frame["trial"] > 3), "friction_coefficient"
    ] = np.nan
    found = found_in(frame)
    assert found.left_out == ("sub-02", "sub-04")
    assert isinstance(found.slope, NotComputed)
    assert "Ratings were not compared with measured friction" in sentence(found, 0.4)


def test_nothing_is_said_where_no_friction_was_measured():
    frame = trials([-3.0, -4.0, -2.0])
    assert found_in(frame.drop(columns="friction_coefficient")) is None
    assert found_in(frame.assign(friction_coefficient=np.nan)) is None
    assert measured_friction(None) is None


@pytest.mark.parametrize("spread,step", [(0.4, 0.1), (0.084, 0.01)])
def test_the_sentence_says_what_less_friction_within_the_measured_range_does_to_the_rating(
    spread, step
):
    said = sentence(found_in(trials([-2.0, -3.0, -4.0])), spread)
    assert "was −3.00" in said
    assert "t(2) = −5.20, p = .035)" in said
    assert f"by {step:g}, which is within the measured range (median {spread:.3g}" in said
    assert f"corresponds to a factor of {math.exp(3 * step):.2f}" in said


def test_report_figure_and_json_are_written_where_friction_was_measured(tmp_path):
    table = tmp_path / "tidy.csv"
    frame = trials([-2.0, -3.0, -5.5, -4.0], noise=0.1)
    frame = frame.rename(columns={"level": "amplitude_um_pp"})
    columns = ["participant_id", "trial", "amplitude_um_pp", "estimate", "friction_coefficient"]
    frame[columns].to_csv(table, index=False)
    analysis = analyse(table)
    report = write_analysis(analysis, tmp_path / "with").read_text(encoding="utf-8")
    assert "Ratings against measured friction" in report
    assert "reducing friction by 0.1, which is within the measured range (median 0.400)" in report
    listed = multiplicity(analysis.inference, "ranks", 0.95).families
    assert [each.tests for each in listed if "measured friction" in each.name] == [1]
    written = json.loads((tmp_path / "with" / "friction.json").read_text())
    assert len(written["participants"]) == 4
    assert (tmp_path / "with" / "rating_friction.svg").is_file()
    frame[columns[:-1]].to_csv(table, index=False)
    assert analyse(table).friction is None
