"""Generate the presentation order of surfaces according to a rule.

Orders are drawn uniformly from all orders that the rule allows. Only integer arithmetic is used, so
orders are the same on every machine. Any change in the generated orders requires a new
`ORDER_VERSION`, because a run can only be resumed with its original orders
(docs/decisions/random-orders.md).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from slipscale.experiments.protocol_parts.ordering.no_repeats import ALONE, without_repeats
from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.experiments.protocol_parts.ordering.williams import Place, williams_blocks
from slipscale.faults import UserError

Rule = Literal["simple", "blocked", "williams"]


def presentation_order(
    conditions: int,
    repetitions: int,
    rule: Rule,
    *,
    stream: Stream,
    shared: Callable[[int, int], Stream],
    place: Place,
    no_immediate_repeat: bool = False,
) -> list[list[int]]:
    """Return the presentation order of the conditions, in blocks.

    Parameters
    ----------
    conditions : int
        Number of surfaces, which are numbered from 0 to ``conditions - 1``.
    repetitions : int
        Number of times that each surface is presented.
    rule : {"simple", "blocked", "williams"}
        "simple" shuffles all trials together. "blocked" presents each surface once per block,
        shuffled within the block. "williams" uses a row of a Williams square for each block, which
        balances carry-over across blocks and participants.
    stream : Stream
        The run's stream of random numbers.
    shared : callable
        Returns the random number stream for the design of a group of runs, given the group number
        and the turn number from `Place.within`. With "williams", each run of a group uses a part of
        the same design.
    place : Place
        The run's position in the counterbalancing, used by "williams".
    no_immediate_repeat : bool
        Whether immediate repetitions are forbidden, including across blocks.

    Returns
    -------
    list of list of int
        The conditions of each block. The rule "simple" gives a single block.

    Raises
    ------
    UserError
        If ``no_immediate_repeat`` is True, and a single surface is presented more than once or
        there are too many trials for the rule "simple".
    """
    if no_immediate_repeat and conditions == 1 and repetitions > 1:
        raise UserError(ALONE)
    if rule == "williams":
        return williams_blocks(conditions, repetitions, shared, place, no_immediate_repeat)
    if rule == "simple":
        if no_immediate_repeat:
            return [without_repeats(conditions, repetitions, stream)]
        return [stream.shuffled(list(range(conditions)) * repetitions)]
    blocks: list[list[int]] = []
    for _ in range(repetitions):
        block = stream.shuffled(range(conditions))
        while no_immediate_repeat and blocks and blocks[-1][-1] == block[0]:
            block = stream.shuffled(range(conditions))
        blocks.append(block)
    return blocks


def practice_order(
    conditions: int, repetitions: int, *, stream: Stream, following: int | None
) -> list[list[int]]:
    """Return the practice blocks: each condition once per block, shuffled within the block.

    Parameters
    ----------
    conditions, repetitions, stream
        See `presentation_order`.
    following : int or None
        First condition after practice. If it is not None, no condition is presented twice in a
        row, either during practice or from practice to the next block. If None, immediate repeats
        are allowed.

    Raises
    ------
    UserError
        If immediate repetitions are forbidden, but practice has only one surface.
    """
    if following is not None and conditions == 1 and repetitions:
        raise UserError(ALONE)
    blocks: list[list[int]] = []
    # Blocks are generated from last to first, so that practice adapts to the main order.
    for _ in range(repetitions):
        block = stream.shuffled(range(conditions))
        while following is not None and block[-1] == following:
            block = stream.shuffled(range(conditions))
        following = None if following is None else block[0]
        blocks.insert(0, block)
    return blocks
