"""Individual curves: each participant's answers by level, from the tables of the data set.

The curves give a first impression of the main trials, without normalisation or exclusions. They
unblind the viewer.
"""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from math import isfinite
from pathlib import Path
from typing import NamedTuple

from slipscale.faults.folders import visible
from slipscale.stimuli.quantity import Quantity

TRUTH = {"true": 1.0, "false": 0.0}


class Axes(NamedTuple):
    """Names of the table columns on a curve's x and y axes."""

    x: str
    y: str


# Pairs of columns to plot: answers against level, or the level of an adaptive track against trial
# number. The first pair that a table contains is used.
AXES = (
    Axes("trial", "track_level"),
    Axes("level", "estimate"),
    Axes("level", "rating"),
    Axes("level", "ratio"),
    Axes("comparison_level", "comparison_more"),
    Axes("interval1_level", "matched_level"),
    Axes("number", "produced_level"),
    Axes("step", "difference_felt"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """A participant's curve for one run of a task.

    Parameters
    ----------
    label, task : str
        Label of the participant, and label of the task in the file name.
    x, y : str
        Columns of the table.
    points : tuple of (float, float)
        Mean of ``y`` for each value of ``x``, sorted by ``x``; true counts as 1 and false as 0.
    """

    label: str
    task: str
    x: str
    y: str
    points: tuple[tuple[float, float], ...]


def curves(dataset: Path, quantity: Quantity, label: str = "*") -> list[Curve]:
    """Return the curves of all participants, or of one participant, sorted by file name."""
    paths = visible(dataset, f"sub-{label}/**/beh/*_beh.tsv")
    found = (_curve(path, quantity, path.stat().st_mtime_ns) for path in paths)
    return [each for each in found if each]


@lru_cache(maxsize=1024)
def _curve(path: Path, quantity: Quantity, _changed_ns: int) -> Curve | None:
    with path.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream, delimiter="\t"))
    entities = dict(part.split("-", 1) for part in path.stem.split("_") if "-" in part)
    for axes in AXES:
        x, y = quantity.named(axes.x), quantity.named(axes.y)
        points = tuple(_means(_main(rows), x, y))
        if points:
            task = entities.get("task", "")
            return Curve(label=entities.get("sub", ""), task=task, x=x, y=y, points=points)
    return None


def _main(rows: Iterable[Mapping[str, str]]) -> Iterator[Mapping[str, str]]:
    """Yield the rows of main trials, excluding practice and catch trials."""
    for row in rows:
        if row.get("phase") != "practice" and row.get("catch") != "true":
            yield row


def _means(rows: Iterable[Mapping[str, str]], x: str, y: str) -> Iterator[tuple[float, float]]:
    """Yield the mean of y for each value of x, ignoring missing and non-numeric cells."""
    by_x: dict[float, list[float]] = defaultdict(list)
    for row in rows:
        at, value = _number(row.get(x)), _number(row.get(y))
        if at is not None and value is not None:
            by_x[at].append(value)
    for at in sorted(by_x):
        yield at, sum(by_x[at]) / len(by_x[at])


def _number(cell: str | None) -> float | None:
    if cell in TRUTH:
        return TRUTH[cell]
    try:
        value = float(cell or "")
    except ValueError:
        return None
    return value if isfinite(value) else None
