"""Dimensionless periodic solution of Reynolds' equation (3).

The method combines finite volumes across the ridges (second order, conservative) with Fourier
collocation in time. The states at all instants of one period are solved for together, without time
stepping or transients. The Newton steps are block-tridiagonal, with one dense block of instants
per cell. The film is symmetric about the middle of the contact, so only half of it is solved.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_banded

from slipscale.faults import UserError
from slipscale.stimuli.quantities import Array

_TOLERANCE = 1e-10  # of the largest Newton step in P
_NEWTON_STEPS = 40
_ITERATIONS, _RATE_TOLERANCE = 200, 1e-6  # of the decay rate
_DIRECT_SIGMA = 1e4  # up to here, Newton's method converges from the film at rest
_RIDGE_GRADING, _EDGE_GRADING = 0.85, 0.6  # cells shrink to 15 % at a ridge, 40 % at the edge


class ReynoldsDiverged(UserError):
    """Newton's method found no periodic state: the case is beyond this solver."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Resolution:
    """Resolution of the film in space and time.

    Parameters
    ----------
    cells_per_ridge : int
        Finite volumes per period of the ridges.
    cells_min : int
        Fewest finite volumes over half the contact, whatever the ridges.
    instants : int
        Instants per period; odd, so that differentiation in time is antisymmetric.
    """

    cells_per_ridge: int = 24
    cells_min: int = 160
    instants: int = 17

    def __post_init__(self) -> None:
        if min(self.cells_per_ridge, self.cells_min) < 1:
            raise UserError("resolution: cells_per_ridge and cells_min must be 1 or more")
        if self.instants < 3 or self.instants % 2 == 0:  # noqa: PLR2004 - one harmonic needs three
            raise UserError(
                f"resolution: instants is {self.instants}, expected an odd number of 3 or more"
            )


# (largest squeeze number, resolution): within 0.1 % for the first, 1 % for the last. The film's
# layers under a ridge and at the edge get thinner as the squeeze number grows.
RESOLUTIONS = (
    (300.0, Resolution()),
    (5_000.0, Resolution(cells_per_ridge=96, cells_min=320)),
    (np.inf, Resolution(cells_per_ridge=192, cells_min=640)),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class FilmState:
    """The film's periodic state over half the contact.

    Parameters
    ----------
    position : ndarray, shape (cells,)
        X = x/l0 of the cells' centres, from 0 to 1/2.
    width : ndarray, shape (cells,)
        Width of the cells, in X; their sum is 1/2.
    pressure : ndarray, shape (cells, instants)
        P = p/p0.
    thickness : ndarray, shape (cells, instants)
        H of equation (2), mean over the cell.
    conductance : ndarray, shape (cells, instants)
        H³ at each cell's outer face over the distance to the next cell's centre, or to the edge.
    squeeze_number, storage_exponent : float
        σ of equation (4), and m = 1/n with the polytropic exponent n.
    flow_imbalance : float
        Largest mean mass flow through any cell's face, relative to the largest flow at any
        instant: 0 if mass is conserved, because no gas accumulates in a periodic state.
    newton_steps : int
        Number of Newton steps.
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
        """P at each position, mean over the period, shape (cells,)."""
        return np.asarray(self.pressure.mean(axis=1))

    @property
    def decay_rate(self) -> float:
        """Decay rate of a small disturbance of the film, per radian of the vibration.

        The smallest Floquet exponent of equation (3), linearised about the periodic state. This
        exponent belongs to a disturbance that changes by a constant factor from period to period,
        and is found by inverse iteration with Newton's matrix.
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
        raise ReynoldsDiverged("no slowest disturbance of the film was found: two are equally slow")

    @property
    def overpressure(self) -> float:
        """Mean of p/p0 - 1 over contact and period: F_s of equation (12)."""
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
    """Solve (H³ P^m P_X)_X = σ (P^m H)_T for P periodic in T with P = 1 at the edge.

    Parameters
    ----------
    sigma, eps, delta, wave_number : float
        σ of equation (4); ε, δ and k of equation (2).
    storage_exponent : float
        m = 1/n, where n is the polytropic exponent.
    resolution : Resolution, optional
        Cells and instants; default: the entry of `RESOLUTIONS` for the squeeze number.

    Raises
    ------
    ReynoldsDiverged
        If Newton's method failed, which can happen above a squeeze number of 10⁵.
    """
    resolution = resolution or next(fit for most, fit in RESOLUTIONS if sigma <= most)
    face, middle = _grid(wave_number, delta, resolution)
    width = np.diff(face)
    instants = resolution.instants
    vibration = 1 + eps * np.cos(2 * np.pi * np.arange(instants) / instants)
    # The ridges' mean over each cell is exact, and so is the film's volume.
    ridges = delta * np.diff(np.sin(wave_number * face)) / (wave_number * width)
    thickness = vibration + ridges[:, None]
    at_face = vibration + (delta * np.cos(wave_number * face[1:]))[:, None]
    distance = np.append(np.diff(middle), face[-1] - middle[-1])
    conductance = at_face**3 / distance[:, None]
    storage = sigma * width[:, None] * thickness
    m = storage_exponent
    rate = _differentiation(instants)

    def outflow(p: Array) -> Array:
        """Mass flow towards the edge through each cell's outer face (times -1)."""
        driven = np.vstack([p, np.ones(instants)]) ** (1 + m) / (1 + m)
        return np.asarray(conductance * np.diff(driven, axis=0))

    pressure, steps = np.ones_like(thickness), 0
    # Large squeeze numbers are approached from smaller ones.
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
            # Halve the step while it would make the pressure negative somewhere.
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
    """Return the number of squeeze numbers to solve, each at most four times the previous one."""
    return 1 + max(0, int(np.ceil(np.log(sigma / _DIRECT_SIGMA) / np.log(4))))


def _block_tridiagonal_step(
    conductance: Array, storage_slope: Array, mobility: Array, rate: Array, residual: Array
) -> Array:
    """Return the Newton step from a band matrix in which each cell's instants are consecutive.

    Neighbouring cells are coupled only at equal instants, by the outermost diagonals. The instants
    of one cell are coupled by the time derivative (a dense block).
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
    """Return the cells' faces and centres in X, smoothly refined at the ridges and the edge."""
    ridges = wave_number / (4 * np.pi) if delta else 0.0  # in half the contact
    cells = max(resolution.cells_min, round(resolution.cells_per_ridge * ridges))
    s = np.linspace(0, 1, 2 * cells + 1)
    graded = (1 + _EDGE_GRADING) * s - _EDGE_GRADING * s**2
    pull = _RIDGE_GRADING * delta
    end = wave_number / 2
    # u + pull·sin u = k/2 at the edge: a contraction, for pull < 1.
    last = end
    for _ in range(200):
        last = last - (last + pull * np.sin(last) - end) / (1 + pull)
    u = last * graded
    x = (u + pull * np.sin(u)) / wave_number
    x[-1] = 0.5
    return x[::2], x[1::2]


def _differentiation(instants: int) -> Array:
    """Return the matrix that differentiates a 2π-periodic function at an odd number of instants."""
    offset = np.arange(instants)[:, None] - np.arange(instants)
    with np.errstate(divide="ignore"):
        matrix = (-1.0) ** offset / (2 * np.sin(np.pi * offset / instants))
    np.fill_diagonal(matrix, 0)
    return np.asarray(matrix)
