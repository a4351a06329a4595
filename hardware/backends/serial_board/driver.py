"""Drive a plate through a driver board (docs/reference/board-protocol.md).

SPEC: ``serial:PORT`` or ``serial:PORT,option=value,...`` with

================  ===============================================================
``calibration``   a file written by ``slipscale plate calibrate``
``plate``         a file written by ``slipscale plate new``: limits and calibration
``attention``     seconds (5); if a session neither commands nor checks for this
                  long, it is assumed to hang and the plate is silenced; 0: never
================  ===============================================================

A heartbeat queries the board's status ten times per second, in a separate thread. The board
silences the plate if it receives nothing for its watchdog time. Faults detected by the heartbeat
are raised by `check`.

For textures, the board receives and plays a list of amplitudes. Textures are rejected if the
firmware is too old to support lists.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, TypeVar

from slipscale.faults import UserError
from slipscale.hardware import address as addresses
from slipscale.hardware.backends.serial_board import host as computers
from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.backends.serial_board import supervision as watch
from slipscale.hardware.backends.serial_board.link import BoardLink, Line, NotKnown
from slipscale.hardware.clock import Clock
from slipscale.hardware.driver import PlateDriver
from slipscale.hardware.errors import (
    ConnectionLost,
    GarbledReply,
    NotReached,
    OffCalibration,
    PlateFault,
    PlateTimeout,
    ProtocolViolation,
    WrongDevice,
)
from slipscale.hardware.output.state import ATTENTION_S
from slipscale.hardware.output.unattended import StopsAlone
from slipscale.hardware.records import PlateIdentity, Presentation, Readback
from slipscale.stimuli.modulation import DEFAULT_MODULATOR, STEPS_MAX, Loop, Modulator

if TYPE_CHECKING:
    from slipscale.stimuli.surface import Sensor, Surface

T = TypeVar("T")

HEARTBEAT_S = 0.1
POLL_S = 0.002
LONGEST_SETTLING_S = 2.0
# Delay between `follow` and the plate's response, including the serial line and the board's 25 ms
# ramp, which restarts at each command. For measurements, see the table in docs/how-to/finger.md.
FOLLOW_LAG_S = 0.017
# Smallest level that `follow` commands, as a fraction of the largest level. At a level of 0, the
# board would open its output stage. At levels below its sensor's noise, the board would adjust the
# voltage to noise.
FOLLOWED_SHARE = 0.02
# Largest rounding error of a reported level, as a fraction of the level.
ROUNDED_SHARE = 0.01
OPEN_LOOP_SETTLING_S = 0.05  # five time constants of a plate with Q = 1000

OPTIONS: dict[str, Callable[[str], object]] = {
    "attention": addresses.number_from_0,
}


class SerialBoard(PlateDriver):
    """Plate driven by a driver board.

    Parameters
    ----------
    port : str
        Name of the serial port.
    clock : Clock
        Clock for the time stamps of readbacks. Time-outs use the clock of ``host``.
    plate : Plate
        Limits, calibration and file of the plate; `connect` narrows the limits to those of the
        board, which controls the amplitude with its own sensor.
    attention_s : float
        Time without a command or `check` after which the heartbeat stops; 0 means never.
    host : Host
        Computer to which the board is connected; by default, this computer.
    """

    name = "serial"
    unattended = StopsAlone("the board's watchdog switches it off")
    follow_lag_s = FOLLOW_LAG_S

    def __init__(
        self,
        port: str,
        *,
        clock: Clock,
        plate: addresses.Plate = addresses.DEFAULT_PLATE,
        attention_s: float = ATTENTION_S,
        host: computers.Host | None = None,
    ) -> None:
        super().__init__(clock=clock, plate=plate)
        self.port = port
        # Elsewhere, ports have no path, and the system opens them only once.
        self.instrument = str(Path(port).resolve()) if Path(port).exists() else ""
        self.watchdog_s: float | None = None
        self.attention_s = attention_s
        self._host = host or computers.SystemHost()
        self._attended_s = 0.0
        self._line: Line | None = None
        self._link: BoardLink | None = None
        self._stop_heart: Callable[[], None] | None = None
        self._active: watch.ActivePresentation | None = None
        self._watched: watch.ActivePresentation | None = None
        self._reached_s = 0.0  # time at which the watched presentation began or was last confirmed
        self._fault: PlateFault | None = None

    def check_supported(self, surface: Surface, *, sensors: Collection[Sensor] = ()) -> Loop | None:
        """Return a surface's loop, as `PlateDriver` does; also refuse levels in too large a unit.

        The rule has no exceptions for larger levels, so a study whose smallest level passes before
        the session also passes during the session.
        """
        level, q = surface.settled_level, self.limits.quantity
        if 0 < level < wire.RESOLUTION / 2 / ROUNDED_SHARE:
            raise UserError(
                "{port}: the board reports levels only to {resolution:.4f} {unit_in_short}, "
                "which is too coarse for {level}; use a smaller unit in the plate file and the "
                "study",
                port=self.port,
                resolution=wire.RESOLUTION,
                unit_in_short=q.unit_in_short,
                level=q.short(level),
            )
        return super().check_supported(surface, sensors=sensors)

    def _connect(self) -> PlateIdentity:
        self._close()
        self._fault = self._active = None
        self._line = self._host.open_line(self.port)
        self._link = link = BoardLink(self._line, self._host)
        identity = _identity(link.greet(), self.port)
        self._learn_lists(link, identity.firmware)
        link.ask("*RST")
        self._check_unit(link)
        self._narrow_limits(_parsed(wire.parse_limits, link.ask("LIM?")))
        self._attend()
        self._watched = None
        self._stop_heart = self._host.repeat(partial(self._beat, link), HEARTBEAT_S)
        return identity

    def _drive(self, level: float) -> Presentation:
        link = self._attend()
        begun_s = self._host.now()
        self._active = None
        link.ask(wire.amplitude_command(level))
        status = self._status(link)
        while status.state == "RAMP" or self._rings(level, status):
            if self._host.now() - begun_s > LONGEST_SETTLING_S:
                raise PlateTimeout(
                    "the plate did not settle within {longest_settling_s:g} s",
                    longest_settling_s=LONGEST_SETTLING_S,
                )
            self._host.sleep(POLL_S)
            status = self._status(self._attend())
        if level > 0:
            active = watch.ActivePresentation(level, predicted_v=self._predicted_v(level))
            watch.check_status(status, active, self.limits, port=self.port)
            self._active = active
        elif status.state in wire.VIBRATING:
            raise ProtocolViolation(
                "{port}: the board reports {state} after AMPL 0", port=self.port, state=status.state
            )
        return Presentation(
            commanded_level=level,
            readback=self._readback(status),
            settled_by="readback",
            settle_time_s=self._host.now() - begun_s,
        )

    def _predicted_v(self, level: float) -> float | None:
        """Return the drive voltage that the calibration predicts, or None without a calibration."""
        return self.calibration.voltage_v_peak(level) if self.calibration else None

    def _rings(self, level: float, status: wire.BoardStatus) -> bool:
        """Return whether a plate that was switched off is still ringing down."""
        return level == 0 and (status.level or 0) > self.limits.deviation_level

    def _play(self, loop: Loop) -> None:
        link = self._attend()
        self._active = None
        for command in wire.list_commands(loop):
            link.ask(command)
        mean_level = fmean(loop.levels)
        plain = watch.ActivePresentation(
            mean_level, predicted_v=self._predicted_v(max(loop.levels))
        )
        self._active = replace(
            plain,
            state="LIST",
            resettling_s=max(plain.resettling_s, watch.CORRECTED_PERIODS * loop.period_s),
        )

    def _follow(self, level: float) -> None:
        link = self._attend()
        if self._active is None or self._active.state != watch.FOLLOWS:
            self._active = watch.ActivePresentation(level, watch.FOLLOWS)
        link.ask(wire.amplitude_command(max(level, FOLLOWED_SHARE * self.limits.level)))

    def _excite(self, *, frequency_hz: float, voltage_v: float) -> Readback:
        link = self._attend()
        self._active = None
        link.ask(f"DRIV {frequency_hz:.1f},{voltage_v:.3f}")
        self._host.sleep(OPEN_LOOP_SETTLING_S)
        return self._readback(self._status(link))

    def _read_back(self) -> Readback:
        """Return the board's reading; during a texture, first let the board correct the mean."""
        begun_s, active = self._host.now(), self._active
        status = self._status(self._attend())
        while active is not None and active.state == status.state == "LIST":
            mean_level, measured_level = active.level, status.level
            if measured_level is None or self._host.now() - begun_s > active.resettling_s:
                break
            if abs(measured_level - mean_level) <= self.limits.allowed_level(mean_level):
                break
            self._host.sleep(HEARTBEAT_S)
            status = self._status(self._attend())
        return self._readback(status)

    def _silence(self) -> None:
        self._active = None
        if self._link is not None:
            self._link.stop_now()
            self._link.ask("OUTP OFF")

    def _check(self) -> None:
        self._attend()

    def _close(self) -> None:
        if self._stop_heart is not None:
            self._stop_heart()
        if self._line is not None:
            self._line.close()
        self._line = self._link = self._stop_heart = None

    def _beat(self, link: BoardLink) -> bool:
        """Query the status. Store a fault, which `check` then raises; return whether to go on."""
        now_s = self._host.now()
        if self.attention_s and now_s - self._attended_s > self.attention_s:
            return True
        active = self._active
        if active is not self._watched:
            self._watched, self._reached_s = active, now_s
        try:
            status = self._status(link)
            # If the presentation changed during the query, the status may describe either one.
            if active is not None and active is self._active:
                watch.check_status(status, active, self.limits, port=self.port)
            self._reached_s = now_s
        except (NotReached, OffCalibration) as fault:
            if active is None or now_s - self._reached_s > active.resettling_s:
                self._fault = fault
        except PlateFault as fault:
            self._fault = fault
        return self._fault is None

    def _attend(self) -> BoardLink:
        """Record that the session is alive. Return the connection, or raise the stored fault."""
        self._attended_s = self._host.now()
        if self._fault is not None:
            raise self._fault
        if self._link is None:
            raise ConnectionLost("{port}: not connected", port=self.port)
        return self._link

    def _status(self, link: BoardLink) -> wire.BoardStatus:
        return _parsed(wire.parse_status, link.ask("STAT?"))

    def _readback(self, status: wire.BoardStatus) -> Readback:
        return Readback(
            level=status.level,
            kind="none" if status.level is None else "measured",
            time_s=self.clock.now(),
            voltage_v_peak=status.voltage_v,
            temperature_c=status.temperature_c,
        )

    def _check_unit(self, link: BoardLink) -> None:
        """Raise `WrongDevice` if the board and the plate use different units."""
        quantity = self.limits.quantity
        try:
            unit = link.ask("UNIT?")
        except NotKnown:
            unit = wire.UNIT
        if unit != quantity.suffix:
            raise WrongDevice(
                "{port}: the board's amplitudes are in {unit}, but {suffix} ({unit_in_full}) was "
                "expected; to use another unit, set it in a plate file",
                port=self.port,
                unit=unit,
                suffix=quantity.suffix,
                unit_in_full=quantity.unit_in_full,
            )

    def _learn_lists(self, link: BoardLink, firmware: str) -> None:
        """Query the board's limits for amplitude lists."""
        try:
            lists = _parsed(wire.parse_list_limits, link.ask("LIST:LIM?"))
        except NotKnown:
            self.modulator = None
            self.why_not_modulated = (
                f"the board's firmware ({firmware}) can only hold a constant amplitude"
            )
            return
        if lists.points < STEPS_MAX:
            self.modulator = None
            self.why_not_modulated = (
                f"the board can store {lists.points} amplitudes, but {STEPS_MAX} are required"
            )
            return
        plate = self.calibration.resonance if self.calibration else None
        self.modulator = Modulator(
            resonance_hz=plate.frequency_hz if plate else DEFAULT_MODULATOR.resonance_hz,
            quality_factor=plate.quality_factor if plate else DEFAULT_MODULATOR.quality_factor,
            command_interval_s=lists.step_ms / 1000,
            shortest_edge_s=lists.edge_ms / 1000,
        )

    def _narrow_limits(self, board: wire.BoardLimits) -> None:
        """Narrow the plate's limits to those of the board."""
        ours = self.limits
        if not (
            board.frequency_min_hz < ours.frequency_max_hz
            and ours.frequency_min_hz < board.frequency_max_hz
        ):
            raise WrongDevice(
                "{port}: the board drives {frequency_min_hz:g} to {frequency_max_hz:g} Hz, but "
                "the plate's limits are {limit_min_hz:g} to {limit_max_hz:g} Hz",
                port=self.port,
                frequency_min_hz=board.frequency_min_hz,
                frequency_max_hz=board.frequency_max_hz,
                limit_min_hz=ours.frequency_min_hz,
                limit_max_hz=ours.frequency_max_hz,
            )
        self.limits = replace(
            ours,
            level=min(ours.level, board.level),
            voltage_v=min(ours.voltage_v, board.voltage_v),
            frequency_min_hz=max(ours.frequency_min_hz, board.frequency_min_hz),
            frequency_max_hz=min(ours.frequency_max_hz, board.frequency_max_hz),
            on_time_s=min(ours.on_time_s, board.on_time_s),
        )
        self.largest_level = min(self.largest_level, board.level)
        self.watchdog_s = board.watchdog_ms / 1000


def _identity(answer: str, port: str) -> PlateIdentity:
    fields = answer.split(",")
    if len(fields) != len(PlateIdentity.__slots__) or fields[1] != wire.PROTOCOL:
        raise WrongDevice(
            "{port}: the device identifies itself as '{answer}'; expected a {protocol} board",
            port=port,
            answer=answer,
            protocol=wire.PROTOCOL,
            level_free=False,
        )
    return PlateIdentity(
        manufacturer=fields[0], model=fields[1], serial=fields[2], firmware=fields[3]
    )


def _parsed(parse: Callable[[str], T], value: str) -> T:
    try:
        return parse(value)
    except wire.ImpossibleValue as error:
        raise ProtocolViolation(
            "the board reports impossible limits: {error}", error=error
        ) from error
    except ValueError as error:
        raise GarbledReply(
            "the board answered '{value}', which cannot be read", value=value
        ) from error


def open_plate(address: str, *, clock: Clock, seed: int) -> PlateDriver:  # noqa: ARG001 - real
    """Return a driver for a board (entry point ``serial``).

    Raises
    ------
    UserError
        If the address lacks a port or contains an unknown option.
    """
    port, options, plate = addresses.opened(address, SerialBoard.name, OPTIONS)
    if not port:
        raise UserError(
            "plate 'serial': expected serial:PORT; slipscale plate list shows the ports"
        )
    return SerialBoard(
        port,
        clock=clock,
        plate=plate,
        attention_s=options.get("attention", ATTENTION_S),
    )
