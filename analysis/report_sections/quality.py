"""Who was flagged, who was excluded, and the results without them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from analysis import html
from analysis import quality as quality_rules
from analysis.html import Column, Section, interval, number

if TYPE_CHECKING:
    from analysis.pipeline import Analysis

#: Longer lists of participants are in quality.csv.
PARTICIPANTS_SHOWN = 60


def quality(analysis: Analysis) -> Section:
    """Return flags, exclusions and the results without the flagged."""
    section = Section("Participants and data quality")
    data, counts = analysis.dataset, analysis.dataset.counts
    section.blocks.append(
        html.paragraph(
            f"{number(counts.get('estimation_rows', 0), 0)} rows of magnitude estimation were "
            f"read: {counts.get('practice', 0)} practice and {counts.get('voided', 0)} voided "
            f"trials are never analysed; {counts.get('unanswered', 0)} main trials have no usable "
            f"answer ({counts.get('timed_out', 0)} timed out); "
            f"{counts.get('faulty', 0)} were presented again after a fault or a pause."
        )
    )
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
                    Column(title="", left=True),
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
    return section


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
