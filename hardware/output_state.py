"""Track the state of a plate's drive, and switch it off on every exit.

`GuardedOutput.output` is one of three states (`Output`):

================  ==========================================================================
*confirmed off*   the device confirmed that its drive is off, and has received nothing since
                  that could switch it on
*may be on*       from before such a command is sent until off is confirmed
*unreachable*     off was commanded but not confirmed, or the device was never connected
================  ==========================================================================

1. Only a confirmation by `connect`, `silence` or a presentation of 0 leads to *confirmed off*.
2. A command that is rejected before it is sent, because it is outside the limits or not supported,
   does not change the output. If a command raises any other error, the output is then *confirmed
   off* or *unreachable*, never *may be on*.
3. If the output is *unreachable*, no surface is presented until `connect` or `silence` has
   confirmed that it is off.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import ClassVar

from slipscale.hardware.clock import Clock
from slipscale.hardware.errors import ConnectionLost, OverLimit, PlateFault, StillVibrating
from slipscale.hardware.limits import OnTime, PlateLimits
from slipscale.hardware.records import Output


class GuardedOutput(ABC):
    """Output of a plate: a context manager that always silences the plate on exit.

    Parameters
    ----------
    clock : Clock
        Clock for the duration of vibration.
    limits : PlateLimits
        Limits, including those on the duration of vibration.

    Attributes
    ----------
    output : Output
        State of the drive; for the rules, see the documentation of this module.
    """

    name: ClassVar[str]

    def __init__(self, clock: Clock, limits: PlateLimits) -> None:
        self.clock = clock
        self.limits = limits
        self.output = Output.UNREACHABLE
        self._opened = False  # between `_connect` and `_close`
        self._on_time = OnTime(window_s=limits.duty_window_s)
        self._fault_known = False

    def silence(self) -> None:
        """Stop the vibration; safe to call at any time, in any state and repeatedly.

        Raises `PlateFault` if the plate did not confirm that it is off, unless a fault was already
        raised since `connect`. `StillVibrating` is raised at every attempt that fails, so that no
        other fault and no earlier handler hides it.
        """
        self._on_time.command(self.clock.now(), vibrates=False)
        try:
            self._silence()
        except StillVibrating:
            self.output, self._fault_known = Output.UNREACHABLE, True
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
        """Raise a `PlateFault` if a fault occurred since the last command.

        This method must be fast, because it is called in every frame of a participant's step.
        """
        now_s = self.clock.now()
        if self._on_time.unattended_s(now_s) > self.limits.on_time_s:
            self.silence()
            raise OverLimit(
                "the plate vibrated for {on_time_s:g} s without a new command, so it was "
                "switched off",
                on_time_s=self.limits.on_time_s,
                level_free=True,
            )
        try:
            self._check_duty()
        except OverLimit:
            self.silence()
            raise
        with self._silent_on_fault():
            self._check()

    def close(self) -> None:
        """Silence the plate, and release the device.

        Raises no `PlateFault` except `StillVibrating`.
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
        """Update the output state before and after the command sent in the ``with`` block."""
        if not self._opened or self.output is Output.UNREACHABLE:
            raise ConnectionLost(
                "plate '{name}': it is not connected, or did not confirm that it is off; nothing "
                "can be presented until it is reconnected",
                name=self.name,
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
                pass  # The error that occurred first is raised.
            raise
        except BaseException:  # The session ends; `close` reports if the plate vibrates.
            with suppress(PlateFault):
                self.silence()
            raise

    def _check_duty(self) -> None:
        duty = self._on_time.duty(self.clock.now())
        if duty > self.limits.duty:
            raise OverLimit(
                "the plate vibrated {duty:.0%} of the last {duty_window_s:g} s, more than the "
                "allowed {largest_duty:.0%}",
                duty=duty,
                duty_window_s=self.limits.duty_window_s,
                largest_duty=self.limits.duty,
                level_free=True,
            )

    @abstractmethod
    def _silence(self) -> None:
        """Stop the vibration, and check that it has stopped; do nothing if not connected."""

    @abstractmethod
    def _close(self) -> None:
        """Release the device; do nothing if not connected."""

    def _check(self) -> None:  # noqa: B027 - most backends learn of faults by commands alone
        """Raise a `PlateFault` if a fault occurred since the last command. Must be fast."""

    def __exit__(self, *_error: object) -> None:
        self.close()
