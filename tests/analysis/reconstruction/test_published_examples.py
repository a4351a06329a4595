"""Worked examples that the authors and packages of the field have published."""

from __future__ import annotations

import numpy as np
import pytest

from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions


@pytest.mark.parametrize(
    "n, mean, top",
    [
        # Brown and Heathers (2017), Soc. Psychol. Pers. Sci. 8(4): the GRIM paper's own example.
        (28, "5.19", 7),
        # The Economist, 18 June 2016, "Come again?", on the GRIM preprint: a scale of 1 to 7.
        (49, "5.93", 7),
        # Allard (2018), "Analytic-GRIMMER": ten answers from 1 to 7.
        (10, "3.45", 7),
        # Wikipedia, "GRIM test": twenty rolls of a die.
        (20, "3.48", 6),
    ],
)
def test_grim_examples_are_inconsistent(column, n, mean, top):
    solutions = Solutions(column(n, mean, "1.00", minimum=1, maximum=top))
    assert not solutions.targets.grim
    assert not solutions.consistent
    assert "GRIM:" in solutions.reason


def test_the_reason_names_the_means_that_are_possible(column):
    """5.18 is the nearest possible mean to 5.19 for n = 28 (rsprite2 0.2.1, its GRIM test)."""
    reason = Solutions(column(28, "5.19", "1.00", maximum=10)).reason
    assert "nearest are 5.17857 and 5.21429" in reason
    assert Solutions(column(28, "5.18", "1.00", maximum=10)).targets.grim


def test_the_grimmer_example_is_inconsistent(column):
    """rsprite2 0.2.1, `GRIMMER_test`: 18 whole numbers with mean 3.44 cannot have SD 2.47."""
    solutions = Solutions(column(18, "3.44", "2.47", maximum=20))
    assert solutions.targets.grim
    assert not solutions.targets.grimmer
    assert "GRIMMER:" in solutions.reason


@pytest.mark.parametrize(
    "n, mean, sd, scale",
    [
        # rsprite2 0.2.1, README: a distribution that SPRITE (Heathers et al., 2018) finds.
        (20, "2.2", "1.3", (1, 5)),
        (20, "2.20", "1.32", (1, 5)),
        # pysprite 1.2.1, test_pysprite.py, `values_success`: SPRITE finds one.
        (41, "1.98", "2.02", (-1, 6)),
        (10, "18.60", "12.75", (-10, 39)),
        (21, "3.10", "4.86", (-3, 13)),
        (12, "13.08", "11.90", (-4, 30)),
        (35, "0.37", "4.00", (-5, 8)),
        (34, "-1.85", "3.73", (-8, 4)),
    ],
)
def test_where_sprite_finds_a_data_set_there_is_one(column, n, mean, sd, scale):
    assert Solutions(column(n, mean, sd, minimum=scale[0], maximum=scale[1])).consistent


@pytest.mark.parametrize("mean", ["4.21", "4.23"])
def test_where_sprite_refuses_a_mean_there_is_none(column, mean):
    """pysprite 1.2.1, test_pysprite.py, `values_GRIMfail`: n = 20 on 0 to 10."""
    assert not Solutions(column(20, mean, "2.12", maximum=10)).consistent


def test_closure_s_example_has_its_samples_and_frequencies(column):
    """unsum 0.2.0, README: n = 130 on 1 to 5, mean 2.7, SD 1.9: 5,359 samples."""
    sampler = Sampler(Solutions(column(130, "2.7", "1.9", minimum=1, maximum=5)))
    assert sampler.total == 5359
    published = [358972, 30170, 21940, 30162, 255426]
    assert np.bincount(sampler.listed.ravel()).tolist() == published


def test_corvids_example_has_as_many_solutions_as_the_program_finds(column):
    """Wilner, Wood and Simons (2018): the call in CORVIDS' documentation, n = 20 on 1 to 7.

    Mean 4 and variance 2 are exact there: an SD of this many decimals admits no other. The
    documentation gives no count; the program, run on it, returns 95 solutions.
    """
    solutions = Solutions(column(20, "4.000", "1.41421356", minimum=1, maximum=7))
    assert len(solutions.targets.moments) == 1
    assert solutions.multisets == 95
