"""Measure how often intervals cover a population's true threshold or point of subjective equality.

Simulated people choose one of two intervals or compare surfaces with a standard, at fixed levels.
Their thresholds and slopes differ. The answers are analysed with the function that `analyse` uses.
Finished studies are cached in build/population_thresholds.

    .venv/bin/python -m benchmarks.population_thresholds [--studies 1000] [--write]
"""

from __future__ import annotations

import argparse
import json
import os
import re
import zlib
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # As in `slipscale analyse`.
from collections.abc import Callable

import numpy as np

from benchmarks.measured_page import put
from slipscale.analysis.statistics.psychometrics.hierarchical import HierarchicalFit, Trials
from slipscale.analysis.statistics.psychometrics.integrated_over_people import students_fall
from slipscale.analysis.statistics.psychometrics.thresholds import model_of
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES
from slipscale.experiments.study.analysis_choices import AnalysisChoices

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

KEPT = Path(__file__).resolve().parents[1] / "build" / "population_thresholds"
SIZES, LAPSES = (6, 12, 24), (0.0, 0.05)
#: Answers per level, standard deviation of log slopes, and studies per cached file.
EACH, SLOPES, BATCH = 10, 0.25, 50
#: If a cell's coverage is outside these limits, its number of studies is multiplied by this factor,
#: because a few of the sixty cells are outside by chance.
EXPECTED, AGAIN = (0.93, 0.97), 3


class Observer(NamedTuple):
    """True curve of simulated people, and the curve that is fitted to their answers.

    ``rises`` returns the value of the true curve, from 0 to 1, for the distance between a level and
    the person's threshold (in logarithms, if ``logarithmic``). At the threshold, the value is 0.5.
    The typical threshold is 1; ``spread`` is the standard deviation of these distances.
    """

    method: str
    logarithmic: bool
    rises: Callable[[Array], Array]
    fitted: str

    @property
    def levels(self) -> Array:
        """Levels that are presented."""
        return LEVELS[self.method, self.logarithmic][0]

    @property
    def spread(self) -> float:
        """Standard deviation of thresholds."""
        return LEVELS[self.method, self.logarithmic][1]


#: Levels, and standard deviation of thresholds (of their logarithms, if the axis is logarithmic),
#: keyed by method and by whether the axis is logarithmic.
LEVELS = {
    ("two_interval", True): (np.geomspace(0.4, 3.0, 6), 0.35),
    ("two_interval", False): (np.linspace(0.2, 2.2, 6), 0.25),
    ("comparison", True): (np.geomspace(0.6, 1.6, 6), 0.1),
    ("comparison", False): (np.linspace(0.5, 1.5, 6), 0.1),
}


def _observer(method: str, curve: str, steepness: float, fitted: str = "") -> Observer:
    family = CURVES[curve]
    half = family.inverse(np.array(0.5))
    return Observer(
        method,
        family.logarithmic,
        lambda above: np.asarray(family.distribution(half + steepness * above)),
        fitted or curve,
    )


def _linear_d_prime(above: Array) -> Array:
    # Proportion correct in two intervals, corrected for guessing. d' is proportional to the level
    # or, for people with other slopes, to a power of the level.
    normal = CURVES["normal"].distribution
    return np.asarray(2 * normal(0.6744897501960817 * np.exp(above)) - 1)


#: The fitted curve is the true curve, unless the name contains another one.
OBSERVERS = {
    "threshold: Weibull": _observer("two_interval", "weibull", 2.0),
    "threshold: Gumbel": _observer("two_interval", "gumbel", 2.0),
    "threshold: logistic of the logarithm": _observer("two_interval", "log_logistic", 2.9),
    "threshold: d' in proportion to the level, fitted with Weibull": Observer(
        "two_interval", True, _linear_d_prime, "weibull"
    ),
    "threshold: Gumbel, fitted with Weibull": _observer("two_interval", "gumbel", 2.0, "weibull"),
    "equality: d' in proportion to the difference": _observer("comparison", "normal", 4.5),
    "equality: logistic": _observer("comparison", "logistic", 7.3),
    "equality: Gumbel": _observer("comparison", "gumbel", 5.2),
    "equality: Weibull": _observer("comparison", "weibull", 5.2),
    "equality: normal of the logarithm, fitted with normal": _observer(
        "comparison", "log_normal", 4.5, "normal"
    ),
}


class Cell(NamedTuple):
    """Coverage of 95 % intervals, and the mean error of the estimates with its standard error.

    Errors are relative to the mean of the simulated people, because its random difference from the
    true value would hide a small bias.
    """

    studies: int
    coverage: float
    bias: float
    error: float

    def __str__(self) -> str:
        """Return coverage, bias in per cent, and bias in standard errors."""
        return f"{self.coverage:.3f}; {100 * self.bias:+.1f} ({self.bias / self.error:+.1f})"


def study(
    rng: np.random.Generator, people: int, lapse: float, observer: Observer
) -> tuple[Trials, float]:
    """Return the answers in a simulated study, and the mean deviation of people's thresholds."""
    fitted, levels = CURVES[observer.fitted], observer.levels
    place = np.log(levels) if observer.logarithmic else levels - 1.0
    own = rng.normal(0.0, observer.spread, (people, 1))
    steep = np.exp(rng.normal(0.0, SLOPES, (people, 1)))
    low = 0.5 if observer.method == "two_interval" else lapse
    p = low + (1 - low - lapse) * observer.rises(steep * (place - own))
    yes = rng.binomial(EACH, p).astype(float).ravel()
    answers = Trials(
        person=np.repeat(np.arange(people), len(levels)),
        condition=np.zeros(yes.size, int),
        design=np.ones((yes.size, 1)),
        u=np.tile(fitted.coordinate(levels), people),
        yes=yes,
        n=np.full(yes.size, float(EACH)),
    )
    return answers, float(own.mean())


def measure(name: str, people: int, lapse: float, first: int) -> list[tuple[bool, float]]:
    """Return whether the interval contains the true value, and the error, per study in a batch."""
    observer, choices, found = OBSERVERS[name], AnalysisChoices(), []
    model = model_of(observer.method, observer.fitted, 0.5, choices.largest_lapse)
    fall = students_fall(people, people - 1, choices.confidence)
    truth = float(model.curve.coordinate(1.0))
    for number in range(first, first + BATCH):
        drawn = [zlib.crc32(name.encode()), people, round(1000 * lapse), number]
        answers, off = study(np.random.default_rng(drawn), people, lapse, observer)
        fit = HierarchicalFit(model, answers)
        zero = float(fit.coordinates(np.array(0.0)))
        held = fit.fallen({0: (truth - zero) / fit.scale}) <= fall
        found.append((held, float(fit.coordinates(fit.best.theta[0])) - truth - off))
    return found


def kept(name: str, people: int, lapse: float, first: int) -> list[tuple[bool, float]]:
    """Return a batch; measure it on first use and cache the result."""
    file = re.sub(r"[^\w]+", "-", name)
    path = KEPT / f"{file}_{people}_{lapse:g}_{first}.json"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(measure(name, people, lapse, first)), encoding="utf-8")
    return [(held, error) for held, error in json.loads(path.read_text(encoding="utf-8"))]


def cell(name: str, people: int, lapse: float, studies: int, again: int = AGAIN) -> Cell:
    """Return the coverage and bias, with more studies if the coverage is unexpected."""
    batches = [kept(name, people, lapse, first) for first in range(0, studies, BATCH)]
    held, errors = np.array([each for batch in batches for each in batch]).T
    spread = float(np.std(errors, ddof=1)) / len(errors) ** 0.5
    found = Cell(len(errors), float(held.mean()), float(errors.mean()), spread)
    if again == 1 or EXPECTED[0] <= found.coverage <= EXPECTED[1]:
        return found
    return cell(name, people, lapse, again * studies, again=1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=1000, help="per cell (default: 1000)")
    parser.add_argument("--observer", choices=OBSERVERS, help="default: all")
    parser.add_argument("--write", action="store_true", help="put the table into the page")
    args = parser.parse_args()
    names = [args.observer] if args.observer else list(OBSERVERS)
    # Each batch is finished for all cells before the next, in case the run is interrupted.
    for first, name, lapse, people in product(range(0, args.studies, BATCH), names, LAPSES, SIZES):
        kept(name, people, lapse, first)
    lines = [
        f"| observers, lapses | {' | '.join(f'{people} people' for people in SIZES)} |",
        "| --- |" + " --- |" * len(SIZES),
    ]
    for name, lapse in product(names, LAPSES):
        cells = (cell(name, people, lapse, args.studies) for people in SIZES)
        lines.append(f"| {name}, {lapse:.0%} | {' | '.join(map(str, cells))} |")
    print("\n".join(lines))
    if args.write:
        more = f"{AGAIN * args.studies} where {args.studies} gave a coverage outside .93 to .97"
        put("populations", [f"{args.studies} studies per cell, {more}.", "", *lines])


if __name__ == "__main__":
    main()
