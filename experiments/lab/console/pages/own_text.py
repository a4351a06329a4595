"""The form in which one text of a study is changed in each language, with a live preview."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from slipscale.experiments.lab.console.actions.folder import why_not_edited
from slipscale.experiments.lab.console.actions.own_text import with_texts
from slipscale.experiments.lab.console.pages.view import View
from slipscale.experiments.languages.screen_room import Room, room_of
from slipscale.experiments.languages.texts import blanks
from slipscale.experiments.study.file import parse_whole, study_text
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnText:
    """A text of the study to be changed.

    Parameters
    ----------
    texts : Mapping
        The text by language, as typed or as the study has it.
    placeholders : tuple of str
        Names that the text may contain in braces.
    study_text : str
        The study's text with what was typed; empty if that is invalid.
    fault : str
        Why the typed texts are invalid; empty if they are valid.
    why_not : str
        Why the study cannot be changed here; empty if it can.
    """

    key: str
    texts: Mapping[str, str]
    placeholders: tuple[str, ...]
    room: Room
    study_text: str
    fault: str
    why_not: str


def own_text(view: View, plans: Mapping[str, RunPlan]) -> OwnText | None:
    """Return the text whose key is in the query; None without a known key."""
    key, found = view.query.get("key", ""), view.found
    now = {language: plan.texts().get(key) for language, plan in plans.items()}
    if not plans or any(text is None for text in now.values()):
        return None
    typed = {language: view.query.get(language, "") for language in plans}
    whole, fault = found.study_text, ""
    if new := {language: text for language, text in typed.items() if text.strip()}:
        try:
            edited = with_texts(study_text(found.defaults.study), key, new)
            whole = parse_whole(edited, found.defaults.study)[1]
        except UserError as error:
            whole, fault = "", str(error)
    known = blanks(next(iter(now.values())) or "") or set()
    return OwnText(
        key=key,
        texts={language: typed[language] or (now[language] or "") for language in plans},
        placeholders=tuple(sorted(known)),
        room=room_of(key),
        study_text=whole,
        fault=fault,
        why_not=why_not_edited(found),
    )


def edited_plan(plan: RunPlan, own: OwnText) -> RunPlan:
    """Return a plan with the typed texts."""
    return replace(plan, study_text=own.study_text)
