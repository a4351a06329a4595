"""End sessions without warning at random moments, and measure how long the output stays on.

Usage: ``make unattended ARGS="--times 50"``. Requires Linux; for the sound card, a
PulseAudio server with its ALSA plug-in, which this campaign starts with a null sink; for the limit
of memory, the right to create a control group (version 1).

A session presents random levels. At a random moment, its process is

- killed (SIGKILL), or stopped (SIGSTOP),
- out of memory: it allocates memory beyond the limit of its control group, or
- without a terminal: the terminal that controls it is closed (SIGHUP).

The record of the emulated instrument, not of the session, shows when its output was off:

- generator: an emulated instrument on a socket, in this process,
- DAQ: an emulated device whose output stays on without its process,
- sound card: what the null sink of a sound server in a separate process plays,
- board: an emulated board in a separate process; its own watchdog is the only protection,
- pair: a generator and a DAQ; both must be off.

Prints one row per device and cause. Sessions that had ended before with a fault, because the
computer was too busy, are counted separately. The exit status is 1 if an output was on after 1 s.
"""

from __future__ import annotations

import multiprocessing as mp
import os
import pty
import random
import shutil
import signal
import subprocess
import sys
import time
from argparse import ArgumentParser, Namespace
from array import array
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from datetime import date
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from threading import Thread
from typing import TYPE_CHECKING

from slipscale.hardware.emulator.generator_server import GeneratorServer
from slipscale.hardware.emulator.generators import MAKES
from slipscale.hardware.plate_file import sign
from tests.support import nidaqmx_on_disk
from tests.support.emulator_process import EmulatorProcess

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.context import ForkServerContext, ForkServerProcess

ALLOWED_S = 1.0
PATIENCE_S = 20.0
MEMORY_LIMIT_B = 400_000_000
GROUPS = Path("/sys/fs/cgroup/memory")
FELT_UM_PP = 0.1
HEARD = 300  # of 32,767: smaller samples are silence
BLOCK_B = 960  # 10 ms of sound
PLATE = """
[identity]
name = "{backend}"
[wiring]
backend = "{backend}"
[quantity]
name = "voltage"
unit = "V"
convention = "peak"
[limits]
voltage_v_peak = 30.0
tolerance_v_peak = 2.5
{band}
"""
BAND = "frequency_min_hz = 20.0\nfrequency_max_hz = 1000.0"
#: Record of an instrument: monotonic times at which its output changed, and whether it was then on.
Record = Callable[[], list[tuple[float, bool]]]


def session(
    spec: str, levels: tuple[float, ...], terminal: str, group: str, on: Connection
) -> None:
    """Present random levels until this process ends."""
    from slipscale.hardware.clock import SystemClock
    from slipscale.hardware.registry import open_plate
    from slipscale.hardware.signals import silent_on_signals
    from slipscale.stimuli.surface import VirtualSurface

    os.setsid()
    if terminal:
        os.open(terminal, os.O_RDWR)  # It becomes the terminal that controls this session.
    if group:
        (GROUPS / group / "cgroup.procs").write_text(str(os.getpid()))
    plate = open_plate(spec, clock=SystemClock())
    plate.connect()
    with suppress(KeyboardInterrupt, MemoryError), silent_on_signals(plate):
        while True:
            plate.second_level = random.choice(levels)
            plate.present(VirtualSurface(level=random.choice(levels)))
            on.send(True)
            end_s = time.monotonic() + random.uniform(0.1, 1.0)
            while time.monotonic() < end_s:
                plate.check()
                time.sleep(0.01)
                if on.poll():
                    taken = [bytes(50_000_000) + b"1" for _ in range(1000)]
                    print(len(taken))


def _killed(process: ForkServerProcess, _on: Connection, _terminal: int) -> None:
    os.kill(process.pid or 0, signal.SIGKILL)


def _stopped(process: ForkServerProcess, _on: Connection, _terminal: int) -> None:
    os.kill(process.pid or 0, signal.SIGSTOP)


def _without_memory(process: ForkServerProcess, on: Connection, _terminal: int) -> None:
    on.send(True)
    process.join(PATIENCE_S)


def _without_terminal(_process: ForkServerProcess, _on: Connection, terminal: int) -> None:
    os.close(terminal)


CAUSES = {
    "SIGKILL": _killed,
    "SIGSTOP": _stopped,
    "out of memory": _without_memory,
    "closed terminal": _without_terminal,
}


def plate_file(folder: Path, backend: str, band: str = "") -> Path:
    """Write the signed file of a plate in V peak."""
    path = folder / f"{backend}.toml"
    path.write_text(PLATE.format(backend=backend, band=band), encoding="utf-8")
    sign(path, beyond_by="A campaign", today=date(2026, 1, 1))
    return path


@contextmanager
def generator(folder: Path) -> Iterator[tuple[str, Record]]:
    """Serve an emulated generator of a random make."""
    with GeneratorServer(random.choice(sorted(MAKES))) as it:
        changes = [(time.monotonic(), False)]
        hear = it.generator.hear

        def recorded(line: str) -> str | None:
            answer, on = hear(line), it.generator.channel[1].plate_vpp() > 0
            if on != changes[-1][1]:
                changes.append((time.monotonic(), on))
            return answer

        it.generator.hear = recorded  # type: ignore[method-assign] # a recorder in its place
        plate = plate_file(folder, "scpi")
        yield f"scpi:{it.resource},plate={plate},frequency=30500,gain=2", lambda: changes


@contextmanager
def daq(folder: Path) -> Iterator[tuple[str, Record]]:
    """Use an emulated DAQ that outlives its processes (`prepare` makes it the library)."""
    device = Path(os.environ[nidaqmx_on_disk.FOLDER])
    (device / "output.txt").unlink(missing_ok=True)
    spec = f"daq:Dev1/ao0,plate={plate_file(folder, 'daq', BAND)},frequency=125,per_volt=20"
    yield spec, lambda: [(time_s, volt > 0) for time_s, volt in nidaqmx_on_disk.record(device)]


@contextmanager
def pair(folder: Path) -> Iterator[tuple[str, Record]]:
    """Use a generator and a DAQ."""
    with generator(folder) as (first, one), daq(folder) as (second, other):
        yield f"pair:{first}+{second}", lambda: _either(one(), other())


def _either(*records: list[tuple[float, bool]]) -> list[tuple[float, bool]]:
    """Return when any of several outputs was on."""
    changes = sorted((time_s, n, on) for n, record in enumerate(records) for time_s, on in record)
    state, found = [False] * len(records), []
    for time_s, n, on in changes:
        state[n] = on
        found.append((time_s, any(state)))
    return found


@contextmanager
def board(_folder: Path) -> Iterator[tuple[str, Record]]:
    """Emulate a board in a separate process, and ask for its state all the time."""
    changes, over = [(time.monotonic(), False)], False
    with EmulatorProcess("--no-dtr") as it:

        def watch() -> None:
            while not over:
                on = it.state()["amplitude_um_pp"] > FELT_UM_PP
                if on != changes[-1][1]:
                    changes.append((time.monotonic(), on))
                time.sleep(0.005)

        thread = Thread(target=watch)
        thread.start()
        try:
            yield f"serial:{it.port}", lambda: changes
        finally:
            over = True
            thread.join()


@contextmanager
def sound(folder: Path) -> Iterator[tuple[str, Record]]:
    """Listen to the null sink of the sound server (`prepare` starts it)."""
    changes = [(time.monotonic(), False)]
    command = ["parec", "--device=plate.monitor", "--rate=48000", "--channels=1"]
    with subprocess.Popen(
        [*command, "--format=s16le", "--latency-msec=10"], stdout=subprocess.PIPE
    ) as heard:

        def listen() -> None:
            while heard.stdout and len(data := heard.stdout.read(BLOCK_B)) == BLOCK_B:
                on = max(map(abs, array("h", data)), default=0) > HEARD
                if on != changes[-1][1]:
                    changes.append((time.monotonic(), on))

        thread = Thread(target=listen)
        thread.start()
        try:
            plate = plate_file(folder, "sound", "frequency_min_hz = 5000.0")
            yield (
                f"sound:pulse,plate={plate},frequency=8000,full_scale=40,rate=48000",
                lambda: changes,
            )
        finally:
            heard.kill()
            thread.join()


DEVICES = {
    "generator": (generator, (5.0, 8.0, 12.0)),
    "DAQ": (daq, (5.0, 8.0, 12.0)),
    "pair": (pair, (5.0, 8.0, 12.0)),
    "board": (board, (0.8, 1.2, 2.0)),
    "sound card": (sound, (5.0, 8.0, 12.0)),
}


@contextmanager
def prepare(folder: Path) -> Iterator[None]:
    """Install the emulated DAQ, and start a sound server if there is one."""
    os.environ.update(nidaqmx_on_disk.install(folder))
    os.environ["XDG_RUNTIME_DIR"] = str(folder)
    sys.path.insert(0, str(folder))
    server = None
    if shutil.which("pulseaudio"):
        (folder / "asound.conf").write_text(
            'pcm.pulse { type pulse hint { show on description "pulse" } }\n'
            "ctl.pulse { type pulse }\npcm.!default { type pulse }\nctl.!default { type pulse }\n"
        )
        os.environ["ALSA_CONFIG_PATH"] = str(folder / "asound.conf")
        modules = ["module-null-sink sink_name=plate rate=48000", "module-native-protocol-unix"]
        words = [word for module in modules for word in ("-L", module)]
        command = ["pulseaudio", "-n", "--exit-idle-time=-1", "--daemonize=no", *words]
        server = subprocess.Popen(command, stderr=subprocess.DEVNULL)
        time.sleep(2.0)
    try:
        yield
    finally:
        if server:
            server.kill()
            server.wait()


def once(device: str, cause: str, context: ForkServerContext) -> float | None:
    """Run a session on a device and end it; return how long the output was then on, in s.

    Returns None if the session had already ended with a fault, because the computer was busy.
    """
    opened, levels = DEVICES[device]
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory(prefix="slipscale-unattended-")))
        spec, record = stack.enter_context(opened(folder))
        group = "" if cause != "out of memory" else stack.enter_context(control_group())
        master, slave = pty.openpty()
        terminal = os.ttyname(slave) if cause == "closed terminal" else ""
        here, there = context.Pipe()
        process = context.Process(target=session, args=(spec, levels, terminal, group, there))
        process.start()
        there.close()
        try:
            if not here.poll(PATIENCE_S):
                raise RuntimeError(f"{device}: the session did not start")
            time.sleep(random.uniform(0.0, 1.5))
            until_s = time.monotonic() + PATIENCE_S
            while not record()[-1][1] and time.monotonic() < until_s:
                time.sleep(0.001)  # A ramp or a gap of the sound; only what is on can stay on.
            if not process.is_alive():
                return None
            began_s = time.monotonic()
            CAUSES[cause](process, here, master)
            # The kernel ends a process without memory later than this process asked for it.
            ended_s = time.monotonic() if cause == "out of memory" else began_s
            while record()[-1][1] and time.monotonic() < ended_s + PATIENCE_S:
                time.sleep(0.01)
            time.sleep(0.3)  # It must also stay off.
            off_s = record()[-1][0] if not record()[-1][1] else time.monotonic()
            return max(off_s - ended_s, 0.0)
        finally:
            with suppress(ProcessLookupError):
                os.kill(process.pid or 0, signal.SIGKILL)
            process.join()
            for descriptor in (slave, *([] if terminal else [master])):
                os.close(descriptor)


@contextmanager
def control_group() -> Iterator[str]:
    """Create a control group with a limit of memory."""
    group = GROUPS / f"slipscale-{os.getpid()}"
    group.mkdir()
    (group / "memory.limit_in_bytes").write_text(str(MEMORY_LIMIT_B))
    try:
        yield group.name
    finally:
        for _ in range(100):  # The guard may still be in the group.
            with suppress(OSError):
                group.rmdir()
                break
            time.sleep(0.1)


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the campaign."""
    parser.add_argument("--times", type=int, default=5, help="per device and cause (default: 5)")
    parser.add_argument("--device", choices=DEVICES, action="append", help="default: all")
    parser.add_argument("--cause", choices=CAUSES, action="append", help="default: all")
    parser.add_argument("--seed", type=int, default=1)


def run(args: Namespace) -> tuple[int, str]:
    """End sessions, and return the exit status and the table of results."""
    random.seed(args.seed)
    rows, late = [], 0
    with TemporaryDirectory(prefix="slipscale-unattended-") as folder, prepare(Path(folder)):
        context = mp.get_context("forkserver")
        context.set_forkserver_preload(["slipscale.hardware.plate_file", __name__])
        for device in args.device or DEVICES:
            if device == "sound card" and not shutil.which("pulseaudio"):
                print("sound card: left out, because there is no sound server")
                continue
            for cause in args.cause or CAUSES:
                found, ended = [], 0
                while len(found) < args.times:
                    if (on_s := once(device, cause, context)) is None:
                        ended += 1
                    else:
                        found.append(on_s)
                on = sum(each > ALLOWED_S for each in found)
                late += on
                rows.append(
                    f"| {device} | {cause} | {len(found)} | {on} | {median(found):.2f} s "
                    f"| {max(found):.2f} s | {ended} |"
                )
                print(rows[-1], flush=True)
    head = "| device | cause | sessions | on after 1 s | median | longest | ended before |"
    line = "| --- " * head.count(" | ") + "| --- |"
    return int(late > 0), "\n\n" + "\n".join([head, line, *rows])
