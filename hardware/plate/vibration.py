"""Compute the modes and the driven vibration of a meshed plate.

Eigenmodes around a frequency are computed in shift-invert mode (SciPy's ``eigsh``). The electric
potential is solved for together with the displacements, without approximation. Driven vibration is
a superposition of modes with constant loss factors.

The driven mode is identified by its **modal piezoelectric force**, not by its index, because the
whole plate has about eighteen modes between 30 and 40 kHz.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from slipscale.faults import UserError
from slipscale.hardware.plate.finite_elements import (
    POTENTIAL_UNIT_V,
    Assembly,
    Electrodes,
    assemble,
)
from slipscale.hardware.plate.geometry import DEFAULT, Density, Layout
from slipscale.stimuli.quantities import MILLI, Array, not_negative, positive

# Relative tolerance of ω² - σ. A smaller tolerance requires a fifth more solutions of the linear
# system.
_TOLERANCE = 1e-9
_RIGID_BELOW = 1e-3  # fraction of the highest frequency up to which modes are rigid-body modes


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Supported:
    """System of equations for a plate with supports and electrodes.

    Parameters
    ----------
    free : ndarray of int
        Indices of the free displacements.
    stiffness, mass : sparse
        Stiffness and mass matrices for the free displacements.
    coupling, capacitance : sparse
        Matrices for the free potentials inside the ceramics and, for open electrodes, on the
        electrodes.
    force : ndarray
        Nodal forces in N per volt on the outer electrodes, with all displacements held.
    """

    free: npt.NDArray[np.int_]
    stiffness: object
    mass: Any
    coupling: Any
    capacitance: Any
    force: Array


def support(parts: Assembly, electrodes: Electrodes = "shorted") -> Supported:
    """Apply symmetry, supports and electrodes to an assembly.

    The upper faces of the ceramics are grounded. All outer faces have the same voltage, with the
    sign of the ceramic's polarity. If the electrodes are shorted, the voltage is prescribed. If the
    electrodes are open, the charge is zero and the voltage is unknown.
    """
    size = parts.nodes.shape[1]
    held = np.zeros((3, size), dtype=bool)
    planes = (parts.at(x=0.0), parts.at(y=0.0))
    if parts.quarter:
        # At a plane of symmetry, symmetric motions have no normal component, and antisymmetric
        # motions have only a normal component.
        for axis, (mirror, plane) in enumerate(zip(parts.mirrors, planes, strict=True)):
            across = np.arange(3) == axis
            held[across if mirror == 1 else ~across] |= plane
    if parts.layout.ends == "supported":
        end = parts.layout.length_mm * MILLI / 2
        held[2] |= parts.at(x=end) | parts.at(x=-end)
    free = np.flatnonzero(~held.ravel())

    step = parts.layout.ceramic_thickness_mm * MILLI
    in_ceramic = parts.capacitance.diagonal() > 0
    outer, grounded = in_ceramic & parts.at(z=0.0), in_ceramic & parts.at(z=step)
    fixed = outer | grounded
    for mirror, plane in zip(parts.mirrors, planes, strict=True):
        if mirror == -1:
            fixed |= plane
    inside = np.flatnonzero(in_ceramic & ~fixed)
    pattern = np.where(outer, parts.polarity, 0.0)
    selection = sparse.csr_matrix(
        (np.ones(inside.size), (inside, np.arange(inside.size))), shape=(size, inside.size)
    )
    per_volt = pattern / POTENTIAL_UNIT_V
    coupling = parts.coupling[free]
    capacitance = selection.T @ parts.capacitance @ selection
    response = splu(capacitance.tocsc()).solve(selection.T @ (parts.capacitance @ per_volt))
    force = -(coupling @ (per_volt - selection @ response))
    if electrodes == "open":
        selection = sparse.hstack([selection, sparse.csr_matrix(pattern[:, None])], format="csr")
        capacitance = selection.T @ parts.capacitance @ selection
    return Supported(
        free=free,
        stiffness=parts.stiffness[free][:, free].tocsc(),
        mass=parts.mass[free][:, free].tocsc(),
        coupling=(coupling @ selection).tocsc(),
        capacitance=capacitance.tocsc(),
        force=force,
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Modes:
    """Eigenmodes sorted by frequency, normalised to a modal mass of 1 kg m².

    Parameters
    ----------
    parts : Assembly
        Meshed plate.
    frequency_hz : ndarray, shape (modes,)
        Natural frequencies.
    shape : ndarray, shape (modes, 3, nodes)
        Displacements.
    force : ndarray, shape (modes,)
        Modal piezoelectric force per volt.
    ceramic_share : ndarray, shape (modes,)
        Fraction of the strain energy in the ceramics; 0 for rigid-body modes.
    band_hz : tuple of 2 floats
        Frequency band in which the driven mode is chosen.
    """

    parts: Assembly
    frequency_hz: Array
    shape: Array
    force: Array
    ceramic_share: Array
    band_hz: tuple[float, float] = (0.0, np.inf)

    @property
    def driven(self) -> int:
        """Index of the most strongly driven mode in the band, which has the largest (force/ω)²."""
        low_hz = max(self.band_hz[0], _RIGID_BELOW * self.frequency_hz[-1])
        inside = (self.frequency_hz > low_hz) & (self.frequency_hz <= self.band_hz[1])
        return int(np.argmax(np.abs(self.force) / np.where(inside, self.frequency_hz, np.inf)))

    def loss_from_ceramic(self) -> Array:
        """Return the modes' loss factors if energy is lost only in the ceramics (share/Q_m)."""
        return self.ceramic_share / self.parts.layout.ceramic.quality_factor


@lru_cache(maxsize=64)
def modes(
    layout: Layout,
    near_hz: float,
    count: int = 8,
    *,
    density: Density = DEFAULT,
    electrodes: Electrodes = "shorted",
    quarter: bool = True,
) -> Modes:
    """Compute the ``count`` modes nearest to a frequency.

    Raises
    ------
    UserError
        If the frequency is not positive, or if the mesh has fewer modes than requested.
    """
    positive("near_hz", near_hz, "Hz")
    parts = assemble(layout, density, quarter=quarter)
    system = support(parts, electrodes)
    size = system.free.size
    if not 0 < count < size:
        raise UserError(
            "modes: count is {count}, expected 1 to {most} for this mesh",
            count=count,
            most=size - 1,
        )
    sigma = (2 * np.pi * near_hz) ** 2
    whole = sparse.bmat(
        [
            [system.stiffness - sigma * system.mass, system.coupling],
            [system.coupling.T, -system.capacitance],
        ],
        format="csc",
    )
    # The matrix is symmetric and indefinite but far from singular, so pivoting is not necessary.
    factor = splu(
        whole,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    room = np.zeros(whole.shape[0])

    def solve(load: Array) -> Array:
        room[:size] = load.ravel()
        return np.asarray(factor.solve(room)[:size])

    squares, vectors = eigsh(
        system.stiffness,
        k=count,
        M=system.mass,
        sigma=sigma,
        OPinv=LinearOperator((size, size), matvec=solve, dtype=float),
        v0=np.ones(size),
        tol=_TOLERANCE,
    )
    order = np.argsort(squares)
    vectors = vectors[:, order]
    vectors = vectors * np.where(system.force @ vectors < 0, -1.0, 1.0)
    shape = np.zeros((count, 3 * parts.nodes.shape[1]))
    shape[:, system.free] = vectors.T
    total = np.einsum("mi,im->m", shape, parts.stiffness @ shape.T)
    in_ceramic = np.einsum("mi,im->m", shape, parts.ceramic_stiffness @ shape.T)
    elastic = total > _RIGID_BELOW**2 * np.max(total)
    share = np.divide(in_ceramic, total, out=np.zeros(count), where=elastic)
    return Modes(
        parts=parts,
        frequency_hz=np.sqrt(np.maximum(squares[order], 0)) / (2 * np.pi),
        shape=shape.reshape(count, 3, -1),
        force=system.force @ vectors,
        ceramic_share=share,
    )


def response_um(
    found: Modes,
    frequency_hz: npt.ArrayLike,
    voltage_v: float,
    loss_factor: npt.ArrayLike,
    where_mm: tuple[float, float],
) -> Array:
    """Return the complex vertical amplitude in µm peak at a point of the touch surface.

    Parameters
    ----------
    found : Modes
        Modes to superpose. They must cover the drive frequencies.
    frequency_hz : array_like
        Drive frequencies.
    voltage_v : float
        Drive voltage, V peak.
    loss_factor : array_like
        Loss factor 1/Q for all modes, or per mode.
    where_mm : tuple of 2 floats
        x and y of the point, relative to the centre of the plate. The node nearest to the point is
        used.
    """
    here = found.shape[:, 2, nearest_node(found.parts, where_mm)]
    return _superposed_um(found, frequency_hz, voltage_v, loss_factor, here)


def surface_response_um(
    found: Modes, frequency_hz: float, voltage_v: float, loss_factor: npt.ArrayLike
) -> tuple[npt.NDArray[np.intp], Array]:
    """Return the indices of the touch-surface nodes, and their complex amplitudes in µm peak.

    Both arrays have shape (nodes,). For the parameters, see `response_um`.
    """
    on_top = found.parts.on_top
    amplitude_um_peak = [
        _superposed_um(found, frequency_hz, voltage_v, loss_factor, found.shape[:, 2, node])
        for node in on_top
    ]
    return on_top, np.array(amplitude_um_peak)


def _superposed_um(
    found: Modes,
    frequency_hz: npt.ArrayLike,
    voltage_v: float,
    loss_factor: npt.ArrayLike,
    here: Array,
) -> Array:
    """Return the response in µm peak at a point, given the amplitude of each mode at the point."""
    square = (2 * np.pi * found.frequency_hz) ** 2
    drive = (2 * np.pi * positive("frequency_hz", frequency_hz, "Hz")) ** 2
    loss = not_negative("loss_factor", loss_factor, "(no unit)")
    share = found.force * here * voltage_v / (square * (1 + 1j * loss) - drive[..., None])
    return np.asarray(share.sum(axis=-1) * 1e6)


def nearest_node(parts: Assembly, where_mm: tuple[float, float]) -> int:
    """Return the node of the touch surface that is nearest to a point."""
    x, y = (abs(v) if parts.quarter else v for v in where_mm)
    away = np.hypot(*(parts.nodes[:2, parts.on_top] - np.array([[x], [y]]) * MILLI))
    return int(parts.on_top[np.argmin(away)])
