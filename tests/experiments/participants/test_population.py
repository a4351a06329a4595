"""The simulated population: what is kept of it does not grow with what was felt."""

from experiments.participants import population


def test_what_is_kept_for_the_next_has_an_end():
    """A power analysis draws millions of sensations, all of them different."""
    for each in (population.sensation, population.mean_sensation):
        assert each.cache_info().maxsize == population.MOST_KEPT
