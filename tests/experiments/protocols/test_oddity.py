"""Oddity, and staircases with equal steps that begin one-down."""

from itertools import pairwise

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.protocol_parts.adaptive.staircase import staircase

STUDY = """
name = "triangle"
title = "The odd one of three"
amplitudes_um_pp = [1.2]
[plate]
tolerance = 0.01
tolerance_um_pp = 0.015
[[tasks]]
protocol = "oddity"
start_um_pp = 0.5
lowest_um_pp = 0.03
tracks = 1
most_trials = 12
practice = 1
catch_trials = 2
down_to_up = 1.0
steps_up = [0.2]
until_first_error = true
"""


def test_the_odd_one_is_found_where_the_difference_is_large(laboratory, plan, tmp_path):
    run = plan(STUDY, seed=3)
    assert run.texts()["oddity.question"] == "Which one was different?"
    laboratory.folder = tmp_path
    assert laboratory.run(run) == "complete"
    build_dataset(tmp_path)
    (path,) = tmp_path.glob("sub-*/beh/*_task-oddity_*_beh.tsv")
    header, *lines = [line.split("\t") for line in path.read_text().splitlines()]
    rows = [dict(zip(header, line, strict=True)) for line in lines]
    easy = [row for row in rows if float(row["level_um_pp"]) > 0.3]
    assert len(easy) >= 3
    assert all(row["correct"] == "true" for row in easy)
    main = [row for row in rows if row["track"] == "1"]
    levels = [float(row["level_um_pp"]) for row in main]
    first_error = next(n for n, row in enumerate(main) if row["correct"] == "false")
    ratios = [after / before for before, after in pairwise(levels[: first_error + 1])]
    assert max(ratios) < 0.7  # 0.2 decades down after each right answer


def test_after_the_first_error_steps_are_equal_and_take_two_right_answers():
    rule = staircase(
        start_level=1.0,
        lowest_level=0.01,
        highest_level=2.0,
        steps_up=(0.1,),
        down_after=2,
        scale="linear",
        down_to_up=1.0,
        until_first_error=True,
    )
    track, levels = rule.start(), []
    for correct in (True, True, False, True, True, True, False):
        levels.append(track.level)
        track = track.answered(correct=correct)
    assert [round(each, 3) for each in (*levels, track.level)] == [
        *(1.0, 0.9, 0.8, 0.9, 0.9, 0.8, 0.8, 0.9),
    ]
    assert [round(each, 3) for each in track.reversal_levels] == [0.8, 0.9, 0.8]
