"""Load the library for National Instruments devices, and set their outputs to 0 V."""

from __future__ import annotations

from typing import Any

from slipscale.faults import UserError

TERMINAL_V = 10.0  # largest output voltage, peak


def load_library() -> Any:
    """Import the module ``nidaqmx``. Raises `UserError` if the module is missing."""
    try:
        import nidaqmx
    except ImportError:
        raise UserError(
            "daq: the library nidaqmx is not installed: pip install 'slipscale[daq]', and "
            "NI's own driver (NI-DAQmx)"
        ) from None
    return nidaqmx


def hold_at_zero(library: Any, channel: str) -> None:
    """Set an analogue output to 0 V; it keeps this voltage after the task has ended."""
    with library.Task() as task:
        task.ao_channels.add_ao_voltage_chan(channel, min_val=-TERMINAL_V, max_val=TERMINAL_V)
        task.write(0.0, auto_start=True)
