"""Counts under every SD convention and rounding rule are those of a column that states them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipscale.analysis.reconstruction.answers import all_variants
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions


@st.composite
def columns(draw):
    """Keyword arguments of a column whose numbers are often half-way between two decimals."""
    n, top = draw(st.integers(2, 4)), draw(st.integers(2, 5))
    x = sorted(draw(st.lists(st.integers(0, top), min_size=n, max_size=n)))
    mean, quartiles = np.mean(x), np.quantile(x, [0.25, 0.75])
    printed = {
        "sd": np.std(x, ddof=1),
        "se": np.std(x, ddof=1) / n**0.5,
        "median": np.median(x),
        "lower_quartile": quartiles[0],
        "upper_quartile": quartiles[1],
        "maximum_deviation": max(x[-1] - mean, mean - x[0]),
        "observed_minimum": x[0],
    }
    kept = draw(st.sets(st.sampled_from(sorted(printed))))
    places = draw(st.integers(0, 1))
    facts = {name: f"{printed[name]:.{places}f}" for name in kept}
    told = draw(st.sets(st.integers(0, top), max_size=1))
    shares = [(value, f"{100 * x.count(value) / n:.0f}") for value in told]
    mean_and_sd = {"mean": f"{mean:.{places}f}", "sd": None}
    return {"n": n, "maximum": top, "percentages": shares, **mean_and_sd, **facts}


@settings(max_examples=60, deadline=None)
@given(facts=columns())
def test_every_variant_has_the_data_sets_of_its_convention_and_rounding(
    column, all_multisets, facts
):
    for variant in all_variants(Solutions(column(**facts))):
        named = {"sd_convention": variant.sd_convention, "rounding": variant.rounding}
        assert variant.multisets == len(all_multisets(column(**facts, **named))), named


@pytest.mark.parametrize("stated", ["nearest", "half_up", "half_even", "truncated"])
def test_quartiles_are_rounded_as_the_variant_says(column, stated):
    facts = {"maximum": 3, "lower_quartile": "1", "rounding": stated}
    variants = all_variants(Solutions(column(3, "1", "1", **facts)))
    sample = {each.rounding: each.multisets for each in variants if each.sd_convention == "sample"}
    assert sample == {"nearest": 4, "half_up": 4, "half_even": 2, "truncated": 3}
