"""`slipscale plate watch`: the readback over time, and a plate that is silent afterwards."""

import signal
import subprocess
import sys

import numpy as np
import pytest

from slipscale import commands
from slipscale.hardware.cli.watch import COLUMNS, line, readbacks
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.errors import ConnectionLost
from slipscale.hardware.records import Readback
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.surface import VirtualSurface


def bar(text):
    return text[18 : 18 + COLUMNS + 1]


@pytest.mark.parametrize("um_pp, filled", [(0.0, 0), (1.25, 30), (2.5, 60), (9.0, 60)])
def test_a_bar_is_as_long_as_the_amplitude_and_no_longer_than_the_scale(um_pp, filled):
    readback = Readback(level=um_pp, kind="measured", time_s=0.0)
    drawn = bar(line(readback, 0.0, 0.0, 2.5))
    assert len(drawn) == COLUMNS + 1
    assert drawn[1:].count("#") == max(filled - 1, 0)
    assert drawn[0] == "|"


def test_a_plate_that_measures_nothing_says_so():
    readback = Readback(level=None, kind="none", time_s=0.0)
    assert line(readback, 1.0, 1.0, 2.5).split() == ["1.0", "n/a", "none"]


def test_readbacks_come_at_their_interval():
    clock = VirtualClock()
    with open_plate("mock", clock=clock) as plate:
        plate.present(VirtualSurface(level=1.0))
        times_s = [each.time_s for each in readbacks(plate, clock, 0.5, 2.9)]
    assert len(times_s) == 6
    assert np.diff(times_s) == pytest.approx(0.5, abs=0.05)


def test_a_fault_between_two_readbacks_comes_up():
    clock = VirtualClock()
    with open_plate("mock:fault=lost@check/3", clock=clock) as plate:
        plate.present(VirtualSurface(level=1.0))
        with pytest.raises(ConnectionLost):
            list(readbacks(plate, clock, 10.0, 30.0))


def test_the_amplitude_that_is_there_is_plotted_and_the_plate_silent_afterwards(host, capsys):
    board = host.plug_in("--noise", "0")
    words = ["plate", "watch", f"serial:{board.port}", "--amplitude", "2", "--seconds", "0.5"]
    assert commands.main(words) == 0
    heading, *lines = capsys.readouterr().out.splitlines()
    assert heading.startswith("time s   µm p-p")
    assert len(lines) == 5
    assert all(float(each.split()[1]) == pytest.approx(2.0, abs=0.1) for each in lines)
    assert bar(lines[0]).index("|") == 48
    assert not board.state()["vibrates"]


@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM"])
def test_however_it_is_ended_the_plate_is_silent(emulate, how):
    board = emulate("--watchdog", "2000")
    words = [sys.executable, "-m", "tests.support.patient_host", "plate", "watch"]
    words += [f"serial:{board.port}"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    process.stdout.readline()
    process.stdout.readline()
    assert board.state()["vibrates"]
    process.send_signal(getattr(signal, how))
    process.communicate()
    assert not board.state()["vibrates"]


def test_more_than_the_plate_may_is_refused(capsys):
    assert commands.main(["plate", "watch", "mock", "--amplitude", "9"]) == 2
    assert "--amplitude: 9, expected 0 to 2.5 µm peak to peak" in capsys.readouterr().err


def test_a_plate_in_volts_is_watched_in_volts(plate_in_volts, capsys):
    path = plate_in_volts("mock", tolerance_v_peak=2.0)
    watch = ["plate", "watch", f"mock:plate={path}", "--seconds", "0.2", "--amplitude"]
    assert commands.main([*watch, "60"]) == 0
    assert "time s   V peak   0 " in capsys.readouterr().out
    assert commands.main([*watch, "140"]) == 2
    assert "--amplitude: 140, expected 0 to 130 V peak\n" in capsys.readouterr().err
