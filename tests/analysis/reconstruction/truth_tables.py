"""Printed tests on small tables, and the truth about each: by every data set and every pairing.

A longer campaign: ``python -m tests.analysis.reconstruction.truth_tables 5000``.
"""

from __future__ import annotations

import sys
import warnings
from collections import Counter
from itertools import permutations, product

import numpy as np
from scipy import stats

from slipscale.analysis.published.printed_numbers import Printed
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.inference.printed_test_answers import answer
from slipscale.analysis.reconstruction.table.printed_tests import PrintedTest
from slipscale.analysis.reconstruction.table.published_table import Column, Scale
from slipscale.analysis.statistics.repeated_measures import batched

PAIRED = ("paired_t", "correlation", "rm_f")
KINDS = (*PAIRED, "independent_t", "welch_t", "one_way_f")
# What is printed of a test, and which kinds have it.
ITEMS = {
    "statistic": KINDS,
    "p": tuple(kind for kind in KINDS if kind != "rm_f"),
    "one_sided_p": ("paired_t", "independent_t", "welch_t", "correlation"),
    "d": ("paired_t", "independent_t"),
    "partial_eta_squared": ("rm_f", "one_way_f"),
}


def _columns(random, kind):
    """A table of two or three columns, degenerate ones included, printed with few decimals."""
    k = 3 if kind in ("rm_f", "one_way_f") and random.random() < 0.7 else 2
    n = int(random.integers(2, 5 if k == 2 else 4))
    top = int(random.integers(1, 6))
    decimals = int(random.integers(1, 3))
    columns = []
    for place in range(k):
        if kind not in PAIRED:
            n = int(random.integers(2, 5))
        x = random.integers(0, top + 1, size=n)
        if random.random() < 0.3:
            x[:] = random.choice([0, top, x[0]])
        printed = {
            "mean": Printed(f"{x.mean():.{decimals}f}"),
            "sd": Printed(f"{x.std(ddof=1):.{decimals}f}"),
        }
        columns.append(Column(label=f"c{place}", n=n, scale=Scale(maximum=top), **printed))
    return [Solutions(column) for column in columns]


def _tables(kind, columns):
    """Every data set and pairing as one array per column, a table in each row."""
    lists = [column.listed for column in columns]
    if kind in PAIRED:
        orders = [
            np.array(sorted({order for row in rows.tolist() for order in permutations(row)}))
            for rows in lists[1:]
        ]
        lists = [lists[0], *orders]
    places = np.array(list(product(*(range(len(rows)) for rows in lists))))
    return [rows[places[:, j]].astype(float) for j, rows in enumerate(lists)]


def _values(kind, tables):
    """The statistic, its two-sided p and its effect size of every table, by other code."""
    n = [x.shape[1] for x in tables]
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if kind == "rm_f":
            f = batched.repeated_measures_f(np.stack(tables, axis=2))
            df = len(n) - 1, (len(n) - 1) * (n[0] - 1)
            return f, np.full(len(f), np.nan), f * df[0] / (f * df[0] + df[1])
        if kind == "one_way_f":
            found = stats.f_oneway(*tables, axis=1)
            df = len(n) - 1, sum(n) - len(n)
            return (
                found.statistic,
                found.pvalue,
                df[0] * found.statistic / (df[0] * found.statistic + df[1]),
            )
        if kind == "correlation":
            found = [
                stats.pearsonr(a, b) if len(set(a)) > 1 and len(set(b)) > 1 else (np.nan, np.nan)
                for a, b in zip(*tables, strict=True)
            ]
            # Of two points r is 1 or -1, and no p is defined.
            ps = [f[1] if n[0] > 2 else np.nan for f in found]
            return np.array([f[0] for f in found]), np.array(ps), None
        if kind == "paired_t":
            found = stats.ttest_rel(tables[1], tables[0], axis=1)
            return found.statistic, found.pvalue, np.abs(found.statistic) / np.sqrt(n[0])
        found = stats.ttest_ind(tables[1], tables[0], axis=1, equal_var=kind == "independent_t")
        size = np.abs(found.statistic) * np.sqrt(1 / n[0] + 1 / n[1])
        return found.statistic, found.pvalue, size


def _undefined(kind, tables):
    """Whether each table has no variation that the statistic divides by, in whole numbers."""
    if kind == "paired_t":
        return np.ptp(tables[1] - tables[0], axis=1) == 0
    if kind == "correlation":
        return (np.ptp(tables[0], axis=1) == 0) | (np.ptp(tables[1], axis=1) == 0)
    if kind == "rm_f":
        return np.all([np.ptp(x - tables[0], axis=1) == 0 for x in tables[1:]], axis=0)
    return np.all([np.ptp(x, axis=1) == 0 for x in tables], axis=0)


def cases(number, seed):
    """Yield test, columns and whether some data set and pairing print the test."""
    random = np.random.default_rng(seed)
    pairs = [(item, kind) for item, kinds in ITEMS.items() for kind in kinds]
    for turn in range(number):
        item, kind = pairs[turn % len(pairs)]
        columns = _columns(random, kind)
        tables = _tables(kind, columns)
        statistic, p, size = _values(kind, tables)
        value = {"statistic": statistic, "p": p, "one_sided_p": p / 2}.get(item, size)
        value = np.where(_undefined(kind, tables) | ~np.isfinite(value), np.nan, value)
        if kind != "correlation" or item != "statistic":
            value = np.abs(value)
        known = value[~np.isnan(value)]
        decimals = 3 if item.endswith("p") else 2
        if len(known) and random.random() < 0.5:
            printed = random.choice(known)
        else:
            printed = random.random() * (1 if item not in ("statistic", "d") else 4)
        text = f"{printed:.{decimals}f}"
        there = bool((np.abs(known - float(text)) <= 0.5 * 10**-decimals + 1e-9).any())
        key, sides = ("p", 1) if item == "one_sided_p" else (item, 2)
        yield PrintedTest.model_validate({"kind": kind, key: text, "sides": sides}), columns, there


def campaign(number, seed):
    """Count verdicts by truth; return them with the cases that are wrong."""
    counted, wrong = Counter(), []
    for test, columns, there in cases(number, seed):
        found = answer(test, columns)
        counted[found.verdict, there] += 1
        if found.verdict == ("impossible" if there else "possible"):
            wrong.append((test, [c.column for c in columns], found))
    return counted, wrong


if __name__ == "__main__":
    counted, wrong = campaign(int(sys.argv[1]) if len(sys.argv) > 1 else 2000, 1)
    for (verdict, there), times in sorted(counted.items()):
        print(f"{verdict:<12} {'some data set prints it' if there else 'none does':<24} {times}")
    print(f"wrong: {len(wrong)}")
    for test, columns, found in wrong[:5]:
        print(test, [(c.n, c.mean.text, c.sd.text, c.scale.maximum) for c in columns], found)
    raise SystemExit(bool(wrong))
