"""The result of a calibration, which `slipscale plate calibrate` prints or returns as JSON."""

from __future__ import annotations

from pathlib import Path

from slipscale.faults.frozen_table import FrozenTable
from slipscale.faults.message import Message
from slipscale.hardware.calibration.record import Calibration, Gain, Resonance, VoltageConvention


class Result(FrozenTable):
    """Fitted resonance and gain, and the file that contains them (None if none was written)."""

    resonance: Resonance
    gain: Gain
    voltage_convention: VoltageConvention
    file: Path | None = None

    @property
    def facts(self) -> dict[str, str]:
        """The resonance, Q, gain and range as texts, keyed by name."""
        resonance, gain = self.resonance, self.gain
        return {
            "resonance": Message(
                "{frequency_hz:.1f} ± {ci95_hz:.1f} Hz",
                frequency_hz=resonance.frequency_hz,
                ci95_hz=resonance.frequency_ci95_hz,
            ),
            "Q": Message(
                "{quality_factor:.1f} ± {ci95:.1f}",
                quality_factor=resonance.quality_factor,
                ci95=resonance.quality_factor_ci95,
            ),
            "gain": Message(
                "{um_pp_per_v:.5f} ± {ci95_um_pp_per_v:.5f} µm p-p per {voltage_convention}",
                um_pp_per_v=gain.um_pp_per_v,
                ci95_um_pp_per_v=gain.um_pp_per_v_ci95,
                voltage_convention=self.voltage_convention,
            ),
            "range": Message(
                "0 to {amplitude_um_pp:.3f} µm p-p ({voltage_v:g} {voltage_convention})",
                amplitude_um_pp=gain.amplitude_max_um_pp,
                voltage_v=gain.voltage_max_v,
                voltage_convention=self.voltage_convention,
            ),
        }


def result_of(calibration: Calibration, file: Path | None = None) -> Result:
    """Return the result of a calibration."""
    return Result(
        resonance=calibration.resonance,
        gain=calibration.gain,
        voltage_convention=calibration.drive.voltage_convention,
        file=file,
    )
