"""Implement `slipscale plate watch`."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator
from typing import TYPE_CHECKING

from slipscale.faults import DONE, UserError
from slipscale.hardware.address import positive_number

if TYPE_CHECKING:
    from slipscale.hardware.clock import Clock
    from slipscale.hardware.driver import PlateDriver
    from slipscale.hardware.records import Readback

LOOKS_S = 0.02  # interval between two checks of the plate, as in a session
COLUMNS = 60  # width of the plot


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `slipscale plate watch`."""
    parser.add_argument(
        "plate",
        metavar="SPEC",
        nargs="?",
        help="SPEC of the plate, such as mock or serial:PORT (default: the laboratory folder's "
        "plate)",
    )
    parser.set_defaults(of_folder=str)
    parser.add_argument(
        "--amplitude",
        type=float,
        default=1.0,
        metavar="UM",
        help="level to present, in µm peak to peak or the plate's unit; the plate will vibrate "
        "(default: 1)",
    )
    parser.add_argument(
        "--seconds",
        type=positive_number,
        metavar="S",
        help="stop after this time, in seconds (default: run until Ctrl-C)",
    )
    parser.add_argument(
        "--every",
        type=positive_number,
        default=0.1,
        metavar="S",
        help="time between successive lines, in seconds (default: 0.1)",
    )


def run(arguments: Namespace) -> int:
    """Present an amplitude, and print one line per readback until interrupted."""
    from slipscale.hardware.clock import SystemClock
    from slipscale.hardware.registry import open_plate
    from slipscale.hardware.signals import silent_on_signals
    from slipscale.stimuli.surface import VirtualSurface

    if arguments.plate is None:
        raise UserError("plate watch: expected the plate's SPEC, such as mock or serial:PORT")
    clock = SystemClock()
    plate = open_plate(arguments.plate, clock=clock)
    scale_level, quantity = plate.limits.level, plate.limits.quantity
    if not 0 <= arguments.amplitude <= scale_level:
        raise UserError(
            "--amplitude: {amplitude:g}, expected 0 to {scale_level:g} {unit_in_full}",
            amplitude=arguments.amplitude,
            scale_level=scale_level,
            unit_in_full=quantity.unit_in_full,
        )
    with silent_on_signals(plate), plate:
        plate.present(VirtualSurface(level=arguments.amplitude))
        begun_s = clock.now()
        unit, scale = f"{quantity.unit_in_short:<6}", f"{scale_level:g}"
        print(f"time s   {unit}   0{scale:>{COLUMNS}}  | commanded  # readback")
        try:
            for readback in readbacks(plate, clock, arguments.every, arguments.seconds):
                time_s = clock.now() - begun_s
                print(line(readback, time_s, arguments.amplitude, scale_level))
                sys.stdout.flush()
        except KeyboardInterrupt:
            pass  # Users stop the command with a signal, such as Ctrl-C.
    return DONE


def readbacks(
    plate: PlateDriver, clock: Clock, every_s: float, duration_s: float | None
) -> Iterator[Readback]:
    """Yield readbacks at regular intervals, checking the plate in between as in a session."""
    begun_s = due_s = clock.now()
    while duration_s is None or clock.now() - begun_s < duration_s:
        plate.check()
        if clock.now() >= due_s:
            due_s += every_s
            yield plate.read_back()
        clock.sleep(min(LOOKS_S, every_s))


def line(readback: Readback, time_s: float, commanded_level: float, scale_level: float) -> str:
    """Format a readback as one line of the text plot.

    >>> from slipscale.hardware.records import Readback
    >>> half = Readback(level=1.25, kind="measured", time_s=0.0)
    >>> line(half, 3.0, 1.25, 2.5)
    '   3.0    1.250   ##############################|                               measured'
    """
    if readback.level is None:
        return f"{time_s:6.1f}      n/a   {'':{COLUMNS + 1}}  {readback.kind}"
    filled = round(COLUMNS * min(readback.level / scale_level, 1.0))
    cells = list("#" * filled + " " * (COLUMNS + 1 - filled))
    cells[round(COLUMNS * commanded_level / scale_level)] = "|"
    return f"{time_s:6.1f}   {readback.level:6.3f}   {''.join(cells)}  {readback.kind}"


COMMANDS = {"watch": (add_arguments, run)}
