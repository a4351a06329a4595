"""Read which participants the last analysis excluded, and by which rules of the study.

The study file lists the flags that lead to exclusion
(`slipscale.experiments.study.analysis_choices`). The analysis assigns these flags to participants;
this module reads the result.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path

RESULTS = Path("derivatives", "slipscale", "results.json")


@dataclass(frozen=True, slots=True, kw_only=True)
class Exclusions:
    """Participants excluded in the last analysis of a data set.

    Parameters
    ----------
    flags : Mapping
        Flags that led to each participant's exclusion, by participant label.
    analysed_utc : str
        Time of the analysis in ISO 8601. Empty if no analysis has been run, or if its results are
        incomplete or unreadable.
    """

    flags: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    analysed_utc: str = ""


def read_exclusions(dataset: Path) -> Exclusions:
    """Return the exclusions in the last analysis; empty if there was no analysis."""
    path = dataset / RESULTS
    try:
        stat = path.stat()
        return _read(path, stat.st_ino, stat.st_mtime_ns, stat.st_size)
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        return Exclusions()


@lru_cache(maxsize=16)
def _read(path: Path, _inode: int, changed_ns: int, _size: int) -> Exclusions:
    excluded = json.loads(path.read_text(encoding="utf-8"))["excluded"]
    made = datetime.fromtimestamp(changed_ns / 1e9, UTC)
    return Exclusions(
        flags={
            str(who).removeprefix("sub-"): tuple(str(flag) for flag in why)
            for who, why in excluded.items()
        },
        analysed_utc=made.isoformat(timespec="seconds"),
    )
