"""What each make of function generator calls the same things: a table of dialects.

A dialect is data: how to write a setting, how to ask for it, and where in the answer its value
stands. `slipscale.hardware.backends.function_generator` knows the order in which settings are made
and nothing of any make; a laboratory's own make is one more entry.

Sources: Keysight 33500/33600 Series Operating and Service Guide, "SCPI Programming Reference";
Rigol DG1000Z Programming Guide, pages 2-56 (load), 2-58 (state) and 2-184 (offset); Siglent SDG
Programming Guide PG02, sections 3.3 (OUTP) and 3.4 (BSWV); Tektronix AFG3000 Series Programmer
Manual, sections OUTPut and SOURce. Each dialect is tested against an instrument simulated after
these pages; **none has been on a real bench yet**.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from slipscale.faults import UserError

if TYPE_CHECKING:
    from collections.abc import Callable

WHOLE_ANSWER = r"^\"?([^,\"]+)"  # up to a comma; some makes put words in quotes
INFINITE_OHM = 9e37  # SCPI's infinity is 9.9E+37
HIGHEST_ZERO_V = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """One thing of a generator that can be set and asked for.

    Parameters
    ----------
    write, ask : str
        Commands; ``{source}`` and ``{channel}`` stand for the channel's prefix and suffix,
        ``{value}`` for what is set.
    value : str
        Regular expression; its first group is the value in the answer.
    """

    write: str
    ask: str
    value: str = WHOLE_ANSWER

    def read(self, answer: str) -> str | None:
        """Return the value in an answer, or None where there is none."""
        found = re.search(self.value, answer)
        return found[1].strip() if found else None


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedSetting:
    """What is set once on connecting, and what its value must then be."""

    item: Item
    value: str
    holds: Callable[[str], bool]


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """How one make of generator is spoken to.

    Parameters
    ----------
    name : str
        As in the SPEC's ``dialect=``.
    identity : str
        Regular expression that ``MANUFACTURER,MODEL`` of the answer to ``*IDN?`` matches.
    channels : tuple of (str, str)
        Prefix of a source's commands and suffix of an output's, a pair for each channel.
    fixed : tuple of FixedSetting
        Sine, a load of infinite resistance, volts peak to peak, no offset. The load matters: a
        generator that believes in 50 Ω puts twice its volts on an open circuit.
    frequency_hz, voltage_vpp, output : Item
        What is set for each presentation. `voltage_vpp` is at the generator's own output.
    on, off : str
        The words that `output` is set to.
    error : str or None
        Asks for the oldest error; None where the manual knows no such query, so that only
        reading back tells.
    """

    name: str
    identity: str
    channels: tuple[tuple[str, str], ...]
    fixed: tuple[FixedSetting, ...]
    frequency_hz: Item
    voltage_vpp: Item
    output: Item
    on: str = "1"
    off: str = "0"
    error: str | None = "SYST:ERR?"


def is_sine(text: str) -> bool:
    """Whether a waveform's name is the sine's."""
    return text.upper().startswith("SIN")


def is_infinite(text: str) -> bool:
    """Whether a load is infinite: a word, or SCPI's number for it."""
    return text.upper().startswith(("INF", "HZ")) or number(text) >= INFINITE_OHM


def is_peak_to_peak(text: str) -> bool:
    """Whether a unit is volts peak to peak."""
    return text.upper() == "VPP"


def is_zero(text: str) -> bool:
    """Whether a voltage is zero, with or without a sign."""
    return abs(number(text)) < HIGHEST_ZERO_V


def is_on(text: str) -> bool | None:
    """Return whether an output is on: some makes answer 1 and 0, others ON and OFF."""
    return {"1": True, "ON": True, "0": False, "OFF": False}.get(text.upper().lstrip("+"))


def number(text: str) -> float:
    """Return a number that may carry its unit (``30500HZ``, ``1.5V``); NaN where there is none."""
    found = re.match(r"[+-]?(\d+\.?\d*|\.\d+)(E[+-]?\d+)?(?=[A-Z]*$)", text, re.IGNORECASE)
    return float(found[0]) if found else math.nan


def _bswv(parameter: str) -> Item:
    """Return an item of Siglent's basic wave, which is answered whole."""
    return Item(
        write=f"C{{channel}}:BSWV {parameter},{{value}}",
        ask="C{channel}:BSWV?",
        value=rf"[ ,]{parameter},([^,]+)",
    )


def _plain(header: str) -> Item:
    return Item(write=f"{header} {{value}}", ask=f"{header}?")


KEYSIGHT = Dialect(
    name="keysight",
    identity=r"(?i)^(agilent|keysight)",
    # The 33220A has one channel and knows no suffix.
    channels=(("", ""), ("SOUR2:", "2")),
    fixed=(
        FixedSetting(item=_plain("{source}FUNC"), value="SIN", holds=is_sine),
        FixedSetting(item=_plain("OUTP{channel}:LOAD"), value="INF", holds=is_infinite),
        FixedSetting(item=_plain("{source}VOLT:UNIT"), value="VPP", holds=is_peak_to_peak),
        FixedSetting(item=_plain("{source}VOLT:OFFS"), value="0", holds=is_zero),
    ),
    frequency_hz=_plain("{source}FREQ"),
    voltage_vpp=_plain("{source}VOLT"),
    output=_plain("OUTP{channel}"),
)
RIGOL = Dialect(
    name="rigol",
    identity=r"(?i)^rigol",
    channels=((":SOUR1:", "1"), (":SOUR2:", "2")),
    fixed=(
        FixedSetting(item=_plain("{source}FUNC"), value="SIN", holds=is_sine),
        FixedSetting(item=_plain(":OUTP{channel}:LOAD"), value="INF", holds=is_infinite),
        FixedSetting(item=_plain("{source}VOLT:UNIT"), value="VPP", holds=is_peak_to_peak),
        FixedSetting(item=_plain("{source}VOLT:OFFS"), value="0", holds=is_zero),
    ),
    frequency_hz=_plain("{source}FREQ"),
    voltage_vpp=_plain("{source}VOLT"),
    output=_plain(":OUTP{channel}"),
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
    ),
    frequency_hz=_bswv("FRQ"),
    voltage_vpp=_bswv("AMP"),
    output=Item(write="C{channel}:OUTP {value}", ask="C{channel}:OUTP?", value=r":OUTP (\w+)"),
    on="ON",
    off="OFF",
    error=None,
)
TEKTRONIX = Dialect(
    name="tektronix",
    identity=r"(?i)^tektronix",
    channels=(("SOUR1:", "1"), ("SOUR2:", "2")),
    fixed=(
        FixedSetting(item=_plain("{source}FUNC:SHAP"), value="SIN", holds=is_sine),
        FixedSetting(item=_plain("OUTP{channel}:IMP"), value="INF", holds=is_infinite),
        FixedSetting(item=_plain("{source}VOLT:UNIT"), value="VPP", holds=is_peak_to_peak),
        FixedSetting(item=_plain("{source}VOLT:LEV:IMM:OFFS"), value="0", holds=is_zero),
    ),
    frequency_hz=_plain("{source}FREQ:FIX"),
    voltage_vpp=_plain("{source}VOLT:LEV:IMM:AMPL"),
    output=_plain("OUTP{channel}:STAT"),
)

DIALECTS = {each.name: each for each in (KEYSIGHT, RIGOL, SIGLENT, TEKTRONIX)}


def dialect_named(name: str) -> Dialect:
    """Return a dialect by its name, or raise ValueError that says what was expected."""
    if name not in DIALECTS:
        raise ValueError(f"expected one of {', '.join(DIALECTS)}")
    return DIALECTS[name]


def dialect_of(manufacturer: str, model: str) -> Dialect | None:
    """Return the dialect of who answered ``*IDN?``; None: no make in the table."""
    said = f"{manufacturer},{model}"
    return next((each for each in DIALECTS.values() if re.search(each.identity, said)), None)


def channel_number(text: str) -> int:
    """Return a channel's number, or raise ValueError that says what was expected."""
    if text not in {"1", "2"}:
        raise ValueError("expected 1 or 2")
    return int(text)


def words_of(dialect: Dialect, channel: int) -> dict[str, str]:
    """Return what stands for a channel in the dialect's commands. Raises UserError."""
    if channel > len(dialect.channels):
        raise UserError(f"plate 'scpi': {dialect.name} generators have no channel {channel}")
    source, suffix = dialect.channels[channel - 1]
    return {"source": source, "channel": suffix}
