"""The pages "Data" and "Pilots"."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Any

from slipscale.experiments.lab.blind_summary import RunSummary, summary
from slipscale.experiments.lab.console.pages.view import MOST_PEOPLE, View, date_of, failure
from slipscale.experiments.lab.console.plots import scatter
from slipscale.experiments.lab.console.state import RESULTS, pilots, table3

if TYPE_CHECKING:
    from slipscale.experiments.lab.console.jobs import Jobs
    from slipscale.experiments.lab.console.state import Snapshot
    from slipscale.experiments.lab.roster import Visit

MOST_BARS = 24


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One run in the table of runs."""

    label: str
    visit: Visit
    summary: RunSummary

    @property
    def median_s(self) -> float | None:
        """Median response time."""
        times = self.summary.response_times_s
        return median(times) if times else None


def data(view: View) -> dict[str, Any]:
    """Return the values of the data page; results only if they may be seen."""
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
        "results_of": date_of(found.results_ns),
        "reported": (found.defaults.data / RESULTS / "report.html").is_file(),
        "downloadable": found.defaults.data.is_dir(),
        "analysis_failed": failure(analysis),
    }


def _rounded(value: str) -> str:
    """Round a number in a table for display; return other values unchanged."""
    try:
        number = float(value)
    except ValueError:
        return value
    return f"{number:g}" if number == round(number, 2) else f"{number:.2f}"


def pilot(view: View) -> dict[str, Any]:
    """Return the values of the pilots page."""
    found, jobs = view.found, view.jobs
    job = jobs.last("pilot")
    return {
        "at_work": bool(job and job.running),
        "parts_asked": job.parts if job else 0,
        "parts_done": parts_done(found, jobs),
        "pilot_failed": failure(job),
        "listed": [
            (folder.name, (folder / RESULTS / "report.html").is_file())
            for folder in pilots(found.defaults)
        ],
    }


def parts_done(found: Snapshot, jobs: Jobs) -> int:
    """Return how many simulated participants the running pilot has reached."""
    job = jobs.last("pilot")
    if job is None or not job.running:
        return 0
    try:
        newest = pilots(found.defaults)[0]
        begun = newest.stat().st_mtime >= job.began_s - 1
        return sum(1 for _ in (newest / "sourcedata").glob("sub-*")) if begun else 0
    except (IndexError, OSError):
        return 0  # its folder does not exist yet
