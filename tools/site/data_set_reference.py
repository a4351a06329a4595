"""The data set reference, generated from the schema and the protocols' columns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from slipscale.experiments.dataset.further_tables.person_columns import (
    person_columns,
    questionnaire_columns,
    session_columns,
)
from slipscale.experiments.dataset.measured import MEASURED
from slipscale.experiments.dataset.schema import (
    EVENTS,
    FLAG_SEPARATOR,
    FLAGS,
    MISSING,
    NOTES,
    PARTICIPANT,
    RUN,
    SESSION,
    SIDECAR,
    columns,
    table_stem,
)
from slipscale.experiments.protocol_parts.registry import load_protocol, protocol_names
from tools.site.tables import code, table

if TYPE_CHECKING:
    from slipscale.experiments.protocol_parts.base import Protocol
    from slipscale.experiments.steps.columns import Column

INTRODUCTION = f"""# The data set

Each session writes a journal, and the data set is built from the journals. It is a behavioural
data set in BIDS format, with one table (TSV) and one sidecar (JSON) per task, participant and run.
Missing values are `{MISSING}`. Decimals use a point, times are in seconds, and amplitudes are peak
to peak.

This page is generated from `experiments/dataset/schema.py` and the protocols.
"""
EVENTS_TEXT = """
## Events

Next to each table, `..._events.tsv` contains the times of the trials, since BIDS stores onsets and
durations in tables of events. Join it to the table with the column `trial`. The sidecar
`task-..._events.json` gives each trial type its HED tags.

"""
WARNINGS_TEXT = """
## The BIDS validator

The official validator reports no error. Its warnings are:

"""
#: What the validator recommends and Slipscale does not write, and why.
WARNINGS = {
    "CogAtlasID": "no entry of the Cognitive Atlas describes these tasks",
    "CogPOID": "the same for the Cognitive Paradigm Ontology",
    "InstitutionName": "not recorded; add it to `task-..._beh.json` of a copy before you publish",
    "InstitutionAddress": "as above",
    "InstitutionalDepartmentName": "as above",
    "SourceDatasets": "the data come from no other data set",
    "StimulusPresentation": "the sidecar's key `software` names PsychoPy and its version",
    "TOO_FEW_AUTHORS": "the study file names a single author, or none yet",
}
PEOPLE = f"""
## participants.tsv

One row per participant: `{PARTICIPANT}`, one column per question in the study's `about_you` tables,
and

"""
SESSIONS = f"""
## sub-01_sessions.tsv

If runs have a session, each participant has a table with one row per session: `{SESSION}`, and

"""
QUESTIONNAIRES = f"""
## phenotype/

Each questionnaire has a table `phenotype/<name>.tsv` and a sidecar with the item and answer texts.
The table has one row each time the questionnaire was completed: `{PARTICIPANT}`, the visit if there
are several, and one column per item with the code of the answer.

"""
MEASURED_TEXT = """
## Measurements

These columns follow `exploration_time` in the tables of runs in which they were measured: finger
columns if a [position or force sensor](../how-to/finger.md) was used, and plate columns if the
plate reports them.

"""
FLAG_TEXT = f"""
## Flags

The column `flag` lists what happened in a trial, separated by `{FLAG_SEPARATOR}`.

"""
SIDECAR_TEXT = f"""
## Sidecars

Each table has a sidecar next to it, which contains under the key `{SIDECAR}`:

"""


def pages() -> dict[str, str]:
    """Return the page."""
    return {"reference/data-set.md": page()}


def page() -> str:
    """Return the page's text; columns that most protocols share are listed once."""
    shipped = {
        name: protocol for name in protocol_names() if _is_shipped(protocol := load_protocol(name))
    }
    rows = {
        name: _rows(columns(replace(each, interval_columns=2) if each.intervals else each))
        for name, each in shipped.items()
    }
    times = Counter(row for own in rows.values() for row in own)
    shared = [row for row, count in times.items() if 2 * count > len(shipped)]
    parts = [INTRODUCTION, "\n## Columns of most tables\n\n", _table(shared)]
    for name, protocol in shipped.items():
        stem = table_stem(participant="01", session="", task=protocol.task, run="01")
        more = " Any third interval has the same columns." if protocol.intervals else ""
        lacking = ", ".join(row[0] for row in shared if row not in rows[name])
        more += f" Without {lacking}." if lacking else ""
        parts += [
            f"\n## {protocol.titled()}\n\n`sub-01/beh/{stem}.tsv`, protocol `{name}`.{more}\n\n",
            _table([row for row in rows[name] if row not in shared]),
        ]
    parts += [EVENTS_TEXT, _table(_rows(EVENTS))]
    parts += [MEASURED_TEXT, _table(_rows(MEASURED))]
    parts += [PEOPLE, _table(_rows(person_columns()))]
    parts += [SESSIONS, _table(_rows(session_columns()))]
    parts += [QUESTIONNAIRES, _table(_rows(questionnaire_columns({}, (SESSION, RUN))))]
    parts += [FLAG_TEXT, _meanings("flag", FLAGS), SIDECAR_TEXT, _meanings("key", NOTES)]
    parts += [WARNINGS_TEXT, _meanings("warning", WARNINGS)]
    return "".join(parts)


def _is_shipped(protocol: Protocol) -> bool:
    return protocol.steps.__module__.startswith("slipscale.experiments.protocols.")


def _rows(described: Mapping[str, Column]) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for name, column in described.items():
        levels = "; ".join(f"`{level}`: {means}" for level, means in column.levels.items())
        # Flags have a separate table.
        meaning = column.description.partition(":")[0] if name == "flag" else column.description
        meaning = f"{meaning} ({levels})" if levels else meaning
        rows.append((code(name), meaning, column.kind, column.units))
    return rows


def _table(rows: list[tuple[str, ...]]) -> str:
    return table(("column", "meaning", "kind", "unit"), rows) + "\n"


def _meanings(title: str, entries: Mapping[str, str]) -> str:
    return table((title, "meaning"), [(code(name), text) for name, text in entries.items()]) + "\n"
