"""Implement `slipscale plate calibrate`."""

from __future__ import annotations

import math
import os
import sys
from argparse import ArgumentParser, Namespace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.faults import DONE, UserError
from slipscale.hardware.address import number, positive_number
from slipscale.hardware.calibration.keep_alive import typed

if TYPE_CHECKING:
    from slipscale.hardware.calibration.record import Calibration, Device, DriveChain, Point
    from slipscale.hardware.calibration.sweep import SweepPlan
    from slipscale.hardware.driver import PlateDriver
    from slipscale.hardware.records import Readback

# `ASKED` is printed instead of a reading (--steps) while the operator is asked for it. The operator
# types `BACK` to repeat the previous point.
ASKED, BACK = "?", "b"


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `slipscale plate calibrate`."""
    parser.add_argument(
        "--plate",
        metavar="SPEC",
        help=("plate to calibrate (default: the laboratory folder's plate, or mock)"),
    )
    source = parser.add_mutually_exclusive_group()
    source.add_argument(
        "--prompt",
        action="store_true",
        help="prompt for vibrometer readings instead of using the plate's readback; enter b to "
        "repeat the previous point",
    )
    source.add_argument(
        "--csv",
        "--from-csv",
        type=Path,
        metavar="FILE",
        help="fit readings from a file without using the plate; columns: sweep (coarse, fine or "
        "voltage), "
        "frequency_hz, voltage_v, and one of amplitude_um_pp, velocity_mm_s_peak, trace (an "
        "oscilloscope's CSV file)",
    )
    parser.add_argument(
        "--mm-s-per-volt",
        type=positive_number,
        metavar="MM_S",
        help="for oscilloscope traces in --csv: velocity in mm/s per volt of the vibrometer output",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("calibration.toml"),
        metavar="FILE",
        help="new file to write (default: calibration.toml)",
    )
    parser.add_argument("--by", required=True, help="name of the person performing the calibration")
    parser.add_argument("--instrument", required=True, help="model and range of the vibrometer")
    parser.add_argument(
        "--temperature", type=number, metavar="C", help=("temperature of the plate, in °C")
    )
    parser.add_argument(
        "--point", default="", help="point on the plate at which the amplitude was measured"
    )
    parser.add_argument(
        "--finger", action="store_true", help="record that a finger was resting on the plate"
    )
    parser.add_argument(
        "--centre",
        type=positive_number,
        default=30_500.0,
        metavar="HZ",
        help="centre of the frequency sweep, in Hz (default: 30500)",
    )
    parser.add_argument(
        "--span",
        type=positive_number,
        default=1_500.0,
        metavar="HZ",
        help="half-width of the frequency sweep, in Hz (default: 1500)",
    )
    parser.add_argument(
        "--sweep-voltage",
        type=positive_number,
        default=5.0,
        metavar="V",
        help="voltage of the frequency sweep (default: 5)",
    )
    parser.add_argument(
        "--max-voltage",
        type=positive_number,
        default=16.0,
        metavar="V",
        help="largest voltage of the voltage sweep (default: 16)",
    )
    parser.add_argument(
        "--voltage-convention",
        default="V peak",
        choices=["V peak", "V peak-to-peak", "V RMS"],
        help="convention for all voltages, which are those at the plate (default: V peak)",
    )
    parser.add_argument(
        "--amplifier-gain",
        type=positive_number,
        metavar="G",
        help="check that the plate has this gain; to set the gain, use the plate's SPEC "
        "(scpi:RESOURCE,gain=G)",
    )
    parser.add_argument(
        "--serial",
        default="",
        help=(
            "with --csv: the serial number of the board or generator, as printed by slipscale check"
        ),
    )
    parser.add_argument(
        "--plate-serial",
        default="",
        help="serial number of the plate itself, if plates are interchangeable",
    )
    parser.add_argument(
        "--changed-plate",
        action="store_true",
        help="accept a gain that differs by more than 20 %% from the last calibration, because "
        "the plate, its amplifier or its wiring was changed",
    )
    parser.add_argument(
        "--seed", type=int, default=0, help=("random seed of a simulated plate (default: 0)")
    )
    parser.add_argument(
        "--measure-only",
        action="store_true",
        help="report resonance and gain without writing a file",
    )
    parser.add_argument(
        "--steps",
        action="store_true",
        help="print each reading (Hz, V, µm peak to peak) as a line to standard error; with "
        "--prompt, also print each question (Hz, V, question mark)",
    )
    parser.add_argument("--json", action="store_true", help="print the result as a line of JSON")
    parser.set_defaults(of_folder=without_calibration)


def without_calibration(spec: str) -> str:
    """Remove the calibration from a SPEC, because a new calibration will replace it.

    >>> without_calibration("serial:/dev/ttyACM0,calibration=plate.toml,limit=2")
    'serial:/dev/ttyACM0,limit=2'
    """
    return ",".join(word for word in spec.split(",") if not word.startswith("calibration="))


def run(arguments: Namespace) -> int:
    """Measure or read sweeps, fit them, and write the calibration with a plot."""
    # Imported late, to keep `slipscale plate --help` fast.
    from slipscale.figure_style import save
    from slipscale.hardware.calibration.plot import draw
    from slipscale.hardware.calibration.readings import read_points
    from slipscale.hardware.calibration.record import DriveChain, Provenance, write_calibration
    from slipscale.hardware.calibration.result import result_of
    from slipscale.hardware.calibration.sweep import SweepPlan, calibration_from

    if not arguments.measure_only:
        _check_out(arguments.out)
    plan = SweepPlan(
        centre_hz=arguments.centre,
        span_hz=arguments.span,
        sweep_voltage_v=arguments.sweep_voltage,
        max_voltage_v=arguments.max_voltage,
    )
    plate = _open(arguments)
    drive = DriveChain(
        voltage_convention=arguments.voltage_convention,
        amplifier_gain=_agreed_gain(plate, arguments.amplifier_gain),
    )
    serial = _plate_serial(plate, arguments.plate_serial)
    # Checked before the sweep, because an error after the sweep would lose the readings.
    made = Provenance(
        date=datetime.now(tz=UTC).date(),
        by=arguments.by,
        instrument=arguments.instrument,
        temperature_c=arguments.temperature,
        point=arguments.point,
        finger=arguments.finger,
    )
    if arguments.csv:
        device = _device(plate, arguments)
        points = read_points(arguments.csv, mm_s_per_v=arguments.mm_s_per_volt)
    else:
        device, points = _measure(plate, arguments, plan, drive)
    device = device.model_copy(update={"plate": serial})
    calibration = calibration_from(points, device=device, made=made, drive=drive)
    _check_plausible(calibration, plate, changed_plate=arguments.changed_plate)
    picture = arguments.out.with_suffix(".png")
    try:
        if not arguments.measure_only:
            write_calibration(calibration, arguments.out)
            save(draw(calibration), picture)
    except OSError as error:
        raise UserError(
            "--out {out}: {reason}", out=arguments.out, reason=error.strerror
        ) from error
    result = result_of(calibration, None if arguments.measure_only else arguments.out)
    if arguments.json:
        print(result.model_dump_json())
    else:
        written = f"{arguments.out} and {picture}" if result.file else "nothing"
        for name, fact in {**result.facts, "wrote": written}.items():
            print(f"{name:<10} {fact}")
    return DONE


def _check_plausible(calibration: Calibration, plate: PlateDriver, *, changed_plate: bool) -> None:
    from slipscale.hardware.calibration.soundness import changed, implausible

    expected = plate.plate_file.expected.model_dump() if plate.plate_file else {}
    faults = implausible(calibration, expected)
    if plate.calibration and not changed_plate:
        faults += filter(None, [changed(calibration, plate.calibration)])
    if faults:
        raise UserError(
            "calibration: {faults}. Check the unit of the readings, peak or peak to peak, and "
            "the amplifier's gain; nothing was written. If the plate was changed, add "
            "--changed-plate, or set other bounds under [expected] in its plate file",
            faults="; ".join(faults),
        )


def _check_out(path: Path) -> None:
    """Raise `UserError` unless the calibration and its plot can be written as new files."""
    if path.suffix != ".toml":
        raise UserError(
            "--out {path}: expected the name of a new TOML file, such as plate.toml", path=path
        )
    for each in (path, path.with_suffix(".png")):
        if each.exists():
            raise UserError(
                "--out {path}: {file} already exists, and data may depend on it; expected "
                "the name of a new file",
                path=path,
                file=each.name,
            )
    if not (path.parent.is_dir() and os.access(path.parent, os.W_OK)):
        raise UserError(
            "--out {path}: expected a writable folder, got {folder}", path=path, folder=path.parent
        )


def _open(arguments: Namespace) -> PlateDriver:
    from slipscale.hardware.address import without_session_watchdog
    from slipscale.hardware.clock import Clock, SystemClock, VirtualClock
    from slipscale.hardware.registry import open_plate

    spec = without_session_watchdog(arguments.plate or "mock")
    clock: Clock = VirtualClock() if spec.startswith("mock") else SystemClock()
    return open_plate(spec, clock=clock, seed=arguments.seed)


def _agreed_gain(plate: PlateDriver, given: float | None) -> float:
    """Return the driver's gain; raise `UserError` if ``given`` differs from it."""
    if given is not None and not math.isclose(given, plate.amplifier_gain):
        raise UserError(
            "--amplifier-gain {stated_gain:g}: plate '{plate_name}' has a gain of {plate_gain:g}; "
            "set the gain only in the plate's SPEC (scpi:RESOURCE,gain=...); the calibration "
            "file uses the same gain",
            stated_gain=given,
            plate_name=plate.name,
            plate_gain=plate.amplifier_gain,
        )
    return plate.amplifier_gain


def _plate_serial(plate: PlateDriver, given: str) -> str:
    """Return the plate's serial number. Raises `UserError` if the plate file contradicts it."""
    filed = plate.plate_file.identity.serial if plate.plate_file else ""
    if given and filed and given != filed:
        raise UserError(
            "--plate-serial {serial}: the plate file has serial number '{filed_serial}'; "
            "correct one of them",
            serial=given,
            filed_serial=filed,
        )
    return given or filed


def _device(plate: PlateDriver, arguments: Namespace) -> Device:
    """Return the device that drove the plate for the readings in a file."""
    from slipscale.hardware.calibration.record import Device

    if not arguments.serial and not plate.simulated:
        raise UserError(
            "--csv also requires --serial, the serial number of the board or generator "
            "that drove the plate; slipscale check prints this number"
        )
    return Device(backend=plate.name, serial=arguments.serial)


def _measure(
    plate: PlateDriver, arguments: Namespace, plan: SweepPlan, drive: DriveChain
) -> tuple[Device, tuple[Point, ...]]:
    from slipscale.hardware.calibration.record import Device
    from slipscale.hardware.calibration.sweep import sweep
    from slipscale.hardware.signals import silent_on_signals

    def report(frequency_hz: float, volts: float, read: str) -> None:
        if arguments.steps:
            print(f"step: {frequency_hz:g} {volts:g} {read}", file=sys.stderr, flush=True)

    def measure(frequency_hz: float, volts: float) -> float | None:
        readback = plate.excite(frequency_hz=frequency_hz, voltage_v=volts * drive.v_peak_per_volt)
        if arguments.prompt:
            report(frequency_hz, volts, ASKED)
            level = prompted(
                plate, f"{frequency_hz:.1f} Hz, {volts:.2f} {drive.voltage_convention}"
            )
        else:
            level = measured(plate, readback)
        report(frequency_hz, volts, BACK if level is None else f"{level:g}")
        return level

    with silent_on_signals(plate):
        identity = plate.connect()
        points = sweep(plan, measure)
    return (
        Device(
            backend=plate.name,
            manufacturer=identity.manufacturer,
            model=identity.model,
            serial=identity.serial,
            firmware=identity.firmware,
        ),
        points,
    )


def measured(plate: PlateDriver, readback: Readback) -> float:
    """Return the amplitude measured by the plate itself, in µm p-p."""
    if readback.kind != "measured" or readback.level is None:
        raise UserError(
            "plate '{plate_name}' does not measure its vibration; use --prompt or --csv",
            plate_name=plate.name,
        )
    return readback.level


def prompted(plate: PlateDriver, drive: str) -> float | None:
    """Ask the operator for a vibrometer reading in µm p-p, and keep the plate alive meanwhile.

    Returns None if the operator asks to repeat the previous point.

    Raises
    ------
    UserError
        If standard input has ended.
    PlateFault
        If the plate fails while waiting, for example because it was silenced.
    """

    def alive() -> None:
        plate.check()
        plate.read_back()

    while True:
        try:
            line = typed(f"{drive}: type the vibrometer's reading in µm peak to peak: ", alive)
        except EOFError:
            raise UserError(
                "--prompt: the input ended before the last reading; nothing was written"
            ) from None
        reading = _reading(line)
        if reading is not None or line.strip() == BACK:
            return reading
        print(
            f"'{line}' is not a reading; expected a reading in µm, 0 or more, or {BACK} for the "
            "previous point"
        )


def _reading(text: str) -> float | None:
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        return None
    return value if math.isfinite(value) and value >= 0 else None


COMMANDS = {"calibrate": (add_arguments, run)}
