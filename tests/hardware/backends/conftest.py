"""Function generators simulated after their makers' manuals, on a socket of this machine.

They share nothing with `slipscale.hardware.backends.generator_dialects`: what a make understands
and how it answers is written here a second time, from the manuals.
"""

import re
import socket
import threading
from contextlib import ExitStack, suppress
from typing import ClassVar

import pytest

OPEN_CIRCUIT = 9.9e37


class Channel:
    def __init__(self):
        self.function, self.frequency_hz, self.vpp, self.offset_v = "SIN", 1000.0, 0.1, 0.0
        self.load_ohm, self.unit, self.on = 50.0, "VPP", True  # left on by whoever was before

    def plate_vpp(self):
        """What arrives at an open circuit: twice what is set for a load of 50 Ω."""
        return self.vpp * (2 if self.load_ohm == 50 else 1) * (2.83 if self.unit == "VRMS" else 1)


class Generator:
    """What all makes have: channels, errors, and words that are looked up in a table."""

    identity = ""
    channels = 2
    smallest_vpp = 0.002

    def __init__(self):
        self.channel = {number: Channel() for number in range(1, self.channels + 1)}
        self.errors = []

    def hear(self, line):
        """Obey a line; return the answer to a query, None to anything else."""
        if line == "*IDN?":
            return self.identity
        if line == "*CLS":
            self.errors.clear()
            return None
        return self.obey(line)


class Scpi(Generator):
    """A tree of headers: ``table`` maps a pattern of the header to what it sets."""

    table: ClassVar = {}
    no_error = '0,"No error"'
    queued = "SYST:ERR?"
    words: ClassVar = {True: "1", False: "0"}

    def obey(self, line):
        if line.lstrip(":").upper() == self.queued:
            return self.errors.pop(0) if self.errors else self.no_error
        header, _, value = line.partition(" ")
        query = header.endswith("?")
        for pattern, name in self.table.items():
            found = re.fullmatch(pattern, header.rstrip("?").upper())
            if found and int(found["n"] or 1) in self.channel:
                channel = self.channel[int(found["n"] or 1)]
                return self.answer(channel, name) if query else self.set(channel, name, value)
        self.errors.append('-113,"Undefined header"')
        return None

    def answer(self, channel, name):
        value = getattr(channel, name)
        if isinstance(value, bool):
            return self.words[value]
        return value if isinstance(value, str) else self.number(value)

    def set(self, channel, name, value):
        if name in ("function", "unit"):
            setattr(channel, name, value.upper())
        elif name == "on":
            channel.on = value.upper() in ("1", "ON")
        elif name == "load_ohm":
            channel.load_ohm = OPEN_CIRCUIT if value.upper().startswith("INF") else float(value)
        elif name == "vpp" and float(value) < self.smallest_vpp:
            self.errors.append('-222,"Data out of range"')
        else:
            setattr(channel, name, float(value))


class Keysight(Scpi):
    """33500 series: numbers with a sign and 15 decimals, words short, outputs 1 and 0."""

    identity = "Agilent Technologies,33522B,MY57800001,4.00-1.19-2.00-52-00"
    no_error = '+0,"No error"'
    table: ClassVar = {
        r"(SOUR(?P<n>[12])?:)?FUNC": "function",
        r"(SOUR(?P<n>[12])?:)?FREQ": "frequency_hz",
        r"(SOUR(?P<n>[12])?:)?VOLT": "vpp",
        r"(SOUR(?P<n>[12])?:)?VOLT:UNIT": "unit",
        r"(SOUR(?P<n>[12])?:)?VOLT:OFFS": "offset_v",
        r"OUTP(?P<n>[12])?:LOAD": "load_ohm",
        r"OUTP(?P<n>[12])?": "on",
    }

    def number(self, value):
        return "9.9E+37" if value == OPEN_CIRCUIT else f"{value:+.15E}"


class Rigol(Scpi):
    """DG1000Z: seven digits without a sign, outputs ON and OFF; bounds are kept in silence."""

    identity = "Rigol Technologies,DG1022Z,DG1ZA000000001,03.01.12"
    words: ClassVar = {True: "ON", False: "OFF"}
    table: ClassVar = {
        r":?SOUR(?P<n>[12])?:FUNC": "function",
        r":?SOUR(?P<n>[12])?:FREQ": "frequency_hz",
        r":?SOUR(?P<n>[12])?:VOLT": "vpp",
        r":?SOUR(?P<n>[12])?:VOLT:UNIT": "unit",
        r":?SOUR(?P<n>[12])?:VOLT:OFFS": "offset_v",
        r":?OUTP(?P<n>[12])?:(LOAD|IMP)": "load_ohm",
        r":?OUTP(?P<n>[12])?(:STAT)?": "on",
    }

    def set(self, channel, name, value):
        if name == "vpp":
            value = str(max(float(value), self.smallest_vpp))
        super().set(channel, name, value)

    def number(self, value):
        return f"{value:.6E}"


class Siglent(Generator):
    """SDG2000X: basic wave and output are each one query; what it does not know it ignores."""

    identity = "Siglent Technologies,SDG2042X,SDG2XCAD000001,2.01.01.35R3"
    setters: ClassVar = {"FRQ": "frequency_hz", "AMP": "vpp", "OFST": "offset_v"}

    def obey(self, line):
        found = re.fullmatch(
            r"C(?P<n>[12]):(?P<head>BSWV|OUTP)(?P<query>\?)?( (?P<rest>.*))?", line
        )
        if not found:
            return None
        channel, prefix = self.channel[int(found["n"])], f"C{found['n']}:{found['head']}"
        if found["query"]:
            return f"{prefix} {self.state(channel, found['head'])}"
        words = found["rest"].split(",")
        if found["head"] == "OUTP":
            if words[0] in ("ON", "OFF"):
                channel.on = words.pop(0) == "ON"
            if words and words[0] == "LOAD":
                channel.load_ohm = OPEN_CIRCUIT if words[1] == "HZ" else float(words[1])
        for key, value in zip(words[::2], words[1::2], strict=True):
            if key == "WVTP":
                channel.function = value
            elif key in self.setters:
                setattr(channel, self.setters[key], float(value))
        return None

    def state(self, channel, head):
        if head == "OUTP":
            load = "HZ" if channel.load_ohm == OPEN_CIRCUIT else f"{channel.load_ohm:g}"
            return f"{'ON' if channel.on else 'OFF'},LOAD,{load},PLRT,NOR"
        wave = "SINE" if channel.function.startswith("SIN") else channel.function
        return (
            f"WVTP,{wave},FRQ,{channel.frequency_hz:.9g}HZ,PERI,{1 / channel.frequency_hz:.6g}S,"
            f"AMP,{channel.vpp:.6g}V,AMPVRMS,{channel.vpp / 2.83:.4g}Vrms,"
            f"OFST,{channel.offset_v:g}V,"
            f"HLEV,{channel.vpp / 2:.6g}V,LLEV,{-channel.vpp / 2:.6g}V,PHSE,0"
        )


class Tektronix(Scpi):
    """AFG3000: outputs 1 and 0, the impedance under IMP, the shape under FUNC:SHAP."""

    identity = "TEKTRONIX,AFG3102C,C010001,SCPI:99.0 FV:1.0.4"
    table: ClassVar = {
        r"(SOUR(?P<n>[12])?:)?FUNC(:SHAP)?": "function",
        r"(SOUR(?P<n>[12])?:)?FREQ(:(CW|FIX))?": "frequency_hz",
        r"(SOUR(?P<n>[12])?:)?VOLT(:LEV)?(:IMM)?(:AMPL)?": "vpp",
        r"(SOUR(?P<n>[12])?:)?VOLT:UNIT": "unit",
        r"(SOUR(?P<n>[12])?:)?VOLT(:LEV)?(:IMM)?:OFFS": "offset_v",
        r"OUTP(?P<n>[12])?:IMP": "load_ohm",
        r"OUTP(?P<n>[12])?(:STAT)?": "on",
    }

    def number(self, value):
        return "9.9E+37" if value == OPEN_CIRCUIT else f"{value:.4E}".replace("E+0", "E")


MAKES = {"keysight": Keysight, "rigol": Rigol, "siglent": Siglent, "tektronix": Tektronix}


class Bench:
    """A generator behind a socket that can drop: once and back, or for good."""

    def __init__(self, make):
        self.generator = MAKES[make]()
        self.lines = []
        self.drop_at = None  # the number of the line at which the connection drops, unread
        self.for_good = False
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.resource = f"TCPIP::127.0.0.1::{self._socket.getsockname()[1]}::SOCKET"
        self._over = False
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def vibrating(self):
        return any(channel.on for channel in self.generator.channel.values())

    def close(self):
        self._over = True
        with socket.socket() as poke:
            poke.connect_ex(self._socket.getsockname())
        self._thread.join()
        self._socket.close()

    def _serve(self):
        while not self._over:
            connection, _ = self._socket.accept()
            with connection, suppress(ConnectionError):  # whoever gave up closed it
                if not (self._over or (self.for_good and self._dropped())):
                    self._talk(connection)

    def _dropped(self):
        return self.drop_at is not None and len(self.lines) >= self.drop_at

    def _talk(self, connection):
        buffer = b""
        while True:
            if hasattr(socket, "TCP_QUICKACK"):  # else each command waits 40 ms for the last's
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
            received = connection.recv(4096)
            if not received:
                return
            *lines, buffer = (buffer + received).split(b"\n")
            for raw in lines:
                self.lines.append(raw.decode().strip())
                if len(self.lines) == self.drop_at:
                    return
                answer = self.generator.hear(self.lines[-1])
                if answer is not None:
                    connection.sendall(answer.encode() + b"\n")


@pytest.fixture
def bench():
    """Return a maker of simulated generators, by make; all end with the test."""
    with ExitStack() as stack:

        def made(make):
            found = Bench(make)
            stack.callback(found.close)
            return found

        yield made
