"""Implement `slipscale plate emulate`."""

from __future__ import annotations

import tempfile
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from slipscale.faults import DONE, UserError
from slipscale.hardware.backends.fault_injection import parse_injections
from slipscale.hardware.backends.serial_board.protocol import BoardLimits
from slipscale.hardware.emulator.generators import MAKES
from slipscale.hardware.emulator.response_faults import EMULATED_ONLY, FAULT_NAMES, PHASES

if TYPE_CHECKING:
    from ctypes import CDLL

    from slipscale.hardware.backends.fault_injection import Injection
    from slipscale.hardware.clock import Clock
    from slipscale.hardware.emulator.emulator import Emulator, Plug

SHOWN_S = 0.05


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `slipscale plate emulate`."""
    parser.add_argument(
        "--fault",
        action="append",
        default=[],
        metavar="NAME[@PHASE/N]",
        help=f"inject a fault at the N-th command (of a phase: {', '.join(PHASES)}); may be "
        "repeated. "
        f"NAME is one of: {', '.join(FAULT_NAMES)}",
    )
    parser.add_argument(
        "--generator",
        choices=sorted(MAKES),
        help="simulate a function generator instead of a board: print its RESOURCE for "
        "scpi:RESOURCE, and the plate's voltage whenever it changes",
    )
    parser.add_argument(
        "--seed", type=int, default=0, help=("random seed of the simulated plate (default: 0)")
    )
    parser.add_argument(
        "--finger",
        action="store_true",
        help="simulate a finger that rests on the plate and lowers the plate's Q from 60 to 50",
    )
    parser.add_argument(
        "--gain",
        type=float,
        metavar="UM_PER_V",
        help="gain of the simulated plate without a finger, µm peak to peak per volt peak "
        "(default: 2.3/15, the paper's)",
    )
    parser.add_argument(
        "--plate",
        type=Path,
        metavar="FILE",
        help="plate file that sets the unit and the maximum level of the emulated board, e.g. in "
        "V (default: 2.5 µm peak to peak)",
    )
    parser.add_argument(
        "--noise",
        type=float,
        default=0.005,
        metavar="UM",
        help="standard deviation of the vibration sensor's readings in µm (default: 0.005)",
    )
    parser.add_argument(
        "--sensor",
        type=float,
        default=1.0,
        metavar="FACTOR",
        help="ratio of the vibration sensor's reading to the true amplitude; 0.5 or 0 for a "
        "broken sensor (default: 1)",
    )
    parser.add_argument(
        "--firmware",
        action="store_true",
        help="instead of emulating a board, compile the reference firmware with this computer's "
        "C++ compiler and run it",
    )
    parser.add_argument(
        "--back-after",
        type=float,
        default=0.3,
        metavar="SECONDS",
        help="time after which an unplugged, busy, unresponsive or overheated board recovers, in "
        "seconds (default: 0.3; 0: never)",
    )
    parser.add_argument(
        "--watchdog",
        type=float,
        default=500.0,
        metavar="MS",
        help="time without a command after which the board switches the plate off, in ms: 400 to "
        "2000 (default: 500)",
    )
    parser.add_argument(
        "--no-dtr",
        action="store_true",
        help="do not restart the board when the host closes the port; only the watchdog then "
        "switches the plate off",
    )
    parser.add_argument(
        "--log",
        type=Path,
        metavar="FILE",
        help="record the state of the simulated plate in a new CSV file, one line per millisecond",
    )


def run(arguments: Namespace) -> int:
    """Emulate a board or a generator until interrupted."""
    if arguments.generator and arguments.log:
        raise UserError("--log: records boards only; a generator prints what it receives")
    if arguments.generator:
        return _serve_generator(arguments.generator)
    try:
        from slipscale.hardware.emulator import pty
    except ImportError:
        raise UserError(
            "plate emulate requires pseudo-terminals, which exist only on Linux and macOS"
        ) from None
    from slipscale.hardware.clock import SystemClock
    from slipscale.hardware.emulator import compiled, console
    from slipscale.hardware.signals import EndedBySignal, signals_raise

    terminal = pty.PseudoTerminal()
    with ExitStack() as stack:
        stack.callback(terminal.close)

        def firmware() -> CDLL:
            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="slipscale-firmware-"))
            return compiled.load(compiled.build(Path(folder)))

        log = stack.enter_context(_log(arguments.log)) if arguments.log else None
        emulator = emulated(arguments, terminal, clock=SystemClock(), firmware=firmware, log=log)
        try:
            with signals_raise():
                console.run(emulator, terminal)
        except EndedBySignal:
            pass  # Users stop the emulator with a signal, such as Ctrl-C.
    return DONE


def emulated(
    arguments: Namespace,
    plug: Plug,
    *,
    clock: Clock,
    firmware: Callable[[], CDLL],
    log: TextIO | None,
) -> Emulator:
    """Return the emulated board that the command's arguments describe, and plug it in.

    ``firmware`` returns the library for ``--firmware``. Raises `UserError`.
    """
    from slipscale.hardware.emulator import compiled, console
    from slipscale.hardware.emulator.emulator import BoardMake, Emulator
    from slipscale.hardware.plate.dynamics import NO_FINGER, Resonator
    from slipscale.hardware.plate.twin import Twin

    _check_numbers(arguments)
    orders, (limits, unit) = _orders(arguments), _made_by(arguments)
    resonator = Resonator()
    if arguments.gain is not None:
        resonator = replace(resonator, gain_um_pp_per_v=arguments.gain)
    return Emulator(
        plug,
        clock=clock,
        make=BoardMake(
            back_s=arguments.back_after,
            dtr=not arguments.no_dtr,
            firmware=partial(compiled.CompiledBoard, code=firmware())
            if arguments.firmware
            else None,
            limits=replace(limits, watchdog_ms=arguments.watchdog),
            unit=unit,
        ),
        injections=orders,
        twin=Twin(
            seed=arguments.seed,
            resonator=resonator,
            noise_um=arguments.noise,
            sensor=arguments.sensor,
            finger=console.FINGER if arguments.finger else NO_FINGER,
        ),
        log=log,
    )


def _orders(arguments: Namespace) -> list[Injection]:
    """Return the faults to inject. Raises `UserError`."""
    parse = partial(parse_injections, faults=FAULT_NAMES, phases=PHASES)
    try:
        orders = [each for text in arguments.fault for each in parse(text)]
    except ValueError as error:
        raise UserError("--fault: {error}", error=error) from None
    only_emulated = {each.fault for each in orders} & set(EMULATED_ONLY)
    if arguments.firmware and only_emulated:
        raise UserError(
            "--fault: {options}: the reference firmware has no such fault; omit --firmware",
            options=", ".join(sorted(only_emulated)),
        )
    return orders


def _log(path: Path) -> TextIO:
    try:
        return path.open("x", encoding="utf-8")
    except OSError as error:
        raise UserError("--log: {path}: {reason}", path=path, reason=error.strerror) from None


def _serve_generator(make: str) -> int:
    """Serve a simulated generator, and print the voltages that its outputs would apply."""
    from slipscale.hardware.emulator.generator_server import GeneratorServer
    from slipscale.hardware.signals import EndedBySignal, signals_raise

    status: dict[int, float] = {}
    try:
        with signals_raise(), GeneratorServer(make) as server:
            print(server.resource, flush=True)
            while True:
                for number, channel in server.generator.channel.items():
                    vpp = channel.plate_vpp()
                    if vpp != status.setdefault(number, 0.0):
                        print(f"output {number}: {vpp:.4f} V peak to peak", flush=True)
                        status[number] = vpp
                time.sleep(SHOWN_S)
    except EndedBySignal:
        pass  # Users stop the emulator with a signal, such as Ctrl-C.
    return DONE


def _made_by(arguments: Namespace) -> tuple[BoardLimits, str]:
    """Return the limits and unit of the emulated board. Raises UserError."""
    from slipscale.hardware.backends.serial_board.protocol import UNIT, BoardLimits
    from slipscale.hardware.plate_file import read_plate

    if arguments.plate is None:
        return BoardLimits(), UNIT
    if arguments.firmware:
        raise UserError(
            "--plate: the reference firmware supports only µm peak to peak; omit --firmware"
        )
    limits = read_plate(arguments.plate).plate_limits()
    return BoardLimits(level=limits.level, on_time_s=limits.on_time_s), limits.quantity.suffix


def _check_numbers(arguments: Namespace) -> None:
    """Raise `UserError` if the noise, sensor factor or watchdog time is invalid."""
    from slipscale.hardware.backends.serial_board.protocol import WATCHDOG_MS

    if not (isfinite(arguments.noise) and arguments.noise >= 0):
        raise UserError("--noise: {noise:g}, expected 0 or more µm", noise=arguments.noise)
    if not (isfinite(arguments.sensor) and arguments.sensor >= 0):
        raise UserError(
            "--sensor: {sensor:g}, expected a factor of 0 or more", sensor=arguments.sensor
        )
    shortest_ms, longest_ms = WATCHDOG_MS
    if not shortest_ms <= arguments.watchdog <= longest_ms:
        raise UserError(
            "--watchdog: {watchdog_ms:g}, expected {shortest_ms} to {longest_ms} ms",
            watchdog_ms=arguments.watchdog,
            shortest_ms=shortest_ms,
            longest_ms=longest_ms,
        )


COMMANDS = {"emulate": (add_arguments, run)}
