import pytest

from tools.rehearsal.emulator_process import EmulatorProcess

# On a loaded machine a host or an emulator may stand still for longer than a usual watchdog waits.
PATIENT = ("--watchdog", "2000")


@pytest.fixture(scope="module")
def board():
    """One emulated board for a whole module: it restarts whenever a host lets go of it."""
    with EmulatorProcess("--back-after", "0.5", "--noise", "0", *PATIENT) as board:
        yield board


@pytest.fixture(scope="module")
def board_that_waits():
    """One emulated board for a whole module: away, it comes back when the test says so."""
    with EmulatorProcess("--back-after", "0", "--noise", "0", *PATIENT) as board:
        yield board
