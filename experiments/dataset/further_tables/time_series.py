"""Write the finger's position and forces as BIDS time series (``_physio.tsv.gz`` with JSON).

BIDS requires a constant sampling frequency, but sensors are read once per video frame. The samples
are therefore resampled according to these rules:

- each task of a run has one file per source, from its first sample to its last;
- the frequency is the source's median sampling frequency, rounded to 1 Hz;
- a row contains the last sample within half a period, otherwise n/a (no finger, or no step that
  is measured);
- the journal keeps every sample with its time.
"""

from __future__ import annotations

import gzip
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from statistics import median
from typing import NamedTuple

from slipscale.experiments.dataset.measured import samples
from slipscale.experiments.dataset.schema import MISSING
from slipscale.experiments.journal.record import Record
from slipscale.hardware.contact.source import QUANTITIES, Kind

UNITS = {"mm": "mm", "n": "N"}
DESCRIPTIONS = {
    "x_mm": "Finger position along the stroke",
    "y_mm": "Finger position across the stroke",
    "normal_n": "Normal force",
    "lateral_n": "Lateral force along the stroke",
}


class Placed(NamedTuple):
    """Sample of a sensor, with the number of the trial in which it was recorded."""

    time_s: float
    trial: int
    values: tuple[float, ...]


def series_of(
    records: Sequence[Record], task: str
) -> Iterator[tuple[Kind, bytes, Mapping[str, object]]]:
    """Yield the kind of each sensor used in a task, its compressed table and a description."""
    found: dict[Kind, list[Placed]] = {}
    now = ""
    for record in records:
        if record.kind == "begin":
            now = (record.data["what"]["trial"] or {}).get("task", "")
        elif record.kind == "contact" and now == task:
            own = found.setdefault(record.data["source"], [])
            trial = record.data["trial"]
            own += (Placed(each.time_s, trial, each.values) for each in samples(record))
    for kind, placed in found.items():
        if rate_hz := _rate_hz(placed):
            yield kind, _table(placed, rate_hz), _described(kind, placed[0].time_s, rate_hz)


def _rate_hz(placed: Sequence[Placed]) -> int:
    """Return the median sampling frequency in Hz, or 0 if there are too few samples."""
    gaps = [b.time_s - a.time_s for a, b in pairwise(placed) if b.time_s > a.time_s]
    return max(round(1 / median(gaps)), 1) if gaps else 0


def _table(placed: Sequence[Placed], rate_hz: int) -> bytes:
    """Return the compressed rows without a header, as BIDS requires."""
    begun_s = placed[0].time_s
    width = len(placed[0].values) + 1
    rows = [[MISSING] * width] * (round((placed[-1].time_s - begun_s) * rate_hz) + 1)
    for each in placed:
        place = round((each.time_s - begun_s) * rate_hz)
        rows[place] = [*(f"{value:g}" for value in each.values), str(each.trial)]
    text = "".join("\t".join(row) + "\n" for row in rows)
    return gzip.compress(text.encode(), mtime=0)


def _described(kind: Kind, begun_s: float, rate_hz: int) -> Mapping[str, object]:
    names = QUANTITIES[kind]
    return {
        "SamplingFrequency": rate_hz,
        "StartTime": round(begun_s, 6),
        "Columns": [*names, "trial"],
        **{
            name: {"Description": DESCRIPTIONS[name], "Units": UNITS[name.rpartition("_")[2]]}
            for name in names
        },
        "trial": {"Description": "Trial number, as in the table of the task"},
    }
