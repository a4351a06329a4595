"""Figures of a data set: nothing is spread along a quantity, and values show under the pointer."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.difference.figures import RING, difference
from slipscale.analysis.tasks.difference.verbal_coding import load_codebook
from slipscale.analysis.tasks.difference.yes_no import analyse_differences
from slipscale.analysis.tasks.estimation.figures import fig15, growth_means
from slipscale.analysis.tasks.estimation.growth.figures import growth
from slipscale.analysis.writing.axes import apart, with_tips
from slipscale.figure_style import svg

AMPLITUDES = [0.0, 0.5, 1.2, 2.3]


@pytest.fixture
def logs():
    rng = np.random.default_rng(1)
    return pd.DataFrame(rng.normal([1, 2, 3, 4], 0.2, (8, 4)), columns=AMPLITUDES)


def test_participants_shares_lie_at_the_size_of_their_step():
    rows = [
        {
            "participant_id": f"p{who}",
            "level_before": before,
            "level": after,
            "catch": before == after,
            "difference_felt": int(before != after and (who + after) % 3 > 0),
            "verbal_report": "",
        }
        for who in range(8)
        for before, after in ((2.3, 1.2), (1.2, 0.5), (0.5, 0.0), (0.0, 0.0))
    ]
    steps = pd.DataFrame(rows).astype({"participant_id": "category"})
    figure = difference(analyse_differences(steps, load_codebook()), steps)
    rings = [
        each
        for axes in figure.axes
        for each in axes.collections
        if isinstance(each, PathCollection)
    ]
    places = {round(float(ring.get_offsets()[0][0]), 6) for ring in rings}
    assert places == {0.0, 0.5, 0.7, 1.1}
    # The area counts participants: eight at each of four sizes.
    assert sum(float(ring.get_sizes()[0]) for ring in rings) == pytest.approx(4 * 8 * RING)


def test_fig_15_shows_what_each_participant_answered_and_no_paper_beside_another_scale(logs):
    cells = np.exp(logs)
    (axes,) = fig15(cells, top=None, unit="as given").axes
    lines = [line.get_ydata() for line in axes.get_lines() if len(line.get_xdata()) == 4][
        : len(cells)
    ]
    assert np.array(lines) == pytest.approx(cells.to_numpy())
    (ours,) = axes.containers
    assert ours.lines[0].get_ydata() == pytest.approx(cells.mean().to_numpy())
    assert axes.get_ylim()[0] == 0
    # Values beyond the scale stay visible.
    assert fig15(cells * 10).axes[0].get_ylim()[1] >= 10 * cells.max(axis=None)


def test_the_growth_of_means_has_intervals_above_zero(logs):
    """On raw means Cousineau and Morey's interval of the smallest mean reaches below 0 here."""
    wide = logs + np.random.default_rng(2).normal(0, 0.8, logs.shape)
    figure = growth_means(wide, without_log=[0.5])
    (axes,) = figure.axes
    bars = [path for line in axes.collections for path in line.get_segments()]
    assert bars
    assert all((np.asarray(bar)[:, 1] > 0).all() for bar in bars)
    # Bar and mean are of the same kind: each bar is symmetrical about its mean, in logarithms.
    middles = [float(np.log(np.asarray(bar)[:, 1]).mean()) for bar in bars[-4:]]
    assert middles == pytest.approx(wide.mean().tolist())
    assert axes.get_yscale() == "log"
    text = with_tips(svg(figure, salt="fig15"))
    assert text.count("<title>") == 4
    assert f"<title>0.5 µm: geometric mean {np.exp(wide[0.5].mean()):.2f}" in text
    assert "tip-" not in text
    assert "without estimates of zero" in text


LEVELS = [0.0, 0.5, 1.2, 2.3]


def test_fig_15_of_estimates_of_zero_has_an_axis_from_zero():
    (axes,) = fig15(pd.DataFrame(np.zeros((6, 4)), columns=LEVELS), top=None).axes
    assert axes.get_ylim() == (0, 1)


def test_fig_15_shows_each_interval_whole_and_within_possible_means():
    cells = pd.DataFrame([[10, 30, 70, 98]] * 7 + [[50, 50, 50, 30]], columns=LEVELS)
    cells += np.arange(8)[:, None] / 10
    for most, end in ((np.inf, 110.0), (100.0, 100.0)):
        (axes,) = fig15(cells, most=most).axes
        bars = axes.containers[0].lines[2][0].get_segments()
        highest = max(bar[:, 1].max() for bar in bars)
        assert axes.get_ylim()[1] >= highest
        assert highest == pytest.approx(end, abs=2)


def test_fig_15_of_one_participant_has_no_error_bars_in_its_legend():
    (axes,) = fig15(pd.DataFrame([[12.5, 25, 62.5, 100]], columns=LEVELS)).axes
    (ours,) = axes.containers
    assert not ours.has_yerr
    assert axes.get_legend_handles_labels()[1] == ["arithmetic mean"]


def test_the_growth_of_one_number_has_an_axis():
    figure = growth_means(pd.DataFrame({0.0: [np.log(12)], 0.5: [np.log(12)]}))
    low, high = figure.axes[0].get_ylim()
    assert low < 12 < high
    assert "<svg" in svg(figure, salt="one")


def test_fig_15_gives_each_group_its_own_means(logs):
    groups = pd.Series(["old", "young"] * 4, index=logs.index)
    assert len(fig15(np.exp(logs), groups=groups).axes[0].containers) == 2
    (axes,) = growth_means(logs, groups=groups).axes
    labels = axes.get_legend_handles_labels()[1]
    assert labels[0] == "geometric mean of old, 95 % within-participant CI"
    means = [container.lines[0].get_ydata() for container in axes.containers]
    assert np.log(means[1]) == pytest.approx(logs[groups == "young"].mean().to_numpy())


def test_the_growth_figure_s_panels_lie_one_above_the_other(logs):
    figure = growth(logs, NotComputed("none"))
    above, below = (axes.get_position() for axes in figure.axes)
    assert above.y0 > below.y1
    assert above.x0 < below.x1
    assert figure.get_figwidth() < 5.5


def test_ticks_with_long_labels_do_not_overlap():
    axes = Figure(figsize=(2.8, 2.7)).add_subplot()
    axes.set_xscale("log")
    levels = np.array([6324.56, 20000, 63245.6, 200000, 632456])
    axes.set_xlim(levels[0], levels[-1])
    assert apart(axes, levels) == [6324.56, 63245.6, 632456]
    short = np.array([0.1, 1, 10, 100, 1000])
    axes.set_xlim(0.1, 1000)
    assert apart(axes, short) == short.tolist()
