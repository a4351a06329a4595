"""The page of the study: its tasks, its orders, its file."""

from __future__ import annotations

from typing import Any

from slipscale.experiments.lab.console.actions import text_hash, why_not_edited
from slipscale.experiments.lab.console.pages.view import MOST_PEOPLE, View, plan_of
from slipscale.experiments.lab.console.state import usual_duration_s
from slipscale.experiments.study.file import study_text


def study(view: View) -> dict[str, Any]:
    """Return what the page of the study shows; the file's text, without its texts files' words."""
    found = view.found
    text = study_text(found.defaults.study) if found.study else ""
    shown: dict[str, Any] = {
        "text": text,
        "before": text_hash(text),
        "not_edited": found.problem or why_not_edited(found),
        "timeline": [],
        "orders": [],
        "minutes": None,
        "most_people": MOST_PEOPLE,
    }
    if found.study is None:
        return shown
    plans = [plan_of(found, f"{number:02d}") for number in range(1, found.study.participants + 1)]
    context = plans[0].context()
    duration_s = usual_duration_s(found.roster) if found.roster else None
    duration_s = duration_s or (usual_duration_s(found.rehearsals) if found.rehearsals else None)
    return shown | {
        "timeline": [
            (protocol.title, protocol.trials(options, context))
            for protocol, options in plans[0].tasks()
        ],
        "orders": [
            (plan.participant, plan.row + 1, [protocol.title for protocol, _ in plan.tasks()])
            for plan in plans
        ],
        "minutes": round(duration_s / 60) or 1 if duration_s else None,
    }
