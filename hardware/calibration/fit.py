"""Estimate resonance, Q and gain, with their uncertainties, from vibrometer readings."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, stats

from slipscale.faults import UserError
from slipscale.hardware.calibration.record import Gain, Point, Resonance

FEWEST_POINTS = 6
CONFIDENCE = 0.95
EXPLAINED_MIN = 0.5  # smallest explained share of the variance; noise alone gives about 0.1
NO_RESONANCE = (
    "frequency sweep: no resonance; the plate responds equally at all frequencies. Check that "
    "the vibrometer measures the plate, and sweep around its resonance"
)
WEIGHTING_ROUNDS = 5
LARGEST_WEIGHT_RATIO = 1e4


@dataclass(frozen=True, slots=True)
class Peak:
    """Fitted resonance, with its height in µm p-p per volt."""

    resonance: Resonance
    height_um_pp_per_v: float


def response(
    frequency_hz: NDArray[np.float64], resonance_hz: float, quality_factor: float, height: float
) -> NDArray[np.float64]:
    """Return the magnitude of the frequency response, modelled as in the simulated plate."""
    detuning = (frequency_hz - resonance_hz) / resonance_hz
    return height / np.sqrt(1 + (2 * quality_factor * detuning) ** 2)


def fit_resonance(points: Sequence[Point]) -> Peak:
    """Fit a resonance to a frequency sweep by weighted least squares.

    Raises
    ------
    UserError
        If there are too few points, if a point has a voltage of 0, or if the sweep contains no
        resonance or no peak.
    """
    if len(points) < FEWEST_POINTS:
        raise UserError(
            "frequency sweep: {count} points, expected {fewest_points} or more",
            count=len(points),
            fewest_points=FEWEST_POINTS,
        )
    frequency_hz = np.array([each.frequency_hz for each in points])
    voltage_v = np.array([each.voltage_v for each in points])
    if np.any(voltage_v == 0):
        raise UserError("frequency sweep: at least one point was measured at 0 V")
    per_volt = np.array([each.amplitude_um_pp for each in points]) / voltage_v
    if np.ptp(per_volt) == 0:
        raise UserError(NO_RESONANCE)
    top = int(np.argmax(per_volt))
    # The initial estimate of Q is based on the half-power bandwidth.
    band = frequency_hz[per_volt > per_volt[top] / np.sqrt(2)]
    width_hz = max(float(np.ptp(band)), float(np.ptp(frequency_hz)) / len(points))
    guess = (frequency_hz[top], frequency_hz[top] / width_hz, per_volt[top])
    try:
        best, covariance = _fitted(frequency_hz, per_volt, guess)
    except RuntimeError:
        raise UserError("frequency sweep: no resonance could be fitted to the readings") from None
    resonance_hz, quality_factor, height = best[0], abs(best[1]), best[2]
    inside = frequency_hz.min() < resonance_hz < frequency_hz.max()
    if not (inside and height > 0 and np.all(np.isfinite(covariance))):
        raise UserError(
            "frequency sweep: no peak between {lowest_hz:g} and {highest_hz:g} Hz; sweep around"
            " the resonance",
            lowest_hz=frequency_hz.min(),
            highest_hz=frequency_hz.max(),
        )
    explained = 1 - np.var(per_volt - response(frequency_hz, *best)) / np.var(per_volt)
    if explained < EXPLAINED_MIN:
        raise UserError(NO_RESONANCE)
    half_width = _quantile(len(points) - 3) * np.sqrt(np.diag(covariance))
    residual_um = (per_volt - response(frequency_hz, *best)) * voltage_v
    return Peak(
        Resonance(
            frequency_hz=float(resonance_hz),
            frequency_ci95_hz=float(half_width[0]),
            quality_factor=float(quality_factor),
            quality_factor_ci95=float(half_width[1]),
            residual_um=_rms(residual_um, len(points) - 3),
        ),
        float(height),
    )


def fit_gain(points: Sequence[Point]) -> Gain:
    """Fit a line through the origin to a voltage sweep at resonance.

    Raises
    ------
    UserError
        If there are too few points, or if the plate does not respond.
    """
    if len(points) < FEWEST_POINTS:
        raise UserError(
            "voltage sweep: {count} points, expected {fewest_points} or more",
            count=len(points),
            fewest_points=FEWEST_POINTS,
        )
    voltage_v = np.array([each.voltage_v for each in points])
    amplitude_um = np.array([each.amplitude_um_pp for each in points])
    if not voltage_v @ amplitude_um > 0:
        raise UserError("voltage sweep: the plate does not respond to the voltage")
    weights = np.ones_like(voltage_v)
    for _ in range(WEIGHTING_ROUNDS):
        square = float((weights * voltage_v) @ voltage_v)
        slope = float((weights * voltage_v) @ amplitude_um) / square
        left_um = amplitude_um - slope * voltage_v
        deviation = float(np.sqrt((weights * left_um) @ left_um / (len(points) - 1)))
        half_width = float(_quantile(len(points) - 1) * deviation / np.sqrt(square))
        weights = _weights(slope * voltage_v, left_um, weights)
    highest_v = float(voltage_v.max())
    return Gain(
        um_pp_per_v=slope,
        um_pp_per_v_ci95=half_width,
        residual_um=_rms(left_um, len(points) - 1),
        voltage_max_v=highest_v,
        # A plate that saturates does not reach the amplitude on the fitted line.
        amplitude_max_um_pp=min(slope * highest_v, float(amplitude_um.max())),
    )


def _fitted(
    frequency_hz: NDArray[np.float64],
    per_volt: NDArray[np.float64],
    guess: tuple[float, float, float],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the best-fit parameters of a resonance, and their covariance. Raises RuntimeError."""
    weights = np.ones_like(frequency_hz)
    best = np.array(guess)
    with warnings.catch_warnings():
        # If the covariance cannot be estimated, `curve_fit` returns infinity; the caller checks it.
        warnings.simplefilter("ignore", optimize.OptimizeWarning)
        for _ in range(WEIGHTING_ROUNDS):
            best, covariance = optimize.curve_fit(
                response, frequency_hz, per_volt, p0=best, sigma=1 / np.sqrt(weights)
            )
            fitted = response(frequency_hz, *best)
            weights = _weights(fitted, per_volt - fitted, weights)
    return best, covariance


def _weights(
    fitted: NDArray[np.float64], left: NDArray[np.float64], before: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Estimate the weights of readings from the residuals of a fit.

    The noise of a vibrometer has a constant part and a part that is proportional to the reading:
    variance = a + b·reading², fitted to the squared residuals with non-negative a and b. If noise
    of 2 % of the reading were treated as constant, the coverage of a 95 % interval for the gain
    would be only 86 %.

    Parameters
    ----------
    fitted, left : ndarray
        Fitted values, and residuals (reading minus fitted value).
    before : ndarray
        Weights used in the fit; the squared residuals get the same weights.

    Returns
    -------
    ndarray
        Reciprocal variances, scaled so that the largest is 1.
    """
    terms = np.column_stack([np.ones_like(fitted), fitted**2]) * before[:, None]
    (constant, proportional), _ = optimize.nnls(terms, left**2 * before)
    variance = constant + proportional * fitted**2
    if variance.max() == 0:
        return before
    weights = 1 / np.maximum(variance, variance.max() / LARGEST_WEIGHT_RATIO)
    return np.asarray(weights / weights.max())


def _quantile(freedom: int) -> float:
    return float(stats.t.ppf((1 + CONFIDENCE) / 2, freedom))


def _rms(residuals: NDArray[np.float64], freedom: int) -> float:
    return float(np.sqrt(residuals @ residuals / freedom))
