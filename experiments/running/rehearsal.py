"""A run's steps as they would come: to be looked at before anybody sits down."""

from __future__ import annotations

from typing import TYPE_CHECKING

from experiments.protocols.steps import EndBlock, EndTrial, Present, Reply, Voided

if TYPE_CHECKING:
    from collections.abc import Iterator

    from experiments.protocols.steps import Answer, Step
    from experiments.study.run_plan import RunPlan
    from hardware.driver import PlateDriver
    from stimuli.surface import Surface


def rehearse(plan: RunPlan) -> Iterator[Step]:
    """Yield a run's steps as if every question were answered with "yes" and no trial voided."""
    steps = plan.steps()
    answer: Answer = None
    while True:
        try:
            step = steps.send(answer)
        except StopIteration:
            return
        yield step
        answer = Voided() if isinstance(step, EndTrial | EndBlock) else Reply(value=True)


def surfaces(plan: RunPlan) -> list[Surface]:
    """Return every surface that a run will present, standards and starts among them, once each.

    They are in the order of their labels: that of presentation is nobody's business yet.
    """
    found = {step.surface for step in rehearse(plan) if isinstance(step, Present)}
    return sorted(found, key=lambda surface: (surface.label, surface.amplitude_um_pp))


def admit(plan: RunPlan, plate: PlateDriver) -> None:
    """Raise what `PlateDriver.admit` raises if the plate could not present all of a run."""
    for surface in surfaces(plan):
        plate.admit(surface)
