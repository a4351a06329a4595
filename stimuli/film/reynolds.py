"""Solve the full Reynolds equation in physical units, for any squeeze number.

Equation (3) in Biet and others (2007) is solved, with equation (4) corrected as in
`slipscale.stimuli.film.squeeze_film.squeeze_number`. For the method, see
`slipscale.stimuli.film.periodic_film`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np

from slipscale.stimuli.film.periodic_film import FilmState, Resolution, periodic_state
from slipscale.stimuli.film.squeeze_film import (
    AIR,
    FINGER,
    NORMAL_FORCE_N,
    Finger,
    Friction,
    Gas,
    friction_from,
    gap,
    squeeze_number,
)
from slipscale.stimuli.quantities import positive


@dataclass(frozen=True, slots=True, kw_only=True)
class WorkingPoint:
    """Case to solve: peak amplitude in µm, roughness in µm, frequency in Hz, finger and gas."""

    amplitude_um_peak: float
    roughness_um: float
    frequency_hz: float
    finger: Finger = FINGER
    gas: Gas = AIR
    polytropic_exponent: float = 1.0  # n of equation (3): 1 is isothermal, as in the paper

    def __post_init__(self) -> None:
        gap(self.amplitude_um_peak, self.roughness_um, self.finger)
        positive("frequency_hz", self.frequency_hz, "Hz")
        positive("polytropic_exponent", self.polytropic_exponent, "(no unit)")


def solve(point: WorkingPoint, resolution: Resolution | None = None) -> FilmState:
    """Compute the periodic state of the film at a working point.

    Raises
    ------
    ReynoldsDiverged
        If Newton's method fails, which can happen if the squeeze number is above 10⁵.
    """
    _, eps, delta = (
        float(v) for v in gap(point.amplitude_um_peak, point.roughness_um, point.finger)
    )
    sigma = float(
        squeeze_number(
            point.frequency_hz, point.amplitude_um_peak, point.roughness_um, point.finger, point.gas
        )
    )
    return periodic_state(
        sigma,
        eps,
        delta,
        point.finger.wave_number,
        storage_exponent=1 / point.polytropic_exponent,
        resolution=resolution,
    )


# A uniform disturbance of the film's mass decays as a sum of odd diffusion modes, with a share of
# 8/π² in the slowest. After this fraction of the slowest mode's time constant, the disturbance has
# decayed by 63 %.
_TO_63_PERCENT = 1 + float(np.log(8 / np.pi**2))


def time_constant_s(point: WorkingPoint, resolution: Resolution | None = None) -> float:
    """Return the time in which the overpressure completes 63 % of its response to a small step.

    This time constant limits how fast friction can follow a change in amplitude. It is computed
    from equation (3), linearised about the periodic state (`FilmState.decay_rate`). For small
    amplitudes, the film responds much more slowly, because gas leaves a narrow gap slowly.

    Raises
    ------
    ReynoldsDiverged
        See `solve`.
    """
    rate_per_s = solve(point, resolution).decay_rate * 2 * np.pi * point.frequency_hz
    return _TO_63_PERCENT / rate_per_s


def relative_friction(
    point: WorkingPoint,
    normal_force_n: float = NORMAL_FORCE_N,
    resolution: Resolution | None = None,
) -> Friction:
    """Compute equation (15) with the overpressure from the full Reynolds equation."""
    state = solve(point, resolution)
    return friction_from(
        np.asarray(state.overpressure),
        np.asarray(state.squeeze_number),
        normal_force_n,
        point.finger,
        point.gas,
    )


def sweep(
    points: Iterable[WorkingPoint],
    resolution: Resolution | None = None,
    *,
    workers: int = 2,
    show_progress: bool = False,
) -> list[FilmState]:
    """Solve many operating points in parallel, and return their states in the same order."""
    cases = list(points)
    if workers == 1:
        return list(_shown((solve(case, resolution) for case in cases), len(cases), show_progress))
    # Processes are spawned, because a fork of a process with BLAS threads may hang.
    with ProcessPoolExecutor(max_workers=workers, mp_context=get_context("spawn")) as pool:
        done = pool.map(solve, cases, [resolution] * len(cases))
        return list(_shown(done, len(cases), show_progress))


def _shown(
    states: Iterable[FilmState],
    total: int,
    show_progress: bool,
) -> Iterator[FilmState]:
    if not show_progress:
        yield from states
        return
    from rich.progress import track

    yield from track(states, description="Reynolds equation", total=total)
