"""Calibrate the plate, check its conformance, present surfaces, and start an emulated board."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from slipscale.experiments.lab.console.actions.calibrating import measured_so_far, result_in
from slipscale.experiments.lab.console.actions.desk import Actions, Desk
from slipscale.experiments.lab.console.actions.forms import Form, Nothing, unused
from slipscale.experiments.lab.console.jobs import HELD, Job
from slipscale.experiments.lab.folder import read_lab, write_settings
from slipscale.faults import UserError
from slipscale.faults.folders import visible
from slipscale.faults.message import Message
from slipscale.hardware.cli.calibrate import BACK, without_calibration

DECIMAL = r"[0-9]+([.,][0-9]*)?"
Decimal = Annotated[str, Field(pattern=f"^({DECIMAL})?$")]
TYPED = "typed"  # the operator types the readings, point by point


class Calibrate(Form):
    """Calibrate the folder's plate. If ``keep`` is False, no calibration file is written.

    ``table`` is the name of a CSV file with earlier readings, and ``serial`` identifies the device
    that drove the plate when they were taken. With `TYPED`, the operator types each reading. The
    sweep range is in Hz and V peak. Empty fields stand for the command's defaults.
    """

    by: Annotated[str, Field(min_length=1, max_length=200)]
    instrument: Annotated[str, Field(min_length=1, max_length=200)]
    temperature: Annotated[str, Field(pattern=f"^(-?{DECIMAL})?$")] = ""
    centre: Decimal = ""
    span: Decimal = ""
    sweep_voltage: Decimal = ""
    max_voltage: Decimal = ""
    finger: bool = False
    changed_plate: bool = False
    keep: bool = True
    table: Annotated[str, Field(max_length=200)] = ""
    serial: Annotated[str, Field(max_length=200)] = ""


class Reading(Form):
    """An instrument reading in µm p-p, or a request to repeat the previous point.

    ``number`` is the number of readings before this one. A request with any other number is
    rejected, so that no reading is stored twice.
    """

    reading: Annotated[str, Field(pattern=f"^({DECIMAL}|{BACK})$")]
    number: Annotated[int, Field(ge=0)]


class Surface(Form):
    """Present a surface at a level, in the plate's quantity, until the plate is switched off."""

    level: Annotated[float, Field(ge=0, allow_inf_nan=False)]


def _calibrate(desk: Desk, request: Calibrate) -> str:
    found = desk.free()
    words = [f"--by={request.by}", f"--instrument={request.instrument}"]
    numbers = ("temperature", "centre", "span", "sweep_voltage", "max_voltage")
    words += [
        f"--{name.replace('_', '-')}={typed.replace(',', '.')}"
        for name in numbers
        if (typed := getattr(request, name))
    ]
    if request.table == TYPED:
        words.append("--prompt")
    elif request.table:
        if request.table not in (path.name for path in visible(Path(), "*.csv")):
            raise UserError(
                "{table}: expected a CSV file in the laboratory folder", table=request.table
            )
        words += [f"--csv={request.table}", f"--serial={request.serial}"]
    if request.finger:
        words.append("--finger")
    if request.changed_plate:
        words.append("--changed-plate")
    spec = without_calibration(found.defaults.plate)
    out = ("--out", str(unused("calibration-{}.toml"))) if request.keep else ("--measure-only",)
    words = ["plate", "calibrate", f"--plate={spec}", *words, *out, "--steps", "--json"]
    desk.jobs.start("calibrate", "the calibration", *words)
    return "calibrating"


def _reading(desk: Desk, request: Reading) -> str:
    job = desk.jobs.last("calibrate")
    measured = measured_so_far(job.steps()) if job and job.running else None
    if job is None or measured is None or not measured.asked:
        raise UserError("no calibration is waiting for a reading")
    if len(measured.points) != request.number:
        raise UserError(
            "this point has already been measured; enter the reading for the point now on the page"
        )
    job.type(request.reading)
    return ""


def _conform(desk: Desk, _: Nothing) -> str:
    spec = desk.free().defaults.plate
    desk.jobs.start("conform", "the conformance check", "plate", "conform", spec)
    return "checking the plate's conformance"


def _surface(desk: Desk, request: Surface) -> str:
    spec = desk.free().defaults.plate
    words = ("plate", "watch", spec, f"--amplitude={request.level:g}", "--every=0.2")
    desk.jobs.start("surface", "the test surface", *words)
    return "presenting a test surface"


def _held(desk: Desk) -> list[Job]:
    jobs = (desk.jobs.last(kind) for kind in HELD)
    return [job for job in jobs if job and job.running]


def _hold(desk: Desk, _: Nothing) -> str:
    for job in _held(desk):
        job.hold()
    return ""


def _release(desk: Desk, _: Nothing) -> str:
    for job in _held(desk):
        job.release()
    return "the plate is switched off"


def _adopt(desk: Desk, _: Nothing) -> str:
    desk.free()
    job = desk.jobs.last("calibrate")
    made, lab = result_in(job.said()) if job else None, read_lab(Path())
    if made is None or made.file is None or lab is None:
        raise UserError("no calibration has been made since this console was started")
    spec = without_calibration(lab.plate)
    spec += f"{',' if ':' in spec else ':'}calibration={made.file}"
    write_settings(Path(), lab.model_copy(update={"plate": spec}))
    desk.now()
    return Message("saved: the laboratory folder's plate now uses {file}", file=made.file)


def _emulator(desk: Desk, _: Nothing) -> str:
    desk.jobs.start("emulator", "the emulated board", "plate", "emulate")
    return "starting an emulated board"


ACTIONS: Actions = {
    "calibrate": (Calibrate, _calibrate),
    "reading": (Reading, _reading),
    "conform": (Nothing, _conform),
    "surface": (Surface, _surface),
    "hold": (Nothing, _hold),
    "release": (Nothing, _release),
    "adopt": (Nothing, _adopt),
    "emulator": (Nothing, _emulator),
}
