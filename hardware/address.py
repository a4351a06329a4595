"""Parse plate addresses: the part of a SPEC after the backend's name.

An address has the form ``PORT,key=value,key=value``: a port or resource, which may be empty, and
options. Each backend defines its options as a mapping from names to converters.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipscale.faults import UserError
from slipscale.hardware.limits import PlateLimits

if TYPE_CHECKING:
    from slipscale.hardware.calibration.record import Calibration
    from slipscale.hardware.plate_file import PlateFile


# For pairs of actuators, see `slipscale.hardware.backends.pair`.
PAIR, SPLIT = "pair:", "+"


def parts(spec: str) -> tuple[str, ...]:
    """Return both SPECs of a pair of actuators, or the given SPEC for a single plate.

    >>> parts("pair:serial:COM3,plate=desk+mock"), parts("mock")
    (('serial:COM3,plate=desk', 'mock'), ('mock',))
    """
    return tuple(spec.removeprefix(PAIR).split(SPLIT)) if spec.startswith(PAIR) else (spec,)


def is_mock(spec: str) -> bool:
    """Return whether a plate is simulated, in which case a finger would feel nothing.

    >>> is_mock("mock:q=50"), is_mock("pair:mock+mock"), is_mock("pair:serial:COM3+mock")
    (True, True, False)
    """
    return all(each.partition(":")[0] == "mock" for each in parts(spec))


def split_address(
    address: str, converters: Mapping[str, Callable[[str], object]], *, what: str = "plate address"
) -> tuple[str, dict[str, Any]]:
    """Split an address into port and options; ``what`` names the address in error messages.

    Raises
    ------
    UserError
        If an option is unknown or given twice, or if its value is invalid.

    Examples
    --------
    >>> split_address("/dev/ttyACM0,limit=2", {"limit": number})
    ('/dev/ttyACM0', {'limit': 2.0})
    """
    words = address.split(",")
    target = "" if "=" in words[0] else words.pop(0)
    options: dict[str, object] = {}
    for word in words:
        key, equals, text = word.partition("=")
        if not equals or key not in converters or key in options:
            known = ", ".join(f"{name}=..." for name in sorted(converters)) or "none"
            raise UserError(
                "{what} '{address}': '{word}' is not an option; known options: {known}",
                what=what,
                address=address,
                word=word,
                known=known,
            )
        try:
            options[key] = converters[key](text)
        except ValueError as error:
            raise UserError(
                "{what} '{address}': {key} is '{text}', {error}",
                what=what,
                address=address,
                key=key,
                text=text,
                error=error,
            ) from None
    return target, options


def number(text: str) -> float:
    """Parse a finite number; otherwise, raise ValueError with the expected format."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError("expected a number")
    return value


def number_from_0(text: str) -> float:
    """Parse a number of 0 or more; otherwise, raise ValueError with the expected format."""
    value = number(text)
    if value < 0:
        raise ValueError("expected a number, 0 or more")
    return value


def positive_number(text: str) -> float:
    """Parse a number above 0; otherwise, raise ValueError with the expected format."""
    value = number(text)
    if value <= 0:
        raise ValueError("expected a number above 0")
    return value


def calibration(text: str) -> Calibration:
    """Read a calibration file. Raises UserError."""
    from slipscale.hardware.calibration.stored import read_calibration

    return read_calibration(Path(text))


@dataclass(frozen=True, slots=True, kw_only=True)
class Plate:
    """Limits, calibration and plate file of the plate in an address."""

    limits: PlateLimits = field(default_factory=PlateLimits)
    calibration: Calibration | None = None
    file: PlateFile | None = None


DEFAULT_PLATE = Plate()


def plate_file(text: str) -> tuple[PlateFile, Calibration | None]:
    """Read a plate file by path or by its name in the folder ``plates``. Raises UserError."""
    from slipscale.hardware.plate_file import open_plate_file, path_of

    return open_plate_file(path_of(text, Path()))


def plate_of(options: Mapping[str, Any], *, backend: str, simulated: bool = False) -> Plate:
    """Return the plate defined by the options ``plate`` and ``calibration``.

    A simulated plate accepts the plate file of any backend.

    Raises
    ------
    UserError
        If the plate file is for another backend, if two different calibrations are given, or if the
        calibration is not plausible.
    """
    file, own = options.get("plate", (None, None))
    given: Calibration | None = options.get("calibration")
    if file is None:
        if given and (faults := implausible_alone(given)):
            raise UserError(
                "plate '{backend}': the calibration is not plausible: {faults}",
                backend=backend,
                faults=faults,
            )
        return Plate(calibration=given)
    if file.wiring.backend != backend and not simulated:
        raise UserError(
            "plate '{backend}': the plate file of '{identity_name}' is for backend "
            "'{wiring_backend}'",
            backend=backend,
            identity_name=file.identity.name,
            wiring_backend=file.wiring.backend,
        )
    if given and own and given != own:
        raise UserError(
            "plate '{backend}': the SPEC and the plate file of '{identity_name}' name different "
            "calibrations; name only one",
            backend=backend,
            identity_name=file.identity.name,
        )
    if given and (faults := file.implausible(given)):
        raise UserError(
            "plate '{backend}': the calibration does not belong to this plate: {faults}",
            backend=backend,
            faults="; ".join(faults),
        )
    return Plate(limits=file.plate_limits(), calibration=given or own, file=file)


def opened(
    address: str,
    backend: str,
    options: Mapping[str, Callable[[str], Any]] | None = None,
    *,
    simulated: bool = False,
) -> tuple[str, dict[str, Any], Plate]:
    """Parse a backend's address into port, options and plate.

    Every backend has the options ``calibration`` and ``plate``. ``options`` maps the names of
    additional options to converters.

    Raises
    ------
    UserError
        See `split_address` and `plate_of`.
    """
    known = {"calibration": calibration, "plate": plate_file, **(options or {})}
    target, found = split_address(address, known)
    return target, found, plate_of(found, backend=backend, simulated=simulated)


def implausible_alone(calibration: Calibration) -> str:
    """Describe the implausible values in a calibration that has no plate file."""
    from slipscale.hardware.calibration.soundness import implausible

    return "; ".join(implausible(calibration, {}))


def plate_file_of(spec: str) -> PlateFile | None:
    """Read the plate file that a SPEC names, if any. Raises UserError if reading fails."""
    from slipscale.hardware.plate_file import path_of, read_plate

    named = _plates_in(spec)
    return read_plate(path_of(named[0], Path())) if named else None


def _plates_in(spec: str) -> list[str]:
    words = parts(spec)[0].partition(":")[2].split(",")
    return [word.removeprefix("plate=") for word in words if word.startswith("plate=")]


def with_plate_file(spec: str, wanted: str) -> str:
    """Add a study's plate file to a SPEC; for a pair, to the first actuator's SPEC.

    Raises
    ------
    UserError
        If the SPEC names a different plate file.

    Examples
    --------
    >>> with_plate_file("serial:COM3", "desk"), with_plate_file("mock", "desk")
    ('serial:COM3,plate=desk', 'mock:plate=desk')
    >>> with_plate_file("mock:plate=desk,q=50", "desk"), with_plate_file("mock", "")
    ('mock:plate=desk,q=50', 'mock')
    """
    if not wanted:
        return spec
    if spec.startswith(PAIR):
        first, *second = parts(spec)
        return PAIR + SPLIT.join([with_plate_file(first, wanted), *second])
    backend, _, address = spec.partition(":")
    named = _plates_in(spec)
    if not named:
        return f"{backend}:{address},plate={wanted}" if address else f"{backend}:plate={wanted}"
    if named != [wanted]:
        raise UserError(
            "plate '{spec}': the study is for plate '{wanted}', not '{given_plate}'",
            spec=spec,
            wanted=wanted,
            given_plate=named[0],
        )
    return spec


def without_session_watchdog(spec: str) -> str:
    """Disable the session watchdog, which silences a plate that the session does not check.

    The session watchdog must be disabled for scripts that do not check the plate regularly, and for
    calibrations in which a person reads an instrument.

    >>> without_session_watchdog("serial:COM3")
    'serial:COM3,attention=0'
    >>> without_session_watchdog("serial:COM3,attention=9"), without_session_watchdog("mock")
    ('serial:COM3,attention=9', 'mock')
    >>> without_session_watchdog("pair:scpi:COM4+mock")
    'pair:scpi:COM4,attention=0+mock'
    >>> without_session_watchdog("sound:3,full_scale=20")
    'sound:3,full_scale=20,attention=0'
    """
    if spec.startswith(PAIR):
        return PAIR + SPLIT.join(map(without_session_watchdog, parts(spec)))
    watched = spec.startswith(("serial:", "sound:", "scpi:", "daq:"))
    return f"{spec},attention=0" if watched and "attention=" not in spec else spec
