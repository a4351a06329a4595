"""The simulated population: who the pilot's participants are, with a source for each number.

A participant *i* feels a surface of amplitude *A* as a sensation between 0 (not slippery) and
100 (the most slippery surface imaginable). Across the population the sensation at *A* follows a
beta distribution on 0-100; a participant's place in it comes from a Gaussian copula: one part
shared by all amplitudes (some people find everything slippery), one part for each amplitude, one
for each trial.

====================== ======================= ==============================================
what                   value                   source
====================== ======================= ==============================================
mean sensation         12.75, 19.58, 56.25,    Biet 2007, Table III: mean, at 0, 0.5, 1.2 and
                       81.33                   2.3 µm p-p
spread of sensation    12.75, 8.11, 8.82,      Biet 2007, Table III: standard deviation (read
                       10.76                   as the sample's)
between amplitudes     monotone cubic          our assumption: Table III has four amplitudes
shared part            0.3 of the variance     our assumption: the published table leaves the
                                               pairing open
trial-to-trial part    0.15 of the variance    our assumption
scale top              10, 20, 50, 100, 1000   our assumption: free-modulus scales are round
                                               numbers over decades
least step             1 in 100 of the top     our assumption
noticing a difference  d' = change of mean     our assumption, so that each step of the paper's
                       sensation / 2.2,        descent is felt by nearly all ("all of the
                       criterion 1.6           subjects feel clearly the difference")
exploration            log-normal, 3 s, 0.3    our assumption (median, sigma of the logarithm)
time to answer         log-normal, 2 s, 0.4    our assumption
textures               the mean amplitude      our assumption
                       over a stroke
words                  "less slippery", ...    Biet 2007, Section IV-B: "less slippery"
====================== ======================= ==============================================
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache
from statistics import NormalDist
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

# Biet 2007, Table III (page 2688 of the journal's volume 54).
AMPLITUDE_UM_PP = (0.0, 0.5, 1.2, 2.3)
MEAN_SENSATION = (12.75, 19.58, 56.25, 81.33)
SD_SENSATION = (12.75, 8.11, 8.82, 10.76)
# Sensations kept for the next who feels the same: a power analysis draws millions.
MOST_KEPT = 2**15


@dataclass(frozen=True, slots=True, kw_only=True)
class Population:
    """The assumptions, to be varied.

    Parameters
    ----------
    shared, trial_to_trial : float
        Parts of the variance; the rest is each amplitude's own. Together at most 1.
    scale_tops : tuple of float
        Each participant has one of them.
    criterion, noise : float
        A change of sensation by ``x`` is noticed with d' = x / noise against the criterion.
    exploration_s, exploration_sigma, answer_s, answer_sigma : float
        Medians in seconds, and standard deviations of the natural logarithm.
    """

    shared: float = 0.3
    trial_to_trial: float = 0.15
    scale_tops: tuple[float, ...] = (10.0, 20.0, 50.0, 100.0, 1000.0)
    criterion: float = 1.6
    noise: float = 2.2
    exploration_s: float = 3.0
    exploration_sigma: float = 0.3
    answer_s: float = 2.0
    answer_sigma: float = 0.4

    def __post_init__(self) -> None:
        if not (0 <= self.shared <= 1 and 0 <= self.trial_to_trial <= 1 - self.shared):
            raise ValueError("shared and trial_to_trial are parts of one variance")

    @property
    def own(self) -> float:
        """The part of the variance that is each amplitude's own."""
        return 1 - self.shared - self.trial_to_trial


@cache
def _curves() -> tuple[Callable[[float], float], Callable[[float], float]]:
    """Return mean and standard deviation of sensation as monotone curves of amplitude."""
    from scipy.interpolate import PchipInterpolator  # noqa: PLC0415 - half a second, pilots only

    return (
        PchipInterpolator(AMPLITUDE_UM_PP, MEAN_SENSATION, extrapolate=False),
        PchipInterpolator(AMPLITUDE_UM_PP, SD_SENSATION, extrapolate=False),
    )


@lru_cache(MOST_KEPT)
def mean_sensation(amplitude_um_pp: float) -> float:
    """Return the population's mean sensation (0-100) at an amplitude; the ends are held."""
    return float(_curves()[0](_within(amplitude_um_pp)))


@lru_cache(MOST_KEPT)
def sensation(amplitude_um_pp: float, deviate: float) -> float:
    """Return the sensation (0-100) of somebody at a place in the population.

    Parameters
    ----------
    amplitude_um_pp : float
        What the finger feels.
    deviate : float
        The place, as a standard normal deviate.

    Notes
    -----
    The beta distribution has the mean and standard deviation of the curves at that amplitude.
    """
    from scipy.stats import beta  # noqa: PLC0415 - half a second, pilots only

    felt = _within(amplitude_um_pp)
    mean = float(_curves()[0](felt)) / 100
    sd = float(_curves()[1](felt)) / 100
    concentration = mean * (1 - mean) / sd**2 - 1
    place = NormalDist().cdf(deviate)
    return 100 * float(beta.ppf(place, mean * concentration, (1 - mean) * concentration))


def _within(amplitude_um_pp: float) -> float:
    """Hold an amplitude (a reading of a vibrating plate, with its noise) inside the table."""
    return min(max(amplitude_um_pp, AMPLITUDE_UM_PP[0]), AMPLITUDE_UM_PP[-1])
