"""Adaptive methods and thresholds: how fast, how near the truth, how honest their intervals.

    OMP_NUM_THREADS=1 .venv/bin/python benchmarks/adaptive.py speed
    OMP_NUM_THREADS=1 .venv/bin/python benchmarks/adaptive.py recovery [--runs 400]

``speed``: QUEST+ runs at once beside a loop over `questplus`, and one trial's computation beside
one frame of 60 Hz. ``recovery``: tracks of a known observer, a Weibull function fitted to each by
maximum likelihood, and how often the 95 % intervals hold the truth; scales likewise. The figures
are in ``docs/explanation/thresholds.md``. One thread: with several, BLAS waits on small products.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from questplus import QuestPlus as Loop
from scipy import stats

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics import psychometric_fit as likelihood
from slipscale.analysis.tasks.scales.difference_scaling import difference_scale
from slipscale.analysis.tasks.scales.paired_comparison_scale import bradley_terry, thurstone
from slipscale.experiments.protocols.adaptive.batched import QuestPlusBatch
from slipscale.experiments.protocols.adaptive.curves import CURVES
from slipscale.experiments.protocols.adaptive.quest_plus import LARGEST_GRID, QuestPlus
from slipscale.experiments.protocols.adaptive.staircase import staircase
from slipscale.experiments.protocols.adaptive.weighted import weighted

if TYPE_CHECKING:
    from collections.abc import Callable

    from slipscale.experiments.protocols.adaptive.curves import Array
    from slipscale.experiments.protocols.adaptive.up_down import UpDown

FRAME_MS = 1000 / 60
GRID = QuestPlus(
    levels_um_pp=tuple(np.round(np.geomspace(0.02, 2.0, 40), 9)),
    thresholds_um_pp=tuple(np.geomspace(0.04, 1.5, 40)),
    slopes=(1.0, 1.5, 2.0, 3.0, 4.5),
    lapses=(0.0, 0.02, 0.04),
)
WEIBULL = CURVES["weibull"]
#: The observer: half-way between its asymptotes at this level.
HALF_WAY_UM, SLOPE = 0.25, 2.0
SCALE_UM = HALF_WAY_UM / np.log(2) ** (1 / SLOPE)


def speed() -> None:
    """Print times and ratios."""
    trials, runs = 40, 1000
    rng = np.random.default_rng(1)

    loop = Loop(
        stim_domain={"intensity": np.array(GRID.levels_um_pp)},
        param_domain={
            "threshold": np.array(GRID.thresholds_um_pp),
            "slope": np.array(GRID.slopes),
            "lower_asymptote": GRID.guess,
            "lapse_rate": np.array(GRID.lapses),
        },
        outcome_domain={"response": ["correct", "wrong"]},
        func="weibull",
        stim_scale="linear",
    )
    begun = time.perf_counter()
    for _ in range(trials):
        level = loop.next_stim
        correct = rng.random() < probability(np.array(level["intensity"]), 0.02)
        loop.update(stim=level, outcome={"response": "correct" if correct else "wrong"})
    theirs = (time.perf_counter() - begun) / trials * 1e3

    batch = QuestPlusBatch.start(GRID, runs)
    begun = time.perf_counter()
    for _ in range(trials):
        batch = batch.answered(rng.random(runs) < probability(batch.levels_um_pp, 0.02))
    ours = (time.perf_counter() - begun) / trials / runs * 1e3
    print(f"questplus {theirs:.2f} ms a trial, batched {ours:.5f} ms: {theirs / ours:.0f} times")

    largest = QuestPlus(
        levels_um_pp=tuple(np.geomspace(0.02, 2.0, 100)),
        thresholds_um_pp=tuple(np.geomspace(0.04, 1.5, LARGEST_GRID // 100 // 20)),
        slopes=tuple(np.linspace(1, 5, 10)),
        lapses=(0.0, 0.02),
    )
    for name, grid in (("this grid", GRID), ("the largest grid admitted", largest)):
        track = grid.start().answered(correct=True)
        begun = time.perf_counter()
        for _ in range(trials):
            track = track.answered(correct=bool(rng.random() < 0.8))
        one = (time.perf_counter() - begun) / trials * 1e3
        print(f"one trial on {name}: {one:.3f} ms, {one / FRAME_MS:.4f} of a frame of 60 Hz")


def probability(level_um_pp: Array, lapse: float) -> Array:
    """Return the observer's proportion correct."""
    return WEIBULL.proportion(
        level_um_pp, threshold_um_pp=SCALE_UM, slope=SLOPE, guess=0.5, lapse=lapse
    )


@dataclass(frozen=True)
class Tracks:
    """Levels and answers of some runs, each of shape (runs, trials)."""

    levels_um_pp: Array
    correct: Array


def up_down(rule: UpDown) -> Callable[[int, int, float, np.random.Generator], Tracks]:
    """Return a simulation of an up-down rule."""

    def simulate(runs: int, trials: int, lapse: float, rng: np.random.Generator) -> Tracks:
        levels, correct = np.empty((2, runs, trials))
        for run in range(runs):
            track = rule.start()
            for trial in range(trials):
                levels[run, trial] = track.level_um_pp
                answer = bool(rng.random() < probability(levels[run, trial], lapse))
                correct[run, trial] = answer
                track = track.answered(correct=answer)
        return Tracks(levels, correct)

    return simulate


def quest_plus(runs: int, trials: int, lapse: float, rng: np.random.Generator) -> Tracks:
    """Simulate QUEST+."""
    batch = QuestPlusBatch.start(GRID, runs)
    levels, correct = np.empty((2, runs, trials))
    for trial in range(trials):
        levels[:, trial] = batch.levels_um_pp
        correct[:, trial] = rng.random(runs) < probability(batch.levels_um_pp, lapse)
        batch = batch.answered(correct[:, trial] > 0)
    return Tracks(levels, correct)


def constant_stimuli(runs: int, trials: int, lapse: float, rng: np.random.Generator) -> Tracks:
    """Simulate balanced levels, seven of them."""
    levels = np.tile(np.resize(np.geomspace(0.06, 1.0, 7), trials), (runs, 1))
    return Tracks(levels, (rng.random(levels.shape) < probability(levels, lapse)).astype(float))


START_UM, LOWEST_UM, HIGHEST_UM = 0.8, 0.01, 2.0
METHODS: dict[str, Callable[[int, int, float, np.random.Generator], Tracks]] = {
    "constant stimuli": constant_stimuli,
    "2-down-1-up": up_down(
        staircase(
            steps_up=(0.3, 0.2, 0.12),
            down_after=2,
            start_um_pp=START_UM,
            lowest_um_pp=LOWEST_UM,
            highest_um_pp=HIGHEST_UM,
        )
    ),
    "3-down-1-up": up_down(
        staircase(
            steps_up=(0.3, 0.2, 0.12),
            down_after=3,
            start_um_pp=START_UM,
            lowest_um_pp=LOWEST_UM,
            highest_um_pp=HIGHEST_UM,
        )
    ),
    "weighted 75 %": up_down(
        weighted(
            steps_up=(0.5, 0.3),
            target=0.75,
            start_um_pp=START_UM,
            lowest_um_pp=LOWEST_UM,
            highest_um_pp=HIGHEST_UM,
        )
    ),
    "QUEST+": quest_plus,
}


def recovery(runs: int) -> None:
    """Print bias, spread and coverage of each method, and coverage of scales."""
    model = likelihood.Model(curve=WEIBULL)
    drop = float(stats.chi2.ppf(0.95, 1)) / 2
    true = np.log(HALF_WAY_UM), np.log(SLOPE)
    print(
        f"{runs} runs each; share of 95 % intervals that hold the truth, "
        f"± {1.96 * (0.0475 / runs) ** 0.5:.3f}"
    )
    print("method             trials lapse  bias log10   SD   threshold  slope  population of 12")
    for trials in (60, 120, 240):
        for lapse in (0.02, 0.05):
            for name, simulate in METHODS.items():
                rng = np.random.default_rng([trials, int(100 * lapse)])
                tracks = simulate(runs, trials, lapse, rng)
                counts = likelihood.Counts(
                    np.log(tracks.levels_um_pp), tracks.correct, np.ones((runs, trials))
                )
                fits = likelihood.fit(model, counts)
                # As `thresholds.fit_threshold` judges them.
                flat, _ = fits.at_bound(likelihood.LOG_SLOPE)
                outside = np.any(fits.at_bound(likelihood.THRESHOLD), axis=0)
                good = ~(flat | outside)
                held = []
                for parameter, truth in enumerate(true):
                    # An interval holds the truth where the likelihood there has not fallen so far.
                    low, high = fits.bounds.low.copy(), fits.bounds.high.copy()
                    low[:, parameter] = high[:, parameter] = truth
                    there = likelihood.fit(model, counts, likelihood.Bounds(low, high))
                    fall = fits.log_likelihood - there.log_likelihood
                    held.append(np.mean((fall <= drop)[good]))
                error = (fits.theta[:, 0] - true[0])[good]
                decades = error / np.log(10)
                groups = error[: len(error) // 12 * 12].reshape(-1, 12)
                half = stats.t.ppf(0.975, 11) * groups.std(axis=1, ddof=1) / 12**0.5
                groups_held = np.mean(np.abs(groups.mean(axis=1)) <= half)
                print(
                    f"{name:<18} {trials:>6} {lapse:5.2f}  {decades.mean():+.3f} ± "
                    f"{decades.std() / len(decades) ** 0.5:.3f}  {decades.std():.3f}  "
                    f"{held[0]:.3f}      {held[1]:.3f}  {groups_held:.3f}  "
                    f"({np.sum(~good)} without a threshold)",
                    flush=True,
                )


def scales(runs: int) -> None:
    """Print how often intervals of scales hold the truth."""
    true = np.array([-1.0, -0.4, 0.1, 0.5, 0.8])
    for name, estimate, curve in (
        ("Bradley-Terry", bradley_terry, CURVES["logistic"]),
        ("Thurstone V", thurstone, CURVES["normal"]),
    ):
        share = curve.distribution(true[:, None] - true[None, :])
        for people, spread in ((1, 0.0), (12, 0.0), (12, 0.5)):
            rng = np.random.default_rng(5)
            held, there = np.zeros(5), 0
            for _ in range(runs):
                own = true + spread * rng.standard_normal((people, 5))
                own = (
                    share[None]
                    if not spread
                    else curve.distribution(own[:, :, None] - own[:, None, :])
                )
                trials = np.triu(np.full((5, 5), 48 // people if people > 1 else 40), k=1).astype(
                    int
                )
                won = rng.binomial(trials, np.broadcast_to(own, (people, 5, 5)))
                chosen = won + (trials - won).transpose(0, 2, 1)
                found = estimate(chosen)
                if not isinstance(found, NotComputed):
                    there += 1
                    held += [a <= t <= b for (a, b), t in zip(found.intervals, true, strict=True)]
            print(
                f"{name:<14} {people:>2} people, SD {spread}: intervals hold "
                f"{np.mean(held) / there:.3f} ({runs - there} without)",
                flush=True,
            )
    values, noise = np.array([0.0, 0.1, 0.3, 0.6, 0.8, 1.0]), 0.25
    rng = np.random.default_rng(6)
    quadruples = np.array(
        [
            [a, b, c, d]
            for a in range(6)
            for b in range(a + 1, 6)
            for c in range(b, 6)
            for d in range(c + 1, 6)
        ]
    )
    some = runs // 4
    for repeats in (8, 24):
        held, noise_held, there = np.zeros(4), 0, 0
        shown = np.repeat(quadruples, repeats, axis=0)
        distance = values[shown] @ [1, -1, -1, 1]
        for run in range(some):
            larger = distance + noise * rng.standard_normal(len(shown)) > 0
            fitted = difference_scale(shown, larger, simulations=200, seed=run)
            if isinstance(fitted, NotComputed):
                continue
            there += 1
            held += [
                one is not None and one.low <= value <= one.high
                for one, value in zip(fitted.intervals[1:-1], values[1:-1], strict=True)
            ]
            low, high = fitted.noise_interval
            noise_held += low <= noise <= high
        print(
            f"difference scaling, {len(shown)} quadruples: values {np.mean(held) / there:.3f}, "
            f"noise {noise_held / there:.3f} ({some - there} without)",
            flush=True,
        )


def main() -> None:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=["speed", "recovery", "scales"])
    parser.add_argument("--runs", type=int, default=400)
    asked = parser.parse_args()
    if asked.what == "speed":
        speed()
    else:
        {"recovery": recovery, "scales": scales}[asked.what](asked.runs)


if __name__ == "__main__":
    main()
