"""The driver over real pseudo-terminals, with boards and hosts in processes of their own.

What depends on time is tested in virtual time in test_driver.py. Here the driver's time-outs are
long, tests wait for conditions, and boards have the longest watchdog.
"""

import os
import signal
import subprocess
import sys
import time

import pytest
import serial

from slipscale.hardware.backends.serial_board.driver import SerialBoard
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.errors import ConnectionLost, NoPermission, PlateBusy, PlateNotFound
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.surface import VirtualSurface
from slipscale.stimuli.texture import Grating
from tests.support.patient_host import PatientHost

SURFACE = VirtualSurface(level=1.2)
TEXTURE = Grating(spatial_period_mm=2.5, waveform="square", mean_level=1.2, depth_level=0.8)
WATCHDOG = ("--watchdog", "2000")


def serial_plate(board):
    return SerialBoard(board.port, clock=SystemClock(), host=PatientHost())


def wait_for(condition, *, at_most_s=120.0):
    """Poll for something that another process does; the bound only ends a broken test."""
    end_s = time.monotonic() + at_most_s
    while not condition():
        assert time.monotonic() < end_s
        time.sleep(0.01)


@pytest.mark.parametrize("options", [[], ["--firmware"]])
def test_surfaces_and_textures_are_presented_held_and_silenced(emulate, options):
    board = emulate("--noise", "0", *WATCHDOG, *options)
    with serial_plate(board) as plate:
        assert plate.identity.model == "slipscale-plate-1"
        presentation = plate.present(SURFACE)
        assert presentation.readback.kind == "measured"
        assert presentation.readback.level == pytest.approx(1.2, abs=0.03)
        assert plate.present(TEXTURE).commanded_level == 1.2
        for _ in range(50):  # some heartbeats
            time.sleep(0.01)
            plate.check()
        assert board.state()["state"] == "LIST"
        plate.silence()
        assert not board.state()["vibrates"]
        plate.present(SURFACE)
    assert not board.state()["vibrates"]


def test_unplugged_is_told_and_found_again_when_it_is_plugged_in(emulate):
    board = emulate("--back-after", "0", *WATCHDOG)
    plate = serial_plate(board)
    plate.connect()
    plate.present(SURFACE)
    board.unplug()

    def lost():
        try:
            plate.check()
        except ConnectionLost:
            return True
        return False

    wait_for(lost)
    plate.close()
    with pytest.raises(PlateNotFound):
        plate.connect()
    board.back()
    with plate:
        plate.present(SURFACE)


def test_no_such_port():
    with pytest.raises(PlateNotFound, match="/dev/ttyNONE: no such port"):
        open_plate("serial:/dev/ttyNONE", clock=SystemClock()).connect()


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="file permissions as Unix has them")
def test_no_permission_names_the_group_to_join(monkeypatch):
    def refuse(*args, **kwargs):
        raise serial.SerialException(13, "could not open port: Permission denied")

    monkeypatch.setattr(serial, "serial_for_url", refuse)  # root may open anything
    with pytest.raises(NoPermission, match="dialout"):
        open_plate("serial:/dev/ttyACM0", clock=SystemClock()).connect()


def test_a_port_that_another_program_holds_is_busy(emulate):
    board = emulate()
    with (
        serial.Serial(board.port, exclusive=True),
        pytest.raises(PlateBusy, match="another program"),
    ):
        serial_plate(board).connect()


HOST = """
import sys, time
from slipscale.hardware.backends.serial_board.driver import SerialBoard
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.signals import silent_on_signals
from slipscale.stimuli.surface import VirtualSurface
from tests.support.patient_host import PatientHost

plate = SerialBoard(sys.argv[1], clock=SystemClock(), host=PatientHost())
with silent_on_signals(plate):
    plate.connect()
    plate.present(VirtualSurface(level=2.3))
    print("presented", flush=True)
    if sys.argv[2] == "raise":
        raise ValueError
    while True:
        time.sleep(0.01)
        plate.check()
"""


def host_of(board, way):
    process = subprocess.Popen(
        [sys.executable, "-c", HOST, board.port, way],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    assert process.stdout.readline() == "presented\n"
    return process


@pytest.mark.parametrize("way", ["raise", "SIGINT", "SIGTERM", "SIGHUP", "SIGKILL", "SIGSTOP"])
def test_however_the_host_ends_the_plate_falls_silent(emulate, way):
    board = emulate("--no-dtr", *WATCHDOG)  # nothing but the stop command and the watchdog helps
    process = host_of(board, way)
    try:
        if way != "raise":
            process.send_signal(getattr(signal, way))
        wait_for(lambda: not board.state()["vibrates"])
        stopped_by_watchdog = board.state()["state"] == "WDOG"
        assert stopped_by_watchdog == (way in ("SIGKILL", "SIGSTOP"))
    finally:
        process.kill()
        process.communicate()
