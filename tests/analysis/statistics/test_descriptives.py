"""Descriptives against the paper, R and closed forms."""

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.load import load
from slipscale.analysis.preprocessing.normalisation import cell_means
from slipscale.analysis.published.biet2007 import (
    ALLOWED_DATASET,
    PARTICIPANTS,
    STATISTICS,
    TABLE3,
    agrees,
)
from slipscale.analysis.statistics.descriptives import cousineau_morey, means_and_spreads


def test_the_shipped_data_set_gives_every_cell_of_table_iii():
    data = load(ALLOWED_DATASET)
    table = means_and_spreads(cell_means(data.estimates)).set_index("level")
    assert set(table["n"]) == {PARTICIPANTS}
    for row in TABLE3:
        for statistic in STATISTICS:
            ours = table.loc[float(row.amplitude_um_pp), statistic]
            assert agrees(getattr(row, statistic), ours), (row, statistic, ours)


def test_the_shipped_data_set_is_what_the_table_allows():
    """Twelve integers within the bounds that the extreme deviations leave, and not sorted."""
    estimates = load(ALLOWED_DATASET).estimates
    wide = cell_means(estimates)
    assert (wide == wide.round()).all(axis=None)
    assert list(wide.min()) >= [0, 10, 40, 63]
    assert list(wide.max()) == [40, 30, 69, 100]
    assert not (wide.diff(axis=1).iloc[:, 1:] >= 0).all(axis=None)


@pytest.mark.parametrize(
    "printed, ours, verdict",
    [
        ("19.58", 19.575, True),
        ("19.58", 19.585, True),
        ("19.58", 19.5749, False),
        ("15.9", 15.89, True),
        ("12", 12.5, True),
        ("12", 12.51, False),
    ],
)
def test_agreement_is_rounding_to_the_printed_number(printed, ours, verdict):
    assert agrees(printed, ours) is verdict


def test_one_participant_has_a_mean_and_no_deviation():
    table = means_and_spreads(pd.DataFrame({0.0: [12.0, np.nan], 0.5: [20.0, 30.0]}))
    assert list(table["mean"]) == [12, 25]
    assert np.array_equal(table["maximum_deviation"], [np.nan, 5], equal_nan=True)


def test_both_conventions_of_the_standard_deviation():
    cells = pd.DataFrame({0.0: [1.0, 2.0, 6.0], 1.0: [0.0, 0.0, 3.0]})
    sample, population = means_and_spreads(cells), means_and_spreads(cells, "population")
    assert list(sample["standard_deviation"]) == pytest.approx([np.sqrt(7), np.sqrt(3)])
    assert list(population["standard_deviation"]) == pytest.approx([np.sqrt(14 / 3), np.sqrt(2)])
    assert list(sample["maximum_deviation"]) == [3.0, 2.0]


def test_one_participant_has_means_and_no_spread():
    table = means_and_spreads(pd.DataFrame({0.0: [5.0], 1.0: [7.0]}))
    assert list(table["mean"]) == [5, 7]
    assert table["standard_deviation"].isna().all()


def test_within_participant_intervals_do_not_see_differences_between_participants():
    values = np.random.default_rng(1).normal(size=(12, 4))
    shifted = values + np.arange(12)[:, None] * 100
    assert cousineau_morey(shifted) == pytest.approx(cousineau_morey(values))


def test_for_two_conditions_the_interval_is_the_paired_t_test_s_over_root_two():
    """Morey (2008): with k = 2 the interval of the difference is sqrt(2) times each bar."""
    from scipy import stats

    a, b = np.random.default_rng(2).normal(size=(2, 10))
    low, high = stats.ttest_rel(a, b).confidence_interval()
    bars = cousineau_morey(np.column_stack([a, b]))
    assert bars * np.sqrt(2) == pytest.approx(np.full(2, (high - low) / 2))
