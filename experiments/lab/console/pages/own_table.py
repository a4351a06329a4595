"""The page for a laboratory's own table: upload, preview, meaning of the columns, and report."""

from __future__ import annotations

from slipscale.experiments.lab.console.own_tables import (
    CODES,
    LARGEST_MB,
    ROLES,
    about,
    description_of,
    tables,
    values_in,
)
from slipscale.experiments.lab.console.pages.view import View, date_of, failure
from slipscale.experiments.lab.console.state import RESULTS, changed_ns
from slipscale.faults import ANSWER_IS_NO  # the description states why the choices do not fit


def own_table(view: View) -> dict[str, object]:
    """Return the values for the page of the selected table or, by default, the newest."""
    found = tables()
    asked = view.query.get("number", "")
    folder = next((path for path in found if path.name == asked), found[0] if found else None)
    described = description_of(folder) if folder else None
    name = about(folder.name) if folder else ""
    describe, report = (
        job if job and str(job.about) == name else None
        for job in (view.jobs.last("describe"), view.jobs.last("report"))
    )
    unreadable = failure(describe) if describe and describe.status != ANSWER_IS_NO else ""
    failed = failure(report) if report and report.status != ANSWER_IS_NO else ""
    result = folder / RESULTS / "report.html" if folder else None
    faults = [text for text in (described.fault if described else "", failed) if text]
    named = {column: text for text in faults for column in values_in(text)}
    columns = described.columns if described else ()
    beside = {column.name: named[column.name] for column in columns if column.name in named}
    return {
        "most_mb": LARGEST_MB,
        "listed": [
            (path.name, each.name if (each := description_of(path)) else "") for path in found
        ],
        "number": folder.name if folder else "",
        "described": described,
        "reading": bool(describe and describe.running),
        "unreadable": unreadable,
        "beside": beside,
        "elsewhere": [text for text in faults if text not in beside.values()],
        "roles": ROLES,
        "role_of": {column: role for role, column in described.roles.items()} if described else {},
        "meanings": CODES,
        "analysing": bool(report and report.running),
        "steps": report.steps() if report else [],
        "report_of": date_of(changed_ns(result)) if result and result.is_file() else "",
    }
