"""Define the commands of function generators, with one dialect per make.

A dialect defines how to write a setting, how to query it, and how to find its value in the answer.
The order of commands is the same for all makes and is defined in
`slipscale.hardware.backends.generator_output`.

Each dialect cites the source of its values. Sources marked "not verified" are manuals cited from
memory. Dialects are tested with simulated instruments (`slipscale.hardware.emulator.generators`);
**none has been tested on a real generator yet**.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from slipscale.faults import UserError
from slipscale.faults.message import Message

WHOLE_ANSWER = r"^\"?([^,\"]+)"  # Answer up to the first comma; some generators add quotes.
INFINITE_OHM = 9e37  # SCPI's infinity is 9.9E+37
HIGHEST_ZERO_V = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """Generator setting that can be written and queried.

    Parameters
    ----------
    write, ask : str
        Commands. ``{source}`` and ``{channel}`` are replaced by the prefix and suffix of the
        channel, and ``{value}`` by the value.
    value : str
        Regular expression for the answer; its first group is the value.
    """

    write: str
    ask: str
    value: str = WHOLE_ANSWER

    def read(self, answer: str) -> str | None:
        """Return the value in an answer, or None if the answer does not match."""
        found = re.search(self.value, answer)
        return found[1].strip() if found else None


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedSetting:
    """Setting that is written when the generator is connected and must not change afterwards."""

    item: Item
    value: str
    holds: Callable[[str], bool]


@dataclass(frozen=True, slots=True, kw_only=True)
class VoltageRange:
    """Sine voltage range of a model, in V peak to peak into an open circuit."""

    model: str  # a regular expression
    smallest_vpp: float
    largest_vpp: float
    resolution_vpp: float  # resolution of the smallest voltages
    source: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """Commands and properties of one make of function generator.

    Parameters
    ----------
    name : str
        Value of ``dialect=`` in the SPEC.
    identity : str
        Regular expression for ``MANUFACTURER,MODEL`` in the answer to ``*IDN?``.
    channels : tuple of (str, str)
        For each channel, the prefix of source commands and the suffix of output commands.
    fixed : tuple of FixedSetting
        Settings that must not change: sine wave, infinite load, volts peak to peak, and no offset,
        modulation, sweep or burst.
    frequency_hz, voltage_vpp, output : Item
        Settings sent to the generator for each presentation. `voltage_vpp` is the voltage at the
        generator's output.
    ranges : tuple of VoltageRange
        Voltage ranges of the models. The first range with a matching pattern applies.
    attenuator : FixedSetting or None
        Setting that holds the attenuator in the position for the largest voltage, because its
        relays would interrupt a ramp; None if the generator has no attenuator setting.
    on, off : str
        Values of `output`.
    error : str or None
        Query that returns the oldest error. If None, errors are detected only by reading settings
        back.
    """

    name: str
    identity: str
    channels: tuple[tuple[str, str], ...]
    fixed: tuple[FixedSetting, ...]
    frequency_hz: Item
    voltage_vpp: Item
    output: Item
    ranges: tuple[VoltageRange, ...]
    attenuator: FixedSetting | None = None
    on: str = "1"
    off: str = "0"
    error: str | None = "SYST:ERR?"

    def range_of(self, model: str) -> VoltageRange:
        """Return the voltage range of a model, or the last of `ranges` if the model is unknown."""
        return next((each for each in self.ranges if re.search(each.model, model)), self.ranges[-1])


def is_sine(text: str) -> bool:
    """Return whether a reply indicates a sine wave."""
    return text.upper().startswith("SIN")


def is_infinite(text: str) -> bool:
    """Return whether a reply indicates an infinite load, in words or as SCPI's infinity."""
    return text.upper().startswith(("INF", "HZ")) or number(text) >= INFINITE_OHM


def is_peak_to_peak(text: str) -> bool:
    """Return whether a reply indicates volts peak to peak."""
    return text.upper() == "VPP"


def is_zero(text: str) -> bool:
    """Return whether a reply indicates zero, with or without a sign."""
    return abs(number(text)) < HIGHEST_ZERO_V


def is_on(text: str) -> bool | None:
    """Return whether a reply indicates that an output is on, in digits or words."""
    return {"1": True, "ON": True, "0": False, "OFF": False}.get(text.upper().lstrip("+"))


def is_off(text: str) -> bool:
    """Return whether a reply indicates that a function is off."""
    return is_on(text) is False


def is_continuous(text: str) -> bool:
    """Return whether a reply indicates a single frequency without a sweep."""
    return text.upper().startswith(("CW", "FIX"))


def number(text: str) -> float:
    """Parse a number with or without a unit (``30500HZ``, ``1.5V``); return NaN for other text."""
    found = re.match(r"[+-]?(\d+\.?\d*|\.\d+)(E[+-]?\d+)?(?=[A-Z]*$)", text, re.IGNORECASE)
    return float(found[0]) if found else math.nan


def _bswv(parameter: str) -> Item:
    """Return a parameter of Siglent's BSWV command, whose answer contains all parameters."""
    return Item(
        write=f"C{{channel}}:BSWV {parameter},{{value}}",
        ask="C{channel}:BSWV?",
        value=rf"[ ,]{parameter},([^,]+)",
    )


def _plain(header: str) -> Item:
    return Item(write=f"{header} {{value}}", ask=f"{header}?")


def _off(*headers: str, word: str = "0") -> tuple[FixedSetting, ...]:
    """Return the settings that switch off functions, such as modulations."""
    return tuple(FixedSetting(item=_plain(each), value=word, holds=is_off) for each in headers)


def _siglent_off(header: str) -> FixedSetting:
    item = Item(
        write=f"C{{channel}}:{header} STATE,{{value}}",
        ask=f"C{{channel}}:{header}?",
        value=r"\bSTATE,(\w+)",
    )
    return FixedSetting(item=item, value="OFF", holds=is_off)


def _sine(function: str, load: str, offset: str) -> tuple[FixedSetting, ...]:
    """Return the settings for sine, infinite load, volts peak to peak and no offset."""
    return (
        FixedSetting(item=_plain(function), value="SIN", holds=is_sine),
        FixedSetting(item=_plain(load), value="INF", holds=is_infinite),
        FixedSetting(item=_plain("{source}VOLT:UNIT"), value="VPP", holds=is_peak_to_peak),
        FixedSetting(item=_plain(offset), value="0", holds=is_zero),
    )


KEYSIGHT = Dialect(
    name="keysight",
    identity=r"(?i)^(agilent|keysight)",
    # The 33220A has one channel and does not accept a suffix.
    channels=(("", ""), ("SOUR2:", "2")),
    fixed=(
        *_sine("{source}FUNC", "OUTP{channel}:LOAD", "{source}VOLT:OFFS"),
        # Only functions that the 33220A also has; BPSK and SUM exist only in the 33500.
        *_off(
            *(f"{{source}}{each}:STAT" for each in ("AM", "FM", "PM", "FSK", "PWM", "SWE", "BURS"))
        ),
    ),
    frequency_hz=_plain("{source}FREQ"),
    voltage_vpp=_plain("{source}VOLT"),
    output=_plain("OUTP{channel}"),
    ranges=(
        VoltageRange(
            model=r"332[125]0A",
            smallest_vpp=0.02,
            largest_vpp=20,
            resolution_vpp=1e-4,
            source="33220A data sheet: 10 mVpp to 10 Vpp into 50 Ω, 20 mVpp to 20 Vpp into an "
            "open circuit, 4 digits (page not verified)",
        ),
        VoltageRange(
            model=r"33[56]",
            smallest_vpp=0.002,
            largest_vpp=20,
            resolution_vpp=1e-4,
            source="33500 Series Operating and Service Guide, page 216: at most 20 Vpp into an "
            "open circuit; data sheet: at least 1 mVpp into 50 Ω (page not verified)",
        ),
    ),
    attenuator=_off("{source}VOLT:RANG:AUTO")[0],
)
RIGOL = Dialect(
    name="rigol",
    identity=r"(?i)^rigol",
    channels=((":SOUR1:", "1"), (":SOUR2:", "2")),
    fixed=(
        *_sine("{source}FUNC", ":OUTP{channel}:LOAD", "{source}VOLT:OFFS"),
        *_off(
            *(f"{{source}}{each}:STAT" for each in ("MOD", "SWE", "BURS", "SUM", "HARM")),
            word="OFF",
        ),
    ),
    frequency_hz=_plain("{source}FREQ"),
    voltage_vpp=_plain("{source}VOLT"),
    output=_plain(":OUTP{channel}"),
    ranges=(
        VoltageRange(
            model="",
            smallest_vpp=0.002,
            largest_vpp=20,
            resolution_vpp=1e-4,
            source="DG1000Z data sheet: 1 mVpp to 10 Vpp into 50 Ω up to 10 MHz, twice that into "
            "an open circuit (page not verified)",
        ),
    ),
    # DG1000Z Programming Guide, page 2-185.
    attenuator=_off("{source}VOLT:RANG:AUTO", word="OFF")[0],
    on="ON",
    off="OFF",
    error=":SYST:ERR?",
)
SIGLENT = Dialect(
    name="siglent",
    identity=r"(?i)^siglent",
    channels=(("", "1"), ("", "2")),
    fixed=(
        FixedSetting(item=_bswv("WVTP"), value="SINE", holds=is_sine),
        FixedSetting(
            item=Item(
                write="C{channel}:OUTP LOAD,{value}",
                ask="C{channel}:OUTP?",
                value=r"LOAD,([^,]+)",
            ),
            value="HZ",  # high impedance
            holds=is_infinite,
        ),
        FixedSetting(item=_bswv("OFST"), value="0", holds=is_zero),
        # SDG Programming Guide PG02, sections on MDWV, SWWV and BTWV.
        *(_siglent_off(each) for each in ("MDWV", "SWWV", "BTWV")),
    ),
    frequency_hz=_bswv("FRQ"),
    voltage_vpp=_bswv("AMP"),
    output=Item(write="C{channel}:OUTP {value}", ask="C{channel}:OUTP?", value=r":OUTP (\w+)"),
    ranges=(
        VoltageRange(
            model=r"SDG(1\d{3}X|2\d{3}X|6\d{3}X)",
            smallest_vpp=0.004,
            largest_vpp=20,
            resolution_vpp=1e-3,
            source="SDG1000X and SDG2000X data sheets: 2 mVpp to 10 Vpp into 50 Ω, twice that "
            "into an open circuit (pages not verified)",
        ),
    ),
    on="ON",
    off="OFF",
    error=None,
)
TEKTRONIX = Dialect(
    name="tektronix",
    identity=r"(?i)^tektronix",
    channels=(("SOUR1:", "1"), ("SOUR2:", "2")),
    fixed=(
        *_sine("{source}FUNC:SHAP", "OUTP{channel}:IMP", "{source}VOLT:LEV:IMM:OFFS"),
        *_off(
            *(f"{{source}}{each}:STAT" for each in ("AM", "FM", "PM", "FSK", "PWM", "BURS")),
        ),
        FixedSetting(item=_plain("{source}FREQ:MODE"), value="CW", holds=is_continuous),
    ),
    frequency_hz=_plain("{source}FREQ:FIX"),
    voltage_vpp=_plain("{source}VOLT:LEV:IMM:AMPL"),
    output=_plain("OUTP{channel}:STAT"),
    ranges=(
        VoltageRange(
            model=r"AFG30[25]",
            smallest_vpp=0.02,
            largest_vpp=20,
            resolution_vpp=1e-4,
            source="Tektronix tm_devices, driver of the AFG3K: 20 mVpp to 20 Vpp at high impedance",
        ),
        VoltageRange(
            model=r"AFG325",
            smallest_vpp=0.1,
            largest_vpp=10,
            resolution_vpp=1e-4,
            source="Tektronix tm_devices, driver of the AFG3K: 100 mVpp to 10 Vpp at high "
            "impedance",
        ),
        VoltageRange(
            model="",
            smallest_vpp=0.04,
            largest_vpp=20,
            resolution_vpp=1e-4,
            source="Tektronix tm_devices, driver of the AFG3K: 40 mVpp to 20 Vpp at high "
            "impedance (AFG310x)",
        ),
    ),
)

DIALECTS = {each.name: each for each in (KEYSIGHT, RIGOL, SIGLENT, TEKTRONIX)}


def dialect_named(name: str) -> Dialect:
    """Return a dialect by name. Raises ValueError with the expected names."""
    if name not in DIALECTS:
        raise ValueError(Message("expected one of {dialects}", dialects=", ".join(DIALECTS)))
    return DIALECTS[name]


def dialect_of(manufacturer: str, model: str) -> Dialect | None:
    """Return the dialect for an answer to ``*IDN?``, or None for an unknown make."""
    device = f"{manufacturer},{model}"
    return next((each for each in DIALECTS.values() if re.search(each.identity, device)), None)


def channel_number(text: str) -> int:
    """Parse the number of a channel. Raises ValueError unless the number is 1 or 2."""
    if text not in {"1", "2"}:
        raise ValueError("expected 1 or 2")
    return int(text)


def words_of(dialect: Dialect, channel: int) -> dict[str, str]:
    """Return the fields that select a channel in a dialect's commands. Raises UserError."""
    if channel > len(dialect.channels):
        raise UserError(
            "plate 'scpi': {dialect_name} generators have no channel {channel}",
            dialect_name=dialect.name,
            channel=channel,
        )
    source, suffix = dialect.channels[channel - 1]
    return {"source": source, "channel": suffix}
