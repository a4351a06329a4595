"""Simulated people who are distracted in 20 % of trials."""

from types import MappingProxyType

from slipscale.protocol import Behaviour, Explore

DISTRACTED = 0.2


class Distracted(Behaviour):
    """Simulate participants who sometimes guess, and who stroke each surface for 50 % longer."""

    population = MappingProxyType({"trial_to_trial": 0.2})  # Keys as in a population file.

    def pick(self, strengths):
        """Return the index of the chosen interval."""
        if self.stream("distracted").uniform() < DISTRACTED:
            return self.stream("distracted", "choice").below(len(strengths))
        return self.person.pick(strengths)

    def duration_s(self, step, usual_s):
        """Return how long a step takes."""
        return 1.5 * usual_s if isinstance(step, Explore) else usual_s
