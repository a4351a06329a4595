"""The actions of ``slipscale study``: create, show and validate study files."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

import tomlkit

from slipscale.experiments.dataset.files import write_file
from slipscale.experiments.protocols.magnitude_estimation import MagnitudeEstimation
from slipscale.experiments.protocols.visual_analogue_scale import VisualAnalogueScale
from slipscale.experiments.running.balance import order_balance, task_balance
from slipscale.experiments.running.pilot import simulated_plate
from slipscale.experiments.running.rehearsal import check_supported, check_ways, dry_run
from slipscale.experiments.running.screen_check import check_screens
from slipscale.experiments.steps.steps import Present
from slipscale.experiments.study.file import parse_study, read_study, study_text
from slipscale.experiments.study.own_language import check_own_code, template, with_room_for
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.experiments.study.schema import study_schema
from slipscale.faults import UserError
from slipscale.faults.message import Message

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.experiments.steps.trial import Trial
    from slipscale.experiments.study.model import Study
    from slipscale.stimuli.surface import Stimulus, Surface

# A longer run would take days.
MOST_TRIALS = 10_000
# Balance is computed for the first runs with up to this number of trials, in about a second.
TRIALS_LOOKED_AT = 20_000
SCHEMA_FILE = "study.schema.json"


def new(
    path: Path, template: str, title: str, authors: tuple[str, ...] = (), licence: str = ""
) -> str:
    """Copy a shipped study to a new file for editing, and return a message.

    The title, authors and licence of the shipped study are not copied. The study name is derived
    from the file name.

    The schema is written next to the file, so that editors with support for TOML schemas (Even
    Better TOML, Taplo) can complete and check the file. An existing schema is replaced.
    """
    if path.exists():
        raise UserError("{path} already exists; name a new file", path=path)
    document = tomlkit.parse(study_text(template))
    document["name"] = _label(path.stem)
    document["title"] = title
    document["authors"] = list(authors)
    if licence:
        document["license"] = licence
    else:
        document.pop("license", None)
    began = f"# Based on the study '{template}', which is described as follows:\n"
    write_file(path, f"#:schema {SCHEMA_FILE}\n{began}{tomlkit.dumps(document)}")
    write_file(path.with_name(SCHEMA_FILE), schema())
    lacking = [*([] if authors else ["authors"]), *([] if licence else ["license"])]
    edit = f"enter its {' and '.join(lacking)} and edit it" if lacking else "edit it"
    return f"wrote {path}: {edit}, then run slipscale study validate {shlex.quote(str(path))}"


def _label(stem: str) -> str:
    """Convert a file name to a study name: letters, digits and _, starting with a letter.

    >>> _label("mon étude"), _label("2nd")
    ('mon_tude', 'study_2nd')
    """
    plain = re.sub(r"[^A-Za-z0-9]+", "_", stem).strip("_")
    return plain if re.match("[A-Za-z]", plain) else f"study_{plain}".rstrip("_")


def texts(name: str, language: str, path: Path) -> str:
    """Write a language file for a language that a study adds, and return a message.

    Raises
    ------
    UserError
        If the file already exists, or the language is shipped.
    """
    check_own_code(language)
    if path.exists():
        raise UserError("{path} already exists; name a new file", path=path)
    study = parse_study(with_room_for(study_text(name), name, language), name)
    write_file(path, template(study, language))
    return (
        f"wrote {path}: translate the texts, put the file next to the study file and name it "
        f'there: texts_files = ["{path.name}"] and language = "{language}"; then run '
        "slipscale study validate"
    )


def schema() -> str:
    """Return the JSON Schema of study files, with the options of every installed protocol."""
    return json.dumps(study_schema(), indent=2, ensure_ascii=False)


def validate(name: str) -> str:
    """Return a message if a study is valid; otherwise raise a `UserError` that lists all faults."""
    study, text = read_study(name)
    plan = _plan(name, study, text)
    check_ways(plan)
    check_supported(plan, simulated_plate(plan))
    check_screens(plan)
    textures = f", textures: {len(study.textures)}" if study.textures else ""
    line = (
        f"{name}: no faults (tasks: {len(study.tasks)}, {study.quantity.levels}: "
        f"{len(study.levels)}{textures})"
    )
    return "\n".join([line, *_textures(study), *balance(name, study, text)])


def _textures(study: Study) -> Iterator[str]:
    """Describe how well the plate and the air film reproduce each texture and each varied level."""
    surfaces: list[tuple[str, Surface]] = [
        (f"texture {each.name}", each) for each in study.texture_surfaces
    ]
    if varied := study.varied:
        surfaces += [
            (study.quantity.short(level), varied.turned(level).made) for level in study.levels
        ]
    for name, surface in surfaces:
        if followed := surface.followed():
            parts = f"the plate reproduces {followed.plate:.0%} of {followed.whole}"
            if study.plate_quantity.in_um_pp:  # only ultrasonic plates have an air film
                parts += f", friction from the film model {followed.friction:.0%}"
                if followed.rise_s:
                    parts += f" (10 to 90 % in {1000 * followed.rise_s:.3g} ms)"
            yield f"{name}: {followed.change}; {parts}"


def show(name: str, participant: str, session: str = "", run: str = "01") -> str:
    """Describe a study, and the order of surfaces for one participant.

    The description is intended for planning a study. It lists the amplitudes, so the operator of a
    session should not see it.

    Parameters
    ----------
    name : str
        A study file, or the name of a study that comes with Slipscale.
    participant, session, run : str
        The run to show; by default, the first planned session.
    """
    study, text = read_study(name)
    plan = replace(
        _plan(name, study, text),
        participant=participant,
        session=session or _sessions(study)[0],
        run=run,
    )
    q = study.quantity
    lines = [
        f"{study.name}: {study.title}",
        f"language {study.language}, seed {study.seed}, {study.participants} participants planned",
        f"{q.levels} {', '.join(f'{a:g}' for a in study.levels)} {q.unit_in_short}",
    ]
    if study.sessions or study.runs > 1:
        sessions = f"sessions {', '.join(study.sessions)}, " if study.sessions else ""
        lines.append(f"{sessions}{study.runs} runs per session; visits = {study.visits}")
    lines += [
        f"texture {each.name} ({each.label}, {study.plate_quantity.unit_in_short}): {each.summary}"
        for each in study.texture_surfaces
    ]
    for protocol, options in plan.tasks():
        lines += ["", f"{protocol.titled(q)} ({protocol.task})"]
        given = options.model_dump(mode="json", exclude_none=True, exclude={"protocol"})
        lines += [
            f"  {q.named(key)} = {tomlkit.item(value).as_string()}" for key, value in given.items()
        ]
    if balanced := balance(name, study, text):
        lines += ["", *balanced]
    which = f"session {plan.session}, " if plan.session else ""
    place = f"position {plan.row + 1} in the counterbalancing, visit {plan.visit + 1}"
    lines += [
        "",
        f"participant {participant}, {which}run {run}: {place}",
        f"surfaces of participant {participant}, {q.unit_in_short} (this list unblinds you)",
    ]
    if any(protocol.possible_levels for protocol, _ in plan.tasks()):
        lines.append("orders that depend on answers assume that the first option is always chosen")
    lines += [f"  {task:<22} {order}" for task, order in orders(plan).items()]
    return "\n".join(lines)


def orders(plan: RunPlan) -> dict[str, str]:
    """Return each task's surfaces in order of presentation, with practice trials in brackets.

    The surfaces of a trial's intervals are separated by slashes.
    """
    found: dict[str, dict[int, str]] = {}
    practice: set[tuple[str, int]] = set()
    for trial, surface in presented(plan):
        shown = found.setdefault(trial.task, {})
        before = f"{shown[trial.number]}/" if trial.number in shown else ""
        shown[trial.number] = f"{before}{_name(surface)}"
        if trial.phase == "practice":
            practice.add((trial.task, trial.number))
    return {
        task: " ".join(
            f"({each})" if (task, number) in practice else each for number, each in shown.items()
        )
        for task, shown in found.items()
    }


def balance(name: str, study: Study, text: str) -> list[str]:
    """Describe the balance of a study's orders across all participants, one sentence per line."""
    whole = _plan(name, study, text)
    every = (
        replace(whole, participant=f"{number:02d}", session=session, run=f"{run:02d}")
        for number in range(1, study.participants + 1)
        for session in _sessions(study)
        for run in range(1, study.runs + 1)
    )
    runs_in_all = study.participants * len(_sessions(study)) * study.runs
    plans = list(islice(every, max(TRIALS_LOOKED_AT // max(whole.planned_trials(), 1), 1)))
    lines: list[str] = []
    if len(plans) < runs_in_all:
        lines.append(
            Message(
                "the first {count} of {runs_in_all} runs:",
                count=len(plans),
                runs_in_all=runs_in_all,
            )
        )
    for protocol, options in plans[0].tasks():
        # Surface orders are balanced only in tasks with ratings of single surfaces.
        if isinstance(options, MagnitudeEstimation | VisualAnalogueScale):
            surfaces = [_name(surface) for surface in plans[0].context().surfaces]
            runs = [_main_blocks(plan, protocol.task) for plan in plans]
            balanced = order_balance(options, surfaces, runs)
            lines.append(Message("{task}, {balance}", task=protocol.task, balance=balanced))
    if study.task_order == "counterbalanced" and len(study.tasks) > 1:
        lines.append(task_balance(plan.tasks()[0][0].task for plan in plans))
    return lines


def orders_of_all(name: str) -> Figure:
    """Plot the order of surfaces in each participant's first run (at most `MOST` participants).

    The figure unblinds you.
    """
    from slipscale.experiments.running.orders_figure import MOST, orders_figure

    study, text = read_study(name)
    plan = _plan(name, study, text)
    labels = [f"{number:02d}" for number in range(1, min(study.participants, MOST) + 1)]
    people = [(label, presented(replace(plan, participant=label))) for label in labels]
    return orders_figure(people, study.quantity)


def presented(plan: RunPlan) -> list[tuple[Trial, Stimulus]]:
    """Return a run's trials in order, each with its surface."""
    steps = (step for step in dry_run(plan) if isinstance(step, Present))
    return [(step.trial, step.surface) for step in steps if step.trial]


def _main_blocks(plan: RunPlan, task: str) -> list[list[str]]:
    """Return a task's blocks of main trials, as lists of surface names."""
    found: dict[object, list[str]] = {}
    for trial, surface in presented(plan):
        if trial.task == task and trial.phase == "main" and not trial.factors.get("catch"):
            found.setdefault(trial.factors["block"], []).append(_name(surface))
    return list(found.values())


def _name(surface: Stimulus) -> str:
    return surface.name or f"{surface.level:g}"


def _sessions(study: Study) -> tuple[str, ...]:
    return study.sessions or ("",)


def _plan(name: str, study: Study, text: str) -> RunPlan:
    """Return the plan of the first participant's run.

    Raises
    ------
    UserError
        If the run has an implausibly large number of trials, probably because of a typing error.
    """
    plan = RunPlan(
        study_name=name,
        study_text=text,
        participant="01",
        session=_sessions(study)[0],
        seed=study.seed,
        language=study.language,
        mode="pilot",
    )
    if (trials := plan.planned_trials()) > MOST_TRIALS:
        raise UserError(
            "{name}: a run has {trials:,} trials; expected at most {most_trials:,}",
            name=name,
            trials=trials,
            most_trials=MOST_TRIALS,
        )
    return plan
