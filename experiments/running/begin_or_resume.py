"""Carry out a planned run from the point at which its journal ends."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.experiments.journal.header import header, resume_data
from slipscale.experiments.running.contact_sources import NamedSource, describe_contact
from slipscale.experiments.session.interruptions import UNBLINDED
from slipscale.experiments.session.parts import Setup
from slipscale.experiments.session.session import RunOutcome, Session
from slipscale.experiments.session.sound.masking_noise import NoNoise
from slipscale.faults import UserError
from slipscale.hardware.address import PAIR, is_mock
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.backends.pair import PlatePair, pair_of
from slipscale.hardware.registry import open_plate

if TYPE_CHECKING:
    from slipscale.experiments.steps.steps import Steps
    from slipscale.experiments.study.run_plan import RunPlan
    from slipscale.hardware.clock import Clock
    from slipscale.hardware.contact.source import Kind
    from slipscale.hardware.driver import PlateDriver
    from slipscale.stimuli.quantity import Quantity


def plate_for(plan: RunPlan, spec: str, clock: Clock) -> PlateDriver:
    """Return the plate for a SPEC, with the study's tolerance; the plate is not yet connected.

    For a study with a second actuator, ``mock`` is a pair of simulated plates.
    """
    wanted, second = plan.study.plate, plan.study.second_plate
    paired = spec.startswith(PAIR)
    if paired and not second:
        raise UserError(
            "plate '{spec}': the study '{study_name}' has no [second_plate]; expected the SPEC "
            "of one plate",
            spec=spec,
            study_name=plan.study.name,
        )
    if second and not paired and not is_mock(spec):
        raise UserError(
            "plate '{spec}': the study '{study_name}' has a [second_plate]; expected --plate "
            "pair:FIRST+SECOND",
            spec=spec,
            study_name=plan.study.name,
        )
    specs = pair_of(spec) if paired else (spec, "mock")
    first = _opened(plan, specs[0], clock, plan.study.plate_quantity, wanted.level)
    first.limits = first.limits.held_to(
        tolerance=wanted.tolerance, deviation_level=wanted.tolerance_level
    )
    if not second:
        return first
    return PlatePair(first, _opened(plan, specs[1], clock, second.quantity.quantity, second.level))


def _opened(
    plan: RunPlan, spec: str, clock: Clock, quantity: Quantity, largest_level: float
) -> PlateDriver:
    """Return the plate for a SPEC; raise `UserError` if its quantity is not the study's."""
    driver = open_plate(spec, clock=clock, seed=plan.seed)
    if isinstance(driver, MockPlate) and driver.plate_file is None:
        driver.adopt(quantity, largest_level)
    if (made := driver.limits.quantity).makes != quantity.makes:
        raise UserError(
            "plate '{spec}' makes {made_name} in {unit_in_full}, but the study's levels are "
            "{quantity_name} in {quantity_unit_in_full}; expected a plate file and a study with "
            "the same [quantity]",
            spec=spec,
            made_name=made.name,
            unit_in_full=made.unit_in_full,
            quantity_name=quantity.name,
            quantity_unit_in_full=quantity.unit_in_full,
        )
    return driver


def run_plan(
    plan: RunPlan,
    setup: Setup,
    *,
    spec: str,
    sources: Mapping[Kind, NamedSource] | None = None,
    backup: Path | None = None,
    steps: Steps | None = None,
) -> RunOutcome:
    """Carry out a plan from the point at which the journal ends to the end of the run.

    Parameters
    ----------
    plan : RunPlan
    setup : Setup
        The objects with which the session interacts. The header of a new journal is written by this
        function.
    spec : str
        The plate's SPEC, for the journal.
    sources : Mapping, optional
        Connected finger-position and force sources.
    backup : Path, optional
        Folder to which the journal is copied at the end.
    steps : generator, optional
        Steps to carry out, such as a generator that modifies the plan's steps (default: the plan's
        steps).
    """
    journal, plate = setup.journal, setup.plate
    contact = describe_contact(sources or {}, plate)
    masking = "absent" if isinstance(setup.noise, NoNoise) else "on"
    if not journal.records:
        kind = setup.participant.kind
        journal.write("header", **header(plan, plate, spec, kind, masking), **contact)
    else:
        journal.write("resume", **resume_data(plan, plate, spec, masking), **contact)
    if setup.unblind:
        journal.write("note", text=UNBLINDED)
    if backup:
        journal.write("backup", folder=str(backup.resolve()))
    if setup.markers.names:
        journal.write("markers", outputs=list(setup.markers.names))
    session = Session(
        steps=steps or plan.steps(),
        setup=setup,
        texts=plan.texts(),
        planned=plan.planned_trials(),
        sources={kind: each.source for kind, each in (sources or {}).items()},
        stroke=plan.study.stroke,
    )
    return session.run()
