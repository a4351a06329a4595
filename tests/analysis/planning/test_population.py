"""Table III of the paper stands in three places; they say the same."""

import tomllib
from pathlib import Path

from analysis.published import biet2007
from experiments.participants.population import AMPLITUDE_UM_PP, MEAN_SENSATION, SD_SENSATION

ROWS = biet2007.TABLE3


def test_the_simulated_population_has_the_published_means_and_spreads():
    assert tuple(float(row.amplitude_um_pp) for row in ROWS) == AMPLITUDE_UM_PP
    assert tuple(float(row.mean) for row in ROWS) == MEAN_SENSATION
    assert tuple(float(row.standard_deviation) for row in ROWS) == SD_SENSATION


def test_the_table_to_be_reconstructed_is_the_published_one():
    text = Path(biet2007.__file__).with_name("biet2007_table3.toml").read_text(encoding="utf-8")
    columns = tomllib.loads(text)["column"]
    assert [(c["mean"], c["sd"], c["maximum_deviation"]) for c in columns] == [
        (row.mean, row.standard_deviation, row.maximum_deviation) for row in ROWS
    ]
    assert {c["n"] for c in columns} == {biet2007.PARTICIPANTS}
