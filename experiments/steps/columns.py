"""Columns of a trial table, and the record of a trial from which their values are computed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from slipscale.experiments.steps.trial import Trial, Value
from slipscale.stimuli.surface import Stimulus

Kind = Literal["number", "label", "text"]


@dataclass(slots=True, kw_only=True)
class IntervalRecord:
    """An interval of a trial, as recorded in the journal."""

    surface: Stimulus
    readback_level: float | None = None
    onset_s: float = 0.0
    exploration_time_s: float | None = None


@dataclass(slots=True, kw_only=True)
class TrialRecord:
    """A trial as recorded in the journal; it becomes one row of the data set.

    In a trial without intervals, ``surface``, ``readback_level``, ``onset_s`` and
    ``exploration_time_s`` describe the trial's surface. In a trial with intervals, ``intervals``
    contains the values of each interval, keyed by number.
    """

    trial: Trial
    surface: Stimulus | None = None
    before: Stimulus | None = None
    readback_level: float | None = None
    onset_s: float = 0.0
    end_s: float = 0.0
    exploration_time_s: float | None = None
    answers: dict[str, Mapping[str, Any]] = field(default_factory=dict)
    run_answers: Mapping[str, Value] = field(default_factory=dict)
    flags: list[str] = field(default_factory=list)
    intervals: dict[int, IntervalRecord] = field(default_factory=dict)
    measured: Mapping[str, Value] = field(default_factory=dict)

    def answer(self, name: str) -> Value:
        """Return the answer to a question, or None if the question was not answered."""
        value: Value = self.answers.get(name, {}).get("value")
        return value


def truth(value: Value) -> str | None:
    """Return "true" or "false" for a table cell, or None for a missing value."""
    return None if value is None else "true" if value else "false"


def _of_its_name(record: TrialRecord, name: str = "") -> Value:
    """Return the trial factor called ``name`` or, if there is no such factor, the answer."""
    factors = record.trial.factors
    value = factors[name] if name in factors else record.answer(name)
    return truth(value) if isinstance(value, bool) else value


@dataclass(frozen=True, slots=True)
class Given:
    """A function with its last arguments; unlike a `partial`, it equals its unpickled copy."""

    function: Callable[..., Any]
    arguments: tuple[object, ...]

    def __call__(self, *first: object) -> Any:
        """Call the function."""
        return self.function(*first, *self.arguments)


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A column of the data set: its value for each trial, and its sidecar description.

    Parameters
    ----------
    value : callable
        Returns the column's value for a trial; None is written as missing. By default, a column
        contains the trial factor with the column's name or, if there is no such factor, the answer
        to the question with the column's name. Logical values are written as true or false.
    kind : {"number", "label", "text"}
        Cell type: a number, a label (such as a category or a name), or free text.
    description : str
        A description for readers of the data set.
    units : str
        The unit in BIDS notation; empty for a dimensionless number.
    levels : Mapping
        All possible labels with their meanings; empty if the labels are not known in advance.
    as_stated : bool
        Whether the column's name is independent of the study's quantity.
    """

    value: Callable[[TrialRecord], Value] = _of_its_name
    kind: Kind = "number"
    description: str
    units: str = ""
    levels: Mapping[str, str] = field(default_factory=dict)
    as_stated: bool = False


def read_by_name(columns: Mapping[str, Column]) -> dict[str, Column]:
    """Fill columns without ``value`` with the trial factor or answer of the same name."""
    return {
        name: replace(column, value=Given(_of_its_name, (name,)))
        if column.value is _of_its_name
        else column
        for name, column in columns.items()
    }
