"""Ratings, ratio judgements and production: against plain NumPy and SciPy, and known truths."""

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.productions.declaration import ANALYSIS as PRODUCTIONS
from slipscale.analysis.tasks.productions.statistics import Counterpart, productions
from slipscale.analysis.tasks.ratings.statistics import ratings, start_effect
from slipscale.analysis.tasks.ratios.statistics import ratios
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

PEOPLE = 8


def rated(pull=0.0, each=6, people=PEOPLE, noise=4.0):
    """Return ratings with people's own levels, and a pull towards the mark's start."""
    rng = np.random.default_rng(3)
    rows = []
    for who in range(people):
        own = 5 * rng.normal()
        for surface, level in (("0", 20.0), ("1.2", 55.0), ("2.3", 80.0), ("ridges", 40.0)):
            for _ in range(each):
                start = rng.uniform(0, 100)
                place = level + own + noise * rng.normal()
                rows.append((f"sub-{who}", surface, start, (1 - pull) * place + pull * start))
    frame = pd.DataFrame(rows, columns=["participant_id", "surface", "cursor_start", "rating"])
    amplitude = pd.to_numeric(frame["surface"], errors="coerce")
    frame = frame.assign(
        task="line", catch=False, resolution=1.0, categories=np.nan, level=amplitude
    )
    return frame.assign(participant_id=pd.Categorical(frame["participant_id"]))


def judged(exponent=0.7, people=PEOPLE):
    rng = np.random.default_rng(4)
    rows = [
        (
            f"sub-{who}",
            amplitude,
            (amplitude / 1.2) ** (exponent + own) * np.exp(0.1 * rng.normal()),
        )
        for who in range(people)
        for own in [0.1 * rng.normal()]
        for amplitude in (0.0001, 0.3, 0.6, 1.8, 2.3)[1:]
        for _ in range(3)
    ]
    frame = pd.DataFrame(rows, columns=["participant_id", "comparison_level", "ratio"])
    return frame.assign(
        task="r", catch=False, standard_level=1.2,
        participant_id=pd.Categorical(frame["participant_id"]),
    )  # fmt: skip


def produced(exponent=0.8, people=PEOPLE, rise=0.0):
    rng = np.random.default_rng(5)
    rows = [
        (
            *(f"sub-{who}", number, began),
            1.2
            * (number / 10) ** (1 / (exponent * own))
            * np.exp(rise * (began == "high") + 0.05 * rng.normal()),
        )
        for who in range(people)
        for own in [np.exp(0.1 * rng.normal())]
        for number in (5.0, 10.0, 15.0)
        for began in ("low", "high")
        for _ in range(2)
    ]
    frame = pd.DataFrame(rows, columns=["participant_id", "number", "began", "produced_level"])
    return frame.assign(
        task="p", catch=False, standard_level=1.2, modulus=10.0, bound="none",
        participant_id=pd.Categorical(frame["participant_id"]),
    )  # fmt: skip


def test_ratings_are_compared_by_ranks_of_participants_means():
    frame = rated()
    (found,) = ratings(frame)
    table = frame.pivot_table(
        index="participant_id", columns="surface", values="rating", observed=True
    )
    names = ["0", "1.2", "2.3", "ridges"]  # amplitudes in order, textures after them
    assert [each.surface for each in found.surfaces] == names
    test = stats.friedmanchisquare(*(table[name] for name in names))
    assert found.friedman.chi2 == pytest.approx(test.statistic)
    assert found.friedman.p == pytest.approx(test.pvalue)
    trend = stats.page_trend_test(table[names[:3]].to_numpy())
    assert found.page_trend.p == pytest.approx(trend.pvalue)
    for each in found.surfaces:
        own = table[each.surface]
        assert each.mean == pytest.approx(own.mean())
        low, high = stats.ttest_1samp(own, 0).confidence_interval(0.95)
        assert tuple(each.interval) == pytest.approx((low, high))
    pair = found.pairs[0]
    assert pair.p_wilcoxon == pytest.approx(stats.wilcoxon(table["1.2"] - table["0"]).pvalue)
    assert pair.p_wilcoxon_holm >= pair.p_wilcoxon
    assert pair.difference.mean == pytest.approx((table["1.2"] - table["0"]).mean())


@pytest.mark.parametrize("pull", [0.0, 0.2])
def test_the_pull_of_the_start_is_found_and_not_invented(pull):
    found = start_effect(rated(pull=pull, each=40), 0.95)
    assert found.mean == pytest.approx(pull, abs=0.02)
    assert (found.interval.low > 0) == (pull > 0)


def test_starts_that_differ_between_surfaces_and_people_are_no_pull():
    frame = rated(each=40)
    jitter = frame["cursor_start"] / 10
    level = frame.groupby(["participant_id", "surface"], observed=True)["rating"]
    found = start_effect(frame.assign(cursor_start=level.transform("mean") + jitter), 0.95)
    assert found.interval.low < 0 < found.interval.high
    assert abs(found.mean) < 0.2


def test_a_start_that_never_changes_pulls_by_an_amount_that_is_not_known():
    (found,) = ratings(rated().assign(cursor_start=50.0))
    assert "always started in the same place" in found.start_effect.reason


def test_the_ends_of_the_line_and_catch_trials_are_counted_by_themselves():
    frame = rated(each=2)
    frame.loc[frame.index[:3], "rating"] = [0.0, 0.0, 100.0]
    catch = frame.iloc[:4].assign(catch=True, rating=7.0)
    (found,) = ratings(pd.concat([frame, catch], ignore_index=True))
    assert found.surfaces[0].at_left == 2
    assert sum(each.at_right for each in found.surfaces) == 1
    assert (found.catch_trials, found.catch_mean) == (4, 7.0)
    assert found.answers == len(frame)


def test_ratios_are_geometric_means_and_their_exponent_the_mean_slope():
    frame = judged()
    (found,) = ratios(frame)
    logs = np.log(frame["ratio"])
    cells = frame.assign(log=logs).pivot_table(
        index="participant_id", columns="comparison_level", values="log", observed=True
    )
    for each in found.surfaces:
        own = cells[each.comparison_level]
        assert each.ratio == pytest.approx(np.exp(own.mean()))
        low, high = stats.ttest_1samp(own, 0).confidence_interval(0.95)
        assert tuple(each.interval) == pytest.approx((np.exp(low), np.exp(high)))
    slopes = [np.polyfit(np.log(cells.columns), row, 1)[0] for row in cells.to_numpy()]
    assert found.power_law.exponent == pytest.approx(np.mean(slopes))


def test_the_standard_against_itself_is_no_part_of_the_exponent():
    frame = judged()
    catch = frame.iloc[:6].assign(catch=True, comparison_level=1.2, ratio=3.0)
    (found,) = ratios(pd.concat([frame, catch], ignore_index=True))
    assert found.catch_ratio == pytest.approx(3.0)
    assert found.power_law == ratios(frame)[0].power_law
    assert ratios(catch).reason == "no ratio judgements"


def test_two_standards_of_one_task_are_kept_apart():
    frame = pd.concat([judged(), judged().assign(standard_level=0.8)], ignore_index=True)
    assert [each.name for each in ratios(frame)] == ["r_800nm", "r_1200nm"]


def test_the_exponent_of_production_is_the_inverse_slope_of_amplitude_on_number():
    frame = produced()
    (found,) = productions(frame)
    cells = frame.assign(log=np.log(frame["produced_level"])).pivot_table(
        index="participant_id", columns="number", values="log", observed=True
    )
    slopes = [np.polyfit(np.log(cells.columns), row, 1)[0] for row in cells.to_numpy()]
    assert found.slope.mean == pytest.approx(np.mean(slopes))
    assert found.exponent == pytest.approx(1 / np.mean(slopes))
    low, high = found.slope.interval
    assert tuple(found.exponent_interval) == pytest.approx((1 / high, 1 / low))
    assert found.exponent_interval.low < 0.8 < found.exponent_interval.high


@pytest.mark.parametrize("rise", [0.0, 0.1])
def test_what_the_beginning_adds_is_found(rise):
    (found,) = productions(produced(rise=rise, people=30))
    assert found.beginning.mean == pytest.approx(rise, abs=0.02)


def test_a_production_that_does_not_grow_has_no_exponent():
    falling = produced().assign(number=lambda rows: 100 / rows["number"])
    (found,) = productions(falling)
    assert found.exponent is found.exponent_interval is None


def test_productions_at_the_bounds_are_counted():
    frame = produced()
    frame.loc[frame.index[:3], "bound"] = ["lowest", "highest", "highest"]
    (found,) = productions(frame)
    assert found.at_bounds == 3
    assert [each.at_bounds for each in found.numbers] == [3, 0, 0]
    ended = 3 / found.numbers[0].productions
    assert ended > 0.05
    assert [each.interval is None for each in found.numbers] == [True, False, False]
    texts = PRODUCTIONS.task_remarks(found, 0.95, PLATE_AMPLITUDE)
    assert any("For the number 5, more than 5 % of productions ended" in text for text in texts)
    assert PRODUCTIONS.task_doubts(found, 0.95, PLATE_AMPLITUDE) == []
    many = frame.assign(bound="highest")
    (doubt,) = PRODUCTIONS.task_doubts(productions(many)[0], 0.95, PLATE_AMPLITUDE)
    assert f"{len(frame)} of {len(frame)} productions ended at the adjustment limits" in doubt


def test_few_productions_at_the_bounds_leave_the_interval():
    frame = produced(people=12)
    frame.loc[frame.index[:2], "bound"] = "highest"
    (found,) = productions(frame)
    assert found.numbers[0].interval is not None


def test_both_exponents_are_of_those_who_did_both_and_the_remedy_is_between_them():
    """A regression of 0.25 makes production's exponent 1/0.75 and estimation's 0.75 times 0.8."""
    frame = produced(exponent=0.8 / 0.75)
    who = [f"sub-{n}" for n in range(PEOPLE)]
    rng = np.random.default_rng(6)
    others = pd.Series(0.6 * np.exp(0.05 * rng.normal(size=PEOPLE)), index=who)
    others["sub-0"] = -0.1  # whose exponent has no logarithm
    others["sub-elsewhere"] = 0.6
    made = productions(
        frame, counterpart=Counterpart(name="magnitude estimation", exponents=others)
    )
    both = made[0].both
    assert both.n == PEOPLE - 1
    assert both.estimation == pytest.approx(0.6, rel=0.05)
    assert both.production == pytest.approx(0.8 / 0.75, rel=0.1)
    assert both.combined == pytest.approx(np.sqrt(both.estimation * both.production))
    assert both.combined == pytest.approx(0.8, rel=0.06)
    assert both.ratio_interval.low > 1


def test_without_estimation_production_stands_alone_and_nothing_is_invented():
    assert isinstance(productions(produced())[0].both, NotComputed)
    empty = produced().iloc[:0]
    assert productions(empty).reason == "no trials of magnitude production"


@pytest.mark.parametrize("people", [1, 2])
def test_of_fewer_than_three_people_there_are_means_and_no_intervals(people):
    (line,) = ratings(rated(people=people))
    (ratio,) = ratios(judged(people=people))
    (made,) = productions(produced(people=people))
    assert f"too few participants ({people}" in line.surfaces[0].interval.reason
    assert ratio.surfaces[0].interval is made.numbers[0].interval is None
    for part in (line.friedman, line.start_effect, ratio.power_law, made.slope, made.beginning):
        assert isinstance(part, NotComputed)
