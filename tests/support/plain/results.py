"""What the results of each kind of task must be, by plain formulas."""

import math
from collections import defaultdict
from dataclasses import dataclass
from math import exp, log, sqrt

import numpy as np
import pytest

from slipscale.analysis.tasks.estimation import section
from tests.support.plain.formulas import (
    T,
    check_anova,
    check_friedman,
    check_interval,
    check_mean,
    ends,
    line,
    mean,
    own_means,
    sd,
    tail,
)
from tests.support.plain.scaling import compared, rated_pairs, sorted_items, told_apart
from tests.support.plain.thresholds import forced


@dataclass
class Kind:
    """How a kind's tables are read, and what its results must be.

    ``check(found, rows)`` compares the results of a task with its rows, pairs of participant and
    row. ``key`` is the key in inference.json.
    """

    key: str
    answer: str
    cell: str
    check: object
    zero: str | None = None


def rated(found, rows):
    for_surface = own_means(rows, "amplitude_um_pp", lambda row: float(row["rating"]))
    low, high = (0.0, 100.0) if found["categories"] is None else (1.0, found["categories"])
    assert len(found["surfaces"]) == len(for_surface)
    for each in found["surfaces"]:
        name = next(name for name in for_surface if float(name) == float(each["surface"]))
        values = list(for_surface[name].values())
        assert each["participants"] == len(values)
        assert each["ratings"] == sum(row["amplitude_um_pp"] == name for _, row in rows)
        assert each["mean"] == pytest.approx(mean(values))
        if len(values) == 1:
            assert each["sd"] is None
        else:
            assert each["sd"] == pytest.approx(sd(values), abs=1e-12)
        check_interval(each["interval"], ends(values, low, high))
    names = {float(name): people for name, people in for_surface.items()}
    for pair in found["pairs"]:
        one, other = (names[float(pair[key])] for key in ("from_surface", "to_surface"))
        both = [other[who] - one[who] for who in one if who in other]
        check_mean(pair["difference"], both, low - high, high - low)


def of_level(means, level):
    """Return participants' means at a level, which the tables name by its digits."""
    return next(list(own.values()) for name, own in means.items() if float(name) == level)


def judged(found, rows):
    logs = own_means(rows, "comparison_um_pp", lambda row: log(float(row["ratio"])))
    for each in found["surfaces"]:
        values = of_level(logs, each["comparison_level"])
        assert each["participants"] == len(values)
        assert each["ratio"] == pytest.approx(exp(mean(values)))
        low_high = ends(values)
        check_interval(each["interval"], low_high and tuple(map(exp, low_high)))
    slopes = slopes_of(logs, [level for level in logs if float(level) > 0])
    law = found["power_law"]
    if len(slopes) < 3:
        assert "reason" in law
    else:
        assert law["exponent"] == pytest.approx(mean(slopes))
        assert law["sd"] == pytest.approx(sd(slopes))
        assert law["ci95"] == pytest.approx(ends(slopes))


def slopes_of(logs, levels):
    """Return the log-log slopes of participants with at least two levels."""
    people = sorted({who for level in levels for who in logs[level]})
    own = {who: [level for level in levels if who in logs[level]] for who in people}
    return [
        line([log(float(level)) for level in known], [logs[level][who] for level in known])[1]
        for who, known in own.items()
        if len(known) > 1
    ]


def produced(found, rows):
    logs = own_means(rows, "number", lambda row: log(float(row["produced_um_pp"])))
    for each in found["numbers"]:
        values = of_level(logs, each["number"])
        assert (each["participants"], each["productions"]) == (
            len(values),
            sum(float(row["number"]) == each["number"] for _, row in rows),
        )
        assert each["level"] == pytest.approx(exp(mean(values)))
        ended = [
            row["bound"] != "none" for _, row in rows if float(row["number"]) == each["number"]
        ]
        assert each["at_bounds"] == sum(ended)
        low_high = ends(values) if sum(ended) <= 0.05 * len(ended) else None
        check_interval(each["interval"], low_high and tuple(map(exp, low_high)))
    slopes = slopes_of(logs, list(logs))
    check_mean(found["slope"], slopes)
    if len(slopes) > 2 and mean(slopes) > 0:
        assert found["exponent"] == pytest.approx(1 / mean(slopes))


def matched(found, rows):
    rows = [
        pair
        for pair in rows
        if float(pair[1]["interval1_amplitude_um_pp"]) == found["reference_level"]
    ]
    assert found["matches"] == len(rows)
    own = own_means(rows, "phase", value_of("matched_um_pp"))["main"]
    assert found["mean_level"] == pytest.approx(mean(list(own.values())))
    check_mean(found["bias_level"], [each - found["reference_level"] for each in own.values()])
    sides = own_means(rows, "direction", value_of("matched_um_pp"))
    for side in sides:
        assert found[f"{side}_level"] == pytest.approx(mean(list(sides[side].values())))
    both = [
        sides["descending"][who] - sides["ascending"][who]
        for who in own
        if all(who in sides.get(side, ()) for side in ("ascending", "descending"))
    ]
    check_mean(found["direction_level"], both)
    spread = defaultdict(list)
    for who, row in rows:
        spread[who, row["direction"]].append(float(row["matched_um_pp"]))
    variances = [sd(each) ** 2 for each in spread.values() if len(each) > 1]
    if variances:
        assert found["variability_level"] == pytest.approx(sqrt(mean(variances)))


def value_of(column):
    return lambda row: float(row[column])


def limited(found, rows):
    series = defaultdict(list)
    for who, row in rows:
        series[who, row["place"], row["series"]].append(row)
    own = defaultdict(lambda: {"ascending": [], "descending": []})
    for (who, *_), steps in series.items():
        levels = [float(step["comparison_um_pp"]) for step in steps]
        way = steps[0]["direction"]
        own[who]  # also participants without a transition
        if (steps[-1]["different"] == "true") == (way == "ascending"):
            up = way == "ascending"
            before = [each for each in levels if (each < levels[-1] if up else each > levels[-1])]
            if before:
                own[who][way].append((levels[-1] + (max(before) if up else min(before))) / 2)
    means = {w: {way: mean(v) for way, v in each.items() if v} for w, each in own.items()}
    for way in ("ascending", "descending"):
        check_mean(found[f"{way}_level"], [each[way] for each in means.values() if way in each])
    whole = [each for each in means.values() if len(each) == 2]
    errors = [each["descending"] - each["ascending"] for each in whole]
    check_mean(found["constant_error_level"], errors)
    check_mean(found["threshold_level"], [mean(list(each.values())) for each in whole])


def identified(found, rows):
    items = [float(item) for item in found["items"]]
    people = defaultdict(lambda: np.zeros((len(items), len(items))))
    for who, row in rows:
        people[who][items.index(float(row["presented"])), items.index(float(row["named"]))] += 1
    table = sum(people.values())
    assert found["table"] == table.astype(int).tolist()
    check_mean(found["share_right"], [np.trace(e) / e.sum() for e in people.values()], 0.0, 1.0)
    p = table / table.sum()
    outer = np.outer(p.sum(axis=1), p.sum(axis=0))
    bits = sum(p[i] * math.log2(p[i] / outer[i]) for i in zip(*np.nonzero(p), strict=True))
    assert found["information_bits"] == pytest.approx(bits)


def pointed(found, rows):
    for each in found["conditions"]:
        own = defaultdict(list)
        for who, row in rows:
            if row["feedback"] == each["feedback"]:
                own[who].append(row)
        people = [movement(moves) for moves in own.values()]
        checked = ("throughput_bit_s", "movement_time_s", "error_share", "intercept_s")
        bounds = {"error_share": (0.0, 1.0), "intercept_s": (-math.inf, math.inf)}
        for name in (*checked, "slope_s_per_bit"):
            values = [float(person[name]) for person in people if name in person]
            low, high = bounds.get(name, (0.0 if name in checked else -math.inf, math.inf))
            check_mean(each[name], values, low, high)


def movement(moves):
    """Return one participant's results (Shannon formulation, effective width)."""
    cells = defaultdict(list)
    for row in moves:
        start, target, end = (
            np.array([float(row[f"{name}_{axis}_mm"]) for axis in "xy"])
            for name in ("start", "target", "selection")
        )
        way = target - start
        along = float((end - start) @ way / np.hypot(*way))
        cells[float(row["distance_mm"]), float(row["width_mm"])].append(
            (along, float(row["movement_time"]))
        )
    rates, bits, times = [], [], []
    for (distance, width), each in cells.items():
        if len(each) < 3:
            continue
        moved, took = zip(*each, strict=True)
        times.append(mean(took))
        bits.append(math.log2(distance / width + 1))
        width_mm = sqrt(2 * math.pi * math.e) * sd(moved)
        rates.append(math.log2(mean(moved) / width_mm + 1) / mean(took))
    found = {
        "movement_time_s": mean([float(row["movement_time"]) for row in moves]),
        "error_share": mean([float(row["selection"] != "target") for row in moves]),
    }
    if rates:
        found["throughput_bit_s"] = mean(rates)
    if len(set(bits)) > 1:
        found["intercept_s"], found["slope_s_per_bit"] = line(bits, times)
    return found


def above_standard(row):
    return round(float(row["comparison_um_pp"]) - float(row["standard_um_pp"]), 9)


def noticed(found, rows):
    steps = defaultdict(list)
    for _, row in rows:
        pair = float(row["amplitude_before_um_pp"]), float(row["amplitude_um_pp"])
        steps[pair].append(row["difference_felt"] == "yes")
    for each in found["steps"]:
        own = steps[each["from_level"], each["to_level"]]
        assert (each["yes"], each["n"]) == (sum(own), len(own))
        if len({who for who, _ in rows}) == len(own):  # independent: Clopper and Pearson
            low, high = each["ci95"]
            assert low == 0 or tail(len(own), sum(own), low) == pytest.approx(0.025, abs=1e-6)
            few = tail(len(own), len(own) - sum(own), 1 - high)
            assert high == 1 or few == pytest.approx(0.025, abs=1e-6)


def estimated(results, analysis, rows):
    """Compare the statistics of magnitude estimates."""
    whole = own_means(rows, "amplitude_um_pp", value_of("estimate"))
    for each in analysis.table3.to_dict("records"):
        values = of_level(whole, each["level"])
        assert each["n"] == len(values)
        assert each["mean"] == pytest.approx(mean(values))
        if len(values) > 1:
            assert each["standard_deviation"] == pytest.approx(sd(values))
            far = max(abs(value - mean(values)) for value in values)
            assert each["maximum_deviation"] == pytest.approx(far)
    for each in analysis.description.to_dict("records"):
        values = of_level(whole, each["level"])
        assert each["median"] == pytest.approx(np.median(values))
        if len(values) > 1:
            assert each["sd_sample"] == pytest.approx(sd(values))
            n = len(values)
            assert each["sd_population"] == pytest.approx(sd(values) * sqrt((n - 1) / n))
    positive = [pair for pair in rows if float(pair[1]["estimate"]) > 0]
    logs = own_means(positive, "amplitude_um_pp", lambda row: log(float(row["estimate"])))
    if len(positive) == len(rows):
        for each in analysis.description.to_dict("records"):
            values = of_level(logs, each["level"])
            plainly = ends(values)
            raw_ends = ends(of_level(whole, each["level"]), 0)
            assert each["geometric_mean"] == pytest.approx(exp(mean(values)))
            for name, bounds in (
                ("geometric", plainly and map(exp, plainly)),
                ("mean", raw_ends),
            ):
                printed = [each[f"{name}_low"], each[f"{name}_high"]]
                assert printed == pytest.approx(
                    [*bounds] if bounds else [math.nan] * 2, nan_ok=True
                )
    people = {who for who, _ in rows}
    slopes = slopes_of(logs, [level for level in logs if float(level) > 0])
    if len(people) > 2 and len(positive) == len(rows):
        spread = max(sd(list(own.values())) for own in logs.values())
        page = " ".join(map(str, section.estimates(analysis, {}).blocks))
        assert f"(here up to {spread:.2f})" in page
        law = results["power_law"]
        assert (law["exponent"], law["sd"]) == pytest.approx((mean(slopes), sd(slopes)))
        assert law["ci95"] == pytest.approx(ends(slopes))
        mixed = results["mixed_model"]
        half = T[len(people) - 2] * mixed["se"]
        assert mixed["ci"] == pytest.approx((mixed["exponent"] - half, mixed["exponent"] + half))
        by_level = {float(level): own for level, own in logs.items()}
        for pair in results["pairwise"]:
            one, other = (by_level[pair[key]] for key in ("from_level", "to_level"))
            both = [other[who] - one[who] for who in one if who in other]
            error = sd(both) / sqrt(len(both))
            assert pair["ratio"] == pytest.approx(exp(mean(both)))
            assert pair["ratio_ci"] == pytest.approx(tuple(map(exp, ends(both))))
            assert (pair["t"], pair["df"]) == (pytest.approx(mean(both) / error), len(both) - 1)
            assert pair["d_z"] == pytest.approx(mean(both) / sd(both))
        complete = [who for who in people if all(who in own for own in logs.values())]
        table = np.array([[logs[level][who] for level in logs] for who in complete])
        check_anova(results["rm_anova"], table)
        raw = np.array([[whole[level][who] for level in whole] for who in complete])
        check_friedman(results["friedman"], raw)


KINDS = {
    "category_scale": Kind("ratings", "rating", "amplitude_um_pp", rated, "1"),
    "visual_analogue_scale": Kind("ratings", "rating", "amplitude_um_pp", rated, "0"),
    "ratio_to_standard": Kind("ratios", "ratio", "comparison_um_pp", judged),
    "magnitude_production": Kind("productions", "produced_um_pp", "number", produced),
    "matching": Kind("matching", "matched_um_pp", "direction", matched, "0"),
    "limits": Kind("limits", "different", "direction", limited),
    "identification": Kind("identification", "named", "presented", identified),
    "pointing": Kind("pointing", "movement_time", "distance_mm", pointed),
    "same_different": Kind("same_different", "response", "first", told_apart),
    "similarity": Kind("similarity", "dissimilarity", "first", rated_pairs, "0"),
    "sorting": Kind("sorting", "group", "item", sorted_items),
    "paired_comparison": Kind("scales", "response", "stimulus1", compared),
    "constant_stimuli": Kind(
        "thresholds",
        "comparison_more",
        "comparison_um_pp",
        forced(above_standard, "comparison_more"),
    ),
    "detection_threshold": Kind(
        "thresholds", "correct", "level_um_pp", forced(value_of("level_um_pp"), "correct")
    ),
    "difference_threshold": Kind(
        "thresholds", "correct", "level_um_pp", forced(value_of("level_um_pp"), "correct")
    ),
    "oddity": Kind(
        "thresholds", "correct", "level_um_pp", forced(value_of("level_um_pp"), "correct")
    ),
    "descending_difference": Kind("difference", "difference_felt", "amplitude_um_pp", noticed),
}
ESTIMATES = Kind("power_law", "estimate", "amplitude_um_pp", estimated, "0.5")
