"""Check thousands of published columns, with one verdict per column.

Each row of the input file describes one published column, and the verdict on a row does not depend
on other rows. Verdicts and their order are therefore independent of the number of workers, and an
interrupted batch can be resumed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from hashlib import sha256
from multiprocessing import get_context
from typing import TYPE_CHECKING

from slipscale.analysis.reconstruction.data_sets.saddle_point import log10_multisets
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.table.contradictions import impossible

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.data_sets.constraints import Targets
    from slipscale.analysis.reconstruction.table.table_files import Row

# Number of rows that are passed to a worker process at a time.
TOGETHER = 8


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Verdict on one row of a batch file.

    Parameters
    ----------
    line : int
        Number of the line on which the row ends.
    digest : str
        Hash of the row's cells, by which the row is found when a batch is resumed.
    label : str
        Label of the column.
    verdict : {"consistent", "inconsistent", "not counted", "not understood"}
        The result. "Not counted" means that no contradiction was found, but that the row exceeds
        the limits on counting.
    failed : {"", "impossible", "GRIM", "GRIMMER", "extremes", "count"}
        Name of the first test that an inconsistent row fails.
    multisets : str
        Exact number of data sets. Empty if the data sets were not counted.
    log10_estimate : str
        Approximate decimal logarithm of the number of data sets. Empty if the data sets were
        counted or if no approximation is available.
    reason : str
        Reason for a verdict other than "consistent".
    """

    line: int
    digest: str
    label: str
    verdict: str
    failed: str = ""
    multisets: str = ""
    log10_estimate: str = ""
    reason: str = ""


def verdict(row: Row, memory_gib: float, minutes: float) -> Verdict:
    """Return the verdict on one row of a batch file."""
    give = partial(Verdict, line=row.line, digest=digest(row))
    if row.column is None:
        reason = "; ".join(fault.whole for fault in row.told)
        return give(label="", verdict="not understood", reason=reason)
    solutions = Solutions(row.column, memory_gib, minutes)
    label = row.column.label
    if solutions.refused:
        about = log10_multisets(solutions.targets)
        return give(
            label=label,
            verdict="not counted",
            log10_estimate="" if about is None else f"{about:.2f}",
            reason=solutions.refused,
        )
    if solutions.consistent:
        multisets = str(solutions.multisets)
        return give(label=label, verdict="consistent", multisets=multisets)
    return give(
        label=label,
        verdict="inconsistent",
        failed="impossible" if impossible(row.column) else _failed(solutions.targets),
        multisets="0",
        reason=solutions.reason,
    )


def _failed(targets: Targets) -> str:
    tests = ((targets.grim, "GRIM"), (targets.grimmer, "GRIMMER"), (not targets.reason, "extremes"))
    return next((name for passed, name in tests if not passed), "count")


def digest(row: Row) -> str:
    """Return a hash that identifies a row's cells."""
    return sha256("\0".join(row.cells).encode()).hexdigest()[:12]


def verdicts(
    rows: Sequence[Row], memory_gib: float, minutes: float, workers: int
) -> Iterator[Verdict]:
    """Yield one verdict per row, in the order of the rows.

    Parameters
    ----------
    rows : sequence of Row
        Rows of the file.
    memory_gib, minutes : float
        Limits on memory and time for each row.
    workers : int
        Number of processes. With 1, the current process does all the work.
    """
    judge = partial(verdict, memory_gib=memory_gib, minutes=minutes)
    if workers == 1 or len(rows) <= TOGETHER:
        yield from map(judge, rows)
        return
    # Forking would copy locks of numerical libraries' threads in an arbitrary state.
    with ProcessPoolExecutor(max_workers=workers, mp_context=get_context("spawn")) as pool:
        yield from pool.map(judge, rows, chunksize=TOGETHER)


def summary(found: Iterable[tuple[str, str]]) -> list[str]:
    """Summarise the number of rows per verdict and per failed test, as lines of text."""
    counts = Counter(found)
    rows = counts.total()
    lines = [f"{rows:,} rows"]
    for name in ("consistent", "inconsistent", "not counted", "not understood"):
        of_it = {failed: number for (word, failed), number in counts.items() if word == name}
        number = sum(of_it.values())
        which = ", ".join(f"{failed} {of_it[failed]:,}" for failed in sorted(of_it) if failed)
        share = f"{number / rows:.1%}" if rows else ""
        lines.append(f"  {name:<15}{number:>9,}  {share:>6}" + (f"  ({which})" if which else ""))
    return lines
