"""Write the section on participants, data quality and exclusions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeAlias

import pandas as pd

from slipscale.analysis.preprocessing import data_quality as quality_rules
from slipscale.analysis.statistics.not_computed import computed
from slipscale.analysis.tasks.difference.reading import TRIALS as DIFFERENCES
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection, TableColumn
from slipscale.analysis.writing.numbers import (
    DASH,
    SMALLEST_OF_TWO_DECIMALS,
    counted,
    grouped,
    interval,
    significant,
)
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.stimuli.quantity import Quantity, capitalised

if TYPE_CHECKING:
    from markupsafe import Markup

    from slipscale.analysis.statistics.robustness import SubsetSummary
    from slipscale.analysis.tasks.kind import Analysis

    #: One row of a DataFrame.
    Row: TypeAlias = pd.Series[Any]

#: Largest number of participants listed in the report; quality.csv lists all.
PARTICIPANTS_SHOWN = 60
#: Smallest number of steps per participant for which the report shows d' and c.
FEWEST_FOR_D_PRIME = 10


def quality(analysis: Analysis) -> ReportSection:
    """Return the section with flags, exclusions and results without flagged participants."""
    section = ReportSection("Participants and data quality")
    data = analysis.dataset
    section.blocks += [html.paragraph(text) for text in _counted(analysis)]
    flags = analysis.flags
    flagged = flags[flags.any(axis=1)]
    section.gist = [
        f"{counted(len(flagged), 'participant was', 'participants were')} flagged and "
        f"{len(analysis.excluded)} excluded."
        if len(flagged) or analysis.excluded
        else "No participant was flagged or excluded."
    ]
    rules = ", ".join(data.choices.exclusions)
    excluded = "; ".join(f"{who} ({', '.join(why)})" for who, why in analysis.excluded.items())
    if rules or excluded:
        set_by = f"Exclusion rule in the study file: {rules}. " if rules else ""
        section.blocks.append(
            html.paragraph(f"{set_by}Excluded before the analysis: {excluded or 'nobody'}.")
        )
    else:
        section.blocks.append(html.paragraph("The study file does not define any exclusion rules."))
    rows = [
        [
            str(who),
            "; ".join(
                f"{name.replace('_', ' ')} ({_measure(analysis, str(who), name)})"
                for name in flags.columns
                if row[name]
            ),
            "excluded" if str(who) in analysis.excluded else "kept",
        ]
        for who, row in flagged.iloc[:PARTICIPANTS_SHOWN].iterrows()
    ]
    if rows:
        meanings = "; ".join(
            f"{name.replace('_', ' ')}: {quality_rules.MEANINGS[name].format(q=data.quantity)}"
            for name in flags.columns
            if flagged[name].any()
        )
        more = len(flagged) - len(rows)
        section.blocks.append(
            html.table(
                html.columns("Participant", "Flags (measure)", "Analysis", left=3),
                rows,
                f"Flagged: {len(flagged)} of {len(flags)} participants. {meanings}."
                + (f" Participants listed only in quality.csv: {more}." if more else ""),
            )
        )
    if len(analysis.robustness) > 1:
        section.blocks.append(_with_and_without(analysis))
    section.blocks += _each(analysis)
    return section


def _each(analysis: Analysis) -> list[Markup]:
    """Return the table of individual exponents and sensitivities, or nothing if it is empty."""
    own, quantity = analysis.individuals, analysis.dataset.quantity
    if not len(own):
        return []
    # With few steps, d' and c mainly reflect the log-linear correction.
    sensitive = "d_prime" in own and own["changes"].max() >= FEWEST_FOR_D_PRIME
    known = {
        name: column
        for name, column in OWN_COLUMNS.items()
        if name in own and (sensitive or name not in {"d_prime", "criterion"})
    }
    more = len(own) - PARTICIPANTS_SHOWN
    rows = [
        [
            row[PARTICIPANT],
            *(write(row) for name, (_, write) in OWN_COLUMNS.items() if name in known),
        ]
        for _, row in own.head(PARTICIPANTS_SHOWN).iterrows()
    ]
    return [
        html.table(
            [
                TableColumn(title="Participant", left=True),
                *(_headed(column, quantity) for column, _ in known.values()),
            ],
            rows,
            "Results of each participant."
            + (" Exponents are descriptive." if "exponent" in known else "")
            + (" d′ and c are in individuals.csv." if "d_prime" in own and not sensitive else "")
            + (f" Participants listed only in individuals.csv: {more}." if more > 0 else ""),
        )
    ]


def _of(row: Row, part: str, whole: str) -> str:
    return DASH if pd.isna(row[part]) else f"{row[part]:.0f}/{row[whole]:.0f}"


def _headed(column: TableColumn, quantity: Quantity) -> TableColumn:
    unit = column.unit.format(q=quantity).strip()
    return replace(column, title=column.title.format(q=quantity), unit=unit)


def _estimate(value: float) -> str:
    """Format the estimate for a stimulus level of 1, possibly far below the presented levels."""
    return significant(value) if 0 < value < SMALLEST_OF_TWO_DECIMALS else grouped(value, 1)


#: Heading of a column, and function that formats the column's cell in a row, keyed by column of
#: `analysis.reporting.individuals`; ``q`` in headings is a placeholder for the quantity.
OWN_COLUMNS: dict[str, tuple[TableColumn, Callable[[Row], str]]] = {
    "exponent": (TableColumn(title="Exponent"), lambda row: grouped(row["exponent"])),
    "estimate_at_1_level": (
        TableColumn(title="Power function", unit="at 1 {q.unit} {q.short_convention}"),
        lambda row: _estimate(row["estimate_at_1_level"]),
    ),
    "growth_function": (
        TableColumn(title="Favoured", left=True),
        lambda row: row["growth_function"] if isinstance(row["growth_function"], str) else DASH,
    ),
    "hits": (
        TableColumn(title="“{q.yes}”", unit="{q.yes_no.down[1]}"),
        lambda row: _of(row, "hits", "changes"),
    ),
    "false_alarms": (
        TableColumn(title="“{q.yes}”", unit="{q.yes_no.catch[1]}"),
        lambda row: _of(row, "false_alarms", "catches"),
    ),
    "d_prime": (TableColumn(title="d′"), lambda row: grouped(row["d_prime"])),
    "criterion": (TableColumn(title="c"), lambda row: grouped(row["criterion"])),
}


def _counted(analysis: Analysis) -> list[str]:
    counts, words, texts = analysis.dataset.counts, analysis.dataset.quantity.yes_no, []
    for trials in (kind.trials for kind in analysis.kinds if kind.trials):
        if read := counts.get(f"{trials.counted}_rows"):
            listed = ", ".join(trials.counted_left_out(counts)).replace(f" of {trials.title}", "")
            title = words.task if trials is DIFFERENCES else trials.title
            texts.append(
                f"{capitalised(title)}: {grouped(read, 0)} rows were read; "
                + (f"not analysed: {listed}." if listed else "all were analysed.")
            )
    if again := counts.get("faulty"):
        texts.append(
            f"Trials in which a surface was presented again after a fault or a pause: {again}."
        )
    return texts


def _measure(analysis: Analysis, who: str, name: str) -> str:
    return f"{analysis.measures[name].loc[who]:.3g}"


def _with_and_without(analysis: Analysis) -> Markup:
    amplitudes, value = list(analysis.robustness[0].means), analysis.dataset.quantity.value
    return html.table(
        html.columns(
            "Participants",
            "n",
            *(("Mean", value(a)) for a in amplitudes),
            "Exponent",
            "Interval",
            "Friedman χ²",
            left=1,
        ),
        [_subset(subset, amplitudes) for subset in analysis.robustness],
        "Main results with and without flagged participants.",
    )


def _subset(subset: SubsetSummary, amplitudes: Sequence[float]) -> list[str]:
    law, friedman = computed(subset.power_law), computed(subset.friedman)
    return [
        subset.participants,
        str(subset.n),
        *(grouped(subset.means.get(amplitude)) for amplitude in amplitudes),
        grouped(law.exponent if law else None),
        interval(*(law.interval if law else (None, None))),
        grouped(friedman.chi2 if friedman else None),
    ]
