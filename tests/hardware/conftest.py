from contextlib import ExitStack

import pytest

from hardware.emulator.process import EmulatorProcess


@pytest.fixture
def emulate():
    """Start emulated boards, each in its own process; all end with the test."""
    with ExitStack() as stack:
        yield lambda *arguments: stack.enter_context(EmulatorProcess(*arguments))


@pytest.fixture(scope="module")
def board():
    """One emulated board for a whole module: it restarts whenever a host lets go of it."""
    with EmulatorProcess("--back-after", "0.5", "--noise", "0") as board:
        yield board
