"""Print docs/reference/data-set.md, made from the schema.

Use: ``PYTHONPATH=. python tools/data_set_page.py > docs/reference/data-set.md``.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import TYPE_CHECKING

from slipscale.experiments.dataset.measured import MEASURED
from slipscale.experiments.dataset.schema import (
    FLAG_SEPARATOR,
    FLAGS,
    MISSING,
    NOTES,
    PARTICIPANT,
    RUN,
    SESSION,
    SIDECAR,
    columns,
    person_columns,
    questionnaire_columns,
    session_columns,
    table_stem,
)
from slipscale.experiments.protocols.registry import load_protocol, protocol_names

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from slipscale.experiments.protocols.base import Column, Protocol

INTRODUCTION = f"""# The data set

A session writes its journal; `slipscale` makes the data set from the journals, as often as
wanted. It is a behavioural data set in BIDS form: one table (TSV) and one sidecar (JSON) a task,
participant and run. The sidecar says what this page says. A missing value is `{MISSING}`; a
decimal point is a point; times are in seconds, to the microsecond; amplitudes are peak to peak.

This page is made from `experiments/dataset/schema.py` and the protocols.
"""
PEOPLE = f"""
## participants.tsv

One row a participant: `{PARTICIPANT}`, then a column for each question of the study's `about_you`
tables, then
"""
SESSIONS = f"""
## sub-01_sessions.tsv

Where runs have a session, each participant has a table with one row a session: `{SESSION}`, then
"""
QUESTIONNAIRES = f"""
## phenotype/

Each questionnaire of the study has a table `phenotype/<name>.tsv` and a sidecar with the words of
items and answers. One row for each time it was asked: `{PARTICIPANT}`, then, where a participant
comes more than once, which visit it was, then a column for each item, with the code of the answer.

"""
MEASURED_TEXT = """
## What is measured beside

Columns after `exploration_time`, in the tables of the runs that measured them: of the finger where
a source of its [place or forces](../how-to/finger.md) was used, of the plate where it tells them.
"""
FLAG_TEXT = f"""
## Flags

What happened in a trial, in the column `flag`; several are separated by `{FLAG_SEPARATOR}`.
"""
SIDECAR_TEXT = f"""
## The sidecar of a run

Beside each table, under the key `{SIDECAR}`:
"""


def page() -> str:
    """Return the whole page."""
    parts = [INTRODUCTION]
    shipped = [name for name in protocol_names() if _is_shipped(load_protocol(name))]
    for name in shipped:
        protocol = load_protocol(name)
        stem = table_stem(participant="01", session="", task=protocol.task, run="01")
        shown = f"\n`sub-01/beh/{stem}.tsv`, of the protocol `{name}`."
        if protocol.intervals:
            protocol = replace(protocol, interval_columns=2)
            shown += " A third interval has columns like those of the first two."
        parts += [f"\n## {protocol.title}\n", f"{shown}\n\n", _columns(columns(protocol))]
        parts += [
            f"\n## {protocol.title}\n",
            f"\n`sub-01/beh/{stem}.tsv`, of the protocol `{name}`.\n\n",
            _columns(columns(protocol)),
        ]
    parts += [MEASURED_TEXT, "\n", _columns(MEASURED)]
    parts += [PEOPLE, "\n", _columns(person_columns())]
    parts += [SESSIONS, "\n", _columns(session_columns())]
    parts += [QUESTIONNAIRES, _columns(questionnaire_columns({}, (SESSION, RUN)))]
    parts += [FLAG_TEXT, "\n", _table(("flag", "meaning"), _quoted(FLAGS))]
    parts += [SIDECAR_TEXT, "\n", _table(("key", "meaning"), _quoted(NOTES))]
    return "".join(parts)


def _is_shipped(protocol: Protocol) -> bool:
    """Return whether a protocol is Slipscale's own, not an installed laboratory's."""
    return protocol.steps.__module__.startswith("slipscale.experiments.protocols.")


def _columns(described: Mapping[str, Column]) -> str:
    """Return a table of columns."""
    rows = []
    for name, column in described.items():
        levels = "; ".join(f"`{level}`: {means}" for level, means in column.levels.items())
        # The flags have a table of their own.
        meaning = column.description.partition(":")[0] if name == "flag" else column.description
        rows.append(
            (f"`{name}`", column.kind, column.units, f"{meaning} ({levels})" if levels else meaning)
        )
    return _table(("column", "kind", "unit", "meaning"), rows)


def _quoted(entries: Mapping[str, str]) -> list[tuple[str, ...]]:
    return [(f"`{name}`", meaning) for name, meaning in entries.items()]


def _table(header: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    """Return a Markdown table."""
    lines = [header, tuple("---" for _ in header), *rows]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


if __name__ == "__main__":
    sys.stdout.reconfigure(encoding="utf-8")  # type: ignore[union-attr] # it is a text stream
    sys.stdout.write(page())
