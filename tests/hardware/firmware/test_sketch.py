"""The sketch compiles for each processor: by its own compiler, or against declared stubs."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
SKETCH = ROOT / "hardware" / "firmware" / "slipscale_plate"
STUBS = Path(__file__).parent / "arduino_stubs"
CORE = Path("/usr/share/arduino/hardware/arduino/avr")  # Debian's arduino-core-avr
WARNINGS = ["-Wall", "-Wextra", "-Werror"]
HOST = shutil.which("g++") or shutil.which("c++") or shutil.which("clang++")
AVR = shutil.which("avr-g++")

PROCESSORS = {
    "ESP32, IDF 5": ["-DARDUINO_ARCH_ESP32"],
    "ESP32, IDF 4": ["-DARDUINO_ARCH_ESP32", "-DESP_IDF_VERSION_MAJOR=4"],
    "Teensy 4": ["-D__IMXRT1062__"],
}
AVR_BOARDS = {
    "Uno": ("standard", ["-mmcu=atmega328p"]),
    "Leonardo": ("leonardo", ["-mmcu=atmega32u4", "-DUSB_VID=0x2341", "-DUSB_PID=0x8036"]),
}


def compiled(command):
    sketch = ["-x", "c++", "-include", "Arduino.h", SKETCH / "slipscale_plate.ino"]
    return subprocess.run([*command, *sketch], capture_output=True, text=True, check=False)


@pytest.mark.skipif(HOST is None, reason="no C++ compiler on this machine")
@pytest.mark.parametrize("processor", PROCESSORS)
def test_the_sketch_compiles_against_the_stubs(processor):
    done = compiled(
        [HOST, "-std=c++11", "-fsyntax-only", *WARNINGS, *PROCESSORS[processor], "-I", STUBS]
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(HOST is None, reason="no C++ compiler on this machine")
def test_a_processor_that_nobody_described_is_told():
    done = compiled([HOST, "-std=c++11", "-fsyntax-only", "-I", STUBS])
    assert "neither AVR, ESP32 nor Teensy 4" in done.stderr


@pytest.mark.skipif(
    AVR is None or not CORE.exists(), reason="needs gcc-avr, avr-libc and arduino-core-avr"
)
@pytest.mark.parametrize("board", AVR_BOARDS)
def test_the_sketch_and_the_rules_compile_for_arduino_boards(board, tmp_path):
    variant, flags = AVR_BOARDS[board]
    folders = [CORE / "cores" / "arduino", CORE / "variants" / variant]
    folders += [CORE / "libraries" / each / "src" for each in ("SPI", "Wire", "EEPROM")]
    includes = [word for folder in (*folders, SKETCH) for word in ("-I", folder)]
    # The compiler is older than its core expects: DECIMAL_DIG.
    common = ["-std=gnu++11", "-Os", "-DF_CPU=16000000L", "-DARDUINO=10819", "-DDECIMAL_DIG=17"]
    common += ["-DARDUINO_ARCH_AVR", *flags, *WARNINGS, *includes, "-c"]
    done = compiled([AVR, *common, "-o", tmp_path / "sketch.o"])
    assert done.returncode == 0, done.stderr
    for source in SKETCH.glob("*.cpp"):
        subprocess.run([AVR, *common, source, "-o", tmp_path / f"{source.stem}.o"], check=True)


def test_the_sketch_tells_the_firmwares_version():
    told = [
        re.search(r"slipscale-plate-1,[^,]+,([\d.]+)\"", (SKETCH / name).read_text("utf-8"))[1]
        for name in ("slipscale_plate.ino", "plate_board.h")
    ]
    assert told[0] == told[1]
