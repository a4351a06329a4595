"""Small data sets whose results follow by hand: the numbers of CSV, sentence, figure and JSON."""

import json
from math import log

import pandas as pd
import pytest

from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reporting import files, page
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

PEOPLE = ("01", "02", "03")
SOURCE = {"study": "by hand", "mode": "participant", "seed": 1}
#: Task label -> its columns, and for each participant the cells of every trial.
TABLES: dict[str, tuple[tuple[str, ...], list[list[tuple[object, ...]]]]] = {
    # Both ends of the line occur: 0 is its left end, 100 its right.
    "line": (
        ("surface", "level", "rating", "cursor_start", "resolution"),
        [
            [("S1", 0.0, 0, 20, 1), ("S2", 1.0, 40, 50, 1), ("S3", 2.0, 100, 80, 1)],
            [("S1", 0.0, 10, 20, 1), ("S2", 1.0, 50, 50, 1), ("S3", 2.0, 90, 80, 1)],
            [("S1", 0.0, 20, 20, 1), ("S2", 1.0, 60, 50, 1), ("S3", 2.0, 100, 80, 1)],
        ],
    ),
    # Slopes of log ratio on log amplitude: 1, 1.5 and 2.
    "ratios": (
        ("standard_level", "comparison_level", "ratio"),
        [
            [(1.0, 0.5, 0.5), (1.0, 2.0, 2.0)],
            [(1.0, 0.5, 0.5), (1.0, 2.0, 4.0)],
            [(1.0, 0.5, 0.5), (1.0, 2.0, 8.0)],
        ],
    ),
    # Slopes of log amplitude on log number: 1, 1 and 2.
    "made": (
        ("standard_level", "modulus", "number", "produced_level", "began", "bound"),
        [
            [(0.8, 10, 5, 0.4, "low", "n/a"), (0.8, 10, 20, 1.6, "high", "n/a")],
            [(0.8, 10, 5, 0.4, "high", "n/a"), (0.8, 10, 20, 1.6, "low", "n/a")],
            [(0.8, 10, 5, 0.2, "low", "n/a"), (0.8, 10, 20, 3.2, "high", "n/a")],
        ],
    ),
    # Means of each person: 1.15, 1.0 and 1.1 µm for a reference of 1 µm.
    "matching": (
        ("direction", "interval1_level", "matched_level", "felt_again"),
        [
            [("ascending", 1.0, 1.0, 0), ("descending", 1.0, 1.3, 1)],
            [("ascending", 1.0, 0.9, 0), ("descending", 1.0, 1.1, 0)],
            [("ascending", 1.0, 1.05, 2), ("descending", 1.0, 1.15, 0)],
        ],
    ),
    # 2 µm is chosen over 0.5 µm in 9 of 12 trials.
    "pairs": (
        ("stimulus1", "stimulus2", "response"),
        [
            [("0.5", "2", 2), ("2", "0.5", 1), ("0.5", "2", 2), ("2", "0.5", 2)],
            [("0.5", "2", 2), ("2", "0.5", 1), ("0.5", "2", 1), ("2", "0.5", 1)],
            [("0.5", "2", 1), ("2", "0.5", 1), ("0.5", "2", 2), ("2", "0.5", 1)],
        ],
    ),
    # Two intervals: half of the easiest trials would be right by chance.
    "choices": (
        ("track", "standard_level", "track_level", "target_interval", "response", "correct"),
        [
            [(1, 1.2, level, 1, 1 if right else 2, str(right).lower()) for level, right in trials]
            for trials in [
                [(0.1, place < 6) for place in range(10)] + [(0.8, True)] * 10,
                [(0.1, place < 5) for place in range(10)] + [(0.8, True)] * 10,
                [(0.1, place < 4) for place in range(10)]
                + [(0.8, place > 0) for place in range(10)],
            ]
        ],
    ),
}


def write(folder):
    (folder / "dataset_description.json").write_text('{"Name": "By hand", "BIDSVersion": "1.10.0"}')
    lines = ["participant_id", *(f"sub-{who}" for who in PEOPLE)]
    (folder / "participants.tsv").write_text("\n".join(lines) + "\n")
    for task, (columns, everybody) in TABLES.items():
        for who, trials in zip(PEOPLE, everybody, strict=True):
            path = folder / f"sub-{who}/beh/sub-{who}_task-{task}_run-01_beh.tsv"
            path.parent.mkdir(parents=True, exist_ok=True)
            head = ["trial", "catch", "phase", *columns, "flag"]
            named = [PLATE_AMPLITUDE.named(name) for name in head]
            rows = [
                [place, "false", "main", *cells, "n/a"] for place, cells in enumerate(trials, 1)
            ]
            pd.DataFrame(rows, columns=named).to_csv(path, sep="\t", index=False)
            path.with_suffix(".json").write_text(json.dumps(SOURCE))


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("by_hand")
    write(folder)
    analysis = analyse(folder)
    files.write_analysis(analysis, folder / "out")
    tables = {path.stem: pd.read_csv(path) for path in (folder / "out").glob("*.csv")}
    inference = json.loads((folder / "out" / "inference.json").read_text(encoding="utf-8"))
    sentences = {title: " ".join(texts) for title, texts in page.conclusions(analysis).items()}
    return tables, inference, sentences, files.draw(analysis)


def drawn(figure, marker="o", axes=0):
    """Return the single points of a figure, from left to right."""
    lines = [line for line in figure.axes[axes].lines if line.get_marker() == marker]
    points = [line.get_xydata()[0] for line in lines if len(line.get_xydata()) == 1]
    return sorted((round(float(x), 6), round(float(y), 6)) for x, y in points)


def test_ratings_keep_both_ends_of_the_line(found):
    tables, inference, sentences, figures = found
    rows = tables["ratings"]
    assert rows["mean"].tolist() == pytest.approx([10, 50, 290 / 3])
    assert rows["at_left_end"].tolist() == [1, 0, 0]
    assert rows["at_right_end"].tolist() == [0, 0, 2]
    (task,) = inference["ratings"]
    assert [each["ratings"] for each in task["surfaces"]] == [3, 3, 3]
    assert task["friedman"]["chi2"] == pytest.approx(6)
    assert "were 10.0 (0 µm), 50.0 (1 µm) and 96.7 (2 µm)" in sentences["Rating scales"]
    assert "3 of 9 ratings were at an end of the line" in sentences["Rating scales"]
    assert drawn(figures["ratings_line"]) == [(0, 10), (1, 50), (2, 96.666667)]


def test_ratios_have_their_geometric_means_and_exponent(found):
    tables, inference, sentences, figures = found
    assert tables["ratios"]["ratio"].tolist() == pytest.approx([0.5, 4])
    (task,) = inference["ratios"]
    assert task["power_law"]["exponent"] == pytest.approx(1.5)
    assert "was 1.50, 95% CI" in sentences["Ratio judgements"]
    assert "2 µm 4.00 times" in sentences["Ratio judgements"]
    assert drawn(figures["ratios_ratios"]) == [(0.5, 0.5), (2, 4)]
    assert drawn(figures["ratios_ratios"], "D") == [(1, 1)]


def test_productions_have_their_geometric_means_and_slope(found):
    tables, inference, _, figures = found
    low, high = (0.4 * 0.4 * 0.2) ** (1 / 3), (1.6 * 1.6 * 3.2) ** (1 / 3)
    assert tables["productions"]["amplitude_um_pp"].tolist() == pytest.approx([low, high])
    (task,) = inference["productions"]
    assert task["slope"]["mean"] == pytest.approx(4 / 3)
    assert drawn(figures["productions_made"]) == [(5, round(low, 6)), (20, round(high, 6))]
    assert drawn(figures["productions_made"], "D") == [(10, 0.8)]


def test_matches_have_their_bias_and_direction(found):
    tables, inference, sentences, _ = found
    (row,) = tables["matching"].to_dict(orient="records")
    assert row["mean_um_pp"] == pytest.approx(3.25 / 3)
    assert row["bias_um_pp"] == pytest.approx(0.25 / 3)
    assert (row["ascending_um_pp"], row["descending_um_pp"]) == pytest.approx((2.95 / 3, 3.55 / 3))
    assert row["felt_again"] == 3 / 6
    (task,) = inference["matching"]
    assert abs(task["direction_um_pp"]["mean"]) == pytest.approx(0.2)
    assert "was matched by 1.083 µm" in sentences["Matching"]


def test_a_scale_has_its_shares_and_log_odds(found):
    tables, inference, _, _ = found
    shares = tables["scales"].query("model == 'share chosen'").set_index("surface")["value"]
    assert shares.to_dict() == pytest.approx({0.5: 0.25, 2.0: 0.75})
    (task,) = inference["scales"]
    assert (task["chosen"], task["compared"]) == ([3, 9], [12, 12])
    low, high = task["bradley_terry"]["values"]
    assert high - low == pytest.approx(log(3), rel=0.1)  # a weak prior keeps it finite


def test_thresholds_count_their_answers_and_draw_chance_at_one_half(found):
    tables, inference, _, figures = found
    assert tables["thresholds"]["trials"].tolist() == [20, 20, 20]
    assert tables["thresholds"]["correct"].tolist() == [16, 15, 13]
    (task,) = inference["thresholds"]
    assert task["method"] == "two_interval"
    axes = figures["thresholds_choices"].axes[0]
    assert [line.get_ydata()[0] for line in axes.lines if line.get_linestyle() == ":"] == [0.5]
    shares = dict(tuple(map(float, each.get_offsets()[0])) for each in axes.collections)
    assert list(shares) == pytest.approx([0.1, 0.8])
    assert list(shares.values()) == pytest.approx([0.5, 29 / 30])
