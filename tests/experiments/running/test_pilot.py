"""A pilot's journal: the same records however it is written, on disk at once where faults are."""

import os

import pytest

from slipscale.experiments.journal.plan_and_progress import last_plate, read_plan
from slipscale.experiments.running.pilot import pilot_plans, run_pilot, run_simulated
from tests.support.board_sessions import STUDY
from tools.campaigns.torture.pilots import content


@pytest.fixture
def syncs(monkeypatch):
    """Return the list that grows at each wait for the disk."""
    found = []
    monkeypatch.setattr(os, "fsync", lambda _descriptor: found.append(1))
    return found


@pytest.mark.parametrize(
    "spec, each_record", [("mock", False), ("mock:fault=time_out@present/2", True)]
)
def test_a_pilot_waits_for_the_disk_once_a_run_unless_faults_are_tried(
    tmp_path, syncs, spec, each_record
):
    (plan,) = pilot_plans("biet2007", participants=1, seed=1, language="en")
    run_simulated(tmp_path, plan, spec)
    barriers = sum("kept" in each.data for each in read_plan(plan.journal_path(tmp_path))[1])
    assert len(syncs) >= barriers > 20 if each_record else len(syncs) == 1


def test_a_pilot_s_records_are_those_of_a_journal_that_waits_for_the_disk(tmp_path, laboratory):
    (plan,) = pilot_plans("biet2007", participants=1, seed=1, language="en")
    run_simulated(tmp_path / "pilot", plan, "mock")
    laboratory.run(plan)
    here, there = (
        [(r.time_s, r.kind, r.data) for r in read_plan(plan.journal_path(folder))[1][1:]]
        for folder in (tmp_path / "pilot", laboratory.folder)
    )
    assert here == there


def test_a_pilot_whose_plate_missed_its_amplitude_by_chance_is_gone_on_with_anywhere(
    tmp_path, places
):
    """A surface is made again at the time of the try that succeeded, not of one that failed."""
    study = tmp_path / "narrow.toml"
    narrow = "[plate]\ntolerance = 0.001\ntolerance_um_pp = 0.01\n\n[[tasks]]"
    text = STUDY.replace("repetitions = 1", "repetitions = 4")
    study.write_text(text.replace("[[tasks]]", narrow, 1))
    (plan,) = pilot_plans(str(study), participants=1, seed=10, language="en")
    whole, scatters = tmp_path / "whole", "mock:noise=0.005"
    run_simulated(whole, plan, scatters, synced=False)
    expected = content(whole)
    lines = plan.journal_path(whole).read_bytes().splitlines(keepends=True)
    kinds = [record.kind for record in read_plan(plan.journal_path(whole))[1]]
    assert "retry" in kinds
    for kept in places(lines):
        if kinds[kept - 1] in ("fault", "retry"):  # the try that failed is not made again
            continue
        path = plan.journal_path(tmp_path / f"cut{kept}")
        path.parent.mkdir(parents=True)
        path.write_bytes(b"".join(lines[:kept]))
        run_simulated(tmp_path / f"cut{kept}", plan, scatters, synced=False)
        assert content(tmp_path / f"cut{kept}") == expected, f"cut after {kinds[kept - 1]} {kept}"


def test_the_mock_s_own_scatter_is_no_fault_of_a_plate_that_must_be_held_narrowly(tmp_path):
    """One reading in some hundred would lie beyond: trials are repeated, and a pilot may end."""
    plans = pilot_plans("matching", participants=2, seed=7, language=None)
    run_pilot(tmp_path, plans, tell=lambda _: None)
    for plan in plans:
        kinds = {record.kind for record in read_plan(plan.journal_path(tmp_path))[1]}
        assert "end" in kinds
        assert "fault" not in kinds


def test_a_mock_that_was_asked_for_scatters_as_asked(tmp_path):
    (plan,) = pilot_plans("matching", participants=1, seed=7, language=None)
    run_pilot(tmp_path, [plan], spec="mock:noise=0.004", tell=lambda _: None)
    assert last_plate(read_plan(plan.journal_path(tmp_path))[1]) == "mock:noise=0.004"
