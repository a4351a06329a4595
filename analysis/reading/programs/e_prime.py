"""Read E-Prime text files: logs written by E-Run and tables exported by E-DataAid.

Both are usually UTF-16. A log begins with ``*** Header Start ***``. A log consists of frames, which
are lists of variables. Frames are nested, and each frame follows the frames nested inside it. Each
row of the returned table combines a frame at the deepest level of nesting (usually a trial) with
its enclosing frames and the header. An exported table begins with its column names, which include
``ExperimentName`` and ``Subject``, possibly after lines with the file name and types.
"""

from __future__ import annotations

import re
from pathlib import Path

import pandas as pd

from slipscale.analysis.reading.dialect import decoded
from slipscale.analysis.reading.programs.records import framed, records, table_of
from slipscale.faults import UserError

LOG = "*** Header Start ***"
EDGE = re.compile(r"\*\*\* (?P<kind>Header|LogFrame) (?P<edge>Start|End) \*\*\*")
#: Number of first lines in which the header is searched: E-DataAid writes the file's name and up to
#: three lines of types above it.
MOST_ABOVE = 5
#: Columns in every exported table.
ALWAYS = {"ExperimentName", "Subject"}


def recognises(head: str, _path: Path) -> bool:
    """Return whether a file with this beginning was written by E-Prime."""
    return head.lstrip().startswith(LOG) or _header_line(head) is not None


def read(content: bytes, path: Path) -> pd.DataFrame:
    """Return one row per trial, with all cells as text.

    Raises
    ------
    UserError
        If a log has no complete frame, or a frame is not closed.
    """
    text = decoded(content, path)[0].decode("utf-8")
    if text.lstrip().startswith(LOG):
        return _log(text, path)
    skipped = _header_line(text.lstrip("\r\n")) or 0
    (_, names), *rows = records(text.lstrip("\r\n").split("\n", skipped)[-1], path)
    return table_of(names, [(line + skipped, row) for line, row in rows])


def _header_line(head: str) -> int | None:
    """Return the index of the header line, or None if the file is not an exported table."""
    for number, line in enumerate(head.split("\n", MOST_ABOVE)[:MOST_ABOVE]):
        if set(line.strip("\r").split("\t")) >= ALWAYS:
            return number
    return None


def _log(text: str, path: Path) -> pd.DataFrame:
    header: dict[str, str] = {}
    frames: list[tuple[int, int, dict[str, str]]] = []
    inside: dict[str, str] | None = None
    level = 1
    for number, line in enumerate(text.splitlines(), start=1):
        edge = EDGE.search(line)
        name, colon, value = line.strip().partition(":")
        if edge is not None and edge["edge"] == "Start":
            inside = header if edge["kind"] == "Header" else {}
        elif edge is not None:
            if edge["kind"] == "LogFrame" and inside is not None:
                frames.append((level, number, inside))
            inside = None
        elif inside is None and name == "Level" and value.strip().isdigit():
            level = int(value)
        elif inside is not None and colon:
            inside[name] = value.strip()
    if inside is not None or not frames:
        raise UserError(
            "{path}: {reason}; expected the complete log of a finished session",
            path=path,
            reason="a frame is not closed" if frames else "no complete frame",
        )
    deepest = max(level for level, _, _ in frames)
    rows, lines = [], []
    around: dict[int, dict[str, str]] = {}
    # The order is reversed, because each frame in a log follows the frames nested inside it.
    for level, number, frame in reversed(frames):
        around = {outer: values for outer, values in around.items() if outer < level}
        around[level] = frame
        if level == deepest:
            rows.append({k: v for part in (header, *around.values()) for k, v in part.items()})
            lines.append(number)
    return framed(rows[::-1], lines[::-1])
