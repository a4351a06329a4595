"""Simulate studies with known truths, and check all that a report says of them.

    OMP_NUM_THREADS=1 .venv/bin/python -m benchmarks.truths [--only PROTOCOL] [--jobs 2]
    .venv/bin/python -m benchmarks.truths --write

Each of the 18 protocols is simulated with 3, 6 and 12 people. Without an effect, everybody feels
all levels alike, so each significant p value and each sentence with "differed" is a false alarm.
With an effect, sensations lie at the floor, in the middle or at the ceiling, and each printed
interval should contain what the same analysis finds in one study of many people. This truth has no
bias of small samples, and contains the bias that is left in large ones, which
`benchmarks.recovery` measures. People are simulated and read once, `CHUNK` at a time: together,
the first ones are the large study, and all studies are parts of them. Finished cells are cached in
build/truths.
"""

from __future__ import annotations

import argparse
import datetime as dt
import json
import math
import re
import tempfile
import traceback
import warnings
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import NamedTuple
from unittest import mock

import numpy as np
import pandas as pd
from joblib import Parallel, delayed

from benchmarks.measured_page import put
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.planning.distribution.numbers import (
    BOUNDS,
    OF_AN_INTERVAL,
    TABLE3,
    Label,
    ResultName,
    findings,
)
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.reporting.sections.summary import answers
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.kind import Analysis
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.bare_dataset import write_simulated
from slipscale.experiments.running.pilot import pilot_plans
from slipscale.faults import UserError

ROOT = Path(__file__).resolve().parents[1]
KEPT = ROOT / "build" / "truths"
SIZES = (3, 6, 12)
SEED = 7
STUDIES = 200  # at most, per cell
PEOPLE = 1200  # simulated for each protocol and place, unless the command line sets another number
#: Share of these people for protocols whose analysis takes more than 0.2 s per study.
SLOW: Mapping[str, float] = {
    "magnitude_estimation": 0.4,
    "constant_stimuli": 0.4,
    "detection_threshold": 0.2,
    "difference_threshold": 0.2,
    "oddity": 0.2,
}
#: People simulated at once (a multiple of each size); the first of them are the large study.
CHUNK, SLOW_CHUNK = 480, 192
#: The most likely curve of a single participant yields only its goodness of fit, which is slow to
#: simulate and is not counted.
FIT = "slipscale.analysis.tasks.thresholds.statistics.fit_threshold"
LEVELS = (0.0, 0.5, 1.2, 2.3)
#: Sensations of people who feel all levels alike, or who use the lower end, the middle or the upper
#: end of their scale; and the noise (in sensation) with which they discriminate.
PLACES: Mapping[str, tuple[tuple[float, ...], float]] = {
    "none": ((50.0, 50.0, 50.0, 50.0), 2.2),
    "floor": ((1.0, 2.0, 4.0, 7.0), 20.0),
    "middle": ((20.0, 35.0, 55.0, 75.0), 5.0),
    "ceiling": ((70.0, 85.0, 93.0, 97.0), 1.0),
}
STUDY = """name = "simulated"
title = "Simulated"
language = "en"
seed = 1
participants = 6
amplitudes_um_pp = [{levels}]
[plate]
tolerance = 0.01
tolerance_um_pp = 0.015
[[tasks]]
protocol = "{protocol}"
"""
#: Keys of each protocol beside its defaults.
KEYS: Mapping[str, str] = {
    "category_scale": 'labels = ["none", "weak", "moderate", "strong", "very strong"]',
    "constant_stimuli": "standard_um_pp = 0.5\ncomparisons_um_pp = [0.6, 0.8, 1.2, 1.7, 2.3]",
    "descending_difference": "",
    "detection_threshold": "",
    "difference_threshold": "start_um_pp = 0.6\nlowest_um_pp = 0.05",
    "identification": "",
    "limits": "",
    "magnitude_estimation": "",
    "magnitude_production": "standard_um_pp = 0.8\nmodulus = 10.0\n"
    "numbers = [7.0, 10.0, 14.0, 20.0]",
    "matching": "nearest_start_um_pp = 0.1\nfurthest_start_um_pp = 0.2\nhighest_um_pp = 2.5",
    "oddity": "lowest_um_pp = 0.07",
    "paired_comparison": "",
    "pointing": "",
    "ratio_to_standard": "standard_um_pp = 1.2",
    "same_different": "",
    "similarity": "",
    "sorting": "",
    "visual_analogue_scale": "",
}
#: Levels of protocols that cannot begin at 0.
ABOVE_ZERO = ("matching", "magnitude_production", "ratio_to_standard")
DIFFERED = re.compile(r"\b(differed|differ|was larger|rose|was biased|had an effect)\b")
#: Keys of the estimate beside an interval that is called only "interval".
ESTIMATES = ("mean", "value", "exponent", "ratio", "level", "d_prime", "half_yes")
#: Tests of something that is true although levels do not matter: a mean against 0, equivalence.
#: Also matches that begin below and above the reference: people who feel no difference stay there.
TRUE_ANYWAY = re.compile(
    r"throughput|movement_time|error_share|intercept|(as|des)cending_level|threshold_level"
    r"|equivalence|productions.slope|slope_s_per_bit|matching.direction"
)
DENIED = re.compile(r"\b(not|no|cannot|at most)\b")


class Cell(NamedTuple):
    """Simulated studies of one protocol, place and number of people."""

    protocol: str
    place: str
    people: int

    @property
    def population(self) -> Population:
        """The simulated people; without an effect, their individual exponents are 0, too."""
        sensation, noise = PLACES[self.place]
        spread = tuple(0.25 * min(each, 100 - each) for each in sensation)
        shared = 0.85 if self.place == "none" else 0.55
        return Population(
            name="truths",
            levels=LEVELS,
            mean_sensation=sensation,
            sd_sensation=spread,
            shared=shared,
            noise=noise,
        )


def study_text(protocol: str) -> str:
    """Return the study file of a protocol."""
    levels = LEVELS[1:] if protocol in ABOVE_ZERO else LEVELS
    text = STUDY.format(levels=", ".join(map(str, levels)), protocol=protocol)
    return f"{text}{KEYS[protocol]}\n"


def simulated(cell: Cell, people: int, seed: int) -> Dataset:
    """Simulate people, and read their trials."""
    with tempfile.TemporaryDirectory(prefix="slipscale-") as name:
        file = Path(name) / "study.toml"
        file.write_text(study_text(cell.protocol), encoding="utf-8")
        plans = pilot_plans(
            str(file),
            participants=people,
            seed=seed,
            language=None,
            population=cell.population,
        )
        folder = Path(name) / "data"
        write_simulated(folder, plans, cell.population, sessions=False)
        return replace(load(folder), folder=None)


def people_of(cell: Cell, most: int) -> list[Dataset]:
    """Simulate the people of a protocol and place: ``most``, or fewer if the protocol is slow."""
    people = int(most * SLOW.get(cell.protocol, 1.0)) // max(SIZES) * max(SIZES)
    chunk = SLOW_CHUNK if cell.protocol in SLOW else CHUNK
    return [
        simulated(cell, min(chunk, people - first), SEED + first)
        for first in range(0, people, chunk)
    ]


def studies_of(cell: Cell, data: Sequence[Dataset]) -> list[Dataset]:
    """Return a cell's studies, which have no participants in common."""
    parts = [
        of_people(chunk, names[start : start + cell.people])
        for chunk in data
        for names in [sorted(chunk.people)]
        for start in range(0, len(names), cell.people)
    ]
    return parts[:STUDIES]


def of_people(data: Dataset, who: Sequence[str]) -> Dataset:
    """Return the data of some participants."""
    part = data.with_tables(lambda rows: rows_of(rows, who))
    return replace(part, participants=rows_of(data.participants, who))


def rows_of(rows: pd.DataFrame, who: Sequence[str]) -> pd.DataFrame:
    """Return some participants' rows."""
    return rows[rows[PARTICIPANT].isin(who)].reset_index(drop=True) if len(rows) else rows


def analysed(data: Dataset) -> Analysis | None:
    """Return a study's analysis, or None if the data are refused."""
    try:
        with mock.patch(FIT, return_value=NotComputed("not counted here")):
            return analyse(data)
    except UserError:
        return None


def family(name: ResultName) -> str:
    """Return a result's name without levels and tasks."""
    words = (each for each in name if not isinstance(each, Label))
    return ".".join(each for each in words if not re.search(r"\d", each))


def numbers_of(analysis: Analysis) -> dict[ResultName, float]:
    """Return the results of the statistics, and the described means with their intervals."""
    numbers = dict(findings(analysis).numbers)
    for row in analysis.description.to_dict("records") if analysis.prepared else ():
        for kind, column in (("mean", "mean"), ("geometric", "geometric_mean")):
            name = (TABLE3, Label((f"{row['level']:g}",)), kind)
            numbers[ResultName((*name, "mean"))] = row[column]
            for bound in BOUNDS:
                numbers[ResultName((*name, "ci", bound))] = row[f"{kind}_{bound}"]
    return {name: value for name, value in numbers.items() if math.isfinite(value)}


def intervals(numbers: Mapping[ResultName, float]) -> Iterator[tuple[ResultName, float, float]]:
    """Yield each interval's estimate, by name, with the interval's bounds."""
    for whole in dict.fromkeys(name[:-1] for name in numbers if name[-1] in BOUNDS):
        last = str(whole[-1])
        own = re.sub(r"_(ci|interval)$", "", last)
        if own == last and last not in OF_AN_INTERVAL:
            continue
        names = ESTIMATES if own == last else (own,)
        found = [ResultName((*whole[:-1], each)) for each in names]
        low, high = (ResultName((*whole, bound)) for bound in BOUNDS)
        for estimate in [each for each in found if each in numbers][:1]:
            yield estimate, numbers.get(low, -math.inf), numbers.get(high, math.inf)


class Counts(NamedTuple):
    """How often something holds, and in how many results it was looked for."""

    holds: int
    of: int

    @property
    def share(self) -> float:
        """The share of results in which it holds."""
        return self.holds / self.of

    def outside(self, low: float, high: float) -> bool:
        """Return whether the share is outside limits by more than chance (2.6 standard errors)."""
        error = 2.6 * math.sqrt(max(self.share * (1 - self.share), 0.02) / self.of)
        return self.share + error < low or self.share - error > high


@dataclass
class Measured:
    """What is counted in the simulated studies of a cell."""

    studies: int = 0
    refused: int = 0
    differed: int = 0
    significant: dict[str, Counts] = field(default_factory=dict)
    covered: dict[str, Counts] = field(default_factory=dict)
    bias_sd: dict[str, float] = field(default_factory=dict)


def truth_of(cell: Cell, data: Dataset) -> Mapping[ResultName, float]:
    """Return the results of one study of many people; empty without an effect."""
    large = None if cell.place == "none" else analysed(data)
    return numbers_of(large) if large else {}


def measured(studies: Sequence[Dataset], truth: Mapping[ResultName, float]) -> Measured:
    """Analyse a cell's studies and count."""
    out = Measured(studies=len(studies))
    holds: dict[str, list[bool]] = defaultdict(list)
    covers: dict[str, list[bool]] = defaultdict(list)
    errors: dict[ResultName, list[float]] = defaultdict(list)
    for study in studies:
        analysis = analysed(study)
        if analysis is None:
            out.refused += 1
            continue
        numbers = numbers_of(analysis)
        said = [text for text in answers(analysis) if DIFFERED.search(text)]
        out.differed += any(not DENIED.search(text) for text in said)
        for name, concluded in findings(analysis).conclusions.items():
            if "p" in str(name[-1]).split("_"):
                holds[family(name)].append(concluded)
        for name, low, high in intervals(numbers):
            if name in truth:
                covers[family(name)].append(low <= truth[name] <= high)
                errors[name].append(numbers[name] - truth[name])
    out.significant = {name: Counts(sum(each), len(each)) for name, each in holds.items()}
    out.covered = {name: Counts(sum(each), len(each)) for name, each in covers.items()}
    out.bias_sd = {
        family(name): float(np.mean(each) / np.std(each))
        for name, each in errors.items()
        if len(each) > len(studies) / 2 and np.std(each) > 0
    }
    return out


def measure(cells: Sequence[Cell], people: int) -> None:
    """Measure and keep cells of one protocol and place, which differ in the number of people."""
    warnings.filterwarnings("ignore")  # of fits that the analysis checks itself
    try:
        data = people_of(cells[0], people)
        truth = truth_of(cells[0], data[0])
        for cell in cells:
            found = measured(studies_of(cell, data), truth)
            KEPT.mkdir(parents=True, exist_ok=True)
            place_of(cell).write_text(json.dumps(asdict(found)), encoding="utf-8")
            print(*cell, in_words(cell.place, found), flush=True)
    except Exception:  # noqa: BLE001 - one cell's fault must not end the campaign
        print(*cells[0], traceback.format_exc(), flush=True)


def place_of(cell: Cell) -> Path:
    """Return the file in which a cell's counts are kept."""
    return KEPT / f"{'_'.join(map(str, cell))}.json"


def kept(cell: Cell) -> Measured | None:
    """Return a cell's counts from the cache, or None."""
    path = place_of(cell)
    if not path.exists():
        return None
    data = json.loads(path.read_text(encoding="utf-8"))
    for key in ("significant", "covered"):
        data[key] = {name: Counts(*counts) for name, counts in data[key].items()}
    return Measured(**data)


def rows(cells: Mapping[Cell, Measured]) -> Iterator[str]:
    """Yield the table: a row for each protocol and place, with one entry per number of people."""
    yield f"| protocol | sensations | {' | '.join(f'{n} people' for n in SIZES)} |"
    yield "| --- | --- |" + " --- |" * len(SIZES)
    for protocol in KEYS:
        for place in PLACES:
            found = [cells.get(Cell(protocol, place, n)) for n in SIZES]
            if any(found):
                texts = [in_words(place, each) if each else "not measured" for each in found]
                yield f"| {protocol} | {place} | {' | '.join(texts)} |"


def in_words(place: str, found: Measured) -> str:
    """Say how often a cell's studies erred, and name what is outside the limits."""
    answered = found.studies - found.refused
    if not answered:
        return "refused"
    cautious: dict[str, Counts] = {}
    if place == "none":
        said = Counts(found.differed, answered)
        text = f"“differed” {said.share:.3f}"
        parts = [f"**{text}**" if said.outside(0.0, 0.08) else text]
        tests = {k: v for k, v in found.significant.items() if not TRUE_ANYWAY.search(k)}
        wrong = {k: v for k, v in tests.items() if v.outside(0.0, 0.08)}
        parts += [f"{len(tests)} tests"] if tests else []
    else:
        wrong = {k: v for k, v in found.covered.items() if v.outside(0.92, 1.0)}
        cautious = {k: v for k, v in found.covered.items() if v.outside(0.0, 0.98)}
        shares = [v.share for v in found.covered.values()]
        parts = ["no interval"]
        if shares:
            parts = [f"{len(shares)} intervals, lowest {min(shares):.3f}"]
            parts += [f"bias up to {max(map(abs, found.bias_sd.values()), default=0):.2f} SD"]
    parts += [f"**{name} {v.share:.3f}** ({v.of})" for name, v in wrong.items()]
    parts += [f"wide: {name} {v.share:.3f} ({v.of})" for name, v in cautious.items()]
    parts += [f"{found.refused} refused"] if found.refused else []
    return f"{found.studies}: {'; '.join(parts)}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="only protocols whose name begins so")
    parser.add_argument("--people", type=int, default=PEOPLE, help="simulated for each row")
    parser.add_argument("--jobs", type=int, default=1, help="number of processes")
    parser.add_argument("--write", action="store_true", help="put the table into the page")
    asked = parser.parse_args()
    if not asked.write:
        wanted = [name for name in KEYS if name.startswith(asked.only)]
        missing = [
            [cell for cell in (Cell(*each, n) for n in (6, 3, 12)) if kept(cell) is None]
            for each in product(sorted(wanted, key=SLOW.__contains__), PLACES)
        ]
        Parallel(n_jobs=asked.jobs)(
            delayed(measure)(cells, asked.people) for cells in missing if cells
        )
    else:
        every = (Cell(*each) for each in product(KEYS, PLACES, SIZES))
        cells = {cell: found for cell in every if (found := kept(cell))}
        day = f"{dt.datetime.now(dt.UTC):%Y-%m-%d}"
        head = f"Seed {SEED}, {day}. Each cell begins with its number of simulated studies."
        put("truths", [head, "", *rows(cells)])


if __name__ == "__main__":
    main()
