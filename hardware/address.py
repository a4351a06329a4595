"""Addresses of plates: what follows the backend's name in a SPEC.

``PORT,key=value,key=value``: a port or resource (may be empty), then options. Which options there
are is the backend's business: it hands in a table of names and converters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipscale.faults import UserError
from slipscale.hardware.limits import PlateLimits

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from slipscale.hardware.calibration.record import Calibration
    from slipscale.hardware.plate_file import PlateFile


def split_address(
    address: str, converters: Mapping[str, Callable[[str], Any]], *, what: str = "plate address"
) -> tuple[str, dict[str, Any]]:
    """Return the port and the converted options of an address; ``what`` names it in messages.

    Raises
    ------
    UserError
        An option is unknown, twice there, or its value cannot be read.

    Examples
    --------
    >>> split_address("/dev/ttyACM0,limit=2", {"limit": number})
    ('/dev/ttyACM0', {'limit': 2.0})
    """
    words = address.split(",")
    target = "" if "=" in words[0] else words.pop(0)
    options: dict[str, Any] = {}
    for word in words:
        key, equals, text = word.partition("=")
        if not equals or key not in converters or key in options:
            known = ", ".join(f"{name}=..." for name in sorted(converters)) or "none"
            raise UserError(
                f"{what} '{address}': '{word}' is not an option of its own; known: {known}"
            )
        try:
            options[key] = converters[key](text)
        except ValueError as error:
            raise UserError(f"{what} '{address}': {key} is '{text}', {error}") from None
    return target, options


def number(text: str) -> float:
    """Return a finite number, or raise ValueError that says what was expected."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError("expected a number")
    return value


def positive_number(text: str) -> float:
    """Return a finite number above 0, or raise ValueError that says what was expected."""
    value = number(text)
    if value <= 0:
        raise ValueError("expected a number above 0")
    return value


def calibration(text: str) -> Calibration:
    """Return the calibration in a file. Raises UserError."""
    from slipscale.hardware.calibration.stored import read_calibration  # noqa: PLC0415 - SciPy

    return read_calibration(Path(text))


@dataclass(frozen=True, slots=True, kw_only=True)
class Plate:
    """What an address says of the plate: limits, calibration, and the file they come from."""

    limits: PlateLimits
    calibration: Calibration | None
    file: PlateFile | None


def plate_file(text: str) -> tuple[PlateFile, Calibration | None]:
    """Return the plate in a file, or of a name in the folder ``plates``. Raises UserError."""
    from slipscale.hardware.plate_file import open_plate_file, path_of  # noqa: PLC0415 - pydantic

    return open_plate_file(path_of(text, Path()))


def plate_of(options: Mapping[str, Any], *, backend: str, simulated: bool = False) -> Plate:
    """Return what the options ``plate`` and ``calibration`` say together.

    A simulated plate takes the file of any backend: there a study is rehearsed.

    Raises
    ------
    UserError
        The plate file is for another backend, or does not agree with the calibration.
    """
    file, own = options.get("plate", (None, None))
    given: Calibration | None = options.get("calibration")
    if file is None:
        if given and (faults := implausible_alone(given)):
            raise UserError(f"plate '{backend}': the calibration is not plausible: {faults}")
        return Plate(limits=PlateLimits(), calibration=given, file=None)
    if file.wiring.backend != backend and not simulated:
        raise UserError(
            f"plate '{backend}': the plate file of '{file.identity.name}' is for backend "
            f"'{file.wiring.backend}'"
        )
    if given and own and given != own:
        raise UserError(
            f"plate '{backend}': the plate file of '{file.identity.name}' names another "
            "calibration; give one of them"
        )
    if given and (faults := file.implausible(given)):
        raise UserError(
            f"plate '{backend}': the calibration is not this plate's: {'; '.join(faults)}"
        )
    return Plate(limits=file.plate_limits(), calibration=given or own, file=file)


def opened(
    address: str,
    backend: str,
    options: Mapping[str, Callable[[str], Any]] | None = None,
    *,
    simulated: bool = False,
) -> tuple[str, dict[str, Any], Plate]:
    """Return the target, the options and the plate of a backend's address.

    Every backend has the options ``calibration`` and ``plate``; ``options`` adds its own, as names
    and converters.

    Raises
    ------
    UserError
        As `split_address` and `plate_of`.
    """
    known = {"calibration": calibration, "plate": plate_file, **(options or {})}
    target, found = split_address(address, known)
    return target, found, plate_of(found, backend=backend, simulated=simulated)


def implausible_alone(calibration: Calibration) -> str:
    """Return what is implausible in a calibration without a plate file, or ""."""
    from slipscale.hardware.calibration.soundness import implausible  # noqa: PLC0415 - NumPy

    return "; ".join(implausible(calibration, {}))


def plate_file_of(spec: str) -> PlateFile | None:
    """Return the plate file that a SPEC names, None without one. Raises UserError if unreadable."""
    from slipscale.hardware.plate_file import path_of, read_plate  # noqa: PLC0415 - pydantic

    named = _plates_in(spec)
    return read_plate(path_of(named[0], Path())) if named else None


def _plates_in(spec: str) -> list[str]:
    """Return the plates that a SPEC's options name."""
    words = spec.partition(":")[2].split(",")
    return [word.removeprefix("plate=") for word in words if word.startswith("plate=")]


def with_plate_file(spec: str, wanted: str) -> str:
    """Return a SPEC with the plate file that a study names, if it names one.

    Raises
    ------
    UserError
        The SPEC names another.

    Examples
    --------
    >>> with_plate_file("serial:COM3", "desk"), with_plate_file("mock", "desk")
    ('serial:COM3,plate=desk', 'mock:plate=desk')
    >>> with_plate_file("mock:plate=desk,q=50", "desk"), with_plate_file("mock", "")
    ('mock:plate=desk,q=50', 'mock')
    """
    if not wanted:
        return spec
    backend, _, address = spec.partition(":")
    named = _plates_in(spec)
    if not named:
        return f"{backend}:{address},plate={wanted}" if address else f"{backend}:plate={wanted}"
    if named != [wanted]:
        raise UserError(f"plate '{spec}': the study is for plate '{wanted}', not '{named[0]}'")
    return spec


def without_session_watchdog(spec: str) -> str:
    """Return a SPEC whose backend does not ask whether its session still checks the plate.

    For calibration, where a person reads an instrument meanwhile, and for scripts of others.

    >>> without_session_watchdog("serial:COM3")
    'serial:COM3,attention=0'
    >>> without_session_watchdog("serial:COM3,attention=9"), without_session_watchdog("mock")
    ('serial:COM3,attention=9', 'mock')
    >>> without_session_watchdog("sound:3,full_scale=20")
    'sound:3,full_scale=20,attention=0'
    """
    if spec.startswith(("serial:", "sound:")) and "attention=" not in spec:
        return f"{spec},attention=0"
    return spec
