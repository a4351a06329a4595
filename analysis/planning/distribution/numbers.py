"""Extract the numeric results and conclusions of an analysis, with the same names in every study.

The results are read from the content of inference.json, so new results are included automatically.
Results for single participants are omitted, because every study has different participants.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from slipscale.analysis import json_form
from slipscale.analysis.json_form import Json, JsonObject
from slipscale.analysis.tasks.kind import Analysis

TABLE3 = "table3"
#: Keys that identify an element of a list. The values of these keys form the element's name.
IDENTIFIERS = (
    *("task", "from_level", "to_level", "reference_level", "removed_level", "standard_level"),
    *("surface", "from_surface", "to_surface", "comparison_level", "number", "name", "session"),
    *("factor", "condition", "first", "second"),
)
#: Keys whose values are omitted: results for single participants, word counts and settings.
LEFT_OUT = (
    *("participant", "participants", "consistency", "words"),
    *("normalisation", "levels", "left_out_levels"),
)
PERSON = "sub-"
#: Corrected p-values, which replace the uncorrected p-value of the same result.
CORRECTED = {
    "p": ("p_gg", "p_holm"),
    "p_wilcoxon": ("p_wilcoxon_holm",),
    "equivalence_p": ("equivalence_p_holm",),
}
#: p-values that do not count as conclusions: assumption checks and alternative corrections.
NOT_CONCLUDED = ("mauchly_p", "shapiro_p", "p_hf")
#: Boolean values that describe the computation and do not count as conclusions.
OF_A_COMPUTATION = ("converged", "at_bound", "at_ceiling")
#: Key of the best-fitting model's name.
BEST = "best"
BOUNDS = ("low", "high")
#: Suffixes of keys whose values are intervals.
OF_AN_INTERVAL = ("ci", "ci95", "interval")


class Label(tuple[str, ...]):
    """The values that identify an element of a list."""

    __slots__ = ()

    def __str__(self) -> str:
        """Join the values, without repetitions."""
        return " - ".join(dict.fromkeys(self))


class BestModel(str):
    """The name of the model that fits best."""

    __slots__ = ()


class ResultName(tuple[str | Label, ...]):
    """Keys and labels that lead to a result, followed by the best model if that is the result."""

    __slots__ = ()

    def __str__(self) -> str:
        """Return the name as it is written to files."""
        if isinstance(self[-1], BestModel):
            return f"{ResultName(self[:-1])}: {self[-1]}"
        return ".".join(map(str, self))

    def at(self, path: Sequence[str]) -> list[str | Label] | None:
        """Return what is at each ``*`` of a path, or None if the path leads elsewhere."""
        pairs = list(zip(path, self, strict=False))
        if len(path) != len(self) or any(one not in ("*", key) for one, key in pairs):
            return None
        return [key for one, key in pairs if one == "*"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """Numeric results and conclusions from one study.

    Parameters
    ----------
    numbers : Mapping
        Available numeric results (such as ``table3.0.5.mean`` or ``power_law.exponent``).
    conclusions : Mapping
        Whether each conclusion holds (a p-value is significant, or a statement is true), such as
        ``friedman.p``.
    """

    numbers: Mapping[ResultName, float] = field(default_factory=dict)
    conclusions: Mapping[ResultName, bool] = field(default_factory=dict)


def cell_name(level: float, statistic: str) -> ResultName:
    """Return the name of a cell in Table III.

    >>> str(cell_name(0.5, "mean"))
    'table3.0.5.mean'
    """
    return ResultName((TABLE3, f"{level:g}", statistic))


def findings(analysis: Analysis) -> Findings:
    """Return all numeric results and conclusions of an analysis."""
    numbers: dict[ResultName, float] = {}
    conclusions: dict[ResultName, bool] = {}
    if analysis.prepared is not None:
        for amplitude, *values in analysis.table3.itertuples(index=False):
            for column, value in zip(analysis.table3.columns[1:], values, strict=True):
                numbers[cell_name(amplitude, column)] = float(value)
    level = round(1 - analysis.dataset.choices.confidence, 12)
    for name, value in _leaves(json_form.form(analysis.inference.results), ResultName()):
        last = str(name[-1])
        if isinstance(value, bool):
            if last not in OF_A_COMPUTATION:
                conclusions[name] = value
        elif isinstance(value, int | float):
            numbers[name] = float(value)
            if _concludes(last):
                conclusions[name] = value < level
        elif isinstance(value, str) and last == BEST:
            conclusions[ResultName((*name, BestModel(value)))] = True
    return Findings(
        numbers={name: value for name, value in numbers.items() if math.isfinite(value)},
        conclusions=conclusions,
    )


def _concludes(key: str) -> bool:
    return "p" in key.split("_") and key not in NOT_CONCLUDED


def _leaves(value: Json, name: ResultName) -> Iterator[tuple[ResultName, Json]]:
    """Yield the name and value of each result in a nested record."""
    if isinstance(value, dict):
        yield from _of_record(_by_surface(value), name)
    elif isinstance(value, list):
        for label, inner in zip(_labels(value), value, strict=True):
            yield from _leaves(inner, ResultName((*name, label)))
    else:
        yield name, value


def _of_record(record: JsonObject, name: ResultName) -> Iterator[tuple[ResultName, Json]]:
    for key, value in record.items():
        replaced = any(other in record for other in CORRECTED.get(key, ()))
        identifies = key in IDENTIFIERS and not isinstance(value, dict)
        left_out = key in LEFT_OUT and not isinstance(key, json_form.Unchanged)
        if left_out or identifies or key.startswith(PERSON) or replaced:
            continue
        yield from _leaves(value, ResultName((*name, key)))


def _by_surface(record: JsonObject) -> JsonObject:
    """Convert the lists in a scale's record to mappings from surface to value."""
    surfaces = record.get("surfaces")
    # Scales list surfaces by name; ratings list them as records.
    if not isinstance(surfaces, list) or not all(isinstance(name, str) for name in surfaces):
        return record

    def named(key: str, value: Json) -> Json:
        bounds = key.endswith(OF_AN_INTERVAL)
        if bounds or not isinstance(value, list) or len(value) != len(surfaces):
            return value
        return dict(zip(map(str, surfaces), value, strict=True))

    return {
        key: {name: named(name, inner) for name, inner in value.items()}
        if isinstance(value, dict)
        else named(key, value)
        for key, value in record.items()
        if key != "surfaces"
    }


def _labels(values: list[Json]) -> Sequence[str | Label]:
    """Name the elements of a list: by identifier, as low and high, or by number from 1."""
    numbered = [str(number) for number in range(1, len(values) + 1)]
    if len(values) == len(BOUNDS) and not any(isinstance(value, dict | list) for value in values):
        return list(BOUNDS)
    named = [_identified(value) for value in values]
    return named if all(named) and len(set(named)) == len(named) else numbered


def _identified(value: Json) -> Label:
    if not isinstance(value, dict):
        return Label()
    parts = [value[key] for key in IDENTIFIERS if value.get(key) is not None]
    return Label(f"{part:g}" if isinstance(part, float) else str(part) for part in parts)
