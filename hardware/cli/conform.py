"""Implement `slipscale plate conform`."""

from __future__ import annotations

import json
import os
from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from typing import TYPE_CHECKING

from slipscale.faults import ANSWER_IS_NO, DONE, UserError
from slipscale.faults.message import AS_DATA, output

if TYPE_CHECKING:
    from slipscale.hardware.conformance.bench import Bench
    from slipscale.hardware.conformance.table import Verdict


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `slipscale plate conform`."""
    parser.add_argument(
        "plate",
        metavar="SPEC",
        nargs="?",
        help="serial:PORT, or the SPEC of another backend; the plate will vibrate (default: the "
        "laboratory folder's plate)",
    )
    parser.add_argument(
        "--guided",
        action="store_true",
        help="continue with manual steps that require a loaded plate and a second instrument "
        "(driver boards only)",
    )
    parser.add_argument(
        "--long",
        action="store_true",
        help="also check the maximum on-time (driver boards only); this check alone takes 600 s",
    )
    parser.add_argument(
        "--accept-unproved",
        action="store_true",
        help="exit with 0 even if rules were not proved because --guided or --long is missing",
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.set_defaults(of_folder=str)


def run(arguments: Namespace) -> int:
    """Check that a board follows the serial protocol, or another backend the driver's rules."""
    spec = arguments.plate or ""
    backend, _, address = spec.partition(":")
    if not backend:
        raise UserError("plate conform: expected a SPEC; slipscale plate list shows the ports")
    if backend == "serial":
        port = address.partition(",")[0]  # Calibration and limits are not part of the protocol.
        if not port:
            raise UserError(
                "plate conform: expected serial:PORT; slipscale plate list shows the ports"
            )
        with _bench(port, long=arguments.long) as bench:
            return _told(_board(bench, guided=arguments.guided), arguments)
    if arguments.guided or arguments.long:
        raise UserError(
            "plate conform: --guided and --long apply only to driver boards (serial:PORT)"
        )
    return _told(_backend(spec), arguments)


@contextmanager
def _bench(port: str, *, long: bool) -> Iterator[Bench]:
    from slipscale.hardware.backends.serial_board import protocol as wire
    from slipscale.hardware.backends.serial_board.host import SystemHost
    from slipscale.hardware.conformance.bench import Bench
    from slipscale.hardware.errors import PlateFault
    from slipscale.hardware.signals import signals_raise

    host = SystemHost()
    line = host.open_line(port)
    try:
        with signals_raise():
            yield Bench(line, host, long=long)
    finally:
        with suppress(PlateFault):
            line.write(wire.STOP)
        line.close()


def _board(bench: Bench, *, guided: bool) -> Iterator[Verdict]:
    from slipscale.hardware.conformance.guided import Terminal, guide, unguided
    from slipscale.hardware.conformance.table import examine

    yield from examine(bench)
    yield from guide(bench, Terminal(bench)) if guided else unguided()


def _backend(spec: str) -> Iterator[Verdict]:
    from slipscale.hardware.address import without_session_watchdog
    from slipscale.hardware.clock import SystemClock
    from slipscale.hardware.conformance.contract import Rig, examine_backend
    from slipscale.hardware.registry import open_plate
    from slipscale.hardware.signals import silent_on_signals

    clock = SystemClock()
    plate = open_plate(without_session_watchdog(spec), clock=clock)
    with silent_on_signals(plate):
        yield from examine_backend(Rig(plate, clock))


def _told(verdicts: Iterable[Verdict], arguments: Namespace) -> int:
    lines = []
    for verdict in verdicts:
        lines.append(verdict)
        if AS_DATA in os.environ:
            texts = output(verdict.rule), output(verdict.detail)
            print(json.dumps([verdict.outcome, *texts]), flush=True)
        elif not arguments.json:
            detail = f": {verdict.detail}" if verdict.detail else ""
            print(f"{verdict.outcome:<15} {verdict.rule}{detail}", flush=True)
    departs = sum(each.outcome == "departs" for each in lines)
    unproved = sum(each.outcome == "not proved" for each in lines)
    if arguments.json:
        print(json.dumps([asdict(each) for each in lines], indent=2))
    else:
        print(f"{len(lines)} rules, {departs} violated, {unproved} not proved")
    return ANSWER_IS_NO if departs or (unproved and not arguments.accept_unproved) else DONE


COMMANDS = {"conform": (add_arguments, run)}
