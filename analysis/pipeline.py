"""Compute all results of `slipscale analyse`, without writing files.

Each stage is a function that can also be called separately in a notebook. This module calls the
stages in order, with the options in the study file. Participants are excluded before descriptive
statistics and tests are computed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import inf

import pandas as pd

from slipscale.analysis.load import Data, load
from slipscale.analysis.preprocessing import data_quality, data_warnings, normalisation, sessions
from slipscale.analysis.preprocessing.log_transform import Prepared, prepare
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.reading.meaning.keywords import mapping_of
from slipscale.analysis.reporting.individuals import individuals
from slipscale.analysis.reporting.notebook import DisplayedAnalysis
from slipscale.analysis.statistics import descriptives
from slipscale.analysis.statistics.measured_friction import measured_friction
from slipscale.analysis.statistics.robustness import robustness
from slipscale.analysis.statistics.sensitivity import sensitivity
from slipscale.analysis.tasks.estimation import textures
from slipscale.analysis.tasks.outside import guard
from slipscale.analysis.tasks.table import KINDS, TRIALS, conclude
from slipscale.experiments.dataset.hand_exclusions import BY_HAND, excluded_by_hand
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.study.analysis_choices import Axis
from slipscale.faults import UserError


class OutsideTasks(UserError):
    """The data set contains only tasks from other packages, none of which provides an analysis."""


def analyse(
    dataset: Data | Dataset,
    *,
    normalise: str | None = None,
    equivalence_ratio: float | None = None,
    axis: Axis | None = None,
    bayesian: bool = False,
    progress: Callable[[str], None] | None = None,
    **columns: object,
) -> DisplayedAnalysis:
    """Analyse a data set. To write the results, use the method ``save``.

    Parameters
    ----------
    dataset : str, Path, sequence of them, DataFrame or Dataset
        What `slipscale.analysis.load.load` reads or returns.
    normalise : str, optional
        A key of `slipscale.analysis.preprocessing.normalisation.RULES`. The default is the rule in
        the study file or, if none is set, `default_rule` in that module.
    equivalence_ratio : float, optional
        Largest ratio of two geometric means at which the amplitudes count as equivalent. The
        default is the ratio in the study file.
    axis : {"linear", "logarithmic"}, optional
        Axis of threshold curves. The default is the axis in the study file.
    bayesian : bool
        Whether to sample the hierarchical Bayesian power function as well, which requires the extra
        ``bayes``.
    progress : callable, optional
        Function called with a short description of the next step.
    **columns
        Meaning of a table's columns; see `slipscale.analysis.load.load`.

    Raises
    ------
    UserError
        If the data cannot be read, contain nothing to analyse, or cannot be normalised by the rule.
    """
    tell = progress or (lambda _: None)
    if isinstance(dataset, Dataset):
        data = dataset
    else:
        tell("reading the data")
        data = load(dataset, mapping_of(columns) if columns else None)
    faults: list[str] = []
    outside = guard.installed_kinds(faults)
    if not any(map(len, data.tasks)) and not (data.others and outside):
        error = OutsideTasks if data.others else UserError
        raise error(f"{data.name}: {data_warnings.nothing(data, TRIALS)}")
    absences = data_warnings.absent(data)
    asked = {"equivalence_ratio": equivalence_ratio, "axis": axis}
    data, changes = _with_choices(data, asked)
    tell("checking data quality")
    measures = data_quality.measures(data, data.choices.thresholds)
    flags = data_quality.flags(measures, data.choices.thresholds)
    data, excluded = exclude(data, flags)
    tell("describing")
    estimates, prepared, rule, notes = normalised(data, normalise)
    cells = prepared.cells if prepared else normalisation.cell_means(estimates, "normalised")
    choices = data.choices
    description = descriptives.describe(
        cells,
        prepared.logs if prepared else cells,
        confidence=choices.confidence,
        most=normalisation.RULES[rule].most,
    )
    tell("testing")
    kinds = (*KINDS, *outside)
    inference = conclude(
        data,
        prepared,
        rule if prepared else None,
        bayesian=bayesian,
        kinds=kinds,
    )
    analysis = DisplayedAnalysis(
        dataset=data,
        rule=rule,
        estimates=estimates,
        cells=cells,
        table3=descriptives.means_and_spreads(cells, choices.standard_deviation),
        description=description,
        textures=textures.describe(data.textures, data.estimates, rule, choices.standard_deviation),
        prepared=prepared,
        inference=inference,
        sensitivity=sensitivity(data.estimates, rule, data.quantity) if prepared else (),
        robustness=robustness(prepared, set(flags.index[flags.any(axis=1)])) if prepared else (),
        individuals=individuals(prepared, inference),
        measures=measures,
        flags=flags,
        excluded=excluded,
        friction=measured_friction(prepared),
        kinds=kinds,
        problems=(
            *data.problems,
            *absences,
            *sessions.pooled(data),
            *changes,
            *notes,
            *data_warnings.changing_tops(data),
            *data_warnings.beyond_tops(data),
            *data_warnings.too_few_data(cells, data.quantity),
            *data_warnings.scales(cells, rule),
            *data_warnings.unequal(prepared),
            *data_warnings.without_a_condition(prepared),
        ),
    )
    return guard.evaluated(analysis, faults)


def _with_choices(data: Dataset, asked: Mapping[str, object]) -> tuple[Dataset, list[str]]:
    """Set the requested choices; add a note for each that a frozen study sets differently."""
    own = data.choices
    differing = {
        name: value
        for name, value in asked.items()
        if value is not None and value != getattr(own, name)
    }
    ratio = differing.get("equivalence_ratio", 2.0)
    if not (isinstance(ratio, float | int) and 1 < ratio < inf):
        raise UserError(
            "the equivalence ratio is {asked:g}; expected a number above 1", asked=ratio
        )
    if "axis" in differing and own.threshold_curve:
        raise UserError(
            "--axis: the study sets threshold_curve = {curve}, which has its own axis; remove one "
            "of them",
            curve=own.threshold_curve,
        )
    notes = [
        f"The frozen study sets {name} = {getattr(own, name)}, but the analysis used {value}."
        for name, value in differing.items()
        if name in data.frozen
    ]
    return replace(data, choices=own.model_copy(update=differing)), notes


def normalised(
    data: Dataset, asked: str | None
) -> tuple[pd.DataFrame, Prepared | None, str, list[str]]:
    """Return normalised estimates, prepared data for inference, the rule, and notes on the rule."""
    rule, notes = _choose_rule(data, asked)
    estimates = data.estimates.assign(normalised=normalisation.normalise(data.estimates, rule))
    prepared = prepare(estimates, data.choices, data.quantity) if len(estimates) else None
    return (prepared.trials if prepared else estimates), prepared, rule, notes


def exclude(data: Dataset, flags: pd.DataFrame) -> tuple[Dataset, dict[str, tuple[str, ...]]]:
    """Return the data without excluded participants, and the reasons for each exclusion."""
    rules: list[str] = list(data.choices.exclusions)
    by_hand = excluded_by_hand(data.folder) if data.folder else {}
    why: dict[str, tuple[str, ...]] = {}
    for who in map(str, flags.index):
        broken = [name for name in rules if bool(flags.loc[who, name])]
        if decision := by_hand.get(who.removeprefix("sub-")):
            after = ", after results were shown" if decision.results_seen else ""
            broken.append(f"{BY_HAND}{after}: {decision.reason}")
        if broken:
            why[who] = tuple(broken)
    if why and len(why) == len(flags):
        causes = [*rules, *([BY_HAND] if by_hand else [])]
        raise UserError(
            "{data_name}: the study's exclusions ({causes}) leave no participants",
            data_name=data.name,
            causes=", ".join(causes),
        )
    if not why:
        return data, {}

    def keep(rows: pd.DataFrame) -> pd.DataFrame:
        if not len(rows):
            return rows
        kept = rows[~rows[PARTICIPANT].isin(list(why))].reset_index(drop=True)
        people = kept[PARTICIPANT].cat.remove_unused_categories()
        return kept.assign(**{PARTICIPANT: people})

    kept = data.with_tables(keep)
    removed = {
        f"{kind.counted}_excluded": len(data.of(kind)) - len(kept.of(kind)) for kind in TRIALS
    }
    return replace(kept, counts={**data.counts, **removed}), why


def _choose_rule(data: Dataset, asked: str | None) -> tuple[str, list[str]]:
    """Return the normalisation rule set by the user, study or default, and notes on the choice."""
    frozen = data.choices.normalisation
    if asked and frozen and asked != frozen:
        return asked, [
            (
                f"The frozen study sets the normalisation '{frozen}', but the analysis used "
                f"'{asked}'."
            )
        ]
    if asked or frozen:
        return str(asked or frozen), []
    rule = normalisation.default_rule(data.estimates)
    if not (data.estimates["estimate"] > 0).any():
        return "none", []
    tops = data.estimates["scale_top"]
    if rule != "scale_top" and tops.notna().any():
        return rule, [
            (
                f"Mixed scales: {int((~(tops > 0)).sum())} of {len(tops)} trials have no declared "
                f"top of the scale above 0; all trials are normalised by '{rule}' instead."
            )
        ]
    return rule, []
