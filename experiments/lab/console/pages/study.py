"""The study page: tasks, orders and the study file."""

from __future__ import annotations

import tomllib
from difflib import unified_diff
from functools import cache
from typing import NamedTuple

from slipscale.experiments.journal.plan_and_progress import read_usable
from slipscale.experiments.lab.console.actions.folder import why_not_edited
from slipscale.experiments.lab.console.actions.forms import text_hash
from slipscale.experiments.lab.console.pages.editor import editor
from slipscale.experiments.lab.console.pages.view import View
from slipscale.experiments.lab.console.state import Snapshot, usual_duration_s
from slipscale.experiments.study.file import shipped_studies, study_text
from slipscale.faults import UserError

CONTEXT = 2  # lines of context around each change
KINDS = {"+": "now", "-": "before", "@": "gap"}


class Line(NamedTuple):
    """A line of the diff between an earlier study file and the current one."""

    kind: str
    words: str


def study(view: View) -> dict[str, object]:
    """Return the values for the study page, which does not show the contents of language files."""
    found = view.found
    template = view.query.get("from", "")
    template = template if template in shipped_studies() else ""
    text = _text(found, template)
    duration_s = usual_duration_s(found.roster) if found.roster else None
    duration_s = duration_s or (usual_duration_s(found.rehearsals) if found.rehearsals else None)
    used, compared = _compared(found) if found.study else ("", [])
    return {
        "text": text,
        "before": text_hash(text),
        "not_edited": "" if template else why_not_edited(found) if text else found.problem,
        "template": template,
        "templates": shipped_studies(),
        "titles": _titles(),
        "used": used,
        "compared": compared,
        "took_minutes": round(duration_s / 60) or 1 if duration_s else None,
        **editor(view, text, template),
    }


@cache
def _titles() -> list[tuple[str, str]]:
    """Return the names and titles of all shipped studies."""
    texts = {name: tomllib.loads(study_text(name)) for name in shipped_studies()}
    return [(name, str(text["title"])) for name, text in texts.items()]


def _text(found: Snapshot, template: str) -> str:
    """Return the study text to edit; empty if the folder has no settings or no study file."""
    if not template and found.defaults.file is None:
        return ""
    try:
        return study_text(template or found.defaults.study)
    except UserError:
        return ""


def _compared(found: Snapshot) -> tuple[str, list[Line]]:
    """Return the participant of the study's last run, and how the study has changed since then."""
    begun = [
        (visit.started_utc, person.label, visit)
        for person in (found.roster.people if found.roster else ())
        for visit in person.visits
        if visit.started_utc
    ]
    for _, label, visit in sorted(begun, key=lambda each: each[0], reverse=True):
        plan, _ = read_usable(visit.path, most=1)
        if plan is None or found.study is None or plan.study.name != found.study.name:
            continue
        before, now = plan.study_text.splitlines(), found.study_text.splitlines()
        lines = list(unified_diff(before, now, n=CONTEXT, lineterm=""))[2:]
        return label, [Line(KINDS.get(line[0], "same"), line[1:]) for line in lines]
    return "", []
