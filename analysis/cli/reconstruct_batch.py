"""Implement `slipscale reconstruct --batch`: check all rows of a CSV file."""

from __future__ import annotations

import csv
import io
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.faults import ANSWER_IS_NO, DONE, UserError
from slipscale.faults.spreadsheet_cells import harmless_cell

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.table.table_files import Row


def run_batch(arguments: Namespace) -> int:
    """Write one verdict per row, or resume an earlier run; return 1 if a row is inconsistent."""
    from slipscale.analysis.reconstruction.data_sets.batch import Verdict, summary, verdicts
    from slipscale.analysis.reconstruction.table.table_files import read_rows

    if arguments.out is None:
        raise UserError("--batch needs --out FILE, the CSV file for the verdicts")
    if arguments.workers < 1:
        raise UserError("--workers {workers}: expected 1 or more", workers=arguments.workers)
    others = ("sample", "long", "html", "json", "conclusions", "variants")
    if given := [f"--{name}" for name in others if getattr(arguments, name)]:
        raise UserError(
            "--batch writes one verdict per row: omit {options}", options=", ".join(given)
        )
    rows = read_rows(arguments.table)
    names = [field.name for field in fields(Verdict)]
    found = _earlier(arguments.out, names, rows)
    try:
        with arguments.out.open("a", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, names, lineterminator="\n")
            if not file.tell():
                writer.writeheader()
            left = rows[len(found) :]
            for verdict in verdicts(
                left, arguments.memory_gib, arguments.minutes, arguments.workers
            ):
                record = asdict(verdict)
                writer.writerow(record | {"label": harmless_cell(verdict.label)})
                # Finished verdicts are kept.
                file.flush()
                found.append((verdict.verdict, verdict.failed))
    except OSError as error:
        raise UserError(
            "{out}: cannot be written ({reason})", out=arguments.out, reason=error.strerror
        ) from None
    print("\n".join(summary(found)))
    return ANSWER_IS_NO if any(word == "inconsistent" for word, _ in found) else DONE


def _earlier(path: Path, names: list[str], rows: Sequence[Row]) -> list[tuple[str, str]]:
    """Read the verdicts of an earlier run, and remove an incomplete last line.

    Raises
    ------
    UserError
        If the file is not a verdict file, or if its verdicts are for other rows.
    """
    from slipscale.analysis.reconstruction.data_sets.batch import digest

    if not path.exists():
        return []
    try:
        text = path.read_bytes().decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UserError("{path}: cannot be read ({error})", path=path, error=error) from None
    whole = text[: text.rfind("\n") + 1]
    reader = csv.reader(io.StringIO(whole, newline=""))
    head, written = next(reader, names), [dict(zip(names, cells, strict=False)) for cells in reader]
    same = len(written) <= len(rows) and all(
        (entry.get("line"), entry.get("digest")) == (str(row.line), digest(row))
        for entry, row in zip(written, rows, strict=False)
    )
    if head != names or not same or (text and not whole):
        raise UserError(
            "{path}: already exists and does not contain verdicts on these rows; expected a new"
            " file, or the output of an interrupted --batch with the same table",
            path=path,
        )
    if whole != text:
        path.write_bytes(whole.encode("utf-8"))
    return [(entry["verdict"], entry["failed"]) for entry in written]
