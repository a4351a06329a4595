"""Who was excluded from the analysis, and by which of the study's rules: as the last one found.

The study file names the flags that exclude (`slipscale.experiments.study.analysis_choices`); who
has them is for the analysis to say. This reads what it wrote.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

RESULTS = Path("derivatives", "slipscale", "results.json")


@dataclass(frozen=True, slots=True, kw_only=True)
class Exclusions:
    """What the last analysis of a data set found.

    Parameters
    ----------
    flags : Mapping
        Label of a participant -> the flags that excluded them; nobody else is in it.
    analysed_utc : str
        When that was, in ISO 8601; empty where there was no analysis, or its results are being
        written or cannot be read.
    """

    flags: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    analysed_utc: str = ""


def read_exclusions(dataset: Path) -> Exclusions:
    """Return who was excluded, as the last analysis found; nobody without one."""
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
