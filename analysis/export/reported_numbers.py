"""List all numbers in a report, so that scripts can recompute them."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pandas as pd

from slipscale.analysis import json_form
from slipscale.analysis.json_form import Json
from slipscale.analysis.preprocessing.normalisation import RULES
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.effects.groups.statistics import membership
from slipscale.analysis.tasks.effects.sessions.statistics import SESSIONS
from slipscale.analysis.tasks.kind import Analysis
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.stimuli.level_names import path_in_file

#: Parts of the names of results that contain the unit in inference.json, and are omitted.
PER_UNIT, UNIT = re.compile(r"per_level\b"), re.compile(r"(?<!\bof)_levels?\b")
#: Results that cannot be recomputed from the files: verbal coding and squeeze-film predictions.
LEFT_OUT = re.compile(
    r"\.verbal_reports\.|\.finding\.|^growth\.(friction|individual)\.|covariance|^normalisation\."
)
#: Names of intervals that contain the confidence level.
LEVEL = re.compile(r"\bci95\b")


def reported_numbers(analysis: Analysis) -> pd.DataFrame:
    """Return every number in the report, in columns ``name value``.

    A name is the path to the number in the results, such as ``rm_anova.F``,
    ``pairwise.0.ratio_ci.0`` or ``table3.2.mean``. Positions count from 0.
    """
    parts = {
        "table3": analysis.table3.to_dict(orient="records"),
        "descriptives": analysis.description.to_dict(orient="records"),
        "robustness": [_means_in_order(json_form.record(row)) for row in analysis.robustness],
        "individuals": _exponents(analysis),
    }
    inference = json_form.record(analysis.inference.results)
    quantity = analysis.dataset.quantity
    found = [
        (
            path_in_file(
                LEVEL.sub("ci", UNIT.sub("", PER_UNIT.sub("per_unit", name))), quantity.in_file
            ),
            value,
        )
        for name, value in _numbers({**inference, **json_form.record(parts)})
        if not LEFT_OUT.search(name)
    ]
    return pd.DataFrame(found, columns=["name", "value"])


def _means_in_order(row: dict[str, Json]) -> dict[str, Json]:
    means = row["means"]
    return row | {"means": list(means.values()) if isinstance(means, dict) else means}


def _exponents(analysis: Analysis) -> dict[str, dict[str, float]]:
    own = analysis.individuals
    if "exponent" not in own:
        return {}
    return {
        str(who): {"exponent": float(value)}
        for who, value in zip(own[PARTICIPANT], own["exponent"], strict=True)
    }


#: Levels, which are inputs and not results.
GIVEN = re.compile(
    r"(^|\.)((level|from_level|to_level|removed_level|of_levels|reduction|presented_levels)(\.[\d.]+)?|levels\.[\d.]+)$"
)
#: Columns of levels that the script reads.
COLUMNS = (
    *("track_level", "standard_level", "reference_level", "matched_level", "comparison_level"),
    "produced_level",
)


def _numbers(value: Json, name: str = "") -> Iterator[tuple[str, float]]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _numbers(inner, f"{name}.{key}" if name else key)
    elif isinstance(value, list):
        for place, inner in enumerate(value):
            yield from _numbers(inner, f"{name}.{place}")
    elif isinstance(value, int | float) and not isinstance(value, bool) and not GIVEN.search(name):
        yield name, value


def settings(analysis: Analysis) -> pd.DataFrame:
    """Return the analysis choices and the names of level columns as ``name``-``value`` pairs."""
    data, choices = analysis.dataset, analysis.dataset.choices
    named, stepped = data.quantity.named, data.quantity.stepped
    found = {
        "level": data.quantity.column,
        "before": named("level_before") if stepped else data.quantity.column,
        "after": data.quantity.column if stepped else "reference",
        **{name: named(name) for name in (*COLUMNS, "of_level")},
        "answer": "difference_felt" if stepped else "yes",
        "weber_base": named("level_before") if stepped else "reference",
        "confidence": f"{choices.confidence!r}",
        "zero_rule": choices.zero_rule,
        "largest_mean": str(RULES[analysis.rule].most),
        "standard_deviation": choices.standard_deviation,
        "equivalence_ratio": f"{choices.equivalence_ratio!r}",
        "axis": choices.axis or "",
        "threshold_curve": choices.threshold_curve or "",
        "threshold_share": f"{choices.threshold_share!r}",
        "largest_lapse": f"{choices.largest_lapse!r}",
    }
    return pd.DataFrame(list(found.items()), columns=["name", "value"])


def task_trials(analysis: Analysis) -> dict[str, pd.DataFrame]:
    """Return the non-empty input tables for `recompute_tasks.R`, keyed by file name.

    The tables contain the analysed trials of every task (except tasks whose trials are already in a
    table of the report), the participants' groups and the session measures.
    """
    data = analysis.dataset
    found = {
        f"trials_{kind.trials.name}": data.of(kind.trials)
        for kind in analysis.kinds
        if kind.trials is not None and not kind.trials.label
    }
    groups = membership(data)
    if not isinstance(groups, NotComputed):
        found["groups"] = groups.rename("group").rename_axis(PARTICIPANT).reset_index()
    sessions = analysis.inference[SESSIONS]
    if sessions and sessions.measures:
        found["session_measures"] = pd.concat(
            [
                measure.table.reset_index(names=PARTICIPANT)
                .melt(PARTICIPANT, var_name="session")
                .assign(measure=measure.name)
                for measure in sessions.measures
            ],
            ignore_index=True,
        )
    return {name: data.quantity.columns(rows) for name, rows in found.items() if len(rows)}
