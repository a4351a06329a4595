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
4. While the output may be on, a guard (`slipscale.hardware.output.guard`) waits for the death of
   this process, if the backend declares one. `connect` starts it, before the backend connects. A
   guard of an output that is not confirmed off survives `close`.
5. If the session or the computer was frozen while the output may have been on, the next command or
   check is a fault (`Frozen`). All durations count the time in which the computer was suspended.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import ClassVar

from slipscale.hardware.clock import Clock
from slipscale.hardware.errors import (
    ConnectionLost,
    Frozen,
    GuardLost,
    OverLimit,
    PlateFault,
    StillVibrating,
)
from slipscale.hardware.limits import OnTime, PlateLimits
from slipscale.hardware.output import guard as guards
from slipscale.hardware.output.instrument_lock import InstrumentLock
from slipscale.hardware.output.unattended import Guarded, Unattended, Unguarded
from slipscale.hardware.records import Output

FROZEN_S = 1.0
ATTENTION_S = 5.0  # A session that gives no sign of life for this time is assumed to hang.


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
    instrument : str
        Name of the instrument, which only one process drives at a time
        (`slipscale.hardware.output.instrument_lock`); "" if it needs no lock.
    unattended : Unattended
        What happens to the output when this process is killed or frozen.
    interlock : str
        What switches an unguarded output off, as acknowledged by the operator.
    attention_s : float
        Time without a command or `check` after which the session is assumed to hang, and the
        output is switched off; 0 means never.
    frozen_s : float
        Time between two commands or calls of `check` after which the session, or the computer, was
        frozen. Until then, nothing recorded what the plate did.
    """

    name: ClassVar[str]
    instrument: str = ""
    unattended: Unattended = Unguarded("the backend declares no guard")
    interlock: str = ""
    attention_s: float = ATTENTION_S
    frozen_s: float = FROZEN_S

    def __init__(self, clock: Clock, limits: PlateLimits) -> None:
        self.clock = clock
        self.limits = limits
        self._guard: guards.Guard | None = None
        self._lock: InstrumentLock | None = None
        self._known_state = Output.UNREACHABLE
        self._opened = False  # between `_connect` and `_close`
        self._seen_s = 0.0  # time of the last sign of life, see `_lived_s`
        self._on_time = OnTime(window_s=limits.duty_window_s)
        self._fault_known = False

    @property
    def output(self) -> Output:
        """State of the drive; for the rules, see the documentation of this module."""
        return self._known_state

    @output.setter
    def output(self, state: Output) -> None:
        self._known_state = state
        if self._guard is not None and state is not Output.UNREACHABLE:
            self._guard.arm(state is Output.MAY_BE_ON)

    def _start_guard(self) -> None:
        """Lock the instrument, and start the backend's guard in place of an earlier one."""
        if self._guard is not None:
            self._guard.kill()
            self._guard = None
        if self.instrument and self._lock is None:
            self._lock = InstrumentLock(self.instrument)
        if isinstance(self.unattended, Guarded):
            keeps = (self._lock.descriptor,) if self._lock else ()
            self._guard = guards.Guard(
                self.unattended.opens, attention_s=self.attention_s, keeps=keeps
            )
            if self._opened and self.output is not Output.OFF:
                self._guard.arm(True)

    def _ask_guard(self, method: str, *words: str) -> str:
        """Call a method of the guard's `Switch`; start the guard again if it has ended."""
        if self._guard is None or self._guard.ended:
            self._start_guard()
        if self._guard is None:
            raise GuardLost(guards.ENDED)
        return self._guard.call(method, *words)

    def attend(self) -> None:
        """Record that the session was alive, although it neither commanded nor checked."""
        self._seen_s = self._lived_s()

    def silence(self) -> None:
        """Stop the vibration; safe to call at any time, in any state and repeatedly.

        Raises `PlateFault` if the plate did not confirm that it is off, unless a fault was already
        raised since `connect`. `StillVibrating` is raised at every attempt that fails, so that no
        other fault and no earlier handler hides it.
        """
        self._on_time.command(self._lived_s(), vibrates=False)
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
        with self._silent_on_fault():
            if self._on_time.unattended_s(self._lived_s()) > self.limits.on_time_s:
                raise OverLimit(
                    "the plate vibrated for {on_time_s:g} s without a new command, so it was "
                    "switched off",
                    on_time_s=self.limits.on_time_s,
                    level_free=True,
                )
            self._check_duty()
            self._check()

    def close(self) -> None:
        """Silence the plate, and release the device.

        Raises no `PlateFault` except `StillVibrating`.
        """
        self._fault_known = True
        try:
            self.silence()
        finally:
            confirmed_off = self.output is Output.OFF
            self._opened = False
            with suppress(PlateFault):
                self._close()
            if self._guard is not None:
                self._guard.end(confirmed_off=confirmed_off)
                self._guard = None if self._guard.ended else self._guard
            if self._lock is not None:
                self._lock.release(shared=self._guard is not None)
                self._lock = None

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
            self._on_time.command(self._lived_s(), vibrates=vibrates)
            if vibrates:
                self.output = Output.MAY_BE_ON
            yield
        if not vibrates:
            self.output = Output.OFF

    @contextmanager
    def _silent_on_fault(self) -> Iterator[None]:
        try:
            self._check_alive()
            yield
            self._seen_s = self._lived_s()
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

    def _lived_s(self) -> float:
        """Return the time, including that in which the computer was suspended."""
        return self.clock.now() + self.clock.suspended_s()

    def _check_alive(self) -> None:
        """Record a sign of life; raise `Frozen` if the last one was long before, with output on."""
        gap_s = self._lived_s() - self._seen_s
        self._seen_s += gap_s
        if self._guard is not None:
            self._guard.attend()
            self._guard.check()
        if self.attention_s and self.output is Output.MAY_BE_ON and gap_s > self.frozen_s:
            raise Frozen(
                "this session stood still for {gap_s:.1f} s while the plate was on", gap_s=gap_s
            )

    def _check_duty(self) -> None:
        duty = self._on_time.duty(self._lived_s())
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
