"""Simulated function generators on a socket of this machine."""

from contextlib import ExitStack

import pytest

from slipscale.hardware.emulator.generator_server import GeneratorServer


@pytest.fixture
def bench():
    """Return a maker of simulated generators, by make; all end with the test."""
    with ExitStack() as stack:

        def made(make, **options):
            server = stack.enter_context(GeneratorServer(make, **options))
            for channel in server.generator.channel.values():
                channel.on = True  # left on by the person who used it before
            return server

        yield made
