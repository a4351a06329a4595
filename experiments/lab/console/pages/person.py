"""A participant's page: runs, events, consent, exclusion and withdrawal.

For rehearsals and simulated pilots, the page also shows all answers.
"""

from __future__ import annotations

from pathlib import Path

from slipscale.experiments.dataset.hand_exclusions import RECORD, Decision, decisions
from slipscale.experiments.lab.answers import answered_trials
from slipscale.experiments.lab.blind_summary import summary
from slipscale.experiments.lab.console.pages.data import Row, curve_plots, reported
from slipscale.experiments.lab.console.pages.view import View, failure, titles_of
from slipscale.experiments.lab.console.state import pilots
from slipscale.experiments.lab.curves import curves
from slipscale.experiments.lab.defaults import REHEARSALS
from slipscale.experiments.lab.roster import Roster, read_roster
from slipscale.faults import UserError


def person(view: View) -> dict[str, object]:
    """Return the values for a participant's page, or for that of a rehearsal or a pilot.

    The query's ``pilot`` is the name of a pilot's folder; any other value stands for rehearsals.
    """
    found, pilot = view.found, "pilot" in view.query
    dataset, roster = _of_pilot(view) if pilot else (found.defaults.data, found.roster)
    label = view.query.get("label", "")
    who = roster.person(label) if roster else None
    visits = who.visits if who else ()
    rows = [Row(label=label, visit=visit, summary=summary(visit.path)) for visit in visits]
    decided, fault = _decisions(dataset, label) if who else ((), "")
    job, analysis = view.jobs.last("session"), view.jobs.last("rehearsals")
    quantity = found.study.quantity if found.study else None
    return {
        "label": label,
        "pilot": pilot,
        "folder": dataset.name,
        "simulated": pilot and dataset.name != REHEARSALS,
        "person": who,
        "rows": rows,
        "curves": curve_plots(curves(dataset, quantity, label), view)
        if who and quantity and (found.seen or pilot)
        else [],
        "answered": [
            (visit, trials)
            for visit in visits
            if pilot and quantity and (trials := answered_trials(visit.path, quantity))
        ],
        "reported": pilot and reported(dataset),
        "analysing": bool(analysis and analysis.running),
        "analysis_failed": failure(analysis),
        "titles": titles_of(found, view.t),
        "decisions": decided[::-1],
        "by_hand": bool(decided) and decided[-1].excluded,
        "fault": fault,
        "busy": bool(found.live or (job and job.running)),
    }


def _of_pilot(view: View) -> tuple[Path, Roster | None]:
    """Return the folder and the participants of the pilot in the query, or of the rehearsals."""
    found = view.found
    for folder in pilots(found.defaults):
        if folder.name == view.query["pilot"] and found.study:
            return folder, read_roster(folder, found.study, found.study_text)
    return found.defaults.out(pilot=True), found.rehearsals


def _decisions(dataset: Path, label: str) -> tuple[tuple[Decision, ...], str]:
    """Return a participant's exclusion decisions, and the error if they cannot be read."""
    path = dataset / "sourcedata" / f"sub-{label}" / RECORD
    try:
        return (decisions(path) if path.exists() else ()), ""
    except UserError as error:
        return (), str(error)
