"""Declare scales from paired comparisons and triads."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median

from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from slipscale.analysis.json_form import JsonObject
from slipscale.analysis.reading.surface_labels import amplitude_of, with_unit
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed, all_computed, computed, fold
from slipscale.analysis.tasks.declared.one_statistic import Blocks, Figures, OneStatistic, Svgs
from slipscale.analysis.tasks.scales.difference_scaling import DifferenceScale
from slipscale.analysis.tasks.scales.paired_comparison_scale import ComparisonScale
from slipscale.analysis.tasks.scales.statistics import SCALES, TRIALS, TaskScale
from slipscale.analysis.tasks.scales.transitivity import Consistency
from slipscale.analysis.writing import html
from slipscale.analysis.writing.axes import tip
from slipscale.analysis.writing.numbers import DASH, bracketed, counted, joined, number, p_value
from slipscale.analysis.writing.task_names import task_name
from slipscale.figure_style import BLUE, GREY, PALE, canvas, styled
from slipscale.stimuli.quantity import Quantity, capitalised


def _fit(found: TaskScale) -> str:
    """Return sentences on the fit of a scale, for the caption of the table."""
    texts, fitted = [], []
    for name, scale in (("Bradley-Terry", found.bradley_terry), ("Thurstone V", found.thurstone)):
        if isinstance(scale, NotComputed):
            if found.consistency:
                texts.append(f"{name}: not computed ({scale.reason}).")
        elif scale.fit:
            fitted.append(
                f"{name}, deviance {number(scale.fit.deviance)} (df = {scale.fit.df}, "
                f"{p_value(scale.fit.p)})"
            )
    if fitted:
        texts.append(
            f"Fit with Firth's correction, treating answers as independent: {'; '.join(fitted)}."
        )
    if found.transitivity:
        counts = found.transitivity
        texts.append(
            f"Of {counts.triads} triads, {counts.weak_violations}, "
            f"{counts.moderate_violations} and {counts.strong_violations} violate weak, "
            "moderate and strong stochastic transitivity, respectively."
        )
    if found.differences:
        texts.append(
            "Maximum likelihood difference scaling; the noise is "
            f"{number(found.differences.noise)} of "
            f"the whole scale, CI {bracketed(found.differences.noise_interval)}."
        )
    return " ".join(texts)


def _scale_table(task: TaskScale, quantity: Quantity) -> Markup:
    scales: dict[str, ComparisonScale | DifferenceScale | NotComputed] = {
        "Bradley-Terry": task.bradley_terry,
        "Thurstone V": task.thurstone,
        "Difference scale": task.differences,
    }
    titles = ["Surface"]
    cells: list[list[str]] = []
    if task.chosen:
        titles.append("Chosen")
        counts = zip(task.chosen, task.compared, strict=True)
        cells.append([f"{chosen}/{compared}" for chosen, compared in counts])
    for title, found in scales.items():
        if found:
            titles += [title, "CI"]
            cells.append([number(value) for value in found.values])
            cells.append([bracketed(interval) for interval in found.intervals])
    rows = [
        [with_unit(name, quantity), *(column[place] for column in cells)]
        for place, name in enumerate(task.surfaces)
    ]
    return html.table(html.columns(*titles, left=1), rows, _fit(task))


def _consistency_table(task: TaskScale) -> Markup:
    zetas = [each.zeta for each in all_computed(task.consistency.values())]
    rows = [
        [who, *fold(each, _counts, lambda reason: [DASH, DASH, reason])]
        for who, each in task.consistency.items()
    ]
    columns = html.columns("Participant", "Circular triads", "Consistence ζ", "By chance", left=1)
    caption = (
        "Circular triads (A over B, B over C, C over A; ties count half each way), Kendall's "
        "coefficient of consistence, and the probability of so few circular triads if choices were "
        "random."
    )
    summary = "Consistency of each participant"
    if zetas:
        summary += (
            f": ζ from {number(min(zetas))} to {number(max(zetas))}, median "
            f"{number(median(zetas))} (1: no circular triads)"
        )
    return html.details(summary, [html.table(columns, rows, caption)])


def _counts(found: Consistency) -> list[str]:
    return [f"{found.circular_triads:g}/{found.triads}", number(found.zeta), p_value(found.p)]


@styled
def scale(found: TaskScale, quantity: Quantity) -> Figure:
    """Plot a Bradley-Terry scale for pairs, or a difference scale for triads."""
    figure, axes = canvas(size=(5.6, 3.4))
    for scaled, kind in (
        (found.bradley_terry, "log odds, Bradley-Terry"),
        (found.differences, "difference scale, 0 to 1"),
    ):
        if scaled:
            _points(axes, found.surfaces, scaled.values, scaled.intervals, quantity)
            axes.set_ylabel(f"{capitalised(quantity.judged)} ({kind})")
    return figure


def _points(
    axes: Axes,
    surfaces: Sequence[str],
    values: Sequence[float],
    intervals: Sequence[ConfidenceInterval | None],
    quantity: Quantity,
) -> None:
    numbers = [amplitude_of(name) for name in surfaces]
    known = [each for each in numbers if each is not None]
    # Textures have no amplitude, so if there are any, all surfaces are drawn side by side.
    amplitudes = len(known) == len(surfaces)
    places = known if amplitudes else [float(place) for place in range(len(surfaces))]
    if amplitudes:
        axes.plot(places, values, color=PALE, linewidth=1.0, zorder=1)
    for place, name, value, interval in zip(places, surfaces, values, intervals, strict=True):
        if interval is not None:
            axes.plot([place, place], list(interval), color=BLUE, linewidth=1.8, zorder=2)
        axes.plot([place], [value], "o", color=BLUE, zorder=3, gid=tip(f"{name}: {value:.2f}"))
    axes.axhline(0, color=GREY, linewidth=0.8, linestyle=":", zorder=0)
    axes.set_xticks(places, list(surfaces))
    axes.set_xlabel(quantity.headed(quantity.title) if amplitudes else "Surface")


class _Scales(OneStatistic[TaskScale]):
    name = "scales"
    trials = TRIALS
    statistics = (SCALES,)
    question = "Where do the {q.stimuli} lie on a single scale of {q.judged}?"
    what = "paired-comparison"
    title = "Paired comparison"
    heading = "Scales of {q.judged}"

    def task_name(self, found: TaskScale, _quantity: Quantity) -> str:
        form = {2: "Paired comparison", 3: "Triads", 4: "Quadruples"}[found.stimuli]
        return task_name(f"{form} of {len(found.surfaces)} surfaces", found.task)

    def task_answer(self, found: TaskScale, _confidence: float, quantity: Quantity) -> str:
        scale = found.bradley_terry if found.consistency else found.differences
        what = (
            f"{self.task_name(found, quantity)}, {counted(found.answers, 'answer', 'answers')} "
            "from " + counted(found.participants, "participant", "participants")
        )
        if isinstance(scale, NotComputed):
            counts = zip(found.surfaces, found.chosen, found.compared, strict=False)
            shares = ", ".join(
                f"{with_unit(name, quantity)}: {chosen} of {there}"
                for name, chosen, there in counts
            )
            listing = f"; chosen: {shares}" if shares else ""
            return f"{what}: no scale was computed ({scale.reason}){listing}."
        unit = (
            "scale values (Bradley-Terry model, natural log odds of a choice, mean 0)"
            if found.consistency
            else "scale values (maximum likelihood difference scaling, from 0 to 1)"
        )
        order = sorted(zip(scale.values, found.surfaces, strict=True), key=lambda each: each[0])
        values = [number(value) for value, _ in order]
        surfaces = [with_unit(name, quantity) for _, name in order]
        if len(set(values)) == 1:
            return f"{what}: all {unit} were {values[0]} ({joined(surfaces)})."
        names = joined([f"{value} ({name})" for value, name in zip(values, surfaces, strict=True)])
        return f"{what}: from the least to the most {quantity.adjective}, {unit} were {names}."

    def task_blocks(self, task: TaskScale, svgs: Svgs, level: float, quantity: Quantity) -> Blocks:
        values = bool(task.consistency) or computed(task.differences) is not None
        return [
            *html.figure_if_drawn(
                svgs,
                f"scale_{task.task}",
                f"Scale values with {level:g} % intervals"
                + (
                    ", which account for correlated answers from the same participant."
                    if task.consistency
                    else " (bootstrap); the first and last surface are 0 and 1 by definition."
                ),
                f"Scale values of {', '.join(with_unit(each, quantity) for each in task.surfaces)}",
            ),
            _scale_table(task, quantity)
            if values
            else html.paragraph(self.task_answer(task, level / 100, quantity), "note"),
            *([_consistency_table(task)] if task.consistency else []),
        ]

    def task_figures(self, task: TaskScale, _: object, quantity: Quantity) -> Figures:
        drawn = any(map(computed, (task.bradley_terry, task.differences)))
        return {f"scale_{task.task}": scale(task, quantity)} if drawn else {}

    def task_rows(self, task: TaskScale) -> list[JsonObject]:
        rows: list[JsonObject] = []
        for name, chosen, compared in zip(task.surfaces, task.chosen, task.compared, strict=False):
            share = {"value": chosen / compared if compared else None}
            rows.append({"task": task.task, "model": "share chosen", "surface": name, **share})
        for found in (task.bradley_terry, task.thurstone, task.differences):
            if not found:
                continue
            model = "differences" if isinstance(found, DifferenceScale) else found.model
            for name, value, interval in zip(
                task.surfaces, found.values, found.intervals, strict=True
            ):
                low, high = (None, None) if interval is None else interval
                row: JsonObject = {
                    "task": task.task,
                    "model": model,
                    "surface": name,
                    "value": value,
                }
                rows.append(row | {"ci_low": low, "ci_high": high})
        return rows


ANALYSIS = _Scales()
