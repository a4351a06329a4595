"""`slipscale plate conform SPEC`."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import asdict
from typing import TYPE_CHECKING

from slipscale.faults import ANSWER_IS_NO, DONE, UserError

if TYPE_CHECKING:
    from argparse import ArgumentParser, Namespace


def add_arguments(parser: ArgumentParser) -> None:
    """Fill the parser."""
    parser.add_argument(
        "plate",
        metavar="SPEC",
        nargs="?",
        help="serial:PORT; the plate will vibrate (default: the laboratory folder's)",
    )
    parser.add_argument("--json", action="store_true", help="for programs")
    # The port alone: a calibration and limits are nothing to the protocol.
    parser.set_defaults(of_folder=lambda spec: spec.partition(",")[0])


def run(arguments: Namespace) -> int:
    """Check the board against every rule of its protocol; print what it makes of each."""
    spec = arguments.plate or ""
    backend, _, port = spec.partition(":")
    if backend != "serial" or not port or "," in port:
        raise UserError(
            f"plate conform: '{spec}', expected serial:PORT; slipscale plate list shows ports"
        )
    from slipscale.hardware.backends.serial_board import protocol as wire  # noqa: PLC0415 - loads pyserial
    from slipscale.hardware.backends.serial_board.serial_line import SerialLine  # noqa: PLC0415
    from slipscale.hardware.clock import SystemClock  # noqa: PLC0415
    from slipscale.hardware.conformance.bench import Bench  # noqa: PLC0415
    from slipscale.hardware.conformance.table import examine  # noqa: PLC0415
    from slipscale.hardware.errors import PlateFault  # noqa: PLC0415
    from slipscale.hardware.signals import signals_raise  # noqa: PLC0415

    line = SerialLine(port)
    verdicts = []
    try:
        with signals_raise():
            for verdict in examine(Bench(line, SystemClock())):
                verdicts.append(verdict)
                if not arguments.json:
                    detail = f": {verdict.detail}" if verdict.detail else ""
                    print(f"{verdict.outcome:<15} {verdict.rule}{detail}", flush=True)
    finally:
        with suppress(PlateFault):
            line.write(wire.STOP)
        line.close()
    if arguments.json:
        print(json.dumps([asdict(each) for each in verdicts], indent=2))
    departs = sum(each.outcome == "departs" for each in verdicts)
    if not arguments.json:
        print(f"{len(verdicts)} rules, the board departs from {departs}")
    return ANSWER_IS_NO if departs else DONE


COMMANDS = {"conform": (add_arguments, run)}
