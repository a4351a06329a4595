"""Same–different, limits, identification, sorting: known answers give their known numbers."""

import shutil
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import friedmanchisquare, norm

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reporting.multiplicity import multiplicity
from slipscale.analysis.statistics.holm import holm
from slipscale.analysis.statistics.mean_over_participants import mean_over_participants
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.identification import declaration as identification
from slipscale.analysis.tasks.identification.statistics import identifications, information_bits
from slipscale.analysis.tasks.limits.statistics import LIMITS, limits
from slipscale.analysis.tasks.ratings.conditions import CONDITIONS, rating_conditions
from slipscale.analysis.tasks.ratings.statistics import RATINGS
from slipscale.analysis.tasks.same_different import declaration as same_different
from slipscale.analysis.tasks.same_different.declaration import ANALYSIS as SAME_DIFFERENT
from slipscale.analysis.tasks.same_different.statistics import (
    _of_counts,
    differencing,
    pairs,
)
from slipscale.analysis.tasks.similarity.sorting.reading import separated, sorted_items
from slipscale.analysis.tasks.similarity.sorting.statistics import SORTING
from slipscale.analysis.tasks.similarity.statistics import map_of
from slipscale.analysis.tasks.table import KINDS
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

STUDY = """
name = "conditions"
title = "Three methods in two conditions"
amplitudes_um_pp = [0.0, 0.8, 1.6, 2.4]
[[factors]]
name = "hand"
levels = ["left", "right"]
simulated = { left = 0.5 }
[[tasks]]
protocol = "limits"
lowest_um_pp = 0.2
highest_um_pp = 1.6
step_um_pp = 0.2
series = 2
[[tasks]]
protocol = "identification"
repetitions = 2
practice = 0
learning = 0
[[tasks]]
protocol = "category_scale"
labels = ["not at all", "a little", "clearly", "very much"]
practice = 0
repetitions = 1
"""

SORTED = """
name = "sorted"
title = "Free sorting"
amplitudes_um_pp = [0.0, 0.8, 1.6, 2.4]
[[tasks]]
protocol = "sorting"
groups = 3
"""


@pytest.fixture(scope="module")
def piloted(tmp_path_factory):
    folder = tmp_path_factory.mktemp("conditions")
    (folder / "conditions.toml").write_text(STUDY, encoding="utf-8")
    study = str(folder / "conditions.toml")
    plans = pilot_plans(study, participants=3, seed=2, language=None)
    run_pilot(folder / "data", plans, tell=lambda _: None)
    return analyse(folder / "data")


def test_each_condition_of_a_factor_is_reported_as_a_task_and_effects_are_found(piloted):
    limits_of, categories = piloted.inference[LIMITS], piloted.inference[RATINGS]
    assert [task.task for task in limits_of] == ["limits_hand-left", "limits_hand-right"]
    left, right = limits_of
    assert left.threshold_level.mean > right.threshold_level.mean + 0.1
    means = {task.task: task.surfaces[-1].mean for task in categories}
    assert means["categoryscale_hand-left"] < means["categoryscale_hand-right"] - 0.5
    assert [task.categories for task in categories] == [4, 4]


def test_directions_of_another_spelling_are_reported_and_left_out(piloted, tmp_path):
    folder = shutil.copytree(Path(piloted.dataset.folder), tmp_path / "copy")
    shutil.rmtree(folder / "sourcedata")
    path = next(folder.glob("sub-02/beh/*task-limits_*_beh.tsv"))
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("\tascending\t", "\tup\t"), encoding="utf-8")
    data = load(folder)
    changed = text.count("\tascending\t")
    assert data.counts["the method of limits_unanswered"] == changed
    (first, *_) = [each for each in data.problems if "column direction" in each]
    assert first.endswith("'up' instead of ascending or descending; the trial is left out")
    found = analyse(folder).inference[LIMITS]
    assert [len(each.people) for each in found] == [3, 3]
    assert [each.ascending_level.n for each in found if each.ascending_level] == []


def test_ratings_are_compared_between_the_levels_of_a_factor(piloted, page):
    """With both hands, everybody rates the same surfaces, so levels differ by their mean."""
    (found,) = piloted.inference[CONDITIONS]
    assert (found.task, found.factor) == ("categoryscale", "hand")
    (pair,) = found.pairs
    assert (pair.from_surface, pair.to_surface, pair.participants) == ("left", "right", 3)
    means = {
        task.task: np.mean([each.mean for each in task.surfaces])
        for task in piloted.inference[RATINGS]
    }
    change = means["categoryscale_hand-right"] - means["categoryscale_hand-left"]
    assert pair.difference.mean == pytest.approx(change)
    assert "Ratings, hand: right minus left: " in page(piloted)


def test_pairs_of_all_conditions_are_corrected_as_the_one_family_that_is_listed(piloted):
    """Six pairs of surfaces in each of two conditions: a family of 12, with Holm's correction."""
    pairs = [pair for task in piloted.inference[RATINGS] for pair in task.pairs]
    found, expected = [pair.p_wilcoxon_holm for pair in pairs], [pair.p_wilcoxon for pair in pairs]
    assert found == pytest.approx(holm(expected), nan_ok=True)
    listed = multiplicity(piloted.inference, "ranks", 0.95).families
    (family,) = [each for each in listed if each.name.startswith("pairs of rated surfaces")]
    assert family.corrected
    assert family.tests == sum(np.isfinite(pair.p_wilcoxon) for pair in pairs) > 6


def test_three_conditions_are_compared_by_ranks_over_surfaces_rated_in_all():
    rng = np.random.default_rng(8)
    rows = [
        {
            "participant_id": f"sub-{who}", "task of all conditions": "t", "catch": False,
            "factor: speed": speed, "surface": surface,
            "rating": 2.0 + place + float(rng.integers(2)),
            "categories": np.nan,
        }
        for who in range(8)
        for place, speed in enumerate(("5", "10", "20"))
        for surface in ("0.5", "1.2")
        if (who, speed, surface) != (0, "20", "0.5")
    ]  # fmt: skip
    frame = pd.DataFrame(rows)
    (found,) = rating_conditions(frame)
    whole = frame[~((frame["participant_id"] == "sub-0") & (frame["surface"] == "0.5"))]
    cells = whole.pivot_table(index="participant_id", columns="factor: speed", values="rating")
    test = friedmanchisquare(cells["5"], cells["10"], cells["20"])
    assert (found.friedman.chi2, found.friedman.p) == pytest.approx((test.statistic, test.pvalue))
    assert [(each.from_surface, each.to_surface) for each in found.pairs] == [
        ("5", "10"),
        ("5", "20"),
        ("10", "20"),
    ]
    assert found.pairs[1].difference.mean == pytest.approx((cells["20"] - cells["5"]).mean())


def test_the_report_holds_every_task_with_its_numbers(piloted, page):
    text = page(piloted)
    for said in (
        "Method of limits, hand left, 12 series from 3 participants",
        "Identification, hand right, 24 answers from 3 participants",
        "mean categories, from 1 (lowest) to 4, were",
        "Category scale, hand left: Ratings ",
        "Category scale, hand right: Ratings ",
        "trials per cell of the table",
    ):
        assert said in text, said
    named = {name for kind in KINDS for name in kind.figures(piloted)}
    assert {"limits_limits_hand-left", "identification_identification_hand-right"} <= named


def of(frame):
    """Return a statistic's inputs with one table of trials."""
    data = SimpleNamespace(of=lambda _: frame, choices=AnalysisChoices())
    return SimpleNamespace(data=data)


@pytest.mark.parametrize("d_prime", [0.3, 1.5, 3.0])
@pytest.mark.parametrize("criterion", [0.8, 2.0])
def test_the_differencing_model_is_inverted(d_prime, criterion):
    # P(|N(d', 2)| > k): each impression has the variance 1.
    different, same = (
        norm.cdf((mean - criterion) / 2**0.5) + norm.cdf((-mean - criterion) / 2**0.5)
        for mean in (d_prime, 0.0)
    )
    assert differencing(different, same) == pytest.approx((d_prime, criterion), abs=1e-6)


def test_answers_below_chance_have_a_negative_sensitivity_of_the_same_size():
    below, criterion = differencing(0.2, 0.3)
    assert below == -differencing(0.3, 0.2)[0] < 0
    assert criterion == differencing(0.3, 0.3)[1]
    assert differencing(0.3, 0.3)[0] == 0.0


def test_equal_proportions_of_unequal_numbers_of_trials_have_no_sensitivity():
    assert _of_counts(0, 8, 0, 16)[0] == pytest.approx(0, abs=1e-6)
    assert _of_counts(4, 8, 8, 16)[0] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("people,trials", [(6, 8), (10, 20)])
@pytest.mark.parametrize("different", [0.05, 0.3])
def test_people_who_cannot_tell_a_pair_apart_seldom_have_a_reliable_d_prime(
    people, trials, different
):
    """Equal additions and a d' that ends at 0 gave up to 90 % of intervals above 0."""
    rng = np.random.default_rng(0)
    of_counts = cache(_of_counts)
    above = 0
    for _ in range(200):
        yes = rng.binomial([trials, 2 * trials], different, (people, 2)).tolist()
        own = [of_counts(hit, trials, false, 2 * trials)[0] for hit, false in yes]
        found = mean_over_participants(np.array(own), 0.95)
        above += bool(found) and found.interval.low > 0
    assert above <= 0.07 * 200


def test_a_pairs_sensitivity_is_that_of_its_own_and_its_same_trials():
    rows = [
        {"first": a, "second": b, "different": float(n < yes)}
        for (a, b), yes in {
            ("a", "b"): 30,
            ("a", "a"): 4,
            ("b", "b"): 6,
            ("a", "c"): 39,
            ("c", "b"): 38,
            ("c", "c"): 1,
        }.items()
        for n in range(40)
    ]
    people = [pd.DataFrame(rows).assign(participant_id=who) for who in ("1", "2", "3")]
    frame = pd.concat(people, ignore_index=True).assign(task="t", catch=False)
    ((ab, ac, bc),) = (task.pairs for task in pairs(of(frame)))
    assert (ab.different, ab.different_n, ab.same, ab.same_n) == (90, 120, 30, 240)
    shared = differencing((90 + 1 / 3) / (120 + 2 / 3), (30 + 2 / 3) / (240 + 4 / 3))
    assert ab.d_prime == pytest.approx(shared[0])
    assert (ac.same, bc.same) == (15, 21)
    assert ac.d_prime > bc.d_prime > ab.d_prime
    assert isinstance(ab.mean_d_prime, NotComputed)  # all three are equal


def series(number, direction, answers, levels, who="1"):
    return [
        {
            "participant_id": who,
            "session": "",
            "run": "1",
            "task": "t",
            "series": float(number),
            "direction": direction,
            "comparison_level": level,
            "standard_level": 0.0,
            "felt": float(answer),
        }
        for answer, level in zip(answers, levels, strict=True)
    ]


def test_a_transition_lies_between_the_last_level_and_the_one_before_it():
    up, down = (0.1, 0.2, 0.3, 0.4), (0.6, 0.5, 0.4, 0.3)
    frame = []
    for who, more in (("1", 0), ("2", 0), ("3", 1)):
        frame += series(1, "ascending", [0] * (2 + more) + [1], up[: 3 + more], who)
        frame += series(2, "descending", [1, 1, 0], down[:3], who)
        # The second level was voided: it and the third were done again.
        frame += series(3, "ascending", [0, 0, 0, 1], (0.1, 0.3, 0.2, 0.3), who)
        frame += series(4, "descending", [1, 1, 1, 1], down, who)  # no transition
    found = limits(of(pd.DataFrame(frame).assign(trial=range(len(frame)))))[0]
    assert (found.series, found.without_transition, found.standard_level) == (12, 3, 0.0)
    one, _, three = found.people
    assert one.ascending_level == pytest.approx(0.25)
    assert one.descending_level == pytest.approx(0.45)
    assert one.threshold_level == pytest.approx(0.35)
    assert three.ascending_level == pytest.approx(0.30)
    assert found.threshold_level.mean == pytest.approx((0.35 + 0.35 + 0.375) / 3)
    assert found.constant_error_level.mean == pytest.approx((0.2 + 0.2 + 0.15) / 3)


def test_a_channel_with_a_fifth_of_errors_transfers_its_known_information():
    table = np.array([[400.0, 100.0], [100.0, 400.0]])
    known = 1 + 0.2 * np.log2(0.2) + 0.8 * np.log2(0.8)
    plain, corrected = information_bits(table)
    assert plain == pytest.approx(known)
    assert corrected == pytest.approx(known - 1 / (2 * 1000 * np.log(2)))


def test_the_correction_removes_nearly_all_information_of_random_answers():
    random = np.random.default_rng(1)
    tables = random.multinomial(100, [1 / 25] * 25, size=400).reshape(400, 5, 5).astype(float)
    plain, corrected = np.mean([information_bits(each) for each in tables], axis=0)
    assert plain == pytest.approx(16 / (2 * 100 * np.log(2)), rel=0.15)  # the known bias
    assert abs(corrected) < 0.02


def test_identification_counts_every_answer_and_its_share_right():
    told = [("a", "a")] * 8 + [("a", "b")] * 2 + [("b", "b")] * 10
    rows = [
        {"participant_id": who, "presented": one, "named": other, "right": float(one == other)}
        for who in "123"
        for one, other in (told if who != "3" else [*told[:-1], ("b", "a")])
    ]
    found = identifications(of(pd.DataFrame(rows).assign(task="t")))[0]
    assert found.table == ((24, 6), (1, 29))
    assert found.share_right.mean == pytest.approx((0.9 + 0.9 + 0.85) / 3)
    assert found.most_bits == 1.0
    assert found.trials_per_cell == 5


def test_the_share_of_people_who_separate_two_items_is_their_dissimilarity():
    groups = {"1": "1123", "2": "1122", "3": "1222"}
    rows = [
        {"participant_id": who, "session": "", "run": "1", "item": item, "group": float(group)}
        for who, of_items in groups.items()
        for item, group in zip("abcd", of_items, strict=True)
    ]
    first = {**rows[0], "group": 3.0}  # changed in the second round
    frame = pd.DataFrame([first, *rows]).assign(task="t", trial=range(1, 14))
    found = separated(frame, Problems())
    assert len(found) == 3 * 6
    assert found.groupby(["first", "second"])["dissimilarity"].mean().to_dict() == pytest.approx(
        {("a", "b"): 1 / 3, ("a", "c"): 1, ("a", "d"): 1}
        | {("b", "c"): 2 / 3, ("b", "d"): 2 / 3, ("c", "d"): 1 / 3}
    )
    assert sorted_items(found) == 12
    with_factor = separated(frame.assign(**{"factor: hand": "left"}), Problems())
    assert set(with_factor["factor: hand"]) == {"left"}  # lost, this was a KeyError
    group = map_of("t", found, sorted_items=12)
    assert group.sorting
    assert group.people == ()
    places = {item: place[0] for item, place in group.coordinates.items()}
    assert abs(places["a"] - places["d"]) > abs(places["b"] - places["d"]) > 0.1


def test_sorted_items_are_reported_as_such_and_not_as_ratings(tmp_path, page):
    """Four surfaces in two rounds by three people: the first round's 12 trials are replaced."""
    path = tmp_path / "sorted.toml"
    path.write_text(SORTED, encoding="utf-8")
    plans = pilot_plans(str(path), participants=3, seed=2, language=None)
    run_pilot(tmp_path / "data", plans, tell=lambda _: None)
    analysis = analyse(tmp_path / "data")
    text = page(analysis)
    for said in (
        "4 items sorted by 3 participants",
        "Free sorting: 24 rows were read; not analysed: 12 trials without a group, or sorted again",
        "proportion of participants who put them into different groups",
    ):
        assert said in text, said
    for said in ("dissimilarity trials", "Dissimilarity rating", "root mean square", "weights"):
        assert said not in text, said
    (found,) = analysis.inference[SORTING]
    assert found.answers == 12


@pytest.mark.parametrize("d_prime, people", [(4, 8), (4, 12), (6, 8), (6, 12)])
def test_the_interval_of_a_large_d_prime_has_no_upper_bound_and_contains_it(d_prime, people):
    """Bounded intervals contained 4 in 46 to 82 % of 400 studies, and 6 in none."""
    rng = np.random.default_rng(d_prime + people)
    share = [
        norm.cdf((mean - 2) / 2**0.5) + norm.cdf((-mean - 2) / 2**0.5) for mean in (d_prime, 0.0)
    ]
    inside = at_ceiling = 0
    for _ in range(60):
        yes = rng.binomial(10, share, (people, 2))
        rows = [
            {"participant_id": f"{who}", "first": "a", "second": other, "different": float(n < k)}
            for who, own in enumerate(yes)
            for other, k in zip("ba", own, strict=True)
            for n in range(10)
        ]
        ((pair,),) = (t.pairs for t in pairs(of(pd.DataFrame(rows).assign(task="t", catch=False))))
        at_ceiling += pair.at_ceiling
        low, high = pair.mean_d_prime.interval if pair.mean_d_prime else (-np.inf, np.inf)
        inside += low <= d_prime <= high
    assert at_ceiling >= 55
    assert inside >= 55  # .92


def test_a_d_prime_at_the_ceiling_is_called_a_lower_bound():
    answers = {"1": (10, 0), "2": (10, 2), "3": (9, 3), "4": (10, 1)}
    rows = [
        {"participant_id": who, "first": "a", "second": other, "different": float(n < k)}
        for who, own in answers.items()
        for other, k in zip("ba", own, strict=True)
        for n in range(10)
    ]
    (task,) = pairs(of(pd.DataFrame(rows).assign(task="t", catch=False)))
    own = np.array([_of_counts(hits, 10, false, 10)[0] for hits, false in answers.values()])
    low = own.mean() - 3.182446 * own.std(ddof=1) / 2
    text = same_different.ANALYSIS.task_answer(task, 0.95, PLATE_AMPLITUDE)
    assert f"at least {low:.2f}, 95% bound of the mean, (a and b)" in text
    (row,) = same_different.ANALYSIS.task_rows(task)
    assert row["at_ceiling"] is True


@pytest.mark.parametrize("right, trials", [(0.3, 25), (0.6, 50), (0.9, 50)])
def test_the_mean_information_has_no_interval_because_it_would_not_cover(right, trials):
    """The bias of individual values does not shrink with people: intervals covered .13 to .73."""
    rng = np.random.default_rng(trials)
    confusion = np.full((5, 5), (1 - right) / 4) + np.eye(5) * (right - (1 - right) / 4)
    known = np.log2(5) + (confusion * np.log2(confusion)).sum() / 5
    inside = 0
    for _ in range(100):
        tables = [
            np.array([rng.multinomial(trials // 5, row) for row in confusion], float)
            for _ in range(12)
        ]
        found = mean_over_participants(
            np.array([information_bits(each)[1] for each in tables]), 0.95, (0, np.log2(5))
        )
        inside += bool(found) and found.interval.low <= known <= found.interval.high
    assert inside < 92
    own = [
        {"participant_id": f"{who}", "presented": f"{a}", "named": f"{b}", "right": float(a == b)}
        for who, each in enumerate(tables)
        for (a, b), n in np.ndenumerate(each)
        for _ in range(int(n))
    ]
    (task,) = identifications(of(pd.DataFrame(own).assign(task="t")))
    mean = np.mean([information_bits(each)[1] for each in tables])
    assert task.mean_information_bits == pytest.approx(mean)
    text = str(identification.ANALYSIS.task_blocks(task, {}, 95.0, PLATE_AMPLITUDE))
    assert "no interval" in text
    assert "CI" not in text


@pytest.mark.parametrize("people", [3, 6])
def test_intervals_of_d_prime_of_few_people_are_called_too_narrow(people):
    rng = np.random.default_rng(2)
    rows = [
        {
            "first": a,
            "second": b,
            "different": float(rng.random() < share),
            "participant_id": str(n),
        }
        for n in range(people)
        for a, b, share in (("a", "b", 0.5), ("a", "a", 0.2), ("b", "b", 0.2))
        for _ in range(30)
    ]
    (found,) = pairs(of(pd.DataFrame(rows).assign(task="t", catch=False)))
    doubts = SAME_DIFFERENT.task_doubts(found, 0.95, PLATE_AMPLITUDE)
    assert bool(doubts) == (people == 3)
    assert all("in 88 %" in text for text in doubts)
    assert not hasattr(found.pairs[0].mean_d_prime, "p")
