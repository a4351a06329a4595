"""Select one session, or report that sessions are pooled."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from typing import TYPE_CHECKING

from slipscale.analysis.reading.surface_labels import numbers_first
from slipscale.faults import UserError

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.reading.dataset import Dataset


def sessions_of(data: Dataset) -> list[str]:
    """Return the labels of all sessions that contain trials, in the order of the study file.

    Labels that are not in the study file follow in sorted order.
    """
    found: set[str] = set()
    for table in data.tables.values():
        if "session" in table:
            found.update(map(str, table["session"].dropna().unique()))
    planned = [str(label) for label in tomllib.loads(data.study_text).get("sessions", ())]
    listed = [label for label in planned if label in found]
    return [*listed, *sorted(found - {"", *listed}, key=numbers_first)]


def only_session(data: Dataset, session: str) -> Dataset:
    """Return a data set with only the trials of one session.

    Raises
    ------
    UserError
        If the session does not exist.
    """
    known = sessions_of(data)
    if session not in known:
        available = ", ".join(known) or "none"
        raise UserError(
            "{data_name}: unknown session '{session}'; expected one of {available}",
            data_name=data.name,
            session=session,
            available=available,
        )
    note = f"Only session {session} is analysed; the data contain sessions {', '.join(known)}."
    of_session = data.with_tables(lambda table: _rows(table, session))
    return replace(of_session, problems=(*data.problems, note))


def _rows(table: pd.DataFrame, session: str) -> pd.DataFrame:
    if "session" not in table:
        return table
    return table[table["session"].astype(str) == session].reset_index(drop=True)


def pooled(data: Dataset) -> list[str]:
    """State that sessions are combined, and in which section the report compares them."""
    known = sessions_of(data)
    if len(known) < 2:  # noqa: PLR2004 - several
        return []
    chosen = data.choices.tests
    compared = (
        "Differences between sessions are reported under “Sessions”"
        if chosen is None or "sessions" in chosen
        else "The study file does not select the test “sessions”, so changes between sessions "
        "are not tested"
    )
    sentence = (
        f"Sessions {', '.join(known)} are combined: each participant's mean is over all of "
        f"their sessions. {compared}. To analyse a single session, use --in-session "
        f"{known[0]}."
    )
    return [sentence]
