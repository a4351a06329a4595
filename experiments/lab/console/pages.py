"""What each page shows: from a snapshot to a template's values. No request, no file of the web."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from serial.tools.list_ports import comports

from slipscale.experiments.journal.plan_and_progress import is_mock
from slipscale.experiments.lab.blind_summary import RunSummary, summary
from slipscale.experiments.lab.console.actions import text_hash, why_not_edited
from slipscale.experiments.lab.console.history import deviations, history
from slipscale.experiments.lab.console.plots import scatter
from slipscale.experiments.lab.console.state import (
    RESULTS,
    changed_ns,
    findings,
    pilots,
    table3,
    usual_duration_s,
)
from slipscale.experiments.lab.folder import FILE, LabFile, lab_text, read_lab
from slipscale.experiments.languages.texts import languages
from slipscale.experiments.study.file import shipped_studies, study_text
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError
from slipscale.hardware.cli.ports import listing

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from slipscale.experiments.lab.console.jobs import Job, Jobs
    from slipscale.experiments.lab.console.page_texts import Words
    from slipscale.experiments.lab.console.state import Live, Snapshot
    from slipscale.experiments.lab.roster import Person, Visit

MOST_EVENTS = 30
MOST_NOTES = 20
MOST_REHEARSALS = 5
MOST_BARS = 24
LOW_GB = 1.0  # a run takes some megabytes; a disk that is nearly full fails elsewhere too
MOST_PEOPLE = 60  # in a table, unless all are asked for


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Note:
    """The operator's words in a run."""

    label: str
    visit: Visit
    time_s: float
    words: str


def today(found: Snapshot, jobs: Jobs, t: Words) -> dict[str, Any]:
    """Return what the page of the day shows."""
    check, people = jobs.last("check"), found.roster.people if found.roster else ()
    over = check is not None and not check.running
    results = findings(check.said()) if check and over else None
    return {
        "mock": is_mock(found.defaults.plate),
        "begun": sum(person.state != "withdrew" for person in people),
        "session_failed": _failure(jobs.last("session")),
        "between": _between(found, jobs.last("session")),
        "checking": bool(check and check.running),
        "steps": check.steps() if check else [],
        "found_checks": results,
        "check_failed": check.complained() if check and over and results is None else "",
        "ready": bool(results) and all(each["passed"] is not False for each in results or ()),
        "notes": _notes(found),
        "checked": _when_over(check),
        "began": _began(found, jobs.last("session")),
        "doing": _doing(found.live, t) if found.live else "",
        "pressing": _pressing(people),
        "most_rehearsals": MOST_REHEARSALS,
        "titles": _titles(found),
    }


def _between(found: Snapshot, job: Job | None) -> str:
    """Return whose session begins or ends: its process is there, its journal is not written."""
    return job.about if job and job.running and not found.live else ""


def _pressing(people: Sequence[Person]) -> list[Person]:
    """Return whom a long table shows: who waits for something, then who began last."""
    if len(people) <= MOST_PEOPLE:
        return list(people)

    def order(person: Person) -> tuple[bool, str]:
        last = person.last_begun
        return person.state not in ("done", "withdrew"), last.started_utc if last else ""

    shown = sorted(people, key=order, reverse=True)[:MOST_PEOPLE]
    return [person for person in people if person in shown]


def _notes(found: Snapshot) -> list[Note]:
    """Return the operators' newest notes, of rehearsals too."""
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


def live(found: Snapshot, jobs: Jobs, t: Words) -> dict[str, Any]:
    """Return what the page of the running session shows."""
    job = jobs.last("session")
    shown: dict[str, Any] = {"session_failed": _failure(job), "began": _began(found, job)}
    if found.live is None:
        return shown
    groups = deviations(found.live.summary.readings)
    status = found.live.status
    # A pause takes the surface away, and it is presented again: nothing is wrong with the plate.
    held = status is not None and status.state == "paused" and status.plate == "lost"
    return shown | {
        "plate": "silent" if held or status is None else status.plate,
        "doing": _doing(found.live, t),
        "since_s": _since_s(found.live.visit.started_utc),
        "events": found.live.summary.events[::-1][:MOST_EVENTS],
        "tolerance": round(100 * max(g.largest for g in groups)) if groups else None,
        "history": history(found.live.summary),
    }


def _doing(live: Live, t: Words) -> str:
    """Return what the participant does now, in words."""
    if live.status is None:
        return ""
    if live.status.state in ("paused", "fault", "done", "presenting"):
        return t(f"live.{live.status.state}")
    kind, _, name = live.summary.doing.partition(":")
    question = t.known(f"question.{name}", name.replace("_", " "))
    return t.known(f"live.{kind}", t(f"live.{live.status.state}")).format(name=question)


def _began(found: Snapshot, job: Job | None) -> bool:
    """Return whether a session that was started here came to record anything."""
    visits = (
        visit
        for roster in (found.roster, found.rehearsals)
        for person in (roster.people if roster else ())
        for visit in person.visits
        if visit.state != "free"
    )
    return job is not None and any(changed_ns(v.path) > job.began_s * 1e9 for v in visits)


def _when_over(job: Job | None) -> str:
    """Return when a job ended, in ISO 8601; empty while there is no such time."""
    if job is None or job.running:
        return ""
    return datetime.fromtimestamp(changed_ns(job.output) / 1e9, UTC).isoformat()


def _since_s(started_utc: str) -> float | None:
    """Return how long ago a run began, as the times of its events count."""
    if not started_utc:
        return None
    return (datetime.now(UTC) - datetime.fromisoformat(started_utc)).total_seconds()


def local_time(utc: str) -> str:
    """Return a time in ISO 8601 as this computer's clocks show it, to the minute.

    >>> local_time("")
    ''
    """
    return f"{datetime.fromisoformat(utc).astimezone():%Y-%m-%d %H:%M}" if utc else ""


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
        "most_people": MOST_PEOPLE,
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
            (plan.participant, plan.row + 1, [protocol.title for protocol, _ in plan.tasks()])
            for plan in plans
        ],
        "minutes": round(duration_s / 60) or 1 if duration_s else None,
    }


def _titles(found: Snapshot) -> dict[str, str]:
    """Return the titles of the study's tasks, by their labels."""
    if found.study is None:
        return {}
    return {protocol.task: protocol.title for protocol, _ in _plan(found, "01").tasks()}


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
    at_work = bool(analysis and analysis.running)
    figure = found.defaults.data / RESULTS / "fig15.svg"
    drawn = found.seen and figure.is_file()
    return {
        "rows": rows[-MOST_PEOPLE:],
        "all_rows": rows,
        "plot": scatter([row.summary.response_times_s for row in rows]),
        "durations": [
            (row.label, row.summary.duration_s / 60, row.summary.duration_s / longest)
            for row in whole[-MOST_BARS:]
        ],
        "table3": table3(found.defaults.data) if found.seen else [],
        "figure": figure.stat().st_mtime_ns if drawn else None,
        "rounded": _rounded,
        "analysing": at_work,
        "steps": analysis.steps() if analysis and at_work else [],
        "results_of": _date(found.results_ns),
        "reported": (found.defaults.data / RESULTS / "report.html").is_file(),
        "downloadable": found.defaults.data.is_dir(),
        "analysis_failed": _failure(analysis),
    }


def _date(when_ns: int | None) -> str:
    """Return when a file changed, in ISO 8601; empty if there is none."""
    return "" if when_ns is None else datetime.fromtimestamp(when_ns / 1e9, UTC).isoformat()


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
        "parts_asked": job.parts if job else 0,
        "parts_done": parts_done(found, jobs),
        "pilot_failed": _failure(job),
        "listed": [
            (folder.name, (folder / RESULTS / "report.html").is_file())
            for folder in pilots(found.defaults)
        ],
    }


def parts_done(found: Snapshot, jobs: Jobs) -> int:
    """Return how many simulated participants the pilot at work has come to."""
    job = jobs.last("pilot")
    if job is None or not job.running:
        return 0
    try:
        newest = pilots(found.defaults)[0]
        begun = newest.stat().st_mtime >= job.began_s - 1
        return sum(1 for _ in (newest / "sourcedata").glob("sub-*")) if begun else 0
    except (IndexError, OSError):
        return 0  # its folder is not there yet


def _failure(job: Job | None) -> str:
    """Return what a job that has ended complained of; nothing where it did what it should.

    A session that was stopped says so itself: that is no failure.
    """
    stopped = 130
    return job.complained() if job and job.status not in (None, 0, stopped) else ""


def strip(found: Snapshot, t: Words, lab: str) -> list[tuple[str, str, str]]:
    """Return what every page's first line shows: (what, its value, how it is)."""
    live, status = found.live, found.live.status if found.live else None
    session = t("strip.running", label=live.label) if live else t("strip.none")
    if live and status and status.state in ("paused", "fault"):
        session += f" · {t(f'live.{status.state}')}"
    low = found.free_gb is not None and found.free_gb < LOW_GB
    missing = found.without_backup
    backup = t("strip.no_backup") if missing is None else t("strip.backed_up")
    return [
        ("laboratory", lab, ""),
        ("study", found.study.title if found.study else found.defaults.study, ""),
        ("plate", found.defaults.plate, "warn" if is_mock(found.defaults.plate) else ""),
        ("session", session, "bad" if status and status.state == "fault" else ""),
        ("disk", t("strip.free", gb=found.free_gb) if found.free_gb else "–", "bad" * low),
        (
            "backup",
            t("strip.missing", count=missing) if missing else backup,
            "warn" * bool(missing),
        ),
    ]


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """A setting on its page: its input's type, its value, what is offered, what it means."""

    key: str
    kind: str
    value: object
    offered: tuple[str, ...]
    why: str


def settings(_: Snapshot, jobs: Jobs, __: Words) -> dict[str, Any]:
    """Return what the page of the settings shows: each key of slipscale.toml."""
    test = jobs.last("test")
    over = test is not None and not test.running
    text, fault = lab_text(Path()), ""
    try:
        lab = read_lab(Path()) or LabFile()
    except UserError as error:
        lab, fault = LabFile(), str(error)
    return {
        "there": bool(text),
        "before": text_hash(text),
        "fault": fault,
        "fields": [_field(key, getattr(lab, key)) for key in LabFile.model_fields],
        "testing": bool(test and test.running),
        "tested": findings(test.said()) if test and over else None,
        "test_failed": test.complained() if test and over and not findings(test.said()) else "",
    }


def _field(key: str, value: object) -> Field:
    kinds: dict[type, str] = {bool: "checkbox", int: "number"}
    offered: dict[str, Callable[[], list[str]]] = {
        "study": lambda: [*sorted(path.name for path in Path().glob("*.toml")), *shipped_studies()],
        "plate": lambda: ["mock", *(port["spec"] for port in listing((), comports)["ports"])],
        "language": languages,
    }
    return Field(
        key=key,
        kind=kinds.get(type(value), "text"),
        value=" ".join(value) if isinstance(value, tuple) else value,
        offered=tuple(name for name in offered.get(key, list)() if name != FILE),
        why=str(LabFile.model_fields[key].description),
    )


PAGES: dict[str, Callable[[Snapshot, Jobs, Words], dict[str, Any]]] = {
    "today": today,
    "live": live,
    "study": study,
    "data": data,
    "pilot": pilot,
    "settings": settings,
}
