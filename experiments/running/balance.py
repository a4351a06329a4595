"""Describe how well a study's orders are balanced across the planned participants."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import chain, pairwise, permutations
from typing import TYPE_CHECKING

from slipscale.experiments.protocol_parts.ordering.williams import williams_group, williams_square
from slipscale.faults.message import Message

if TYPE_CHECKING:
    from slipscale.experiments.protocol_parts.building_blocks.rated_surfaces import RatedOptions

NAMED = 8  # larger numbers of transitions are counted instead of listed


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
    by_count: dict[int, list[str]] = {}
    for before, after in pairs:
        by_count.setdefault(follows[before, after], []).append(f"{before} then {after}")
    rows = len(williams_square(len(surfaces)))
    group = williams_group(
        len(surfaces), options.repetitions, no_immediate_repeat=options.no_immediate_repeat
    )
    filled = f"{_many(len(blocks), 'block')} in {_many(len(runs), 'run')}"
    if len(by_count) == 1:
        each = _times(next(iter(by_count)))
        return Message(
            "williams: {filled} are balanced with squares of {rows} rows; within blocks each "
            "surface follows every other surface {each}",
            filled=filled,
            rows=rows,
            each=each,
        )
    usual = max(by_count, key=lambda count: (len(by_count[count]), count))
    unequal = "; ".join(
        f"{_listed(names)} {'come' if len(names) > 1 else 'comes'} {_times(count)}"
        for count, names in sorted(by_count.items())
        if count != usual
    )
    others = "transition" if len(by_count[usual]) == 1 else "transitions"
    return (
        f"williams: {filled} do not fill complete squares of {rows} rows; within blocks "
        f"{unequal}; the other {len(by_count[usual])} {others} {_times(usual)}; {group} "
        f"participants, or a multiple of {group}, would be balanced"
    )


def task_balance(first: Iterable[str]) -> str:
    """Describe in one sentence how often each task comes first; ``first`` has one task per run."""
    counts = Counter(first)
    each = ", ".join(f"{task} first in {_many(count, 'run')}" for task, count in counts.items())
    even = len(counts) > 1 and len(set(counts.values())) == 1
    return Message("task order: {each}", each=each) + (
        "" if even else "; an even number of runs would be balanced"
    )


def _times(least: int, most: int | None = None) -> str:
    span = f"{least}" if most is None or most == least else f"{least} to {most}"
    return f"{span} {'time' if span == '1' else 'times'}"


def _many(count: int, thing: str) -> str:
    return f"{count} {thing}" if count == 1 else f"{count} {thing}s"


def _listed(names: Sequence[str]) -> str:
    more = len(names) - NAMED
    return ", ".join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")
