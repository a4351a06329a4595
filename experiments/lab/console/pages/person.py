"""A participant's page: runs, events, consent, exclusion and withdrawal."""

from __future__ import annotations

from pathlib import Path

from slipscale.experiments.dataset.hand_exclusions import RECORD, Decision, decisions
from slipscale.experiments.lab.blind_summary import summary
from slipscale.experiments.lab.console.pages.data import Row, curve_plots
from slipscale.experiments.lab.console.pages.view import View, titles_of
from slipscale.experiments.lab.curves import curves
from slipscale.faults import UserError


def person(view: View) -> dict[str, object]:
    """Return the values for a participant's page, or for their rehearsal page."""
    found, pilot = view.found, "pilot" in view.query
    roster = found.rehearsals if pilot else found.roster
    label = view.query.get("label", "")
    who = roster.person(label) if roster else None
    rows = [
        Row(label=label, visit=visit, summary=summary(visit.path))
        for visit in (who.visits if who else ())
    ]
    decided, fault = _decisions(found.defaults.out(pilot=pilot), label) if who else ((), "")
    job = view.jobs.last("session")
    return {
        "label": label,
        "pilot": pilot,
        "person": who,
        "rows": rows,
        "curves": curve_plots(
            curves(found.defaults.out(pilot=pilot), found.study.quantity, label), view
        )
        if who and found.study and (found.seen or pilot)
        else [],
        "titles": titles_of(found, view.t),
        "decisions": decided[::-1],
        "by_hand": bool(decided) and decided[-1].excluded,
        "fault": fault,
        "busy": bool(found.live or (job and job.running)),
    }


def _decisions(dataset: Path, label: str) -> tuple[tuple[Decision, ...], str]:
    """Return a participant's exclusion decisions, and the error if they cannot be read."""
    path = dataset / "sourcedata" / f"sub-{label}" / RECORD
    try:
        return (decisions(path) if path.exists() else ()), ""
    except UserError as error:
        return (), str(error)
