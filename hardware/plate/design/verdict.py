"""Check by finite elements whether a plate meets its requirements at the finger's position.

The beam of equation (37) bends uniformly over its width and therefore overestimates the amplitude:
the paper's plate reaches two thirds of that value at its edge and less than half in its middle.
The beam model selects the plates worth solving. The solutions are judged here, on meshes that are
refined until the amplitude changes by less than 4 %.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from slipscale.faults import UserError
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.plate.design.sizing import layout_of
from slipscale.hardware.plate.geometry import BRICKS_MM, QUICK, density_of
from slipscale.hardware.plate.paper_study import harmonic, plate_modes
from slipscale.stimuli.surface import pp_from_peak

if TYPE_CHECKING:
    from slipscale.hardware.plate.design.requirements import Brief
    from slipscale.hardware.plate.design.sizing import Candidate
    from slipscale.hardware.plate.geometry import Density
    from slipscale.hardware.plate.vibration import Modes

CONVERGED = 0.04  # of the amplitude, from one mesh to the next


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """A plate's driven mode by finite elements, with shorted electrodes and the ceramic's Q.

    Parameters
    ----------
    resonance_hz : float
        Resonance of the mode that the ceramics drive most strongly.
    amplitude_middle_um_peak, amplitude_edge_um_peak : float
        Amplitude at the antinode nearest to the middle, on the mid line and at the edge, for the
        brief's voltage.
    unknowns : int
        Number of displacements solved for.
    uncertainty : float or None
        Relative difference of the amplitudes from those of the previous mesh, the larger of the
        two; None if only one mesh was solved.
    """

    resonance_hz: float
    amplitude_middle_um_peak: float
    amplitude_edge_um_peak: float
    unknowns: int
    uncertainty: float | None = None

    def amplitude_um_peak(self, place: str) -> float:
        """Return the amplitude at the finger's position, "middle" or "edge"."""
        return {
            "middle": self.amplitude_middle_um_peak,
            "edge": self.amplitude_edge_um_peak,
        }[place]


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """A candidate and its verdict.

    Parameters
    ----------
    candidate : Candidate
        With the beam's estimates.
    solution : Solution or None
        None if the beam model already rules the plate out, or the plate could not be solved.
    why_not : tuple of str
        Unmet requirements; empty if the plate meets all of them.
    needs : tuple of str
        Requirements beyond a driver's shipped limits: such a plate requires a plate file.
    """

    candidate: Candidate
    solution: Solution | None
    why_not: tuple[str, ...]
    needs: tuple[str, ...]

    @property
    def admissible(self) -> bool:
        """Whether the plate meets every requirement."""
        return not self.why_not


def solve(brief: Brief, candidate: Candidate, density: Density = QUICK) -> tuple[Modes, Solution]:
    """Return a plate's modes and its response to the drive. Raises UserError."""
    layout = layout_of(brief, candidate)
    modes = plate_modes(layout, near_hz=candidate.frequency_hz, density=density)
    voltage_v = brief.requirements.voltage_v
    edge = harmonic(modes, voltage_v=voltage_v)
    middle = harmonic(modes, voltage_v=voltage_v, where_mm=(layout.antinode_x_mm, 0.0))
    return modes, Solution(
        resonance_hz=float(modes.frequency_hz[modes.driven]),
        amplitude_middle_um_peak=middle.peak_um_pp / 2,
        amplitude_edge_um_peak=edge.peak_um_pp / 2,
        unknowns=int(3 * modes.parts.nodes.shape[1]),
    )


def converged(brief: Brief, candidate: Candidate) -> Solution:
    """Refine the mesh until the solution agrees with the previous one; return the last solution.

    Raises
    ------
    UserError
        The plate cannot be solved.
    """
    layout = layout_of(brief, candidate)
    solution: Solution | None = None
    for brick_mm in BRICKS_MM:
        _, finer = solve(brief, candidate, density_of(layout, brick_mm))
        if solution is not None:
            pairs = (
                (finer.amplitude_middle_um_peak, solution.amplitude_middle_um_peak),
                (finer.amplitude_edge_um_peak, solution.amplitude_edge_um_peak),
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
    """Return whether a plate meets the brief; solve it unless the beam model rules it out."""
    if not candidate.beam_admissible:
        return Judged(
            candidate=candidate,
            solution=None,
            why_not=("its half wave is outside the bounds",),
            needs=(),
        )
    try:
        solution = converged(brief, candidate)
    except UserError as error:
        return Judged(candidate=candidate, solution=None, why_not=(str(error),), needs=())
    return judged(brief, candidate, solution, frequency_min_hz)


def judged(
    brief: Brief, candidate: Candidate, solution: Solution, frequency_min_hz: float
) -> Judged:
    """Compare a solved plate with the brief and with the driver's shipped limits."""
    wanted, limits = brief.requirements, PlateLimits()
    amplitude_um_peak = solution.amplitude_um_peak(wanted.finger_place)
    why_not, needs = [], []
    if amplitude_um_peak < wanted.amplitude_um_peak:
        why_not.append(
            f"{amplitude_um_peak:.2f} µm peak at the {wanted.finger_place}, "
            f"{wanted.amplitude_um_peak:g} required"
        )
    if solution.uncertainty is not None and solution.uncertainty > CONVERGED:
        why_not.append(
            f"its amplitude is uncertain by {solution.uncertainty:.0%}: the meshes disagree, solve "
            "it with --fe and --fine"
        )
    if solution.resonance_hz < frequency_min_hz:
        why_not.append(
            f"resonates at {solution.resonance_hz / 1000.0:.2f} kHz, at least "
            f"{frequency_min_hz / 1000.0:.3g} required"
        )
    if not limits.frequency_min_hz <= solution.resonance_hz <= limits.frequency_max_hz:
        needs.append(
            f"{solution.resonance_hz / 1e3:.2f} kHz (shipped: {limits.frequency_min_hz / 1e3:g} to "
            f"{limits.frequency_max_hz / 1e3:g})"
        )
    if pp_from_peak(wanted.amplitude_um_peak) > limits.level:
        needs.append(
            f"{pp_from_peak(wanted.amplitude_um_peak):g} µm p-p (shipped: up to {limits.level:g})"
        )
    return Judged(
        candidate=candidate, solution=solution, why_not=tuple(why_not), needs=tuple(needs)
    )
