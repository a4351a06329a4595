"""Hold the connection to a function generator in the guard process, and switch its output off."""

from __future__ import annotations

import sys

from slipscale.hardware.backends.generator_dialects import Dialect
from slipscale.hardware.backends.generator_line import GeneratorLine
from slipscale.hardware.backends.generator_output import GeneratorOutput
from slipscale.hardware.errors import PlateFault


class GuardedGenerator(GeneratorLine):
    """Connection to a generator whose output can be switched off at any time.

    Parameters
    ----------
    resource : str
        VISA resource.
    channel : int
        Output channel, 1 or 2.
    chosen : Dialect or None
        Commands for this make of generator; by default, the make is identified with ``*IDN?``.
    """

    def __init__(self, resource: str, channel: int, chosen: Dialect | None) -> None:
        # PyVISA works without NumPy, whose import takes longer than everything else.
        sys.modules.setdefault("numpy", None)  # type: ignore[arg-type]
        super().__init__(resource)
        self._output = GeneratorOutput(self, channel, chosen)

    def switch_off(self) -> None:
        """Switch the output off; the next attempt after a `PlateFault` opens the resource again."""
        try:
            if not self.opened:
                self.open()
            self._output.identify()
            self._output.switch_off()
        except PlateFault:
            self.release()
            raise
