"""Recompute numbers in the paper's text and Table II from other numbers in the paper.

To record the computed values in ``constants.json``, run ``python -m
slipscale.analysis.reproduction.constants``. Do this only after an intended change to a formula or
constant, and explain in the commit message why the numbers changed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from slipscale.analysis.published.biet2007 import PARTICIPANTS
from slipscale.analysis.reproduction.comparison import Outcome, record

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def alpha() -> Outcome:
    """Compute the ratio of the moduli, equation (26) and Table II."""
    from slipscale.hardware.plate.beam import BeamSection

    return Outcome(
        published="1.81",
        ours=BeamSection.printed().alpha,
        unit="",
        reason="the ratio of 123 GPa to c11p = 67.9 GPa from Table II; with c11p = 73.4 GPa from "
        "Appendix B, the ratio would be 1.67",
    )


def c11p() -> Outcome:
    """Compute the ceramic's modulus c11p (Table II) from the matrices in Appendix B."""
    from slipscale.hardware.plate.materials import P1_91

    return Outcome(
        published="6.79",
        ours=P1_91.plane_strain_pa / 1e10,
        unit="1e10 Pa",
        reason=(
            "computed as s11/(s11² - s12²) from Appendix B, which contradicts Table II. As in the "
            "paper, the beam model uses Table II and the finite-element model Appendix B"
        ),
    )


def d31() -> Outcome:
    """Compute the ceramic's charge constant d31 (Table II) from Appendix B."""
    from slipscale.hardware.plate.materials import P1_91

    return Outcome(
        published="-247",
        ours=P1_91.d31_m_v * 1e12,
        unit="1e-12 m/V",
        reason="computed as d = e s (Appendix B), but only the value in Table II reproduces Fig. 8",
    )


def plate_area() -> Outcome:
    """Compute the area of the touch surface (Section III-C)."""
    from slipscale.hardware.plate.geometry import Layout

    plate = Layout.prototype()
    return Outcome(
        published="40.67",
        ours=plate.length_mm * plate.width_mm / 100,
        unit="cm²",
        reason="83 mm by 49 mm",
    )


def plate_half_wave() -> Outcome:
    """Compute half the wavelength of the (8;0) mode (Section III-C)."""
    from slipscale.hardware.plate.geometry import Layout

    return Outcome(
        published="10.37",
        ours=Layout.prototype().length_mm / 8,
        unit="mm",
        reason=(
            "the plate's length of 83 mm, divided by 8. This is not the distance between nodal "
            "lines, because the ends are free; in the middle of the finite-element mode, the "
            "distance is 11.4 mm"
        ),
    )


def harmonic_cross() -> Outcome:
    """Compute the frequency of a half-wavelength section at the length marked in Fig. 9."""
    from slipscale.hardware.plate.geometry import Layout
    from slipscale.hardware.plate.paper_study import half_wave_frequency_hz

    return Outcome(
        published="34.77",
        ours=half_wave_frequency_hz(Layout.half_wave(83 / 8)) / 1e3,
        unit="kHz",
        reason=(
            "computed for a half-wavelength section of 10.37 mm, the length at which Fig. 9 marks "
            "the harmonic peak of the whole plate with a cross. The cross is not on the curve of "
            "half-wavelength sections. A section of 11.36 mm, the distance between "
            "the plate's nodal lines, resonates at 33.86 kHz; we conjecture that the difference "
            "is due to the free ends"
        ),
    )


def first_test_share() -> Outcome:
    """Compute a lower confidence limit for the proportion of people who feel the effect.

    In the first test of the paper, all twelve participants felt the effect.
    """
    from scipy.stats import binomtest

    interval = binomtest(PARTICIPANTS, PARTICIPANTS).proportion_ci(method="exact")
    return Outcome(
        published=None,
        ours=float(interval.low),
        unit="share",
        reason=(
            "lower limit of the 95 % confidence interval (Clopper and Pearson), given that all "
            "12 participants felt the effect; the paper reports no catch trials, so the rate of "
            "false alarms is unknown"
        ),
    )


# Values are computed, and large libraries imported, only on request.
ITEMS: Mapping[str, Callable[[], Outcome]] = {
    "table2.alpha": alpha,
    "table2.c11p": c11p,
    "table2.d31": d31,
    "plate.area": plate_area,
    "plate.half_wave": plate_half_wave,
    "fig9.harmonic_cross": harmonic_cross,
    "first_test.share_at_least": first_test_share,
}
FIGURES: Mapping[str, Callable[[], Figure]] = {}


if __name__ == "__main__":
    record(ITEMS, "constants.json")
