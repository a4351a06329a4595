"""Recompute numbers in the paper's text and Table II from other numbers in the paper.

To record the computed values in ``constants.json``, run ``python -m
slipscale.analysis.reproduction.constants``. Do this only after an intended change to a formula or
constant, and explain in the commit message why the numbers changed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING

from slipscale.analysis.published.biet2007 import PARTICIPANTS, STUDY
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
        by_construction=True,
        covers=("eq.26", "table.2"),
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
        covers=("table.2",),
    )


def d31() -> Outcome:
    """Compute the ceramic's charge constant d31 (Table II) from Appendix B."""
    from slipscale.hardware.plate.materials import P1_91

    return Outcome(
        published="-247",
        ours=P1_91.d31_m_v * 1e12,
        unit="1e-12 m/V",
        reason="computed as d = e s (Appendix B), but only the value in Table II reproduces Fig. 8",
        covers=("table.2",),
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
        by_construction=True,
        covers=("fig.1",),
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
        by_construction=True,
        covers=("fig.1", "fig.11"),
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
        covers=("fig.9",),
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
        covers=("fig.14",),
    )


def setup(name: str, published: str, unit: str) -> Outcome:
    """Compare a number of the experiment (Section IV-B) with the shipped study."""
    from slipscale.experiments.study.file import read_study

    study, _ = read_study(STUDY)
    ours = {"participants": study.participants, "surfaces": len(study.levels)}[name]
    return Outcome(
        published=published,
        ours=ours,
        unit=unit,
        reason="the shipped study biet2007 sets the number that the paper states (Section IV-B)",
        by_construction=True,
        covers=("fig.14",),
    )


def ridge_height() -> Outcome:
    """Compute the height 2h_e of the epidermal ridges (Section II and Fig. 2)."""
    from slipscale.stimuli.film.squeeze_film import FINGER

    return Outcome(
        published="100",
        ours=2 * FINGER.ridge_amplitude_um,
        unit="µm",
        reason="twice h_e from Table I; the paper states around 100 µm",
        by_construction=True,
        covers=("fig.2",),
    )


def mesh_gap() -> Outcome:
    """Compute the gap that 7 ceramics of 11 mm leave on 83 mm (Section III-C and Fig. 10)."""
    from slipscale.hardware.plate.geometry import Layout

    layout = Layout.prototype()
    return Outcome(
        published="1",
        ours=(layout.length_mm - layout.columns * 11) / (layout.columns - 1),
        unit="mm",
        reason="83 mm less seven times 11 mm, divided by six gaps; Fig. 10 shows the mesh",
        by_construction=True,
        covers=("fig.10",),
    )


def table1(name: str) -> Outcome:
    """Compare a constant of Table I with the default of the models."""
    from slipscale.stimuli.film.squeeze_film import AIR, FINGER, NORMAL_FORCE_N, ROUGHNESS_UM

    ours, published, unit, covers = {
        "ridge_amplitude": (FINGER.ridge_amplitude_um, "50", "µm", ("fig.2",)),
        "ridge_period": (FINGER.ridge_period_um, "350", "µm", ("fig.2",)),
        "contact_length": (FINGER.contact_length_mm / 10, "1", "cm", ()),
        "viscosity": (AIR.viscosity_pa_s * 1e5, "1.85", "1e-5 Pa·s", ()),
        "pressure": (AIR.pressure_pa / 1e6, "0.1", "MPa", ()),
        "force": (NORMAL_FORCE_N, "0.5", "N", ()),
        **{f"roughness.{value}": (value, str(value), "µm", ()) for value in ROUGHNESS_UM},
    }[name]
    reason = "the models use the constant as their default"
    if name == "force":
        reason += "; Table I gives 0.3 to 0.7 N, and Fig. 5 uses 0.5 N"
    return Outcome(
        published=published,
        ours=ours,
        unit=unit,
        reason=reason,
        by_construction=True,
        covers=("table.1", *covers),
    )


# Values are computed, and large libraries imported, only on request.
TABLE1 = ("ridge_amplitude", "ridge_period", "contact_length", "viscosity", "pressure", "force")
ROUGHNESSES = tuple(f"roughness.{value}" for value in (0.4, 0.8, 1.2, 1.6))
ITEMS: Mapping[str, Callable[[], Outcome]] = {
    **{f"table1.{name}": partial(table1, name) for name in (*TABLE1, *ROUGHNESSES)},
    "table2.alpha": alpha,
    "table2.c11p": c11p,
    "table2.d31": d31,
    "fig1.area": plate_area,
    "fig1.half_wave": plate_half_wave,
    "fig9.harmonic_cross": harmonic_cross,
    "first_test.share_at_least": first_test_share,
    "fig2.ridge_height": ridge_height,
    "fig10.gap": mesh_gap,
    "fig14.participants": partial(setup, "participants", "12", "people"),
    "fig14.surfaces": partial(setup, "surfaces", "4", "amplitudes"),
}
FIGURES: Mapping[str, Callable[[], Figure]] = {}


if __name__ == "__main__":
    record(ITEMS, "constants.json")
