"""Equivalence tests and Bayes factors: against R, pingouin, and what they promise."""

import json
from math import exp, log
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pingouin import bayesfactor_ttest

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.preprocessing.log_transform import prepare
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.analysis.statistics.equivalence import bayes_factor, equivalence
from slipscale.analysis.statistics.mean_over_participants import mean_over_participants
from slipscale.analysis.statistics.repeated_measures.pairwise import pairwise
from slipscale.analysis.tasks.estimation import sentences as apa
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.faults import UserError
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

pytestmark = pytest.mark.usefixtures("without_models")

HERE = Path(__file__).parents[2] / "data" / "r_reference"
R = json.loads((HERE / "comparisons.json").read_text())


def ready(frame, **choices):
    frame = frame.assign(session="", run="1")
    frame["participant_id"] = frame["participant_id"].astype("category")
    return prepare(frame, AnalysisChoices(**choices))


def reference(**choices):
    raw = pd.read_csv(HERE / "estimates.csv")
    names = {"participant": "participant_id", "amp": "level", "est": "normalised"}
    return ready(raw.rename(columns=names), **choices)


def nearly_equal(n=20, seed=3, ratio=1.0):
    """Two amplitudes whose estimates differ by a ratio, with a spread of 15 %."""
    rng = np.random.default_rng(seed)
    own = rng.normal(3, 0.5, n)[:, None] + rng.normal(0, 0.15, (n, 2)) + [0, log(ratio)]
    who, what = np.indices(own.shape)
    return pd.DataFrame(
        {
            "participant_id": [f"p{i:02d}" for i in who.ravel()],
            "level": np.array([1.0, 1.1])[what.ravel()],
            "normalised": np.exp(own.ravel()),
        }
    )


def test_two_one_sided_tests_are_r_s():
    found = pairwise(reference(equivalence_ratio=2.5))
    for pair, expected, holm in zip(found, R["tost"], R["tost_holm"], strict=True):
        same = pair.logs.equivalence
        assert same.p == pytest.approx(expected["p"], rel=1e-8)
        assert list(same.interval) == pytest.approx(expected["ci"], rel=1e-9)
        assert same.interval.confidence == pytest.approx(0.9)
        assert pair.logs.equivalence_p_holm == pytest.approx(holm, rel=1e-8)


@given(st.floats(-1, 1), st.floats(0.05, 1), st.integers(3, 40), st.floats(1.01, 4))
def test_the_interval_lies_within_the_bounds_exactly_where_the_test_is_significant(
    mean, sd, n, bound
):
    values = np.linspace(-1, 1, n)
    values = mean + sd * (values - values.mean()) / values.std(ddof=1)
    found = equivalence(mean_over_participants(values, 0.95), bound)
    low, high = found.interval
    inside = 1 / bound < low and high < bound
    assert inside == (found.p < 0.05)


@pytest.mark.parametrize("n", [3, 12, 100])
@pytest.mark.parametrize("t", [0.0, -0.7, 2.2, 12.0])
def test_the_bayes_factor_is_pingouin_s(t, n):
    assert bayes_factor(t, n) == pytest.approx(bayesfactor_ttest(t, n, paired=True), rel=1e-6)


def test_the_bayes_factor_of_very_large_t_grows_on_where_pingouin_s_integral_misses_its_peak():
    assert 6000 < bayes_factor(1e4, 3) < 8000
    assert bayes_factor(1e4, 3) < bayes_factor(1e5, 3) < bayes_factor(1e6, 3)
    assert bayes_factor(200, 4000) == float("inf")


def test_pairs_not_told_apart_become_equal_or_undecided():
    equal = pairwise(ready(nearly_equal()))
    sentence = apa.equivalence(equal, 0.95, PLATE_AMPLITUDE)
    assert sentence.startswith("Pairs that were equivalent: 1 and 1.1 µm, ratio")
    assert "neither" not in sentence
    assert "BF₀₁ = " in sentence
    undecided = apa.equivalence(pairwise(ready(nearly_equal(n=4))), 0.95, PLATE_AMPLITUDE)
    assert (
        "equivalent: none; pairs that neither differed nor were equivalent: 1 and 1.1 µm"
        in undecided
    )
    assert apa.equivalence(pairwise(ready(nearly_equal(ratio=2.0))), 0.95, PLATE_AMPLITUDE) is None


@pytest.mark.parametrize("factor, told", [(1e5, "< 0.01"), (1e-5, "> 100"), (0.25, "= 4.00")])
def test_a_decisive_bayes_factor_is_not_told_more_closely(factor, told):
    assert apa.bayes_of_none(factor) == told


def test_the_ratio_is_the_study_s_or_the_one_asked_for_and_the_report_says_so(dataset, page):
    folder = dataset(choices="equivalence_ratio = 1.5")
    assert analyse(folder).inference.pairwise[0].logs.equivalence.bound == 1.5
    asked = analyse(folder, equivalence_ratio=2.0)
    assert asked.inference.pairwise[0].logs.equivalence.bound == 2.0
    assert (
        "The frozen study sets equivalence_ratio = 1.5, but the analysis used 2.0."
        in asked.problems
    )
    assert "within a ratio of 0.5 to 2" in page(asked)
    with pytest.raises(UserError, match=r"equivalence ratio is 1; expected a number above 1"):
        analyse(folder, equivalence_ratio=1.0)


def test_a_foreign_table_declares_its_analysis_beside_its_columns(tmp_path):
    path = tmp_path / "data.csv"
    nearly_equal().rename(columns={"level": "amplitude_um_pp"}).to_csv(path, index=False)
    columns = {"participant": "participant_id", "stimulus": "amplitude_um_pp"}
    table = {"columns": columns | {"response": "normalised"}}
    mapping = parse_mapping(table | {"analysis": {"equivalence_ratio": 1.1}}, "here")
    data = load(path, mapping)
    assert (data.choices.equivalence_ratio, data.frozen) == (1.1, ("equivalence_ratio",))
    with pytest.raises(UserError, match=r"analysis\.equivalence_ratio"):
        parse_mapping(table | {"analysis": {"equivalence_ratio": 0.9}}, "here")


def test_equal_pairs_reach_the_answer_of_the_report(tmp_path, page):
    path = tmp_path / "data.csv"
    frame = nearly_equal().rename(columns={"level": "amplitude_um_pp", "normalised": "estimate"})
    pd.concat([frame, frame.assign(amplitude_um_pp=3.0, estimate=frame["estimate"] * 4)]).to_csv(
        path, index=False
    )
    found = analyse(path)
    assert exp(abs(log(found.inference.pairwise[0].logs.ratio))) < 1.25
    text = page(found)
    answer = text[text.index("<b>Answer.</b>") :].split("<b>Design.</b>")[0]
    assert "Pairs that were equivalent: 1 and 1.1" in answer
    assert "equivalent within the bound" in text
