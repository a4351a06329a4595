"""Rows of tables of other laboratories: their order, and which are omitted."""

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.preprocessing.data_warnings import absent
from slipscale.analysis.preprocessing.sessions import only_session
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.faults import UserError

pytestmark = pytest.mark.usefixtures("without_models")

COLUMNS = {"participant": "who", "stimulus": "level", "response": "loudness"}


def mapping(table=None, levels=None, **columns):
    columns = {name: column for name, column in (COLUMNS | columns).items() if column}
    return parse_mapping({"columns": columns, "table": table or {}, "levels": levels or {}}, "here")


def trials():
    """Blocks named in the order of two people's sessions; trial numbers restart in each."""
    return pd.DataFrame(
        {"who": who, "visit": visit, "part": part, "n": n, "level": n, "loudness": 10 * row + n}
        for row, (who, visit, part) in enumerate(
            (who, visit, part)
            for who, parts in (("p2", "ba"), ("p10", "ab"))
            for visit in (2, 10)
            for part in parts
        )
        for n in range(1, 12)
    )


def written(tmp_path, frame, name="data.csv"):
    frame.to_csv(tmp_path / name, index=False)
    return tmp_path / name


@pytest.mark.parametrize("own", [True, False])
def test_rows_are_analysed_in_the_order_of_their_trial_numbers(tmp_path, own):
    names = {"who": "participant_id", "level": "amplitude_um_pp", "loudness": "estimate"}
    names |= {"visit": "session", "part": "block", "n": "trial"}
    found = None if own else mapping(session="visit", block="part", trial="n")
    frame = trials().rename(columns=names if own else {})
    # Within a block, rows are in any order; the blocks of a run follow each other.
    mixed = frame.groupby(frame.index // 11).sample(frac=1, random_state=3)
    for sort in ("file", "reversed sessions"):
        table = mixed if sort == "file" else pd.concat([mixed[11 * 4 :], mixed[: 11 * 4]])
        data = load(written(tmp_path, table), found)
        for who, rows in data.estimates.groupby("participant_id", observed=True):
            expected = frame.loc[frame.iloc[:, 0] == who, frame.columns[-1]]
            assert rows["estimate"].tolist() == expected.tolist()


def test_shuffled_rows_have_the_same_drift(tmp_path):
    rng = np.random.default_rng(1)
    frame = pd.DataFrame(
        {"who": who, "n": n, "level": level, "loudness": level * np.exp(0.05 * n + noise)}
        for who in range(4)
        for n, level in enumerate(rng.permutation([1, 2, 4] * 4))
        for noise in [rng.normal(0, 0.05)]
    )
    orders = [
        analyse(load(written(tmp_path, rows), mapping(trial="n"))).inference.results["order"]
        for rows in (frame, frame.sample(frac=1, random_state=3))
    ]
    assert orders[0] == orders[1]
    assert orders[0].log_slope_per_trial.mean == pytest.approx(0.05, abs=0.01)


def test_rows_keep_their_order_if_a_trial_number_is_missing(tmp_path):
    frame = trials().query("visit == 2 and part == 'a'").sample(frac=1, random_state=3)
    frame = frame.astype({"n": object}).reset_index(drop=True)
    frame.loc[3, "n"] = None
    data = load(written(tmp_path, frame), mapping(trial="n"))
    assert sorted(data.estimates["estimate"]) == sorted(frame["loudness"])
    assert data.estimates["estimate"].tolist() == frame["loudness"].tolist()
    assert data.problems[0].startswith("1 of 22 rows have no trial number")


def test_rows_without_a_condition_are_omitted_with_their_lines(tmp_path):
    frame = trials().assign(speed=["slow", "fast"] * 44)
    frame.loc[[3, 40, 77], "speed"] = None
    data = load(written(tmp_path, frame), mapping(factor="speed"))
    assert data.problems == ("data.csv, lines 5, 42 and 79: omitted, because there is no speed",)
    assert set(data.estimates["factor: speed"]) == {"slow", "fast"}
    assert len(data.estimates) == len(frame) - 3


@pytest.mark.parametrize(
    "columns, levels",
    [
        ({"response": "", "yes_count": "yes", "n": "tot"}, {}),
        ({"response": "", "stimulus": ""}, {"p1": 1, "p2": 2}),
    ],
)
def test_several_answers_per_row_have_no_trial_number(columns, levels):
    """All but one of a row's answers were removed as repeated trials."""
    with pytest.raises(UserError, match="a trial number requires one response per row"):
        mapping(levels=levels, trial="trial", **columns)


@pytest.mark.parametrize("column, value", [("texture", "smooth"), ("phase", "practice")])
def test_a_column_that_only_selects_rows_has_no_other_meaning(tmp_path, column, value):
    frame = trials().assign(**{column: [value, "other"] * 44})
    data = load(written(tmp_path, frame), mapping(table={"only": {column: value}}))
    assert len(data.estimates) == 44
    assert data.problems == ()


def test_the_groups_have_the_name_of_their_column(tmp_path):
    frame = pd.DataFrame(
        {"who": who, "grp": "xy"[who % 2], "level": level, "loudness": level + who}
        for who in range(8)
        for level in (1, 2, 4)
    )
    analysis = analyse(load(written(tmp_path, frame), mapping(group="grp")))
    assert analysis.inference.results["groups"].column == "grp"
    assert analysis.dataset.frozen == ()


def test_people_of_a_table_by_hand_are_not_in_participants_tsv(tmp_path):
    frame = trials().query("who == 'p2' or visit == 2")
    data = only_session(load(written(tmp_path, frame), mapping(session="visit")), "10")
    assert absent(data) == ["1 of 2 participants have no trials (p10)."]


def test_rows_are_selected_by_numbers_as_people_write_them(tmp_path):
    """Next to 0.5, a level of 2 was only found as 2.0."""
    frame = trials().assign(level=[0.5, 2] * 44)
    data = load(written(tmp_path, frame), mapping(table={"only": {"level": ["2", "0.5"]}}))
    assert len(data.estimates) == 88


def test_rows_of_a_folder_without_a_participant_are_omitted_with_their_lines(tmp_path):
    folder = tmp_path / "sub-1" / "beh"
    folder.mkdir(parents=True)
    frame = trials()
    frame.loc[[3, 4], "who"] = "n/a"
    frame.to_csv(folder / "sub-1_task-a_beh.tsv", sep="\t", index=False)
    data = load(tmp_path, mapping())
    assert data.problems == (
        "sub-1/beh/sub-1_task-a_beh.tsv, lines 5 and 6: omitted, because there is no who",
    )
