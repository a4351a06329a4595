"""What scales, maps and sensitivities to pairs must be, by plain formulas."""

from collections import defaultdict
from itertools import combinations, permutations
from math import inf, sqrt
from statistics import NormalDist

import numpy as np
import pytest
from scipy.optimize import brentq, minimize, nnls
from scipy.stats import logistic, norm

from tests.support.plain.formulas import T, ends, mean, sd

NORMAL = NormalDist()


def told_apart(found, rows):
    """Compare d' by the differencing model, from hit and false-alarm rates."""
    for pair in found["pairs"]:
        names = {float(pair["first"]), float(pair["second"])}
        own = defaultdict(lambda: {"pair": [], "same": []})
        for who, row in rows:
            two = {float(row["first"]), float(row["second"])}
            if two <= names:
                own[who]["pair" if two == names else "same"].append(row["response"] == "true")
        people = [each for each in own.values() if each["pair"] and each["same"]]
        assert pair["participants"] == len(people)
        whole = {key: [a for each in people for a in each[key]] for key in ("pair", "same")}
        assert (pair["different"], pair["different_n"]) == (
            sum(whole["pair"]),
            len(whole["pair"]),
        )
        assert (pair["same"], pair["same_n"]) == (sum(whole["same"]), len(whole["same"]))
        assert (pair["d_prime"], pair["criterion"]) == pytest.approx(d_prime(whole), abs=1e-9)
        values = [d_prime(each)[0] for each in people]
        printed = pair["mean_d_prime"]
        if (interval := ends(values)) is None:
            assert "reason" in printed
            continue
        low = any(all(each["same"]) for each in people)
        high = any(all(each["pair"]) for each in people)
        assert (printed["mean"], printed["sd"]) == pytest.approx((mean(values), sd(values)))
        bounds = [None if low else interval[0], None if high else interval[1]]
        assert printed["ci"] == [each if each is None else pytest.approx(each) for each in bounds]
        assert pair["at_ceiling"] == high


def d_prime(answers):
    """Return d' and the criterion, after the log-linear correction in proportion to the trials."""
    n, m = len(answers["pair"]), len(answers["same"])
    hits = (sum(answers["pair"]) + n / (n + m)) / (n + 2 * n / (n + m))
    false_alarms = (sum(answers["same"]) + m / (n + m)) / (m + 2 * m / (n + m))
    criterion = sqrt(2) * NORMAL.inv_cdf(1 - false_alarms / 2)
    low, high = sorted((hits, false_alarms))
    at = sqrt(2) * NORMAL.inv_cdf(1 - low / 2)

    def rate(d):
        return NORMAL.cdf((d - at) / sqrt(2)) + NORMAL.cdf((-d - at) / sqrt(2))

    size = 0.0 if high - low < 1e-12 else brentq(lambda d: rate(d) - high, 0.0, 30.0, xtol=1e-12)
    return (size if hits >= false_alarms else -size), criterion


def compared(found, rows):
    """Compare both scales with penalised maximum likelihood by a general optimiser."""
    counted(found, rows)
    names = [float(name) for name in found["surfaces"]]
    own = defaultdict(lambda: np.zeros((len(names), len(names))))
    for who, row in rows:
        two = [names.index(float(row[f"stimulus{number}"])) for number in (1, 2)]
        chosen = two.pop(int(row["response"]) - 1)
        own[who][chosen, two[0]] += 1
    tables = np.array(list(own.values()))
    pooled = tables.sum(axis=0)
    assert found["chosen"] == pooled.sum(axis=1).tolist()
    assert found["compared"] == (pooled + pooled.T).sum(axis=1).tolist()
    check_scale(found["bradley_terry"], tables, logistic)
    check_scale(found["thurstone"], tables, norm)
    for who, table in own.items():
        if (table + table.T + np.eye(len(names)) > 0).all():
            circles = circular(np.sign(table - table.T))
            assert found["consistency"][who]["circular_triads"] == pytest.approx(circles)


def circular(better):
    """Count circular triads; a triad with ties counts by the share of its possible orders."""
    total = 0.0
    for a, b, c in combinations(range(len(better)), 3):
        edges = [better[a, b], better[b, c], better[c, a]]
        ways = [1.0 if edge == 0 else None for edge in edges]
        for around in (1, -1):
            p = [0.5 if way else float(e == around) for e, way in zip(edges, ways, strict=True)]
            total += float(np.prod(p))
    return total


def check_scale(found, tables, curve):
    """Compare a scale; its parameters are the values of all surfaces but the last."""
    people, k = len(tables), tables.shape[1]
    pooled = tables.sum(axis=0)
    one, other = np.triu_indices(k, 1)
    pairs = np.zeros((len(one), k))
    pairs[range(len(one)), one], pairs[range(len(one)), other] = 1, -1
    design = pairs[:, :-1]
    won, lost = pooled[one, other], pooled[other, one]

    def information(b):
        p, density = curve.cdf(design @ b), curve.pdf(design @ b)
        return design.T * ((won + lost) * density**2 / (p * (1 - p))) @ design

    def minus_log(b):
        z = design @ b
        likelihood = won @ curve.logcdf(z) + lost @ curve.logsf(z)
        return -likelihood - np.linalg.slogdet(information(b))[1] / 2

    b = np.zeros(k - 1)
    for _ in range(3):  # each search starts where the last one ended
        options = {"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000}
        b = minimize(minus_log, b, method="Nelder-Mead", options=options).x
    centred = np.vstack([np.eye(k - 1), np.zeros(k - 1)]) - 1 / k
    values, covariance = centred @ b, np.linalg.inv(information(b))
    assert found["values"] == pytest.approx(values, abs=1e-5)
    z = design @ b
    p, density = curve.cdf(z), curve.pdf(z)
    quantile = NORMAL.inv_cdf(0.975)
    if people > 2 and np.ptp(tables, axis=0).any():
        scores = np.array(
            [
                ((t[one, other] - (t[one, other] + t[other, one]) * p) * density / (p * (1 - p)))
                @ design
                for t in tables
            ]
        )
        middle = sum(np.outer(each, each) for each in scores) * people / (people - 1)
        covariance, quantile = covariance @ middle @ covariance, T[people - 2]
    covariance = centred @ covariance @ centred.T
    assert np.array(found["covariance"]) == pytest.approx(covariance, abs=1e-4)
    half = quantile * np.sqrt(np.diag(covariance))
    for (low, high), value, width in zip(found["intervals"], values, half, strict=True):
        assert (low, high) == pytest.approx((value - width, value + width), abs=1e-3)
    seen = won + lost > 0
    if seen.sum() > k - 1:
        expected = np.column_stack([(won + lost) * p, (won + lost) * (1 - p)])[seen]
        observed = np.column_stack([won, lost])[seen]
        logs = np.log(np.where(observed > 0, observed, 1) / expected)
        assert found["fit"]["deviance"] == pytest.approx(2 * (observed * logs).sum(), abs=1e-4)
        assert found["fit"]["df"] == seen.sum() - (k - 1)


def rated_pairs(found, rows):
    """Compare the map with mean dissimilarities of equal root mean square."""
    counted(found, rows)
    own = defaultdict(lambda: defaultdict(list))
    for who, row in rows:
        own[who][pair_of(row["first"], row["second"])].append(float(row["dissimilarity"]))
    tables = {who: {p: mean(values) for p, values in each.items()} for who, each in own.items()}
    for table in tables.values():
        size = sqrt(mean([value**2 for value in table.values()]))
        table.update({pair: value / size for pair, value in table.items()})
    check_map(found, tables)
    places = {float(name): np.array(place) for name, place in found["coordinates"].items()}
    for person in found["people"]:
        table = tables[person["participant"]]
        squares = np.array([(places[a] - places[b]) ** 2 for a, b in table])
        squares /= squares.sum() / len(squares)
        wanted = np.array(list(table.values())) ** 2
        weights, left = nnls(squares, wanted)
        assert person["weights"] == pytest.approx(weights, abs=1e-6)
        explained = 1 - left**2 / ((wanted - wanted.mean()) ** 2).sum()
        assert person["r2"] == pytest.approx(explained)


def sorted_items(found, rows):
    """Compare the map with the shares of people who put two items into different groups.

    Only the last group of an item counts. A participant's runs have equal weights.
    """
    last = {(who, row["place"], float(row["item"])): row["group"] for who, row in rows}
    assert found["answers"] == len(last)
    assert found["participants"] == len({who for who, *_ in last})
    apart = defaultdict(lambda: defaultdict(list))
    for (who, place, one), (whose, where, other) in combinations(last, 2):
        if (who, place) == (whose, where):
            groups = last[who, place, one], last[who, place, other]
            apart[who][pair_of(one, other)].append(float(groups[0] != groups[1]))
    check_map(found, {w: {p: mean(v) for p, v in each.items()} for w, each in apart.items()})


def pair_of(one, other):
    return tuple(sorted((float(one), float(other))))


def check_map(found, tables):
    """Compare the stress of the map, and of the best line of items."""
    items = [float(item) for item in found["items"]]
    values = defaultdict(list)
    for table in tables.values():
        for pair, value in table.items():
            values[pair].append(value)
    group = {pair: mean(values[pair]) for pair in combinations(items, 2)}
    places = {float(name): np.array(place) for name, place in found["coordinates"].items()}
    shown = stress(group, places)
    assert shown == pytest.approx(found["stress"]["2"], abs=1e-6)
    best = inf
    for order in permutations(items):
        if order[0] > order[-1]:
            continue  # the mirror image

        def of_line(gaps, order=order):
            at = np.concatenate([[0.0], np.cumsum(np.abs(gaps))])
            return stress(group, dict(zip(order, at[:, None], strict=True)))

        line = minimize(of_line, np.ones(len(items) - 1), method="Nelder-Mead")
        best = min(best, line.fun)
    assert found["stress"]["1"] == pytest.approx(best, abs=2e-3)


def stress(group, places):
    """Return Kruskal's stress-1: ties are put into the order of the distances."""
    distance = {(a, b): float(np.linalg.norm(places[a] - places[b])) for a, b in group}
    order = sorted(group, key=lambda pair: (round(group[pair], 9), distance[pair]))
    blocks = []
    for pair in order:  # pool adjacent violators
        blocks.append([distance[pair]])
        while len(blocks) > 1 and mean(blocks[-2]) >= mean(blocks[-1]):
            last = blocks.pop()
            blocks[-1] = blocks[-1] + last
    left = sum((each - mean(block)) ** 2 for block in blocks for each in block)
    return sqrt(left / max(sum(each**2 for each in distance.values()), 1e-300))


def counted(found, rows):
    assert found["answers"] == len(rows)
    assert found["participants"] == len({who for who, _ in rows})
