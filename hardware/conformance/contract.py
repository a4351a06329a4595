"""Test whether a backend fulfils the contract in `slipscale.hardware.driver`.

Plug-in authors run these tests with `slipscale plate conform SPEC`. The plate vibrates during the
tests. The rule for readbacks does not apply to backends whose readbacks are "commanded" or "none".
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from statistics import median
from typing import get_args

from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.hardware.clock import Clock
from slipscale.hardware.conformance.bench import Departure, NotApplicable, differs
from slipscale.hardware.conformance.table import Verdict
from slipscale.hardware.driver import PROVING, PlateDriver
from slipscale.hardware.errors import OverLimit, PlateFault
from slipscale.hardware.records import Output, Readback, ReadbackKind
from slipscale.stimuli.surface import VirtualSurface

CHECKS = 50
CHEAP_S = 0.008  # longest duration of `check`: half a frame at 60 Hz
STEADY_S = 0.2
SHARES = (0.2, 0.5, 0.35)  # test amplitudes, as fractions of the largest amplitude


class Rig:
    """Plate under test and its clock.

    Parameters
    ----------
    plate : PlateDriver
        Driver, not connected.
    clock : Clock
        The computer's clock.
    """

    def __init__(self, plate: PlateDriver, clock: Clock) -> None:
        self.plate = plate
        self.clock = clock

    def surface(self, share: float) -> VirtualSurface:
        """Return a surface whose amplitude is a given fraction of the largest amplitude."""
        return VirtualSurface(level=round(share * self.plate.limits.level, 4))


def _connects_off(rig: Rig) -> None:
    rig.plate.silence()  # This must also work before the plate is connected.
    with rig.plate as plate:
        identity = plate.identity
        if identity is None or not (identity.manufacturer and identity.model):
            differs("an identity with manufacturer and model", str(identity))
        _expect_output(plate, Output.OFF, "connect")
        _expect_off(plate.read_back(), "connect")


def _presents(rig: Rig) -> None:
    with rig.plate as plate:
        for share in SHARES:
            surface = rig.surface(share)
            made = plate.present(surface)
            if made.commanded_level != surface.level:
                differs(f"commanded {surface.level:g}", f"{made.commanded_level:g}")
            if made.readback.kind not in get_args(ReadbackKind):
                differs(
                    Message("a readback of kind {kinds}", kinds=get_args(ReadbackKind)),
                    made.readback.kind,
                )
            _expect_output(plate, Output.MAY_BE_ON, "present")
            rig.clock.sleep(STEADY_S)
            readback = plate.read_back()
            plate.confirm(surface.level, readback)  # A later reading shows that it had settled.


def _readback_proves(rig: Rig) -> None:
    with rig.plate as plate:
        readback = plate.present(rig.surface(0.5)).readback
        if readback.kind not in PROVING or readback.level is None:
            raise NotApplicable(
                Message(
                    "the readback is of kind '{readback_kind}', which cannot reveal a wrong "
                    "amplitude; measure with a vibrometer",
                    readback_kind=readback.kind,
                )
            )


def _zero_is_off(rig: Rig) -> None:
    with rig.plate as plate:
        plate.present(rig.surface(0.5))
        made = plate.present(rig.surface(0))
        _expect_output(plate, Output.OFF, "a level of 0")
        _expect_off(made.readback, "a level of 0")


def _limits_leave_it(rig: Rig) -> None:
    with rig.plate as plate:
        plate.present(rig.surface(0.5))
        before = plate.read_back()
        for wrong in (1.01 * plate.limits.level, math.inf):
            try:
                plate.present(VirtualSurface(level=wrong))
            except (OverLimit, UserError):
                pass
            else:
                differs(
                    Message("{wrong} to be refused", wrong=plate.limits.quantity.short(wrong)),
                    "a presentation",
                )
        _expect_output(plate, Output.MAY_BE_ON, "a refused command")
        if before.kind in PROVING:
            plate.confirm(rig.surface(0.5).level, plate.read_back())


def _silence_repeats(rig: Rig) -> None:
    with rig.plate as plate:
        plate.present(rig.surface(0.5))
        for _ in range(3):
            plate.silence()
            _expect_output(plate, Output.OFF, "silence")
        _expect_off(plate.read_back(), "silence")
    rig.plate.silence()  # This must also work after the plate was closed.
    rig.plate.close()


class _Ends(Exception):
    """Exception that simulates an error in the caller's code."""


def _exception_ends_off(rig: Rig) -> None:
    try:
        with rig.plate as plate:
            plate.present(rig.surface(0.5))
            raise _Ends  # noqa: TRY301 - it concerns how the block is left
    except _Ends:
        pass
    _expect_output(rig.plate, Output.OFF, "an exception inside the with block")


def _closed_is_told(rig: Rig) -> None:
    with rig.plate:
        pass
    for name, command in (
        ("present", lambda: rig.plate.present(rig.surface(0.5))),
        ("read_back", rig.plate.read_back),
    ):
        try:
            command()
        except PlateFault:
            continue
        differs(
            Message("a PlateFault from {name} if the plate is not connected", name=name), "none"
        )


def _reconnects(rig: Rig) -> None:
    for _ in range(2):
        with rig.plate as plate:
            plate.present(rig.surface(0.5))


def _check_is_cheap(rig: Rig) -> None:
    with rig.plate as plate:
        plate.present(rig.surface(0.5))
        took_s = []
        for _ in range(CHECKS):
            begun_s = rig.clock.now()
            plate.check()
            took_s.append(rig.clock.now() - begun_s)
        if median(took_s) > CHEAP_S:
            differs(
                Message("check() to take at most {limit_ms:g} ms", limit_ms=1000 * CHEAP_S),
                f"{1000 * median(took_s):.1f} ms",
            )


def _follows(rig: Rig) -> None:
    if rig.plate.follow_lag_s is None:
        raise NotApplicable("the backend has no follow_lag_s")
    with rig.plate as plate:
        plate.present(rig.surface(0.5))
        plate.follow(rig.surface(0.3).level)
        rig.clock.sleep(STEADY_S)
        readback = plate.read_back()
        if readback.kind in PROVING:
            plate.confirm(rig.surface(0.3).level, readback)


def _expect_output(plate: PlateDriver, due: Output, after: str) -> None:
    if plate.output is not due:
        differs(
            Message("the output to be {due} after {after}", due=due, after=after), str(plate.output)
        )


def _expect_off(readback: Readback, after: str) -> None:
    if readback.voltage_v_peak:
        differs(Message("0 V after {after}", after=after), f"{readback.voltage_v_peak:g} V")
    if readback.kind == "applied" and readback.level:
        differs(
            Message("an amplitude of 0 in the readback after {after}", after=after),
            f"{readback.level:g}",
        )


RULES: tuple[tuple[str, Callable[[Rig], None]], ...] = (
    ("the output is off after connecting", _connects_off),
    ("an amplitude settles and remains constant", _presents),
    ("the readback can reveal a wrong amplitude", _readback_proves),
    ("a level of 0 switches the output off", _zero_is_off),
    ("a command outside the limits does not change the plate", _limits_leave_it),
    ("silence() can be called at any time, and more than once", _silence_repeats),
    ("the plate is off after an exception inside the with block", _exception_ends_off),
    ("a plate that is not connected raises a PlateFault", _closed_is_told),
    ("a plate can be connected again after it was closed", _reconnects),
    ("check() is cheap", _check_is_cheap),
    ("follow() reaches the amplitude", _follows),
)


def examine_backend(rig: Rig) -> Iterator[Verdict]:
    """Check a backend against all rules, disconnecting the plate after each check."""
    for rule, check in RULES:
        try:
            with _closed(rig):
                check(rig)
        except NotApplicable as reason:
            yield Verdict(rule=rule, outcome="not applicable", detail=str(reason))
        except (Departure, PlateFault, UserError) as departure:
            yield Verdict(rule=rule, outcome="departs", detail=str(departure))
        except Exception as error:  # noqa: BLE001 - a plug-in may raise anything, which departs
            detail = Message(
                "expected a PlateFault or a UserError; got {name}: {error}",
                name=type(error).__name__,
                error=error,
            )
            yield Verdict(rule=rule, outcome="departs", detail=detail)
        else:
            yield Verdict(rule=rule, outcome="conforms")


@contextmanager
def _closed(rig: Rig) -> Iterator[None]:
    try:
        yield
    finally:
        rig.plate.close()
