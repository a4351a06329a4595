"""The plate in three dimensions: quadratic bricks with piezoelectric coupling.

Every matrix of a layer is a contraction of the nine integrals ∫ ∂_k N_i ∂_l N_j of each element
with that layer's constants: stiffness with c^E, coupling with e, capacitance with ε^S. scikit-fem
provides the gradients at the integration points. Displacement and potential share one scalar basis,
so their integration is consistent.

Displacements are in m. Potentials are in units of `POTENTIAL_UNIT_V`, so that the entries of all
blocks have similar magnitudes. The touch surface faces up; the ceramics' upper faces are bonded to
the grounded resonator.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy import sparse
from skfem import Basis, BilinearForm, ElementHexS2, MeshHex

from slipscale.hardware.plate.geometry import DEFAULT, Density, Layout, mesh_lines
from slipscale.hardware.plate.materials import VACUUM_PERMITTIVITY_F_M
from slipscale.stimuli.quantities import MILLI

if TYPE_CHECKING:
    import numpy.typing as npt

    from slipscale.stimuli.quantities import Array

Electrodes = Literal["shorted", "open"]
POTENTIAL_UNIT_V = 1e10
_ORDER = 5  # integration order: exact for stiffness and mass of rectangular quadratic bricks
_VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])  # index of a symmetric pair, Appendix B


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Assembly:
    """The matrices of a meshed plate before supports and electrodes; all nodes, x, y, z in turn.

    Parameters
    ----------
    layout, density, quarter
        Layout and mesh; ``quarter`` is x, y >= 0 with symmetry at both planes.
    nodes : ndarray, shape (3, n)
        Positions, m.
    stiffness, mass : sparse, shape (3n, 3n)
        N/m and kg.
    ceramic_stiffness : sparse, shape (3n, 3n)
        The ceramics' part of ``stiffness``.
    coupling : sparse, shape (3n, n)
        Nodal forces per potential, N per potential unit.
    capacitance : sparse, shape (n, n)
        Charge per potential, in matching units.
    """

    layout: Layout
    density: Density
    quarter: bool
    nodes: Array
    stiffness: Any
    ceramic_stiffness: Any
    mass: Any
    coupling: Any
    capacitance: Any

    def at(self, **planes: float) -> npt.NDArray[np.bool_]:
        """Return which nodes are on the given planes, e.g. ``at(x=0.0, z=0.003)`` in m."""
        chosen = np.ones(self.nodes.shape[1], dtype=bool)
        for axis, value in planes.items():
            chosen &= np.abs(self.nodes["xyz".index(axis)] - value) < 1e-9  # noqa: PLR2004 - 1 nm
        return chosen

    @property
    def thickness_m(self) -> float:
        """Height of the touch surface above the ceramics' free face, m."""
        return (self.layout.ceramic_thickness_mm + self.layout.resonator_thickness_mm) * MILLI


@lru_cache(maxsize=2)
def assemble(layout: Layout, density: Density = DEFAULT, *, quarter: bool = True) -> Assembly:
    """Mesh a layout and assemble its matrices."""
    mesh, ceramic = _mesh(layout, density, quarter=quarter)
    element = ElementHexS2()
    basis = Basis(mesh, element, intorder=_ORDER)
    size = basis.N
    stiffness: dict[bool, Any] = {}
    mass = sparse.csr_matrix((size, size))
    layers = (
        (False, layout.resonator.stiffness_pa, layout.resonator.density_kg_m3),
        (True, layout.ceramic.stiffness, layout.ceramic.density_kg_m3),
    )
    for active, constants, density_kg_m3 in layers:
        layer = Basis(mesh, element, intorder=_ORDER, elements=np.flatnonzero(ceramic == active))
        products = _products(layer)
        tensor = constants[_VOIGT[:, :, None, None], _VOIGT]
        stiffness[active] = _blocks(tensor.transpose(0, 2, 1, 3), layer, products)
        overlap = BilinearForm(lambda u, v, _: u * v)
        mass = mass + density_kg_m3 * overlap.assemble(layer)
    # The loop ends with the ceramics, whose products are used for coupling and capacitance.
    piezo = layout.ceramic.coupling[:, _VOIGT] * POTENTIAL_UNIT_V
    coupling = _blocks(piezo.transpose(1, 2, 0)[:, None], layer, products)
    permittivity = np.diag(layout.ceramic.relative_permittivity) * VACUUM_PERMITTIVITY_F_M
    capacitance = _blocks(permittivity[None, None] * POTENTIAL_UNIT_V**2, layer, products)
    return Assembly(
        layout=layout,
        density=density,
        quarter=quarter,
        nodes=basis.doflocs,
        stiffness=stiffness[False] + stiffness[True],
        ceramic_stiffness=stiffness[True],
        mass=sparse.block_diag([mass] * 3, format="csr"),
        coupling=coupling,
        capacitance=capacitance,
    )


def _mesh(layout: Layout, density: Density, *, quarter: bool) -> tuple[MeshHex, Array]:
    """Return the mesh and which of its bricks are ceramic; gaps and borders are cut out."""
    (x, bare_x), (y, bare_y) = (
        mesh_lines(length_mm, pieces, layout.gap_mm, bricks, half=quarter, border_mm=border_mm)
        for length_mm, pieces, bricks, border_mm in zip(
            (layout.length_mm, layout.width_mm),
            (layout.columns, layout.rows),
            (density.along_ceramic, density.across_ceramic),
            layout.border_mm,
            strict=True,
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
    mesh = MeshHex.init_tensor(x, y, z)
    middle = mesh.p[:, mesh.t].mean(axis=1)
    low = middle[2] < step
    bare = bare_x[np.searchsorted(x, middle[0]) - 1] | bare_y[np.searchsorted(y, middle[1]) - 1]
    keep = ~(low & bare)
    return mesh.restrict(np.flatnonzero(keep)), low[keep]


def _products(basis: Basis) -> Array:
    """Return ∫ ∂_k N_i ∂_l N_j of each element's nodes i, j, shape (elements, nodes, nodes, 9)."""
    gradients = np.stack([np.asarray(each[0].grad) for each in basis.basis])  # i, k, element, point
    nodes, _, elements, points = gradients.shape
    left = gradients.transpose(2, 0, 1, 3).reshape(elements, 3 * nodes, points)
    right = (gradients * basis.dx).transpose(2, 3, 0, 1).reshape(elements, points, 3 * nodes)
    products = (left @ right).reshape(elements, nodes, 3, nodes, 3)
    return np.asarray(products.transpose(0, 1, 3, 2, 4).reshape(elements, nodes, nodes, 9))


def _blocks(tensor: Array, basis: Basis, products: Array) -> Any:
    """Return the sparse matrix with blocks [a][b] = Σ_kl tensor[a, b, k, l] ∫ ∂_k N_i ∂_l N_j."""
    rows, columns = tensor.shape[:2]
    size, of_element = basis.N, basis.element_dofs.T
    values = products @ tensor.reshape(rows * columns, 9).T
    a, b = np.divmod(np.arange(rows * columns), columns)
    i = of_element[:, :, None, None] + size * a
    j = of_element[:, None, :, None] + size * b
    places = [np.broadcast_to(each, values.shape).ravel() for each in (i, j)]
    shape = (rows * size, columns * size)
    return sparse.coo_matrix((values.ravel(), places), shape=shape).tocsr()
