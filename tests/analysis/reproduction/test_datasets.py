import pytest

from analysis.reproduction import datasets
from analysis.reproduction.comparison import compare


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


def test_nothing_has_drifted(ours):
    comparisons = compare(["datasets", "conclusions"])
    assert {c.item for c in comparisons} == set(ours)
    assert [c.item for c in comparisons if c.drifted] == []
