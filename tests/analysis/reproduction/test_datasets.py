from itertools import combinations

import numpy as np
import pytest

from slipscale.analysis.published.biet2007 import TABLE3, agrees
from slipscale.analysis.reproduction import datasets
from slipscale.analysis.reproduction.comparison import compare
from slipscale.analysis.statistics.repeated_measures.batched import paired_t, repeated_measures_f


@pytest.fixture(scope="module")
def ours():
    return {item: call() for item, call in datasets.ITEMS.items()}


def test_counts_are_those_that_another_implementation_found(ours):
    """Found by a prototype whose counts were checked against complete enumeration."""
    counts = {"0": 40711, "0.5": 1336, "1.2": 83530, "2.3": 605304}
    assert {a: ours[f"datasets.{a}.sample"].ours for a in counts} == counts
    counts = {"0": 69262, "0.5": 522, "1.2": 106816, "2.3": 354367}
    assert {a: ours[f"datasets.{a}.population"].ours for a in counts} == counts


def test_everybody_rated_1_2_above_0_5_in_every_data_set(ours):
    assert ours["conclusions.sign.0.5um.1.2um.lowest"].ours == 12
    assert "in every data set" in ours["conclusions.sign.0.5um.1.2um.lowest"].reason


def test_whether_0_5_differs_from_0_is_not_decided_by_the_table(ours):
    low, high = (ours[f"conclusions.t.0um.0.5um.{end}"] for end in ("lowest", "highest"))
    assert low.ours < 2.2010 < high.ours  # Student's t(11), 5 % two-sided
    assert "depends on the data set" in low.reason


# This table prints all twelve numbers of Table III if its SD divides by n.
WITH_POPULATION_SD = {
    0.0: [8, 11, 3, 32, 1, 16, 9, 3, 27, 3, 40, 0],
    0.5: [28, 21, 28, 10, 28, 15, 17, 30, 28, 10, 10, 10],
    1.2: [42, 64, 56, 56, 40, 65, 58, 64, 50, 67, 49, 64],
    2.3: [92, 74, 83, 73, 100, 74, 85, 73, 65, 90, 71, 96],
}


def test_a_table_with_the_population_sd_lies_within_the_conclusions(ours):
    for row in TABLE3:
        x = np.array(WITH_POPULATION_SD[float(row.amplitude_um_pp)])
        assert agrees(row.mean, x.mean())
        assert agrees(row.standard_deviation, x.std())
        assert agrees(row.maximum_deviation, np.abs(x - x.mean()).max())
    table = np.array(list(WITH_POPULATION_SD.values()), dtype=float).T[None]
    f = repeated_measures_f(table)[0]
    assert f == pytest.approx(81.007, abs=5e-4)
    assert ours["conclusions.rm_f.lowest"].ours <= f
    assert "with the sample SD" in ours["conclusions.rm_f.lowest"].reason
    for (i, one), (j, other) in combinations(enumerate(WITH_POPULATION_SD), 2):
        t = paired_t(table[:, :, [i, j]])[0]
        low, high = (
            ours[f"conclusions.t.{one:g}um.{other:g}um.{end}"].ours for end in ("lowest", "highest")
        )
        assert low <= t <= high


def test_the_number_of_tables_is_told_to_the_last_digit(ours):
    found = ours["datasets.tables.sample"]
    assert found.ours == pytest.approx(6.366e49, rel=1e-4)
    exact = 2962591251840 * 34964843760 * 8002156919724 * 76796709905520
    assert f"{exact:,} tables" in found.reason
    assert "p from 0.0016 to" in ours["conclusions.t.0um.0.5um.lowest"].reason


def test_nothing_has_drifted(ours):
    comparisons = compare(["datasets", "conclusions"])
    assert {c.item for c in comparisons} == set(ours)
    assert [c.item for c in comparisons if c.drifted] == []


def test_a_bound_is_printed_rounded_outward(ours):
    # 80.99895 is the least F: "at least 81.00" would be false.
    least = ours["conclusions.rm_f.lowest"]
    assert least.ours == pytest.approx(80.99895, abs=1e-5)
    assert least.shown == "80.99"
    assert "80.99 with the population SD" in least.reason
