"""Declare magnitude estimation."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import pandas as pd
from matplotlib.figure import Figure

from slipscale.analysis.preprocessing import normalisation
from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.power_law import exponents
from slipscale.analysis.statistics.statistic import SessionTable
from slipscale.analysis.tasks.effects.groups.statistics import GROUPS, membership
from slipscale.analysis.tasks.effects.sessions.anova import session_logs
from slipscale.analysis.tasks.estimation import (
    comparisons_section,
    figures,
    growth_section,
    sentences,
    table,
)
from slipscale.analysis.tasks.estimation import section as estimates_section
from slipscale.analysis.tasks.estimation.growth import exponents_figure
from slipscale.analysis.tasks.estimation.growth import figures as growth_figures
from slipscale.analysis.tasks.estimation.plain_answer import plain_answer
from slipscale.analysis.tasks.estimation.primary import primary_sentences, secondary_sentences
from slipscale.analysis.tasks.estimation.reading import TRIALS
from slipscale.analysis.tasks.estimation.spread import unequal_spread
from slipscale.analysis.tasks.estimation.statistics import (
    BAYESIAN_GROWTH,
    GROWTH,
    ORDER,
    PAIRWISE,
    POWER_LAW,
    RM_ANOVA,
    STATISTICS,
)
from slipscale.analysis.tasks.kind import Analysis, TaskAnalysis
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import counted, joined
from slipscale.analysis.writing.verdicts import reliable


def _equal(analysis: Analysis) -> list[str]:
    """Return a sentence on pairs that were shown to be equivalent, if there are any."""
    level = analysis.dataset.choices.confidence
    pairs = analysis.inference.found(PAIRWISE) or ()
    if not any(reliable(pair.logs.equivalence_p_holm, level) for pair in pairs if pair.logs):
        return []
    text = sentences.equivalence(pairs, level, analysis.dataset.quantity)
    return [text] if text else []


def _groups(analysis: Analysis, prepared: Prepared) -> pd.Series[str] | None:
    """Return each participant's group (NaN if it was not compared), or None without groups."""
    compared, member = analysis.inference.found(GROUPS), membership(analysis.dataset)
    if compared is None or isinstance(member, NotComputed):
        return None
    people = prepared.logs.index
    found = member.reindex(people.astype(str)).set_axis(people)
    return found.where(found.isin(list(compared.n)))


class _Estimation(TaskAnalysis):
    name = "estimation"
    trials = TRIALS
    statistics = STATISTICS
    tables = staticmethod(table.tables)

    def questions(self, analysis: Analysis) -> list[str]:
        if analysis.prepared is None:
            return []
        quantity = analysis.dataset.quantity
        return [f"Does {quantity.perceived} change with {quantity.in_full}, and how?"]

    def design(self, analysis: Analysis) -> list[str]:
        if analysis.prepared is None:
            return []
        amplitudes = joined([f"{a:g}" for a in analysis.cells.columns])
        trials = counted(len(analysis.estimates), "estimate", "estimates")
        return [f"{trials} of {analysis.dataset.quantity.with_convention(amplitudes)}"]

    def answers(self, analysis: Analysis) -> list[str]:
        if analysis.prepared is None:
            return []
        data, inference = analysis.dataset, analysis.inference
        level, quantity = data.choices.confidence, data.quantity
        texts = primary_sentences(inference, data.choices.primary, level, quantity)
        texts += _equal(analysis)
        if analysis.prepared.geometric:
            texts.insert(0, sentences.geometric_means(analysis.description, quantity))
        if (found := inference.found(POWER_LAW)) is not None:
            texts.append(sentences.power_law(found, level, quantity))
        return texts

    def plain_answers(self, analysis: Analysis) -> list[str]:
        return [] if analysis.prepared is None else [plain_answer(analysis)]

    def doubts(self, analysis: Analysis) -> list[str]:
        order = analysis.inference[ORDER]
        found = []
        if isinstance(order, NotComputed) and "not identifiable" in order.reason:
            found.append(f"Order effects are {order.reason}.")
        if analysis.prepared is not None and analysis.dataset.choices.primary == "ranks":
            found += unequal_spread(analysis.prepared)
            pairs = analysis.inference.found(PAIRWISE) or ()
            choices = analysis.dataset.choices
            found += sentences.out_of_reach(pairs, choices.confidence, analysis.dataset.quantity)
        return found

    def sentences(self, analysis: Analysis) -> Mapping[str, list[str]]:
        if analysis.prepared is None:
            return {}
        choices = analysis.dataset.choices
        asked = (analysis.inference, choices.primary, choices.confidence, analysis.dataset.quantity)
        return {
            "Primary analysis": primary_sentences(*asked),
            "Secondary analyses": secondary_sentences(*asked),
        }

    def sections(self, analysis: Analysis, svgs: Mapping[str, str]) -> Iterable[ReportSection]:
        parts = (
            estimates_section.estimates,
            comparisons_section.comparisons,
            growth_section.growth,
        )
        return [write(analysis, svgs) for write in parts]

    def figures(self, analysis: Analysis) -> Mapping[str, Figure]:
        prepared, inference = analysis.prepared, analysis.inference
        if prepared is None:
            return {}
        quantity, level = analysis.dataset.quantity, analysis.dataset.choices.confidence
        rule = normalisation.RULES[analysis.rule]
        unit, groups = rule.unit.format(q=quantity), _groups(analysis, prepared)
        drawn = {
            "fig15": figures.fig15(
                analysis.cells,
                unit=unit,
                top=rule.end,
                most=rule.most,
                paper=analysis.beside_paper,
                confidence=level,
                quantity=quantity,
                groups=groups,
            )
        }
        if prepared.geometric:
            drawn["growth_means"] = figures.growth_means(
                prepared.logs,
                without_log=prepared.without_log,
                unit=unit,
                confidence=level,
                quantity=quantity,
                groups=groups,
            )
        if inference.found(POWER_LAW) is not None:
            drawn["growth"] = growth_figures.growth(
                prepared.logs, inference[GROWTH], unit=unit, confidence=level, quantity=quantity
            )
        if (bayesian := inference.found(BAYESIAN_GROWTH)) is not None and bayesian.converged:
            drawn["exponents"] = exponents_figure.exponents(bayesian)
        if inference.found(RM_ANOVA) is not None:
            drawn["residuals"] = figures.residuals(prepared.whole_logs, quantity)
        return drawn

    def session_tables(self, _data: Dataset, prepared: Prepared | None) -> Iterator[SessionTable]:
        if prepared is None or prepared.refused:
            return
        logs = session_logs(prepared)
        levels = {label: table.mean(axis=1, skipna=False) for label, table in logs.items()}
        slopes = {label: exponents(table)["exponent"] for label, table in logs.items()}
        yield "magnitude estimation, level", "mean natural logarithm", pd.DataFrame(levels)
        yield "magnitude estimation, exponent", "exponent", pd.DataFrame(slopes)


ANALYSIS = _Estimation()
