"""Journals recorded before orders had a version are replayed and gone on with as they were."""

from pathlib import Path

import pytest

from slipscale.experiments.dataset.rows_from_journal import gather
from slipscale.experiments.journal.run_record import is_complete, read_plan
from slipscale.experiments.protocols.base import ORDER_VERSION
from slipscale.experiments.running.pilot import run_pilot
from slipscale.experiments.running.study_commands import orders, presented

OLD = Path(__file__).parents[2] / "data" / "order_version_1"


def told(records):
    """Return what was asked about which surface, and what was answered."""
    trials = [trial for each in gather(records).trials.values() for trial in each]
    return [
        (t.trial.task, t.trial.number, t.surface, {k: a["value"] for k, a in t.answers.items()})
        for t in trials
    ]


@pytest.mark.parametrize("rule", ["simple", "blocked", "williams"])
def test_an_old_journals_plan_gives_the_order_that_it_recorded(rule):
    plan, records = read_plan(OLD / f"{rule}.jsonl")
    assert plan.order_version == 1
    recorded = [(task, number, surface) for task, number, surface, _ in told(records)]
    drawn = [(trial.task, trial.number, surface) for trial, surface in presented(plan)]
    assert sorted(drawn, key=str) == sorted(recorded, key=str)
    assert len(drawn) == 15


@pytest.mark.parametrize("rule", ["simple", "blocked", "williams"])
def test_an_old_run_that_was_interrupted_ends_as_it_would_have(laboratory, rule):
    plan, records = read_plan(OLD / f"{rule}.jsonl")
    path = plan.journal_path(laboratory.folder)
    path.parent.mkdir(parents=True)
    lines = (OLD / f"{rule}.jsonl").read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[: len(lines) // 2]))
    assert laboratory.run(plan) == "complete"
    ended = told(laboratory.records(plan))
    assert [trial[:3] for trial in ended] == [trial[:3] for trial in told(records)]
    # Who answers since is another: the simulated people of today.
    begun = [trial for trial, before in zip(ended, told(records), strict=True) if trial == before]
    assert len(begun) > len(ended) // 3


def test_a_pilot_begun_with_an_old_rule_ends_with_it(tmp_path, plan):
    old = plan(order_version=1)
    run_pilot(tmp_path, [old], tell=lambda _: None)
    path = old.journal_path(tmp_path)
    path.write_bytes(b"".join(path.read_bytes().splitlines(keepends=True)[:20]))
    run_pilot(tmp_path, [plan(), plan(participant="02")], tell=lambda _: None)
    for participant in ("01", "02"):
        found, records = read_plan(plan(participant=participant).journal_path(tmp_path))
        assert found.order_version == 1
        assert is_complete(records)


def test_a_new_journal_names_the_version_of_its_orders(laboratory, plan):
    laboratory.run()
    (header,) = laboratory.records(kind="header")
    assert header.data["order_version"] == ORDER_VERSION
    assert orders(plan()) != orders(plan(order_version=1))
