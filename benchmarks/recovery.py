"""Measure bias and coverage of the analysis (docs/validation/measured/statistics.md).

Each case simulates one protocol with one rule. People answer the protocol's own trials without a
plate or a session; the resulting tables are read and analysed by `analyse`'s functions. Finished
cases are cached in build/recovery.

    OMP_NUM_THREADS=1 nice -n 19 .venv/bin/python -m benchmarks.recovery [--runs 400] [--write]
"""

from __future__ import annotations

import argparse
import datetime as dt
import json
import tempfile
from dataclasses import asdict
from pathlib import Path

from benchmarks.measured_page import put
from benchmarks.recovery_measures import (
    PEOPLE,
    SEED,
    STANDARD_UM_PP,
    Case,
    Row,
    label,
    measure_matching,
    measure_scales,
    measure_thresholds,
)
from slipscale.analysis.load import load
from slipscale.experiments.participants.simulated_people.habits import Habits
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.bare_dataset import write_simulated
from slipscale.experiments.study.run_plan import RunPlan

ROOT = Path(__file__).resolve().parents[1]
KEPT = ROOT / "build" / "recovery"
#: People with 2 % lapses, as in the shipped population `realistic`, and with so much noise that
#: their thresholds are well above the resolution of simulated fingers (0.01 µm).
OBSERVERS = Population(name="recovery", noise=5.0, habits=Habits(lapses=0.02))
#: The default noise, for which the shipped studies of paired comparison and matching are designed.
SHARPER = OBSERVERS.model_copy(update={"noise": 2.2})

STUDY = """
name = "simulated"
title = "Simulated"
language = "en"
seed = 1
participants = 8
amplitudes_um_pp = [{amplitudes}]
[plate]
tolerance = 0.01
tolerance_um_pp = 0.015
[[tasks]]
"""
DIFFERENCE = """protocol = "difference_threshold"
standard_um_pp = 1.2
start_um_pp = 0.4
lowest_um_pp = 0.02
highest_um_pp = 0.8
practice = 0
"""
DETECTION = """protocol = "detection_threshold"
start_um_pp = 0.6
lowest_um_pp = 0.02
highest_um_pp = 1.2
practice = 0
"""
#: 60 trials in total, as in the shipped studies.
TWO_TRACKS = "steps_up = [0.2, 0.1]\ntracks = 2\nmost_trials = 30\n"
RULES = {
    **{
        f"staircase, {k}-down-1-up": f'rule = "staircase"\ndown_after = {k}\n{TWO_TRACKS}'
        for k in (1, 2, 3, 4)
    },
    "weighted, 75 %": f'rule = "weighted"\n{TWO_TRACKS}',
    "QUEST+": 'rule = "quest_plus"\ntracks = 1\nmost_trials = 60\n',
    "QUEST+, 240 trials": 'rule = "quest_plus"\ntracks = 1\nmost_trials = 240\n',
    "staircase, 2-down-1-up, 240 trials": 'rule = "staircase"\ndown_after = 2\n'
    "steps_up = [0.2, 0.1]\ntracks = 2\nmost_trials = 120\n",
}
#: Protocols whose rules are rows of one table per number of intervals.
ADAPTIVE = ("difference threshold", "detection threshold")
CONSTANT = """protocol = "constant_stimuli"
standard_um_pp = 1.2
comparisons_um_pp = [{levels}]
question = "{question}"
repetitions = {repetitions}
practice = 0
"""


def cases() -> list[Case]:
    """Return the studies to simulate: one for each protocol and rule."""
    plain = STUDY.format(amplitudes="1.2")
    found = [
        Case(
            f"{name}, {rule}, {intervals} intervals",
            f"{plain}{protocol}intervals = {intervals}\n{text}",
            OBSERVERS,
            1,
            measure_thresholds,
            intervals,
            standard,
        )
        for name, protocol, standard in (
            ("difference threshold", DIFFERENCE, STANDARD_UM_PP),
            ("detection threshold", DETECTION, 0.0),
        )
        for intervals in (2, 3)
        for rule, text in RULES.items()
        if intervals == 2 or "240" not in rule
    ]
    one_side, both = "1.23, 1.26, 1.32, 1.4, 1.6", "0.95, 1.05, 1.15, 1.25, 1.35, 1.45"
    for title, levels, question, repetitions in (
        ("one side, forced choice", one_side, "forced_choice", 20),
        ("both sides, forced choice", both, "forced_choice", 16),
        ("both sides, yes or no", both, "yes_no", 16),
    ):
        task = CONSTANT.format(levels=levels, question=question, repetitions=repetitions)
        found.append(
            Case(f"constant stimuli, {title}", plain + task, OBSERVERS, 1, measure_thresholds)
        )
    five = STUDY.format(amplitudes="1.0, 1.06, 1.12, 1.18, 1.24")
    for form in ("pairs", "triads"):
        task = f'protocol = "paired_comparison"\nform = "{form}"\nrepetitions = 2\npractice = 0\n'
        found.append(
            Case(f"paired comparison, {form}", five + task, SHARPER, PEOPLE, measure_scales)
        )
    task = 'protocol = "matching"\npractice = 0\n'
    found.append(Case("matching", plain + task, SHARPER, PEOPLE, measure_matching))
    return found


def measured(case: Case, runs: int) -> list[Row]:
    """Simulate a case and return its rows."""
    with tempfile.TemporaryDirectory() as folder:
        plans = [
            RunPlan(
                study_name="simulated",
                study_text=case.study,
                participant=label(number),
                seed=SEED,
                language="en",
                mode="pilot",
            )
            for number in range(1, runs * case.each + 1)
        ]
        write_simulated(Path(folder), plans, case.people, sessions=False)
        return case.measure(load(folder), case, runs)


def _path(case: Case, runs: int) -> Path:
    name = "".join(letter if letter.isalnum() else "-" for letter in case.title)
    return KEPT / f"{name}_{runs}.json"


def _kept(case: Case, runs: int) -> list[Row]:
    """Return a case's rows from the cache; measure them first if they are missing."""
    path = _path(case, runs)
    if not path.exists():
        rows = measured(case, runs)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps([asdict(each) for each in rows]), encoding="utf-8")
    return [Row(**each) for each in json.loads(path.read_text(encoding="utf-8"))]


def table_of(title: str, cases: dict[str, list[Row]]) -> list[str]:
    """Return a table of bias and coverage, with one row per case and one column per quantity."""
    heads = [each.what for each in next(iter(cases.values())) if each.coverage is not None]
    return [
        f"| {' | '.join([title, *heads])} |",
        "| --- |" + " --- |" * len(heads),
        *(f"| {name} | {' | '.join(_cells(rows))} |" for name, rows in cases.items()),
    ]


def _cells(rows: list[Row]) -> list[str]:
    """Format the bias and coverage of each quantity, such as "+0.014 µm; 0.912"."""
    return [
        f"{row.bias:+.3f}{'' if row.unit == 'decades' else f' {row.unit}'}; {row.coverage:.3f}"
        for row in rows
        if row.coverage is not None
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=400)
    parser.add_argument("--only", default="", help=("only cases whose title begins with this text"))
    parser.add_argument(
        "--write", action="store_true", help="put all measured tables into the page"
    )
    asked = parser.parse_args()
    for case in cases():
        if case.title.startswith(asked.only):
            print("\n".join(table_of("", {case.title: _kept(case, asked.runs)})), flush=True)
    if asked.write:
        put("recovery", _tables(asked.runs))


def _tables(runs: int) -> list[str]:
    """Return the lines of the page: results, and cases not yet measured."""
    there = [case for case in cases() if _path(case, runs).exists()]
    # A table contains cases of one protocol for which the same quantities were measured.
    tables: dict[tuple[str, ...], dict[str, list[Row]]] = {}
    for case in there:
        protocol, _, rule = case.title.partition(", ")
        if protocol in ADAPTIVE:
            rule, _, intervals = rule.rpartition(", ")
            protocol = f"{protocol}, {intervals}"
        rows = _kept(case, runs)
        key = (protocol, *(each.what for each in rows))
        tables.setdefault(key, {})[rule or protocol] = rows
    day = f"{dt.datetime.now(dt.UTC):%Y-%m-%d}"
    lines = [f"Each case was simulated in {runs} runs (seed {SEED}, {day})."]
    for (title, *_), rules in tables.items():
        lines += ["", *table_of(title, rules)]
    if missing := [case.title for case in cases() if case not in there]:
        lines += ["", f"Not measured yet: {'; '.join(missing)}."]
    return lines


if __name__ == "__main__":
    main()
