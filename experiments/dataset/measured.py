"""Define and compute the optional columns for quantities measured during a trial.

A run's table has a column for each quantity that was measured at least once. Positions and forces
are computed from the samples in the journal (docs/decisions/one-journal.md).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

from slipscale.experiments.journal.record import Record
from slipscale.experiments.steps.columns import Column, TrialRecord
from slipscale.experiments.steps.trial import Value
from slipscale.experiments.study.stroke import OUTSIDE, WITHIN
from slipscale.hardware.contact.measures import friction, movement
from slipscale.hardware.contact.plausibility import implausible_forces, implausible_places
from slipscale.hardware.contact.source import Sample

CHANGES = "changes"
SPEED, STROKES = "exploration_speed_mm_s", "strokes"
STROKE = "stroke"
SLIP_RATE, SLIP_DEPTH = "slip_rate_hz", "slip_depth_share"
COEFFICIENT, NORMAL_FORCE = "friction_coefficient", "normal_force_n"
OF_INTERVAL = re.compile(r"interval([0-9]+)_")
#: The name does not end in ``_level``, because the value is in the second actuator's quantity.
SECOND_READBACK = "second_readback"
# Name of each column's quantity in the reply to a presentation.
OF_THE_PLATE = {
    "drive_voltage_v_peak": "drive_voltage_v_peak",
    "plate_temperature_c": "temperature_c",
    SECOND_READBACK: SECOND_READBACK,
}


def _value(name: str) -> Callable[[TrialRecord], Value]:
    return lambda record: record.measured.get(name)


MEASURED: Mapping[str, Column] = {
    SPEED: Column(
        value=_value(SPEED),
        description="Mean speed of the finger during the exploration: path length divided by "
        "contact time",
        units="mm/s",
    ),
    STROKES: Column(
        value=_value(STROKES),
        description="Number of strokes of 5 mm or more in one direction during the exploration",
    ),
    COEFFICIENT: Column(
        value=_value(COEFFICIENT),
        description="Coefficient of friction while the finger slid during the exploration: median "
        "of lateral force magnitude divided by normal force",
    ),
    NORMAL_FORCE: Column(
        value=_value(NORMAL_FORCE),
        description="Mean normal force while the finger slid during the exploration",
        units="N",
    ),
    SLIP_RATE: Column(
        value=_value(SLIP_RATE),
        description="Number of slips per second while the finger slid: drops in the ratio of "
        "lateral to normal force by more than 10 %, while the normal force is at least half its "
        "mean. Slips faster than half the sensor's sampling rate are not detected",
        units="Hz",
    ),
    SLIP_DEPTH: Column(
        value=_value(SLIP_DEPTH),
        description="Median drop in the ratio of lateral to normal force in a slip, as a fraction "
        "of the ratio before the slip; n/a without a slip",
    ),
    CHANGES: Column(
        value=_value(CHANGES),
        description="Number of times that the finger triggered a transient (a change in amplitude) "
        "during the exploration",
    ),
    STROKE: Column(
        value=_value(STROKE),
        kind="label",
        description="Whether the exploration met the study's requirements for strokes, or how "
        f"it deviated: {WITHIN}, or one or more of {', '.join(OUTSIDE)}",
    ),
    "drive_voltage_v_peak": Column(
        value=_value("drive_voltage_v_peak"),
        description="Peak drive voltage at the plate after settling (a texture settles at its mean "
        "amplitude)",
        units="V",
    ),
    "plate_temperature_c": Column(
        value=_value("plate_temperature_c"),
        description="Temperature of the plate, or of its board, once the plate had settled",
        units="Cel",
    ),
    SECOND_READBACK: Column(
        value=_value(SECOND_READBACK),
        description="{q.in_full_title} read back from the second actuator once the plate had "
        "settled{q.behind}",
        units="{q.bids}",
    ),
}

UNREADABLE = 0.1  # largest accepted fraction of unreadable readings in an exploration


def measured_columns(names: Iterable[str]) -> dict[str, Column]:
    """Return the columns for measured quantities, in the order of the table.

    If a quantity was measured in an interval, its column name starts with the interval, as in
    ``interval1_strokes``.
    """
    wanted = set(names)
    found = {name: column for name, column in MEASURED.items() if name in wanted}
    intervals = {match[1] for name in wanted if (match := OF_INTERVAL.match(name))}
    for number in sorted(intervals, key=int):
        for plain, column in MEASURED.items():
            name = f"interval{number}_{plain}"
            if name in wanted:
                description = f"{column.description} (interval {number})"
                found[name] = replace(column, value=_value(name), description=description)
    return found


def of_interval(values: Mapping[str, Value], interval: int | None) -> Mapping[str, Value]:
    """Prefix the names of values with the interval, if any, as in ``interval1_strokes``."""
    return {f"interval{interval}_{name}": v for name, v in values.items()} if interval else values


def plate_measures(presented: Mapping[str, Any]) -> dict[str, Value]:
    """Return the quantities other than amplitude that were measured during a presentation."""
    measures = {column: presented.get(name) for column, name in OF_THE_PLATE.items()}
    return {column: value for column, value in measures.items() if value is not None}


def samples(record: Record) -> list[Sample]:
    """Return the samples of a "contact" record."""
    data = record.data
    rows = zip(data["times_s"], *data["values"].values(), strict=True)
    return [Sample(data["begun_s"] + time_s, tuple(values)) for time_s, *values in rows]


class Explorations:
    """Collects the samples of each exploration from the records of a journal, passed in order."""

    def __init__(self) -> None:
        self._parts: dict[str, list[Sample]] = {}
        self._whole: dict[str, list[Sample]] = {}
        self._unreadable = 0
        self._changes: int | None = None
        self.outcome = ""  # deviations of the last stroke, if the study sets limits for strokes

    def see(self, record: Record) -> None:
        """Process the next record of the journal."""
        if record.kind == "begin":  # samples of an unfinished exploration belong to no trial
            self._parts, self._whole, self._unreadable = {}, {}, 0
            self._changes, self.outcome = None, ""
        elif record.kind == "contact" and record.data["during"] == "exploration":
            self._take(record)

    def _take(self, record: Record) -> None:
        data, source = record.data, str(record.data["source"])
        gathered = self._parts.setdefault(source, [])
        gathered += samples(record)
        self._unreadable += data.get("unreadable", 0)
        if (changes_s := data.get("changes_s")) is not None:
            self._changes = (self._changes or 0) + len(changes_s)
        if data["ends"]:
            del self._parts[source]
        if data["ends"] == "whole":
            self._whole[source] = gathered

    @property
    def unchanged(self) -> bool:
        """Whether the finger failed to trigger a transient in the last exploration."""
        return self._changes == 0

    def implausible(self) -> list[str]:
        """Describe values measured in the last exploration that are implausible for a finger."""
        places, forces = self._whole.get("position", []), self._whole.get("force", [])
        found = [*implausible_places(places), *implausible_forces(forces)]
        if self._unreadable > UNREADABLE * (self._unreadable + len(places) + len(forces)):
            found.append(f"{self._unreadable} unreadable readings")
        return found

    def measures(self) -> dict[str, Value]:
        """Return the measures computed from the last exploration; empty if nothing was measured."""
        found: dict[str, Value] = {STROKE: self.outcome} if self.outcome else {}
        places = self._whole.get("position", [])
        if "position" in self._whole:
            moved = movement(places)
            found |= {SPEED: _rounded(moved.speed_mm_s), STROKES: float(moved.strokes)}
        if "force" in self._whole:
            slid = friction(self._whole["force"], places)
            found |= {
                COEFFICIENT: _rounded(slid.coefficient),
                NORMAL_FORCE: _rounded(slid.normal_n),
                SLIP_RATE: _rounded(slid.slip_rate_hz),
                SLIP_DEPTH: _rounded(slid.slip_depth_share),
            }
        if self._changes is not None:
            found[CHANGES] = float(self._changes)
        return found


def _rounded(value: float | None) -> float | None:
    """Round a value to four decimals, because sensors are not more precise."""
    return None if value is None else round(value, 4)
