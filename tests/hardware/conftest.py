import pytest


@pytest.fixture
def board(host):
    """An emulated board in virtual time."""
    return host.plug_in("--back-after", "0.5", "--noise", "0")


@pytest.fixture
def board_that_waits(host):
    """An emulated board in virtual time: unplugged, it comes back when the test says so."""
    return host.plug_in("--back-after", "0", "--noise", "0")
