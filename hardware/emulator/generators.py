"""Simulate function generators of several makes (`slipscale plate emulate --generator MAKE`).

So that tests are independent, this module shares no code with
`slipscale.hardware.backends.generator_dialects`. Each simulated generator behaves as described in
its manufacturer's manual.

=========  ==================================================================================
make       source of limits and behaviour
=========  ==================================================================================
keysight   33500 Series Operating and Service Guide: pages 62 (a change of the load changes the
           displayed amplitude, not the output) and 216 (20 Vpp into an open circuit). E1441A
           User's Manual, page 99: break points at which the output drops for a moment
33220      as keysight; 33220A data sheet: 20 mVpp to 20 Vpp into an open circuit (page not
           verified)
rigol      DG1000Z Programming Guide, pages 2-56 (load), 2-184 (offset), 2-185 (range); values
           outside the range are clipped without an error (a user's report)
siglent    SDG Programming Guide PG02, sections 3.3 (OUTP) and 3.4 (BSWV) and those on MDWV, SWWV
           and BTWV; no error query
tektronix  Tektronix tm_devices, driver and commands of the AFG3K: 40 mVpp to 20 Vpp at high
           impedance (AFG310x); no command holds the attenuator
=========  ==================================================================================
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar

SOURCE_OHM = 50.0
OPEN_OHM = 9.9e37
RMS = 2 * math.sqrt(2)  # V peak to peak per V RMS of a sine
# Voltages in V peak to peak at which an attenuator switches: E1441A User's Manual, page 99.
BREAK_POINTS_VPP = (0.317, 0.632, 1.26, 2.52, 5.02)
ERROR_QUEUE = 20
OUT_OF_RANGE = '-222,"Data out of range"'


@dataclass(slots=True)
class GeneratorChannel:
    """Output channel of a generator, initially in its ``*RST`` state.

    ``open_vpp`` is the voltage into an open circuit. Set and displayed values depend on the load
    setting and the unit.
    """

    function: str = "SIN"
    frequency_hz: float = 1000.0
    open_vpp: float = 0.2
    offset_v: float = 0.0
    load_ohm: float = SOURCE_OHM
    unit: str = "VPP"
    on: bool = False
    range_auto: bool = True
    active: set[str] = field(default_factory=set)  # modulations, sweep, burst
    dropouts: int = 0  # how often the attenuator switched while the output was on

    @property
    def scale(self) -> float:
        """Ratio of the displayed amplitude to the open-circuit voltage in V peak to peak."""
        loaded = self.load_ohm / (self.load_ohm + SOURCE_OHM) if self.load_ohm < OPEN_OHM else 1.0
        return loaded / (RMS if self.unit == "VRMS" else 1.0)

    def plate_vpp(self) -> float:
        """Return the voltage that would drive a plate at resonance, in V peak to peak.

        Only a sine wave drives the plate. An untriggered burst gives 0; for other modulations and
        for sweeps, half the amplitude is assumed.
        """
        if not self.on or "BURS" in self.active or not self.function.startswith("SIN"):
            return 0.0
        return self.open_vpp * (0.5 if self.active else 1.0)

    def set_open_vpp(self, vpp: float) -> None:
        """Change the voltage, switching an automatic attenuator if necessary."""
        crossed = [each for each in BREAK_POINTS_VPP if (each < vpp) != (each < self.open_vpp)]
        self.dropouts += bool(crossed and self.on and self.range_auto)
        self.open_vpp = vpp


class SimulatedGenerator:
    """Base class of simulated generators, with their channels, limits and error queue."""

    identity: ClassVar[str]
    smallest_vpp: ClassVar[float] = 0.002  # into an open circuit
    largest_vpp: ClassVar[float] = 20.0
    resolution_vpp: ClassVar[float] = 1e-4
    clips: ClassVar[bool] = False  # whether values are clipped without an error

    def __init__(self) -> None:
        self.errors: list[str] = []
        self.channel = {1: GeneratorChannel(), 2: GeneratorChannel()}

    def reset(self) -> None:
        """Reset all settings, as with ``*RST`` or a preset at the front panel."""
        self.channel = {1: GeneratorChannel(), 2: GeneratorChannel()}

    def hear(self, line: str) -> str | None:
        """Process a line; return the answer to a query, or None for a command."""
        common: dict[str, Callable[[], str | None]] = {
            "*IDN?": lambda: self.identity,
            "*OPC?": lambda: "1",
            "*CLS": self.errors.clear,
            "*RST": self.reset,
        }
        return common[line]() if line in common else self.obey(line)

    def obey(self, line: str) -> str | None:
        """Process a command or query in this manufacturer's language."""
        raise NotImplementedError

    def set_amplitude(self, channel: GeneratorChannel, displayed: float) -> None:
        """Round an amplitude to the resolution and set it.

        Values outside the range are rejected or clipped.
        """
        vpp = displayed / channel.scale
        rounded = round(vpp / self.resolution_vpp) * self.resolution_vpp
        within = min(max(rounded, self.smallest_vpp), self.largest_vpp)
        if not math.isclose(within, rounded):
            if not self.clips:
                self.fail(OUT_OF_RANGE)
                return
            rounded = within
        channel.set_open_vpp(rounded)

    def fail(self, error: str) -> None:
        """Add an error to the queue."""
        self.errors = [*self.errors, error][-ERROR_QUEUE:]


class _Scpi(SimulatedGenerator):
    """Generator with SCPI commands; ``table`` maps header patterns to settings."""

    table: ClassVar[dict[str, str]] = {}
    functions: ClassVar[tuple[str, ...]] = ()  # modulations, sweep, burst
    no_error: ClassVar[str] = '0,"No error"'
    words: ClassVar[dict[bool, str]] = {True: "1", False: "0"}

    def obey(self, line: str) -> str | None:
        """Process a command or query of this make."""
        if line.lstrip(":").upper() == "SYST:ERR?":
            return self.errors.pop(0) if self.errors else self.no_error
        header, _, value = line.partition(" ")
        known = {rf":?(SOUR(?P<n>[12])?:)?{each}:STAT": each for each in self.functions}
        for pattern, name in {**self.table, **known}.items():
            found = re.fullmatch(pattern, header.rstrip("?").upper())
            if found:
                channel = self.channel[int(found["n"] or 1)]
                if header.endswith("?"):
                    return self._answer(channel, name)
                self._set(channel, name, value.upper())
                return None
        self.fail('-113,"Undefined header"')
        return None

    def _answer(self, channel: GeneratorChannel, name: str) -> str:
        if name in self.functions:
            return self.words[name in channel.active]
        if name in {"on", "range_auto"}:
            return self.words[bool(getattr(channel, name))]
        if name in {"function", "unit"}:
            return str(getattr(channel, name))
        if name == "mode":
            return "SWE" if "SWE" in channel.active else "CW"
        if name == "amplitude":
            return self.number(channel.open_vpp * channel.scale)
        return self.number(float(getattr(channel, name)))

    def number(self, value: float) -> str:
        """Format a number in this manufacturer's style."""
        raise NotImplementedError

    def _set(self, channel: GeneratorChannel, name: str, value: str) -> None:
        if name in self.functions:
            channel.active = {name} if value in {"1", "ON"} else channel.active - {name}
        elif name in {"on", "range_auto"}:
            setattr(channel, name, value in {"1", "ON"})
        elif name in {"function", "unit"}:
            setattr(channel, name, value)
        elif name == "mode":
            channel.active = {"SWE"} if value.startswith("SWE") else channel.active - {"SWE"}
        elif name == "load_ohm":
            channel.load_ohm = OPEN_OHM if value.startswith("INF") else float(value)
        elif name == "amplitude":
            self.set_amplitude(channel, float(value))
        else:
            setattr(channel, name, float(value))


class Keysight(_Scpi):
    """Keysight 33500 series, which answers with signed 15-decimal numbers and short keywords."""

    identity = "Agilent Technologies,33522B,MY57800001,4.00-1.19-2.00-52-00"
    no_error = '+0,"No error"'
    functions: ClassVar[tuple[str, ...]] = (
        "AM",
        "FM",
        "PM",
        "FSK",
        "PWM",
        "SWE",
        "BURS",
        "BPSK",
        "SUM",
    )
    table: ClassVar[dict[str, str]] = {
        r"(SOUR(?P<n>[12])?:)?FUNC": "function",
        r"(SOUR(?P<n>[12])?:)?FREQ": "frequency_hz",
        r"(SOUR(?P<n>[12])?:)?VOLT": "amplitude",
        r"(SOUR(?P<n>[12])?:)?VOLT:UNIT": "unit",
        r"(SOUR(?P<n>[12])?:)?VOLT:OFFS": "offset_v",
        r"(SOUR(?P<n>[12])?:)?VOLT:RANG:AUTO": "range_auto",
        r"OUTP(?P<n>[12])?:LOAD": "load_ohm",
        r"OUTP(?P<n>[12])?": "on",
    }

    def number(self, value: float) -> str:
        """Format a number in this manufacturer's style."""
        return "9.9E+37" if value >= OPEN_OHM else f"{value:+.15E}"


class Agilent33220(Keysight):
    """Agilent 33220A, which has a single channel (no suffix) and a minimum of 20 mVpp."""

    identity = "Agilent Technologies,33220A,MY44000001,2.02-2.02-22-2"
    smallest_vpp = 0.02
    functions: ClassVar[tuple[str, ...]] = ("AM", "FM", "PM", "FSK", "PWM", "SWE", "BURS")

    def obey(self, line: str) -> str | None:
        """Process a command or query in this manufacturer's language."""
        if re.match(r"(?i):?(SOUR|OUTP)[12]", line):
            self.fail('-114,"Header suffix out of range"')
            return None
        return super().obey(line)


class Rigol(_Scpi):
    """Rigol DG1000Z, which answers with unsigned seven-digit numbers and silently clips values."""

    identity = "Rigol Technologies,DG1022Z,DG1ZA000000001,03.01.12"
    words: ClassVar[dict[bool, str]] = {True: "ON", False: "OFF"}
    clips = True
    functions: ClassVar[tuple[str, ...]] = ("MOD", "SWE", "BURS", "SUM", "HARM")
    table: ClassVar[dict[str, str]] = {
        r":?SOUR(?P<n>[12])?:FUNC": "function",
        r":?SOUR(?P<n>[12])?:FREQ": "frequency_hz",
        r":?SOUR(?P<n>[12])?:VOLT": "amplitude",
        r":?SOUR(?P<n>[12])?:VOLT:UNIT": "unit",
        r":?SOUR(?P<n>[12])?:VOLT:OFFS": "offset_v",
        r":?SOUR(?P<n>[12])?:VOLT:RANG:AUTO": "range_auto",
        r":?OUTP(?P<n>[12])?:(LOAD|IMP)": "load_ohm",
        r":?OUTP(?P<n>[12])?(:STAT)?": "on",
    }

    def number(self, value: float) -> str:
        """Format a number in this manufacturer's style."""
        return f"{value:.6E}"


class Tektronix(_Scpi):
    """Tektronix AFG3000, which uses IMP for the impedance and FUNC:SHAP for the shape."""

    identity = "TEKTRONIX,AFG3102C,C010001,SCPI:99.0 FV:1.0.4"
    smallest_vpp = 0.04
    functions: ClassVar[tuple[str, ...]] = ("AM", "FM", "PM", "FSK", "PWM", "BURS")
    table: ClassVar[dict[str, str]] = {
        r"(SOUR(?P<n>[12])?:)?FUNC(:SHAP)?": "function",
        r"(SOUR(?P<n>[12])?:)?FREQ(:(CW|FIX))?": "frequency_hz",
        r"(SOUR(?P<n>[12])?:)?FREQ:MODE": "mode",
        r"(SOUR(?P<n>[12])?:)?VOLT(:LEV)?(:IMM)?(:AMPL)?": "amplitude",
        r"(SOUR(?P<n>[12])?:)?VOLT:UNIT": "unit",
        r"(SOUR(?P<n>[12])?:)?VOLT(:LEV)?(:IMM)?:OFFS": "offset_v",
        r"OUTP(?P<n>[12])?:IMP": "load_ohm",
        r"OUTP(?P<n>[12])?(:STAT)?": "on",
    }

    def number(self, value: float) -> str:
        """Format a number in this manufacturer's style."""
        return "9.9E+37" if value >= OPEN_OHM else f"{value:.4E}".replace("E+0", "E")


class Siglent(SimulatedGenerator):
    """Siglent SDG2000X, which reports all settings of a wave at once.

    Unknown commands are ignored.
    """

    identity = "Siglent Technologies,SDG2042X,SDG2XCAD000001,2.01.01.35R3"
    smallest_vpp = 0.004
    resolution_vpp = 1e-3
    clips = True
    functions: ClassVar[dict[str, str]] = {"MDWV": "AM", "SWWV": "SWE", "BTWV": "BURS"}

    def obey(self, line: str) -> str | None:
        """Process a command or query of this make."""
        found = re.fullmatch(r"C(?P<n>[12]):(?P<head>[A-Z]{4})(?P<query>\?)?( (?P<rest>.*))?", line)
        if not found:
            return None
        channel, head = self.channel[int(found["n"])], found["head"]
        if head not in {"BSWV", "OUTP", *self.functions}:
            return None
        if found["query"]:
            return f"C{found['n']}:{head} {self._state(channel, head)}"
        words = (found["rest"] or "").split(",")
        if head == "OUTP" and words[0] in {"ON", "OFF"}:
            channel.on = words.pop(0) == "ON"
        for key, value in zip(words[::2], words[1::2], strict=False):
            self._set(channel, head, key, value)
        return None

    def _set(self, channel: GeneratorChannel, head: str, key: str, value: str) -> None:
        if head in self.functions and key == "STATE":
            name = self.functions[head]
            channel.active = {name} if value == "ON" else channel.active - {name}
        elif head == "OUTP" and key == "LOAD":
            channel.load_ohm = OPEN_OHM if value == "HZ" else float(value)
        elif key == "WVTP":
            channel.function = value
        elif key == "FRQ":
            channel.frequency_hz = float(value)
        elif key == "OFST":
            channel.offset_v = float(value)
        elif key == "AMP":
            self.set_amplitude(channel, float(value))

    def _state(self, channel: GeneratorChannel, head: str) -> str:
        if head in self.functions:
            if self.functions[head] not in channel.active:
                return "STATE,OFF"
            return "STATE,ON,AM,MDSP,SINE,SRC,INT,FRQ,100HZ,DEPTH,100,CARR,WVTP,SINE"
        if head == "OUTP":
            load = "HZ" if channel.load_ohm >= OPEN_OHM else f"{channel.load_ohm:g}"
            return f"{'ON' if channel.on else 'OFF'},LOAD,{load},PLRT,NOR"
        vpp = channel.open_vpp * channel.scale
        wave = "SINE" if channel.function.startswith("SIN") else channel.function
        return (
            f"WVTP,{wave},FRQ,{channel.frequency_hz:.9g}HZ,PERI,{1 / channel.frequency_hz:.6g}S,"
            f"AMP,{vpp:.6g}V,AMPVRMS,{vpp / RMS:.4g}Vrms,OFST,{channel.offset_v:g}V,"
            f"HLEV,{vpp / 2:.6g}V,LLEV,{-vpp / 2:.6g}V,PHSE,0"
        )


MAKES: dict[str, type[SimulatedGenerator]] = {
    "keysight": Keysight,
    "33220": Agilent33220,
    "rigol": Rigol,
    "siglent": Siglent,
    "tektronix": Tektronix,
}
