"""How many processes run the tests."""

from __future__ import annotations

import math
import os
from pathlib import Path

#: A worker that has collected all tests holds 0.6 GB and grows to 1.8 GB; the processes that a test
#: starts need up to 0.5 GB.
BYTES_PER_WORKER = 2e9


def workers(processors: int, memory: float) -> int:
    """Return the number of workers for which processors and memory suffice."""
    return max(1, int(min(processors, memory / BYTES_PER_WORKER)))


def memory_bytes(root: Path = Path("/")) -> float:
    """Return the machine's memory, or the limit of this process's control group if it is lower.

    Where the machine does not say (Windows), there is no limit.
    """
    known = hasattr(os, "sysconf")
    whole = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") if known else math.inf
    return min([whole, *_limits(root)])


def _limits(root: Path) -> list[float]:
    """Return the limits of this process's control groups; Linux has two ways to state them."""
    groups = root / "proc/self/cgroup"
    found = []
    for line in groups.read_text("utf-8").splitlines() if groups.exists() else []:
        _, controllers, path = line.split(":", 2)
        ways = {
            "": f"sys/fs/cgroup{path}/memory.max",
            "memory": f"sys/fs/cgroup/memory{path}/memory.limit_in_bytes",
        }
        limit = root / ways.get(controllers, "none")
        if limit.is_file() and (text := limit.read_text("utf-8").strip()).isdecimal():
            found.append(float(text))
    return found
