"""The reference firmware, built for this computer, and the emulated board: one and the same.

Both replay docs/reference/board-transcript.txt, then are compared with each other.
"""

import random
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.emulator import compiled
from slipscale.hardware.emulator.firmware import Board
from slipscale.hardware.plate.dynamics import FingerLoad, Resonator
from slipscale.hardware.plate.twin import Surroundings, Twin
from slipscale.stimuli.modulation import DEFAULT_MODULATOR, Loop
from slipscale.stimuli.texture import Grating

ROOT = Path(__file__).parents[3]
FIRMWARE = ROOT / "hardware" / "firmware"
TRANSCRIPT = ROOT / "docs" / "reference" / "board-transcript.txt"
COMPILER = shutil.which("g++") or shutil.which("c++") or shutil.which("clang++")
FLAGS = ["-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]

SQUARE = Loop(levels=(2.0, 0.4), step_s=0.02, edge_s=0.002, mean_level=1.2)
WAVES = {
    "square": SQUARE,
    "sine": Grating(
        spatial_period_mm=7.3, mean_level=1.2, depth_level=1.2, finger_speed_mm_s=83
    ).loop(),
}
TIME_CONSTANT_MS = 1000 * DEFAULT_MODULATOR.time_constant_s

needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C++ compiler on this machine")


def transcript():
    return TRANSCRIPT.read_text(encoding="utf-8").splitlines()


def told(lines):
    return [line for line in lines if line[0] in ">."]


def answers(lines):
    return [line for line in lines if line[0] == "<"]


def emulated(lines):
    """Replay the host's side of a transcript on the emulated board, its plate without drift."""
    twin = Twin(surroundings=Surroundings(warm_up_k=0, wander_k=0), noise_um=0)
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
    folder = FIRMWARE / "slipscale_plate"
    sources = [FIRMWARE / "host" / "replay.cpp", *folder.glob("*.cpp")]
    subprocess.run([COMPILER, *FLAGS, "-I", folder, *sources, "-o", program], check=True)

    def replay(lines, *plate):
        done = subprocess.run(
            [program, *plate],
            input="\n".join(lines) + "\n",
            capture_output=True,
            text=True,
            check=True,
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


SANITIZERS = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]


def has_sanitizers(folder):
    program = [COMPILER, *SANITIZERS, "-x", "c++", "-", "-o", folder / "none"]
    done = subprocess.run(program, input=b"int main() {}", capture_output=True, check=False)
    return done.returncode == 0


@needs_compiler
def test_the_firmware_breaks_no_rule_whatever_comes(tmp_path):
    if not has_sanitizers(tmp_path):
        pytest.skip("no sanitizers on this machine")
    folder = FIRMWARE / "slipscale_plate"
    sources = [FIRMWARE / "host" / "fuzz.cpp", *folder.glob("*.cpp")]
    build = [COMPILER, *FLAGS, "-O1", *SANITIZERS, "-I", folder, *sources]
    subprocess.run([*build, "-o", tmp_path / "fuzz"], check=True)
    program = [tmp_path / "fuzz", "5000"]
    done = subprocess.run(program, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "5000 inputs, no finding\n"), done.stderr


BODIES = """*IDN? | *RST | SYST:ERR? | LIM? | AMPL 0 | AMPL 0.5 | AMPL 1.2 | AMPL 2.3 | AMPL 2.5
AMPL 2.51 | AMPL -1 | AMPL +1 | AMPL 1. | AMPL .5 | AMPL 1e0 | AMPL nan | AMPL | AMPL 1,2
AMPL 00000001 | AMPL 0.1234567 | DRIV 30500,3 | DRIV 24999,3 | DRIV 30500 | DRIV 30500,17
DRIV 30500,1,2 | OUTP OFF | OUTP 0 | OUTP ON | OUTP | OUTP OFF,1 | STAT? 1 | FOO | FOO 1 | *IDN
LIST:LIM? | LIST:LIM? 1 | LIST:AMPL 1,2,0.4 | LIST:AMPL 1,2,0.4 | LIST:AMPL 3,1.6,0.8 | LIST:AMPL
LIST:AMPL 1 | LIST:AMPL 0,1 | LIST:AMPL 1.5,1 | LIST:AMPL 1,2.6 | LIST:AMPL 1,,1 | LIST:AMPL 7,1
LIST:AMPL 2,1,1,1,1,1,1,1,1,1 | LIST:AMPL 1,1,1,1,1,1,1,1,1 | LIST:PLAY 2,20,2 | LIST:PLAY 2,20,2
LIST:PLAY 2,5,5 | LIST:PLAY 4,10,3 | LIST:PLAY 1,10,2 | LIST:PLAY 2,10,1 | LIST:PLAY 2,3,2
LIST:PLAY 2,10,11 | LIST:PLAY 2,10 | LIST:PLAY | LIST:PLAY 2,10,2,1 | LIST:PLAY 2,700000,2
LIST:PLAY 65,10,2 | LIST:FOO"""


def said(sequence, body):
    return "> " + wire.command_frame(sequence, body).decode().strip()


def playing(sequence, loop=SQUARE):
    """Yield what has the board play a loop, about the amplitude at which it has settled."""
    yield said(sequence, f"AMPL {loop.mean_level}")
    yield ". 120"
    for offset, body in enumerate(wire.list_commands(loop), 1):
        yield said(sequence + offset, body)


def any_session(seed):
    """Return commands good and bad, repetitions, noise, waits; ``STAT?`` only once settled."""
    chance = random.Random(seed)
    lines = [] if chance.random() < 0.3 else list(playing(60))
    for sequence in range(1, 60):
        body = chance.choice(re.split(r" \| |\n", BODIES))
        command = said(sequence, body)
        noise = chance.choice(["> !", "> >7 junk", "> noise" + command[2:], "> " + command[3:]])
        status = said(1000 + sequence, "STAT?")
        lines += [command] * chance.choice([1, 1, 1, 2])
        lines += [noise] * chance.choice([0, 0, 1])
        lines += [f". {chance.choice([60, 60, 120, 700])}", status]
    return lines


@needs_compiler
@pytest.mark.parametrize("seed", range(20))
def test_firmware_and_emulated_board_answer_alike_whatever_is_said(firmware, seed):
    session = any_session(seed)
    assert firmware(session) == emulated(session)


def watched(duration_ms, how="="):
    """Yield so much time, with a host that is alive."""
    for beat in range(duration_ms // 200):
        yield from (f"{how} 200", said(200 + beat, "STAT?"))


def on_the_plate(lines):
    """Return what the firmware drove and what the plate did, a row a millisecond."""
    return np.array([line.split()[1:] for line in lines if line[0] == "="], dtype=float).T


@needs_compiler
@pytest.mark.parametrize("wave", WAVES)
def test_the_firmware_drives_what_a_loop_says(firmware, wave):
    loop = WAVES[wave]
    driven, _ = on_the_plate(firmware([*playing(1, loop), *watched(2000)]))
    # The wire rounds a step to the microsecond.
    sent = Loop(
        levels=loop.levels,
        step_s=round(loop.step_s, 6),
        edge_s=loop.edge_s,
        mean_level=loop.mean_level,
    )
    due = [sent.at_level(ms / 1000 + 1e-9) for ms in range(1, 2001)]
    assert np.abs(driven - due).max() < 2e-4


@needs_compiler
@pytest.mark.parametrize("wave", WAVES)
def test_firmware_and_emulated_board_make_the_same_of_a_list(firmware, wave):
    loop = WAVES[wave]
    _, made = on_the_plate(firmware([*playing(1, loop), "= 400"], str(TIME_CONSTANT_MS)))
    twin = Twin(surroundings=Surroundings(warm_up_k=0, wander_k=0))
    board, now_ms, emulated_um_pp = Board(twin, boot=1), 0, []
    for line in [*playing(1, loop), ". 400"]:
        if line[0] == ">":
            board.receive(line[2:].encode() + b"\n", now_ms / 1000)
        for _ in range(int(line[2:]) if line[0] == "." else 0):
            now_ms += 1
            # The emulated drive is smooth; the firmware's holds each voltage for a millisecond,
            # which on average is half a millisecond late.
            emulated_um_pp.append(twin.amplitude_um_pp((now_ms - 0.5) / 1000))
            board.tick(now_ms / 1000)
    difference = np.abs(made - emulated_um_pp[-400:])
    assert difference.mean() < 0.02
    assert difference.max() < 0.2


@needs_compiler
def test_the_firmware_brings_a_plate_that_a_finger_damps_back_to_the_mean(firmware):
    said_and_done = firmware([*playing(1), *watched(1000)], str(TIME_CONSTANT_MS), "0.85")
    *_, status = answers(said_and_done)
    assert " LIST,1.2000,1.2000," in status
    _, made = on_the_plate(said_and_done)
    assert made[-400:].mean() == pytest.approx(1.2, abs=0.001)
    assert made[-400:].max() == pytest.approx(2.0, abs=0.01)
    assert made.max() < 2.1


@needs_compiler
def test_a_late_turn_of_the_firmware_does_not_pass_for_a_weak_plate(firmware):
    turns = [
        line for beat in range(30) for line in [". 9", "- 4"] * 8 + [said(200 + beat, "STAT?")]
    ]
    told = answers(firmware([*playing(1), *turns], str(TIME_CONSTANT_MS)))[-30:]
    means_um_pp = [float(line.split(",")[2]) for line in told]
    assert means_um_pp == pytest.approx([1.2] * 30, rel=0.01)


@needs_compiler
def test_a_drive_that_does_not_suffice_for_the_ridges_is_told(firmware):
    *_, status = answers(firmware([*playing(1), *watched(1000)], str(TIME_CONSTANT_MS), "0.75"))
    assert " SAT,1.2000," in status
    assert ",16.500," in status


@needs_compiler
@pytest.mark.parametrize("body", ["AMPL 2.3", "AMPL 0", "AMPL 1.2"])
@pytest.mark.parametrize("after_ms", [3, 21, 22, 39])
def test_whatever_follows_a_list_follows_without_a_step(firmware, body, after_ms):
    driven, _ = on_the_plate(firmware([*playing(1), f"= {after_ms}", said(80, body), "= 60"]))
    before, after = driven[:after_ms], driven[after_ms:]
    assert np.abs(np.diff(np.append(before[-1], after))).max() < 0.16
    assert after[-1] == pytest.approx(float(body.split()[1]))


@needs_compiler
def test_an_amplitude_in_the_middle_of_a_ramp_goes_on_from_there(firmware):
    ramped, _ = on_the_plate(firmware([said(1, "AMPL 2.3"), "= 10", said(2, "AMPL 0.5"), "= 60"]))
    assert np.abs(np.diff(ramped)).max() < 0.16
    assert ramped.max() < 1


# The plate, and how 1.2 and then 2.3 µm end there.
PLATES = {
    "free": ({}, {"HOLD"}),
    "finger": ({"finger": FingerLoad(loss=1 / 300)}, {"HOLD", "SAT"}),
    "heavy finger": ({"finger": FingerLoad(loss=1 / 60)}, {"SAT"}),
    "noise": ({"noise_um": 0.012, "seed": 8}, {"HOLD"}),
    "rings long": ({"resonator": Resonator(quality_factor=300)}, {"HOLD"}),
    "another gain": ({"resonator": Resonator(gain_um_pp_per_v=0.2)}, {"HOLD"}),
}


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return compiled.load(compiled.build(tmp_path_factory.mktemp("library")))


@needs_compiler
@pytest.mark.parametrize("plate", PLATES)
def test_firmware_and_emulated_board_settle_alike(library, plate):
    """Millisecond by millisecond, on the same plate with the same noise."""
    options, ends = PLATES[plate]
    one = Board(Twin(**options), boot=1)
    other = compiled.CompiledBoard(Twin(**options), 1, code=library)
    states = set()
    for now_ms in range(1, 400):
        now_s = now_ms / 1000
        bodies = {1: "AMPL 1.2", 150: "AMPL 2.3", 300: "AMPL 0"}
        for board in (one, other):
            board.tick(now_s)
            frame = wire.command_frame(now_ms, bodies.get(now_ms, "LIM?"))
            assert len(board.receive(frame, now_s)) == 1
        assert one.state == other.state
        assert other.twin.voltage_v(now_s) == pytest.approx(one.twin.voltage_v(now_s), abs=2e-3)
        states.add(one.state)
    assert states == {"RAMP", "OFF"} | ends
