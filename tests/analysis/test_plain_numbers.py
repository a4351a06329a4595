"""Printed numbers of every kind of task, recomputed from the tables with the formulas of textbooks.

No package computes the expected values: rows are read with ``csv``, and standard deviations divide
by n - 1. Each kind is crossed with the forms that data take: groups, a factor, sessions, runs, a
missing cell, one participant, ties, zeros and several tasks of the same kind.
"""

from collections import defaultdict
from typing import Any

import pytest

from slipscale.analysis import json_form
from slipscale.analysis.pipeline import analyse
from tests.support.plain.results import ESTIMATES, KINDS, estimated
from tests.support.plain.tables import (
    VARIATIONS,
    answered,
    factor,
    missing_cell,
    one_participant,
    several_tasks,
    simulate,
    tables_of,
    ties,
    write,
)


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """Return a function that returns the folder of a protocol, simulated once."""
    made = {}

    def of(protocol):
        if protocol not in made:
            made[protocol] = simulate(protocol, tmp_path_factory.mktemp(protocol))
        return made[protocol]

    return of


def of_task(found, name):
    """Return the results of a task; the descending difference has only one."""
    return [found] if isinstance(found, dict) else [each for each in found if each["task"] == name]


#: Thresholds take 5 to 20 s per data set: only quick ones are crossed with variations.
QUICK = {"constant_stimuli": (missing_cell, ties), "oddity": (one_participant,)}
CROSSED = [
    pytest.param(protocol, each, id=f"{protocol}-{each.__name__}")
    for protocol, kind in KINDS.items()
    for each in (QUICK.get(protocol, ()) if kind.key == "thresholds" else VARIATIONS)
]


@pytest.mark.parametrize("protocol,variation", CROSSED)
def test_numbers_are_those_of_plain_formulas(simulated, tmp_path, protocol, variation):
    kind, source = KINDS[protocol], simulated(protocol)
    tables = variation(list(tables_of(source)), kind)
    groups = variation is several_tasks or protocol == "visual_analogue_scale"
    folder = write(tmp_path / "data", source, tables, groups, variation is factor)
    results: Any = json_form.form(analyse(folder).inference.results)
    tasks = defaultdict(list)
    for table in tables:
        for row in answered(table.rows, kind.answer):
            # Thresholds in the conditions of a factor are fitted in one model of the task.
            apart = variation is factor and kind.key != "thresholds"
            hand = f"_hand-{row['hand']}" if apart else ""
            place = f"{table.session} {table.run}"
            tasks[table.task + hand].append((table.who, row | {"place": place}))
    if isinstance(results[kind.key], dict) and protocol != "descending_difference":
        pytest.fail(f"{results[kind.key]}")
    for name, rows in tasks.items():
        if name != "descendingdifference" and protocol == "descending_difference":
            continue  # only one label of this kind is analysed
        found = of_task(results[kind.key], name)
        assert found
        for each in found:
            kind.check(each, rows)


@pytest.mark.parametrize("variation", VARIATIONS[:-1], ids=lambda each: each.__name__)
def test_magnitude_estimates_are_those_of_plain_formulas(simulated, tmp_path, variation):
    source = simulated("magnitude_estimation")
    tables = variation(list(tables_of(source)), ESTIMATES)
    folder = write(tmp_path / "data", source, tables, False, variation is factor)
    found = analyse(folder, normalise="none")
    rows = [(table.who, row) for table in tables for row in answered(table.rows, ESTIMATES.answer)]
    estimated(json_form.form(found.inference.results), found, rows)
