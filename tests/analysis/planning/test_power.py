"""Power: the population's own numbers, laws of power, and the command."""

import json
from itertools import combinations

import numpy as np
import pytest
from scipy import stats
from statsmodels.stats.multitest import multipletests

import slipscale
from analysis.planning.power import fewest, power_curve, power_of, simulate
from analysis.statistics.batched import friedman_p, holm, signed_rank_p
from experiments.participants.population import Population
from faults import UserError

AMPLITUDES = (0.0, 0.5, 1.2, 2.3)


def studies(**kwargs):
    options = {"participants": 200, "repetitions": 1, "studies": 50} | kwargs
    people = options.pop("population", Population())
    return simulate(AMPLITUDES, population=people, rng=np.random.default_rng(1), **options)


def test_simulated_estimates_have_table_iii_s_means_and_spreads():
    """The numbers are the paper's (Table III), typed here once more."""
    values = studies().reshape(-1, 4)
    assert values.mean(axis=0) == pytest.approx([12.75, 19.58, 56.25, 81.33], abs=0.5)
    assert values.std(axis=0) == pytest.approx([12.75, 8.11, 8.82, 10.76], abs=0.5)
    assert (values == values.round()).all()


def test_power_is_the_share_of_studies_that_scipy_and_statsmodels_find_significant():
    """The same simulated studies, one by one, by the libraries' own tests."""
    values = studies(participants=9, studies=60)
    values[:, 0, 1] = 0  # somebody feels nothing at 0.5 µm
    pairs = list(combinations(range(4), 2))
    omnibus, steps, widths = [], [], []
    log_amplitudes = np.log(AMPLITUDES[1:])
    for study in values:
        omnibus.append(stats.friedmanchisquare(*study.T).pvalue < 0.05)
        raw = [_wilcoxon(study[:, high] - study[:, low]) for low, high in pairs]
        rejected = multipletests(raw, method="holm")[0]
        steps.append([rejected[pairs.index((low, low + 1))] for low in range(3)])
        slopes = [
            stats.linregress(log_amplitudes, np.log(np.maximum(own[1:], 0.5))).slope
            for own in study
        ]
        low, high = stats.ttest_1samp(slopes, 0).confidence_interval()
        widths.append((high - low) / 2)
    found = power_of(AMPLITUDES, values)
    assert found.omnibus == np.mean(omnibus)
    assert list(found.steps.values()) == list(np.mean(steps, axis=0))
    assert 0 < found.weakest < 1
    assert found.exponent_half_width == pytest.approx(np.mean(widths))


def _wilcoxon(steps):
    return stats.wilcoxon(steps, method="exact").pvalue if steps.any() else 1.0


@pytest.mark.parametrize("n, power", [(5, 0.0), (6, 0.9**6 + 0.1**6)])
def test_power_of_a_population_made_by_hand_is_the_binomial_s(n, power):
    """Nine in ten feel more, by sizes that never tie.

    Of six, Wilcoxon's p is 2/64 where all agree, and 4/64 at the least where one does not; of
    five it is 2/32 at the least.
    """
    rng = np.random.default_rng(6)
    up = np.where(rng.random((4000, n)) < 0.9, 1, -1)
    values = np.stack([np.full((4000, n), 50.0), 50 + up * np.arange(1, n + 1)], axis=2)
    found = power_of((1.0, 2.0), values)
    assert found.steps[1.0, 2.0] == found.omnibus
    assert found.omnibus == pytest.approx(power, abs=4 * np.sqrt(power * (1 - power) / 4000))


@pytest.mark.parametrize("n, method", [(50, "exact"), (51, "asymptotic")])
def test_planning_takes_the_exact_test_up_to_the_size_where_the_report_does(n, method):
    steps = np.arange(1.0, n + 1) * np.resize([1, 1, -1], n)
    found = signed_rank_p(np.stack([steps, -steps, np.zeros(n)]))
    expected = stats.wilcoxon(steps, method=method).pvalue
    assert list(found) == pytest.approx([expected, expected, 1.0])


def test_repetitions_average_out_only_the_trial_s_part_of_the_variance():
    people = Population(shared=0.3, trial_to_trial=0.5)
    once = studies(population=people).reshape(-1, 4).var(axis=0)
    often = studies(population=people, repetitions=40).reshape(-1, 4).var(axis=0)
    assert often[2] / once[2] == pytest.approx(0.5, abs=0.06)


def test_without_any_difference_the_tests_keep_their_level():
    rng = np.random.default_rng(3)
    values = np.round(rng.normal(50, 10, (1500, 12, 4)))
    found = power_of(AMPLITUDES, values)
    error = np.sqrt(0.05 * 0.95 / 1500)
    assert abs(found.omnibus - 0.05) < 4 * error + 0.015  # Friedman's chi-square is approximate
    assert max(found.steps.values()) < 0.05


def test_friedman_and_holm_at_scale_are_scipy_s_and_statsmodels_one_by_one():
    values = studies(participants=5, studies=20)
    expected = [stats.friedmanchisquare(*one.T).pvalue for one in values]
    assert friedman_p(values) == pytest.approx(expected)
    p = np.random.default_rng(2).uniform(0, 0.2, (20, 6))
    expected = [multipletests(row, method="holm")[1] for row in p]
    assert holm(p) == pytest.approx(np.array(expected))


def test_more_participants_have_more_power_and_narrower_exponents():
    curve = power_curve(AMPLITUDES, [10, 40], studies=150)
    small, large = curve
    assert large.steps[0.0, 0.5] > small.steps[0.0, 0.5]
    assert large.exponent_half_width < small.exponent_half_width
    assert power_curve(AMPLITUDES, [10], studies=150)[0] == small


def test_the_fewest_are_those_from_which_on_the_target_holds():
    curve = power_curve(AMPLITUDES, [6, 60], studies=60)
    assert fewest(curve, 0.8) == 60
    assert fewest(curve[:1], 0.8) is None


def test_too_small_a_study_is_refused():
    with pytest.raises(UserError, match="2 participants"):
        power_curve(AMPLITUDES, [2])


def test_a_study_that_no_memory_holds_is_refused():
    with pytest.raises(UserError, match=r"2.4e\+13 estimates; expected at most 5e\+07"):
        power_curve(AMPLITUDES, [6], studies=1_000_000_000_000)


@pytest.mark.parametrize(
    "words",
    [
        ["--sizes", "-5"],
        ["--sizes", "2", "20"],
        ["--sizes", "99999999999999999999"],
        ["--repetitions", "0"],
        ["--repetitions", "-1"],
        ["--repetitions", "1000000000"],
        ["--studies", "0"],
        ["--seed", "-1"],
        ["--alpha", "0"],
        ["--alpha", "nan"],
        ["--target", "1"],
        ["--trial-to-trial", "0.71"],
        ["--trial-to-trial", "nan"],
        ["no-such-study"],
        [""],
    ],
)
def test_nonsense_is_refused_in_a_sentence_that_names_it(capsys, words):
    assert slipscale.main(["power", *words]) == 2
    said = capsys.readouterr().err
    assert "expected" in said
    assert words[0] in said or "estimates; expected at most" in said


def test_all_nonsense_is_named_at_once(capsys):
    assert slipscale.main(["power", "--alpha", "5", "--studies", "0"]) == 2
    said = capsys.readouterr().err
    assert "--alpha 5.0: expected a share above 0 and below 1" in said
    assert "--studies 0: expected 1 or more" in said


def test_the_command_says_how_many_and_exits_1_where_none_suffices(capsys):
    words = ["power", "--studies", "40", "--json", "--sizes"]
    assert slipscale.main([*words, "60"]) == 0
    assert json.loads(capsys.readouterr().out)["enough"] == 60
    assert slipscale.main([*words, "4"]) == 1
    assert slipscale.main(["power", "--trial-to-trial", "2"]) == 2


def test_power_is_that_of_the_declared_primary_analysis():
    """Logarithms: paired t, one by one, of simulated studies with zeros among them."""
    rng = np.random.default_rng(5)
    values = np.round(rng.lognormal(np.log([8, 14, 50]), 0.4, (40, 8, 3)))
    values[0, 0, 0] = 0
    found = power_of((0.5, 1.2, 2.3), values, primary="logarithms")
    reject = []
    for study in values:
        logs = np.where(study > 0, np.log(np.maximum(study, 1e-9)), np.nan)
        ps = [
            stats.ttest_1samp(logs[:, high] - logs[:, low], 0, nan_policy="omit").pvalue
            for low, high in ((0, 1), (0, 2), (1, 2))
        ]
        reject.append(multipletests(ps, method="holm")[1] < 0.05)
    share = np.mean(reject, axis=0)
    assert found.steps[0.5, 1.2] == pytest.approx(share[0])
    assert found.steps[1.2, 2.3] == pytest.approx(share[2])
    assert found.omnibus > 0.9
    assert found.steps != power_of((0.5, 1.2, 2.3), values).steps
