"""The seam between what a session writes and what the analysis reads."""

from dataclasses import replace

import pytest

from slipscale.analysis.reading.cleaning import empty_differences, empty_estimates
from slipscale.analysis.reading.trial_tables import (
    DIFFERENCE,
    ESTIMATION,
    FREE_TEXT,
    IDENTITY,
    trial_table,
)
from slipscale.experiments.dataset.measured import MEASURED
from slipscale.experiments.dataset.schema import columns
from slipscale.experiments.protocols import descending_difference, magnitude_estimation
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

TASKS = [
    (ESTIMATION, magnitude_estimation.PROTOCOL, empty_estimates),
    (DIFFERENCE, descending_difference.PROTOCOL, empty_differences),
]


@pytest.mark.parametrize("table, protocol, empty", TASKS)
def test_all_that_the_analysis_reads_is_declared_and_so_is_all_it_hands_on(table, protocol, empty):
    declared = {*IDENTITY, *columns(protocol, MEASURED)}
    assert table.task == protocol.task
    assert set(map(PLATE_AMPLITUDE.named, table.columns)) <= declared
    assert set(empty().columns) == {*table.columns, "file", "line"}


@pytest.mark.parametrize("table, protocol, empty", TASKS)
def test_a_column_renamed_in_the_schema_cannot_be_read_under_its_old_name(table, protocol, empty):
    own = {*protocol.design, *protocol.stimulus, *protocol.response}
    read = [name for name in (*table.required, *table.numbers, *table.words) if name in own]
    assert len(read) > 3
    for name in set(read) - {"texture", protocol.answer}:  # these two a protocol must declare
        renamed = replace(
            protocol,
            **{
                group: {
                    f"new_{key}" if key == name else key: column
                    for key, column in getattr(protocol, group).items()
                }
                for group in ("design", "stimulus", "response")
            },
        )
        with pytest.raises(LookupError, match=rf"reads {name} of task {table.task}.*new_{name}"):
            trial_table(renamed, required=table.required, optional=(*table.numbers, *table.words))


def test_words_are_never_read_as_numbers():
    assert "verbal_report" in FREE_TEXT
    assert set(FREE_TEXT) & {*ESTIMATION.numbers, *DIFFERENCE.numbers} == set()
