"""Check with the finite-element model whether a plate meets the requirements.

The beam model of equation (37) assumes that the plate bends uniformly across its width, and
overestimates the amplitude: the paper's plate reaches two thirds of the predicted value at its edge
and less than half in its middle. The beam model is therefore only used to select the plates that
are solved with finite elements. The mesh is refined until the amplitude changes by less than 4 %.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from slipscale.faults import UserError
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.plate.design.sizing import Candidate, drawn_layout, layout_of
from slipscale.hardware.plate.geometry import BRICKS_MM, QUICK, Density, Layout, Region, density_of
from slipscale.hardware.plate.paper_study import MODE_COUNT, harmonic, plate_modes
from slipscale.hardware.plate.vibration import Modes, modes, surface_response_um
from slipscale.stimuli.surface import pp_from_peak

if TYPE_CHECKING:
    from slipscale.hardware.plate.design.requirements import Brief, DrawnPlate

CONVERGED = 0.04  # largest relative difference between the amplitudes on two successive meshes


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """Finite-element solution for the driven mode of a plate with shorted electrodes.

    The quality factor of the plate is assumed to be that of the ceramic.

    Parameters
    ----------
    resonance_hz : float
        Resonance of the mode that the ceramics drive most strongly.
    amplitude_um_peak : dict of str to float
        Amplitude at the voltage in the design brief, keyed by position. Candidates have two
        positions at the antinode nearest to the centre: "middle" (on the centre line) and "edge".
        Custom plates have "finger" (position of the finger) and "largest" (maximum on the touch
        surface).
    unknowns : int
        Number of unknown displacements.
    uncertainty : float or None
        Largest relative change in amplitude since the previous mesh, or None if only one mesh was
        solved.
    """

    resonance_hz: float
    amplitude_um_peak: dict[str, float]
    unknowns: int
    uncertainty: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """Verdict on a plate.

    Parameters
    ----------
    solution : Solution or None
        Finite-element solution; None if the plate is outside the bounds of the beam model, or if
        the finite-element computation failed.
    why_not : tuple of str
        Unmet requirements; empty if the plate meets all requirements.
    needs : tuple of str
        Values outside a driver's default limits, for which a plate file is required.
    """

    solution: Solution | None
    why_not: tuple[str, ...]
    needs: tuple[str, ...]

    @property
    def admissible(self) -> bool:
        """Whether the plate meets all requirements."""
        return not self.why_not


def solve(brief: Brief, candidate: Candidate, density: Density = QUICK) -> tuple[Modes, Solution]:
    """Compute the modes of a candidate and its response to the drive. Raises UserError."""
    layout = layout_of(brief, candidate)
    found = plate_modes(layout, near_hz=candidate.frequency_hz, density=density)
    voltage_v = brief.requirements.voltage_v
    x_mm = layout.antinode_x_mm
    return found, _solution(
        found,
        {
            place: harmonic(found, voltage_v=voltage_v, where_mm=(x_mm, y_mm)).peak_um_pp / 2
            for place, y_mm in (("middle", 0.0), ("edge", layout.width_mm / 2))
        },
    )


def solve_drawn(brief: Brief, plate: DrawnPlate, density: Density) -> tuple[Modes, Solution]:
    """Compute the modes of a custom plate and its response to the drive. Raises UserError."""
    layout = drawn_layout(brief, plate)
    low_hz, high_hz = plate.band_hz
    middle_hz, count, reach_hz = (low_hz + high_hz) / 2, MODE_COUNT // 2, 0.0
    while reach_hz < (high_hz - low_hz) / 2:  # Repeat until the modes cover the band.
        count *= 2
        found = modes(layout, middle_hz, count, density=density)
        reach_hz = float(np.abs(found.frequency_hz - middle_hz).max())
    found = replace(found, band_hz=plate.band_hz)
    resonance_hz = float(found.frequency_hz[found.driven])
    if not low_hz <= resonance_hz <= high_hz:
        raise UserError(
            "plate {plate!r}: no mode is within band_hz, expected a wider band", plate=plate.name
        )
    voltage_v, loss = brief.requirements.voltage_v, 1 / layout.ceramic.quality_factor
    response = harmonic(found, voltage_v=voltage_v, where_mm=plate.finger_at_mm)
    _, on_top_um_peak = surface_response_um(found, response.peak_hz, voltage_v, loss)
    finger = response.peak_um_pp / 2
    largest = max(finger, float(np.abs(on_top_um_peak).max()))
    return found, _solution(found, {"finger": finger, "largest": largest})


def _solution(found: Modes, amplitude_um_peak: dict[str, float]) -> Solution:
    return Solution(
        resonance_hz=float(found.frequency_hz[found.driven]),
        amplitude_um_peak=amplitude_um_peak,
        unknowns=int(3 * found.parts.nodes.shape[1]),
    )


def converged(layout: Layout, solved: Callable[[Density], tuple[Modes, Solution]]) -> Solution:
    """Refine the mesh until the amplitudes converge or no finer mesh is available.

    The solution with the finest mesh is returned.

    Raises
    ------
    UserError
        If the finite-element computation fails.
    """
    solution: Solution | None = None
    for brick_mm in BRICKS_MM:
        _, finer = solved(density_of(layout, brick_mm))
        if solution is not None:
            pairs = zip(
                finer.amplitude_um_peak.values(), solution.amplitude_um_peak.values(), strict=True
            )
            uncertainty = max(abs(new - old) / new for new, old in pairs)
            finer = replace(finer, uncertainty=uncertainty)
        solution = finer
        if solution.uncertainty is not None and solution.uncertainty <= CONVERGED:
            break
    if solution is None:
        raise UserError("the plate has no mesh")
    return solution


def judge(brief: Brief, candidate: Candidate, frequency_min_hz: float) -> Judged:
    """Check whether a candidate meets the requirements of the design brief.

    Candidates outside the bounds of the beam model are not solved with finite elements.
    """
    if not candidate.beam_admissible:
        return Judged(
            solution=None,
            why_not=("the half-wavelength is outside the bounds of the beam model",),
            needs=(),
        )
    try:
        solution = converged(
            layout_of(brief, candidate), lambda density: solve(brief, candidate, density)
        )
    except UserError as error:
        return Judged(solution=None, why_not=(str(error),), needs=())
    return judged(brief, solution, frequency_min_hz)


def judge_drawn(brief: Brief, plate: DrawnPlate, frequency_min_hz: float) -> Judged:
    """Check whether a custom plate meets the requirements. Raises UserError if solving fails."""
    layout = placed(brief, plate)
    solution = converged(layout, lambda density: solve_drawn(brief, plate, density))
    verdict = judged(brief, solution, frequency_min_hz, place="finger")
    workspace = Region(size_mm=brief.requirements.workspace_mm)
    if np.all(layout.outline.holds(*workspace.rim_mm())):
        return verdict
    return replace(verdict, why_not=("the plate does not cover the workspace", *verdict.why_not))


def placed(brief: Brief, plate: DrawnPlate) -> Layout:
    """Return the layout of a custom plate.

    Raises UserError if a patch or the finger is not on the plate.
    """
    layout = drawn_layout(brief, plate)
    if not layout.outline.holds(*np.array(plate.finger_at_mm)[:, None])[0]:
        raise UserError(
            "plate {plate!r}: finger_at_mm is {finger_at_mm}; expected a position on the plate",
            plate=plate.name,
            finger_at_mm=list(plate.finger_at_mm),
        )
    return layout


def judged(
    brief: Brief, solution: Solution, frequency_min_hz: float, *, place: str | None = None
) -> Judged:
    """Compare a finite-element solution with the requirements and the default driver limits."""
    wanted, limits = brief.requirements, PlateLimits()
    place = place or wanted.finger_place
    amplitude_um_peak = solution.amplitude_um_peak[place]
    why_not, needs = [], []
    if amplitude_um_peak < wanted.amplitude_um_peak:
        why_not.append(
            f"the amplitude at the {place} is {amplitude_um_peak:.2f} µm peak, but "
            f"{wanted.amplitude_um_peak:g} is required"
        )
    if solution.uncertainty is not None and solution.uncertainty > CONVERGED:
        why_not.append(
            f"the amplitude is uncertain by {solution.uncertainty:.0%}, because the meshes "
            "disagree; solve the plate with --fe and --fine"
        )
    if solution.resonance_hz < frequency_min_hz:
        why_not.append(
            f"the plate resonates at {solution.resonance_hz / 1000.0:.2f} kHz, but at least "
            f"{frequency_min_hz / 1000.0:.3g} kHz is required"
        )
    if not limits.frequency_min_hz <= solution.resonance_hz <= limits.frequency_max_hz:
        needs.append(
            f"{solution.resonance_hz / 1e3:.2f} kHz (default limits: "
            f"{limits.frequency_min_hz / 1e3:g} to {limits.frequency_max_hz / 1e3:g})"
        )
    if pp_from_peak(wanted.amplitude_um_peak) > limits.level:
        needs.append(
            f"{pp_from_peak(wanted.amplitude_um_peak):g} µm p-p (default limit: {limits.level:g})"
        )
    return Judged(solution=solution, why_not=tuple(why_not), needs=tuple(needs))
