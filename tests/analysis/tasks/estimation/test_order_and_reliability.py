"""Order and reliability: what is identifiable, and intervals that hold what they promise."""

import warnings

import numpy as np
import pandas as pd
import pytest
import statsmodels.formula.api as smf

from slipscale.analysis.preprocessing.data_quality import DECISIONS, _patterns
from slipscale.analysis.preprocessing.log_transform import prepare
from slipscale.analysis.reading.trial_tables import FACTOR
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.reliability import reliability
from slipscale.analysis.statistics.variance_components import reml_components
from slipscale.analysis.tasks.estimation.order_effects import order_effects
from slipscale.experiments.study.analysis_choices import AnalysisChoices

AMPLITUDES = np.array([0.0, 0.5, 1.2, 2.3])


def ready(rows, conditions=None, **choices):
    """Rows of (participant, amplitude, log estimate), in order of presentation."""
    frame = pd.DataFrame(rows, columns=["participant_id", "level", "log"])
    if conditions:
        frame[f"{FACTOR}speed"] = conditions
    frame = frame.assign(
        participant_id=frame["participant_id"].astype(str).astype("category"),
        normalised=np.exp(frame.pop("log")),
        session="",
        run="1",
    )
    return prepare(frame, AnalysisChoices(**choices))


def session(rng, people, *, repetitions=3, drift=0.0, carry=0.0, order=None):
    rows = []
    for person in range(people):
        before, own = np.nan, rng.normal(0, 0.4)
        shown = np.repeat(AMPLITUDES, repetitions)
        shown = rng.permutation(shown) if order is None else shown[order]
        for position, amplitude in enumerate(shown):
            log = own + 0.6 * amplitude + drift * position + carry * np.nan_to_num(before)
            rows.append((person, amplitude, log + rng.normal(0, 0.2)))
            before = amplitude
    return rows


def test_one_order_for_all_is_not_identifiable():
    rng = np.random.default_rng(1)
    found = order_effects(ready(session(rng, 8, order=rng.permutation(12))))
    assert isinstance(found, NotComputed)
    assert "not identifiable, because every participant had the same order" in found.reason


def test_a_sorted_table_is_not_identifiable():
    rng = np.random.default_rng(1)
    found = order_effects(ready(session(rng, 8, order=np.arange(12))))
    assert "sorted by amplitude" in found.reason


def test_carry_over_alone_does_not_show_as_drift():
    """Fitted apart, "position" came out significant in 28 to 56 % of such studies."""
    rng = np.random.default_rng(2)
    found = [order_effects(ready(session(rng, 10, carry=0.4))) for _ in range(100)]
    assert sum(each.log_slope_per_trial.p < 0.05 for each in found) <= 12
    assert sum(each.log_slope_per_level_before.p < 0.05 for each in found) > 90
    slopes = [each.log_slope_per_level_before.mean for each in found]
    assert np.mean(slopes) == pytest.approx(0.4, abs=0.02)


def blocks(rng, people, repetitions, sd):
    person, interaction, error = sd
    rows = []
    for who in range(people):
        own = rng.normal(0, person)
        for amplitude in AMPLITUDES:
            here = own + amplitude + rng.normal(0, interaction)
            rows += [(who, amplitude, here + rng.normal(0, error)) for _ in range(repetitions)]
    return rows


def test_components_of_variance_are_recovered_and_amplitudes_do_not_count_as_reliable():
    found = reliability(ready(blocks(np.random.default_rng(3), 400, 4, (0.5, 0.3, 0.4))))
    assert found.variance_participants == pytest.approx(0.25, rel=0.15)
    assert found.variance_interaction == pytest.approx(0.09, rel=0.15)
    assert found.variance_repetitions == pytest.approx(0.16, rel=0.05)
    assert found.single.value == pytest.approx(0.34 / 0.5, abs=0.03)
    assert found.mean.value == pytest.approx(0.34 / 0.38, abs=0.03)


def test_the_interval_of_reliability_covers_at_the_study_s_confidence():
    """Participant x amplitude as independent targets covered .75."""
    rng = np.random.default_rng(4)
    truth = 0.34 / 0.5
    covered = 0
    for _ in range(150):
        found = reliability(ready(blocks(rng, 12, 3, (0.5, 0.3, 0.4)), confidence=0.9))
        assert found.single.interval.confidence == 0.9
        low, high = found.single.interval
        covered += low <= truth <= high
    assert 0.82 * 150 <= covered <= 0.97 * 150


def test_an_amplitude_that_nobody_repeated_counts_with_its_single_estimates():
    rng = np.random.default_rng(5)
    rows = session(rng, 6, repetitions=2)
    seen = set()
    once = [r for r in rows if r[1] != 0.5 or (r[0] not in seen and not seen.add(r[0]))]
    found = reliability(ready(once))
    assert (found.n, found.of_levels, found.repetitions) == (6, 4, pytest.approx(1.6))
    assert (found.method, found.trials) == ("REML", 42)


def test_conditions_of_a_factor_are_no_repetitions_and_no_drift():
    """Everybody judges all surfaces in one condition, and then in another, which is stronger."""
    rng = np.random.default_rng(6)
    halves = [session(rng, 12, repetitions=2) for _ in range(2)]
    rows = [
        (who, amplitude, log + 1.5 * half, f"c{half}")
        for person in range(12)
        for half, found in enumerate(halves)
        for who, amplitude, log in found
        if who == person
    ]
    found = ready([row[:3] for row in rows], conditions=[row[3] for row in rows])
    same = reliability(found)
    assert (same.repetitions, same.of_levels, same.method) == (2, 8, "mean squares")
    assert same.variance_repetitions == pytest.approx(0.2**2, rel=0.25)
    assert abs(order_effects(found).log_slope_per_trial.mean) < 0.01
    trials = found.trials.assign(estimate=found.trials["normalised"])
    patterns = _patterns(trials, AnalysisChoices().thresholds)
    flagged = DECISIONS["drift"](patterns["drift"], AnalysisChoices().thresholds)
    assert flagged.sum() <= 1


def test_an_estimate_of_zero_is_no_repetition():
    rows = blocks(np.random.default_rng(5), 10, 3, (0.5, 0.3, 0.4))
    rows[0] = (*rows[0][:2], -np.inf)
    found = reliability(ready(rows))
    assert (found.n, found.trials) == (10, 10 * 4 * 3 - 1)


def unbalanced(rng, people=9, most=6):
    """One to six estimates per cell, for every participant and amplitude."""
    rows = []
    for person in range(people):
        own = rng.normal(0, 0.5)
        for amplitude in AMPLITUDES:
            cell = own + amplitude + rng.normal(0, 0.3)
            count = int(rng.integers(1, most + 1))
            rows += [(person, amplitude, cell + rng.normal(0, 0.4)) for _ in range(count)]
    return rows


def test_components_of_unbalanced_data_are_statsmodels_reml():
    rows = unbalanced(np.random.default_rng(1))
    found = reliability(ready(rows))
    frame = pd.DataFrame(rows, columns=["who", "level", "log"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = smf.mixedlm(
            "log ~ C(level)",
            frame,
            groups="who",
            re_formula="1",
            vc_formula={"cell": "0 + C(level)"},
        )
        fit = model.fit(reml=True)
    expected = [fit.cov_re.iloc[0, 0], fit.vcomp[0], fit.scale]
    ours = [
        found.variance_participants,
        found.variance_interaction,
        found.variance_repetitions,
    ]
    assert ours == pytest.approx(expected, rel=2e-4)
    assert found.trials == len(rows)
    assert found.single.value == pytest.approx(sum(ours[:2]) / sum(ours))


def test_reml_of_balanced_data_equals_the_mean_squares():
    rows = blocks(np.random.default_rng(8), 10, 3, (0.5, 0.3, 0.4))
    balanced = reliability(ready(rows))
    frame = pd.DataFrame(rows, columns=["who", "level", "log"])
    cells = frame.groupby(["who", "level"])["log"]
    around = ((frame["log"] - cells.transform("mean")) ** 2).groupby(frame["who"]).sum()
    found = reml_components(
        frame.pivot_table(index="who", columns="level", values="log").to_numpy(),
        np.full((10, 4), 3.0),
        around.to_numpy(),
    )
    assert found == pytest.approx(
        [
            balanced.variance_participants,
            balanced.variance_interaction,
            balanced.variance_repetitions,
        ],
        rel=1e-8,
    )


@pytest.mark.parametrize("levels", [1, 2, 5])
@pytest.mark.parametrize("person, cell", [(0.0, 0.0), (0.0, 0.5), (2.0, 0.0), (1.0, 0.3)])
def test_no_other_components_are_more_likely(person: float, cell: float, levels: int):
    """The density of the cells is written out, with the mean of each level integrated out."""
    rng = np.random.default_rng(levels)
    counts = rng.integers(0, 4, (9, levels)).astype(float)
    counts[0] = 3
    means = person * rng.normal(size=(9, 1)) + cell * rng.normal(size=counts.shape)
    means += rng.normal(size=counts.shape) / np.sqrt(np.maximum(counts, 1))
    freedom = np.maximum(counts - 1, 0).sum(axis=1)
    squares = rng.chisquare(np.maximum(freedom, 1e-9))
    there = counts.ravel() > 0
    whose = np.repeat(np.arange(9), levels)[there]
    which = np.tile(np.eye(levels), (9, 1))[there]

    def deviance(components: np.ndarray) -> float:
        between, within, repetition = components
        cells = np.diag(within + repetition / counts.ravel()[there])
        inverse = np.linalg.inv(cells + between * (whose[:, None] == whose))
        normal = which.T @ inverse @ which
        off = means.ravel()[there]
        off = off - which @ np.linalg.solve(normal, which.T @ inverse @ off)
        return (
            off @ inverse @ off
            - np.linalg.slogdet(inverse)[1]
            + np.linalg.slogdet(normal)[1]
            + squares.sum() / repetition
            + freedom.sum() * np.log(repetition)
        )

    found = reml_components(means, counts, squares)
    others = np.exp(rng.normal(0, 1, (300, 3))) * np.maximum(found, 1e-3)
    close = np.maximum(found + 1e-3 * rng.normal(size=(100, 3)), [0, 0, 1e-3])
    assert deviance(found) <= min(map(deviance, [*others, *close])) + 1e-9


def test_the_interval_of_unbalanced_data_covers():
    rng = np.random.default_rng(6)
    truth = 0.34 / 0.5
    intervals = [reliability(ready(unbalanced(rng, 12))).single.interval for _ in range(40)]
    covered = sum(low <= truth <= high for low, high in intervals)
    assert 35 <= covered <= 40


def test_the_interval_of_reliability_is_a_jackknife_over_people():
    """Written out: each person is left out, and t has 5 degrees of freedom (2.570582)."""
    rows = blocks(np.random.default_rng(8), 6, 3, (0.5, 0.3, 0.4))
    whole = reliability(ready(rows)).single
    left = [
        reliability(ready([row for row in rows if row[0] != who])).single.value for who in range(6)
    ]
    pseudo = 6 * np.arctanh(whole.value) - 5 * np.arctanh(left)
    half = 2.570582 * np.sqrt(((pseudo - pseudo.mean()) ** 2).sum() / 5 / 6)
    expected = np.tanh([pseudo.mean() - half, pseudo.mean() + half])
    assert tuple(whole.interval) == pytest.approx(tuple(expected), rel=1e-5)
