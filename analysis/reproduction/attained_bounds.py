"""Bounds on test statistics over all data sets consistent with Table III.

A search over all pairs of data sets takes minutes. The tables of ratings in which it found the
lowest and highest values are therefore recorded. Bounds are computed from these tables, after
checking that they are consistent with Table III. Only the search proves that no other data set
gives a lower or higher value. To repeat this search, run ``python -m
slipscale.analysis.reproduction.attained_bounds``.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import cache
from math import inf
from pathlib import Path

import numpy as np

from slipscale.analysis.reconstruction.counts.state_table import Array
from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.data_sets.witness import gives_what_is_printed
from slipscale.analysis.reconstruction.inference.bounds import Range, Table, as_table
from slipscale.analysis.reconstruction.inference.conclusions import (
    Conclusion,
    conclusions,
    f_test,
    signs,
    t_test,
)
from slipscale.analysis.reconstruction.table.published_table import CONVENTIONS, Convention
from slipscale.analysis.reproduction.allowed_datasets import columns
from slipscale.analysis.statistics.repeated_measures import batched

RECORDED = Path(__file__).with_name("recorded") / "attained_bounds.json"
COMMAND = "python -m slipscale.analysis.reproduction.attained_bounds"


def _participants_higher(tables: Array) -> Array:
    found: Array = (tables[:, :, 1] > tables[:, :, 0]).sum(axis=1)
    return found


# Functions that return the conclusion and compute the statistic, for each kind of conclusion.
KINDS: dict[
    str, tuple[Callable[[Sequence[Solutions], Range], Conclusion], Callable[[Array], Array]]
] = {
    "sign": (signs, _participants_higher),
    "t": (t_test, batched.paired_t),
    "rm_f": (f_test, batched.repeated_measures_f),
}


@cache
def known(convention: Convention) -> tuple[Conclusion, ...]:
    """Return the conclusions from the recorded tables under one SD convention.

    Raises
    ------
    ValueError
        If a recorded table is not consistent with Table III.
    """
    chosen = {s.column.label: s for s in _columns(convention)}
    found = []
    for name, ends in json.loads(RECORDED.read_text(encoding="utf-8"))[convention].items():
        concerned = [chosen[label] for label in ends["columns"]]
        test, statistic = KINDS[name.partition(".")[0]]
        tables = [_checked(name, concerned, ends[end]) for end in ("lowest", "highest")]
        values = [
            float(statistic(np.array(table, dtype=float).T[None])[0]) if table else inf
            for table in tables
        ]
        found.append(test(concerned, Range(values[0], values[1], *tables)))
    return tuple(found)


def _columns(convention: Convention) -> list[Solutions]:
    return [one.under(convention, one.column.rounding) for one in columns()]


def _checked(name: str, concerned: Sequence[Solutions], table: Sequence[Sequence[int]]) -> Table:
    """Return the ratings in a table, after checking that they are consistent with Table III."""
    for solutions, row in zip(concerned, table, strict=bool(table)):
        if not gives_what_is_printed(solutions.column, row):
            raise ValueError(
                f"{RECORDED.name}, {name}: column {solutions.column.label} is not consistent with "
                "Table III"
            )
    return as_table(*(np.array(row) for row in table))


def search(convention: Convention) -> list[Conclusion]:
    """Search all data sets and pairings for the bounds. This takes minutes."""
    found = conclusions([Sampler(solutions) for solutions in _columns(convention)])
    return [one for one in found if one.name.partition(".")[0] in KINDS]


def _record() -> None:
    entries: dict[str, dict[str, dict[str, object]]] = {
        convention: {
            one.name: {
                "columns": one.labels,
                **{
                    end: [[int(v) for v in row] for row in table]
                    for end, table in (("lowest", one.at_low), ("highest", one.at_high))
                },
            }
            for one in search(convention)
        }
        for convention in CONVENTIONS
    }
    RECORDED.write_text(_text(entries), encoding="utf-8")


def _text(entries: dict[str, dict[str, dict[str, object]]]) -> str:
    """Format the entries as JSON with one line per bound, so that diffs are readable."""
    parts = [
        f"{json.dumps(convention)}: {{\n"
        + ",\n".join(f"{json.dumps(name)}: {json.dumps(ends)}" for name, ends in bounds.items())
        + "\n}"
        for convention, bounds in entries.items()
    ]
    return "{\n" + ",\n".join(parts) + "\n}\n"


if __name__ == "__main__":
    _record()
