"""Scales from paired comparisons, and whether choices are consistent."""

import json
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.scales.paired_comparison_scale import bradley_terry, thurstone
from slipscale.analysis.tasks.scales.transitivity import (
    circular_triads_by_chance,
    consistency,
    stochastic_transitivity,
)
from slipscale.faults import UserError

# Citations between four journals of statistics (Stigler 1994), cited over citing: Biometrika,
# Communications in Statistics, JASA, JRSS-B.
CITATIONS = np.array([[0, 730, 498, 221], [33, 0, 68, 17], [320, 813, 0, 142], [284, 276, 325, 0]])
MANY = 100_000
R = json.loads((Path(__file__).parents[3] / "data" / "r_reference" / "firth.json").read_text())
MODELS = pytest.mark.parametrize("scale", [bradley_terry, thurstone])


def test_with_many_answers_the_journals_scale_is_the_published_one():
    """Turner and Firth 2012, J. Stat. Softw. 48(9), section 2.1, by maximum likelihood.

    Firth's correction vanishes as answers grow: each citation counts a hundred thousand times.
    """
    found = bradley_terry(MANY * CITATIONS)
    distances = np.array(found.values)[1:] - found.values[0]
    c = np.array(found.covariance) * MANY
    errors = np.sqrt(c[0, 0] + np.diag(c)[1:] - 2 * c[0, 1:])
    assert np.round(distances, 5).tolist() == [-2.94907, -0.47957, 0.26895]
    assert np.round(errors, 5).tolist() == [0.10255, 0.06059, 0.07083]
    assert (round(found.fit.deviance / MANY, 4), found.fit.df) == (4.2934, 3)


@pytest.mark.parametrize("case", ["journals", "never_chosen", "one_pair"])
def test_scales_with_firths_correction_are_those_of_r(case):
    reference = R[case]
    for name, scale in (("bradley_terry", bradley_terry), ("thurstone", thurstone)):
        assert scale(reference["won"]).values == pytest.approx(reference[name], abs=1e-7)


def test_every_study_of_few_choices_has_a_scale_without_bias():
    """By maximum likelihood 18 of these 60 have none; the ends lie at -1.5 and 1.5."""
    rng, true = np.random.default_rng(6), np.linspace(-1.5, 1.5, 5)
    found = [bradley_terry(choices(3, rng, bradley_terry, true=true)) for _ in range(60)]
    ends = np.array([(one.values[-1] - one.values[0]) / 2 for one in found])
    assert abs(ends.mean() - 1.5) < 2 * ends.std(ddof=1) / len(ends) ** 0.5


@pytest.mark.parametrize("scale", [bradley_terry, thurstone])
@pytest.mark.parametrize("answers", [16, 100, 400])
def test_a_scale_of_choices_that_never_differ_is_centred(scale, answers):
    """A pseudo-inverse took rounding errors for information about the mean."""
    values = scale(np.tril(np.full((4, 4), float(answers)), -1)).values
    assert sum(values) == pytest.approx(0, abs=1e-9)
    assert values == pytest.approx(-np.array(values[::-1]))
    assert np.all(np.diff(values) > 0)


def test_people_who_all_choose_alike_get_an_interval_with_a_width():
    same = np.broadcast_to([[0, 1, 1], [0, 0, 1], [0, 0, 0]], (5, 3, 3))
    for low, high in bradley_terry(same).intervals:
        assert high - low > 1


TRUE = np.array([-0.7, -0.2, 0.3, 0.6])


def choices(trials, rng, scale, *, people=1, spread=0.0, true=TRUE):
    values = true
    own = values + spread * rng.standard_normal((people, len(values)))
    distance = own[:, :, None] - own[:, None, :]
    share = {bradley_terry: stats.logistic.cdf, thurstone: stats.norm.cdf}[scale](distance)
    counts = np.triu(np.full(distance.shape[1:], trials), k=1)
    won = rng.binomial(counts, np.triu(share))
    return won + (counts - won).transpose(0, 2, 1)


@MODELS
def test_the_truth_is_recovered_and_intervals_hold_it_as_often_as_stated(scale):
    """Over 200 data sets: means within 3.5 standard errors, 736 to 778 of 800 intervals.

    Sum-zero values hang together, so the count's bounds are those of 300 independent intervals at
    3 standard errors. Seeds are fixed: nothing fails by chance.
    """
    rng = np.random.default_rng(9)
    found = [scale(choices(60, rng, scale)) for _ in range(200)]
    values = np.array([one.values for one in found])
    error = values.std(axis=0, ddof=1) / len(found) ** 0.5
    assert np.all(np.abs(values.mean(axis=0) - TRUE) < 3.5 * error)
    held = sum(
        low <= true <= high
        for one in found
        for (low, high), true in zip(one.intervals, TRUE, strict=True)
    )
    assert 736 <= held <= 778


@MODELS
def test_people_who_differ_widen_the_intervals(scale):
    rng = np.random.default_rng(2)
    by_person = choices(10, rng, scale, people=12, spread=1.0)
    allowing, ignoring = scale(by_person), scale(by_person.sum(axis=0))
    assert allowing.values == ignoring.values
    widths = [
        np.diff(np.array([tuple(i) for i in one.intervals]), axis=1) for one in (allowing, ignoring)
    ]
    assert np.mean(widths[0] / widths[1]) > 1.5
    assert allowing.participants == 12


@MODELS
def test_a_scale_that_fits_is_not_refused_and_a_circle_is(scale):
    rng = np.random.default_rng(5)
    assert scale(choices(400, rng, scale)).fit.p > 0.01
    assert scale([[0, 80, 20], [20, 0, 80], [80, 20, 0]]).fit.p < 1e-6


@MODELS
def test_surfaces_that_were_never_compared_have_no_scale(scale):
    assert "never compared" in scale([[0, 9, 0], [3, 0, 0], [0, 0, 0]]).reason


@pytest.mark.parametrize(
    "chosen,words",
    [
        ([[0, 1, 2], [1, 0, 2]], "square table"),
        ([[0]], "at least two surfaces"),
        ([[0, 1.5], [1, 0]], "whole numbers"),
        ([[0, -1], [1, 0]], "whole numbers of 0 or more"),
        ([[1, 1], [1, 0]], "compared with itself"),
    ],
)
def test_tables_that_cannot_be_are_refused(chosen, words):
    with pytest.raises(UserError, match=words):
        bradley_terry(chosen)


@pytest.mark.parametrize(
    "surfaces,ways",
    [
        (4, (24, 16, 24)),
        (5, (120, 120, 240, 240, 280, 24)),
        (6, (720, 960, 2240, 2880, 6240, 3648, 8640, 4800, 2640)),
    ],
)
def test_circular_triads_by_chance_are_kendalls(surfaces, ways):
    """Kendall and Babington Smith 1940, Table I."""
    assert circular_triads_by_chance(surfaces) == ways


@given(st.integers(3, 8), st.randoms(use_true_random=False))
def test_circular_triads_are_those_without_an_order(surfaces, random):
    chosen = np.zeros((surfaces, surfaces), int)
    for one, other in combinations(range(surfaces), 2):
        first = random.random() < 0.5
        chosen[one, other], chosen[other, one] = (2, 1) if first else (0, 1)
    wins = chosen > chosen.T
    circles = sum(
        sorted(wins[np.ix_(three, three)].sum(axis=1)) == [1, 1, 1]
        for three in combinations(range(surfaces), 3)
    )
    found = consistency(chosen)
    assert found.circular_triads == circles
    assert 0 <= found.zeta <= 1
    assert 0 < found.p <= 1


def test_an_order_is_consistent_and_a_circle_is_not():
    order = np.triu(np.ones((5, 5), int), k=1)
    found = consistency(order)
    assert (found.circular_triads, found.zeta, found.p) == (0, 1.0, 120 / 1024)
    circle = consistency([[0, 1, 0], [0, 0, 1], [1, 0, 0]])
    assert (circle.circular_triads, circle.zeta, circle.p) == (1, 0.0, 1.0)


def test_chi_square_takes_over_from_counting_without_a_jump():
    """Kendall's approximation of the tail for 7 surfaces, against 20,000 random tables."""
    rng = np.random.default_rng(1)
    tables = np.triu(rng.integers(0, 2, (20_000, 7, 7)), k=1)
    upper = np.triu(np.ones((7, 7), int), k=1)
    scores = (tables + (upper - tables).transpose(0, 2, 1)).sum(axis=2)
    circles = 35 - (scores * (scores - 1) // 2).sum(axis=1)
    for one in (4, 6, 8):
        table = tables[np.flatnonzero(circles == one)[0]]
        found = consistency(table + (upper - table).T)
        assert found.circular_triads == one
        assert found.p == pytest.approx(np.mean(circles <= one), abs=0.02)


@given(st.integers(3, 5), st.randoms(use_true_random=False))
def test_ties_count_as_the_mean_over_all_ways_to_break_them(surfaces, random):
    chosen = np.zeros((surfaces, surfaces), int)
    pairs = list(combinations(range(surfaces), 2))
    for one, other in pairs:
        chosen[one, other] = random.choice([0, 1, 1, 2])
        chosen[other, one] = 2 - chosen[one, other]
    tied = [pair for pair in pairs if chosen[pair] == 1]
    broken = []
    for ways in product((0, 2), repeat=len(tied)):
        table = chosen.copy()
        for (one, other), way in zip(tied, ways, strict=True):
            table[one, other], table[other, one] = way, 2 - way
        broken.append(consistency(table).circular_triads)
    found = consistency(chosen)
    assert found.ties == len(tied)
    assert found.circular_triads == pytest.approx(np.mean(broken))
    assert found.zeta <= 1


def test_the_chance_of_tied_choices_is_that_of_coins_tossed_as_often():
    """Three pairs, twice each, all tied: as many circles or fewer in 50 of 64 ways to toss."""
    found = consistency([[0, 1, 1], [1, 0, 1], [1, 1, 0]])
    assert (found.circular_triads, found.ties, found.zeta) == (0.25, 3, 0.75)
    shares = {0: 1, 1: 2, 2: 1}
    ways = 0
    for x, y, z in product(shares, repeat=3):
        table = [[0, x, y], [2 - x, 0, z], [2 - y, 2 - z, 0]]
        if consistency(table).circular_triads <= 0.25:
            ways += shares[x] * shares[y] * shares[z]
    assert ways == 50
    assert found.p == pytest.approx(50 / 64, abs=0.015)


def test_the_chance_of_an_order_is_smaller_if_random_choices_could_be_tied():
    """Three pairs, twice each, all clear: no circle at all in 18 of 64 ways to toss, not 6 of 8."""
    found = consistency([[0, 2, 2], [0, 0, 2], [0, 0, 0]])
    assert (found.circular_triads, found.ties) == (0, 0)
    shares = {0: 1, 1: 2, 2: 1}
    ways = sum(
        shares[x] * shares[y] * shares[z]
        for x, y, z in product(shares, repeat=3)
        if consistency([[0, x, y], [2 - x, 0, z], [2 - y, 2 - z, 0]]).circular_triads == 0
    )
    assert ways == 18
    assert found.p == pytest.approx(18 / 64, abs=0.015)


def test_two_surfaces_and_pairs_never_compared_have_no_circles():
    assert consistency([[0, 1], [2, 0]]) == NotComputed(
        "too few surfaces (2; at least 3 are needed)"
    )
    assert "never compared" in consistency([[0, 1, 0], [0, 0, 1], [0, 0, 0]]).reason


@pytest.mark.parametrize(
    "shares,violations",
    [
        ((0.6, 0.6, 0.7), (0, 0, 0)),
        ((0.6, 0.8, 0.7), (0, 0, 1)),
        ((0.6, 0.8, 0.55), (0, 1, 1)),
        ((0.6, 0.8, 0.4), (1, 1, 1)),
    ],
)
def test_a_triads_violations_are_those_of_its_best_order(shares, violations):
    ab, bc, ac = (round(100 * share) for share in shares)
    chosen = [[0, ab, ac], [100 - ab, 0, bc], [100 - ac, 100 - bc, 0]]
    found = stochastic_transitivity(chosen)
    assert found.triads == 1
    assert (
        found.weak_violations,
        found.moderate_violations,
        found.strong_violations,
    ) == violations


def test_pairs_never_compared_make_no_triad():
    found = stochastic_transitivity([[0, 3, 0], [1, 0, 2], [0, 2, 0]])
    assert found == NotComputed("no three surfaces were all compared with each other")
