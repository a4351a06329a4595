"""The object behind a component in the scripts that Builder writes."""

from __future__ import annotations

from psychopy.constants import NOT_STARTED
from psychopy.hardware import DeviceManager


class PlateOutput:
    """One component's use of a plate; several components may share the plate.

    Parameters
    ----------
    device : str
        The plate's name in the device manager.

    Attributes
    ----------
    amplitude_um_pp : float
        What the next start asks for, µm peak to peak.
    readback_um_pp : float or None
        What the plate told after the last start, µm peak to peak.

    Raises
    ------
    ValueError
        The device manager has no device of that name.
    """

    def __init__(self, device: str) -> None:
        plate = DeviceManager.getDevice(device)
        if plate is None:
            raise ValueError(
                f"there is no device named '{device}': add a Slipscale plate of that name in "
                "Builder's device manager"
            )
        self.status = NOT_STARTED  # PsychoPy's scripts keep their own state here
        self.amplitude_um_pp = 0.0
        self.readback_um_pp: float | None = None
        self._plate = plate
        self._on = False

    def start(self) -> None:
        """Ramp to the amplitude; return once it has settled, some tens of milliseconds later."""
        self._on = True
        made = self._plate.present(float(self.amplitude_um_pp))
        self.readback_um_pp = made.readback.level

    def check(self) -> None:
        """Raise the fault that has come up, if any."""
        self._plate.check()

    def stop(self) -> None:
        """Stop the vibration, if this component started it."""
        if self._on:
            self._on = False
            self._plate.silence()
