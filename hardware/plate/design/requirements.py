"""Read and validate the TOML file with requirements for `slipscale plate design`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from slipscale.faults.frozen_table import FrozenTable
from slipscale.faults.toml_file import read_toml
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.plate.geometry import Region
from slipscale.hardware.plate.materials import COPPER_BERYLLIUM, P1_91, P1_91_TABLE_II

LIMITS = PlateLimits()
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Span = Annotated[float, Field(gt=0, le=300)]  # largest workspace in mm that can be meshed
Length = Annotated[float, Field(ge=2, le=300)]  # in mm; if shorter, a plate needs too many ceramics
AMPLITUDE_MAX_UM_PEAK = 20.0  # a hundredth of the plate's thickness: the limit of linear bending
QUALITY_MAX = 2_000.0  # commercial hard piezoceramics reach about 1,500
Border = Annotated[float, Field(ge=0, le=50)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Row = tuple[float, ...]  # `slipscale.hardware.plate.materials.Piezoceramic` checks the matrices


class Requirements(FrozenTable):
    """Requirements for a plate. The defaults are those in Sections II and III of the paper."""

    workspace_mm: tuple[Span, Span] = (57.0, 45.0)
    finger_place: Literal["middle", "edge"] = "middle"
    voltage_v: Positive = 15.0
    amplitude_um_peak: Annotated[float, Field(gt=0, le=AMPLITUDE_MAX_UM_PEAK)] = 1.5
    roughness_um: Positive = 0.6
    normal_force_n: Annotated[float, Field(gt=0, le=20)] = 0.5  # fingers press with 20 N or less
    squeeze_number: Positive = 10.0
    squeeze_amplitude_um_peak: NotNegative = 3.0
    squeeze_roughness_um: Positive = 1.6
    frequency_min_hz: NotNegative = 25_000.0

    @field_validator("voltage_v")
    @classmethod
    def _voltage_is_safe(cls, voltage_v: float) -> float:
        limit = LIMITS.voltage_v
        if voltage_v > limit:
            raise ValueError(f"must be above 0 and at most {limit:g} V, the safe limit")
        return voltage_v


class BeamConstants(FrozenTable):
    """Constants of the ceramic for the beam model."""

    modulus_pa: Positive = P1_91_TABLE_II.modulus_pa
    d31_m_v: Annotated[float, Field(ge=-1e-7, le=1e-7)] = P1_91_TABLE_II.d31_m_v


class FullConstants(FrozenTable):
    """Constants of the ceramic for the Timoshenko beam and for finite elements."""

    stiffness_pa: tuple[Row, ...] = P1_91.stiffness_pa
    coupling_c_m2: tuple[Row, ...] = P1_91.coupling_c_m2
    relative_permittivity: tuple[Positive, Positive, Positive] = P1_91.relative_permittivity


class Ceramic(FrozenTable):
    """Available ceramics."""

    name: str = "P1-91"
    lengths_mm: Annotated[tuple[Length, ...], Field(min_length=1)] = (11.0, 15.0)
    width_mm: Length = 9.0
    thickness_mm: Positive = 1.0
    gap_mm: NotNegative = 1.0
    density_kg_m3: Positive = P1_91.density_kg_m3
    quality_factor: Annotated[float, Field(gt=1, le=QUALITY_MAX)] = P1_91.quality_factor
    beam: BeamConstants = BeamConstants()
    full: FullConstants = FullConstants()


class PassivePlate(FrozenTable):
    """Passive plate."""

    name: str = COPPER_BERYLLIUM.name
    thickness_mm: Positive = 2.0
    border_mm: tuple[Border, Border] = (0.0, 0.0)  # border without ceramics, along x and y
    young_pa: Positive = COPPER_BERYLLIUM.young_pa
    poisson: Annotated[float, Field(gt=-1, lt=0.5)] = COPPER_BERYLLIUM.poisson
    density_kg_m3: Positive = COPPER_BERYLLIUM.density_kg_m3


class _Outline(FrozenTable):
    """Outline: a rectangle, given by its size, or a disc, given by its diameter."""

    size_mm: tuple[Length, Length] | None = None
    diameter_mm: Length | None = None

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if (self.size_mm is None) == (self.diameter_mm is None):
            raise ValueError("expected either size_mm (a rectangle) or diameter_mm (a disc)")
        return self

    def region(self, at_mm: tuple[float, float] = (0.0, 0.0)) -> Region:
        """Return the rectangle or disc as a region centred at a given position."""
        if self.diameter_mm is None:
            return Region(at_mm=at_mm, size_mm=self.size_mm or (0.0, 0.0))
        return Region(at_mm=at_mm, size_mm=(self.diameter_mm,) * 2, disc=True)


class DrawnPatch(_Outline):
    """Piezo element at any position, measured from the centre of the plate."""

    at_mm: tuple[Finite, Finite] = (0.0, 0.0)
    polarity: Literal[1, -1] = 1


class DrawnPlate(_Outline):
    """Plate with piezo elements at given positions."""

    name: str
    # Of the modes in this frequency band, the one that is driven most strongly is used.
    band_hz: tuple[Positive, Positive] = (LIMITS.frequency_min_hz, LIMITS.frequency_max_hz)
    finger_at_mm: tuple[Finite, Finite] = (0.0, 0.0)
    patch: Annotated[tuple[DrawnPatch, ...], Field(min_length=1)]

    @field_validator("band_hz")
    @classmethod
    def _band_rises(cls, band_hz: tuple[float, float]) -> tuple[float, float]:
        if band_hz[0] >= band_hz[1]:
            raise ValueError(f"must have the lower frequency first, but is {list(band_hz)}")
        return band_hz


class Brief(FrozenTable):
    """Complete design brief. The defaults describe the paper's plate."""

    title: str = "Biet 2007"
    requirements: Requirements = Requirements()
    ceramic: Ceramic = Ceramic()
    resonator: PassivePlate = PassivePlate()
    plate: tuple[DrawnPlate, ...] = ()

    @field_validator("plate")
    @classmethod
    def _names_differ(cls, plates: tuple[DrawnPlate, ...]) -> tuple[DrawnPlate, ...]:
        names = [each.name for each in plates]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"must have different names, but {twice[0]!r} occurs twice")
        return plates


def read(path: Path) -> Brief:
    """Read a design brief from a TOML file.

    Raises
    ------
    UserError
        If the file cannot be read, is not valid TOML, or has errors. All errors are listed.
    """
    return read_toml(path, Brief)
