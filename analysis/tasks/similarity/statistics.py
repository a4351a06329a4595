"""Compute multidimensional scaling of dissimilarity ratings.

Each participant's dissimilarities are averaged over orders and repetitions, and divided by their
root mean square, so that all participants have equal weight. In free sorting, the dissimilarity of
a pair is the proportion of participants who put the two items into different groups. No participant
weights are computed for free sorting, because a single participant's dissimilarities are only 0 or
1.

The group map is non-metric (Kruskal 1964, Psychometrika 29, 1-27 and 115-129). The SMACOF algorithm
(de Leeuw 1977) starts from the classical solution, from random maps and from the map with one
dimension less; the solution with the lowest stress-1 is rotated to its principal axes.

Ties have Kruskal's primary treatment: pairs with the same dissimilarity may have different
distances. Sorting has many ties, because every pair that nobody puts together has a dissimilarity
of 1. For simulated people who sort items on a line, the stress of one dimension is 0 in most
studies with primary ties, and at most 0.13 in 20 studies. The secondary treatment (equal distances)
gives a stress of 0.35, 0.14 and 0.06 in one to three dimensions, and suggests dimensions that do
not exist. For items on a plane, primary ties give a stress of about 0.2 in one dimension and 0.02
in two.

A participant's weights multiply the squared
distances along the axes. They are the non-negative weights that best fit the participant's squared
dissimilarities (the subject step of Carroll and Chang 1970, Psychometrika 35, 283-319).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf

import numpy as np
import pandas as pd

from slipscale.analysis.preprocessing.sufficiency import TINY, few
from slipscale.analysis.reading.surface_labels import numbers_first
from slipscale.analysis.reading.task_tables import by_task
from slipscale.analysis.statistics.arrays import Array
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Inputs, Statistic
from slipscale.analysis.tasks.similarity.reading import RATED, TRIALS
from slipscale.experiments.dataset.schema import PARTICIPANT

#: Smallest number of items. Maps of fewer items fit any dissimilarities.
FEWEST_ITEMS = 4
#: Largest number of dimensions, number of dimensions that are plotted and weighted, number of
#: random starts, and random seed.
MOST_DIMENSIONS, SHOWN, STARTS, SEED = 4, 2, 12, 1
#: Number of iterations from each start, and of further iterations for the two best solutions.
SOME, MANY = 25, 1000
#: Fall of the squared stress below which a search ends, and decimals in which ties agree.
CONVERGED, DECIMALS = 1e-12, 9
#: Standard deviation of a start's last dimension, relative to the map with one dimension less.
SPREAD = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Person:
    """The weights that a participant gives to the axes of the map.

    Parameters
    ----------
    participant : str
    weights : tuple of float
        Weights of squared distances along the map's axes, with an average of about 1.
    r2 : float
        Proportion of variance explained in the participant's squared dissimilarities.
    """

    participant: str
    weights: tuple[float, ...]
    r2: float


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskMap:
    """The multidimensional scaling map for one task.

    Parameters
    ----------
    task : str
        Task label, as in file names.
    participants, answers, catch_trials : int
        Counts of participants, answers (without catch trials) and catch trials. In free sorting,
        answers are final groups of items.
    items : tuple of str
    stress : Mapping
        Stress-1 of the map for each number of dimensions.
    coordinates : Mapping
        Coordinates of each item on the first `SHOWN` principal axes.
    people : tuple of Person
        Weights of participants who rated every pair; empty for free sorting.
    sorting : bool
        Whether the items were sorted into groups.
    """

    task: str
    participants: int
    answers: int
    catch_trials: int
    items: tuple[str, ...]
    stress: Mapping[int, float]
    coordinates: Mapping[str, tuple[float, ...]]
    people: tuple[Person, ...]
    sorting: bool


def maps(inputs: Inputs) -> tuple[TaskMap | NotComputed, ...] | NotComputed:
    """Return the multidimensional scaling map for each task."""
    trials = inputs.data.of(TRIALS)
    if not len(trials) or trials["catch"].all():
        return NotComputed("no dissimilarity ratings")
    return tuple(map_of(task, rows) for task, rows in by_task(trials))


def map_of(
    task: str, trials: pd.DataFrame, sorted_items: int | None = None
) -> TaskMap | NotComputed:
    """Return the map for a task's trials, which have the columns of `TRIALS`.

    Parameters
    ----------
    sorted_items : int, optional
        In free sorting, the number of final groups of items from which the pairs were derived.
    """
    rows = trials[~trials["catch"] & (trials["first"] != trials["second"])]
    items = sorted({*rows["first"], *rows["second"]}, key=numbers_first)
    if len(items) < FEWEST_ITEMS:
        return NotComputed(few("items", len(items), FEWEST_ITEMS))
    sorting = sorted_items is not None
    tables = {
        str(who): _matrix(own, items) if sorting else _scaled(_matrix(own, items))
        for who, own in rows.groupby(PARTICIPANT, observed=True)
    }
    with np.errstate(invalid="ignore"):
        stacked = np.array(list(tables.values()))
        counts = np.isfinite(stacked).sum(axis=0)
        group = np.nansum(stacked, axis=0) / np.where(counts > 0, counts, np.nan)
    missing = np.isnan(group[np.triu_indices(len(items), 1)]).sum()
    if missing:
        return NotComputed(f"no participant rated {missing} of the item pairs")
    if not group.any():
        return NotComputed("all dissimilarities are 0")
    most = min(MOST_DIMENSIONS, len(items) - 2)
    found: dict[int, tuple[Array, float]] = {}
    lower = None
    for dimensions in range(1, most + 1):
        found[dimensions] = scaled(group, dimensions, lower)
        lower = found[dimensions][0]
    coordinates = _principal(found[min(SHOWN, most)][0])
    return TaskMap(
        task=task,
        participants=len(tables),
        answers=len(rows) if sorted_items is None else sorted_items,
        catch_trials=int(trials["catch"].sum()),
        items=tuple(items),
        stress={dimensions: stress for dimensions, (_, stress) in found.items()},
        coordinates={
            item: tuple(place) for item, place in zip(items, coordinates.tolist(), strict=True)
        },
        people=tuple(
            _person(who, table, coordinates)
            for who, table in tables.items()
            if not sorting and np.isfinite(table).all()
        ),
        sorting=sorting,
    )


def _matrix(rows: pd.DataFrame, items: list[str]) -> Array:
    """Return a matrix of mean dissimilarities, with 0 on the diagonal and NaN for unrated pairs."""
    place = {item: number for number, item in enumerate(items)}
    first, second = (rows[name].map(place).to_numpy(int) for name in ("first", "second"))
    sums, counts = np.zeros((2, len(items), len(items)))
    np.add.at(sums, (first, second), rows[RATED].to_numpy(float))
    np.add.at(counts, (first, second), 1)
    counts = counts + counts.T
    table = np.where(counts > 0, (sums + sums.T) / np.maximum(counts, 1), np.nan)
    np.fill_diagonal(table, 0)
    return table


def _scaled(table: Array) -> Array:
    """Scale a table so that its pairs have a root mean square of 1; NaN if all values are 0."""
    known = table[np.triu_indices(len(table), 1)]
    size = np.sqrt(np.nanmean(known**2)) if np.isfinite(known).any() else 0.0
    return table / size if size > TINY else np.full_like(table, np.nan)


def stress_1(dissimilarities: Array, places: Array) -> float:
    """Return Kruskal's stress-1 of a map, with the primary treatment of ties.

    >>> line = np.array([[0.0], [1.0], [3.0]])
    >>> stress_1(np.abs(line - line.T) ** 2, line)
    0.0
    """
    from scipy.spatial.distance import pdist, squareform

    distances = pdist(places)
    left = distances - _monotone(squareform(dissimilarities), distances)
    return float(np.sqrt((left**2).sum() / (distances**2).sum()))


def _monotone(dissimilarities: Array, distances: Array) -> Array:
    """Return the nearest distances in the order of the dissimilarities.

    Pairs with the same dissimilarity may differ in distance.
    """
    from scipy.optimize import isotonic_regression

    order = np.lexsort((distances, dissimilarities.round(DECIMALS)))
    fitted = np.empty_like(distances)
    fitted[order] = isotonic_regression(distances[order]).x
    return fitted


def scaled(
    dissimilarities: Array, dimensions: int, lower: Array | None = None
) -> tuple[Array, float]:
    """Return the non-metric map with the lowest stress-1, and its stress-1.

    Parameters
    ----------
    dissimilarities : array, shape (items, items)
        Symmetric matrix without missing values.
    lower : array, shape (items, dimensions - 1), optional
        The map with one dimension less. The stress is never above the stress of this map.
    """
    from scipy.spatial.distance import pdist, squareform

    pairs = squareform(dissimilarities)

    def improved(start: Array, iterations: int) -> tuple[Array, float]:
        places, before = start, inf
        for _ in range(iterations):
            distances = pdist(places)
            fitted = _monotone(pairs, distances)
            stress = float(((distances - fitted) ** 2).sum() / (distances**2).sum())
            if before - stress < CONVERGED:
                break
            before = stress
            # Guttman's transform of SMACOF, for fitted distances of the same size.
            size = np.sqrt((distances**2).sum() / (fitted**2).sum())
            near = np.maximum(distances, TINY * distances.max())
            ratio = squareform(size * fitted / near)
            places = (np.diag(ratio.sum(axis=1)) - ratio) @ places / len(places)
        return places, stress_1(dissimilarities, places)

    random = np.random.default_rng(SEED)
    starts = [_classical(dissimilarities, dimensions)]
    starts += [random.normal(size=starts[0].shape) for _ in range(STARTS)]
    found = []
    if lower is not None:
        spread = SPREAD * lower.std()
        column = random.normal(size=(len(lower), 1))
        starts.append(np.hstack([lower, spread * column]))
        flat = np.hstack([lower, 0 * column])
        found.append((flat, stress_1(dissimilarities, flat)))
    # A few iterations from each start show which starts lead to a low stress.
    begun = sorted((improved(start, SOME) for start in starts), key=lambda each: each[1])
    found += [improved(places, MANY) for places, _ in begun[:2]]
    return min(found, key=lambda each: each[1])


def _classical(dissimilarities: Array, dimensions: int) -> Array:
    """Return Torgerson's classical solution."""
    n = len(dissimilarities)
    centre = np.eye(n) - 1 / n
    values, vectors = np.linalg.eigh(-centre @ dissimilarities**2 @ centre / 2)
    largest = np.argsort(values)[::-1][:dimensions]
    return np.asarray(vectors[:, largest] * np.sqrt(np.maximum(values[largest], TINY)))


def _principal(coordinates: Array) -> Array:
    """Rotate a map to its principal axes, with no negative coordinates for the last item."""
    centred = coordinates - coordinates.mean(axis=0)
    turned = centred @ np.linalg.svd(centred, full_matrices=False)[2].T
    return np.asarray(turned * np.where(turned[-1] < 0, -1.0, 1.0))


def _person(who: str, table: Array, coordinates: Array) -> Person:
    from scipy.optimize import nnls

    pairs = np.triu_indices(len(table), 1)
    squares = (coordinates[pairs[0]] - coordinates[pairs[1]]) ** 2
    # Like the dissimilarities, the map is scaled to a root mean square distance of 1.
    squares = squares / squares.sum(axis=1).mean()
    wanted = table[pairs] ** 2
    weights, _ = nnls(squares, wanted)
    left = float(((wanted - squares @ weights) ** 2).sum())
    around = float(((wanted - wanted.mean()) ** 2).sum())
    return Person(
        participant=who,
        weights=tuple(weights.tolist()),
        r2=1 - left / around if around > TINY else float("nan"),
    )


class _Similarity(Statistic[tuple[TaskMap | NotComputed, ...]]):
    key = "similarity"
    meaning = "dissimilarity ratings: non-metric multidimensional scaling and participants' weights"
    methods = (
        "Dissimilarities, divided by each participant's root mean square and averaged, were scaled "
        "by non-metric multidimensional scaling [[kruskal1964]] with the primary treatment of "
        "ties. Participants' weights apply to squared distances along the map's principal axes "
        "[[carroll1970]]."
    )

    compute = staticmethod(maps)


SIMILARITY = _Similarity()
