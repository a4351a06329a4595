"""The data page and the pilots page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from slipscale.experiments.lab.blind_summary import RunSummary, summary
from slipscale.experiments.lab.console.jobs import Jobs, Kind
from slipscale.experiments.lab.console.pages.view import (
    MOST_PEOPLE,
    View,
    date_of,
    failure,
    titles_of,
    when_over,
)
from slipscale.experiments.lab.console.plots import CurvePlot, curve_plot, scatter
from slipscale.experiments.lab.console.state import (
    RESULTS,
    Snapshot,
    export_folder,
    findings,
    pilots,
    rows_of_table3,
)
from slipscale.experiments.lab.curves import Curve, curves
from slipscale.experiments.lab.roster import Visit
from slipscale.faults.folders import visible

MOST_BARS = 24


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A row in the table of runs."""

    label: str
    visit: Visit
    summary: RunSummary

    @property
    def median_s(self) -> float | None:
        """Median response time."""
        times = self.summary.response_times_s
        return median(times) if times else None


def data(view: View) -> dict[str, object]:
    """Return the values for the data page, including results only if they may be seen."""
    found, jobs = view.found, view.jobs
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
    chosen = chosen_rows(rows, view)
    at_work = bool(analysis and analysis.running)
    figure = found.defaults.data / RESULTS / "fig15.svg"
    drawn = found.seen and figure.is_file()
    return {
        "rows": chosen[:MOST_PEOPLE],
        "chosen": chosen,
        "counted": len(rows),
        "sorts": tuple(SORTS),
        "query": view.query,
        "states": sorted({row.visit.state for row in rows}),
        "curves": curve_plots(curves(found.defaults.data, found.study.quantity), view)
        if found.seen and found.study
        else [],
        "work": [_work(view, kind) for kind in WORK],
        "exported": export_folder(found.defaults.data).is_dir(),
        "plot": scatter([row.summary.response_times_s for row in rows]),
        "durations": [
            (row.label, row.summary.duration_s / 60, row.summary.duration_s / longest)
            for row in whole[-MOST_BARS:]
        ],
        "table3": rows_of_table3(found.defaults.data) if found.seen else [],
        "figure": figure.stat().st_mtime_ns if drawn else None,
        "rounded": _rounded,
        "analysing": at_work,
        "steps": analysis.steps() if analysis and at_work else [],
        "results_of": date_of(found.results_ns),
        "reported": reported(found.defaults.data),
        "downloadable": found.defaults.data.is_dir(),
        "analysis_failed": failure(analysis),
    }


SORTS: dict[str, Callable[[Row], Any]] = {
    "participant": lambda row: row.label,
    "run": lambda row: (row.visit.session, row.visit.run),
    "trials": lambda row: row.summary.trials,
    "flags": lambda row: sum(row.summary.flags.values()),
    "time": lambda row: row.median_s or 0.0,
    "minutes": lambda row: row.summary.duration_s,
    "state": lambda row: row.visit.state,
}
WORK: tuple[Kind, ...] = ("verify", "build", "export")


def chosen_rows(rows: list[Row], view: View) -> list[Row]:
    """Return the requested runs in the requested order (by default, newest first).

    ``search`` matches a run's label, flags and events; ``state`` matches its state.
    """
    words = view.query.get("search", "").casefold().split()
    state, sort = view.query.get("state", ""), view.query.get("sort", "")
    found = [
        row
        for row in rows[::-1]
        if state in ("", row.visit.state) and all(word in _told(row) for word in words)
    ]
    if sort in SORTS:
        found.sort(key=SORTS[sort], reverse=view.query.get("down") == "1")
    return found


def _told(row: Row) -> str:
    """Return the searchable text of a run."""
    events = " ".join(f"{event.kind} {event.words}" for event in row.summary.events)
    return f"{row.label} {' '.join(row.summary.flags)} {events}".casefold()


def _work(view: View, kind: Kind) -> dict[str, Any]:
    """Return the state, end time and problems of a job that processes the whole data set."""
    job = view.jobs.last(kind)
    over = job is not None and not job.running
    problems = findings(job.said()) if job and over else None
    stopped = failure(job) if not problems else ""
    state = "wrong" if problems or stopped else "good" if over else "running" if job else "never"
    return {
        "kind": kind,
        "state": state,
        "when": when_over(job),
        "problems": problems or (),
        "failed": stopped,
    }


def _rounded(value: str) -> str:
    """Round a table cell for display; return cells that are not numbers unchanged."""
    try:
        number = float(value)
    except ValueError:
        return value
    return f"{number:g}" if number == round(number, 2) else f"{number:.2f}"


def pilot(view: View) -> dict[str, Any]:
    """Return the values for the pilots page."""
    found, jobs = view.found, view.jobs
    job = jobs.last("pilot")
    return {
        "at_work": bool(job and job.running),
        "parts_asked": job.parts if job else 0,
        "parts_done": parts_done(found, jobs),
        "pilot_failed": failure(job),
        "listed": [
            (folder.name, reported(folder), _people(folder)) for folder in pilots(found.defaults)
        ],
        "rehearsals_reported": reported(found.defaults.out(pilot=True)),
    }


def reported(dataset: Path) -> bool:
    """Return whether a data set has a report."""
    return (dataset / RESULTS / "report.html").is_file()


def _people(dataset: Path) -> list[str]:
    """Return the labels of a pilot's simulated participants."""
    folders = visible(dataset / "sourcedata", "sub-*")
    return sorted(folder.name.removeprefix("sub-") for folder in folders)


def parts_done(found: Snapshot, jobs: Jobs) -> int:
    """Return the number of simulated participants that the running pilot has begun."""
    job = jobs.last("pilot")
    if job is None or not job.running:
        return 0
    try:
        newest = pilots(found.defaults)[0]
        begun = newest.stat().st_mtime >= job.began_s - 1
        return sum(1 for _ in visible(newest / "sourcedata", "sub-*")) if begun else 0
    except (IndexError, OSError):
        return 0  # the folder of the new pilot does not exist yet


def curve_plots(found: Sequence[Curve], view: View) -> list[CurvePlot]:
    """Draw the individual curves, with the same axes for all curves of a task."""
    titles = titles_of(view.found, view.t)
    by_task: dict[str, list[Curve]] = {}
    for curve in found:
        by_task.setdefault(curve.task, []).append(curve)
    return [
        curve_plot(curve, group, titles.get(task, task))
        for task, group in by_task.items()
        for curve in group
    ]
