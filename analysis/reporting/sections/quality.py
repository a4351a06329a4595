"""Who was flagged, who was excluded, and the results without them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pandas as pd

from analysis.preprocessing import data_quality as quality_rules
from analysis.reporting import html
from analysis.reporting.html import Column, Section, interval, number
from experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from analysis.result import Analysis

#: Longer lists of participants are in quality.csv.
PARTICIPANTS_SHOWN = 60


def quality(analysis: Analysis) -> Section:
    """Return flags, exclusions and the results without the flagged."""
    section = Section("Participants and data quality")
    data, counts = analysis.dataset, analysis.dataset.counts
    section.blocks += [html.paragraph(text) for text in _counted(counts)]
    rules = ", ".join(data.choices.exclusions)
    section.blocks.append(
        html.paragraph(
            f"Exclusion rule of the study file: {rules}. Excluded before anything was described: "
            + (
                "; ".join(f"{who} ({', '.join(why)})" for who, why in analysis.excluded.items())
                or "nobody"
            )
            + "."
            if rules
            else "The study file sets no exclusion: nobody was excluded. Flags inform, they never "
            "exclude by themselves."
        )
    )
    flags = analysis.flags
    flagged = flags[flags.any(axis=1)]
    rows = [
        [
            str(who),
            "; ".join(
                f"{name.replace('_', ' ')} ({_measure(analysis, who, name)})"
                for name in flags.columns
                if row[name]
            ),
            "excluded" if str(who) in analysis.excluded else "kept",
        ]
        for who, row in flagged.iloc[:PARTICIPANTS_SHOWN].iterrows()
    ]
    if rows:
        meanings = "; ".join(
            f"{name.replace('_', ' ')}: {quality_rules.MEANINGS[name]}"
            for name in flags.columns
            if flagged[name].any()
        )
        more = len(flagged) - len(rows)
        section.blocks.append(
            html.table(
                [
                    Column(title="Participant", left=True),
                    Column(title="Flags (measure)", left=True),
                    Column(title="Analysis", left=True),
                ],
                rows,
                f"Flagged: {len(flagged)} of {len(flags)} participants. {meanings}."
                + (f" {more} more are in quality.csv." if more else ""),
            )
        )
    else:
        section.blocks.append(html.paragraph("No participant carries a flag."))
    if len(analysis.robustness) > 1:
        section.blocks.append(_with_and_without(analysis))
    section.blocks += _each(analysis)
    return section


def _each(analysis: Analysis) -> list[Any]:
    """Return the table of participants' own exponents and sensitivities, where there are any."""
    own = analysis.individuals
    if not len(own):
        return []
    known = {name: column for name, column in OWN_COLUMNS.items() if name in own}
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
            [Column(title="Participant", left=True), *(column for column, _ in known.values())],
            rows,
            "Each participant. Exponents rest on few amplitudes and are descriptive"
            + ("; d′ and c after the log-linear correction." if "d_prime" in known else ".")
            + (f" {more} more are in individuals.csv." if more > 0 else ""),
        )
    ]


def _of(row: pd.Series[Any], part: str, whole: str) -> str:
    return "–" if pd.isna(row[part]) else f"{row[part]:.0f} of {row[whole]:.0f}"


#: Column of `analysis.statistics.individuals` -> its heading, and how a row's cell is written.
OWN_COLUMNS: dict[str, tuple[Column, Callable[[pd.Series[Any]], str]]] = {
    "exponent": (Column(title="Exponent"), lambda row: number(row["exponent"])),
    "estimate_at_1_um": (
        Column(title="Estimate", unit="at 1 µm p-p"),
        lambda row: number(row["estimate_at_1_um"], 1),
    ),
    "growth_function": (
        Column(title="Favoured", left=True),
        lambda row: row["growth_function"] if isinstance(row["growth_function"], str) else "–",
    ),
    "hits": (Column(title="“Yes”", unit="steps"), lambda row: _of(row, "hits", "changes")),
    "false_alarms": (
        Column(title="“Yes”", unit="catch steps"),
        lambda row: _of(row, "false_alarms", "catches"),
    ),
    "d_prime": (Column(title="d′"), lambda row: number(row["d_prime"])),
    "criterion": (Column(title="c"), lambda row: number(row["criterion"])),
}


def _counted(counts: Mapping[str, int]) -> list[str]:
    """Say how many rows were read and left out, task by task."""
    texts = []
    if counts.get("estimation_rows"):
        texts.append(
            f"{number(counts['estimation_rows'], 0)} rows of magnitude estimation were read. Never "
            f"analysed: {counts['practice']} practice, {counts['voided']} voided. Main trials "
            f"without a usable answer: {counts['unanswered']} ({counts['timed_out']} timed out); "
            f"presented again after a fault or a pause: {counts['faulty']}."
        )
    if counts.get("difference_rows"):
        texts.append(
            f"{number(counts['difference_rows'], 0)} rows of the descending difference were read. "
            f"Never analysed: {counts['difference_practice']} practice, "
            f"{counts['difference_voided']} voided. Steps without a usable answer: "
            f"{counts['difference_unanswered']}."
        )
    return texts


def _measure(analysis: Analysis, who: Any, name: str) -> str:
    return f"{float(analysis.measures.loc[who, name]):.3g}"


def _with_and_without(analysis: Analysis) -> Any:
    amplitudes = list(analysis.robustness[0]["means"])
    return html.table(
        [
            Column(title="Participants", left=True),
            Column(title="n"),
            *(Column(title="Mean", unit=f"{a} µm") for a in amplitudes),
            Column(title="Exponent"),
            Column(title="Interval"),
            Column(title="Friedman χ²"),
        ],
        [
            [
                row["participants"],
                str(row["n"]),
                *(number(row["means"].get(a)) for a in amplitudes),
                number(row["exponent"]),
                interval(*(row["exponent_ci"] or (None, None))),
                number(row["friedman_chi2"]),
            ]
            for row in analysis.robustness
        ],
        "The chief results with and without flagged participants.",
    )
