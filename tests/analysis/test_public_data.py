"""Public data sets, each beside R's own figures; `tests/data/foreign/make.R` makes both."""

from pathlib import Path

import pandas as pd
import pytest

from analysis.pipeline import analyse
from analysis.reading.load import load
from analysis.reading.mapping import parse_mapping

FOREIGN = Path(__file__).parents[1] / "data" / "foreign"
R = pd.read_csv(FOREIGN / "r_figures.csv", index_col="table", skipinitialspace=True)
#: Table -> participant, stimulus, unit, response, group.
TABLES = {
    "sleepstudy": ("Subject", "Days", "d", "Reaction", None),
    "orthodont": ("Subject", "age", "a", "distance", "Sex"),
    "orange": ("Tree", "age", "d", "circumference", None),
    "co2": ("Plant", "conc", "mL/L", "uptake", "Treatment"),
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
