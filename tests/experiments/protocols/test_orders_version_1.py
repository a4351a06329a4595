"""The orders that version 1 drew: journals of its time are replayed with them."""

from collections import Counter
from itertools import pairwise, permutations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chisquare

from slipscale.experiments.protocols.orders_version_1 import presentation_order, without_repeats
from slipscale.experiments.protocols.randomisation import Stream
from slipscale.experiments.protocols.williams import williams_square
from slipscale.faults import UserError

UNLIKELY = 1e-4  # seeds are fixed: see test_orders


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
        with pytest.raises(UserError) as refusal:
            presentation_order(1, 2, rule, stream=Stream(1), row=0, no_immediate_repeat=True)
        assert str(refusal.value) == (
            "no_immediate_repeat: one surface alone must follow itself; use more surfaces, or "
            "no_immediate_repeat = false"
        )


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


def test_a_block_that_would_begin_with_the_last_surface_is_drawn_anew_by_its_own_rule():
    """Pinned draw by draw: a run that is resumed must find the order that it began with."""
    redrawn = 0
    for seed in range(60):
        stream = Stream("redrawn", seed)
        first, second = stream.shuffled(range(4)), stream.shuffled(range(4))
        while first[-1] == second[0]:
            second, redrawn = stream.shuffled(range(4)), redrawn + 1
        found = presentation_order(
            4, 2, "blocked", stream=Stream("redrawn", seed), row=0, no_immediate_repeat=True
        )
        assert found == [first, second]
    assert redrawn > 5


def test_a_williams_row_that_would_begin_with_the_last_surface_gives_way_to_another_row():
    square = williams_square(3)
    assert square[3][-1] == square[4][0]
    for seed in range(20):
        stream = Stream("row", seed)
        while (last := stream.choice(square))[0] == square[3][-1]:
            pass
        found = presentation_order(
            3, 5, "williams", stream=Stream("row", seed), row=0, no_immediate_repeat=True
        )
        assert found == [*square[:4], last]


def test_a_participant_s_blocks_are_neighbouring_rows_and_so_are_participants():
    # The first row is 0, 1, n-1, 2 and the others add 1 to each (Williams 1949).
    square = [[0, 1, 3, 2], [1, 2, 0, 3], [2, 3, 1, 0], [3, 0, 2, 1]]
    assert williams_square(4) == square
    for row in (0, 1, 5):
        blocks = presentation_order(4, 3, "williams", stream=Stream(1), row=row)
        assert blocks == [square[(3 * row + block) % 4] for block in range(3)]
