"""The simulated population is the paper's: its constants stand below the analysis."""

from slipscale.analysis.published.biet2007 import TABLE3
from slipscale.experiments.participants.simulated_people.population import (
    AMPLITUDE_UM_PP,
    MEAN_SENSATION,
    SD_SENSATION,
)


def test_the_simulated_population_has_the_published_means_and_spreads():
    assert tuple(float(row.amplitude_um_pp) for row in TABLE3) == AMPLITUDE_UM_PP
    assert tuple(float(row.mean) for row in TABLE3) == MEAN_SENSATION
    assert tuple(float(row.standard_deviation) for row in TABLE3) == SD_SENSATION
