"""Similarity rating: every pair in both orders, on a line, with names of levels and textures."""

from collections import Counter

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.study.file import parse_study
from slipscale.faults import UserError

STUDY = """
name = "map"
title = "A map of four surfaces"
amplitudes_um_pp = [0.0, 0.5, 2.3]
[[textures]]
name = "ridges"
spatial_period_mm = 2.5
waveform = "square"
mean_um_pp = 1.2
depth_um_pp = 0.8
finger_speed_mm_s = 50.0
[[tasks]]
protocol = "similarity"
identical_pairs = true
catch_trials = 1
"""


def test_every_pair_is_rated_in_both_orders_and_further_pairs_are_less_alike(
    laboratory, plan, tmp_path
):
    run = plan(STUDY, seed=3)
    laboratory.folder = tmp_path
    assert laboratory.run(run) == "complete"
    build_dataset(tmp_path)
    (path,) = tmp_path.glob("sub-*/beh/*_task-similarity_*_beh.tsv")
    header, *lines = [line.split("\t") for line in path.read_text().splitlines()]
    rows = [dict(zip(header, line, strict=True)) for line in lines]
    main = [row for row in rows if row["phase"] == "main" and row["catch"] == "false"]
    assert len(rows) == 3 + 1 + 2 * 10 == run.planned_trials()
    shown = Counter((row["first"], row["second"]) for row in main)
    assert shown["0", "2.3"] == shown["2.3", "0"] == shown["ridges", "0"] == 1
    assert shown["ridges", "ridges"] == 2

    def mean(*names):
        found = [float(r["dissimilarity"]) for r in main if {r["first"], r["second"]} == {*names}]
        return sum(found) / len(found)

    assert mean("0") < 10
    assert mean("0", "0.5") < mean("0", "2.3") - 30
    assert 50 < mean("0", "2.3") < 90


def test_two_surfaces_make_no_map():
    with pytest.raises(UserError, match="similarity needs 3 surfaces, but the study has 2"):
        parse_study(STUDY.replace("0.0, 0.5, 2.3", "0.5"), "map.toml")
