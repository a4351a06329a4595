"""Render the results for a published table as a self-contained HTML page."""

from __future__ import annotations

import csv
import io
from base64 import b64encode
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.report import (
    column_lines,
    outward,
    printed_test_details,
    ratings,
    verdict,
)
from slipscale.analysis.reconstruction_page.distributions import cumulative, histogram
from slipscale.analysis.reconstruction_page.figures import cumulative_figure, histogram_figure
from slipscale.analysis.writing import html
from slipscale.faults.spreadsheet_cells import harmless_cell
from slipscale.figure_style import svg

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.answers import Across, ColumnAnswer
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
    from slipscale.analysis.reconstruction.inference.conclusions import Conclusion
    from slipscale.analysis.reconstruction.inference.distributions import Distribution
    from slipscale.analysis.reconstruction.inference.printed_test_answer import PrintedTestAnswer

# Number of data sets per column for histograms, and number included in the page for download.
DRAWN = 2000
WITH_THE_PAGE = 100


@dataclass(frozen=True, kw_only=True)
class Source:
    """Content of the page.

    Parameters
    ----------
    title : str
        Title of the table.
    columns : sequence of (Solutions, ColumnAnswer)
        Columns, each with its results.
    tests : sequence of PrintedTestAnswer
        Verdicts on the published tests.
    across : Across or None
        Results across columns, if they were requested.
    measure, seed : str, int
        Measure (multisets or ordered samples) and random seed for drawing samples.
    """

    title: str
    columns: Sequence[tuple[Solutions, ColumnAnswer]]
    tests: Sequence[PrintedTestAnswer]
    across: Across | None
    measure: str
    seed: int


def render(source: Source) -> str:
    """Return the HTML text of the page."""
    sections = [_verdict(source)]
    sections += [_column(source, place) for place in range(len(source.columns))]
    if source.tests:
        sections.append(_printed_tests(source.tests))
    if source.across is not None:
        sections.append(_across(source.across))
    if samples := long_samples(source):
        sections.append(_samples(samples))
    return html.page(
        "page.html",
        "slipscale.analysis.reconstruction_page",
        title=source.title or "Published table",
        facts=_facts(source),
        sections=sections,
    )


def _facts(source: Source) -> list[tuple[str, str]]:
    answers = [answer for _, answer in source.columns]
    none = [answer.label for answer in answers if answer.consistent is False]
    impossible = sum(one.verdict == "impossible" for one in source.tests)
    tests = [("Impossible tests", f"{impossible} of {len(source.tests)}")] if source.tests else []
    return [
        ("Columns", str(len(answers))),
        ("Columns without any data set", ", ".join(none) or "none"),
        *tests,
        ("Equally likely", source.measure),
        ("Random seed for the samples", str(source.seed)),
    ]


def _drawn(source: Source, place: int, number: int) -> Array | None:
    solutions, _ = source.columns[place]
    if solutions.not_drawn or not solutions.consistent:
        return None
    # As with `--sample`, the samples of a column do not depend on other columns.
    return Sampler(solutions, source.measure).draw(
        number, np.random.default_rng([source.seed, place])
    )


def _column(source: Source, place: int) -> html.ReportSection:
    solutions, answer = source.columns[place]
    section = html.ReportSection(answer.label)
    # The heading already shows the label, and a table shows the sorted ratings.
    lines = (" ".join(line.split()) for line in list(column_lines(answer))[1:])
    convention = f"{answer.sd_convention} SD, rounding: {answer.rounding}"
    facts = [
        convention,
        *(line for line in lines if not line.startswith(("sorted ratings", "assumed"))),
    ]
    section.blocks.append(html.bullets(facts))
    samples = _drawn(source, place, DRAWN)
    if samples is None:
        return section
    up_to = cumulative(solutions, samples, source.measure)
    ends = _axis_ends(solutions, samples)
    over = "all data sets" if up_to.exact else f"{DRAWN:,} randomly selected data sets"
    section.blocks += [
        html.figure(
            svg(histogram_figure(histogram(solutions, samples), ends), salt=f"histogram{place}"),
            f"Number of participants (out of {solutions.column.n}) who gave each rating, in "
            f"{DRAWN:,} randomly selected data sets.",
            f"Histogram of the ratings at {answer.label}, with 95 % bands",
        ),
        html.figure(
            svg(cumulative_figure(up_to, ends), salt=f"cumulative{place}"),
            f"Proportion of ratings at or below each value, in {over}.",
            f"Cumulative distribution of the ratings at {answer.label}, with 95 % bands",
        ),
    ]
    if answer.order_statistics:
        section.blocks.append(
            html.table(
                html.columns("Rank", "Smallest", "Mean", "Largest"),
                [
                    (str(row.rank), f"{row.minimum:g}", f"{row.mean:.2f}", f"{row.maximum:g}")
                    for row in answer.order_statistics
                ],
                "Exact ranges of sorted ratings across all data sets; rank 1 is the smallest.",
            )
        )
    return section


def _axis_ends(solutions: Solutions, samples: Array) -> tuple[float, float]:
    """Return axis limits half a step beyond the scale or, without a scale, beyond the ratings."""
    column = solutions.column
    scale = column.scale
    first = int(samples.min()) if "minimum" in column.assumed else 0
    last = int(samples.max()) if "maximum" in column.assumed else scale.steps
    low, high = (
        float(scale.minimum) + float(scale.step) * step for step in (first - 0.5, last + 0.5)
    )
    return low, high


# Questions to the authors of an impossible table, starting with harmless causes.
ASK = (
    "Is n the number of ratings in each column, or are some ratings missing?",
    "What are the smallest and largest possible answers, and what is the step between answers?",
    "Is the published spread a sample SD, a population SD or a standard error?",
    "Were numbers truncated, or rounded more than once?",
    "Can the raw ratings be shared?",
)
MEANINGS = (
    (
        "GRIM",
        (
            "checks the mean: the mean of n integer ratings is always a multiple of 1/n (Brown and "
            "Heathers 2017)"
        ),
    ),
    (
        "GRIMMER",
        (
            "checks the SD: the sum of squares of integer ratings is always a whole number (Anaya "
            "2016)"
        ),
    ),
    (
        "Multisets",
        (
            "sets of ratings, in any order, that match all numbers published for a column; if "
            "there are none, the column is impossible"
        ),
    ),
)


def _verdict(source: Source) -> html.ReportSection:
    answers = [answer for _, answer in source.columns]
    section = html.ReportSection("Verdict", shown="always")
    section.blocks.append(html.paragraph(verdict(answers, source.tests)))
    section.blocks.append(html.heading("Assumptions"))
    labels: dict[str, list[str]] = {}
    for answer in answers:
        for assumption in answer.assumptions:
            labels.setdefault(assumption, []).append(answer.label)
    section.blocks.append(
        html.bullets(
            text if len(of) == len(answers) else f"{', '.join(of)}: {text}"
            for text, of in labels.items()
        )
    )
    wrong = any(answer.consistent is False for answer in answers) or any(
        one.verdict == "impossible" for one in source.tests
    )
    if wrong:
        section.blocks += [html.heading("Questions for the authors"), html.bullets(ASK)]
    section.blocks.append(html.details("Terms", [html.labelled(*meaning) for meaning in MEANINGS]))
    return section


def _printed_tests(found: Sequence[PrintedTestAnswer]) -> html.ReportSection:
    section = html.ReportSection("Published tests")
    section.blocks.append(
        html.table(
            html.columns("Test", "Published", "Verdict", left=3),
            [(one.question, one.printed, one.verdict) for one in found],
            "Whether each published test is possible, given all data sets and pairings.",
        )
    )
    details = [
        f"{one.question}: {'; '.join(line)}"
        for one in found
        if (line := list(printed_test_details(one)))
    ]
    section.blocks.append(html.bullets(details, "note"))
    return section


def _across(found: Across) -> html.ReportSection:
    section = html.ReportSection("Across columns")
    for decided, caption in (
        (True, "Answers that are the same in every data set and pairing."),
        (False, "Answers that depend on the data set or the pairing."),
    ):
        bounds = [bound for bound in found.bounds if bound.decided is decided]
        if bounds:
            section.blocks.append(
                html.table(
                    html.columns("Question", "Smallest", "Largest", "p", "Attained", left=1),
                    [_row(bound) for bound in bounds],
                    caption,
                )
            )
    attained = [line for bound in found.bounds for line in _attained(bound)]
    if attained:
        section.blocks += [
            html.heading("Tables that attain the bounds"),
            html.bullets(attained, "note"),
        ]
    if found.distributions:
        section.blocks.append(
            html.table(
                html.columns(
                    "Statistic", "Pairing", "Median", "2.5 %", "97.5 %", "p < 0.05", left=2
                ),
                [_distribution(row) for row in found.distributions],
                f"Distributions over {found.distributions[0].samples:,} uniform samples, by "
                "pairing. The last column is the proportion of samples with p < 0.05.",
            )
        )
    return section


def _distribution(row: Distribution) -> tuple[str, ...]:
    at = dict(row.quantiles)
    share = "" if row.significant is None else f"{row.significant:.1%}"
    values = (f"{at[q]:.4g}" for q in (0.5, 0.025, 0.975))
    return (row.question, row.pairing, *values, share)


def _row(bound: Conclusion) -> tuple[str, ...]:
    p = "" if bound.p_low is None else f"{bound.p_low:.2g} to {bound.p_high:.2g}"
    return (
        bound.question,
        outward(bound.low, down=True),
        outward(bound.high, down=False),
        p,
        "yes" if bound.sharp else "perhaps not",
    )


def _attained(bound: Conclusion) -> Iterator[str]:
    ends = ((bound.low, bound.at_low), (bound.high, bound.at_high))
    for value, table in ends[:1] if bound.low == bound.high else ends:
        if table:
            yield f"{bound.question}: {value:.4g} with {ratings(bound.labels, table)}"


def _samples(text: str) -> html.ReportSection:
    address = "data:text/csv;base64," + b64encode(text.encode()).decode()
    link = Markup('<p><a download="samples.csv" href="{}">samples.csv</a>: {}</p>').format(
        address,
        f"{WITH_THE_PAGE} data sets per column of the table, as a CSV file with one rating per "
        "row. The order of the ratings does not identify participants.",
    )
    return html.ReportSection("Samples", [link])


def long_samples(source: Source) -> str:
    """Return samples as CSV text with one rating per row, or "" without samples."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["column", "sample", "place", "rating"])
    rows = 0
    for place, (solutions, answer) in enumerate(source.columns):
        drawn = _drawn(source, place, WITH_THE_PAGE)
        if drawn is None:
            continue
        scale, label = solutions.column.scale, harmless_cell(answer.label)
        for number, row in enumerate(drawn.tolist(), start=1):
            for at, steps in enumerate(row, start=1):
                writer.writerow([label, number, at, f"{float(scale.value(steps)):.10g}"])
                rows += 1
    return out.getvalue() if rows else ""
