"""Draw orders of surfaces for thousands of simulated participants.

Orders have the same distribution as in the protocol
(`slipscale.experiments.protocol_parts.ordering.orders`). Blocks are shuffled for all participants
at once. For all other rules, the protocol's code generates a pool of random designs, each for one
or more people. Each simulated person or group is assigned a design from the pool, and the surfaces
are renumbered at random. Renumbering does not change the probability of any order.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from slipscale.experiments.protocol_parts.ordering.orders import Rule, presentation_order
from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.experiments.protocol_parts.ordering.williams import Place, williams_group

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Orders = NDArray[np.int64]

#: Number of groups in the pool. A group contains one order, or a balanced set of orders.
POOL = 500


def draw_orders(
    rule: Rule,
    surfaces: int,
    repetitions: int,
    practice: int,
    *,
    no_immediate_repeat: bool,
    shape: tuple[int, int],
    rng: np.random.Generator,
) -> Orders:
    """Draw the order of surfaces for each participant, practice trials first.

    The result has the shape (studies, participants, trials).

    Parameters
    ----------
    rule : {"simple", "blocked", "williams"}
    surfaces, repetitions, practice : int
        Number of surfaces (numbered from 0), and number of presentations of each surface in main
        trials and in the preceding practice.
    no_immediate_repeat : bool
        Whether immediate repetitions of a surface are excluded.
    shape : (int, int)
        Number of studies, and number of participants per study.
    rng : Generator
        The only source of random numbers.
    """
    apart = no_immediate_repeat and surfaces > 1
    if rule == "blocked" or (rule == "simple" and (repetitions == 1 or not apart)):
        size = surfaces if rule == "blocked" else surfaces * repetitions
        kinds = np.arange(size) % surfaces
        main: list[Orders] = []
        for _ in range(surfaces * repetitions // size):
            after = main[-1][..., -1] if main and apart else None
            main.append(_shuffled(kinds, shape, rng, after=after))
    else:
        main = [_from_pool(rule, surfaces, repetitions, apart=apart, shape=shape, rng=rng)]
    before: list[Orders] = []
    # Main trials are drawn first, so that only the practice order is adjusted to avoid repeats.
    for _ in range(practice):
        first = (before or main)[0][..., 0]
        kinds = np.arange(surfaces)
        before.insert(0, _shuffled(kinds, shape, rng, before=first if apart else None))
    return np.concatenate([*before, *main], axis=2)


def _shuffled(
    kinds: Orders,
    shape: tuple[int, int],
    rng: np.random.Generator,
    *,
    after: Orders | None = None,
    before: Orders | None = None,
) -> Orders:
    """Shuffle the surfaces; repeat the shuffle if a surface would be presented twice in a row."""
    found = rng.permuted(np.broadcast_to(kinds, (*shape, len(kinds))), axis=2)
    if after is None and before is None:
        return found
    while True:
        clash = found[..., 0] == after if after is not None else found[..., -1] == before
        if not clash.any():
            return found
        found[clash] = rng.permuted(found[clash], axis=1)


def _from_pool(
    rule: Rule,
    surfaces: int,
    repetitions: int,
    *,
    apart: bool,
    shape: tuple[int, int],
    rng: np.random.Generator,
) -> Orders:
    studies, participants = shape
    pool = _pool(rule, surfaces, repetitions, apart)
    size = pool.shape[1]
    groups = -(-participants // size)
    drawn = pool[rng.integers(len(pool), size=(studies, groups))]
    labels = rng.permuted(np.broadcast_to(np.arange(surfaces), (studies, groups, surfaces)), axis=2)
    named = np.take_along_axis(labels[:, :, None], drawn, axis=3)
    return named.reshape(studies, groups * size, -1)[:, :participants]


@cache
def _pool(rule: Rule, surfaces: int, repetitions: int, apart: bool) -> Orders:
    """Draw the pool of orders; its shape is (groups, participants, trials)."""
    size = 1
    if rule == "williams":
        size = williams_group(surfaces, repetitions, no_immediate_repeat=apart)

    def order(group: int, row: int) -> list[int]:
        blocks = presentation_order(
            surfaces,
            repetitions,
            rule,
            stream=Stream("pool of orders", group, row),
            shared=lambda *of: Stream("pool of designs", *of),
            place=Place(row=group * size + row),
            no_immediate_repeat=apart,
        )
        return [each for block in blocks for each in block]

    return np.array([[order(group, row) for row in range(size)] for group in range(POOL)])
