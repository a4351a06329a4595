"""What each page shows: from a snapshot to a template's values. No request, no file of the web."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Any

from experiments.journal.run_record import is_mock
from experiments.lab.console.actions import text_hash, why_not_edited
from experiments.lab.console.plots import scatter
from experiments.lab.console.state import (
    RESULTS,
    findings,
    pilots,
    table3,
    usual_duration_s,
)
from experiments.lab.run_summary import RunSummary, summary
from experiments.session.terminal import clock_face
from experiments.study.file import study_text
from experiments.study.run_plan import RunPlan

if TYPE_CHECKING:
    from collections.abc import Callable

    from experiments.lab.console.jobs import Job, Jobs
    from experiments.lab.console.state import Live, Snapshot
    from experiments.lab.console.words import Words
    from experiments.lab.roster import Visit

MOST_EVENTS = 30
FEWEST_PRESENTATIONS = 8  # before the largest deviation is told: of few it could tell an amplitude


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A run in the table of runs."""

    label: str
    visit: Visit
    summary: RunSummary

    @property
    def median_s(self) -> float | None:
        """Median response time."""
        times = self.summary.response_times_s
        return median(times) if times else None


def today(found: Snapshot, jobs: Jobs, _: Words) -> dict[str, Any]:
    """Return what the page of the day shows."""
    check, people = jobs.last("check"), found.roster.people if found.roster else ()
    over = check is not None and not check.running
    results = findings(check.said()) if check and over else None
    return {
        "mock": is_mock(found.defaults.plate),
        "begun": sum(person.state != "withdrew" for person in people),
        "session_failed": _failure(jobs.last("session")),
        "checking": bool(check and check.running),
        "found_checks": results,
        "check_failed": check.complained() if check and over and results is None else "",
        "ready": bool(results) and all(each["passed"] is not False for each in results or ()),
    }


def live(found: Snapshot, jobs: Jobs, t: Words) -> dict[str, Any]:
    """Return what the page of the running session shows."""
    shown: dict[str, Any] = {"session_failed": _failure(jobs.last("session"))}
    if found.live is None:
        return shown
    used = found.live.summary.used_tolerance
    status = found.live.status
    # A pause takes the surface away, and it is presented again: nothing is wrong with the plate.
    held = status is not None and status.state == "paused" and status.plate == "lost"
    return shown | {
        "plate": "silent" if held or status is None else status.plate,
        "doing": _doing(found.live, t),
        "clock": clock_face,
        "events": found.live.summary.events[::-1][:MOST_EVENTS],
        "tolerance": round(100 * max(used)) if len(used) >= FEWEST_PRESENTATIONS else None,
    }


def _doing(live: Live, t: Words) -> str:
    """Return what the participant does now, in words."""
    if live.status is None:
        return ""
    if live.status.state in ("paused", "fault", "done", "presenting"):
        return t(f"live.{live.status.state}")
    kind, _, name = live.summary.doing.partition(":")
    return t.known(f"live.{kind}", t(f"live.{live.status.state}")).format(name=name)


def study(found: Snapshot, _: Jobs, __: Words) -> dict[str, Any]:
    """Return what the page of the study shows; the file's text, without its texts files' words."""
    text = study_text(found.defaults.study) if found.study else ""
    shown: dict[str, Any] = {
        "text": text,
        "before": text_hash(text),
        "not_edited": found.problem or why_not_edited(found),
        "timeline": [],
        "orders": [],
        "minutes": None,
    }
    if found.study is None:
        return shown
    plans = [_plan(found, f"{number:02d}") for number in range(1, found.study.participants + 1)]
    context = plans[0].context()
    duration_s = usual_duration_s(found.roster) if found.roster else None
    duration_s = duration_s or (usual_duration_s(found.rehearsals) if found.rehearsals else None)
    return shown | {
        "timeline": [
            (protocol.title, protocol.trials(options, context))
            for protocol, options in plans[0].tasks()
        ],
        "orders": [
            (plan.participant, plan.row + 1, [protocol.task for protocol, _ in plan.tasks()])
            for plan in plans
        ],
        "minutes": round(duration_s / 60) or 1 if duration_s else None,
    }


def _plan(found: Snapshot, participant: str) -> RunPlan:
    if found.study is None:
        raise LookupError("there is no study to plan with")
    return RunPlan(
        study_name=found.defaults.study,
        study_text=found.study_text,
        participant=participant,
        session=(*found.study.sessions, "")[0],
        seed=found.study.seed,
        language=found.defaults.language or found.study.language,
        mode="participant",
    )


def data(found: Snapshot, jobs: Jobs, _: Words) -> dict[str, Any]:
    """Return what the page of the data shows: results only where they may be seen."""
    people = found.roster.people if found.roster else ()
    rows = [
        Row(label=person.label, visit=visit, summary=summary(visit.path))
        for person in people
        for visit in person.visits
        if visit.state != "free"
    ]
    whole = [row for row in rows if row.visit.state == "complete"]
    longest = max((row.summary.duration_s for row in whole), default=0.0) or 1.0
    analysis = jobs.last("analysis")
    figure = found.defaults.data / RESULTS / "fig15.svg"
    drawn = found.seen and figure.is_file()
    return {
        "rows": rows,
        "plot": scatter([row.summary.response_times_s for row in rows]),
        "durations": [
            (row.label, row.summary.duration_s / 60, row.summary.duration_s / longest)
            for row in whole
        ],
        "table3": table3(found.defaults.data) if found.seen else [],
        "figure": figure.stat().st_mtime_ns if drawn else None,
        "rounded": _rounded,
        "analysing": bool(analysis and analysis.running),
        "analysis_failed": _failure(analysis),
    }


def _rounded(value: str) -> str:
    """Return a number of a table as it is read; anything else as it is."""
    try:
        number = float(value)
    except ValueError:
        return value
    return f"{number:g}" if number == round(number, 2) else f"{number:.2f}"


def pilot(found: Snapshot, jobs: Jobs, _: Words) -> dict[str, Any]:
    """Return what the page of the pilots shows."""
    job = jobs.last("pilot")
    return {
        "at_work": bool(job and job.running),
        "pilot_failed": _failure(job),
        "listed": [
            (folder.name, (folder / RESULTS / "report.html").is_file())
            for folder in pilots(found.defaults)
        ],
    }


def _failure(job: Job | None) -> str:
    """Return what a job that has ended complained of; nothing where it did what it should.

    A session that was stopped says so itself: that is no failure.
    """
    stopped = 130
    return job.complained() if job and job.status not in (None, 0, stopped) else ""


PAGES: dict[str, Callable[[Snapshot, Jobs, Words], dict[str, Any]]] = {
    "today": today,
    "live": live,
    "study": study,
    "data": data,
    "pilot": pilot,
}
