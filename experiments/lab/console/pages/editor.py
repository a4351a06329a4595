"""The study editor: a form for editing a study's text, and results computed from the text."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from typing import Any

from slipscale.experiments.lab.console.pages.view import MOST_PEOPLE, View, plan_of
from slipscale.experiments.lab.console.plots import Drawing, drawing
from slipscale.experiments.lab.console.study_form import StudyForm
from slipscale.experiments.running.study_commands import balance
from slipscale.experiments.running.timeline import Timeline, timeline
from slipscale.experiments.study.file import file_names, parse_whole, shipped_studies
from slipscale.experiments.study.levels import Levels
from slipscale.experiments.study.tables import Texture
from slipscale.faults import UserError
from slipscale.faults.validation import Complaint, Told
from slipscale.stimuli.surface import Surface

SIMULATED = 4  # simulated participants; enough to estimate durations to tenths of a minute


def editor(view: View, text: str, template: str) -> dict[str, Any]:
    """Return the editor contents that are available immediately: form, errors, tasks and trials."""
    source = _source(view, template)
    faults: tuple[Told, ...] = ()
    study, whole = None, text
    try:
        study, whole = parse_whole(text, source)
    except Complaint as error:
        faults = error.faults
    except UserError as error:
        faults = (Told(0, (), str(error), str(error)),)
    try:
        content = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError):
        return {"told": faults, "form": None, "edited": None, "timeline": []}
    shown: dict[str, object] = {
        "told": faults,
        "form": StudyForm(content, faults),
        "drawings": _drawings(tomllib.loads(whole)),  # text with the images of friction maps
        "edited": study,
        "timeline": [],
    }
    if study:
        plan = plan_of(replace(view.found, study=study, study_text=whole), "01")
        context = plan.context()
        shown["timeline"] = [
            (view.t.task(options, protocol, study), protocol.trials(options, context))
            for protocol, options in plan.tasks()
        ]
    return shown


def _source(view: View, template: str) -> str:
    """Return the study file's name, for messages and for finding its language files."""
    return template if template in shipped_studies() else view.found.defaults.study


def follow_up(view: View, text: str, template: str) -> dict[str, object]:
    """Return the results that take longer to compute: duration, cost, orders and their balance."""
    source = _source(view, template)
    try:
        study, whole = parse_whole(text, source)
    except UserError:
        return {"edited": None}
    found = replace(view.found, study=study, study_text=whole)
    shown = MOST_PEOPLE if "all" not in view.query else study.participants
    plans = [plan_of(found, f"{n:02d}") for n in range(1, min(study.participants, shown) + 1)]
    return {
        "edited": study,
        # Nothing is simulated during a session, because the session's frames have priority.
        "minutes": None if view.found.live else simulated_minutes(whole, source),
        "orders": [
            (plan.participant, plan.row + 1, [view.t.task(o, p, study) for p, o in plan.tasks()])
            for plan in plans
        ],
        "balance": balance(source, study, whole),
        "most_people": MOST_PEOPLE,
    }


@lru_cache(maxsize=32)
def simulated_minutes(whole: str, source: str) -> Timeline | None:
    """Return the duration in minutes and the cost; None if a task cannot be simulated."""
    try:
        return timeline(source, people=SIMULATED, text=whole)
    except UserError:
        return None


def _drawings(content: Mapping[str, object]) -> dict[str, list[Drawing]]:
    """Return drawings of all valid surfaces in the study file, keyed by their position."""
    names = file_names(dict(content))
    in_code = names.to_code(dict(content))
    made: dict[str, list[tuple[Surface, str]]] = {"levels": []}
    with suppress(ValueError, UserError):
        levels = Levels.stated(in_code)
        made["levels"] = [
            (surface.made, names.quantity.short(each))
            for each in _listed(in_code.get("levels"))
            if (surface := levels.surface(each)) is not None
        ]
    for number, table in enumerate(_listed(in_code.get("textures"))):
        with suppress(ValueError):
            texture = Texture.model_validate(table).surface()
            made[json.dumps(["textures", number])] = [(texture, texture.caption)]
    largest = max([surface.level for each in made.values() for surface, _ in each], default=0.0)
    return {
        place: [drawing(surface, largest or 1.0, label) for surface, label in each]
        for place, each in made.items()
    }


def _listed(value: object) -> list[Any]:
    return value if isinstance(value, list) else []
