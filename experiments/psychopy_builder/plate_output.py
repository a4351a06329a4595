"""Run-time object for a component in scripts that Builder generates."""

from __future__ import annotations

from psychopy.constants import NOT_STARTED
from psychopy.hardware import DeviceManager


class PlateOutput:
    """Control of a plate by one Builder component. Several components can share a plate.

    Parameters
    ----------
    device : str
        Name of the plate in the device manager.

    Attributes
    ----------
    readback_level : float or None
        Level reported by the plate after the most recent start.

    Raises
    ------
    ValueError
        If the device manager has no device with this name.
    """

    def __init__(self, device: str) -> None:
        plate = DeviceManager.getDevice(device)
        if plate is None:
            raise ValueError(
                f"unknown device '{device}': add a Slipscale plate with that name in "
                "Builder's device manager"
            )
        self.status = NOT_STARTED  # PsychoPy's scripts store the component's state here
        self._amplitude_um_pp = 0.0
        self.readback_level: float | None = None
        self._plate = plate
        self._on = False

    @property
    def amplitude_um_pp(self) -> float:
        """Level to present at the next start, in µm peak to peak or in the plate's unit.

        Setting a value that is not a number raises ValueError.
        """
        return self._amplitude_um_pp

    @amplitude_um_pp.setter
    def amplitude_um_pp(self, value: object) -> None:
        try:
            self._amplitude_um_pp = float(str(value))
        except ValueError:
            raise ValueError(
                f"the amplitude of a Slipscale plate is {value!r}; expected a number: see the "
                "component's amplitude, and the column of the conditions file"
            ) from None

    def start(self) -> None:
        """Ramp to the amplitude, and return when it has settled (after tens of milliseconds)."""
        self._on = True
        made = self._plate.present(self.amplitude_um_pp)
        self.readback_level = made.readback.level

    @property
    def columns(self) -> dict[str, float | None]:
        """The level and its readback, keyed by column names for the plate's quantity."""
        named = self._plate.quantity.named
        return {
            named("level"): self.amplitude_um_pp,
            named("readback_level"): self.readback_level,
        }

    def check(self) -> None:
        """Raise a `PlateFault` if the plate has failed."""
        self._plate.check()

    def stop(self) -> None:
        """Stop the vibration, if this component started it."""
        if self._on:
            self._on = False
            self._plate.silence()
