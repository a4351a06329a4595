"""The reference firmware, built for this computer, and the emulated board: one and the same.

Both are replayed against the transcript in docs/board-protocol.md, then against each other.
"""

import random
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from hardware import board_protocol as wire
from hardware.board import Board
from hardware.plate.twin import Room, Twin

ROOT = Path(__file__).parents[2]
FIRMWARE = ROOT / "hardware" / "firmware"
PAGE = ROOT / "docs" / "board-protocol.md"
COMPILER = shutil.which("g++") or shutil.which("c++") or shutil.which("clang++")
FLAGS = ["-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]

needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C++ compiler on this machine")


def transcript():
    (block,) = re.findall(r"```transcript\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    return block.splitlines()


def told(lines):
    return [line for line in lines if line[0] in ">."]


def answers(lines):
    return [line for line in lines if line[0] == "<"]


def emulated(lines):
    """Replay the host's side of a transcript on the emulated board, its plate without drift."""
    twin = Twin(room=Room(warm_up_k=0, wander_k=0), noise_um=0)
    board, now_ms, heard = Board(twin, boot=42), 0, []
    for line in lines:
        if line[0] == ".":
            for _ in range(int(line[2:])):
                now_ms += 1
                board.tick(now_ms / 1000)
        else:
            for _, reply in board.receive(line[2:].encode() + b"\n", now_ms / 1000):
                heard.append("< " + reply.decode().rstrip())
    return heard


@pytest.fixture(scope="module")
def firmware(tmp_path_factory):
    program = tmp_path_factory.mktemp("firmware") / "replay"
    sources = [FIRMWARE / "host" / "replay.cpp", FIRMWARE / "slipscale_plate" / "plate_board.cpp"]
    folder = FIRMWARE / "slipscale_plate"
    subprocess.run([COMPILER, *FLAGS, "-I", folder, *sources, "-o", program], check=True)

    def replay(lines):
        done = subprocess.run(
            [program], input="\n".join(lines) + "\n", capture_output=True, text=True, check=True
        )
        return [line.rstrip() for line in done.stdout.splitlines()]

    return replay


def test_the_emulated_board_follows_the_documented_transcript():
    lines = transcript()
    assert len(answers(lines)) > 20
    assert emulated(told(lines)) == answers(lines)


@needs_compiler
def test_the_firmware_follows_the_documented_transcript(firmware):
    lines = transcript()
    assert firmware(told(lines)) == answers(lines)


BODIES = """*IDN? | *RST | SYST:ERR? | LIM? | AMPL 0 | AMPL 0.5 | AMPL 1.2 | AMPL 2.3 | AMPL 2.5
AMPL 2.51 | AMPL -1 | AMPL +1 | AMPL 1. | AMPL .5 | AMPL 1e0 | AMPL nan | AMPL | AMPL 1,2
AMPL 00000001 | AMPL 0.1234567 | DRIV 30500,3 | DRIV 24999,3 | DRIV 30500 | DRIV 30500,17
DRIV 30500,1,2 | OUTP OFF | OUTP 0 | OUTP ON | OUTP | OUTP OFF,1 | STAT? 1 | FOO | FOO 1 | *IDN"""


def any_session(seed):
    """Return commands good and bad, repetitions, noise, waits; ``STAT?`` only once settled."""
    chance = random.Random(seed)
    lines = []
    for sequence in range(1, 60):
        body = chance.choice(re.split(r" \| |\n", BODIES))
        command = "> " + wire.command_frame(sequence, body).decode().strip()
        noise = chance.choice(["> !", "> >7 junk", "> noise" + command[2:], "> " + command[3:]])
        status = "> " + wire.command_frame(1000 + sequence, "STAT?").decode().strip()
        lines += [command] * chance.choice([1, 1, 1, 2])
        lines += [noise] * chance.choice([0, 0, 1])
        lines += [f". {chance.choice([60, 60, 120, 700])}", status]
    return lines


@needs_compiler
@pytest.mark.parametrize("seed", range(20))
def test_firmware_and_emulated_board_answer_alike_whatever_is_said(firmware, seed):
    session = any_session(seed)
    assert firmware(session) == emulated(session)
