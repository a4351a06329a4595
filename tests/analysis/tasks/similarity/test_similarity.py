"""Maps of dissimilarities: stress as by MASS in R, places and weights recovered."""

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import isotonic_regression
from scipy.spatial.distance import pdist, squareform

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.meaning.mapping import parse_mapping
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.similarity.statistics import (
    SIMILARITY,
    _scaled,
    map_of,
    scaled,
    stress_1,
)
from slipscale.faults import UserError

#: Ten items with noise; the lower triangle by rows.
LOWER = """
6.67
3.26 3.60
3.32 3.66 1.27
2.18 5.53 2.06 3.31
1.72 5.47 1.91 0.63 1.41
1.94 6.13 3.85 2.26 0.50 2.25
1.21 6.23 1.53 1.23 3.06 2.40 1.72
3.89 2.10 2.28 2.21 3.73 3.68 2.86 4.58
3.70 6.62 4.50 5.12 4.11 4.01 3.80 4.44 4.75
"""
#: Lowest stress of R 4.2.2's MASS::isoMDS from the classical solution and 60 random starts.
R = {1: 0.19341405, 2: 0.11582, 3: 0.05620898}
#: How many of six people put two of seven items into different groups; the upper triangle by rows.
SORTED = [3, 5, 6, 6, 6, 6, 5, 6, 6, 6, 6, 2, 5, 6, 6, 5, 6, 6, 5, 6, 4]
PLACES = {"a": (-2.0, 0.0), "b": (-1.0, 0.9), "c": (0.2, -1.0), "d": (0.5, 0.8), "e": (1.1, -0.6)}
PLACES |= {"f": (2.0, 0.2), "g": (0.0, 0.1)}
WEIGHTS = {"p1": (1.0, 1.0), "p2": (1.6, 0.3), "p3": (0.6, 1.8)}


def rows(numbers=1.0):
    """Every pair once, by three people who weigh the axes differently."""
    names = list(PLACES)
    for who, weights in WEIGHTS.items():
        for place, first in enumerate(names):
            for second in names[place + 1 :]:
                steps = np.subtract(PLACES[first], PLACES[second]) ** 2
                far = numbers * np.sqrt(float(steps @ np.array(weights)))
                yield who, first, second, far


@pytest.fixture(scope="module")
def trials():
    frame = pd.DataFrame(rows(), columns=["participant_id", "first", "second", "dissimilarity"])
    return frame.assign(catch=False)


@pytest.mark.parametrize("dimensions", R)
def test_the_stress_is_that_of_r(dimensions):
    table = np.zeros((10, 10))
    table[np.tril_indices(10, -1)] = [float(text) for text in LOWER.split()]
    _, stress = scaled(table + table.T, dimensions)
    # Both programs stop in the best of several minima: in one dimension there are many.
    assert stress == pytest.approx(R[dimensions], rel=0.03 if dimensions == 1 else 0.01)


def test_the_stress_is_that_of_the_map_itself():
    table = np.zeros((10, 10))
    table[np.tril_indices(10, -1)] = [float(text) for text in LOWER.split()]
    places, stress = scaled(table + table.T, 1)
    told, distances = squareform(table + table.T), pdist(places)
    # Equal dissimilarities have the mean of their distances.
    tied = pd.Series(distances).groupby(told).transform("mean").to_numpy()
    order = np.argsort(told, kind="stable")
    left = distances[order] - isotonic_regression(tied[order]).x
    assert stress == pytest.approx(np.sqrt((left**2).sum() / (distances**2).sum()))


def test_the_stress_never_rises_with_an_added_dimension():
    """The search with four dimensions alone ends at a stress of .002 here."""
    sorted_apart = np.zeros((7, 7))
    sorted_apart[np.triu_indices(7, 1)] = SORTED
    table, places = (sorted_apart + sorted_apart.T) / 6, None
    found = [1.0]
    for dimensions in (1, 2, 3, 4):
        places, stress = scaled(table, dimensions, places)
        assert places.shape == (7, dimensions)
        found.append(stress)
    assert found == sorted(found, reverse=True)


@pytest.fixture(scope="module")
def found(trials):
    """The second person uses numbers 50 times as large, which changes nothing."""
    larger = 50 * trials["dissimilarity"]
    return map_of(
        "t",
        trials.assign(
            dissimilarity=trials["dissimilarity"].where(trials["participant_id"] != "p2", larger)
        ),
    )


def test_places_and_weights_are_recovered(found):
    assert found.stress[2] < 0.02 < found.stress[1]
    assert list(found.stress) == [1, 2, 3, 4]
    ours, truth = np.array(list(found.coordinates.values())), np.array(list(PLACES.values()))
    for axis in (0, 1):
        assert abs(np.corrcoef(ours[:, axis], truth[:, axis])[0, 1]) > 0.95
    people = {each.participant: each for each in found.people}
    # The order of how much people weigh the second axis against the first.
    share = {who: each.weights[1] / each.weights[0] for who, each in people.items()}
    assert sorted(share, key=lambda who: share[who]) == ["p2", "p1", "p3"]
    assert all(each.r2 > 0.9 for each in people.values())


def test_few_items_and_pairs_that_nobody_rated_give_no_map(trials):
    few = trials[trials["first"].isin(["a", "b"]) & trials["second"].isin(["b", "c"])]
    assert "items" in map_of("t", few).reason
    lacking = trials[~((trials["first"] == "a") & (trials["second"] == "b"))]
    assert isinstance(map_of("t", lacking), NotComputed)
    assert map_of("t", lacking).reason == "no participant rated 1 of the item pairs"


def test_a_table_of_another_laboratory_is_mapped_and_reported(tmp_path, page):
    path = tmp_path / "pairs.csv"
    pd.DataFrame(rows(), columns=["who", "left", "right", "far"]).to_csv(path, index=False)
    columns = {"participant": "who", "first": "left", "second": "right", "dissimilarity": "far"}
    analysis = analyse(load(path, parse_mapping({"columns": columns}, "here")))
    (found,) = analysis.inference[SIMILARITY]
    assert (found.participants, found.answers) == (3, 63)
    text = page(analysis)
    assert ", 7 items, " in text
    assert "non-metric multidimensional scaling (Kruskal, 1964)" in text
    with pytest.raises(
        UserError, match="needs --first and --second, with --dissimilarity or --chosen"
    ):
        parse_mapping({"columns": {"participant": "who", "first": "left"}}, "here")


def test_items_that_nobody_tells_apart_have_no_map(trials):
    alike = map_of("t", trials.assign(dissimilarity=0.0), sorted_items=21)
    assert alike == NotComputed("all dissimilarities are 0")


def test_a_table_is_scaled_to_a_root_mean_square_of_one_over_the_pairs_that_are_known():
    table = np.array([[0, 2, np.nan], [2, 0, 4], [np.nan, 4, 0]], float)
    pairs = _scaled(table)[np.triu_indices(3, 1)]
    assert np.nanmean(pairs**2) == pytest.approx(1)
    assert pairs[2] == pytest.approx(2 * pairs[0])


@pytest.mark.parametrize("value", [0.0, np.nan])
def test_a_table_without_any_difference_has_no_scale(value):
    assert np.isnan(_scaled(np.full((3, 3), value))).all()


def of_sorting(dimensions, seed, items=9, people=20, groups=4):
    """Return shares of people who separate items: each divides the space into regions."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(size=(items, dimensions))
    if dimensions == 1:
        places = np.linspace(0, 1, items)[:, None]
    table = np.zeros((items, items))
    for _ in range(people):
        centres = rng.uniform(size=(groups, dimensions))
        group = ((places[:, None] - centres) ** 2).sum(axis=2).argmin(axis=1)
        table += group[:, None] != group
    return table / people


def test_sorted_items_on_a_line_need_one_dimension_and_items_on_a_plane_two():
    """With secondary ties, stress suggested dimensions that do not exist: .35, .14, .06."""
    line, plane, second = [], [], []
    for seed in range(12):
        table = of_sorting(1, seed)
        places, stress = scaled(table, 1)
        line.append(stress)
        distances = pdist(places)
        pairs = squareform(table).round(9)
        means = np.array([distances[pairs == each].mean() for each in pairs])
        fitted = isotonic_regression(means[np.argsort(pairs)]).x
        left = distances[np.argsort(pairs)] - fitted
        second.append(np.sqrt((left**2).sum() / (distances**2).sum()))
        of_plane = of_sorting(2, seed, people=30)
        one, stress = scaled(of_plane, 1)
        plane.append((stress, scaled(of_plane, 2, one)[1]))
    assert np.median(line) < 0.02
    assert np.median(second) > 0.1
    assert np.median(plane, axis=0)[0] > 0.1
    assert np.median(plane, axis=0)[1] < 0.06


def test_every_equal_dissimilarity_may_have_its_own_distance():
    """Three items on a line, all pairs equal: secondary ties would have a stress of a third."""
    line = np.array([[0.0], [1.0], [2.0]])
    assert stress_1(np.ones((3, 3)) - np.eye(3), line) == 0
