"""The input that all pages receive, and functions that several pages use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime

from slipscale.experiments.lab.console.jobs import Job, Jobs
from slipscale.experiments.lab.console.page_texts import Words
from slipscale.experiments.lab.console.state import Snapshot, changed_ns
from slipscale.experiments.study.run_plan import RunPlan

MOST_PEOPLE = 60  # maximum number of rows in a table, unless the page requests all rows


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """A request for a page, and the data to be shown on the page.

    Parameters
    ----------
    query : Mapping
        The query string's parameters.
    """

    found: Snapshot
    jobs: Jobs
    t: Words
    query: Mapping[str, str]


def local_time(utc: str) -> str:
    """Convert an ISO 8601 time to this computer's time zone, to the minute.

    >>> local_time("")
    ''
    """
    return f"{datetime.fromisoformat(utc).astimezone():%Y-%m-%d %H:%M}" if utc else ""


def date_of(when_ns: int | None) -> str:
    """Convert a file's modification time to ISO 8601, or None to an empty string."""
    return "" if when_ns is None else datetime.fromtimestamp(when_ns / 1e9, UTC).isoformat()


def when_over(job: Job | None) -> str:
    """Return when a job ended, in ISO 8601; empty if there is no job or it is still running."""
    if job is None or job.running:
        return ""
    return datetime.fromtimestamp(changed_ns(job.output) / 1e9, UTC).isoformat()


def failure(job: Job | None) -> str:
    """Return the error message of a job that failed; empty if it succeeded.

    A stopped session does not count as a failure.
    """
    stopped = 130
    return job.complained() if job and job.status not in (None, 0, stopped) else ""


def plan_of(found: Snapshot, participant: str) -> RunPlan:
    """Return the plan of a participant's first run; raise LookupError if there is no study."""
    if found.study is None:
        raise LookupError("there is no study on which to base a plan")
    return RunPlan(
        study_name=found.defaults.study,
        study_text=found.study_text,
        participant=participant,
        session=(*found.study.sessions, "")[0],
        seed=found.study.seed,
        language=found.defaults.language or found.study.language,
        mode="participant",
    )


def titles_of(found: Snapshot, t: Words) -> dict[str, str]:
    """Return the titles of the study's tasks by label, in the reader's language."""
    if found.study is None:
        return {}
    tasks = plan_of(found, "01").tasks()
    return {protocol.task: t.task(options, protocol, found.study) for protocol, options in tasks}
