"""A data set of simulated people, without sessions: the protocols' own tables, in seconds.

Each run goes through the real generator and a simulated person without a session
(`slipscale.experiments.participants.simulated_people.bare_run`), and its table is the one that a
session's journal would give.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.experiments.dataset.rows_from_journal import gather
from slipscale.experiments.dataset.schema import columns, table_stem
from slipscale.experiments.dataset.tsv import cell, table
from slipscale.experiments.journal.record import Record
from slipscale.experiments.journal.serialisation import answer_record, step_record
from slipscale.experiments.participants.simulated_people.bare_run import bare_run
from slipscale.experiments.protocols.steps import (
    EndBlock,
    Explore,
    Feedback,
    Instruct,
    Rest,
    Silence,
)
from slipscale.experiments.study.run_plan import RunPlan

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from slipscale.experiments.participants.simulated_people.population import Population

#: Steps that the analysis reads nothing of.
UNREAD = (Instruct, Rest, Explore, Silence, EndBlock, Feedback)


def write_dataset(
    folder: Path, study_text: str, *, people: int, seed: int, population: Population
) -> None:
    """Write the tables of so many people's runs of a study, as `analysis.reading` reads them."""
    for number in range(1, people + 1):
        plan = RunPlan(
            study_name="simulated",
            study_text=study_text,
            participant=label(number),
            seed=seed,
            language="en",
            mode="pilot",
        )
        gathered = gather(list(_records(plan, population)))
        for protocol, _ in plan.tasks():
            described = columns(protocol, gathered.measured(protocol.task))
            rows = [
                [cell(column.value(trial)) for column in described.values()]
                for trial in gathered.trials[protocol.task]
            ]
            stem = table_stem(
                participant=plan.participant, session="", task=protocol.task, run=plan.run
            )
            path = folder / f"sub-{plan.participant}" / "beh" / f"{stem}.tsv"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(table(list(described), rows), encoding="utf-8")


def label(number: int) -> str:
    """Return the label of a participant, counted from 1."""
    return f"{number:05d}"


def _records(plan: RunPlan, population: Population) -> Iterator[Record]:
    """Yield what a session's journal would say of a run's steps."""
    for number, (step, answer, _) in enumerate(bare_run(plan, population)):
        if isinstance(step, UNREAD):
            continue
        for kind, data in (
            ("begin", {"step": number, "what": step_record(step)}),
            ("done", {"step": number, "answer": answer_record(answer)}),
        ):
            yield Record(number=number, time_s=0.0, kind=kind, data=data)
