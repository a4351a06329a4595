"""Simulated data without sessions: the tables that a pilot's journals give."""

import csv

import pytest

from slipscale.experiments.participants.simulated_people.habits import REALISTIC
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.bare_dataset import why_sessions, write_simulated
from slipscale.experiments.running.pilot import pilot_plans

#: The plate takes no time here, reads back what it was asked for, and has no temperature.
PLATE = ("readback", "voltage", "temperature")
STUDY = """
name = "small"
title = "A small study"
amplitudes_um_pp = [0.0, 1.2, 2.3]
participants = 6
sessions = ["01", "02"]
[[tasks]]
protocol = "descending_difference"
[[tasks]]
protocol = "magnitude_estimation"
scale_top = "declared"
response_time_limit_s = 3.0
[[about_you]]
name = "age"
minimum = 18
maximum = 90
prompt = { en = "How old are you?" }
"""
RESTLESS = Population(
    name="restless", habits=REALISTIC.model_copy(update={"lapses": 0.2, "dropout": 0.5})
)


def rows(folder):
    """Return all tables, but for what only a session has: times and measurements."""
    found = {}
    for path in sorted(set(folder.rglob("*.tsv")) - set(folder.rglob("*_events.tsv"))):
        with path.open(encoding="utf-8") as file:
            read = list(csv.DictReader(file, delimiter="\t"))
        found[path.relative_to(folder).as_posix()] = [
            {name: value for name, value in row.items() if not any(word in name for word in PLATE)}
            for row in read
        ]
    return found


@pytest.mark.parametrize("population", [Population(), RESTLESS], ids=["default", "restless"])
def test_its_tables_are_those_of_a_pilot(tmp_path, population):
    (tmp_path / "study.toml").write_text(STUDY)
    plans = pilot_plans(
        str(tmp_path / "study.toml"),
        participants=None,
        seed=3,
        language=None,
        population=population,
    )
    for name, sessions in (("bare", False), ("full", True)):
        write_simulated(tmp_path / name, plans, population, sessions=sessions)
    bare, full = rows(tmp_path / "bare"), rows(tmp_path / "full")
    assert bare == full
    # Somebody who gave up has no second session; the tables of everybody else are there.
    visits = {
        path for path in full if "ses-02" in path and path.endswith("estimation_run-01_beh.tsv")
    }
    assert len(visits) == 6 if population.habits.dropout == 0 else 0 < len(visits) < 6
    assert any(
        "timed_out" in row["flag"] for table in full.values() for row in table if "flag" in row
    )


@pytest.mark.parametrize(
    "study, why",
    [
        ("biet2007", ""),
        ("constant_stimuli", ""),
        ("textures_demo", "textures"),
        ("matching", "adjusted"),
    ],
)
def test_what_only_a_session_simulates_is_known(study, why):
    (plan, *_) = pilot_plans(study, participants=2, seed=None, language=None)
    assert why in why_sessions(plan)
    assert bool(why) == bool(why_sessions(plan))
