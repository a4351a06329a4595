"""The Today page and the page for the running session."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from slipscale.experiments.lab.blind_summary import summary
from slipscale.experiments.lab.console.jobs import Job
from slipscale.experiments.lab.console.page_texts import Words
from slipscale.experiments.lab.console.pages.history import deviations, history
from slipscale.experiments.lab.console.pages.view import (
    MOST_PEOPLE,
    View,
    failure,
    titles_of,
    when_over,
)
from slipscale.experiments.lab.console.state import Live, Snapshot, changed_ns, findings
from slipscale.experiments.lab.roster import Person, Visit
from slipscale.hardware.address import is_mock

MOST_EVENTS = 30
MOST_NOTES = 20
MOST_REHEARSALS = 5
MOST_RESUMED = 3  # buttons beside the next participant; the table has all


@dataclass(frozen=True, slots=True, kw_only=True)
class Note:
    """An operator's note on a run."""

    label: str
    visit: Visit
    time_s: float
    words: str


def today(view: View) -> dict[str, object]:
    """Return the values for the Today page."""
    found, jobs, t = view.found, view.jobs, view.t
    check, people = jobs.last("check"), found.roster.people if found.roster else ()
    over = check is not None and not check.running
    results = findings(check.said()) if check and over else None
    return {
        "mock": is_mock(found.defaults.plate),
        "exclusions": ", ".join(
            t.known(f"flag.{flag}", flag)
            for flag in (found.roster.exclusions if found.roster else ())
        ),
        "begun": sum(person.state != "withdrew" for person in people),
        "session_failed": failure(jobs.last("session")),
        "between": _between(found, jobs.last("session")),
        "checking": bool(check and check.running),
        "steps": check.steps() if check else [],
        "found_checks": results,
        "check_failed": check.complained() if check and over and results is None else "",
        "ready": bool(results) and all(each["passed"] is not False for each in results or ()),
        "notes": _notes(found),
        "checked": when_over(check),
        "began": _began(found, jobs.last("session")),
        "doing": _doing(found.live, t) if found.live else "",
        "pressing": _pressing(people),
        "interrupted": _interrupted(found),
        "most_rehearsals": MOST_REHEARSALS,
        "titles": titles_of(found, t),
    }


def _between(found: Snapshot, job: Job | None) -> str:
    """Return the participant whose session is starting or ending; empty if there is none."""
    return job.about if job and job.running and not found.live else ""


def _interrupted(found: Snapshot) -> list[tuple[str, Visit, bool]]:
    """Return what can be resumed, the last first: participant, run, and whether it is a rehearsal.

    On a simulated plate, only rehearsals are resumed.
    """
    rosters = [(found.rehearsals, True)]
    if not is_mock(found.defaults.plate):
        rosters.append((found.roster, False))
    runs = [
        (person.label, visit, rehearsed)
        for roster, rehearsed in rosters
        for person in (roster.people if roster else ())
        for visit in person.visits
        if visit.state == "interrupted"
    ]
    return sorted(runs, key=lambda run: run[1].started_utc, reverse=True)[:MOST_RESUMED]


def _pressing(people: Sequence[Person]) -> list[Person]:
    """Return the participants to show; if there are many, prefer pending and recent ones."""
    if len(people) <= MOST_PEOPLE:
        return list(people)

    def order(person: Person) -> tuple[bool, str]:
        last = person.last_begun
        return person.state not in ("done", "withdrew"), last.started_utc if last else ""

    shown = sorted(people, key=order, reverse=True)[:MOST_PEOPLE]
    return [person for person in people if person in shown]


def _notes(found: Snapshot) -> list[Note]:
    """Return the operators' notes from the most recent runs, including rehearsals."""
    rosters = [roster for roster in (found.roster, found.rehearsals) if roster]
    begun = [
        (visit.started_utc, person.label, visit)
        for roster in rosters
        for person in roster.people
        for visit in person.visits
        if visit.state != "free"
    ]
    newest = sorted(begun, key=lambda each: each[0], reverse=True)[:MOST_NOTES]
    notes = [
        Note(label=label, visit=visit, time_s=event.time_s, words=event.words)
        for _, label, visit in newest
        for event in reversed(summary(visit.path).events)
        if event.kind == "note"
    ]
    return notes[:MOST_NOTES]


def live(view: View) -> dict[str, object]:
    """Return the values for the page of the running session."""
    found, jobs, t = view.found, view.jobs, view.t
    job = jobs.last("session")
    shown: dict[str, object] = {"session_failed": failure(job), "began": _began(found, job)}
    if found.live is None:
        return shown
    groups = deviations(found.live.summary.readings)
    status = found.live.status
    # A pause removes the surface and later presents it again, which is not a plate fault.
    held = status is not None and status.state == "paused" and status.plate == "lost"
    return shown | {
        "plate": "silent" if held or status is None else status.plate,
        "doing": _doing(found.live, t),
        "since_s": _since_s(found.live.visit.started_utc),
        "events": found.live.summary.events[::-1][:MOST_EVENTS],
        "tolerance": round(100 * max(g.largest for g in groups)) if groups else None,
        "history": history(found.live.summary),
        "task": titles_of(found, t).get(status.task, status.task) if status else "",
    }


def _doing(live: Live, t: Words) -> str:
    """Describe what the participant is doing now."""
    if live.status is None:
        return ""
    if live.status.state in ("paused", "fault", "done", "presenting"):
        return t(f"live.{live.status.state}")
    kind, _, name = live.summary.doing.partition(":")
    question = t.known(f"question.{name}", name.replace("_", " "))
    return t.known(f"live.{kind}", t(f"live.{live.status.state}")).format(name=question)


def _began(found: Snapshot, job: Job | None) -> bool:
    """Return whether anything has been recorded since this console started the session."""
    visits = (
        visit
        for roster in (found.roster, found.rehearsals)
        for person in (roster.people if roster else ())
        for visit in person.visits
        if visit.state != "free"
    )
    return job is not None and any(changed_ns(v.path) > job.began_s * 1e9 for v in visits)


def _since_s(started_utc: str) -> float | None:
    """Return the time since the start of a run, in s; None if there is no start time."""
    if not started_utc:
        return None
    return (datetime.now(UTC) - datetime.fromisoformat(started_utc)).total_seconds()
