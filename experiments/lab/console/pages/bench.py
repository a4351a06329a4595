"""The plate-bench page: plate file and limits, calibration, conformance and test surfaces."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from slipscale.experiments.lab.console.actions.bench import TYPED
from slipscale.experiments.lab.console.actions.calibrating import (
    IN_ALL,
    OF_FREQUENCY,
    measured_so_far,
    result_in,
)
from slipscale.experiments.lab.console.jobs import HELD, Job
from slipscale.experiments.lab.console.pages.view import View, failure
from slipscale.experiments.lab.console.plots import WIDE
from slipscale.faults import RigError, UserError, harmless
from slipscale.faults.folders import visible
from slipscale.faults.message import Message, from_data
from slipscale.hardware.calibration.result import result_of
from slipscale.hardware.calibration.sweep import SweepPlan
from slipscale.hardware.cli.calibrate import BACK
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.driver import PlateDriver
from slipscale.hardware.registry import open_plate

READING = re.compile(r"^\s*([\d.]+)\s+([\d.]+|n/a)\s", re.MULTILINE)
MOST_READINGS = 120
# The sweep range in Hz and V peak, with the command's defaults.
PLAN = SweepPlan()
SWEEP = (
    ("centre", PLAN.centre_hz),
    ("span", PLAN.span_hz),
    ("sweep_voltage", PLAN.sweep_voltage_v),
    ("max_voltage", PLAN.max_voltage_v),
)


class Axis(NamedTuple):
    """Points of a live plot in a 640 by 180 frame, with the limits of both axes."""

    points: tuple[tuple[float, float], ...]
    x_ends: tuple[str, str]
    top: str


def bench(view: View) -> dict[str, object]:
    """Return the values for the plate bench page."""
    found, jobs = view.found, view.jobs
    running = next((kind for kind in HELD if (job := jobs.last(kind)) and job.running), "")
    calibration, surface = jobs.last("calibrate"), jobs.last("surface")
    measured = measured_so_far(calibration.steps() if calibration else ())
    points, readings = measured.points, _readings(surface)
    emulator = jobs.last("emulator")
    return {
        "running": running,
        "busy": bool(found.live),
        "plate": _plate(found.defaults.plate),
        "quantity": found.study.quantity if found.study else None,
        "levels": found.study.levels if found.study else (),
        "tables": [path.name for path in visible(Path(), "*.csv")],
        "measured": measured,
        "typed": TYPED,
        "back": BACK,
        "plan": SWEEP,
        "in_all": IN_ALL,
        "resonance": _axis([(hz, um) for hz, _, um in points[:OF_FREQUENCY]]),
        "gain": _axis([(volts, um) for _, volts, um in points[OF_FREQUENCY:]]),
        "calibrated": result_in(calibration.said()) if calibration else None,
        "calibrate_failed": _failed(calibration),
        "verdicts": _verdicts(jobs.last("conform")),
        "conform_failed": _failed(jobs.last("conform")),
        "readings": _axis(readings),
        "read_last": (readings or [(0.0, 0.0)])[-1][1],
        "surface_failed": _failed(surface),
        "emulator_failed": _failed(emulator),
        "emulated": emulator.said().strip() if emulator and emulator.running else "",
    }


def _plate(spec: str) -> dict[str, object]:
    """Describe a plate without connecting to it, or return the error in its specification."""
    try:
        plate = open_plate(spec, clock=VirtualClock())
    except (UserError, RigError) as error:
        return {"spec": spec, "fault": str(error)}
    return {"spec": spec, "fault": "", "limits": _limits(plate), **_files(plate)}


def _limits(plate: PlateDriver) -> list[tuple[str, str]]:
    limits, q = plate.limits, plate.limits.quantity
    return [
        ("level", q.short(limits.level)),
        ("voltage", Message("{voltage_v:g} V peak", voltage_v=limits.voltage_v)),
        ("tolerance", f"{limits.tolerance:.0%}, {q.short(limits.deviation_level)}"),
        ("on_time", f"{limits.on_time_s:g} s"),
        ("duty", f"{limits.duty:.0%} / {limits.duty_window_s:g} s"),
    ]


def _files(plate: PlateDriver) -> dict[str, object]:
    made = plate.calibration
    filed = plate.plate_file
    return {
        "identity": filed.identity.model_dump() if filed else {},
        "calibration": {
            "date": made.made.date.isoformat(),
            "by": made.made.by,
            "instrument": made.made.instrument,
            **result_of(made).facts,
        }
        if made
        else {},
    }


def _axis(points: Sequence[tuple[float, float]]) -> Axis | None:
    """Scale points to a frame whose y axis starts at 0; return None if there are no points."""
    if not points:
        return None
    xs, ys = [x for x, _ in points], [y for _, y in points]
    left, right, top = min(xs), max(xs), max(*ys, 1e-9)
    placed = tuple((WIDE.x((x - left) / (right - left or 1.0)), WIDE.y(y / top)) for x, y in points)
    return Axis(placed, (f"{left:g}", f"{right:g}"), f"{top:.2f}")


def _failed(job: Job | None) -> str:
    """Return a job's error message; empty if the job did not fail or the console ended it."""
    return "" if job is None or job.released or job.status == 1 else failure(job)


def _verdicts(job: Job | None) -> list[tuple[str, str, str]]:
    """Return the conformance results so far, as (outcome, rule, detail) tuples."""
    found = []
    for line in job.said().splitlines() if job else ():
        with suppress(ValueError):  # an incomplete line, or the summary
            outcome, rule, detail = json.loads(line)
            found.append((outcome, harmless(from_data(rule)), harmless(from_data(detail))))
    return found


def _readings(job: Job | None) -> list[tuple[float, float]]:
    """Return the presented surface's readings as (time in s, level in the plate's quantity)."""
    rows = READING.findall(job.said()) if job else []
    return [(float(s), float(um)) for s, um in rows if um != "n/a"][-MOST_READINGS:]
