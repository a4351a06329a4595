"""Write the tables of a simulated study without running sessions.

Planning uses this module to simulate a study hundreds of times. The simulated participants give the
same answers as in a pilot, and the same code creates the tables, but no journals are written.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.files import write_file
from slipscale.experiments.dataset.journals import Run
from slipscale.experiments.dataset.rendering import render
from slipscale.experiments.dataset.rows_from_journal import gather
from slipscale.experiments.journal.header import header
from slipscale.experiments.journal.record import Record
from slipscale.experiments.journal.serialisation import answer_record, step_record
from slipscale.experiments.participants.simulated_people.bare_run import bare_run, drops_out
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.begin_or_resume import plate_for
from slipscale.experiments.running.pilot import MOCK, run_simulated
from slipscale.experiments.running.rehearsal import dry_run
from slipscale.experiments.steps.replies import Answer, Reply
from slipscale.experiments.steps.steps import Adjust, Instruct
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.hardware.clock import VirtualClock

#: Features that only full sessions can simulate, with a test whether a run has the feature.
NEED_SESSIONS: dict[str, Callable[[RunPlan], bool]] = {
    "textures depend on the finger position": lambda plan: bool(plan.study.textures),
    "the plate file specifies finger sensors": lambda plan: bool(plan.study.plate.file),
    "the finger is measured": lambda plan: bool(
        plan.study.plate.position or plan.study.plate.force
    ),
    "amplitudes are adjusted on the plate": lambda plan: any(
        isinstance(step, Adjust) for step in dry_run(plan)
    ),
}


def why_sessions(plan: RunPlan) -> str:
    """Return the reason why a study requires full sessions; empty if it does not."""
    return next((why for why, has in NEED_SESSIONS.items() if has(plan)), "")


def write_simulated(
    folder: Path, plans: Sequence[RunPlan], population: Population, *, sessions: bool
) -> None:
    """Simulate a study and write its tables.

    Parameters
    ----------
    folder : Path
        A new folder.
    plans : sequence of RunPlan
        Plans of a pilot; see `slipscale.experiments.running.pilot.pilot_plans`.
    population : Population
    sessions : bool
        Whether to simulate full sessions on the mock plate.

    Raises
    ------
    UserError
        If the folder cannot be written.
    """
    if sessions:
        for plan in plans:
            run_simulated(folder, plan, MOCK)
        build_dataset(folder)
        return
    # Participants who drop out do not return for later sessions.
    attended = [plan for plan in plans if not (plan.visit and drops_out(plan, population))]
    files, problems = render([_run(folder, plan, population) for plan in attended])
    if problems:
        raise ValueError(str(problems[0]))
    for name, content in files.items():
        write_file(folder / name, content)


def _run(folder: Path, plan: RunPlan, population: Population) -> Run:
    """Return a simulated run in the same format as a run read from a journal."""
    plate = plate_for(plan, MOCK, VirtualClock())
    records = [
        Record(
            number=0,
            time_s=0.0,
            kind="header",
            data=header(plan, plate, MOCK, "simulated", "absent"),
        )
    ]
    now_s = 0.0

    def note(kind: str, **data: object) -> None:
        records.append(Record(number=len(records), time_s=now_s, kind=kind, data=data))

    last = None
    for last, answer, duration_s in bare_run(plan, population):
        note("begin", what=step_record(last))
        now_s += duration_s
        note("done", answer=answer_record(_as_in_a_session(answer)))
    # The closing text follows the last answer, so a run without it was abandoned.
    note("end" if isinstance(last, Instruct) and last.last else "stop")
    return Run(
        path=plan.journal_path(folder),
        plan=plan,
        records=records,
        damage=(),
        gathered=gather(records),
    )


def _as_in_a_session(answer: Answer) -> Answer:
    """Convert a simulated answer to the format in which sessions record answers."""
    if not isinstance(answer, Reply):
        return answer
    time_s = None if answer.timed_out else answer.response_time_s
    return replace(answer, response_time_s=time_s, time_source="simulated")
