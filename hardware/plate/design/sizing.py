"""Compute half-wavelengths and plate sizes from requirements, following Section III of the paper.

The required amplitude determines the shortest half-wavelength (equation 37). The required squeeze
number determines the lowest frequency and thus the longest half-wavelength. Plates with
half-wavelengths between these limits are candidates; the finite-element model checks whether they
are admissible (`verdict`). A plate with n ceramics in a row is driven in its free-free mode with
n + 1 nodal lines.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from slipscale.faults import UserError
from slipscale.hardware.plate.beam import BeamSection
from slipscale.hardware.plate.geometry import Layout, Patch
from slipscale.hardware.plate.materials import BeamCeramic, Isotropic, Piezoceramic
from slipscale.stimuli.film import reynolds, shared_load, squeeze_film
from slipscale.stimuli.film.reynolds import WorkingPoint

if TYPE_CHECKING:
    from slipscale.hardware.plate.design.requirements import Brief, DrawnPlate

_COLUMNS_MORE = 4  # Candidates have up to this many columns more than the workspace requires.


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """Candidate plate size.

    Parameters
    ----------
    ceramic_length_mm : float
        Length of a ceramic along x.
    columns, rows : int
        Number of ceramics along x and y.
    length_mm, width_mm : float
        Size of the plate.
    half_wave_mm : float
        Distance between nodal lines under the ceramics: the length of the row of n ceramics,
        including gaps but not borders, divided by n + 1/2, as for a free-free beam with n + 1 nodal
        lines. The paper divides by n + 1.
    frequency_hz : float
        Resonance frequency of a Timoshenko beam in plane strain with this half-wavelength.
    amplitude_um_peak : float
        Deflection at resonance from equation (37). In the finite-element model, the amplitude is
        two thirds of this deflection at the edge and less than half in the middle (see `verdict`).
    squeeze_number : float
        Squeeze number at `frequency_hz`, for the worst-case amplitude and roughness in the design
        brief.
    beam_admissible : bool
        Whether the half-wavelength is within the bounds from the beam model.
    """

    ceramic_length_mm: float
    columns: int
    rows: int
    length_mm: float
    width_mm: float
    half_wave_mm: float
    frequency_hz: float
    amplitude_um_peak: float
    squeeze_number: float
    beam_admissible: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """Design limits and candidate plates for a design brief.

    Parameters
    ----------
    frequency_min_hz : float
        Lowest allowed frequency: the lowest frequency in the requirements, or the frequency at
        which the required squeeze number is reached, whichever is higher.
    half_wave_min_mm : float
        Shortest half-wavelength with which the required amplitude is reached.
    half_wave_max_mm : float
        Longest half-wavelength: that of a Timoshenko beam in plane strain at the lowest frequency.
    half_wave_max_printed_mm : float
        Half-wavelength at the lowest frequency according to equation (38) of the paper.
    relative_friction : float
        Relative friction from Reynolds' equation (3), at the lowest frequency and at the amplitude,
        roughness and force in the design brief.
    relative_friction_band : tuple of 2 floats
        Minimum and maximum from the model of a shared load (`slipscale.stimuli.film.shared_load`),
        which is not validated.
    relative_friction_closed_form : float
        Relative friction from the closed form (13), which the paper uses.
    closed_form_holds : bool
        Whether the squeeze number is at least 10, the paper's criterion.
    candidates : tuple of Candidate
        Plates that cover the workspace, including inadmissible ones.
    """

    frequency_min_hz: float
    half_wave_min_mm: float
    half_wave_max_mm: float
    half_wave_max_printed_mm: float
    relative_friction: float
    relative_friction_band: tuple[float, float]
    relative_friction_closed_form: float
    closed_form_holds: bool
    candidates: tuple[Candidate, ...]

    @property
    def beam_admissible(self) -> tuple[Candidate, ...]:
        """Candidates within the bounds of the beam model, which are solved with finite elements."""
        return tuple(plate for plate in self.candidates if plate.beam_admissible)


def design(brief: Brief) -> Design:
    """Compute the design limits and the candidate plates for a design brief.

    Raises
    ------
    UserError
        If the film would carry the finger's whole force, so that there would be no friction.
    """
    wanted = brief.requirements
    printed, wide = sections(brief)
    finger = squeeze_film.FINGER
    worst = (wanted.squeeze_amplitude_um_peak, wanted.squeeze_roughness_um)
    per_hz = float(squeeze_film.squeeze_number(1.0, *worst, finger))
    floor = max(wanted.squeeze_number / per_hz, wanted.frequency_min_hz)
    shortest = printed.half_wave_for_amplitude_mm(wanted.amplitude_um_peak, wanted.voltage_v)
    longest = wide.timoshenko_half_wave_mm(floor)

    def candidate(length_mm: float, columns: int) -> Candidate:
        rows = _needed(wanted.workspace_mm[1], brief.ceramic.width_mm, brief.ceramic.gap_mm)
        gap, border_mm = brief.ceramic.gap_mm, brief.resonator.border_mm
        size = columns * length_mm + (columns - 1) * gap
        half_wave = size / (columns + 0.5)
        frequency = float(wide.timoshenko_frequency_hz(half_wave))
        return Candidate(
            ceramic_length_mm=length_mm,
            columns=columns,
            rows=rows,
            length_mm=size + 2 * border_mm[0],
            width_mm=rows * brief.ceramic.width_mm + (rows - 1) * gap + 2 * border_mm[1],
            half_wave_mm=half_wave,
            frequency_hz=frequency,
            amplitude_um_peak=float(
                printed.dynamic_deflection_um_peak(half_wave, wanted.voltage_v)
            ),
            squeeze_number=per_hz * frequency,
            beam_admissible=shortest <= half_wave <= longest,
        )

    plates = []
    for length_mm in brief.ceramic.lengths_mm:
        least = _needed(wanted.workspace_mm[0], length_mm, brief.ceramic.gap_mm)
        plates += [candidate(length_mm, n) for n in range(least, least + _COLUMNS_MORE + 1)]
    point = WorkingPoint(
        amplitude_um_peak=wanted.amplitude_um_peak,
        roughness_um=wanted.roughness_um,
        frequency_hz=floor,
    )
    with warnings.catch_warnings():
        # The warning is not needed, because the design reports `closed_form_holds`.
        warnings.simplefilter("ignore", squeeze_film.ClosedFormWarning)
        closed = squeeze_film.relative_friction(
            wanted.amplitude_um_peak,
            wanted.roughness_um,
            floor,
            normal_force_n=wanted.normal_force_n,
        )
    solved = reynolds.relative_friction(point, wanted.normal_force_n)
    if solved.relative_friction < 0:
        carried_n = wanted.normal_force_n * (1 - float(solved.relative_friction))
        raise UserError(
            "requirements.normal_force_n: at {amplitude_um_peak:g} µm peak, the film carries "
            "{carried_n:.2g} N, more than the finger's {normal_force_n:g} N; expected a larger "
            "force, a smaller amplitude_um_peak or a rougher plate",
            amplitude_um_peak=wanted.amplitude_um_peak,
            carried_n=carried_n,
            normal_force_n=wanted.normal_force_n,
        )
    return Design(
        frequency_min_hz=floor,
        half_wave_min_mm=shortest,
        half_wave_max_mm=longest,
        half_wave_max_printed_mm=printed.half_wave_for_frequency_mm(floor),
        relative_friction=float(solved.relative_friction),
        relative_friction_band=shared_load.band(
            wanted.amplitude_um_peak, frequency_hz=floor, normal_force_n=wanted.normal_force_n
        ),
        relative_friction_closed_form=float(closed.relative_friction),
        closed_form_holds=bool(closed.closed_form_holds),
        candidates=tuple(plates),
    )


def sections(brief: Brief) -> tuple[BeamSection, BeamSection]:
    """Return two beams for a design brief: as modelled in the paper, and in plane strain."""
    resonator, ceramic = resonator_of(brief), ceramic_of(brief)
    thickness = {
        "ceramic_thickness_mm": brief.ceramic.thickness_mm,
        "resonator_thickness_mm": brief.resonator.thickness_mm,
    }
    beam = BeamCeramic(
        name=brief.ceramic.name,
        modulus_pa=brief.ceramic.beam.modulus_pa,
        d31_m_v=brief.ceramic.beam.d31_m_v,
        density_kg_m3=brief.ceramic.density_kg_m3,
        quality_factor=brief.ceramic.quality_factor,
    )
    printed = BeamSection.printed(beam, resonator, shear_pa=ceramic.shear_xz_pa, **thickness)
    return printed, BeamSection.plane_strain(ceramic, resonator, **thickness)


def resonator_of(brief: Brief) -> Isotropic:
    """Return the material of the resonator."""
    return Isotropic(
        name=brief.resonator.name,
        young_pa=brief.resonator.young_pa,
        poisson=brief.resonator.poisson,
        density_kg_m3=brief.resonator.density_kg_m3,
    )


def ceramic_of(brief: Brief) -> Piezoceramic:
    """Return the ceramic with its full matrices."""
    full = brief.ceramic.full
    return Piezoceramic(
        name=brief.ceramic.name,
        density_kg_m3=brief.ceramic.density_kg_m3,
        stiffness_pa=full.stiffness_pa,
        coupling_c_m2=full.coupling_c_m2,
        relative_permittivity=full.relative_permittivity,
        quality_factor=brief.ceramic.quality_factor,
    )


def layout_of(brief: Brief, plate: Candidate) -> Layout:
    """Convert a candidate to a layout for the finite-element model."""
    return Layout(
        length_mm=plate.length_mm,
        width_mm=plate.width_mm,
        columns=plate.columns,
        rows=plate.rows,
        gap_mm=brief.ceramic.gap_mm,
        border_mm=brief.resonator.border_mm,
        **_layers(brief),
    )


def drawn_layout(brief: Brief, plate: DrawnPlate) -> Layout:
    """Return the layout of a custom plate. Raises UserError if the patches do not fit on it."""
    outline = plate.region()
    patches = [
        Patch(region=each.region(each.at_mm), polarity=each.polarity) for each in plate.patch
    ]
    try:
        return Layout(
            length_mm=outline.size_mm[0],
            width_mm=outline.size_mm[1],
            disc=outline.disc,
            drawn=tuple(patches),
            **_layers(brief),
        )
    except UserError as error:
        raise UserError("plate {plate!r}: {error}", plate=plate.name, error=error) from error


def _layers(brief: Brief) -> dict[str, Any]:
    return {
        "ceramic_thickness_mm": brief.ceramic.thickness_mm,
        "resonator_thickness_mm": brief.resonator.thickness_mm,
        "ceramic": ceramic_of(brief),
        "resonator": resonator_of(brief),
    }


def _needed(span_mm: float, piece_mm: float, gap_mm: float) -> int:
    """Return how many pieces, separated by gaps, are needed to cover a span."""
    return max(1, math.ceil((span_mm + gap_mm) / (piece_mm + gap_mm) - 1e-9))
