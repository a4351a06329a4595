"""`slipscale plate emulate`."""

from __future__ import annotations

from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from faults import DONE, UserError
from hardware.emulator.response_faults import FAULT_NAMES, PHASES
from hardware.fault_injection import parse_injections

if TYPE_CHECKING:
    from argparse import ArgumentParser, Namespace


def add_arguments(parser: ArgumentParser) -> None:
    """Fill the parser."""
    parser.add_argument(
        "--fault",
        action="append",
        default=[],
        metavar="NAME[@PHASE/N]",
        help=f"misbehave at the N-th command (of a phase: {', '.join(PHASES)}); may be repeated. "
        f"NAME is one of: {', '.join(FAULT_NAMES)}",
    )
    parser.add_argument("--seed", type=int, default=0, help="of the simulated plate (default 0)")
    parser.add_argument(
        "--back-after",
        type=float,
        default=0.3,
        metavar="SECONDS",
        help="an unplugged, stuck, deaf or hot board comes back after so long "
        "(default 0.3; 0: never)",
    )
    parser.add_argument(
        "--no-dtr",
        action="store_true",
        help="the line does not tell the board that the host let go: its watchdog has to notice",
    )
    parser.add_argument(
        "--log",
        type=Path,
        metavar="FILE",
        help="write what the simulated plate does, a line a millisecond: a new CSV file",
    )


def run(arguments: Namespace) -> int:
    """Emulate until told to end."""
    parse = partial(parse_injections, faults=FAULT_NAMES, phases=PHASES)
    try:
        orders = [each for text in arguments.fault for each in parse(text)]
    except ValueError as error:
        raise UserError(f"--fault: {error}") from None
    try:
        import tty  # noqa: F401, PLC0415 - there are no pseudo-terminals without it
    except ImportError:
        raise UserError("plate emulate needs pseudo-terminals: Linux or macOS") from None
    from hardware.clock import SystemClock  # noqa: PLC0415
    from hardware.emulator import console, pty  # noqa: PLC0415
    from hardware.plate.twin import Twin  # noqa: PLC0415
    from hardware.signals import EndedBySignal, signals_raise  # noqa: PLC0415

    with ExitStack() as stack:
        log = None
        if arguments.log:
            try:
                log = stack.enter_context(arguments.log.open("x", encoding="utf-8"))
            except OSError as error:
                raise UserError(f"--log: {arguments.log}: {error.strerror}") from None
        emulator = pty.Emulator(
            clock=SystemClock(),
            injections=orders,
            twin=Twin(seed=arguments.seed),
            back_s=arguments.back_after,
            dtr=not arguments.no_dtr,
            log=log,
        )
        try:
            with signals_raise():
                console.run(emulator)
        except EndedBySignal:
            pass  # the usual way to end it
    return DONE


COMMANDS = {"emulate": (add_arguments, run)}
