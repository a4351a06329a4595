"""Implement `slipscale plate new` and `slipscale plate sign`."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from datetime import UTC, datetime
from pathlib import Path

from slipscale.faults import DONE, UserError
from slipscale.faults.suggestions import expected_one_of
from slipscale.faults.validation import in_words


def add_new(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale plate new``."""
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="new TOML file to write, such as plates/NAME.toml"
    )
    parser.add_argument(
        "--backend", required=True, help=("backend that drives the plate: serial, scpi, ...")
    )
    parser.add_argument("--serial", default="", help="serial number of the plate itself")
    parser.add_argument(
        "--device-serial",
        default="",
        help=("serial number of the board or generator, as printed by slipscale check"),
    )
    parser.add_argument(
        "--amplifier-gain",
        type=float,
        metavar="G",
        help="gain of the amplifier, for scpi; peak voltage at full scale, for sound",
    )


def new(arguments: Namespace) -> int:
    """Create a plate file with the default limits."""
    from pydantic import ValidationError

    from slipscale.hardware.plate_file import SUFFIX, Identity, Wiring, new_plate
    from slipscale.hardware.registry import backend_names

    path: Path = arguments.file
    if path.suffix != SUFFIX:
        raise UserError("{path}: expected a name that ends in {suffix}", path=path, suffix=SUFFIX)
    if arguments.backend not in backend_names():
        known = expected_one_of(arguments.backend, backend_names())
        raise UserError(
            "--backend {backend}: {expected}", backend=arguments.backend, expected=known
        )
    try:
        identity = Identity(
            name=path.stem, serial=arguments.serial, device_serial=arguments.device_serial
        )
        wiring = Wiring(backend=arguments.backend, amplifier_gain=arguments.amplifier_gain)
    except ValidationError as error:
        raise UserError("{path}: {faults}", path=path, faults=in_words(error)) from None
    path.parent.mkdir(parents=True, exist_ok=True)
    new_plate(identity, wiring, path)
    print(f"wrote {path}; use it with --plate {arguments.backend}:...,plate={path}")
    return DONE


def add_sign(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale plate sign``."""
    parser.add_argument("file", type=Path, metavar="FILE", help="plate file to sign")
    parser.add_argument(
        "--beyond-shipped-limits",
        action="store_true",
        help="acknowledge limits that are wider than the shipped ones",
    )
    parser.add_argument(
        "--by",
        default="",
        metavar="NAME",
        help="with --beyond-shipped-limits: name of the person responsible for these limits",
    )


def sign(arguments: Namespace) -> int:
    """Update the checksum of a plate file after a change."""
    from slipscale.hardware import plate_file

    if arguments.beyond_shipped_limits != bool(arguments.by):
        raise UserError("--beyond-shipped-limits and --by NAME must be given together")
    today = datetime.now(tz=UTC).date()
    beyond = plate_file.sign(arguments.file, beyond_by=arguments.by, today=today)
    remarks = "".join(
        f"\nbeyond the shipped limits: {name} = {value:g}" for name, value in beyond.items()
    )
    print(f"signed {arguments.file}{remarks}")
    return DONE


COMMANDS = {"new": (add_new, new), "sign": (add_sign, sign)}
