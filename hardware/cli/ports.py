"""Implement `slipscale plate list`."""

from __future__ import annotations

import json
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from slipscale.faults import DONE

if TYPE_CHECKING:
    from serial.tools.list_ports_common import ListPortInfo


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `slipscale plate list`."""
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(arguments: Namespace) -> int:
    """Print backends and serial ports."""
    from serial.tools.list_ports import comports

    from slipscale.hardware.registry import backend_names

    found = listing(backend_names(), comports)
    print(json.dumps(found, indent=2) if arguments.json else as_text(found))
    return DONE


def listing(
    backends: Iterable[str], ports: Callable[[], Iterable[ListPortInfo]]
) -> dict[str, list[dict[str, str]]]:
    """Return the names of all backends, and all serial ports with their SPECs."""
    return {
        "backends": [{"name": name} for name in backends],
        "ports": [
            {
                "port": port.device,
                "what": port.description or "",
                "serial_number": port.serial_number or "",
                "spec": f"serial:{port.device}",
            }
            for port in sorted(ports())
        ],
    }


def as_text(found: dict[str, list[dict[str, str]]]) -> str:
    """Format the backends and ports as text."""
    lines = ["backends: " + ", ".join(each["name"] for each in found["backends"])]
    width = max((len(port["spec"]) for port in found["ports"]), default=0)
    lines += [
        f"--plate {port['spec']:<{width}}  {port['what']} {port['serial_number']}".rstrip()
        for port in found["ports"]
    ]
    if not found["ports"]:
        lines.append(
            "no serial ports; plug the board in, or try slipscale plate emulate "
            "(pseudo-terminals are not listed)"
        )
    return "\n".join(lines)


COMMANDS = {"list": (add_arguments, run)}
