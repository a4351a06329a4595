"""Measure how often a population's threshold interval contains the true value.

Simulated people with individual thresholds answer at constant levels, two intervals. Their answers
are analysed by the function of the analysis. Measured cells are stored in
build/population_thresholds and not measured again.

    .venv/bin/python -m benchmarks.population_thresholds [--studies 1000] [--write]
"""

from __future__ import annotations

import argparse
import json
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from benchmarks.measured_page import put
from slipscale.analysis.statistics.psychometrics.hierarchical import HierarchicalFit, Trials
from slipscale.analysis.statistics.psychometrics.integrated_over_people import students_fall
from slipscale.analysis.statistics.psychometrics.thresholds import model_of
from slipscale.experiments.protocols.adaptive.curves import CURVES
from slipscale.experiments.study.analysis_choices import AnalysisChoices

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

KEPT = Path(__file__).resolve().parents[1] / "build" / "population_thresholds"
SIZES, LAPSES = (6, 12, 24), (0.0, 0.02, 0.05, 0.1)
#: Levels, relative to a typical threshold of 1; answers per level; SD of log thresholds.
LEVELS, EACH, SPREAD = np.geomspace(0.4, 3.0, 6), 10, 0.35


class Observer(NamedTuple):
    """Rise of the typical person's curve, 0 to 1, half-way at level 1; and the fitted curve."""

    rises: Callable[[Array], Array]
    fitted: str


def _weibull(level: Array) -> Array:
    return np.asarray(-np.expm1(-np.log(2) * level**2.0))


def _linear_d_prime(level: Array) -> Array:
    # Proportion correct of two intervals with d' proportional to the level, corrected for chance.
    normal = CURVES["normal"].distribution
    return np.asarray(2 * normal(0.6744897501960817 * level) - 1)


def _on_log_axis(curve: str, steepness: float) -> Callable[[Array], Array]:
    return lambda level: np.asarray(CURVES[curve].distribution(steepness * np.log(level)))


#: A family is fitted with its own curve; d' proportional to the level with the default one.
OBSERVERS = {
    "Weibull": Observer(_weibull, "weibull"),
    "normal on a log axis": Observer(_on_log_axis("normal", 1.7), "log_normal"),
    "logistic on a log axis": Observer(_on_log_axis("logistic", 2.9), "log_logistic"),
    "d' in proportion to the level": Observer(_linear_d_prime, "weibull"),
}


class Cell(NamedTuple):
    """Coverage of .95 intervals, and the mean error with its standard error, in decades."""

    studies: int
    coverage: float
    bias: float
    error: float


def study(rng: np.random.Generator, people: int, lapse: float, observer: Observer) -> Trials:
    """Return the answers of a simulated study; the typical threshold is 1."""
    own = np.exp(rng.normal(0.0, SPREAD, people))
    share = observer.rises(LEVELS / own[:, None])
    yes = rng.binomial(EACH, 0.5 + (0.5 - lapse) * share).astype(float).ravel()
    return Trials(
        person=np.repeat(np.arange(people), len(LEVELS)),
        condition=np.zeros(yes.size, int),
        design=np.ones((yes.size, 1)),
        u=np.tile(np.log(LEVELS), people),
        yes=yes,
        n=np.full(yes.size, float(EACH)),
    )


def measure(name: str, people: int, lapse: float, studies: int) -> Cell:
    """Simulate a cell: the interval covers if the profile falls little at the true value."""
    observer = OBSERVERS[name]
    choices = AnalysisChoices()
    model = model_of("two_interval", observer.fitted, 0.5, choices.largest_lapse)
    fall = students_fall(people, people - 1, choices.confidence)
    errors, held = [], 0
    for number in range(studies):
        rng = np.random.default_rng([people, round(1000 * lapse), number])
        fit = HierarchicalFit(model, study(rng, people, lapse, observer))
        # The true value is 0, a threshold of 1.
        held += fit.fallen({0: float(-fit.coordinates(np.array(0.0)) / fit.scale)}) <= fall
        errors.append(float(fit.coordinates(fit.best.theta[0])) / np.log(10))
    spread = float(np.std(errors, ddof=1)) / studies**0.5
    return Cell(studies, held / studies, float(np.mean(errors)), spread)


def kept(name: str, people: int, lapse: float, studies: int) -> Cell:
    """Return a cell, measured only once."""
    path = KEPT / f"{name.replace(' ', '-')}_{people}_{lapse:g}_{studies}.json"
    if not path.exists():
        cell = measure(name, people, lapse, studies)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(cell), encoding="utf-8")
    return Cell(*json.loads(path.read_text(encoding="utf-8")))


def main() -> None:
    """Measure, print, and with --write insert the table into the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=1000, help="per cell (default: 1000)")
    parser.add_argument("--observer", choices=OBSERVERS, help="default: all")
    parser.add_argument("--write", action="store_true", help="put the table into the page")
    args = parser.parse_args()
    lines = [
        f"| observers, lapses | {' | '.join(f'{people} people' for people in SIZES)} |",
        "| --- |" + " --- |" * len(SIZES),
    ]
    for name, lapse in product(OBSERVERS, LAPSES):
        if args.observer not in {None, name}:
            continue
        cells = [kept(name, people, lapse, args.studies) for people in SIZES]
        told = (f"{each.coverage:.3f}; {each.bias:+.4f}" for each in cells)
        lines.append(f"| {name}, {lapse:.0%} | {' | '.join(told)} |")
        print(lines[-1], flush=True)
    if args.write:
        put("populations", [f"{args.studies} studies per cell.", "", *lines])


if __name__ == "__main__":
    main()
