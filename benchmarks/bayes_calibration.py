"""Simulation-based calibration of the hierarchical Bayesian power function.

    .venv/bin/python benchmarks/bayes_calibration.py [--studies 200]

Parameters are drawn from the priors, a study from the parameters, the posterior from the study:
where model and sampler are right, the true parameter's rank among the draws is uniform (Talts et
al. 2018, arXiv 1804.06788). Prints, for each parameter, p of a chi-square test of uniformity and
how often the intervals of .5 and .9 hold the truth. Needs slipscale[bayes].
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from scipy import stats

from slipscale.analysis.tasks.estimation.growth.hierarchical_sampler import (
    LKJ,
    PRIOR_SD,
    Trials,
    sample,
)

PEOPLE, REPETITIONS = 8, 4
AMPLITUDES = np.array([0.3, 0.5, 1.2, 2.3])
#: Ranks are counted in so many bins; draws are thinned to be nearly independent.
BINS, KEPT = 10, 99
LEVELS = (0.5, 0.9)


def study(rng: np.random.Generator) -> tuple[dict[str, float], Trials]:
    """Return parameters from the priors, and a study from the parameters."""
    truth = {name: float(rng.normal(0, PRIOR_SD[name])) for name in ("A", "B")}
    truth |= {name: float(abs(rng.normal(0, PRIOR_SD[name]))) for name in ("ta", "tb", "s")}
    r = 2 * rng.beta(LKJ, LKJ) - 1
    covariance = truth["ta"] * truth["tb"] * r
    own = rng.multivariate_normal(
        [truth["A"], truth["B"]],
        [[truth["ta"] ** 2, covariance], [covariance, truth["tb"] ** 2]],
        PEOPLE,
    )
    log_x = np.tile(np.repeat(np.log(AMPLITUDES), REPETITIONS), PEOPLE)
    log_x -= log_x.mean()
    who = np.repeat(np.arange(PEOPLE), len(AMPLITUDES) * REPETITIONS)
    log_y = own[who, 0] + own[who, 1] * log_x + rng.normal(0, truth["s"], len(who))
    truth |= {"half_r": (r + 1) / 2, "exponent of one": float(own[0, 1])}
    names = tuple(str(number) for number in range(PEOPLE))
    return truth, Trials(log_y=log_y, log_x=log_x, who=who, names=names)


def main() -> None:
    """Simulate, sample, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=200, help="simulated (default: 200)")
    parser.add_argument("--seed", type=int, default=2018, help="of the simulations (default: 2018)")
    args = parser.parse_args()
    start = time.perf_counter()
    ranks: dict[str, list[int]] = {}
    divergent = 0
    for number in range(args.studies):
        truth, trials = study(np.random.default_rng([args.seed, number]))
        drawn = sample(trials, seed=number)
        divergent += drawn.divergences > 0
        values = dict(drawn.values) | {"exponent of one": drawn.values["own"][..., 0, 1]}
        for name, true in truth.items():
            flat = values[name].ravel()
            kept = flat[:: len(flat) // KEPT][:KEPT]
            ranks.setdefault(name, []).append(int((kept < true).sum()))
    print(f"{args.studies} studies of {PEOPLE} people, {divergent} with divergences")
    print("| parameter | p of uniform ranks | .5 holds | .9 holds |\n| --- | --- | --- | --- |")
    for name, found in ranks.items():
        place = (np.array(found) + 0.5) / (KEPT + 1)
        counts = np.histogram(place, BINS, (0, 1))[0]
        held = [f"{(np.abs(place - 0.5) < level / 2).mean():.3f}" for level in LEVELS]
        print(f"| {name} | {stats.chisquare(counts).pvalue:.2f} | {' | '.join(held)} |")
    print(f"{time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
