import hashlib
from collections import Counter
from itertools import pairwise, permutations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chisquare, kstest

from experiments.protocols.randomisation import (
    Stream,
    _below_big,
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


@pytest.mark.parametrize(
    "key, text", [((2007, "01"), "2007\x1f|01"), (("a\x1fb",), "a\x1f\x1fb"), ((), "")]
)
def test_the_bits_are_sha_256_of_the_key_and_a_counter(key, text):
    expected = [
        int(hashlib.sha256(f"{text}\x1f#{count}".encode()).hexdigest()[:16], 16)
        for count in range(4)
    ]
    stream = Stream(*key)
    assert [stream.bits() for _ in range(4)] == expected


class Given(Stream):
    """A stream of given bits."""

    def __init__(self, *bits):
        super().__init__()
        self.left = list(bits)

    def bits(self):
        return self.left.pop(0)


ONES = (1 << 64) - 1


def test_uniform_numbers_stay_inside_their_interval_at_either_end():
    assert Given(0).uniform() == 0.5 / 2**52
    assert Given(ONES).uniform() == 1 - 0.5 / 2**52 < 1


def test_below_draws_again_at_the_very_limit():
    limit = (1 << 64) - (1 << 64) % 10
    assert Given(limit, 5).below(10) == 5
    assert Given(limit - 1).below(10) == 9


@pytest.mark.parametrize("bound", [0, -1, (1 << 64) + 1])
def test_below_refuses_a_bound_beyond_its_bits(bound):
    with pytest.raises(ValueError, match=rf"bound is {bound}, expected 1 to 2\*\*64"):
        Stream().below(bound)
    assert Given(7).below(1 << 64) == 7


@pytest.mark.parametrize(
    "bound, words", [(3, 2), ((1 << 64) - 1, 2), (1 << 64, 3), ((1 << 66) - 1, 3)]
)
def test_a_number_below_a_large_bound_takes_64_bits_more_than_the_bound_has(bound, words):
    bits = list(range(5, 5 + words))
    stream = Given(*bits, 99)
    value = sum(word << 64 * place for place, word in enumerate(reversed(bits)))
    assert _below_big(bound, stream) == value % bound
    assert stream.left == [99]


def test_a_large_number_is_drawn_again_beyond_the_last_whole_share():
    # 2**128 leaves 1 when divided by 3: only the very last number has no share.
    assert _below_big(3, Given(ONES, ONES, 0, 7)) == 1
    assert _below_big(3, Given(ONES, ONES - 1)) == 2


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
    assert len(square) == (size if size % 2 == 0 else 2 * size)
    assert all(type(condition) is int for row in square for condition in row)
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
    with pytest.raises(UserError) as refusal:
        without_repeats(list("aaab"), Stream(1))
    assert str(refusal.value) == (
        "no_immediate_repeat: one surface is presented so often that it must follow itself; use "
        "more surfaces or fewer repetitions of it"
    )
    for rule in ("blocked", "williams"):
        with pytest.raises(UserError, match="no_immediate_repeat: one surface alone must"):
            presentation_order(1, 2, rule, stream=Stream(1), row=0, no_immediate_repeat=True)


def test_one_item_alone_is_an_order():
    assert without_repeats(["a"], Stream(1)) == ["a"]


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


def orders(rule, *, repetitions=2, no_repeat=False, count=200):
    return [
        presentation_order(
            4, repetitions, rule, stream=Stream(n), row=n, no_immediate_repeat=no_repeat
        )
        for n in range(count)
    ]


def test_simple_order_is_one_block_in_which_a_surface_may_follow_itself_unless_barred():
    found = orders("simple")
    assert {len(order) for order in found} == {1}
    assert any(a == b for (block,) in found for a, b in pairwise(block))
    free = presentation_order(1, 2, "simple", stream=Stream(1), row=0)
    assert free == [[0, 0]]


@pytest.mark.parametrize("no_repeat", [False, True])
def test_blocked_order_takes_every_order_in_every_block(no_repeat):
    found = orders("blocked", no_repeat=no_repeat)
    for block in (0, 1):
        assert len({tuple(order[block]) for order in found}) == 24


@pytest.mark.parametrize("no_repeat", [False, True])
def test_williams_order_takes_rows_of_the_square_and_all_of_them(no_repeat):
    square = {tuple(row) for row in williams_square(4)}
    found = [tuple(b) for order in orders("williams", no_repeat=no_repeat) for b in order]
    assert set(found) == square


def test_a_participant_s_blocks_are_neighbouring_rows_and_so_are_participants():
    # The first row is 0, 1, n-1, 2 and the others add 1 to each (Williams 1949).
    square = [[0, 1, 3, 2], [1, 2, 0, 3], [2, 3, 1, 0], [3, 0, 2, 1]]
    assert williams_square(4) == square
    for row in (0, 1, 5):
        blocks = presentation_order(4, 3, "williams", stream=Stream(1), row=row)
        assert blocks == [square[(3 * row + block) % 4] for block in range(3)]


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
