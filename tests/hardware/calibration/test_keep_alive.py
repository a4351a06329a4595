"""Questions at the terminal while a plate vibrates."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from slipscale.hardware.calibration.keep_alive import typed


class Keyboard:
    """A pipe in the keyboard's place."""

    def __init__(self, monkeypatch):
        read, self.write = os.pipe()
        self.stdin = os.fdopen(read)
        monkeypatch.setattr("sys.stdin", self.stdin)

    def type(self, text):
        os.write(self.write, text.encode())


@pytest.fixture
def keyboard(monkeypatch):
    keyboard = Keyboard(monkeypatch)
    yield keyboard
    os.close(keyboard.write)
    keyboard.stdin.close()


def test_what_vibrates_is_kept_alive_until_a_line_was_typed(keyboard, capsys):
    calls = []

    def alive():
        calls.append(time.monotonic())
        if len(calls) == 4:
            keyboard.type("1,2\n")

    assert typed("reading: ", alive) == "1,2"
    assert len(calls) >= 4
    assert capsys.readouterr().out == "reading: \n"  # input that is not a terminal is not shown


def test_lines_typed_ahead_answer_one_question_each(keyboard):
    keyboard.type("one\r\ntwö\n")
    assert [typed("", lambda: None) for _ in range(2)] == ["one", "twö"]


def test_a_fault_ends_the_question_at_once(keyboard):
    def alive():
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        typed("reading: ", alive)
    keyboard.type("\n")  # ends the reader


def test_the_end_of_the_input_is_told(monkeypatch, keyboard):
    with Path(os.devnull).open(encoding="utf-8") as nothing:
        monkeypatch.setattr("sys.stdin", nothing)
        with pytest.raises(EOFError):
            typed("reading: ", lambda: None)


ASKS = """
from slipscale.hardware.calibration.keep_alive import typed
from slipscale.hardware.signals import EndedBySignal, signals_raise
try:
    with signals_raise():
        print("ready", flush=True)
        typed("reading: ", lambda: None)
except EndedBySignal as signal:
    print("ended by", signal, flush=True)
"""


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGQUIT", "SIGTSTP"])
def test_a_signal_in_the_instant_the_question_appears_is_not_lost(name):
    with subprocess.Popen(
        [sys.executable, "-c", ASKS], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "ready\n"
        process.stdout.read(1)  # the question appears
        process.send_signal(getattr(signal, name))
        assert process.stdout.read().endswith(f"ended by {name}\n")
    assert process.returncode == 0
