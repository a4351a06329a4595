import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from slipscale.faults import UserError
from slipscale.stimuli.film import periodic_film, squeeze_film
from slipscale.stimuli.film.periodic_film import Resolution, ReynoldsDiverged, periodic_state
from slipscale.stimuli.film.reynolds import (
    WorkingPoint,
    relative_friction,
    solve,
    sweep,
    time_constant_s,
)
from slipscale.stimuli.film.squeeze_film import Finger
from slipscale.stimuli.modulation import FILM_TIME_CONSTANT_S

PAPER = WorkingPoint(amplitude_um_peak=1.15, roughness_um=0.6, frequency_hz=30_500)


@pytest.mark.parametrize(
    "peak, number, overpressure",
    [(0.25, 16.5, 0.00159), (0.6, 16.2, 0.00575), (1.15, 15.9, 0.01290)],
)
def test_overpressure_at_the_experiment_s_amplitudes(peak, number, overpressure):
    # Values of an independent prototype (BDF2 in time, all levels at once).
    state = solve(WorkingPoint(amplitude_um_peak=peak, roughness_um=0.6, frequency_hz=30_500))
    assert state.squeeze_number == pytest.approx(number, abs=0.05)
    assert state.overpressure == pytest.approx(overpressure, abs=5e-6)


def test_the_solution_is_nearly_flat_where_the_closed_form_peaks_at_the_ridges():
    state = solve(PAPER)
    at = state.position * 10
    assert state.mean_pressure.max() < 1.02
    assert squeeze_film.mean_pressure(at, 1.15, 0.6).max() > 1.3


def test_error_falls_with_the_square_of_the_cell_size():
    values = [
        solve(PAPER, Resolution(cells_per_ridge=cells, instants=17)).overpressure
        for cells in (12, 24, 48, 96)
    ]
    steps = np.abs(np.diff(values))
    orders = np.log2(steps[:-1] / steps[1:])
    assert np.all((orders > 1.9) & (orders < 2.6))


def test_error_falls_spectrally_with_the_instants():
    exact = solve(PAPER, Resolution(instants=33)).overpressure
    errors = [
        abs(solve(PAPER, Resolution(instants=n)).overpressure - exact) for n in (5, 9, 13, 17)
    ]
    assert all(fine < 0.3 * coarse for coarse, fine in pairwise(errors))
    assert errors[-1] < 1e-7 * exact


def test_mass_is_conserved():
    assert solve(PAPER).flow_imbalance < 1e-8


@pytest.mark.parametrize("sigma, share", [(15.9, 0.62), (200, 0.91), (1e4, 0.99)])
def test_flat_film_approaches_the_closed_form(sigma, share):
    # Shares of the asymptote that an independent prototype gave, epsilon 0.657.
    eps = 0.657
    limit = math.sqrt((1 + 1.5 * eps**2) / (1 - eps**2)) - 1
    state = periodic_state(sigma, eps, 0.0, 1.0)
    assert state.overpressure / limit == pytest.approx(share, abs=0.006)


def test_gap_to_the_closed_form_closes_as_the_root_of_the_squeeze_number():
    # The film leaks in an edge layer of width 1/sqrt(σ).
    eps = 0.3
    limit = math.sqrt((1 + 1.5 * eps**2) / (1 - eps**2)) - 1
    fine = Resolution(cells_min=640)
    gaps = [
        1 - periodic_state(sigma, eps, 0.0, 1.0, resolution=fine).overpressure / limit
        for sigma in (1e3, 4e3, 16e3)
    ]
    assert gaps[0] / gaps[1] == pytest.approx(2, rel=0.05)
    assert gaps[1] / gaps[2] == pytest.approx(2, rel=0.05)


def test_ridged_film_meets_the_closed_form_at_large_squeeze_numbers():
    finger = Finger(contact_length_mm=1.05)  # three ridges
    point = WorkingPoint(
        amplitude_um_peak=2.0, roughness_um=2.0, frequency_hz=30_500 * 40_000, finger=finger
    )
    state = solve(point)
    assert state.squeeze_number > 5_000
    closed = float(squeeze_film.mean_overpressure(2.0, 2.0, finger))
    assert state.overpressure == pytest.approx(closed, rel=0.03)


def test_incompressible_limit_leaves_no_overpressure_to_first_order():
    weak, weaker = (periodic_state(s, 0.3, 0.0, 1.0).overpressure for s in (0.02, 0.01))
    assert weak / weaker == pytest.approx(4, rel=0.02)  # grows as σ²


def test_no_vibration_leaves_the_film_still():
    still = solve(WorkingPoint(amplitude_um_peak=0.0, roughness_um=0.6, frequency_hz=30_500))
    assert still.overpressure == pytest.approx(0, abs=1e-12)


def marched_content(sigma, eps, delta, wave_number, *, cells, times, disturbed=0.0):
    """Method of lines on a uniform grid, stiff integrator: P·H at `times`, from a still film."""
    dx = 0.5 / cells
    middle = (np.arange(cells) + 0.5) * dx
    face = np.arange(1, cells + 1) * dx

    def gap(x, t):
        return 1 + eps * np.cos(t) + delta * np.cos(wave_number * x)

    def slope(t, content):
        pressure = content / gap(middle, t)
        step = np.diff(np.append(pressure**2 / 2, 0.5))
        flow = gap(face, t) ** 3 * step / dx
        flow[-1] *= 2  # half a cell to the edge
        return np.diff(flow, prepend=0.0) / (sigma * dx)

    start = gap(middle, 0.0) * (1 + disturbed)
    options = {"method": "LSODA", "lband": 1, "uband": 1, "rtol": 1e-7, "atol": 1e-9}
    done = solve_ivp(slope, (0, times[-1]), start, t_eval=times, **options)
    return done.y, np.array([gap(middle, t) for t in times]).T


def march(sigma, eps, delta, wave_number, *, cells, periods):
    """What the solver's overpressure is checked against."""
    times = 2 * np.pi * (periods - 1 + np.arange(64) / 64)
    content, gap = marched_content(sigma, eps, delta, wave_number, cells=cells, times=times)
    return np.sum((content / gap).mean(axis=1) - 1) / cells


@pytest.mark.parametrize("delta, wave_number", [(0.0, 1.0), (0.4, 4 * np.pi)])
def test_periodic_state_is_where_marching_in_time_ends(delta, wave_number):
    marched = march(8.0, 0.35, delta, wave_number, cells=80, periods=12)
    state = periodic_state(8.0, 0.35, delta, wave_number)
    assert state.overpressure == pytest.approx(marched, rel=2e-3)


@pytest.mark.parametrize("eps, delta, wave_number", [(0.0, 0.0, 1.0), (0.6, 0.3, 4 * np.pi)])
def test_a_disturbance_decays_as_marching_in_time_says(eps, delta, wave_number):
    sigma, periods = 400.0, np.arange(25)
    still, disturbed = (
        marched_content(
            sigma, eps, delta, wave_number, cells=60, times=2 * np.pi * periods, disturbed=more
        )
        for more in (0.0, 0.01)
    )
    left = np.sum((disturbed[0] - still[0]) / still[1], axis=0)
    state = periodic_state(sigma, eps, delta, wave_number)
    slowest = -np.log(left[24] / left[12]) / (2 * np.pi * 12)
    assert state.decay_rate == pytest.approx(slowest, rel=0.05)
    if not eps:
        # 63 % of it is gone after 0.79 of the slowest mode's time constant.
        gone = 2 * np.pi * np.interp(-np.exp(-1), -left / left[0], periods)
        assert (1 + np.log(8 / np.pi**2)) / state.decay_rate == pytest.approx(gone, rel=0.05)


def test_a_still_even_film_decays_as_diffusion_does():
    # σ P_T = P_XX between two open edges: the slowest mode is cos πX.
    assert periodic_state(50.0, 0.0, 0.0, 1.0).decay_rate == pytest.approx(np.pi**2 / 50, rel=1e-3)


def test_the_papers_film_takes_6_ms_and_a_narrower_one_longer():
    def at(peak_um):
        point = WorkingPoint(amplitude_um_peak=peak_um, roughness_um=0.6, frequency_hz=30_500)
        return time_constant_s(point)

    assert at(1.15) == pytest.approx(FILM_TIME_CONSTANT_S, rel=0.05)
    # Marched over 260 periods from a film with 2 % more gas, on a coarser grid: 5.86 ms.
    assert at(1.15) == pytest.approx(0.00586, rel=0.05)
    assert at(0.25) > at(0.6) > at(1.15)


def test_polytropic_exponent_stiffens_the_film():
    adiabatic = WorkingPoint(
        amplitude_um_peak=1.15, roughness_um=0.6, frequency_hz=30_500, polytropic_exponent=1.4
    )
    assert solve(adiabatic).overpressure != pytest.approx(solve(PAPER).overpressure, rel=1e-3)


def test_sweep_keeps_the_order_and_gives_what_single_solutions_give():
    points = [
        WorkingPoint(amplitude_um_peak=a, roughness_um=0.6, frequency_hz=30_500) for a in (0.9, 0.2)
    ]
    alone = [solve(point).overpressure for point in points]
    assert [s.overpressure for s in sweep(points, workers=2)] == pytest.approx(alone, rel=1e-12)
    shown = sweep(points, workers=1, show_progress=True)
    assert [s.overpressure for s in shown] == pytest.approx(alone, rel=1e-12)


def test_friction_by_reynolds_is_less_reduced_than_by_the_closed_form():
    closed = squeeze_film.relative_friction(1.15, 0.6, 30_500)
    solved = relative_friction(PAPER)
    assert float(closed.relative_friction) == pytest.approx(0.625, abs=5e-4)
    assert float(solved.relative_friction) == pytest.approx(0.742, abs=5e-4)


def test_a_case_beyond_the_solver_says_so_in_a_sentence(monkeypatch):
    monkeypatch.setattr(periodic_film, "_NEWTON_STEPS", 2)
    with pytest.raises(ReynoldsDiverged, match=r"squeeze number 15\.9.* after 2 Newton steps"):
        solve(PAPER)


@pytest.mark.parametrize(
    "change, said",
    [
        ({"roughness_um": 0.0}, "roughness_um is 0"),
        ({"amplitude_um_peak": -1.0}, "amplitude_um_peak is -1"),
        ({"frequency_hz": math.inf}, "frequency_hz is inf"),
        ({"polytropic_exponent": 0.0}, "polytropic_exponent is 0"),
    ],
)
def test_impossible_working_point_is_refused(change, said):
    good = {"amplitude_um_peak": 1.0, "roughness_um": 0.6, "frequency_hz": 3e4}
    with pytest.raises(UserError, match=said):
        WorkingPoint(**good | change)


@pytest.mark.parametrize("change", [{"instants": 8}, {"instants": 1}, {"cells_per_ridge": 0}])
def test_impossible_resolution_is_refused(change):
    with pytest.raises(UserError, match="resolution"):
        Resolution(**change)
