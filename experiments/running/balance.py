"""Describe how well a study's orders are balanced across the planned participants."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import chain, pairwise, permutations
from typing import TYPE_CHECKING, Literal

from slipscale.experiments.protocol_parts.ordering.williams import williams_group, williams_square
from slipscale.faults.message import Message, joined

if TYPE_CHECKING:
    from slipscale.experiments.protocol_parts.building_blocks.rated_surfaces import RatedOptions

NAMED = 8  # larger numbers of transitions are counted instead of listed
COUNTED = {
    "block": ("{count} block", "{count} blocks"),
    "run": ("{count} run", "{count} runs"),
    "time": ("{count} time", "{count} times"),
    "transition": ("{count} transition", "{count} transitions"),
}


def order_balance(
    options: RatedOptions, surfaces: Sequence[str], runs: Sequence[Sequence[Sequence[str]]]
) -> str:
    """Describe in one sentence how often each surface follows every other surface.

    Parameters
    ----------
    options : RatedOptions
        Options of the task.
    surfaces : sequence of str
        Names of all surfaces.
    runs : sequence
        The blocks of main trials in each run; each block is a sequence of surface names.
    """
    pairs = list(permutations(surfaces, 2))
    if not pairs:
        return "one surface: no order to balance"
    if options.randomisation != "williams":
        follows = Counter(chain.from_iterable(pairwise(chain.from_iterable(run)) for run in runs))
        counts = [follows[pair] for pair in pairs]
        return Message(
            "{randomisation}: orders are drawn independently and are balanced on average; "
            "here each surface follows every other surface {times}",
            randomisation=options.randomisation,
            times=_times(min(counts), max(counts)),
        )
    blocks = [block for run in runs for block in run]
    follows = Counter(chain.from_iterable(map(pairwise, blocks)))
    by_count: dict[int, list[tuple[str, str]]] = {}
    for pair in pairs:
        by_count.setdefault(follows[pair], []).append(pair)
    rows = len(williams_square(len(surfaces)))
    group = williams_group(
        len(surfaces), options.repetitions, no_immediate_repeat=options.no_immediate_repeat
    )
    filled = Message(
        "{blocks} in {runs}", blocks=_many(len(blocks), "block"), runs=_many(len(runs), "run")
    )
    if len(by_count) == 1:
        return Message(
            "williams: {filled} are balanced with squares of {rows} rows; within blocks each "
            "surface follows every other surface {times}",
            filled=filled,
            rows=rows,
            times=_times(next(iter(by_count))),
        )
    usual = max(by_count, key=lambda count: (len(by_count[count]), count))
    unequal = joined(
        "; ",
        (
            Message(
                "{transitions} come {times}" if len(names) > 1 else "{transitions} comes {times}",
                transitions=_listed(names),
                times=_times(count),
            )
            for count, names in sorted(by_count.items())
            if count != usual
        ),
    )
    return Message(
        "williams: {filled} do not fill complete squares of {rows} rows; within blocks "
        "{unequal}; the other {transitions} {times}; {group} participants, or a multiple of "
        "{group}, would be balanced",
        filled=filled,
        rows=rows,
        unequal=unequal,
        transitions=_many(len(by_count[usual]), "transition"),
        times=_times(usual),
        group=group,
    )


def task_balance(first: Iterable[str]) -> str:
    """Describe in one sentence how often each task comes first; ``first`` has one task per run."""
    counts = Counter(first)
    balance = joined(
        ", ",
        (
            Message("{task} first in {runs}", task=task, runs=_many(count, "run"))
            for task, count in counts.items()
        ),
    )
    if len(counts) > 1 and len(set(counts.values())) == 1:
        return Message("task order: {balance}", balance=balance)
    return Message(
        "task order: {balance}; an even number of runs would be balanced", balance=balance
    )


def _times(least: int, most: int | None = None) -> str:
    if most is None or most == least:
        return _many(least, "time")
    return Message("{least} to {most} times", least=least, most=most)


def _many(count: int, thing: Literal["block", "run", "time", "transition"]) -> str:
    one, several = COUNTED[thing]
    return Message(one if count == 1 else several, count=count)


def _listed(transitions: Sequence[tuple[str, str]]) -> str:
    listed = joined(
        ", ",
        (
            Message("{before} then {after}", before=before, after=after)
            for before, after in transitions[:NAMED]
        ),
    )
    more = len(transitions) - NAMED
    return Message("{listed} and {more} more", listed=listed, more=more) if more > 0 else listed
