"""Table III is typed in one place; what cannot read it from there says the same."""

from __future__ import annotations

from slipscale.analysis.published.biet2007 import BY_AMPLITUDE, TABLE3, TABLE3_FILE, covers
from slipscale.analysis.reconstruction.table.table_files import read
from slipscale.experiments.participants.simulated_people import population
from slipscale.stimuli.quantity import PLATE_AMPLITUDE


def test_reconstruction_reads_the_same_numbers():
    for row, column in zip(TABLE3, read(TABLE3_FILE).columns, strict=True):
        assert (row.mean, row.standard_deviation) == (column.mean.text, column.sd.text)
        assert row.maximum_deviation == column.maximum_deviation.text
        assert float(row.amplitude_um_pp) == column.amplitude_um_pp


def test_the_simulated_population_feels_as_table_iii_says():
    """Experiments stand below the analysis and cannot read its file."""
    assert tuple(BY_AMPLITUDE) == population.AMPLITUDE_UM_PP
    assert tuple(float(row.mean) for row in TABLE3) == population.MEAN_SENSATION
    assert tuple(float(row.standard_deviation) for row in TABLE3) == population.SD_SENSATION


def test_published_values_are_shown_only_beside_the_papers_amplitudes():
    assert covers([0.0, 1.2], PLATE_AMPLITUDE)
    # 2.3 µm alone is in the paper, so its mean appeared beside those of another experiment.
    assert not covers([0.6, 1.0, 1.5, 2.3], PLATE_AMPLITUDE)
