"""Write the times of a run's trials as BIDS events (``_events.tsv`` with HED tags).

BIDS stores onsets and durations in tables of events. Use the column ``trial`` to find the answers
in the run's table ``_beh.tsv``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import PurePosixPath

from slipscale.experiments.dataset.schema import EVENTS, MAIN, PRACTICE
from slipscale.experiments.dataset.tsv import cell, sidecar, table
from slipscale.experiments.steps.columns import Column, TrialRecord

HED_VERSION = "8.3.0"
#: Tags of each trial type, in the vocabulary of Hierarchical Event Descriptors.
HED = {
    PRACTICE: "Sensory-event, Tactile-presentation, Experimental-trial, Label/Practice",
    MAIN: "Sensory-event, Tactile-presentation, Experimental-trial",
}


def events_of(path: PurePosixPath) -> PurePosixPath:
    """Return the path of the events that belong to a run's table."""
    return path.with_name(f"{path.stem.removesuffix('_beh')}_events.tsv")


def events(described: Mapping[str, Column], trials: Iterable[TrialRecord]) -> str:
    """Return a run's events: one row per trial in which a surface was presented.

    ``described`` contains the columns of the run's table.
    """
    own = events_columns(described)
    rows = [
        [cell(column.value(trial), column.units) for column in own.values()]
        for trial in trials
        if trial.onset_s is not None
    ]
    return table(list(own), rows)


def events_columns(described: Mapping[str, Column]) -> dict[str, Column]:
    """Return the columns of events: times, and the number and surfaces of each trial."""
    shared = ("trial", *(name for name in described if name.endswith("surface")))
    return {**EVENTS, **{name: described[name] for name in shared}}


def events_sidecar(described: Mapping[str, Column]) -> dict[str, object]:
    """Return the descriptions of the columns of events, with the tags of each trial type."""
    found = sidecar(events_columns(described))
    return {**found, "trial_type": {**found["trial_type"], "HED": HED}}
