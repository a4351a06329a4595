from collections import Counter
from itertools import pairwise, permutations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chisquare, kstest

from experiments.protocols.randomisation import (
    Stream,
    presentation_order,
    williams_square,
    with_catch_steps,
    without_repeats,
)
from faults import UserError

# The chi-square tests below use fixed seeds: they cannot fail by chance, only by a change.
UNLIKELY = 1e-4


def test_stream_is_the_same_on_every_machine_for_ever():
    # Computed once by `printf '2007\x1f|01\x1f#0' | sha256sum`, independent of Python.
    assert Stream(2007, "01").bits() == int("befe02cce8ceef0c", 16)


@given(st.lists(st.text(), min_size=2, max_size=3), st.lists(st.text(), min_size=2, max_size=3))
def test_different_keys_give_different_streams(one, other):
    assert (Stream(*one).bits() == Stream(*other).bits()) == (one == other)


@given(st.integers(1, 2**64), st.integers())
def test_below_stays_below(bound, seed):
    assert 0 <= Stream(seed).below(bound) < bound


def test_below_favours_no_number_where_the_bound_does_not_divide_the_range_of_the_bits():
    # Of 2**64 numbers, 3 * 2**62 cannot have equal shares: the remainder of a division would give
    # the lowest third two chances in four.
    bound = 3 << 62
    thirds = Counter(Stream("thirds", i).below(bound) >> 62 for i in range(3000))
    assert chisquare([thirds[third] for third in range(3)]).pvalue > UNLIKELY


@pytest.mark.parametrize("bound", [3 << 62, (1 << 63) + 1, 1 << 64])
def test_below_draws_again_exactly_where_the_bits_lie_beyond_the_last_whole_share(bound):
    limit = (1 << 64) // bound * bound
    for seed in range(50):
        twin = Stream("again", seed)
        drawn = next(bits for bits in iter(twin.bits, None) if bits < limit)
        stream = Stream("again", seed)
        assert stream.below(bound) == drawn % bound
        assert stream.bits() == twin.bits()  # as many numbers were taken


def test_uniform_and_normal_deviates_have_their_distributions():
    stream = Stream("distribution")
    assert kstest([stream.uniform() for _ in range(2000)], "uniform").pvalue > UNLIKELY
    assert kstest([stream.normal() for _ in range(2000)], "norm").pvalue > UNLIKELY


def test_shuffles_are_uniform():
    seen = Counter(tuple(Stream("shuffle", i).shuffled("abcd")) for i in range(4800))
    assert len(seen) == 24
    assert chisquare(list(seen.values())).pvalue > UNLIKELY


@pytest.mark.parametrize("size", range(1, 9))
def test_williams_square_balances_places_and_first_order_carry_over(size):
    square = williams_square(size)
    places = Counter((place, c) for row in square for place, c in enumerate(row))
    follows = Counter(pair for row in square for pair in pairwise(row))
    assert all(sorted(row) == list(range(size)) for row in square)
    assert len(set(places.values())) == 1
    assert len(follows) == size * (size - 1)
    assert len(set(follows.values())) <= 1


@pytest.mark.parametrize("pool", ["aabbc", "aaabbb", "abcd", "aabbcc"])
def test_orders_without_repeats_are_uniform_over_all_there_are(pool):
    admitted = {p for p in permutations(pool) if all(x != y for x, y in pairwise(p))}
    draws = 40 * len(admitted)
    seen = Counter(tuple(without_repeats(list(pool), Stream(pool, i))) for i in range(draws))
    assert set(seen) == admitted
    assert chisquare(list(seen.values())).pvalue > UNLIKELY


def test_an_impossible_constraint_is_refused():
    with pytest.raises(UserError, match="must follow itself"):
        without_repeats(list("aaab"), Stream(1))


@given(
    conditions=st.integers(2, 6),
    repetitions=st.integers(1, 5),
    rule=st.sampled_from(["simple", "blocked", "williams"]),
    row=st.integers(0, 50),
    no_repeat=st.booleans(),
)
def test_every_order_presents_each_surface_as_often_as_asked(
    conditions, repetitions, rule, row, no_repeat
):
    blocks = presentation_order(
        conditions, repetitions, rule, stream=Stream(row), row=row, no_immediate_repeat=no_repeat
    )
    flat = [c for block in blocks for c in block]
    assert Counter(flat) == dict.fromkeys(range(conditions), repetitions)
    if rule != "simple":
        assert all(sorted(block) == list(range(conditions)) for block in blocks)
    if no_repeat:
        assert all(a != b for a, b in pairwise(flat))


def test_williams_counterbalances_across_participants():
    rows = [presentation_order(4, 1, "williams", stream=Stream(p), row=p)[0] for p in range(12)]
    follows = Counter(pair for row in rows for pair in pairwise(row))
    assert set(follows.values()) == {3}  # 12 participants x 3 pairs over 12 ordered pairs


def test_catch_steps_change_nothing_and_the_rest_descends():
    steps = with_catch_steps([2.3, 1.2, 0.5, 0.0], 2, Stream("catch"))
    assert sum(a == b for a, b in steps) == 2
    assert [s for s in steps if s[0] != s[1]] == [(2.3, 1.2), (1.2, 0.5), (0.5, 0.0)]
    assert all(one[1] == other[0] for one, other in pairwise(steps))


def test_catch_steps_come_at_every_place_equally_often():
    def place(i):
        steps = with_catch_steps([2.3, 1.2, 0.5, 0.0], 1, Stream("place", i))
        return [a == b for a, b in steps].index(True)

    seen = Counter(place(i) for i in range(1000))
    assert set(seen) == {0, 1, 2, 3}
    assert chisquare(list(seen.values())).pvalue > UNLIKELY
