"""Measure how often intervals cover a population's true threshold and point of equality.

Simulated people answer at constant levels: two intervals, or comparisons with a standard. Their
thresholds differ, and so do the slopes of their curves. The answers are analysed with the
analysis's own function. Measured studies are stored in build/population_thresholds and not
measured again.

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

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as `slipscale analyse` sets it
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
#: Answers per level, SD of log slopes, and studies that are stored together.
EACH, SLOPES, BATCH = 10, 0.25, 50
#: A cell with a coverage outside these limits is measured with this many times as many studies: of
#: sixty cells, a few are outside by chance.
EXPECTED, AGAIN = (0.93, 0.97), 3


class Observer(NamedTuple):
    """The typical person's answers, and the curve that is fitted to them.

    ``rises`` is the curve, 0 to 1, by how far a level is above the person's threshold on the axis
    of ``levels``; half-way at 0. The typical threshold is a level of 1; ``spread`` is its standard
    deviation on that axis.
    """

    method: str
    logarithmic: bool
    rises: Callable[[Array], Array]
    fitted: str

    @property
    def levels(self) -> Array:
        """Levels presented."""
        return LEVELS[self.method, self.logarithmic][0]

    @property
    def spread(self) -> float:
        """SD of thresholds."""
        return LEVELS[self.method, self.logarithmic][1]


#: Levels, and SD of thresholds on their axis, by method and whether the axis is logarithmic.
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
    # Proportion correct of two intervals with d' proportional to the level, corrected for chance.
    # Slopes that differ are powers of the level.
    normal = CURVES["normal"].distribution
    return np.asarray(2 * normal(0.6744897501960817 * np.exp(above)) - 1)


#: A family is fitted with its own curve, unless stated otherwise.
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
    """Coverage of .95 intervals, and the mean error with its standard error (typical value: 1).

    Errors are taken against the mean of the people drawn, whose expected value is the truth: their
    spread by chance would hide a small bias.
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
    """Return a simulated study's answers, and how far its people's mean is from the typical one."""
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
    """Return for each study in a batch whether the interval covers the truth, and the error."""
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
    """Return the coverage and bias in some studies, or in more if the coverage is unexpected."""
    batches = [kept(name, people, lapse, first) for first in range(0, studies, BATCH)]
    held, errors = np.array([each for batch in batches for each in batch]).T
    spread = float(np.std(errors, ddof=1)) / len(errors) ** 0.5
    found = Cell(len(errors), float(held.mean()), float(errors.mean()), spread)
    if again == 1 or EXPECTED[0] <= found.coverage <= EXPECTED[1]:
        return found
    return cell(name, people, lapse, again * studies, again=1)


def main() -> None:
    """Measure, print, and with --write insert the table into the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=1000, help="per cell (default: 1000)")
    parser.add_argument("--observer", choices=OBSERVERS, help="default: all")
    parser.add_argument("--write", action="store_true", help="put the table into the page")
    args = parser.parse_args()
    names = [args.observer] if args.observer else list(OBSERVERS)
    # All cells of a batch before the next batch: an interrupted run has as many studies of each.
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
