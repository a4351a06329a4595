"""Performing a run: a plan, a plate, a participant and a journal, from its end to the run's."""

from __future__ import annotations

from typing import TYPE_CHECKING

from experiments.journal.header import header, resume_data
from experiments.session.session import Session

if TYPE_CHECKING:
    from experiments.journal.journal import Journal
    from experiments.participants.base import Participant
    from experiments.session.markers import Markers
    from experiments.session.masking import Noise
    from experiments.session.operator import Operator
    from experiments.session.session import RunOutcome
    from experiments.study.run_plan import RunPlan
    from hardware.clock import Clock
    from hardware.driver import PlateDriver


def run_plan(
    plan: RunPlan,
    *,
    spec: str,
    plate: PlateDriver,
    participant: Participant,
    journal: Journal,
    clock: Clock,
    operator: Operator,
    noise: Noise | None = None,
    markers: Markers | None = None,
    unblind: bool = False,
) -> RunOutcome:
    """Run a plan from the journal's end to the run's.

    Parameters
    ----------
    plate : PlateDriver
        Connected.
    journal : Journal
        New (it gets its header here) or reopened.
    """
    masking = "on" if noise else "absent"
    if not journal.records:
        journal.write("header", **header(plan, plate, spec, participant.kind, masking))
    else:
        journal.write("resume", **resume_data(plate, spec, masking))
    if markers and markers.names:
        journal.write("markers", outputs=list(markers.names))
    session = Session(
        steps=plan.steps(),
        plate=plate,
        participant=participant,
        journal=journal,
        clock=clock,
        operator=operator,
        texts=plan.texts(),
        planned=plan.planned_trials(),
        noise=noise,
        markers=markers,
        unblind=unblind,
    )
    return session.run()
