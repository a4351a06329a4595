"""What is known about a plate's drive, and what switches it off on every way out.

The state of the output has three values (`Output`), and `GuardedOutput.output` holds it:

================  ==========================================================================
*confirmed off*   the device confirmed that its drive is off, and was sent nothing since that
                  could switch it on
*may be on*       from before such a command is sent until off is confirmed
*unreachable*     off was commanded and not confirmed, or the device was never connected
================  ==========================================================================

1. Only a confirmation leads to *confirmed off*: `connect`, `silence`, a presentation of 0.
2. A command that raises leaves the output as it was (outside the limits), *confirmed off* or
   *unreachable*; it never leaves it *may be on*.
3. From *unreachable* nothing is presented: `connect` or `silence` has to confirm off first.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, ClassVar

from slipscale.hardware.errors import ConnectionLost, OverLimit, PlateFault, StillVibrating
from slipscale.hardware.limits import OnTime
from slipscale.hardware.records import Output

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import TracebackType

    from slipscale.hardware.clock import Clock
    from slipscale.hardware.limits import PlateLimits


class GuardedOutput(ABC):
    """A plate's output. A context manager's exit leaves it silent on every path.

    Parameters
    ----------
    clock : Clock
        The only clock that may be read.
    limits : PlateLimits
        Of the time for which the plate may vibrate.

    Attributes
    ----------
    output : Output
        What is known about the drive, see the rules of `slipscale.hardware.output_state`.
    """

    name: ClassVar[str]

    def __init__(self, clock: Clock, limits: PlateLimits) -> None:
        self.clock = clock
        self.limits = limits
        self.output = Output.UNREACHABLE
        self._opened = False  # `_connect` returned, and `_close` was not called since
        self._on_time = OnTime(window_s=limits.duty_window_s)
        self._fault_known = False
        self._vibration_known = False  # that it could not be stopped has been told

    def silence(self) -> None:
        """Stop the vibration. May be called at any time, in any state, more than once.

        Raises `PlateFault` when the plate did not confirm, unless a fault was raised before: that
        one has already told that the plate may be out of reach. That it may still vibrate
        (`StillVibrating`) is raised once in any case.
        """
        self._on_time.command(self.clock.now(), vibrates=False)
        try:
            self._silence()
        except StillVibrating:
            self.output = Output.UNREACHABLE
            if not self._vibration_known:
                self._vibration_known = self._fault_known = True
                raise
        except PlateFault:
            self.output = Output.UNREACHABLE
            if not self._fault_known:
                self._fault_known = True
                raise
        else:
            if self._opened:
                self.output = Output.OFF

    def check(self) -> None:
        """Raise the `PlateFault` that has come up since the last command, if any.

        Called often (every frame) while a participant explores or answers: it must be cheap.
        """
        now_s = self.clock.now()
        if self._on_time.unattended_s(now_s) > self.limits.on_time_s:
            self.silence()
            raise OverLimit(
                f"the plate vibrated for {self.limits.on_time_s:g} s without a new command; "
                "it was silenced"
            )
        try:
            self._check_duty()
        except OverLimit:
            self.silence()
            raise
        with self._silent_on_fault():
            self._check()

    def close(self) -> None:
        """Silence, then let go of the device.

        Raises no `PlateFault` but `StillVibrating`, and that only where nobody was told before.
        """
        self._fault_known = True
        try:
            self.silence()
        finally:
            self._opened = False
            with suppress(PlateFault):
                self._close()

    @contextmanager
    def _commanding(self, *, vibrates: bool) -> Iterator[None]:
        """Keep the state of the output around a command, by the rules of this module."""
        if not self._opened or self.output is Output.UNREACHABLE:
            raise ConnectionLost(
                f"plate '{self.name}': it is not connected, or did not confirm that it is off; "
                "nothing is presented before it is connected again"
            )
        with self._silent_on_fault():
            self._on_time.command(self.clock.now(), vibrates=vibrates)
            if vibrates:
                self.output = Output.MAY_BE_ON
            yield
        if not vibrates:
            self.output = Output.OFF

    @contextmanager
    def _silent_on_fault(self) -> Iterator[None]:
        try:
            yield
        except Exception as error:
            self._fault_known = self._fault_known or isinstance(error, PlateFault)
            try:
                self.silence()
            except StillVibrating as still:
                raise still from error
            except PlateFault:
                pass  # the error that is raised tells enough
            raise
        except BaseException:  # somebody ends the session: `close` tells if the plate vibrates
            with suppress(PlateFault):
                self.silence()
            self._vibration_known = False
            raise

    def _check_duty(self) -> None:
        duty = self._on_time.duty(self.clock.now())
        if duty > self.limits.duty:
            raise OverLimit(
                f"the plate vibrated {duty:.0%} of the last {self.limits.duty_window_s:g} s, "
                f"more than {self.limits.duty:.0%}"
            )

    @abstractmethod
    def _silence(self) -> None:
        """Stop the vibration and have that confirmed; do nothing when not connected."""

    @abstractmethod
    def _close(self) -> None:
        """Let go of the device; do nothing when not connected."""

    def _check(self) -> None:  # noqa: B027 - most backends learn of faults by commands alone
        """Raise the fault that has come up since the last command, if any; cheaply."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
