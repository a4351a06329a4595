"""Print the processor time of each part of ``slipscale analyse`` for 14 people.

    .venv/bin/python -m benchmarks.analyse_shares [--participants 14]

A pilot in another process simulates the data and fills the cache of compiled modules. Then the
packages are imported one by one, each after the packages that it requires, and the command runs
with its larger parts timed. The time of a part excludes the parts that it calls. The sum differs
from the time of the command without timers by less than the timers' overhead.
"""

from __future__ import annotations

import argparse
import io
import os
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import redirect_stdout
from functools import wraps
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.analyse_scale import environment

LEAST_SHARE = 0.01  # Parts with a smaller share are not printed.
#: Modules whose imports are timed in this order, keyed by label.
IMPORTS = {
    "import numpy": ("numpy",),
    "import pandas": ("pandas",),
    "import pydantic": ("pydantic",),
    "import scipy.stats": ("scipy.stats",),
    "import statsmodels and formulaic": (
        "statsmodels.regression.mixed_linear_model",
        "statsmodels.stats.proportion",
    ),
    "import matplotlib": ("matplotlib.figure", "matplotlib.backends.backend_svg"),
    "import slipscale": (
        "slipscale.commands",
        "slipscale.analysis.cli.analyse",
        "slipscale.analysis.load",
        "slipscale.analysis.reporting.files",
        "slipscale.analysis.reporting.terminal",
    ),
}
#: Functions (module and name) whose times are added up, keyed by label.
PARTS = {
    "compare tables with journals": (("slipscale.experiments.dataset.verification", "verify"),),
    "read tables": (("slipscale.analysis.load", "_load_folder"),),
    "other statistics": (("slipscale.analysis.pipeline", "conclude"),),
    "draw figures": (("slipscale.analysis.reporting.files", "draw"),),
    "lay out and write figures": (
        ("slipscale.figure_style", "svg"),
        ("slipscale.figure_style", "save"),
    ),
    "write tables and pages": (("slipscale.analysis.reporting.files", "write_analysis"),),
}


def timed(label: str, work: Callable[..., Any], spent_s: dict[str, float]) -> Callable[..., Any]:
    """Wrap a function to add its processor time, except timed calls inside it, to a label."""

    @wraps(work)
    def measured(*args: Any, **kwargs: Any) -> Any:
        began_s, inner_s = time.process_time(), sum(spent_s.values())
        try:
            return work(*args, **kwargs)
        finally:
            within_s = sum(spent_s.values()) - inner_s
            own_s = time.process_time() - began_s - within_s
            spent_s[label] = spent_s.get(label, 0.0) + own_s

    return measured


def replace_everywhere(module: str, name: str, label: str, spent_s: dict[str, float]) -> None:
    """Replace a function by its timed form in every module that imported it."""
    work = getattr(import_module(module), name)
    replacement = timed(label, work, spent_s)
    for each in list(sys.modules.values()):
        if getattr(each, name, None) is work:
            setattr(each, name, replacement)


def shares(data: Path, out: Path) -> dict[str, float]:
    """Time the parts of the command in seconds. Call this only once, in a fresh process."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # As in the command.
    spent_s = {"start Python": time.process_time()}
    for label, modules in IMPORTS.items():
        timed(label, lambda modules=modules: [*map(import_module, modules)], spent_s)()
    for label, functions in PARTS.items():
        for module, name in functions:
            replace_everywhere(module, name, label, spent_s)
    for each in import_module("slipscale.analysis.tasks.table").STATISTICS:
        object.__setattr__(each, "compute", timed(f"compute {each.key}", each.compute, spent_s))
    command = import_module("slipscale.commands").main
    with redirect_stdout(io.StringIO()):
        timed("everything else", command, spent_s)(["analyse", str(data), "--out", str(out)])
    return spent_s


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--participants", type=int, default=14)
    options = parser.parse_args()
    with TemporaryDirectory() as place:
        data = Path(place, "data")
        words = ("pilot", "--participants", str(options.participants), "--out", str(data))
        command = [sys.executable, "-m", "slipscale", *words]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment())
        spent_s = shares(data, Path(place, "out"))
    total_s = sum(spent_s.values())
    for label, part_s in spent_s.items():
        if part_s > LEAST_SHARE * total_s:
            print(f"{label:<34} {part_s:5.2f} s {part_s / total_s:5.0%}")
    print(f"{'total':<34} {total_s:5.2f} s")


if __name__ == "__main__":
    main()
