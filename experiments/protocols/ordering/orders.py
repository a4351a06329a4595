"""The order in which surfaces are presented, by the rule that the study names.

All orders are uniform over what their rule admits, in whole numbers throughout: the same on every
machine. A change of any draw needs a new `ORDER_VERSION`: a run is resumed only with the orders
of its beginning (docs/decisions/random-orders.md).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from slipscale.experiments.protocols.ordering.no_repeats import ALONE, without_repeats
from slipscale.experiments.protocols.ordering.williams import williams_blocks
from slipscale.faults import UserError

if TYPE_CHECKING:
    from collections.abc import Callable

    from slipscale.experiments.protocols.ordering.randomisation import Stream
    from slipscale.experiments.protocols.ordering.williams import Place

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
    """Return the order in which conditions are presented.

    Parameters
    ----------
    conditions : int
        How many surfaces; they are numbered 0 ... conditions - 1.
    repetitions : int
        How often each is presented.
    rule : {"simple", "blocked", "williams"}
        All shuffled together; each once a block, shuffled within; or each block a row of a
        Williams square, so that carry-over is balanced across blocks and participants.
    stream : Stream
        The run's own random numbers.
    shared : callable
        Returns, for group and turn (see `Place.within`), the random numbers that all runs of the
        group have in common: they draw the design that is divided among them, for "williams".
    place : Place
        Where the run stands in the counterbalancing, for "williams".
    no_immediate_repeat : bool
        No surface follows itself, across the limits of blocks neither.

    Returns
    -------
    list of list of int
        Blocks of conditions; "simple" is one block.

    Raises
    ------
    UserError
        A surface must follow itself, as there is no other.
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
    """Return the blocks of practice: each condition once a block, shuffled within.

    Parameters
    ----------
    conditions, repetitions, stream
        See `presentation_order`.
    following : int or None
        What is presented first after the practice. No condition follows itself then, up to and
        including that one; None: they may.

    Raises
    ------
    UserError
        A surface must follow itself, as there is no other.
    """
    if following is not None and conditions == 1 and repetitions:
        raise UserError(ALONE)
    blocks: list[list[int]] = []
    # From the end: the practice gives way to the order that is analysed, not the other way round.
    for _ in range(repetitions):
        block = stream.shuffled(range(conditions))
        while following is not None and block[-1] == following:
            block = stream.shuffled(range(conditions))
        following = None if following is None else block[0]
        blocks.insert(0, block)
    return blocks
