"""Tables in Python: a DataFrame with the same meaning as a file."""

import numpy as np
import pandas as pd
import pytest

import slipscale
from slipscale.faults import UserError

pytestmark = pytest.mark.usefixtures("without_models")

RNG = np.random.default_rng(2)
FRAME = pd.DataFrame(
    {"who": who, "level": level, "loud": level**0.5 * float(RNG.lognormal(0, 0.1))}
    for who in "abcd"
    for level in (0.1 + 0.2, 1.125, 4, 16)
    for _ in range(2)
)
MEANING = {"participant": "who", "stimulus": "level:mm", "response": "loud"}


def test_a_data_frame_is_the_table_with_its_cells(tmp_path):
    FRAME.to_csv(tmp_path / "data.csv", index=False)
    of_file = slipscale.load(tmp_path / "data.csv", decimal=".", **MEANING)
    of_frame = slipscale.load(FRAME, **MEANING)
    assert of_frame.estimates.equals(of_file.estimates)
    assert of_frame.quantity == of_file.quantity
    assert of_frame.sources[0].sha256 == of_file.sources[0].sha256
    assert len(of_frame) == len(FRAME)
    assert of_frame["estimate"].tolist() == FRAME["loud"].tolist()
    assert of_frame.head(3)["level"].tolist() == [0.3, 0.3, 1.125]


def test_levels_and_rows_are_stated_as_in_python():
    wide = FRAME.pivot_table("loud", "who", "level").set_axis(["p1", "p2", "p3", "p4"], axis=1)
    found = slipscale.load(wide, participant="who", levels={"p1": 0.3, "p2": 1.125, "p4": 16})
    assert sorted(found["level"].unique()) == [0.3, 1.125, 16]
    only = slipscale.load(FRAME, only={"who": ["a", "b"]}, **MEANING)
    assert only.people == {"a", "b"}


def test_an_analysis_saves_tables_figures_and_the_report(tmp_path):
    analysis = slipscale.analyse(FRAME, **MEANING)
    assert analysis.save(tmp_path / "out").name == "report.html"
    assert {f"{name}.csv" for name in analysis.tables} <= {
        path.name for path in (tmp_path / "out").iterdir()
    }
    assert analysis.plot("fig15").axes
    with pytest.raises(UserError, match="no figure 'fig'; expected one of fig15, "):
        analysis.plot("fig")


@pytest.mark.parametrize(
    "meaning, said",
    [
        ({"people": "who"}, "people: unknown; expected one of participant, stimulus"),
        ({"participant": "who"}, "needs --stimulus and --response"),
        ({**MEANING, "response": "loudness"}, "DataFrame: no column loudness; .*Nearest: loud"),
        ({}, "DataFrame: no column participant_id"),
    ],
)
def test_what_does_not_fit_is_one_sentence(meaning, said):
    with pytest.raises(UserError, match=said):
        slipscale.load(FRAME, **meaning)
