"""Strength of a simulated person's sensations, and use of the rating line."""

from __future__ import annotations

import math
from collections.abc import Callable

from slipscale.experiments.participants.simulated_people.population import Population, curves

LEAST_SHARE = 0.001  # ratings never reach the ends of a line


class Sensation:
    """Sensation curve, noise and use of the rating line for one person.

    Parameters
    ----------
    people : Population
    own : callable
        Returns the person's standard normal deviate for a named parameter.
    misread : bool
        Whether the person rates stickiness instead of slipperiness.
    """

    def __init__(self, people: Population, own: Callable[[str], float], *, misread: bool) -> None:
        self._curves = curves(people)
        self._intercept = own("shared")
        self._exponent = own("exponent")
        # Subtracting the squared sigma makes the variance of the noise, averaged over people, equal
        # to the population's value.
        self.noise = math.sqrt(people.trial_to_trial) * math.exp(
            people.noise_sigma * own("noise") - people.noise_sigma**2
        )
        self._misread = misread
        self._shift = people.line_shift_sd * own("line shift")
        self._stretch = math.exp(people.line_stretch_sigma * own("line stretch"))

    def percent(self, felt_level: float, noise: float = 0.0) -> float:
        """Return the sensation (0 to 100) at an amplitude in µm peak to peak.

        ``noise`` is the trial's random deviate, with the standard deviation ``self.noise``.
        """
        intercept, exponent = self._curves.turns(felt_level)
        deviate = intercept * self._intercept + exponent * self._exponent + noise
        percent = self._curves.sensation(felt_level, deviate)
        return 100 - percent if self._misread else percent

    def place(self, percent: float) -> float:
        """Return the person's rating of a sensation on a line from 0 to 100."""
        share = min(max(percent / 100, LEAST_SHARE), 1 - LEAST_SHARE)
        logit = self._shift + self._stretch * math.log(share / (1 - share))
        return 100 / (1 + math.exp(-logit))
