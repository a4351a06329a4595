"""Compare film and plate models with the usual alternatives, as ratios from a single run.

Repeat with ``.venv/bin/python benchmarks/models.py``. One core: set OMP_NUM_THREADS=1.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np
from scipy.integrate import solve_ivp
from scipy.sparse.linalg import eigsh
from skfem import Basis, BilinearForm, ElementHexS2, ElementVector
from skfem.helpers import ddot, sym_grad, trace

from slipscale.hardware.plate.finite_elements import _bricks, assemble
from slipscale.hardware.plate.geometry import Density, Layout
from slipscale.hardware.plate.vibration import modes, support
from slipscale.stimuli.film.periodic_film import periodic_state

FILM = {"sigma": 15.9, "eps": 0.3, "delta": 0.6, "wave_number": 6 * np.pi}  # Three ridges.
T = TypeVar("T")
CELLS, PERIODS = 160, 40
PLATE, MESH = Layout.prototype(), Density(along_ceramic=4, across_ceramic=3)


def timed(work: Callable[[], T], repeat: int = 3) -> tuple[float, T]:
    """Return the shortest of several run times in s, and the function's result."""
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - start)
    return min(times), result


def marched() -> float:
    """Return the film's mean overpressure after integrating many periods with SciPy's BDF."""
    sigma, eps, delta, k = FILM.values()
    dx = 0.5 / CELLS
    middle, face = (np.arange(CELLS) + 0.5) * dx, np.arange(1, CELLS + 1) * dx

    def gap(x: np.ndarray, t: float) -> np.ndarray:
        return np.asarray(1 + eps * np.cos(t) + delta * np.cos(k * x))

    def slope(t: float, content: np.ndarray) -> np.ndarray:
        pressure = content / gap(middle, t)
        flow = gap(face, t) ** 3 * np.diff(np.append(pressure**2 / 2, 0.5)) / dx
        flow[-1] *= 2
        return np.diff(flow, prepend=0.0) / (sigma * dx)

    times = 2 * np.pi * (PERIODS - 1 + np.arange(32) / 32)
    pattern = np.eye(CELLS) + np.eye(CELLS, k=1) + np.eye(CELLS, k=-1)
    done = solve_ivp(
        slope,
        (0, times[-1]),
        gap(middle, 0.0),
        method="BDF",
        t_eval=times,
        rtol=1e-6,
        jac_sparsity=pattern,
    )
    pressure = done.y / np.array([gap(middle, t) for t in times]).T
    return float(2 * dx * np.sum(pressure.mean(axis=1) - 1))


def stock_assembly() -> object:
    """Assemble the stiffness with scikit-fem's vector element and a single material throughout."""
    basis = Basis(
        _bricks(PLATE, MESH, quarter=True).mesh, ElementVector(ElementHexS2()), intorder=5
    )
    lame = PLATE.resonator.stiffness_pa

    @BilinearForm  # type: ignore[untyped-decorator]
    def stiffness(u: object, v: object, _: object) -> object:
        strain, other = sym_grad(u), sym_grad(v)
        return lame[0, 1] * trace(strain) * trace(other) + 2 * lame[3, 3] * ddot(strain, other)

    return stiffness.assemble(basis)


def own_assembly() -> object:
    """Assemble all five matrices (stiffness, mass, coupling, capacitance, ceramics)."""
    assemble.cache_clear()
    return assemble(PLATE, MESH)


def stock_modes() -> object:
    """Find eight modes with SciPy's shift-invert mode (default ordering), without coupling."""
    system = support(assemble(PLATE, MESH))
    return eigsh(system.stiffness, k=8, M=system.mass, sigma=(2 * np.pi * 34_500.0) ** 2)


def own_modes() -> object:
    """Find eight modes with the potential eliminated in each solve."""
    modes.cache_clear()
    return modes(PLATE, 34_500.0, 8, density=MESH)


def main() -> None:
    ours, state = timed(lambda: periodic_state(**FILM))  # type: ignore[arg-type]
    theirs, overpressure = timed(marched, 1)
    apart = abs(overpressure / state.overpressure - 1)
    print(
        f"film, three ridges     ours {ours:.3f} s, marching {PERIODS} periods {theirs:.2f} s: "
        f"{theirs / ours:.0f} times; results {apart:.1%} apart"
    )
    for name, own, stock in (
        ("plate, assembly", own_assembly, stock_assembly),
        ("plate, eight modes", own_modes, stock_modes),
    ):
        (ours, _), (theirs, _) = timed(own), timed(stock)
        print(f"{name:<22} ours {ours:.3f} s, stock {theirs:.2f} s: {theirs / ours:.1f} times")


if __name__ == "__main__":
    main()
