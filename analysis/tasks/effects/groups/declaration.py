"""Define how participant groups are analysed and reported."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import exp

from markupsafe import Markup

from slipscale.analysis.reading.cells import listed
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.repeated_measures.two_way import Effect
from slipscale.analysis.tasks.declared.two_way_texts import effect_text
from slipscale.analysis.tasks.effects.groups.statistics import GROUPS, GroupComparison
from slipscale.analysis.tasks.effects.groups.welch import GroupDifference, Welch
from slipscale.analysis.tasks.kind import Analysis, TaskAnalysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import (
    DASH,
    bracketed,
    counted,
    grouped,
    interval,
    level_of,
    number,
    p_cell,
    p_value,
    unit_number,
)
from slipscale.analysis.writing.verdicts import DIFFERED, HAD_EFFECT, reliable, verdict
from slipscale.stimuli.quantity import Quantity


def group_sentences(
    found: GroupComparison | NotComputed, confidence: float, quantity: Quantity
) -> list[str]:
    """Return the sentences on groups; empty if groups were not compared."""
    if not found:
        return []
    sizes = ", ".join(f"{name} (n = {n})" for name, n in found.n.items())
    texts = [f"Groups were defined by {found.column}: {sizes}{_left_out(found)}."]
    texts += answers(found, confidence)
    anova = found.anova
    if isinstance(anova, NotComputed):
        texts.append(f"The mixed analysis of variance was not computed: {anova.reason}.")
        return texts
    corrected = f"; Greenhouse-Geisser ε = {unit_number(anova.epsilon_gg)}"
    texts.append(
        "In a mixed analysis of variance of log estimates, the group "
        f"{verdict(HAD_EFFECT, anova.group.p, confidence, anova.group.df2)} "
        f"on them, {_statistics(anova.group, confidence)}; the effect of {quantity.name} "
        f"{verdict(DIFFERED, anova.interaction.p, confidence, anova.interaction.df2)} between "
        f"groups (interaction), {_statistics(anova.interaction, confidence)}{corrected}."
    )
    return texts


def answers(found: GroupComparison | NotComputed, confidence: float) -> list[str]:
    """Return sentences on differences in exponents and levels between groups."""
    if not found:
        return []
    texts = []
    if isinstance(found.exponents, NotComputed):
        texts.append(f"Exponents were not compared: {found.exponents.reason}.")
    else:
        texts.append(_welch("Exponents", "difference", number, found.exponents, confidence))
    if isinstance(found.levels, NotComputed):
        texts.append(f"Mean log estimates were not compared: {found.levels.reason}.")
    else:
        texts.append(
            _welch(
                "Mean log estimates",
                "ratio of geometric means",
                lambda value: number(exp(value)),
                found.levels,
                confidence,
            )
        )
    return texts


def _left_out(found: GroupComparison) -> str:
    parts = [f"groups too small to compare: {listed(found.left_out)}"] if found.left_out else []
    parts += (
        [f"{counted(found.without_group, 'participant', 'participants')} in no group"]
        if found.without_group
        else []
    )
    return f"; {'; '.join(parts)}" if parts else ""


def _welch(
    what: str, by: str, write: Callable[[float], str], found: Welch, confidence: float
) -> str:
    verb = verdict(DIFFERED, found.p, confidence, found.df2)
    test = (
        f"{what} {verb} between groups, Welch's F({found.df1:g}, {found.df2:.2f}) = "
        f"{number(found.F)}, {p_value(found.p)}, η² = {unit_number(found.eta2)}"
    )
    if found.eta2_interval is not None:
        test += f", {level_of(confidence)} CI {bracketed(found.eta2_interval, unit_number)}"
    if len(found.pairs) == 1:
        return f"{test}; {_pair(found.pairs[0], by, write, confidence)}."
    apart = [pair for pair in found.pairs if reliable(pair.p_holm, confidence)]
    listing = "; ".join(
        f"{_pair(pair, by, write, confidence)}, {p_value(pair.p_holm)}" for pair in apart
    )
    differences = f": {listing}" if apart else ""
    return (
        f"{test}; a difference was shown for {len(apart) or 'none'} of {len(found.pairs)} pairs of "
        f"groups (Welch's t, Holm-corrected){differences}."
    )


def _pair(pair: GroupDifference, by: str, write: Callable[[float], str], confidence: float) -> str:
    size = "" if pair.hedges_g_interval is None else f" {bracketed(pair.hedges_g_interval)}"
    return (
        f"{pair.first} compared with {pair.second} ({by} {write(pair.difference)}, "
        f"{level_of(confidence)} CI {bracketed(pair.interval, write)}, Hedges' g = "
        f"{number(pair.hedges_g)}{size})"
    )


def _statistics(found: Effect, confidence: float) -> str:
    text, bounds = effect_text(found), found.eta2_partial_interval
    if bounds is None:
        return text
    return f"{text}, {level_of(confidence)} CI {bracketed(bounds, unit_number)}"


#: Field of `GroupComparison` -> description with a placeholder for the quantity ``q``, name of the
#: difference, and conversion of a value.
COMPARED: dict[str, tuple[str, str, Callable[[float], float]]] = {
    "exponents": ("Exponent", "difference", float),
    "levels": ("Geometric mean across all {q.levels}", "ratio", exp),
}


def _means(found: Welch, title: str, level: str, read: Callable[[float], float]) -> Markup:
    return html.table(
        html.columns("Group", "n", "Mean", f"{level} CI", left=1),
        [
            [
                group.group,
                str(group.n),
                grouped(read(group.mean)),
                interval(read(group.interval.low), read(group.interval.high)),
            ]
            for group in found.groups
        ],
        f"{title} by group, with t-based intervals across the group's participants.",
    )


def _pairs(
    found: Welch, title: str, how: str, level: str, read: Callable[[float], float]
) -> Markup:
    return html.table(
        html.columns(
            *("Groups", how.capitalize(), f"{level} CI", "t", "df", ("p", "Holm")),
            *(("g", "Hedges"), (f"{level} CI", "of g")),
            left=1,
        ),
        [
            [
                f"{pair.first} – {pair.second}",
                grouped(read(pair.difference)),
                interval(read(pair.interval.low), read(pair.interval.high)),
                grouped(pair.t),
                grouped(pair.df, 1),
                p_cell(pair.p_holm),
                grouped(pair.hedges_g),
                DASH if pair.hedges_g_interval is None else interval(*pair.hedges_g_interval),
            ]
            for pair in found.pairs
        ],
        f"{title}: Welch's t tests between all pairs of groups.",
    )


class _Groups(TaskAnalysis):
    name = "groups"
    statistics = (GROUPS,)

    def answers(self, analysis: Analysis) -> list[str]:
        return answers(analysis.inference[GROUPS], analysis.dataset.choices.confidence)

    def sentences(self, analysis: Analysis) -> Mapping[str, list[str]]:
        found, data = analysis.inference[GROUPS], analysis.dataset
        return {"Groups": group_sentences(found, data.choices.confidence, data.quantity)}

    def sections(self, analysis: Analysis, _svgs: Mapping[str, str]) -> list[ReportSection]:
        """Return the section on groups, which is empty if the study has no groups."""
        section = ReportSection("Groups")
        found = analysis.inference[GROUPS]
        if not found:
            return [section]
        for name, (template, how, read) in COMPARED.items():
            title = template.format(q=analysis.dataset.quantity)
            part = getattr(found, name)
            if isinstance(part, NotComputed):
                section.blocks.append(
                    html.paragraph(f"{title}: not compared ({part.reason}).", "note")
                )
            else:
                level = level_of(analysis.dataset.choices.confidence)
                section.blocks += [
                    _means(part, title, level, read),
                    _pairs(part, title, how, level, read),
                ]
        return [section]


ANALYSIS = _Groups()
