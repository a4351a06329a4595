"""The orders of surfaces: what each rule admits, and that all it admits is equally likely.

The chi-square tests use fixed seeds: they cannot fail by chance, only by a change. A change of
the draws would fail each with a probability of 1e-4 although nothing is wrong.
"""

from collections import Counter
from itertools import pairwise, permutations, product

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chisquare

from slipscale.experiments.protocol_parts.ordering.no_repeats import without_repeats
from slipscale.experiments.protocol_parts.ordering.orders import practice_order, presentation_order
from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.experiments.protocol_parts.ordering.williams import (
    Place,
    williams_group,
    williams_square,
)
from slipscale.faults import UserError

UNLIKELY = 1e-4
RULES = ["simple", "blocked", "williams"]


def order(conditions, repetitions, rule, *, seed=0, row=0, visit=0, advance=True, alone=True):
    return presentation_order(
        conditions,
        repetitions,
        rule,
        stream=Stream(seed, row, visit),
        shared=lambda group, turn: Stream(seed, "shared", group, turn),
        place=Place(row=row, visit=visit, advance=advance),
        no_immediate_repeat=alone,
    )


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


@pytest.mark.parametrize("kinds, each", [(1, 1), (2, 1), (2, 4), (3, 2), (3, 3), (4, 2)])
def test_orders_without_repeats_are_uniform_over_all_there_are(kinds, each):
    pool = list(range(kinds)) * each
    admitted = {p for p in permutations(pool) if all(x != y for x, y in pairwise(p))}
    draws = 20 * len(admitted)
    seen = Counter(tuple(without_repeats(kinds, each, Stream(kinds, i))) for i in range(draws))
    assert set(seen) == admitted
    if len(admitted) > 1:
        assert chisquare(list(seen.values())).pvalue > UNLIKELY


def test_more_trials_without_repeats_than_can_be_drawn_are_refused():
    with pytest.raises(UserError, match=r'1206 trials .* at most 1200 .* use "blocked"'):
        without_repeats(6, 201, Stream("more"))


def test_many_repetitions_without_repeats_are_drawn_like_few():
    """Once 4 x 60 took a minute and 4 x 300 broke off."""
    drawn = without_repeats(4, 300, Stream("long"))
    assert Counter(drawn) == dict.fromkeys(range(4), 300)
    assert all(one != other for one, other in pairwise(drawn))


@given(
    conditions=st.integers(2, 6),
    repetitions=st.integers(1, 5),
    rule=st.sampled_from(RULES),
    row=st.integers(0, 50),
    alone=st.booleans(),
)
def test_every_order_presents_each_surface_as_often_as_asked(
    conditions, repetitions, rule, row, alone
):
    blocks = order(conditions, repetitions, rule, row=row, visit=row % 6, alone=alone)
    flat = [c for block in blocks for c in block]
    assert Counter(flat) == dict.fromkeys(range(conditions), repetitions)
    if rule != "simple":
        assert all(sorted(block) == list(range(conditions)) for block in blocks)
    if alone:
        assert all(one != other for one, other in pairwise(flat))


@pytest.mark.parametrize("rule", RULES)
def test_a_surface_that_must_follow_itself_is_refused(rule):
    with pytest.raises(UserError, match="a single surface"):
        order(1, 2, rule)
    assert [c for block in order(1, 2, rule, alone=False) for c in block] == [0, 0]


@given(conditions=st.integers(2, 5), repetitions=st.integers(0, 4), seed=st.integers(0, 99))
def test_practice_ends_with_another_surface_than_the_main_trials_begin_with(
    conditions, repetitions, seed
):
    blocks = practice_order(conditions, repetitions, stream=Stream(seed), following=1)
    flat = [*(c for block in blocks for c in block), 1]
    assert all(sorted(block) == list(range(conditions)) for block in blocks)
    assert len(blocks) == repetitions
    assert all(one != other for one, other in pairwise(flat))


def test_practice_of_one_surface_that_the_main_trials_begin_with_is_refused():
    with pytest.raises(UserError, match="a single surface"):
        practice_order(1, 1, stream=Stream(1), following=0)
    assert practice_order(1, 0, stream=Stream(1), following=0) == []
    assert practice_order(1, 2, stream=Stream(1), following=None) == [[0], [0]]


@pytest.mark.parametrize("alone", [True, False])
@pytest.mark.parametrize("conditions, repetitions", [(3, 1), (4, 1), (4, 3), (4, 4), (5, 4)])
def test_a_group_of_williams_runs_is_balanced_whatever_the_seed(conditions, repetitions, alone):
    size = williams_group(conditions, repetitions, no_immediate_repeat=alone)
    for seed, group in product(range(3), (0, 2)):
        rows = range(group * size, (group + 1) * size)
        drawn = [order(conditions, repetitions, "williams", seed=seed, row=r) for r in rows]
        blocks = [block for run in drawn for block in run]
        follows = Counter(pair for block in blocks for pair in pairwise(block))
        places = Counter((place, c) for block in blocks for place, c in enumerate(block))
        assert len(follows) == conditions * (conditions - 1)
        assert len(set(follows.values())) == len(set(places.values())) == 1


def test_a_whole_square_in_one_run_is_balanced_within_the_run():
    blocks = order(4, 4, "williams", row=7)
    assert set(Counter(pair for block in blocks for pair in pairwise(block)).values()) == {1}


def test_williams_orders_differ_between_seeds_and_participants():
    """Once every participant had the same sixteen trials, whatever the seed."""
    drawn = [order(4, 4, "williams", seed=s, row=r) for s in range(5) for r in range(5)]
    assert len({str(blocks) for blocks in drawn}) > 15


def test_every_transition_crosses_the_borders_of_williams_blocks():
    """Once only 4 of 12 did."""
    drawn = [order(4, 4, "williams", row=row) for row in range(60)]
    crossed = {(a[-1], b[0]) for blocks in drawn for a, b in pairwise(blocks)}
    assert crossed == set(permutations(range(4), 2))


def test_two_surfaces_without_repeats_alternate_and_participants_begin_with_either():
    drawn = [order(2, 3, "williams", row=row) for row in range(2)]
    assert sorted(map(str, drawn)) == [str([[0, 1]] * 3), str([[1, 0]] * 3)]


def test_visits_that_advance_take_every_row_of_the_square_in_turn():
    for row in range(4):
        visits = [order(4, 1, "williams", row=row, visit=visit)[0] for visit in range(4)]
        assert len({tuple(each) for each in visits}) == 4
        follows = Counter(pair for each in visits for pair in pairwise(each))
        assert set(follows.values()) == {1}


@pytest.mark.parametrize("advance", [True, False])
def test_every_visit_is_balanced_over_participants(advance):
    for visit in range(6):
        runs = [
            order(4, 1, "williams", row=row, visit=visit, advance=advance)[0] for row in range(4)
        ]
        follows = Counter(pair for run in runs for pair in pairwise(run))
        assert set(follows.values()) == {1}
        assert len(follows) == 12


def test_after_a_whole_turn_the_design_is_drawn_anew():
    turns = [order(5, 1, "williams", row=0, visit=10 * turn) for turn in range(4)]
    assert len({str(each) for each in turns}) == 4


@pytest.mark.parametrize("alone", [True, False])
@pytest.mark.parametrize("rule", RULES)
def test_transitions_are_uniform_also_across_the_borders_of_blocks(rule, alone):
    """One participant of each Williams group: the others of a group are not independent."""
    size = williams_group(4, 2, no_immediate_repeat=alone)
    runs = [order(4, 2, rule, seed=alone, row=size * n + n % size, alone=alone) for n in range(960)]
    flat = [[c for block in run for c in block] for run in runs]
    for place in (1, 3, 6):  # inside the first block, across the border, inside the second
        seen = Counter((each[place], each[place + 1]) for each in flat)
        unequal = [seen[pair] for pair in permutations(range(4), 2)]
        assert chisquare(unequal).pvalue > UNLIKELY
        assert not alone or sum(unequal) == 960
    assert chisquare([Counter(each[0] for each in flat)[c] for c in range(4)]).pvalue > UNLIKELY
