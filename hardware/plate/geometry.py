"""Geometry of the monomorph: a resonator with a matrix of ceramics under it, and its mesh lines."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Self

import numpy as np

from slipscale.faults import UserError
from slipscale.hardware.plate.materials import COPPER_BERYLLIUM, P1_91, Isotropic, Piezoceramic
from slipscale.stimuli.quantities import MILLI, not_negative, positive

if TYPE_CHECKING:
    from slipscale.stimuli.quantities import Array

Ends = Literal["free", "supported"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """A plate: x along its length, z up from the ceramics' free face to the touch surface.

    Parameters
    ----------
    length_mm, width_mm : float
        Size along x and y.
    columns, rows : int
        Number of ceramics along x and y; the polarity alternates along x.
    gap_mm : float
        Distance between neighbouring ceramics; 0 for a continuous layer.
    border_mm : tuple of 2 floats
        Bare resonator beyond the ceramics at each end along x and along y.
    ceramic_thickness_mm, resonator_thickness_mm : float
        Thicknesses h_p and h_i.
    ends : {"free", "supported"}
        Whether the faces x = ± length/2 are free or held at w = 0.
    ceramic : Piezoceramic
        Material of the active layer.
    resonator : Isotropic
        Material of the plate.
    """

    length_mm: float
    width_mm: float
    columns: int = 1
    rows: int = 1
    gap_mm: float = 0.0
    border_mm: tuple[float, float] = (0.0, 0.0)
    ceramic_thickness_mm: float = 1.0
    resonator_thickness_mm: float = 2.0
    ends: Ends = "free"
    ceramic: Piezoceramic = P1_91
    resonator: Isotropic = COPPER_BERYLLIUM

    def __post_init__(self) -> None:
        for name in ("length_mm", "width_mm", "ceramic_thickness_mm", "resonator_thickness_mm"):
            positive(f"plate layout: {name}", getattr(self, name), "mm")
        for name, value in (("gap_mm", self.gap_mm), ("border_mm", self.border_mm)):
            not_negative(f"plate layout: {name}", value, "mm")
        if min(self.columns, self.rows) < 1:
            raise UserError("plate layout: columns and rows must be 1 or more")
        if min(self.ceramic_length_mm, self.ceramic_width_mm) <= 0:
            raise UserError(
                f"plate layout: {self.columns} x {self.rows} ceramics with gaps of {self.gap_mm} "
                f"mm and a border of {self.border_mm[0]} x {self.border_mm[1]} mm leave no room on "
                f"{self.length_mm} x {self.width_mm} mm"
            )

    @classmethod
    def prototype(cls, *, continuous: bool = False) -> Self:
        """Return the paper's plate: 83 x 49 mm, 7 x 5 ceramics of 11 x 9 x 1 mm (Section III-C).

        ``continuous`` closes the gaps of 1 mm, as Fig. 11's frequency suggests for the paper's
        model.
        """
        return cls(
            length_mm=83.0, width_mm=49.0, columns=7, rows=5, gap_mm=0.0 if continuous else 1.0
        )

    @classmethod
    def half_wave(cls, half_wave_mm: float, width_mm: float = 49.0) -> Self:
        """Return the half-wave section of Fig. 6, simply supported."""
        return cls(length_mm=half_wave_mm, width_mm=width_mm, ends="supported")

    @property
    def ceramic_length_mm(self) -> float:
        """Length of one ceramic along x."""
        return _piece(self.length_mm, self.columns, self.gap_mm, self.border_mm[0])

    @property
    def ceramic_width_mm(self) -> float:
        """Width of one ceramic along y."""
        return _piece(self.width_mm, self.rows, self.gap_mm, self.border_mm[1])

    @property
    def antisymmetric(self) -> bool:
        """Whether drive and driven mode are odd in x: an even number of ceramics."""
        return self.columns % 2 == 0

    @property
    def antinode_x_mm(self) -> float:
        """X of the antinode nearest to the middle, which is at the middle of a ceramic."""
        return (self.ceramic_length_mm + self.gap_mm) / 2 if self.antisymmetric else 0.0

    def column_of(self, x: Array) -> Array:
        """Return the index of the ceramics' column nearest to x (in m; 0 is the middle)."""
        pitch = (self.ceramic_length_mm + self.gap_mm) * MILLI
        index = np.round(x / pitch + (self.columns - 1) / 2)
        return np.asarray(np.clip(index, 0, self.columns - 1))

    def polarity(self, x: Array) -> Array:
        """Return the polarity +1 or -1 at x (in m); it is +1 in the middle, or just right of it."""
        return np.asarray(1.0 - 2.0 * ((self.column_of(x) - self.columns // 2) % 2))


@dataclass(frozen=True, slots=True, kw_only=True)
class Density:
    """Mesh density of a layout with quadratic bricks.

    Parameters
    ----------
    along_ceramic, across_ceramic : int
        Bricks along x and y per ceramic; a gap has one.
    ceramic_layers, resonator_layers : int
        Bricks through the thickness of each layer.
    """

    along_ceramic: int = 6
    across_ceramic: int = 5
    ceramic_layers: int = 1
    resonator_layers: int = 2

    def __post_init__(self) -> None:
        if min(getattr(self, name) for name in self.__slots__) < 1:
            raise UserError("mesh density: every count of bricks must be 1 or more")


# Excess of the driven mode's frequency over the finest mesh's: docs/explanation/plate-models.md.
QUICK = Density(along_ceramic=3, across_ceramic=2)  # 1.3 %, half a second
DEFAULT = Density()  # 0.4 %, 3 s, 0.4 GB
FINE = Density(
    along_ceramic=9, across_ceramic=8, ceramic_layers=2, resonator_layers=3
)  # 30 s, 2 GB
# Largest brick in mm, from coarse to fine: a wide ceramic requires more bricks than a narrow one.
BRICKS_MM = (4.5, 3.0, 2.2, 1.6)
HALF_WAVE = Density(along_ceramic=6, across_ceramic=8)


def density_of(layout: Layout, brick_mm: float) -> Density:
    """Return the density with bricks no larger than ``brick_mm`` in any direction."""
    return Density(
        along_ceramic=math.ceil(layout.ceramic_length_mm / brick_mm),
        across_ceramic=math.ceil(layout.ceramic_width_mm / brick_mm),
        ceramic_layers=math.ceil(layout.ceramic_thickness_mm / brick_mm),
        resonator_layers=math.ceil(layout.resonator_thickness_mm / brick_mm),
    )


def mesh_lines(
    length_mm: float,
    pieces: int,
    gap_mm: float,
    bricks: int,
    *,
    half: bool,
    border_mm: float = 0.0,
) -> tuple[Array, Array]:
    """Return the mesh lines along one direction, in m, and which intervals have no ceramic.

    Parameters
    ----------
    length_mm, pieces, gap_mm, border_mm
        Size of the plate and its division into ceramics.
    bricks : int
        Intervals per ceramic.
    half : bool
        Whether to keep only the part above 0, the plane of symmetry.
    """
    piece = _piece(length_mm, pieces, gap_mm, border_mm)
    end = length_mm / 2 - border_mm
    starts = np.arange(pieces) * (piece + gap_mm) - end
    fractions = np.arange(bricks + 1) / bricks
    # A border's bricks are no longer than a ceramic's.
    bare = np.linspace(end, length_mm / 2, math.ceil(border_mm * bricks / piece) + 1)
    ceramics = (starts[:, None] + piece * fractions).ravel()
    lines = np.unique(np.round(np.concatenate([-bare, ceramics, bare]), 9))
    if half:
        lines = np.append(0.0, lines[lines > 1e-6])  # noqa: PLR2004 - a nanometre, in mm
    middle = (lines[:-1] + lines[1:]) / 2
    within = np.mod(middle + end, piece + gap_mm)
    return lines * MILLI, np.asarray((within > piece) | (np.abs(middle) > end))


def _piece(length_mm: float, pieces: int, gap_mm: float, border_mm: float) -> float:
    """Return the size of one ceramic in mm."""
    return (length_mm - 2 * border_mm - (pieces - 1) * gap_mm) / pieces
