"""Orders as version 1 of the rule drew them, kept so that journals of that time can be replayed.

Nothing new is drawn here: `slipscale.experiments.protocols.orders` draws what begins now. What was
wrong with these is told in docs/decisions/0130.
"""

from __future__ import annotations

from collections import Counter
from functools import cache
from typing import TYPE_CHECKING, TypeVar

from slipscale.experiments.protocols.no_repeats import ALONE
from slipscale.experiments.protocols.williams import williams_square
from slipscale.faults import UserError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.experiments.protocols.orders import Rule
    from slipscale.experiments.protocols.randomisation import Stream

Item = TypeVar("Item")


@cache
def _arrangements(counts: tuple[int, ...], last: int) -> int:
    """Count the orders of a multiset without immediate repeats.

    ``counts`` are how many of each kind are left, sorted; ``last`` is how many are left of the
    kind that stood last (-1: nothing stood before), for kinds with equal counts are alike.
    """
    if not any(counts):
        return 1
    total = 0
    barred = last >= 0
    for count, kinds in Counter(counts).items():
        free = kinds - (1 if barred and count == last else 0)
        if count and free:
            left = list(counts)
            left[left.index(count)] -= 1
            total += free * _arrangements(tuple(sorted(left)), count - 1)
    return total


def without_repeats(items: Sequence[Item], stream: Stream) -> list[Item]:
    """Return the items in an order uniform over those in which no neighbours are equal.

    Raises
    ------
    UserError
        There is no such order.
    """
    kinds = list(dict.fromkeys(items))
    left = [items.count(kind) for kind in kinds]
    if not _arrangements(tuple(sorted(left)), -1):
        raise UserError(
            "no_immediate_repeat: one surface is presented so often that it must follow itself; "
            "use more surfaces or fewer repetitions of it"
        )
    order: list[Item] = []
    previous: int | None = None
    for _ in items:
        ways = []
        for kind, count in enumerate(left):
            rest = left.copy()
            rest[kind] -= 1
            allowed = count and kind != previous
            ways.append(_arrangements(tuple(sorted(rest)), rest[kind]) if allowed else 0)
        rank = stream.below_any(sum(ways))
        kind = 0
        while rank >= ways[kind]:
            rank -= ways[kind]
            kind += 1
        left[kind] -= 1
        previous = kind
        order.append(kinds[kind])
    return order


def presentation_order(
    conditions: int,
    repetitions: int,
    rule: Rule,
    *,
    stream: Stream,
    row: int,
    no_immediate_repeat: bool = False,
) -> list[list[int]]:
    """Return the order that version 1 gave; see `orders.presentation_order`.

    ``row`` is the participant's place in the counterbalancing (0, 1, ...), for "williams".
    """
    everything = list(range(conditions))
    if rule == "simple":
        pool = everything * repetitions
        return [without_repeats(pool, stream) if no_immediate_repeat else stream.shuffled(pool)]
    square = williams_square(conditions)
    blocks: list[list[int]] = []
    for block in range(repetitions):
        # Neighbouring participants take neighbouring rows, and so do a participant's own blocks.
        order = (
            square[(row * repetitions + block) % len(square)]
            if rule == "williams"
            else stream.shuffled(everything)
        )
        clash = no_immediate_repeat and blocks and blocks[-1][-1] == order[0]
        if clash and conditions == 1:
            raise UserError(ALONE)
        while clash and blocks[-1][-1] == order[0]:
            order = stream.choice(square) if rule == "williams" else stream.shuffled(everything)
        blocks.append(list(order))
    return blocks
