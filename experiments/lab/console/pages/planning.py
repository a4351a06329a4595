"""The planning page: sample size, duration and cost from a power analysis, and the frozen plan.

One job simulates all conditions of a grid, and the sliders on the page select one of them. Results
are stored per version of the study's text, so that an edited study never shows the power of an
earlier version.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from math import comb
from typing import Any

from slipscale.experiments.lab.console.actions.folder import power_folder
from slipscale.experiments.lab.console.actions.study_changes import Change, changed
from slipscale.experiments.lab.console.pages.editor import simulated_minutes
from slipscale.experiments.lab.console.pages.view import MOST_PEOPLE, View, failure
from slipscale.experiments.lab.console.plots import WIDE
from slipscale.experiments.lab.console.state import digest_of, frozen_plans
from slipscale.faults import UserError

AXES = ("participants", "repetitions", "effect")
PROTOCOL = "magnitude_estimation"  # the task whose power is planned


@dataclass(frozen=True, slots=True, kw_only=True)
class Slider:
    """A slider for one axis of the grid: the axis values, and the index of the selected value."""

    axis: str
    values: tuple[float, ...]
    at: int

    @property
    def value(self) -> float:
        """The selected value."""
        return self.values[self.at]


def planning(view: View) -> dict[str, object]:
    """Return the values for the planning page."""
    found, job, frozen = view.found, view.jobs.last("power"), view.jobs.last("freeze")
    shown: dict[str, object] = {
        "computing": bool(job and job.running),
        "progress": _progress(job.steps()) if job and job.running else (0, 1),
        "freezing": bool(frozen and frozen.running),
        "freeze_failed": failure(frozen),
        "plans": [(path.name, digest_of(path)) for path in frozen_plans()],
        "sliders": [],
        "failed": failure(job),
    }
    if found.study is None:
        return shown
    try:
        read = json.loads((power_folder(found.study_text) / "power.json").read_bytes())
        conditions = read["conditions"]
        sliders = [_slider(axis, conditions, view) for axis in AXES]
    except (OSError, ValueError, LookupError, TypeError):
        return shown  # nothing has been computed for this text yet
    people, repetitions, effect = (each.value for each in sliders)
    same = {
        each["participants"]: each
        for each in conditions
        if (each["repetitions"], each["effect"]) == (repetitions, effect)
    }
    chosen = same[people]
    minutes = simulated_minutes(_with_repetitions(view, int(repetitions)), found.defaults.study)
    return shown | {
        "failed": "",
        "sliders": sliders,
        "target": read["target"],
        "weakest": chosen["weakest"],
        "power": chosen["power"],
        "false_alarms": chosen["false_alarms"],
        "enough": min((n for n in same if same[n]["weakest"] >= read["target"]), default=None),
        "curve": _curve({n: each["weakest"] for n, each in same.items()}, read["target"]),
        "minutes": None if found.live else minutes,
        "people": int(people),
        "equal_effects": read["equal_effects"],
        "rank_tests_from": _rank_tests_from(view),
    }


def _progress(steps: list[str]) -> tuple[int, int]:
    """Return the number of finished parts and the total number of parts."""
    done, _, of = (steps or ["0/1"])[-1].partition("/")
    return int(done), max(int(of), 1)


def _slider(axis: str, conditions: list[Mapping[str, Any]], view: View) -> Slider:
    """Return the slider for an option, at the position in the URL or at a default position.

    By default, the slider is at the study's number of participants or, for other options, at 1. If
    this value was not simulated, the slider is at the nearest value.
    """
    values = tuple(sorted({float(each[axis]) for each in conditions}))
    given = view.query.get(axis, "")
    if given.isdecimal() and int(given) < len(values):
        return Slider(axis=axis, values=values, at=int(given))
    study = view.found.study
    own = {"participants": study.participants if study else 0, "effect": 1.0}.get(axis, 1.0)
    nearest = min(values, key=lambda value: abs(value - own))
    return Slider(axis=axis, values=values, at=values.index(nearest))


def _rank_tests_from(view: View) -> int:
    """Return the smallest number of participants with which a rank test of a pair can show any.

    The smallest p-value of Wilcoxon's test of n participants is 2 / 2^n, times the number of pairs.
    Returns 0 if the study's primary analysis has no rank tests.
    """
    study = view.found.study
    if study is None or study.analysis.primary != "ranks":
        return 0
    pairs = comb(len(study.levels), 2)
    most = 1 - study.analysis.confidence
    return next((n for n in range(1, MOST_PEOPLE) if pairs * 2.0 ** (1 - n) < most), 0)


def _with_repetitions(view: View, repetitions: int) -> str:
    """Return the study's text with the number of repetitions changed in the planned task."""
    text, study = view.found.study_text, view.found.study
    for number, task in enumerate(study.tasks if study else ()):
        if task.protocol == PROTOCOL:
            place = ("tasks", number, "repetitions")
            change = Change(what="set", place=place, kind="number", value=str(repetitions))
            try:
                return changed(text, change)
            except UserError:
                return text
    return text


def _curve(weakest: Mapping[int, float], target: float) -> dict[str, Any]:
    """Return SVG coordinates for plotting the power of the weakest comparison by sample size."""
    most = max(weakest)
    return {
        "points": [(WIDE.x(n / most), WIDE.y(weakest[n]), n) for n in sorted(weakest)],
        "target": WIDE.y(target),
        "ticks": [(WIDE.y(power), f"{power:g}") for power in (0, 0.5, 1)],
    }
