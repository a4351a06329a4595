"""The guard: a killed or stopped session leaves no output on."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from slipscale.faults import UserError
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.emulator.generator_server import GeneratorServer
from slipscale.hardware.emulator.generators import MAKES
from slipscale.hardware.errors import Frozen, GuardLost
from slipscale.hardware.output import guard_process
from slipscale.hardware.records import Output
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.surface import VirtualSurface
from tests.support import nidaqmx_on_disk

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of Linux and macOS")
PATIENCE_S = 60.0
#: Presents a level, prints the guard's process id, and checks until a line arrives.
SESSION = """
import json, select, signal, sys, time
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.errors import PlateFault
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.surface import VirtualSurface

for name in sys.argv[3:]:
    signal.signal(getattr(signal, name), signal.SIG_IGN)
plate = open_plate(sys.argv[1], clock=SystemClock())
plate.connect()
try:
    if sys.argv[2]:
        plate.present(VirtualSurface(level=float(sys.argv[2])))
    else:
        plate.excite(frequency_hz=30_500, voltage_v=2.0)
    print(plate._guard.process_id, flush=True)
    while not select.select([sys.stdin], [], [], 0.01)[0]:
        plate.check()
except PlateFault as fault:
    print(json.dumps([fault.code, plate.output]), flush=True)
plate.close()
"""


class SessionProcess:
    """A session in its own process group, and the process id of its guard."""

    def __init__(self, spec, level="", *ignored, env=None):
        self.process = subprocess.Popen(
            [sys.executable, "-c", SESSION, spec, str(level), *ignored],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=env,
            start_new_session=True,
        )
        self.guard_id = int(self.process.stdout.readline())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()


def until(condition):
    end_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end_s
        time.sleep(0.01)


def runs(process_id):
    try:
        os.kill(process_id, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{process_id}/stat").read_text("utf-8").split()[2] != "Z"


@pytest.mark.parametrize("make", sorted(MAKES))
def test_a_generator_is_off_after_its_session_was_killed_and_its_guard_ends(make):
    with (
        GeneratorServer(make) as server,
        SessionProcess(f"scpi:{server.resource},gain=2") as session,
    ):
        channel = server.generator.channel[1]
        assert channel.plate_vpp() == pytest.approx(2.0)
        session.process.kill()
        until(lambda: not channel.on)
        until(lambda: not runs(session.guard_id))


def test_signals_to_the_group_and_to_the_guard_leave_it_waiting():
    with GeneratorServer("keysight") as server:
        ignored = ["SIGINT", "SIGHUP", "SIGTERM"]
        with SessionProcess(f"scpi:{server.resource},gain=2", "", *ignored) as session:
            for name in ignored:
                os.killpg(session.process.pid, getattr(signal, name))
                os.kill(session.guard_id, getattr(signal, name))
            time.sleep(0.2)
            assert runs(session.guard_id)
            assert server.generator.channel[1].on
            session.process.kill()
            until(lambda: not server.generator.channel[1].on)


def test_a_stopped_session_is_off_and_finds_a_fault_when_it_goes_on():
    with (
        GeneratorServer("keysight") as server,
        SessionProcess(f"scpi:{server.resource},gain=2") as session,
    ):
        session.process.send_signal(signal.SIGSTOP)
        until(lambda: not server.generator.channel[1].on)
        session.process.send_signal(signal.SIGCONT)
        assert json.loads(session.process.stdout.readline()) == ["frozen", "confirmed off"]
        assert session.process.wait(PATIENCE_S) == 0
        assert not server.generator.channel[1].on


def test_the_guard_of_a_stopped_session_that_is_then_killed_ends_without_its_generator():
    with GeneratorServer("keysight") as server:
        session = SessionProcess(f"scpi:{server.resource},gain=2")
        with session:
            session.process.send_signal(signal.SIGSTOP)
            until(lambda: not server.generator.channel[1].on)
            time.sleep(0.2)
            server.for_good, server.drop_at = True, len(server.lines)
    until(lambda: not runs(session.guard_id))


def test_a_session_that_hangs_is_off_after_the_attention_time():
    with GeneratorServer("keysight") as server:
        plate = open_plate(f"scpi:{server.resource},gain=2,attention=0.5", clock=SystemClock())
        with plate:
            plate.excite(frequency_hz=30_500, voltage_v=2.0)
            until(lambda: not server.generator.channel[1].on)
            until(lambda: plate._guard._tripped_s)
            assert plate._guard._tripped_s >= guard_process.WATCHDOG_S
            with pytest.raises(Frozen, match=r"more than 0\.7 s while the plate was on"):
                plate.check()
            assert plate.output is Output.OFF
            plate.excite(frequency_hz=30_500, voltage_v=2.0)  # The next command is accepted.
            plate.check()


def test_a_session_that_does_not_check_stays_on_without_an_attention_time():
    with (
        GeneratorServer("keysight") as server,
        open_plate(f"scpi:{server.resource},gain=2,attention=0", clock=SystemClock()) as plate,
    ):
        plate.excite(frequency_hz=30_500, voltage_v=2.0)
        time.sleep(1.5)
        assert server.generator.channel[1].on
        plate.check()


def test_a_guard_that_dies_is_a_fault_and_a_new_one_switches_off():
    with (
        GeneratorServer("keysight") as server,
        open_plate(f"scpi:{server.resource},gain=2", clock=SystemClock()) as plate,
    ):
        plate.excite(frequency_hz=30_500, voltage_v=2.0)
        os.kill(plate._guard.process_id, signal.SIGKILL)
        until(lambda: plate._guard.ended)
        with pytest.raises(GuardLost, match="the guard process ended"):
            plate.check()
        assert not server.generator.channel[1].on
        assert plate.output is Output.OFF


def test_a_guard_that_stands_still_is_replaced_and_the_new_one_switches_off():
    with (
        GeneratorServer("keysight") as server,
        open_plate(f"scpi:{server.resource},gain=2", clock=SystemClock()) as plate,
    ):
        plate.excite(frequency_hz=30_500, voltage_v=2.0)
        still = plate._guard.process_id
        os.kill(still, signal.SIGSTOP)

        def checked():
            try:
                plate.check()
            except GuardLost:
                return True
            return False

        until(checked)
        assert not server.generator.channel[1].on
        assert plate.output is Output.OFF
        assert not runs(still)


def test_a_session_that_ends_in_order_ends_its_guard():
    with GeneratorServer("keysight") as server:
        plate = open_plate(f"scpi:{server.resource},gain=2", clock=SystemClock())
        with plate:
            guard_id = plate._guard.process_id
            assert runs(guard_id)
        assert not runs(guard_id)


def test_the_library_of_a_guard_is_light():
    code = "import sys, slipscale.hardware.output.guard_process; print(*sys.modules)"
    loaded = subprocess.check_output([sys.executable, "-c", code], text=True).split()
    assert {"numpy", "pydantic", "pyvisa", "scipy"} & set(loaded) == set()


@pytest.fixture
def daq(plate_in_volts):
    plate = plate_in_volts("daq", 1.0, (20.0, 1000.0))
    return f"daq:Dev1/ao0,plate={plate},frequency=125,per_volt=20"


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_an_analogue_output_is_at_0_v_after_its_session_was_killed_or_stopped(
    daq, tmp_path, number
):
    env = nidaqmx_on_disk.install(tmp_path)
    with SessionProcess(daq, 40, env=env) as session:
        assert nidaqmx_on_disk.record(tmp_path)[-1][1] == pytest.approx(2.0)
        session.process.send_signal(number)
        until(lambda: nidaqmx_on_disk.record(tmp_path)[-1][1] == 0)
        if number == signal.SIGSTOP:
            session.process.send_signal(signal.SIGCONT)
            assert json.loads(session.process.stdout.readline()) == ["frozen", "confirmed off"]


def test_both_actuators_of_a_pair_are_guarded(daq, tmp_path):
    env = nidaqmx_on_disk.install(tmp_path)
    code = SESSION.replace("plate._guard.", "plate.first._guard.").replace(
        "plate.connect()", "plate.connect(); plate.second_level = 40.0"
    )
    mock = f"mock:guard={tmp_path}/first.txt"
    command = [sys.executable, "-c", code, f"pair:{mock}+{daq}", "1.2"]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=env
    ) as process:
        assert process.stdout.readline()
        assert nidaqmx_on_disk.record(tmp_path)[-1][1] == pytest.approx(2.0)
        process.kill()
        until(lambda: nidaqmx_on_disk.record(tmp_path)[-1][1] == 0)
        until((tmp_path / "first.txt").exists)


def test_an_unguarded_plate_is_refused_without_an_interlock_and_noted_with_one(monkeypatch):
    from slipscale.hardware.backends.mock import MockPlate
    from slipscale.hardware.output.unattended import Unguarded

    monkeypatch.setattr(MockPlate, "unattended", Unguarded("its oscillator runs freely"))
    with pytest.raises(UserError, match=r"\(its oscillator runs freely\); install an interlock"):
        open_plate("mock:q=50", clock=SystemClock())
    with open_plate("mock:q=50,interlock=foot switch", clock=SystemClock()) as plate:
        assert plate.notes == (
            "if this program is killed, only the interlock switches the plate off: foot switch",
        )
        plate.present(VirtualSurface(level=1.2))
