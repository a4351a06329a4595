"""A run's steps as they would come: to be looked at before anybody sits down."""

from __future__ import annotations

from typing import TYPE_CHECKING

from experiments.dataset.schema import columns
from experiments.protocols.steps import Ask, EndBlock, EndTrial, Present, Reply, Voided
from faults import UserError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from experiments.protocols.steps import Answer, Step
    from experiments.study.run_plan import RunPlan
    from hardware.driver import PlateDriver
    from stimuli.surface import Surface


def dry_run(plan: RunPlan) -> Iterator[Step]:
    """Yield a run's steps as if every question were answered with "yes" and no trial voided.

    Raises
    ------
    UserError
        A protocol asks for an answer that its table has no column for, or its table has a
        column that every task has.
    """
    declared = {protocol.task: columns(protocol) for protocol, _ in plan.tasks()}
    steps = plan.steps()
    answer: Answer = None
    while True:
        try:
            step = steps.send(answer)
        except StopIteration:
            return
        if isinstance(step, Ask):
            task = step.trial.task if step.trial else step.task
            if task and step.name not in declared[task]:
                raise UserError(
                    f"protocol '{task}' asks for '{step.name}', which its table has no column "
                    "for: the answer would be missing from the data set; expected it to be declared"
                )
        yield step
        answer = Voided() if isinstance(step, EndTrial | EndBlock) else Reply(value=True)


def surfaces(plan: RunPlan) -> list[Surface]:
    """Return every surface that a run will present, standards and starts among them, once each.

    They are in the order of their labels, so that the order of presentation stays unknown.
    """
    found = {step.surface for step in dry_run(plan) if isinstance(step, Present)}
    return sorted(found, key=lambda surface: (surface.label, surface.amplitude_um_pp))


def check_supported(plan: RunPlan, plate: PlateDriver) -> None:
    """Raise `PlateDriver.check_supported`'s fault if the plate could not present a surface."""
    for surface in surfaces(plan):
        plate.check_supported(surface)
