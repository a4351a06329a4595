"""What thresholds of forced choice must be, by sums over dense grids and a general optimiser."""

from collections import defaultdict
from math import log

import numpy as np
import pytest
from scipy.optimize import minimize

#: Share of right answers by chance.
CHANCE = {"two_interval": 1 / 2, "three_interval": 1 / 3, "oddity": 1 / 3}
#: Largest lapse rate of a population.
LARGEST_LAPSE = 0.2


def forced(level_of, answer):
    """Return a check of thresholds; ``level_of`` returns a trial's level."""

    def check(found, rows):
        people = defaultdict(list)
        for who, row in rows:
            people[who].append((level_of(row), row[answer] == "true"))
        assert [each["participant"] for each in found["participants"]] == sorted(people)
        chance = CHANCE[found["method"]]
        for each in found["participants"]:
            own = people[each["participant"]]
            assert (each["trials"], each["correct"]) == (len(own), sum(right for _, right in own))
            if "reason" in each["function"]:
                continue
            assert each["function"]["trials"] == len(own)
            assert each["function"]["levels"] == len({level for level, _ in own})
            low, median, high = posterior(own, chance)
            # The lower end of an interval is least accurate on the product's grid.
            printed = each["function"]["threshold_level"]
            assert log(printed) == pytest.approx(median, abs=0.02 * (high - low))
            ends = [log(end) for end in each["function"]["threshold_ci"]]
            assert ends == pytest.approx([low, high], abs=0.03 * (high - low))
        if "threshold_level" in found["population"]:
            check_population(found, people, chance)

    return check


def counts(trials):
    """Return logarithms of levels above 0, and numbers of right and of all answers."""
    levels = sorted({level for level, _ in trials if level > 0})
    right = [sum(r for level, r in trials if level == each) for each in levels]
    n = [sum(level == each for level, _ in trials) for each in levels]
    return np.log(levels), np.array(right), np.array(n)


def weibull(u, threshold, slope, chance, lapse):
    """Return the probability of a right answer; at the threshold, the curve is halfway."""
    return chance + (1 - chance - lapse) * (1 - np.exp(-log(2) * np.exp(slope * (u - threshold))))


def posterior(trials, chance):
    """Return the 2.5, 50 and 97.5 % points of the logarithm of the threshold."""
    u, right, n = counts(trials)
    span = u[-1] - u[0]
    threshold = np.linspace(u[0] - span, u[-1] + span, 600)
    log_slope = log(2) + 0.6 * np.linspace(-3.5, 3.5, 61)
    logs = np.zeros((600, 61, 16))
    lapse = 0.06 * (np.arange(16) + 0.5) / 16
    for at, yes, all_answers in zip(u, right, n, strict=True):
        slope = np.exp(log_slope)[:, None]
        p = weibull(at, threshold[:, None, None], slope, chance, lapse)
        p = np.clip(p, 1e-9, 1 - 1e-9)
        logs += yes * np.log(p) + (all_answers - yes) * np.log(1 - p)
    logs -= ((log_slope - log(2)) / 0.6)[:, None] ** 2 / 2
    weight = np.exp(logs - logs.max()).sum(axis=(1, 2))
    below = (np.cumsum(weight) - weight / 2) / weight.sum()
    return np.interp([0.025, 0.5, 0.975], below, threshold)


def check_population(found, people, chance):
    """Compare the typical threshold with the maximum of a likelihood on a dense grid."""
    population = found["population"]
    assert population["n"] == len(people)
    assert population["answers"] == sum(map(len, people.values()))
    several = isinstance(population["sd_log_slope"], dict)
    if several or "reason" in population["slope"]:
        return  # a deviation per session or condition, or a step
    own = [counts(trials) for trials in people.values()]
    catches = [(e["catch_correct"], e["catch_trials"]) for e in found["participants"]]
    right, all_catches = map(sum, zip(*catches, strict=True))
    # The shallowest curve rises from 5 to 95 % over 20 standard deviations of the levels.
    widest = 20 * np.concatenate([u for u, *_ in own]).std()
    shallowest = log(log(log(20) / -log(0.95)) / widest) - 1e-6
    nodes, slopes = np.linspace(-4, 4, 121)[:, None], np.linspace(-3, 3, 13)
    weight = np.exp(-(nodes**2) / 2 - slopes**2 / 2)
    weight /= weight.sum()

    def minus_log(theta):
        threshold, log_slope, sd, sd_slope, lapse = theta
        lapse = abs(lapse)
        if lapse > LARGEST_LAPSE or abs(sd_slope) > 1.5 or log_slope < shallowest:
            return 1e9  # outside the search
        total = right * log(max(1 - lapse, 1e-9)) + (all_catches - right) * log(max(lapse, 1e-9))
        steep = np.exp(log_slope + sd_slope * slopes)
        for u, yes, n in own:
            p = weibull(u[:, None, None], threshold + sd * nodes, steep, chance, lapse)
            p = np.clip(p, 1e-9, 1 - 1e-9)
            logs = np.tensordot(yes, np.log(p), 1) + np.tensordot(n - yes, np.log(1 - p), 1)
            total += logs.max() + log((weight * np.exp(logs - logs.max())).sum())
        return -total

    printed = log(population["threshold_level"]["value"])
    start = [
        printed,
        log(population["slope"]["value"]),
        population["sd"] * log(10),
        population["sd_log_slope"],
        population["lapse"],
    ]
    at_print = minus_log(start)
    away = [start[0] + 0.1, start[1] + 0.1, start[2] + 0.1, start[3] + 0.2, start[4] / 2 + 0.02]
    best = minimize(minus_log, away, method="Nelder-Mead", options={"maxfev": 400})
    assert at_print < best.fun + 0.1  # the printed values are (nearly) the most likely ones
