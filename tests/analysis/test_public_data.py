"""Public data sets, each beside R's own figures; `tests/data/foreign/README.md` tells of them."""

from pathlib import Path

import pandas as pd
import pytest

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.difference import yes_no
from slipscale.analysis.tasks.scales.paired_comparison_scale import bradley_terry

pytestmark = pytest.mark.usefixtures("without_models")

FOREIGN = Path(__file__).parents[1] / "data" / "foreign"
R = pd.read_csv(FOREIGN / "r_figures.csv", index_col="table", skipinitialspace=True)
#: Table -> participant, stimulus, unit, response, group.
TABLES = {
    "sleepstudy": ("Subject", "Days", "d", "Reaction", None),
    "orthodont": ("Subject", "age", "a", "distance", "Sex"),
    "orange": ("Tree", "age", "d", "circumference", None),
    "co2": ("Plant", "conc", "mL/L", "uptake", "Treatment"),
    "loudness": ("subject", "sound_pressure", "µPa", "length", None),
}
YES_NO = pd.read_csv(FOREIGN / "r_figures_yes_no.csv", index_col="table", skipinitialspace=True)
#: Table -> participant, stimulus, unit, run, rows to analyse.
ANSWERS = {
    "flashes": ("observer", "quanta", "", "run", {}),
    "contrast": ("observer", "contrast", "", None, {"context": "0"}),
    "hearing": ("child", "sound_pressure", "µPa", None, {}),
}


@pytest.mark.parametrize("name", TABLES)
def test_figures_are_r_s(name):
    who, stimulus, unit, response, group = TABLES[name]
    columns = {"participant": who, "stimulus": stimulus, "response": response}
    columns |= {"group": group} if group else {}
    found = parse_mapping({"columns": columns, "stimulus": {"unit": unit}}, name)
    path = FOREIGN / f"{name}.csv"
    data = load(path, found)
    assert len(data.estimates) == len(pd.read_csv(path))
    inference = analyse(data).inference
    expected = R.loc[name]
    assert len(data.people) == expected["participants"]
    assert inference.power_law.exponent == pytest.approx(expected["exponent"], rel=1e-9)
    assert tuple(inference.power_law.interval) == pytest.approx(
        (expected["low"], expected["high"]), rel=1e-9
    )
    assert inference.friedman.chi2 == pytest.approx(expected["friedman_chi2"], rel=1e-9)
    assert pytest.approx(expected["F"], rel=1e-8) == inference.rm_anova.F


@pytest.mark.parametrize("name", ANSWERS)
def test_figures_of_yes_and_no_are_r_s(name, monkeypatch):
    # Of each of 46 children: most of a minute, and R's figures have none.
    monkeypatch.setattr(yes_no, "own_thresholds", lambda *_: {})
    who, stimulus, unit, run, only = ANSWERS[name]
    columns = {"participant": who, "stimulus": stimulus, "answer": "answer"}
    columns |= {"run": run} if run else {}
    table = {"columns": columns, "stimulus": {"unit": unit}, "table": {"only": only}}
    found = analyse(load(FOREIGN / f"{name}.csv", parse_mapping(table, name)))
    answers, expected = found.dataset.differences, YES_NO.loc[name]
    assert len(answers) == expected["answers"]
    assert answers["difference_felt"].sum() == expected["yes"]
    difference = found.inference.difference
    assert difference.participants == expected["participants"]
    if name == "hearing":
        # Nor does R's geepack come to an end.
        assert difference.psychometric == NotComputed("the fit did not converge")
        return
    # The estimate of the correlation differs in geepack, by what it divides.
    curve = difference.psychometric
    assert curve.log_odds_per_unit == pytest.approx(expected["slope"], rel=1e-4)
    assert curve.intercept == pytest.approx(expected["intercept"], rel=1e-3)
    if name == "contrast":
        # 120 answers of a participant: a rule of few points over participants misses their peaks.
        largest = difference.signal_detection.by_size[-1]
        assert largest.d_prime == pytest.approx(expected["largest_d_prime"], rel=1e-4)
        assert largest.removed_level == 0.008


def test_a_scale_of_paired_comparisons_is_r_s():
    pairs = pd.read_csv(FOREIGN / "sound_fields.csv", dtype={"chosen": str, "other": str})
    expected = pd.read_csv(FOREIGN / "r_figures_pairs.csv", dtype={"field": str})
    counts = pairs.pivot_table(index="chosen", columns="other", values="times", fill_value=0)
    assert list(counts.index) == list(counts.columns) == list(expected["field"])
    scale = bradley_terry(counts.to_numpy())
    assert scale.values == pytest.approx(  # noqa: PD011 - no DataFrame
        expected["scale"].to_list(), abs=1e-7
    )
