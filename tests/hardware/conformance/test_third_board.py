"""A board in C that was written from the protocol's page alone, held against it and driven."""

import shutil
import subprocess
from pathlib import Path

import pytest

from slipscale.hardware.backends.serial_board.driver import SerialBoard
from slipscale.hardware.conformance.bench import Bench
from slipscale.hardware.conformance.table import examine
from slipscale.hardware.errors import PlateTimeout
from slipscale.stimuli.surface import VirtualSurface
from slipscale.stimuli.texture import Grating
from tools.campaigns.wrong_boards.virtual_line import VirtualLine

SOURCE = Path(__file__).with_name("third_board.c")
TEXTURE = Grating(
    spatial_period_mm=2.5, mean_level=1.2, depth_level=0.8, waveform="square", finger_speed_mm_s=50
)


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    compiler = shutil.which("cc") or shutil.which("gcc")
    if not compiler:
        pytest.skip("there is no C compiler")
    path = tmp_path_factory.mktemp("third") / "board"
    warnings = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1"]
    sanitizers = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    subprocess.run(
        [compiler, *warnings, *sanitizers, "-o", str(path), str(SOURCE), "-lm"], check=True
    )
    return path


class ThirdBoard:
    """The program, which advances to the time at which it receives something."""

    def __init__(self, process):
        self.process = process

    def receive(self, data, now_s):
        self.process.stdin.write(f"{round(now_s * 1000)} {data.hex()}\n")
        self.process.stdin.flush()
        return [("", bytes.fromhex(self.process.stdout.readline()))]

    def tick(self, now_s):
        pass


@pytest.fixture
def line(program):
    with subprocess.Popen(
        [program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        yield VirtualLine(ThirdBoard(process))
        process.stdin.close()
        assert process.wait() == 0  # the sanitizers found nothing


def driver(line, **options):
    return SerialBoard(line.port, clock=line, host=line, **options)


def test_it_conforms_to_every_rule(line):
    verdicts = examine(Bench(line, line))
    assert {v.rule: v.detail for v in verdicts if v.outcome == "departs"} == {}


def test_the_driver_presents_surfaces_and_textures_on_it_and_follows(line):
    with driver(line) as plate:
        assert plate.identity.manufacturer == "Third"
        assert plate.watchdog_s == 0.6
        for surface in (VirtualSurface(level=1.2), TEXTURE):
            presented = plate.present(surface)
            assert presented.readback.kind == "none"  # it has no sensor
            assert presented.readback.voltage_v_peak == pytest.approx(1.2 * 15 / 2.3, abs=0.01)
            checked_for(plate, 0.3)
        plate.present(VirtualSurface(level=1.2))
        for amplitude_um_pp in (0.4, 2.0, 0.0, 1.0):
            plate.follow(amplitude_um_pp)
            checked_for(plate, 0.15)
        assert plate.read_back().voltage_v_peak == pytest.approx(15 / 2.3, abs=0.01)
        plate.silence()
        assert plate.read_back().voltage_v_peak == 0


def checked_for(plate, duration_s):
    for _ in range(round(duration_s / 0.02)):
        plate.clock.sleep(0.02)
        plate.check()


def test_a_host_that_hangs_is_noticed_by_its_watchdog(line):
    with driver(line, attention_s=0.2) as plate:
        plate.present(VirtualSurface(level=1.2))
        line.sleep(0.95)  # above 1 s, the session itself reports that it stood still
        plate.read_back()  # the heart beats again, and hears what happened
        with pytest.raises(PlateTimeout, match="received nothing"):
            checked_for(plate, 2.0)
