"""Solve Reynolds' equation (3) for the periodic film in dimensionless form.

The method combines finite volumes across the ridges (second order, conservative) with Fourier
collocation in time. The equations for all time points of a period are solved simultaneously, so
time stepping is not needed. The matrix of a Newton step is block-tridiagonal; each cell has a dense
block that couples its time points. By symmetry, only half of the contact is solved.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_banded

from slipscale.faults import UserError
from slipscale.stimuli.quantities import Array

_TOLERANCE = 1e-10  # tolerance for the largest Newton step in P
_NEWTON_STEPS = 40
_ITERATIONS, _RATE_TOLERANCE = 200, 1e-6  # relative tolerance for the decay rate
_DIRECT_SIGMA = 1e4  # largest squeeze number solved without intermediate ones
_RIDGE_GRADING, _EDGE_GRADING = 0.85, 0.6  # grid refinement at the ridges and at the edge (0: none)


class ReynoldsDiverged(UserError):
    """Raised if Newton's method does not find a periodic state."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Resolution:
    """Spatial and temporal resolution of the numerical solution.

    Parameters
    ----------
    cells_per_ridge : int
        Number of finite volumes per period of the ridges.
    cells_min : int
        Minimum number of finite volumes over half of the contact.
    instants : int
        Number of time points per period. It must be odd, so that the differentiation matrix is
        antisymmetric.
    """

    cells_per_ridge: int = 24
    cells_min: int = 160
    instants: int = 17

    def __post_init__(self) -> None:
        if min(self.cells_per_ridge, self.cells_min) < 1:
            raise UserError("resolution: cells_per_ridge and cells_min must be 1 or more")
        if self.instants < 3 or self.instants % 2 == 0:  # noqa: PLR2004 - one harmonic needs three
            raise UserError(
                "resolution: instants must be odd and at least 3, but is {instants}",
                instants=self.instants,
            )


# Largest squeeze number for each resolution. Errors are at most 0.1 % with the first resolution,
# and 1 % with the last. Boundary layers at ridges and at the edge get thinner with increasing
# squeeze number.
RESOLUTIONS = (
    (300.0, Resolution()),
    (5_000.0, Resolution(cells_per_ridge=96, cells_min=320)),
    (np.inf, Resolution(cells_per_ridge=192, cells_min=640)),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class FilmState:
    """Periodic state of the film over half of the contact.

    Parameters
    ----------
    position : ndarray, shape (cells,)
        Positions X = x/l0 of the cell centres, from 0 to 1/2.
    width : ndarray, shape (cells,)
        Widths of the cells in X, which add up to 1/2.
    pressure : ndarray, shape (cells, instants)
        Relative pressure P = p/p0.
    thickness : ndarray, shape (cells, instants)
        H of equation (2), averaged over each cell.
    conductance : ndarray, shape (cells, instants)
        Flow conductance of the outer face of each cell: H³ at the face, divided by the distance
        between the centres of the two cells (for the last cell, from its centre to the edge).
    squeeze_number, storage_exponent : float
        σ of equation (4), and m = 1/n, where n is the polytropic exponent.
    flow_imbalance : float
        Largest time-averaged mass flow through a face, divided by the largest flow at any time
        point; 0 if mass is conserved.
    newton_steps : int
    """

    position: Array
    width: Array
    pressure: Array
    thickness: Array
    conductance: Array
    squeeze_number: float
    storage_exponent: float
    flow_imbalance: float
    newton_steps: int

    @property
    def mean_pressure(self) -> Array:
        """Mean of P over a period at each position, shape (cells,)."""
        return np.asarray(self.pressure.mean(axis=1))

    @property
    def decay_rate(self) -> float:
        """Decay rate of the slowest-decaying small disturbance, per radian of the vibration.

        This is the smallest Floquet exponent of equation (3), linearised about the periodic state.
        The eigenvector (a disturbance that changes by a constant factor per period) is found by
        inverse iteration with the matrix of Newton's method.
        """
        m = self.storage_exponent
        storage = (
            self.squeeze_number
            * self.width[:, None]
            * self.thickness
            * (m * self.pressure ** (m - 1))
        )
        rate = _differentiation(self.pressure.shape[1])
        disturbance, found = np.ones_like(self.pressure), np.inf
        for _ in range(_ITERATIONS):
            slower = _block_tridiagonal_step(
                self.conductance, storage, self.pressure**m, rate, storage * disturbance
            )
            before, found = found, float(np.abs(disturbance).max() / np.abs(slower).max())
            disturbance = slower / np.abs(slower).max()
            if abs(found - before) < _RATE_TOLERANCE * found:
                return found
        raise ReynoldsDiverged(
            "two disturbances of the film decay equally slowly, so the decay rate was not found"
        )

    @property
    def overpressure(self) -> float:
        """Mean of p/p0 - 1 over the contact and the period: F_s in equation (12) of the paper."""
        return float(2 * self.width @ (self.mean_pressure - 1))


def periodic_state(
    sigma: float,
    eps: float,
    delta: float,
    wave_number: float,
    *,
    storage_exponent: float = 1.0,
    resolution: Resolution | None = None,
) -> FilmState:
    """Solve (H³ P^m P_X)_X = σ (P^m H)_T for P periodic in T, with P = 1 at the edge.

    Parameters
    ----------
    sigma, eps, delta, wave_number : float
        Squeeze number σ in equation (4), and the parameters ε, δ and k in equation (2).
    storage_exponent : float
        m = 1/n, where n is the polytropic exponent.
    resolution : Resolution, optional
        Resolution in space and time. The default is the entry of `RESOLUTIONS` for the squeeze
        number.

    Raises
    ------
    ReynoldsDiverged
        If Newton's method fails, which can happen if the squeeze number is above 10⁵.
    """
    resolution = resolution or next(fit for most, fit in RESOLUTIONS if sigma <= most)
    face, middle = _grid(wave_number, delta, resolution)
    width = np.diff(face)
    instants = resolution.instants
    vibration = 1 + eps * np.cos(2 * np.pi * np.arange(instants) / instants)
    # The thickness is averaged exactly over each cell, so that the volume of the film is exact.
    ridges = delta * np.diff(np.sin(wave_number * face)) / (wave_number * width)
    thickness = vibration + ridges[:, None]
    at_face = vibration + (delta * np.cos(wave_number * face[1:]))[:, None]
    distance = np.append(np.diff(middle), face[-1] - middle[-1])
    conductance = at_face**3 / distance[:, None]
    storage = sigma * width[:, None] * thickness
    m = storage_exponent
    rate = _differentiation(instants)

    def outflow(p: Array) -> Array:
        """Return the mass flow through the outer face of each cell (negative towards the edge)."""
        driven = np.vstack([p, np.ones(instants)]) ** (1 + m) / (1 + m)
        return np.asarray(conductance * np.diff(driven, axis=0))

    pressure, steps = np.ones_like(thickness), 0
    # Large squeeze numbers are solved by starting from smaller ones.
    for share in np.geomspace(min(1.0, _DIRECT_SIGMA / sigma), 1.0, _stages(sigma)):
        for _ in range(_NEWTON_STEPS):
            steps += 1
            residual = (
                np.diff(outflow(pressure), axis=0, prepend=0.0)
                - share * (storage * pressure**m) @ rate.T
            )
            change = _block_tridiagonal_step(
                conductance, share * storage * m * pressure ** (m - 1), pressure**m, rate, residual
            )
            # Steps that would make the pressure negative are halved.
            fraction = 1.0
            while np.min(pressure + fraction * change) <= 0:
                fraction /= 2
            pressure = pressure + fraction * change
            if np.max(np.abs(change)) < _TOLERANCE:
                break
        else:
            raise ReynoldsDiverged(
                f"no periodic film found at squeeze number {sigma:.3g}, epsilon {eps:.3g}, "
                f"delta {delta:.3g} after {steps} Newton steps; the solver is reliable for "
                "squeeze numbers up to 1e5"
            )
    flow = outflow(pressure)
    largest = np.max(np.abs(flow), initial=np.finfo(float).tiny)
    return FilmState(
        position=middle,
        width=width,
        pressure=pressure,
        thickness=thickness,
        conductance=conductance,
        squeeze_number=sigma,
        storage_exponent=m,
        flow_imbalance=float(np.max(np.abs(flow.mean(axis=1))) / largest),
        newton_steps=steps,
    )


def _stages(sigma: float) -> int:
    """Return how many squeeze numbers are solved; each is at most 4 times the previous one."""
    return 1 + max(0, int(np.ceil(np.log(sigma / _DIRECT_SIGMA) / np.log(4))))


def _block_tridiagonal_step(
    conductance: Array, storage_slope: Array, mobility: Array, rate: Array, residual: Array
) -> Array:
    """Solve for the Newton step with a banded matrix; all time points of a cell are adjacent.

    The outermost diagonals of the matrix couple neighbouring cells at the same time point. For each
    cell, the time derivative adds a dense block that couples all time points.
    """
    instants = residual.shape[1]
    at = np.arange(instants)
    flow = conductance[:-1]
    blocks = -rate * storage_slope[:, None, :]
    blocks[:, at, at] -= np.vstack([conductance[:1], conductance[1:] + flow]) * mobility
    band = np.zeros((2 * instants + 1, *residual.shape))
    band[instants + at[:, None] - at, :, at] = blocks.transpose(1, 2, 0)
    band[0, 1:] = flow * mobility[1:]
    band[-1, :-1] = flow * mobility[:-1]
    change = solve_banded(
        (instants, instants), band.reshape(len(band), -1), -residual.ravel(), check_finite=False
    )
    return np.asarray(change).reshape(residual.shape)


def _grid(wave_number: float, delta: float, resolution: Resolution) -> tuple[Array, Array]:
    """Return the faces and centres of the cells in X, refined near ridges and near the edge."""
    ridges = wave_number / (4 * np.pi) if delta else 0.0  # in half the contact
    cells = max(resolution.cells_min, round(resolution.cells_per_ridge * ridges))
    s = np.linspace(0, 1, 2 * cells + 1)
    graded = (1 + _EDGE_GRADING) * s - _EDGE_GRADING * s**2
    pull = _RIDGE_GRADING * delta
    end = wave_number / 2
    # The edge is at the solution of u + pull·sin u = k/2. The iteration converges for pull < 1.
    last = end
    for _ in range(200):
        last = last - (last + pull * np.sin(last) - end) / (1 + pull)
    u = last * graded
    x = (u + pull * np.sin(u)) / wave_number
    x[-1] = 0.5
    return x[::2], x[1::2]


def _differentiation(instants: int) -> Array:
    """Return the differentiation matrix for 2π-periodic functions at an odd number of points."""
    offset = np.arange(instants)[:, None] - np.arange(instants)
    with np.errstate(divide="ignore"):
        matrix = (-1.0) ** offset / (2 * np.sin(np.pi * offset / instants))
    np.fill_diagonal(matrix, 0)
    return np.asarray(matrix)
