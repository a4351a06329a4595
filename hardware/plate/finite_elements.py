"""Model plates in three dimensions with quadratic bricks and piezoelectric coupling.

The matrices of a layer are contractions of the nine integrals ∫ ∂_k N_i ∂_l N_j of each element
with the constants of the layer: c^E for stiffness, e for coupling, ε^S for capacitance. scikit-fem
provides the shape functions and numbers the nodes. Displacement and potential use the same scalar
basis functions.

All bricks are rectangular. If the edge of a disc cuts a brick, only the part inside the disc is
integrated, and bricks with less than a thousandth inside are omitted (finite cell method,
Parvizian, Duester and Rank, Computational Mechanics 41, 2007).

Displacements are in m. Potentials are in units of `POTENTIAL_UNIT_V`, so that the entries of all
blocks have similar magnitudes. The touch surface faces up; the ceramics' upper faces are bonded to
the grounded resonator.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from scipy import sparse
from skfem import Basis, ElementHexS2, MeshHex

from slipscale.hardware.plate.geometry import DEFAULT, Density, Layout, Region, mesh_lines
from slipscale.hardware.plate.materials import VACUUM_PERMITTIVITY_F_M
from slipscale.stimuli.quantities import MILLI, Array

Electrodes = Literal["shorted", "open"]
POTENTIAL_UNIT_V = 1e10
# Bricks are omitted if at most this fraction is material, because their nodes would be almost free.
_LEAST_FILLED = 1e-3
# Three points integrate the stiffness and mass of a full brick exactly. Along x, each brick has
# six equal parts, because the edge of a disc that cuts a brick is curved.
_GAUSS, _GAUSS_WEIGHTS = (np.polynomial.legendre.leggauss(3) + np.array([[1.0], [0.0]])) / 2
_PARTS = 6
_ACROSS = ((np.arange(_PARTS)[:, None] + _GAUSS) / _PARTS).ravel()
_ACROSS_WEIGHTS = np.tile(_GAUSS_WEIGHTS, _PARTS) / _PARTS
_VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])  # Voigt index of two axes, as in Appendix B


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Assembly:
    """Matrices for a meshed plate without supports and electrodes.

    Parameters
    ----------
    layout, density, quarter
        Layout and mesh. If ``quarter`` is True, the mesh covers only x, y >= 0, with two planes of
        symmetry.
    nodes : ndarray, shape (3, n)
        Positions in m.
    polarity : ndarray, shape (n,)
        Polarity (+1 or -1) of the ceramic that contains the node; 0 in the resonator.
    stiffness, mass : sparse, shape (3n, 3n)
        Stiffness in N/m and mass in kg. The rows and columns are ordered by direction: all nodes in
        x, then all nodes in y, then all nodes in z.
    ceramic_stiffness : sparse, shape (3n, 3n)
        Part of ``stiffness`` that is due to the ceramics.
    coupling : sparse, shape (3n, n)
        Nodal forces in N per `POTENTIAL_UNIT_V`.
    capacitance : sparse, shape (n, n)
        Electric charge per unit potential, in units consistent with ``coupling``.
    """

    layout: Layout
    density: Density
    quarter: bool
    nodes: Array
    polarity: Array
    stiffness: Any
    ceramic_stiffness: Any
    mass: Any
    coupling: Any
    capacitance: Any

    def at(self, **planes: float) -> npt.NDArray[np.bool_]:
        """Return a mask of the nodes on planes given in m, for example ``at(x=0.0, z=0.003)``."""
        chosen = np.ones(self.nodes.shape[1], dtype=bool)
        for axis, value in planes.items():
            chosen &= np.abs(self.nodes["xyz".index(axis)] - value) < 1e-9  # noqa: PLR2004 - 1 nm
        return chosen

    @property
    def thickness_m(self) -> float:
        """Height of the touch surface above the free face of the ceramics, in m."""
        return (self.layout.ceramic_thickness_mm + self.layout.resonator_thickness_mm) * MILLI

    @property
    def mirrors(self) -> tuple[int, int]:
        """Symmetry of the drive at x = 0 and y = 0, or (0, 0) if the whole plate is meshed."""
        return self.layout.mirrors if self.quarter else (0, 0)

    @property
    def on_top(self) -> npt.NDArray[np.intp]:
        """Indices of nodes on the touch surface, except nodes beyond the edge of a disc."""
        on = self.layout.outline.holds(*self.nodes[:2] / MILLI)
        return np.flatnonzero(self.at(z=self.thickness_m) & on)


@lru_cache(maxsize=2)
def assemble(layout: Layout, density: Density = DEFAULT, *, quarter: bool = True) -> Assembly:
    """Mesh a layout and assemble its matrices. Only symmetric plates are reduced to a quarter."""
    quarter = quarter and all(layout.mirrors)
    bricks = _bricks(layout, density, quarter=quarter)
    basis = Basis(bricks.mesh, ElementHexS2(), intorder=1)  # used only to number the nodes
    size = basis.N
    polarity = np.zeros(size)
    # Nodes shared by ceramics that touch each other belong to the negative electrode.
    for sign in (1, -1):
        polarity[basis.element_dofs[:, bricks.polarity == sign]] = sign
    stiffness: dict[bool, Any] = {}
    mass = sparse.csr_matrix((size, size))
    layers = (
        (False, layout.resonator.stiffness_pa, layout.resonator.density_kg_m3),
        (True, layout.ceramic.stiffness, layout.ceramic.density_kg_m3),
    )
    for active, constants, density_kg_m3 in layers:
        layer = np.flatnonzero((bricks.polarity != 0) == active)
        nodes = basis.element_dofs.T[layer]
        products, overlap = _integrals(bricks, layer)
        tensor = constants[_VOIGT[:, :, None, None], _VOIGT]
        stiffness[active] = _blocks(tensor.transpose(0, 2, 1, 3), nodes, size, products)
        unit = np.ones((1, 1, 1, 1))
        mass = mass + density_kg_m3 * _blocks(unit, nodes, size, overlap)
    # `nodes` and `products` are those of the last layer, the ceramics.
    piezo = layout.ceramic.coupling[:, _VOIGT] * POTENTIAL_UNIT_V
    coupling = _blocks(piezo.transpose(1, 2, 0)[:, None], nodes, size, products)
    permittivity = np.diag(layout.ceramic.relative_permittivity) * VACUUM_PERMITTIVITY_F_M
    capacitance = _blocks(permittivity[None, None] * POTENTIAL_UNIT_V**2, nodes, size, products)
    return Assembly(
        layout=layout,
        density=density,
        quarter=quarter,
        nodes=basis.doflocs,
        polarity=polarity,
        stiffness=stiffness[False] + stiffness[True],
        ceramic_stiffness=stiffness[True],
        mass=sparse.block_diag([mass] * 3, format="csr"),
        coupling=coupling,
        capacitance=capacitance,
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Bricks:
    """Bricks of a mesh, with their integration points.

    Parameters
    ----------
    mesh : MeshHex
        Mesh without empty bricks.
    size_m : ndarray, shape (3, bricks)
        Edge lengths.
    polarity : ndarray of int, shape (bricks,)
        Polarity of the ceramic that contains the brick; 0 in the resonator.
    rule : ndarray of int, shape (bricks,)
        Integration rule of each brick, as an index into ``points`` and ``weights``; 0 for bricks
        that are filled completely.
    points : ndarray, shape (rules, 3, points)
        Integration points in the unit cube.
    weights : ndarray, shape (rules, points)
        Integration weights. For each rule, their sum is the filled fraction of a brick's volume.
    """

    mesh: MeshHex
    size_m: Array
    polarity: npt.NDArray[np.int_]
    rule: npt.NDArray[np.int_]
    points: Array
    weights: Array


def _bricks(layout: Layout, density: Density, *, quarter: bool) -> _Bricks:
    """Divide a layout into bricks, some of which may be cut by the edge of a disc."""
    x, y = (
        mesh_lines(layout, axis, size_mm / bricks, half=quarter)
        for axis, size_mm, bricks in (
            (0, layout.ceramic_length_mm, density.along_ceramic),
            (1, layout.ceramic_width_mm, density.across_ceramic),
        )
    )
    step = layout.ceramic_thickness_mm * MILLI
    top = step + layout.resonator_thickness_mm * MILLI
    z = np.concatenate(
        [
            np.linspace(0, step, density.ceramic_layers + 1),
            np.linspace(step, top, density.resonator_layers + 1)[1:],
        ]
    )
    # Integration rule 0 is for bricks that are filled completely.
    chords = [np.array([[0.0], [1.0]]).repeat(_ACROSS.size, axis=1)]
    shape = (x.size - 1, y.size - 1)
    in_resonator, in_ceramic = np.full(shape, -1), np.full(shape, -1)
    polarity = np.zeros(shape, dtype=int)
    _cut(layout.outline, x, y, in_resonator, chords)
    for patch in layout.patches:
        polarity[_cut(patch.region, x, y, in_ceramic, chords)] = patch.polarity
    mesh = MeshHex.init_tensor(x, y, z)
    i, j, k = (
        np.searchsorted(lines, middle) - 1
        for lines, middle in zip((x, y, z), mesh.p[:, mesh.t].mean(axis=1), strict=True)
    )
    low = k < density.ceramic_layers
    rule = np.where(low, in_ceramic[i, j], in_resonator[i, j])
    keep = np.flatnonzero(rule >= 0)
    low_end, high_end = np.array(chords)[:, :, :, None, None].transpose(1, 0, 2, 3, 4)
    full = np.ones((len(chords), _ACROSS.size, _GAUSS.size, _GAUSS.size))
    points = np.stack(
        [
            _ACROSS[:, None, None] * full,
            (low_end + (high_end - low_end) * _GAUSS[:, None]) * full,
            _GAUSS * full,
        ],
        axis=1,
    )
    weights = _ACROSS_WEIGHTS[:, None, None] * (high_end - low_end) * full
    weights = weights * _GAUSS_WEIGHTS[:, None] * _GAUSS_WEIGHTS
    return _Bricks(
        mesh=mesh.restrict(keep),
        size_m=np.stack([np.diff(x)[i], np.diff(y)[j], np.diff(z)[k]])[:, keep],
        polarity=np.where(low, polarity[i, j], 0)[keep],
        rule=rule[keep],
        points=points.reshape(len(chords), 3, -1),
        weights=weights.reshape(len(chords), -1),
    )


def _cut(
    region: Region, x: Array, y: Array, rule: npt.NDArray[np.int_], chords: list[Array]
) -> npt.NDArray[np.bool_]:
    """Set the integration rules of the cells that a region fills or cuts, and return their mask.

    For each cell that the region cuts, the lower and upper limits of the region along y are
    appended to ``chords``, in coordinates of the unit square and with shape (2, points along x).
    """
    x_mm = (x[:-1, None] + np.diff(x)[:, None] * _ACROSS) / MILLI
    ends = np.stack(region.chord_mm(x_mm), axis=1)[:, None] * MILLI
    ends = np.clip((ends - y[:-1, None, None]) / np.diff(y)[:, None, None], 0.0, 1.0)
    filled = (ends[:, :, 1] - ends[:, :, 0]) @ _ACROSS_WEIGHTS
    held = filled > _LEAST_FILLED
    rule[held] = 0
    for i, j in np.argwhere(held & (filled < 1 - _LEAST_FILLED)):
        rule[i, j] = len(chords)
        chords.append(ends[i, j])
    return np.asarray(held)


def _integrals(bricks: _Bricks, chosen: npt.NDArray[np.intp]) -> tuple[Array, Array]:
    """Return the integrals ∫ ∂_k N_i ∂_l N_j (m) and ∫ N_i N_j (m³) for the chosen bricks.

    The shapes are (bricks, nodes, nodes, 9) and (bricks, nodes, nodes, 1).
    """
    used, which = np.unique(bricks.rule[chosen], return_inverse=True)
    points, weights = bricks.points[used], bricks.weights[used]
    element = ElementHexS2()
    # The library's tensor-product mesh orders the axes z, x, y and reverses their directions.
    flat = 1 - np.roll(points.transpose(1, 0, 2).reshape(3, -1), 1, axis=0)
    found = [element.lbasis(flat, node) for node in range(element.doflocs.shape[0])]
    nodes, rules = len(found), used.size
    value = np.stack([each[0] for each in found]).reshape(nodes, rules, -1).transpose(1, 0, 2)
    slope = (
        np.roll([each[1] for each in found], -1, axis=1)
        .reshape(3 * nodes, rules, -1)
        .transpose(1, 0, 2)
    )
    overlap = (value * weights[:, None]) @ value.transpose(0, 2, 1)
    product = (slope * weights[:, None]) @ slope.transpose(0, 2, 1)
    product = product.reshape(rules, nodes, 3, nodes, 3).transpose(0, 1, 3, 2, 4)
    size_m = bricks.size_m[:, chosen].T
    volume = size_m.prod(axis=1)
    scale = volume[:, None, None] / (size_m[:, :, None] * size_m[:, None, :])
    products = product.reshape(rules, nodes, nodes, 9)[which] * scale.reshape(-1, 1, 1, 9)
    return products, overlap[which, :, :, None] * volume[:, None, None, None]


def _blocks(tensor: Array, of_element: npt.NDArray[np.int_], size: int, products: Array) -> Any:
    """Assemble a sparse matrix with blocks [a][b] = Σ_kl tensor[a, b, k, l] ∫ ∂_k N_i ∂_l N_j."""
    rows, columns = tensor.shape[:2]
    values = products @ tensor.reshape(rows * columns, -1).T
    a, b = np.divmod(np.arange(rows * columns), columns)
    i = of_element[:, :, None, None] + size * a
    j = of_element[:, None, :, None] + size * b
    places = [np.broadcast_to(each, values.shape).ravel() for each in (i, j)]
    shape = (rows * size, columns * size)
    return sparse.coo_matrix((values.ravel(), places), shape=shape).tocsr()
