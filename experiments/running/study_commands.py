"""What ``slipscale study`` does: write a study file to begin with, show one, validate one."""

from __future__ import annotations

import json
import shlex
from typing import TYPE_CHECKING

from experiments.dataset.bids import write_file
from experiments.protocols.steps import Present
from experiments.running.dry_run import dry_run
from experiments.study.file import read_study, study_text
from experiments.study.run_plan import RunPlan
from experiments.study.schema import study_schema
from faults import UserError
from stimuli.texture import Grating

if TYPE_CHECKING:
    from pathlib import Path

SCHEMA_FILE = "study.schema.json"


def new(path: Path, template: str) -> str:
    """Write a shipped study to a new file, to be edited; return what to say.

    The schema is written beside it, and the file's first line names it: an editor that knows TOML
    schemas (Even Better TOML, Taplo) completes and checks the file. A schema that is there already
    is replaced: it holds nothing of the user's.
    """
    if path.exists():
        raise UserError(f"{path} exists already; name a new file")
    write_file(path, f"#:schema {SCHEMA_FILE}\n{study_text(template)}")
    write_file(path.with_name(SCHEMA_FILE), schema())
    return f"wrote {path}: edit it, then slipscale study validate {shlex.quote(str(path))}"


def schema() -> str:
    """Return the JSON Schema of study files, with the options of every installed protocol."""
    return json.dumps(study_schema(), indent=2, ensure_ascii=False)


def validate(name: str) -> str:
    """Return what to say of a study without fault; UserError tells every fault."""
    study, _ = read_study(name)
    textures = f", {len(study.textures)} textures" if study.textures else ""
    return (
        f"{name}: no fault ({len(study.tasks)} tasks, {len(study.amplitudes_um_pp)} amplitudes"
        f"{textures})"
    )


def show(name: str, participant: str) -> str:
    """Return what a study does, and the order in which a participant will have the surfaces.

    This unblinds whoever reads it: it is for planning, not for the operator of a session.
    """
    study, text = read_study(name)
    plan = RunPlan(
        study_name=name,
        study_text=text,
        participant=participant,
        seed=study.seed,
        language=study.language,
        mode="pilot",
    )
    lines = [
        f"{study.name}: {study.title}",
        f"language {study.language}, seed {study.seed}, {study.participants} participants planned",
        f"amplitudes {', '.join(f'{a:g}' for a in study.amplitudes_um_pp)} µm p-p",
    ]
    lines += [
        f"texture {grating.name} ({grating.label}): {grating.waveform}, "
        f"{grating.lowest_um_pp:g} to {grating.amplitude_um_pp:g} µm p-p, "
        f"period {grating.spatial_period_mm:g} mm, "
        f"for a finger at {grating.finger_speed_mm_s:g} mm/s"
        for grating in study.gratings
    ]
    for protocol, options in plan.tasks():
        lines += ["", f"{protocol.title} ({protocol.task})"]
        lines += [f"  {key} = {value}" for key, value in options if key != "protocol"]
    lines += ["", f"surfaces of participant {participant}, µm p-p (unblinds you)"]
    lines += [f"  {task:<22} {order}" for task, order in orders(plan).items()]
    return "\n".join(lines)


def orders(plan: RunPlan) -> dict[str, str]:
    """Return each task's surfaces in order of presentation, practice in brackets."""
    found: dict[str, list[str]] = {}
    for step in dry_run(plan):
        if isinstance(step, Present) and step.trial:
            surface = step.surface
            what = surface.name if isinstance(surface, Grating) else f"{surface.amplitude_um_pp:g}"
            word = f"({what})" if step.trial.phase == "practice" else what
            found.setdefault(step.trial.task, []).append(word)
    return {task: " ".join(order) for task, order in found.items()}
