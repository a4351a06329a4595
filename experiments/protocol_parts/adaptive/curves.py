"""Psychometric functions: the proportion of correct (or "yes") answers at a level.

All functions have the form ``guess + (1 - guess - lapse) G(slope (u(x) - u(threshold)))``, where
``u`` is the level or its natural logarithm and ``G`` is a cumulative distribution function
(Wichmann and Hill 2001, Perception & Psychophysics 63, 1293-1313, equation 1). Slopes are per µm,
or dimensionless for the logarithmic functions. At the threshold, ``G`` is 1 - 1/e for the Weibull
and Gumbel functions and one half for the other functions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def _normal(z: Array) -> Array:
    from scipy.special import ndtr

    return np.asarray(ndtr(z))


def _normal_inverse(share: Array) -> Array:
    from scipy.special import ndtri

    return np.asarray(ndtri(share))


def _logistic(z: Array) -> Array:
    # exp(z) overflows for large z, and exp(-z) for very negative z; exp(-abs(z)) never does.
    small = np.exp(-np.abs(z))
    return np.where(z >= 0, 1.0, small) / (1.0 + small)


def _logistic_density(z: Array) -> Array:
    small = np.exp(-np.abs(z))
    return np.asarray(small / (1.0 + small) ** 2)


#: 1 - exp(-exp(HIGHEST)) is 1 in floating point, and exp(HIGHEST - exp(HIGHEST)) is 1e-286. Beyond
#: it, the results of exp underflow, which takes ten times as long.
HIGHEST = 6.5


def _gumbel(z: Array) -> Array:
    return np.asarray(-np.expm1(-np.exp(np.minimum(z, HIGHEST))))


def _gumbel_density(z: Array) -> Array:
    bounded = np.minimum(z, HIGHEST)
    bounded -= np.exp(bounded)
    return np.asarray(np.exp(bounded))


def _normal_density(z: Array) -> Array:
    return np.asarray(np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi))


def _gumbel_inverse(share: Array) -> Array:
    return np.asarray(np.log(-np.log1p(-share)))


def _logistic_inverse(share: Array) -> Array:
    return np.asarray(np.log(share) - np.log1p(-share))


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """A family of psychometric functions.

    Parameters
    ----------
    title : str
        Display name.
    logarithmic : bool
        Whether the proportion depends on the logarithm of the level; the proportion at 0 µm is then
        the guess rate.
    distribution, inverse, density : callable
        ``G``, its inverse and its derivative, for arrays of any shape.
    """

    title: str
    logarithmic: bool
    distribution: Callable[[Array], Array]
    inverse: Callable[[Array], Array]
    density: Callable[[Array], Array]

    def coordinate(self, level: npt.ArrayLike) -> Array:
        """Convert levels in µm peak to peak to coordinates ``u`` (-inf for 0 if logarithmic)."""
        level = np.asarray(level, float)
        if not self.logarithmic:
            return level
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(level))

    def level(self, coordinate: npt.ArrayLike) -> Array:
        """Convert coordinates ``u`` to levels in µm peak to peak (inverse of `coordinate`)."""
        u = np.asarray(coordinate, float)
        return np.asarray(np.exp(u)) if self.logarithmic else u

    def proportion(
        self,
        level: npt.ArrayLike,
        *,
        threshold_level: npt.ArrayLike,
        slope: npt.ArrayLike,
        guess: npt.ArrayLike = 0.0,
        lapse: npt.ArrayLike = 0.0,
    ) -> Array:
        """Return the proportion of correct answers. Parameters are broadcast against each other.

        Parameters
        ----------
        level, threshold_level : array_like
            Levels in µm peak to peak.
        slope : array_like
            Slope above 0, per µm, or dimensionless for a logarithmic curve.
        guess, lapse : array_like
            Lower asymptote, and 1 minus the upper asymptote.
        """
        guess, lapse = np.asarray(guess, float), np.asarray(lapse, float)
        z = np.asarray(slope) * (self.coordinate(level) - self.coordinate(threshold_level))
        return np.asarray(guess + (1 - guess - lapse) * self.distribution(z))


_FAMILIES = {
    "gumbel": (_gumbel, _gumbel_inverse, _gumbel_density),
    "logistic": (_logistic, _logistic_inverse, _logistic_density),
    "normal": (_normal, _normal_inverse, _normal_density),
}


def _curve(title: str, family: str, *, logarithmic: bool) -> Curve:
    distribution, inverse, density = _FAMILIES[family]
    return Curve(
        title=title,
        logarithmic=logarithmic,
        distribution=distribution,
        inverse=inverse,
        density=density,
    )


CURVES: dict[str, Curve] = {
    "weibull": _curve("Weibull function", "gumbel", logarithmic=True),
    "log_logistic": _curve("logistic function of the logarithm", "logistic", logarithmic=True),
    "log_normal": _curve("normal function of the logarithm", "normal", logarithmic=True),
    "gumbel": _curve("Gumbel function", "gumbel", logarithmic=False),
    "logistic": _curve("logistic function", "logistic", logarithmic=False),
    "normal": _curve("cumulative normal function", "normal", logarithmic=False),
}
_PAIRS = (("weibull", "gumbel"), ("log_logistic", "logistic"), ("log_normal", "normal"))
#: Each curve's counterpart on the other axis: linear instead of logarithmic, or vice versa.
OTHER_AXIS = dict(_PAIRS) | {level: logarithm for logarithm, level in _PAIRS}
