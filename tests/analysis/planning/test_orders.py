"""Simulated orders are the protocol's: what is possible, and how often."""

from collections import Counter
from itertools import pairwise, permutations

import numpy as np
import pytest

from slipscale.analysis.planning.simulated.orders import draw_orders

RULES = ("blocked", "simple", "williams")


def drawn(rule, surfaces=3, repetitions=2, practice=1, shape=(400, 6), *, apart=True):
    return draw_orders(
        rule,
        surfaces,
        repetitions,
        practice,
        no_immediate_repeat=apart,
        shape=shape,
        rng=np.random.default_rng(1),
    )


@pytest.mark.parametrize("rule", RULES)
def test_everybody_has_every_surface_equally_often_and_never_twice_in_a_row(rule):
    orders = drawn(rule)
    assert orders.shape == (400, 6, 9)
    assert (np.sort(orders[..., 3:], axis=2) == [0, 0, 1, 1, 2, 2]).all()
    assert (np.sort(orders[..., :3], axis=2) == [0, 1, 2]).all()
    assert (orders[..., 1:] != orders[..., :-1]).all()


@pytest.mark.parametrize("rule", RULES)
def test_where_it_may_a_surface_follows_itself(rule):
    orders = drawn(rule, apart=False)
    assert (orders[..., 1:] == orders[..., :-1]).any()


def test_all_orders_without_repeats_are_as_likely():
    """Of 0 0 1 1 2 2 there are 30 orders without equal neighbours, of 90."""
    orders = drawn("simple", shape=(5000, 6), practice=0).reshape(-1, 6)
    counts = Counter(map(tuple, orders.tolist()))
    apart = {
        each for each in permutations((0, 0, 1, 1, 2, 2)) if all(a != b for a, b in pairwise(each))
    }
    assert set(counts) == apart
    assert len(apart) == 30
    share = np.array(list(counts.values())) / len(orders)
    # The pool's 500 orders are themselves a sample: some 80 of each relabelled kind.
    assert share == pytest.approx(1 / 30, rel=0.25)


def test_a_williams_group_has_each_surface_in_each_place_and_after_each_other_once():
    orders = drawn("williams", surfaces=4, repetitions=1, practice=0, shape=(50, 8))
    for group in orders.reshape(100, 4, 4):
        assert (np.sort(group, axis=0) == np.arange(4)[:, None]).all()
        followed = {(a, b) for row in group.tolist() for a, b in pairwise(row)}
        assert len(followed) == 12


def test_blocks_of_a_simple_order_are_not_kept():
    orders = drawn("simple", practice=0)
    halves = np.sort(orders[..., :3], axis=2)
    assert (halves != [0, 1, 2]).any()
    blocked = np.sort(drawn("blocked", practice=0)[..., :3], axis=2)
    assert (blocked == [0, 1, 2]).all()
