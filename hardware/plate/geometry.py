"""Define the geometry of a plate: a resonator with ceramics under it.

The ceramics are rows of equal rectangles, as in the paper, or rectangles and discs at any
positions. All ceramics are converted to patches.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Literal, Self

import numpy as np
import numpy.typing as npt

from slipscale.faults import UserError
from slipscale.hardware.plate.materials import COPPER_BERYLLIUM, P1_91, Isotropic, Piezoceramic
from slipscale.stimuli.quantities import MILLI, Array, not_negative, positive

Ends = Literal["free", "supported"]
_ON_MM = 1e-6  # tolerance of positions, one nanometre


@dataclass(frozen=True, slots=True, kw_only=True)
class Region:
    """Rectangle or disc, seen from above.

    Parameters
    ----------
    at_mm : tuple of 2 floats
        x and y of the centre, relative to the centre of the plate.
    size_mm : tuple of 2 floats
        Size along x and y. For a disc, both values are the diameter.
    disc : bool
        Whether the region is a disc.
    """

    at_mm: tuple[float, float] = (0.0, 0.0)
    size_mm: tuple[float, float]
    disc: bool = False

    def __post_init__(self) -> None:
        for size in self.size_mm:
            positive("plate layout: size_mm", size, "mm")
        if self.disc and self.size_mm[0] != self.size_mm[1]:
            raise UserError(
                "plate layout: a disc of {length_mm:g} x {width_mm:g} mm; expected two equal "
                "diameters",
                length_mm=self.size_mm[0],
                width_mm=self.size_mm[1],
            )

    def span_mm(self, axis: int) -> tuple[float, float]:
        """Return the region's lower and upper limit along an axis (0 for x, 1 for y)."""
        return (
            self.at_mm[axis] - self.size_mm[axis] / 2,
            self.at_mm[axis] + self.size_mm[axis] / 2,
        )

    def chord_mm(self, x_mm: Array) -> tuple[Array, Array]:
        """Return the region's lowest and highest y at each x; equal if x is outside the region."""
        away = np.abs(x_mm - self.at_mm[0]) / (self.size_mm[0] / 2)
        half = np.sqrt(np.maximum(1 - away**2, 0)) if self.disc else np.where(away < 1, 1.0, 0.0)
        half = half * self.size_mm[1] / 2
        return self.at_mm[1] - half, self.at_mm[1] + half

    def holds(self, x_mm: Array, y_mm: Array) -> npt.NDArray[np.bool_]:
        """Return a mask of the points inside the region or on its edge."""
        away = [np.abs(at - mid) for at, mid in zip((x_mm, y_mm), self.at_mm, strict=True)]
        if self.disc:
            return np.asarray(np.hypot(*away) <= self.size_mm[0] / 2 + _ON_MM)
        within = [far <= size / 2 + _ON_MM for far, size in zip(away, self.size_mm, strict=True)]
        return np.asarray(within[0] & within[1])

    def rim_mm(self) -> Array:
        """Return points on the edge, for testing whether another region contains this one."""
        angle = np.arange(360) * np.pi / 180 if self.disc else np.pi / 4 * np.array([1, 3, 5, 7])
        reach = 0.5 if self.disc else math.sqrt(0.5)
        turned = np.stack([np.cos(angle), np.sin(angle)]) * reach
        return np.asarray(np.array(self.at_mm)[:, None] + np.array(self.size_mm)[:, None] * turned)


@dataclass(frozen=True, slots=True, kw_only=True)
class Patch:
    """Region and polarity (+1 or -1) of one ceramic."""

    region: Region
    polarity: int = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """Plate layout, with x along the length and z from the ceramics up to the touch surface.

    Parameters
    ----------
    length_mm, width_mm : float
        Size along x and y.
    columns, rows : int
        Number of ceramics along x and y. The polarity of the ceramics alternates along x.
    gap_mm : float
        Distance between neighbouring ceramics, 0 for a continuous layer.
    border_mm : tuple of 2 floats
        Width of the resonator's border without ceramics, at each end along x and along y.
    disc : bool
        Whether the plate is a disc, with its diameter as length and width.
    drawn : tuple of Patch
        Ceramics at given positions. If empty, the layout has ``columns`` x ``rows`` ceramics.
    ceramic_thickness_mm, resonator_thickness_mm : float
        Thicknesses h_p and h_i.
    ends : {"free", "supported"}
        Boundary condition at the faces x = ± length/2: free or supported (w = 0).
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
    disc: bool = False
    drawn: tuple[Patch, ...] = ()
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
                "plate layout: {columns} x {rows} ceramics with gaps of {gap_mm} mm and a "
                "border of {border_x_mm} x {border_y_mm} mm leave no room on {length_mm} x "
                "{width_mm} mm",
                columns=self.columns,
                rows=self.rows,
                gap_mm=self.gap_mm,
                border_x_mm=self.border_mm[0],
                border_y_mm=self.border_mm[1],
                length_mm=self.length_mm,
                width_mm=self.width_mm,
            )
        if self.disc and self.ends != "free":
            raise UserError("plate layout: the edge of a disc must be free, not supported")
        _check_places(self.outline, self.patches)

    @classmethod
    def prototype(cls, *, continuous: bool = False) -> Self:
        """Return the paper's plate: 83 x 49 mm, 7 x 5 ceramics of 11 x 9 x 1 mm (Section III-C).

        ``continuous`` closes the gaps of 1 mm, as the frequency in Fig. 11 suggests for the paper's
        model.
        """
        return cls(
            length_mm=83.0, width_mm=49.0, columns=7, rows=5, gap_mm=0.0 if continuous else 1.0
        )

    @classmethod
    def half_wave(cls, half_wave_mm: float, width_mm: float = 49.0) -> Self:
        """Return the simply supported half-wave section of Fig. 6."""
        return cls(length_mm=half_wave_mm, width_mm=width_mm, ends="supported")

    @property
    def ceramic_length_mm(self) -> float:
        """Length of each ceramic along x, or of the shortest if sizes are given individually."""
        if self.drawn:
            return min(each.region.size_mm[0] for each in self.drawn)
        return _piece(self.length_mm, self.columns, self.gap_mm, self.border_mm[0])

    @property
    def ceramic_width_mm(self) -> float:
        """Width of each ceramic along y, or of the narrowest if sizes are given individually."""
        if self.drawn:
            return min(each.region.size_mm[1] for each in self.drawn)
        return _piece(self.width_mm, self.rows, self.gap_mm, self.border_mm[1])

    @property
    def outline(self) -> Region:
        """Outline of the plate."""
        return Region(size_mm=(self.length_mm, self.width_mm), disc=self.disc)

    @property
    def patches(self) -> tuple[Patch, ...]:
        """All ceramics of the plate.

        In each row, the ceramic in the middle (or directly right of the middle) has polarity +1.
        """
        return self.drawn or _rows(self)

    @property
    def mirrors(self) -> tuple[int, int]:
        """Symmetry of the drive under x -> -x and y -> -y: 1 even, -1 odd, 0 neither."""
        return _parity(self.patches, (-1, 1)), _parity(self.patches, (1, -1))

    @property
    def antinode_x_mm(self) -> float:
        """The x coordinate of the antinode nearest to the centre, at the middle of a ceramic."""
        even = not self.drawn and self.columns % 2 == 0
        return (self.ceramic_length_mm + self.gap_mm) / 2 if even else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Density:
    """Mesh density of a layout with quadratic bricks.

    Parameters
    ----------
    along_ceramic, across_ceramic : int
        Number of brick elements per ceramic along x and y. A gap is one element wide, unless the
        gap is wider than an element of the ceramic.
    ceramic_layers, resonator_layers : int
        Number of brick elements through the thickness of the ceramics and of the resonator.
    """

    along_ceramic: int = 6
    across_ceramic: int = 5
    ceramic_layers: int = 1
    resonator_layers: int = 2

    def __post_init__(self) -> None:
        if min(getattr(self, name) for name in self.__slots__) < 1:
            raise UserError("mesh density: every number of bricks must be at least 1")


# The comments give the frequency error (see docs/explanation/plate-models.md), computing time and
# memory.
QUICK = Density(along_ceramic=3, across_ceramic=2)  # 1.3 %, 0.5 s
DEFAULT = Density()  # 0.4 %, 3 s, 0.4 GB
FINE = Density(
    along_ceramic=9, across_ceramic=8, ceramic_layers=2, resonator_layers=3
)  # 30 s, 2 GB
# Largest length of a brick's edges in mm, from coarse to fine meshes.
BRICKS_MM = (4.5, 3.0, 2.2, 1.6)
DRAWN_MM = (1.6, 1.2)  # for --fine and the finer mesh of custom plates
HALF_WAVE = Density(along_ceramic=6, across_ceramic=8)


def density_of(layout: Layout, brick_mm: float) -> Density:
    """Return the mesh density at which no brick in ceramics and layers exceeds ``brick_mm``."""
    return Density(
        along_ceramic=math.ceil(layout.ceramic_length_mm / brick_mm),
        across_ceramic=math.ceil(layout.ceramic_width_mm / brick_mm),
        ceramic_layers=math.ceil(layout.ceramic_thickness_mm / brick_mm),
        resonator_layers=math.ceil(layout.resonator_thickness_mm / brick_mm),
    )


def mesh_lines(layout: Layout, axis: int, brick_mm: float, *, half: bool) -> Array:
    """Return the mesh lines along one direction, in m.

    There is a mesh line at each edge of the plate and of the ceramics' bounding boxes. The bricks
    between two edges have equal lengths of at most ``brick_mm``. If ``half`` is True, the lines
    begin at 0, the plane of symmetry.
    """
    regions = [layout.outline, *(each.region for each in layout.patches)]
    edges = np.array([region.span_mm(axis) for region in regions]).ravel()
    edges = np.unique(np.round(edges, 9))
    if half:
        edges = np.append(0.0, edges[edges > _ON_MM])
    pieces = [
        np.linspace(start, end, math.ceil((end - start) / brick_mm - _ON_MM) + 1)[1:]
        for start, end in pairwise(edges)
    ]
    return np.concatenate([edges[:1], *pieces]) * MILLI


def _piece(length_mm: float, pieces: int, gap_mm: float, border_mm: float) -> float:
    return (length_mm - 2 * border_mm - (pieces - 1) * gap_mm) / pieces


@lru_cache(maxsize=64)
def _rows(layout: Layout) -> tuple[Patch, ...]:
    size_mm = (layout.ceramic_length_mm, layout.ceramic_width_mm)
    counts = (layout.columns, layout.rows)
    x_mm, y_mm = (
        (np.arange(count) - (count - 1) / 2) * (size + layout.gap_mm)
        for count, size in zip(counts, size_mm, strict=True)
    )
    return tuple(
        Patch(
            region=Region(at_mm=(float(x), float(y)), size_mm=size_mm),
            polarity=1 - 2 * ((column - layout.columns // 2) % 2),
        )
        for column, x in enumerate(x_mm)
        for y in y_mm
    )


def _parity(patches: tuple[Patch, ...], signs: tuple[int, int]) -> int:
    """Return 1 if every patch has the same polarity as its mirror image, -1 if opposite, else 0."""

    def key(region: Region, signs: tuple[int, int]) -> tuple[object, ...]:
        x, y = (sign * round(at, 6) + 0.0 for sign, at in zip(signs, region.at_mm, strict=True))
        return x, y, region.size_mm, region.disc

    polarity = {key(each.region, (1, 1)): each.polarity for each in patches}
    ratios = {each.polarity * polarity.get(key(each.region, signs), 0) for each in patches}
    return ratios.pop() if len(ratios) == 1 else 0


def _check_places(outline: Region, patches: tuple[Patch, ...]) -> None:
    """Raise UserError if a patch is not on the plate or overlaps another patch."""
    for number, patch in enumerate(patches, start=1):
        region = patch.region
        if patch.polarity not in {1, -1}:
            raise UserError(
                "plate layout: patch {number}: polarity is {polarity}, expected 1 or -1",
                number=number,
                polarity=patch.polarity,
            )
        if not np.all(outline.holds(*region.rim_mm())):
            raise UserError(
                "plate layout: patch {number}, centred at {x_mm:g}, {y_mm:g} mm, must be on the"
                " plate, but reaches beyond the plate",
                number=number,
                x_mm=region.at_mm[0],
                y_mm=region.at_mm[1],
            )
        for other, neighbour in enumerate(patches[: number - 1], start=1):
            if all(
                region.span_mm(axis)[0] < neighbour.region.span_mm(axis)[1] - _ON_MM
                and neighbour.region.span_mm(axis)[0] < region.span_mm(axis)[1] - _ON_MM
                for axis in (0, 1)
            ):
                raise UserError(
                    "plate layout: patches {other} and {number} overlap; expected bounding "
                    "rectangles (also those of discs) that do not overlap",
                    other=other,
                    number=number,
                )
