"""One process drives an instrument at a time."""

import os
import re
import subprocess
import sys
from threading import Timer

import pytest

from slipscale.hardware.backends.function_generator import FunctionGenerator
from slipscale.hardware.backends.generator_line import instrument_of
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.emulator.generator_server import GeneratorServer
from slipscale.hardware.errors import ConnectionLost, PlateBusy
from slipscale.hardware.output.instrument_lock import InstrumentLock
from slipscale.hardware.records import Output
from slipscale.hardware.registry import open_plate

HOLDER = """
import sys
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.registry import open_plate
with open_plate(sys.argv[1], clock=SystemClock()):
    print("connected", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def server():
    with GeneratorServer("keysight") as server:
        yield server


@pytest.mark.parametrize(
    "one, other",
    [
        ("TCPIP::127.0.0.1::5025::SOCKET", "tcpip0::localhost::5025::SOCKET"),
        ("TCPIP::localhost::INSTR", "TCPIP0::localhost::inst0::INSTR"),
        ("TCPIP::localhost", "TCPIP::LOCALHOST::INSTR"),
        ("USB0::0x0957::0x2C07::MY1::0::INSTR", "USB::2391::11271::my1::INSTR"),
        ("ASRL/dev/null::INSTR", "asrl/dev/../dev/null::INSTR"),
        ("ASRLCOM3::INSTR", "ASRLcom3::INSTR"),
        ("GPIB0::7::INSTR", "GPIB::7"),
    ],
)
def test_every_spelling_of_a_resource_names_one_instrument(one, other):
    assert instrument_of(one) == instrument_of(other)


def test_other_resources_are_other_instruments():
    on_lan = [f"TCPIP::127.0.0.{host}::{port}::SOCKET" for host in (1, 2) for port in (1, 2)]
    names = set(map(instrument_of, [*on_lan, "GPIB::7", "GPIB1::7", "ASRLCOM3", "ASRLCOM4"]))
    assert len(names) == 8
    assert instrument_of("GPIB1::7") != instrument_of("GPIB10::7")


def test_a_second_session_is_refused_with_the_process_and_start_of_the_first(server):
    spec = f"scpi:{server.resource},gain=2"
    first = subprocess.Popen(
        [sys.executable, "-c", HOLDER, spec], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    with first:
        assert first.stdout.readline() == b"connected\n"
        heard = len(server.lines)
        second = open_plate(spec, clock=SystemClock())
        with pytest.raises(PlateBusy) as refused:
            second.connect()
        start = rf"process {first.pid} \(-c .+\) since 20\d\d-\d\d-\d\d \d\d:\d\d:\d\d"
        assert re.search(start, str(refused.value))
        assert refused.value.level_free
        assert len(server.lines) == heard  # Nothing reached the instrument.
        assert second.output is Output.UNREACHABLE
        first.stdin.close()
        assert first.wait(60) == 0
    with second:
        assert second.output is Output.OFF


def test_a_driver_that_could_not_connect_holds_no_lock():
    for _ in range(2):
        with pytest.raises(ConnectionLost, match="refused"):
            open_plate("scpi:TCPIP::127.0.0.1::1::SOCKET,gain=2", clock=SystemClock()).connect()


def test_two_channels_of_one_generator_are_two_plates():
    spec = "scpi:TCPIP::127.0.0.1::1::SOCKET,gain=2"
    one, two = (open_plate(f"{spec},channel={n}", clock=SystemClock()) for n in (1, 2))
    assert isinstance(one, FunctionGenerator)
    assert one.instrument == "TCPIP::127.0.0.1::1::SOCKET, channel 1"
    assert two.instrument == "TCPIP::127.0.0.1::1::SOCKET, channel 2"


def test_another_name_of_a_serial_port_is_the_same_instrument(tmp_path):
    port = tmp_path / "ttyUSB0"
    port.touch()
    (tmp_path / "by-id").symlink_to(port)
    names = {
        open_plate(f"serial:{tmp_path}/{each}", clock=SystemClock()).instrument
        for each in ("ttyUSB0", "by-id")
    }
    assert names == {str(port)}


def test_simulated_plates_need_no_lock():
    assert MockPlate(clock=SystemClock()).instrument == ""


def test_a_lock_that_is_about_to_be_released_is_waited_for():
    first = InstrumentLock("an instrument")
    Timer(0.3, lambda: first.release(shared=False)).start()
    InstrumentLock("an instrument").release(shared=False)


@pytest.mark.skipif(sys.platform == "win32", reason="descriptors are inherited on Linux and macOS")
def test_a_process_that_inherited_the_lock_holds_it_after_its_session():
    lock = InstrumentLock("an instrument")
    with subprocess.Popen(
        [sys.executable, "-c", "input()"], stdin=subprocess.PIPE, pass_fds=[lock.descriptor]
    ) as guard:
        lock.release(shared=True)
        with pytest.raises(PlateBusy, match=f"process {os.getpid()} "):
            InstrumentLock("an instrument")
        guard.communicate(b"\n")
    InstrumentLock("an instrument").release(shared=False)
