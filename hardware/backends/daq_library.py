"""Load the library for National Instruments devices."""

from __future__ import annotations

from typing import Any

from slipscale.faults import UserError


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
