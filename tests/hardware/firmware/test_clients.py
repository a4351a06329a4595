"""The client in C presents an amplitude on an emulated board; the one in MATLAB has no test.

The board's time advances with each command, so that its watchdog does not depend on the machine.
"""

import os
import shutil
import subprocess
import tty
from pathlib import Path
from threading import Thread

import pytest

import slipscale.hardware
from slipscale.hardware.emulator.firmware import Board
from slipscale.hardware.plate.twin import Twin

SOURCE = Path(slipscale.hardware.__file__).parent / "firmware/clients/present.c"
COMMAND_S = 0.1  # the client asks for the status every 100 ms


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    if not shutil.which("gcc"):
        pytest.skip("needs gcc")
    made = tmp_path_factory.mktemp("client") / "present"
    strict = ["-std=c11", "-D_DEFAULT_SOURCE", "-DANSWER_MS=60000", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(["gcc", *strict, "-o", str(made), str(SOURCE)], check=True)
    return made


@pytest.fixture
def present(program):
    """Return a function that runs the client, and gives its end, the commands and the board."""

    def run(amplitude, seconds):
        ours, theirs = os.openpty()
        tty.setraw(theirs)
        board, commands = Board(Twin(noise_um=0), boot=1), []

        def serve():
            while not (data := os.read(ours, 256)).endswith(b"end"):
                now_s = COMMAND_S * len(commands)
                board.tick(now_s)
                for command, answer in board.receive(data, now_s):
                    commands.append(command)
                    os.write(ours, b"<1 damaged*0000\n" + answer)

        server = Thread(target=serve)
        server.start()
        command = [str(program), os.ttyname(theirs), str(amplitude), str(seconds)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        os.write(theirs, b"end")
        server.join()
        os.close(ours)
        os.close(theirs)
        return done, commands, board

    return run


def test_the_client_presents_an_amplitude_and_leaves_the_plate_silent(present):
    done, commands, board = present(1.2, 0.5)
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert len(lines) == 5
    assert lines[-1].startswith("HOLD,1.2000,1.2")
    assert commands == ["AMPL 1.2", *["STAT?"] * 5, "OUTP OFF"]
    assert not board.vibrates


def test_a_refusal_is_told(present, program):
    done, commands, board = present(9, 0.5)
    assert done.returncode == 1
    assert done.stderr == "the board answered: -222 Data out of range\n"
    assert commands == ["AMPL 9", "OUTP OFF"]
    assert not board.vibrates
    nowhere = subprocess.run([str(program), "nowhere", "1", "1"], check=False, capture_output=True)
    assert nowhere.returncode == 2
