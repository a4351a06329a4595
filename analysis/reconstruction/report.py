"""Format the output of `slipscale reconstruct` as text and JSON."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from itertools import groupby
from math import isfinite
from typing import TYPE_CHECKING

from slipscale.analysis.reconstruction.counts.listing import LISTED
from slipscale.analysis.reconstruction.data_sets.saddle_point import words

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.answers import Across, ColumnAnswer, Variant
    from slipscale.analysis.reconstruction.inference.conclusions import Conclusion
    from slipscale.analysis.reconstruction.inference.distributions import Distribution
    from slipscale.analysis.reconstruction.inference.printed_test_answer import PrintedTestAnswer
    from slipscale.analysis.reconstruction.table.interval_column import IntervalColumn

# Maximum number of distinct ratings to print per data set.
SHOWN_VALUES = 20
# Maximum number of pairs of sum and sum of squares to print. JSON contains all pairs.
SHOWN_SUMS = 12
# Terms in JSON, which are also used in the documentation.
Json = dict[str, object]


def column_json(answer: ColumnAnswer) -> Json:
    """Convert the results for one column to JSON data, with counts as strings."""
    written: Json = {
        "label": answer.label,
        "printed": answer.printed,
        "consistent": answer.consistent,
        "reason": answer.reason,
        "multisets": None if answer.multisets is None else str(answer.multisets),
        "ordered": None if answer.ordered is None else str(answer.ordered),
        "sd_convention": answer.sd_convention,
        "rounding": answer.rounding,
        "grim": answer.grim,
        "grimmer": answer.grimmer,
        "scale_is_printed": answer.scale_is_printed,
        "assumptions": list(answer.assumptions),
        "sums": [{"sum": str(s), "sum_of_squares": str(q)} for s, q in answer.sums],
    }
    if answer.refused:
        written["refused"] = answer.refused
        written["witness"] = list(answer.witness)
        written["log10_estimate"] = answer.log10_estimate
    if answer.not_drawn:
        written["not_drawn"] = answer.not_drawn
    if answer.order_statistics:
        written["order_statistics"] = [asdict(row) for row in answer.order_statistics]
    if answer.variants:
        written["variants"] = [_variant_json(variant) for variant in answer.variants]
    return written


def _variant_json(variant: Variant) -> Json:
    return {
        "sd_convention": variant.sd_convention,
        "rounding": variant.rounding,
        "consistent": None if variant.multisets is None else variant.multisets > 0,
        "reason": variant.reason,
        "multisets": None if variant.multisets is None else str(variant.multisets),
    }


def across_json(answer: Across) -> Json:
    """Convert the results of comparing columns to JSON data, with null for infinity."""
    return {
        "always": [_finite(asdict(found)) for found in answer.bounds if found.decided],
        "depends": [_finite(asdict(found)) for found in answer.bounds if not found.decided],
        "not_listed": list(answer.not_listed),
        "distributions": [
            _finite(asdict(found))
            | {"quantiles": [[p, _finite_or_none(v)] for p, v in found.quantiles]}
            for found in answer.distributions
        ],
    }


def printed_tests_json(found: Sequence[PrintedTestAnswer]) -> list[Json]:
    """Convert the verdicts on published tests to JSON data."""
    return [_finite(asdict(one)) for one in found]


def printed_test_lines(found: Sequence[PrintedTestAnswer]) -> list[str]:
    """Format the verdicts on published tests as lines of text."""
    lines = ["Published tests"] if found else []
    for one in found:
        lines.append(f"  {one.question}: {one.printed}: {one.verdict}")
        lines += [f"    {line}" for line in printed_test_details(one)]
    return [*lines, ""] if lines else []


def verdict(columns: Sequence[ColumnAnswer], tests: Sequence[PrintedTestAnswer]) -> str:
    """Summarise the verdicts on all columns and tests in a few sentences."""
    none = [answer.label for answer in columns if answer.consistent is False]
    unknown = [answer.label for answer in columns if answer.consistent is None]
    sentence = f"No ratings give the published {_listed('column', none)}." if none else ""
    if not none and not unknown:
        sentence = "Every published column is possible."
    if unknown:
        sentence += (
            " It could not be determined whether any ratings give the published "
            f"{_listed('column', unknown)}."
        )
    wrong = [one for one in tests if one.verdict == "impossible"]
    open_ = sum(one.verdict == "not decided" for one in tests)
    if wrong:
        named = "; ".join(f"{one.question}, {one.printed}" for one in wrong)
        sentence += f" {len(wrong)} of {len(tests)} published tests are impossible: {named}."
    elif tests and not open_:
        sentence += " Every published test is possible."
    if open_:
        sentence += f" {open_} of {len(tests)} published tests were not decided."
    return sentence.strip()


def _listed(noun: str, labels: Sequence[str]) -> str:
    return f"{noun}{'s' if len(labels) > 1 else ''} {', '.join(repr(label) for label in labels)}"


def verdict_lines(columns: Sequence[ColumnAnswer], tests: Sequence[PrintedTestAnswer]) -> list[str]:
    """Format the overall verdict for the terminal."""
    return [f"Verdict: {verdict(columns, tests)} (under the assumptions listed above)"]


def printed_test_details(one: PrintedTestAnswer) -> Iterator[str]:
    """Yield the evidence for the verdict on a published test."""
    yield one.reason
    if isfinite(one.low):
        high = outward(one.high, down=False)
        low = outward(one.low, down=True)
        extent = f"between {low} and {high}" if isfinite(one.high) else f"at least {low}"
        yield f"the value is {extent} for every data set and pairing"
    if one.pairs is not None:
        yield (
            f"{one.pairs_left:,} of {one.pairs:,} combinations of sums and sums of squares can "
            "give the published value"
        )
    if one.correlation_low is not None:
        yield (
            f"the published value requires a correlation of {one.correlation_low:.3f} to "
            f"{one.correlation_high:.3f}"
        )
    if one.example:
        yield f"obtained with {ratings(one.labels, one.example)}"


def interval_json(column: IntervalColumn) -> Json:
    """Convert the results for a column of continuous values to JSON data."""
    return {
        "label": column.label,
        "printed": column.printed,
        "consistent": not column.reason,
        "reason": column.reason,
        "logarithms": column.logarithms,
        "mean": [_finite_or_none(end) for end in column.mean],
        "sd": list(column.sd),
        "assumptions": list(column.assumptions()),
    }


def interval_lines(column: IntervalColumn) -> Iterator[str]:
    """Yield lines of text about a column of continuous values."""
    yield column.label
    yield f"  printed: {column.printed}"
    yield f"  assumed: {'; '.join(column.assumptions())}"
    if column.reason:
        yield f"  inconsistent: {column.reason}"
        return
    of = "natural logarithms" if column.logarithms else "the values"
    mean, sd = (_join(*(f"{end:.5g}" for end in ends)) for ends in (column.mean, column.sd))
    yield f"  mean of {of}: {mean}; SD: {sd}"


def _finite(entry: Json) -> Json:
    return {key: _finite_or_none(value) for key, value in entry.items()}


def _finite_or_none(value: object) -> object:
    return None if isinstance(value, float) and not isfinite(value) else value


def column_lines(answer: ColumnAnswer) -> Iterator[str]:
    """Yield lines of text about a column of discrete ratings."""
    yield f"{answer.label}  ({answer.sd_convention} SD, rounding: {answer.rounding})"
    yield f"  printed: {answer.printed}"
    yield f"  assumed: {'; '.join(answer.assumptions)}"
    if answer.multisets is None:
        yield from _uncounted_lines(answer)
    elif answer.multisets:
        yield f"  multisets        {answer.multisets:,}"
        if answer.ordered is None:
            why = answer.not_drawn or "counting would take too long; use --measure ordered"
            yield f"  ordered samples  not counted, {why}"
        else:
            yield f"  ordered samples  {answer.ordered:,}"
        pairs = "; ".join(f"{s}, {q}" for s, q in answer.sums[:SHOWN_SUMS])
        more = len(answer.sums) - SHOWN_SUMS
        yield f"  possible pairs of sum and sum of squares: {pairs}" + (
            f"; and {more} more pairs" if more > 0 else ""
        )
    else:
        yield f"  inconsistent: {answer.reason}"
    if answer.order_statistics:
        ranges = (f"{row.minimum:g}-{row.maximum:g}" for row in answer.order_statistics)
        yield f"  sorted ratings, range over all data sets: {'  '.join(ranges)}"
    for variant in answer.variants:
        verdict = f"{variant.multisets:,} multisets" if variant.multisets else variant.reason
        if variant.multisets is None:
            verdict = f"not counted: {variant.reason}"
        yield f"    {variant.sd_convention:<10} {variant.rounding:<10} {verdict}"


def _uncounted_lines(answer: ColumnAnswer) -> Iterator[str]:
    yield f"  not counted: {answer.refused}"
    yield "  GRIM and GRIMMER: passed"
    if answer.log10_estimate is not None:
        yield f"  multisets        {words(answer.log10_estimate)} (saddle-point estimate)"
    if answer.witness:
        often = Counter(answer.witness)
        shown = ", ".join(f"{value:g} ({often[value]})" for value in sorted(often)[:SHOWN_VALUES])
        more = " ..." if len(often) > SHOWN_VALUES else ""
        yield f"  one verified data set, as rating (frequency): {shown}{more}"
    else:
        yield "  a short search found no data set, which does not prove that there is none"


def across_lines(answer: Across) -> list[str]:
    """Format the results across columns as lines of text."""
    lines = []
    for decided, heading in (
        (True, "Answers that are the same in every data set and pairing"),
        (False, "Answers that depend on the data set or the pairing"),
    ):
        if found := [bound for bound in answer.bounds if bound.decided is decided]:
            lines += [heading, *(line for bound in found for line in _bound_lines(bound)), ""]
    if answer.not_listed:
        named = ", ".join(answer.not_listed)
        bounds = "these bounds use only sums and sums of squares"
        lines += [f"Too many multisets to list (limit: {LISTED:,}) for {named}: {bounds}", ""]
    if not answer.distributions:
        return lines
    first = answer.distributions[0]
    lines.append(
        f"Over {first.samples:,} uniform samples ({first.measure}, seed {first.seed}), by pairing: "
        "median, 2.5 % and 97.5 % quantile, proportion with p < 0.05"
    )
    for question, rows in groupby(answer.distributions, key=lambda row: row.question):
        lines += [f"  {question}", *map(_distribution, rows)]
    return [*lines, ""]


def _bound_lines(found: Conclusion) -> Iterator[str]:
    yield _bound(found)
    ends = ((found.low, found.at_low), (found.high, found.at_high))
    for value, table in ends[:1] if found.low == found.high else ends:
        if table:
            yield f"    {_number(value)} with {ratings(found.labels, table)}"


def ratings(labels: Sequence[str], table: Sequence[Sequence[float]]) -> str:
    """Format a table as text, with the ratings of each column in the same order of participants."""
    return "; ".join(
        f"{label}: {' '.join(f'{v:g}' for v in row)}"
        for label, row in zip(labels, table, strict=True)
    )


def _bound(found: Conclusion) -> str:
    sharp = "" if found.sharp else " (bounds, perhaps not attained)"
    extent = _join(outward(found.low, down=True), outward(found.high, down=False))
    p = ""
    if found.p_low is not None and found.p_high is not None:
        p = ", p " + _join(f"{found.p_low:.2g}", f"{found.p_high:.2g}")
    return f"  {found.question}: {extent}{p}{sharp}"


def _distribution(row: Distribution) -> str:
    at = dict(row.quantiles)
    share = "" if row.significant is None else f"{row.significant:.1%}"
    values = "".join(f"{_number(at[q]):>9}" for q in (0.5, 0.025, 0.975))
    return f"    {row.pairing:<17}{values}{share:>9}  {row.method}"


def _join(low: str, high: str) -> str:
    return low if low == high else f"{low} to {high}"


def _number(value: float) -> str:
    return f"{value:.4g}" if isfinite(value) else "infinite"


def outward(value: float, *, down: bool) -> str:
    """Round a bound outwards to four digits, so that it remains valid.

    >>> outward(80.99895, down=True), outward(4.1601, down=False), outward(-1.23451, down=True)
    ('80.99', '4.161', '-1.235')
    """
    if not isfinite(value) or not value:
        return _number(value)
    exact = Decimal(value)
    unit = Decimal(1).scaleb(exact.adjusted() - 3)
    # Floating-point errors must not round a whole number to the next one.
    near = round(exact / unit)
    rounding = ROUND_FLOOR if down else ROUND_CEILING
    steps = Decimal(near) if abs(exact / unit - near) < Decimal("1e-6") else exact / unit
    rounded = steps.to_integral_value(rounding) * unit
    whole = rounded == rounded.to_integral_value()
    return f"{rounded.to_integral_value() if whole else rounded:f}"
