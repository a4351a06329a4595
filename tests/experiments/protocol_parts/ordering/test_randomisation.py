import hashlib
from collections import Counter
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chisquare, kstest

from slipscale.experiments.protocol_parts.ordering.randomisation import Stream, with_catch_steps

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
    assert stream.below_any(bound) == value % bound
    assert stream.left == [99]


def test_a_large_number_is_drawn_again_beyond_the_last_whole_share():
    # 2**128 leaves 1 when divided by 3: only the very last number has no share.
    assert Given(ONES, ONES, 0, 7).below_any(3) == 1
    assert Given(ONES, ONES - 1).below_any(3) == 2


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
