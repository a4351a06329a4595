"""Read jsPsych data (CSV or JSON). Objects in cells become columns such as ``response.Q0``.

A file is recognised as jsPsych if every trial has ``trial_type``, ``trial_index`` and
``time_elapsed``. A JSON file contains a single list of trials, or one list per line (one line per
participant), as in files exported from JATOS. Files named ``.json``, ``.jsonl`` or ``.ndjson`` are
read in the same way without these fields. They may also contain one object with a list per column,
or one of the other arrangements that pandas writes.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pandas as pd

from slipscale.analysis.reading.dialect import decoded, separator_of
from slipscale.analysis.reading.programs.records import framed, records
from slipscale.faults import UserError

#: Endings of JSON files of any program.
ENDINGS = (".json", ".jsonl", ".ndjson")
#: Fields that every trial has.
ALWAYS = ("trial_type", "trial_index", "time_elapsed")


def recognises(head: str, path: Path) -> bool:
    """Return whether a file with this beginning was written by jsPsych."""
    if head[:1] in "[{" and head:
        return path.suffix.lower() in ENDINGS or all(f'"{name}"' in head for name in ALWAYS)
    header = head.partition("\n")[0].replace('"', "").strip("\r")
    return set(ALWAYS) <= set(header.split(separator_of(header.encode())))


def read(content: bytes, path: Path) -> pd.DataFrame:
    """Read one row per trial, as text or numbers; for JSON, ``line`` is the trial number.

    Raises
    ------
    UserError
        If the JSON cannot be read, or an entry is not a trial.
    """
    text = decoded(content, path)[0].decode("utf-8").strip()
    if text[:1] not in "[{":
        (_, names), *rows = records(text, path)
        cells = [dict(zip(names, row, strict=False)) for _, row in rows]
        return _without_emptied(
            framed([dict(_flat(row)) for row in cells], [line for line, _ in rows])
        )
    trials = _trials(text, path)
    for number, trial in enumerate(trials, start=1):
        if not isinstance(trial, dict):
            raise UserError(
                "{path}: entry {number} is {trial:.40}; expected an object with a trial's fields "
                "(from pandas: table.to_json(file, orient='records'))",
                path=path,
                number=number,
                trial=repr(trial),
            )
    return _without_emptied(
        framed([dict(_flat(trial)) for trial in trials], range(1, len(trials) + 1))
    )


def _without_emptied(frame: pd.DataFrame) -> pd.DataFrame:
    """Drop columns whose values were all expanded into separate columns."""
    emptied = [
        name
        for name in frame.columns
        if any(other.startswith(f"{name}.") for other in frame.columns)
        and frame[name].fillna("").eq("").all()
    ]
    return frame.drop(columns=emptied)


def _trials(text: str, path: Path) -> list[object]:
    decoder, at = json.JSONDecoder(), 0
    found: list[object] = []
    try:
        while at < len(text):
            part, at = decoder.raw_decode(text, at)
            found += part if isinstance(part, list) else _arranged(part)
            at += len(text[at:]) - len(text[at:].lstrip(" \r\n\t,"))
    except (json.JSONDecodeError, RecursionError) as error:
        raise UserError(
            "{path}: not readable JSON ({error}); expected a list with one object per trial, "
            "such as jsPsych.data.get().json()",
            path=path,
            error=error,
        ) from None
    # The list may contain one list of trials per participant.
    return [trial for part in found for trial in (part if isinstance(part, list) else [part])]


def _arranged(whole: object) -> list[object]:
    """Return the rows in an object: a list per column, or an arrangement that pandas writes."""
    if not isinstance(whole, dict) or not whole:
        return [whole]
    parts = list(whole.values())
    found: list[object] = [whole]
    names, rows = whole.get("columns"), whole.get("data")
    if isinstance(rows, list) and rows and all(isinstance(row, dict) for row in rows):
        found = rows
    elif isinstance(names, list) and isinstance(rows, list):
        found = [dict(zip(map(str, names), row, strict=False)) for row in rows]
    elif all(isinstance(part, list) for part in parts):
        if len({len(part) for part in parts}) == 1 and len(parts[0]) > 1:
            found = [dict(zip(whole, row, strict=True)) for row in zip(*parts, strict=True)]
    elif all(isinstance(part, dict) for part in parts) and len({tuple(p) for p in parts}) == 1:
        if all(key.isdigit() for key in whole):
            found = parts
        elif parts[0] and all(key.isdigit() for key in parts[0]):
            found = [{name: part[key] for name, part in whole.items()} for key in parts[0]]
    return found


def _flat(value: object, name: str = "") -> Iterator[tuple[str, object]]:
    if isinstance(value, str) and value[:1] == "{":
        with suppress(json.JSONDecodeError, RecursionError):  # an answer may begin with a brace
            value = json.loads(value)
    if isinstance(value, dict) and value:
        for key, inner in value.items():
            yield from _flat(inner, f"{name}.{key}" if name else str(key))
    else:
        yield name, json.dumps(value) if isinstance(value, dict | list) else value
