"""Implement `slipscale reconstruct`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from slipscale.analysis.cli.progress_line import telling
from slipscale.faults import ANSWER_IS_NO, DONE, UserError

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.answers import Across
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
    from slipscale.analysis.reconstruction.inference.printed_test_answer import PrintedTestAnswer
    from slipscale.analysis.reconstruction.table.published_table import Design
    from slipscale.analysis.reconstruction.table.table_files import PublishedTable


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `slipscale reconstruct`."""
    parser.add_argument(
        "table",
        type=Path,
        help=("TOML or CSV file, or name of a shipped table, such as biet2007_table3"),
    )
    parser.add_argument(
        "--sample",
        type=int,
        metavar="N",
        help="draw N random data sets per column, all equally likely, and print them as CSV",
    )
    parser.add_argument(
        "--long",
        action="store_true",
        help="with --sample: write one rating per row instead of one data set per row",
    )
    parser.add_argument("--seed", type=int, default=1, help="random seed (default: 1)")
    parser.add_argument(
        "--measure",
        choices=("multisets", "ordered"),
        default="multisets",
        help="whether all multisets of ratings are equally likely (default), or all assignments "
        "of ratings to participants",
    )
    parser.add_argument(
        "--variants",
        action="store_true",
        help="also report results under all SD conventions and rounding rules",
    )
    parser.add_argument(
        "--conclusions",
        action="store_true",
        help="compare columns: report which conclusions hold in all data sets and pairings, which "
        "depend on the data set, and the distributions of F, Friedman's chi-square, t and "
        "exponents",
    )
    parser.add_argument(
        "--design",
        choices=("paired", "independent"),
        help=(
            "with --conclusions: whether columns come from the same participants (default: as in "
            "the file)"
        ),
    )
    parser.add_argument(
        "--batch",
        action="store_true",
        help="check each row of TABLE, a CSV with rows from any number of tables: write one "
        "verdict per row to --out, and resume an interrupted run",
    )
    parser.add_argument(
        "--workers",
        type=int,
        default=1,
        metavar="N",
        help=("number of processes for --batch (default: 1)"),
    )
    parser.add_argument(
        "--html",
        type=Path,
        metavar="FILE",
        help="also write a self-contained page with figures and samples",
    )
    parser.add_argument("--json", action="store_true", help=("print JSON, with counts as strings"))
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help=("file to write instead of standard output")
    )
    parser.add_argument(
        "--memory-gib",
        type=float,
        default=4.0,
        metavar="GIB",
        help="memory limit for counting or sampling (default: 4); with --batch, per process",
    )
    parser.add_argument(
        "--minutes",
        type=float,
        default=0.1,
        metavar="MIN",
        help="limit on the estimated time in minutes for counting one column (default: 0.1)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Report on all columns; return 1 if any column or published test is impossible."""
    # Imported here so that --help does not import NumPy.
    if arguments.batch:
        from slipscale.analysis.cli.reconstruct_batch import run_batch

        return run_batch(arguments)
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
    from slipscale.analysis.reconstruction.table.table_files import read

    _check(arguments)
    table = read(arguments.table)
    if table.intervals:
        return _answer_intervals(table, arguments)
    design = arguments.design or table.design
    if arguments.conclusions and design is None:
        raise UserError(
            '--conclusions needs the design: set design = "paired" (the same participants in '
            'every column) or "independent" (different participants) in the file, or use '
            "--design"
        )
    columns = [
        Solutions(column, arguments.memory_gib, arguments.minutes) for column in table.columns
    ]
    if arguments.sample is not None:
        _announce(columns)
        _sample(columns, arguments)
        return _status(columns, [each for each in columns if each.refused])
    if _answer(table, columns, design, arguments):
        return ANSWER_IS_NO
    return _status(columns, [each for each in columns if each.refused and not each.witness])


def _answer_intervals(table: PublishedTable, arguments: argparse.Namespace) -> int:
    """Report on columns with continuous values, for which data sets cannot be counted."""
    import json

    from slipscale.analysis.reconstruction import report
    from slipscale.analysis.reconstruction.inference.interval_tests import answer

    for name in ("sample", "variants", "conclusions", "html"):
        if getattr(arguments, name):
            raise UserError(
                "--{name} requires a finite number of data sets, but continuous values or "
                "logarithms, as in {table}, allow infinitely many: omit this option",
                name=name,
                table=arguments.table,
            )
    tests = [answer(test, table.intervals) for test in table.tests]
    with _output(arguments.out) as file:
        if arguments.json:
            written = {
                "title": table.title,
                "intervals": [report.interval_json(column) for column in table.intervals],
                "tests": report.printed_tests_json(tests),
            }
            print(json.dumps(written, indent=2), file=file)
        else:
            lines = [table.title or "published table", "", *report.printed_test_lines(tests)]
            for column in table.intervals:
                lines += [*report.interval_lines(column), ""]
            print("\n".join(lines), file=file)
    wrong = any(column.reason for column in table.intervals)
    return ANSWER_IS_NO if wrong or any(t.verdict == "impossible" for t in tests) else DONE


# Shortest estimated duration of a computation that is announced, in seconds.
WORTH_SAYING_S = 5.0


def _announce(columns: list[Solutions]) -> None:
    """Print the expected duration and memory of long computations to stderr."""
    from slipscale.analysis.reconstruction.counts.problem import duration, seconds_to_count

    for solutions in columns:
        if solutions.refused:
            continue
        seconds = seconds_to_count(solutions.problems)
        if seconds > WORTH_SAYING_S:
            gib = max(task.count_bytes for task in solutions.problems) / 2**30
            print(
                f"column '{solutions.column.label}': counting takes {duration(seconds)} and "
                f"{gib:.1f} GiB",
                file=sys.stderr,
            )


def _check(arguments: argparse.Namespace) -> None:
    """Reject arguments that contradict each other or are out of range."""
    if arguments.seed < 0:
        raise UserError("--seed {seed}: expected 0 or more", seed=arguments.seed)
    if arguments.sample is None:
        if arguments.long:
            raise UserError(
                "--long applies only to the data sets written by --sample; add --sample N"
            )
        return
    if arguments.sample < 1:
        raise UserError("--sample {sample}: expected 1 or more", sample=arguments.sample)
    for name, writes in (
        ("html", "a page that contains samples"),
        ("json", "the counts and tests"),
        ("conclusions", "a report"),
    ):
        if getattr(arguments, name):
            raise UserError(
                "--sample and --{name} cannot be combined, because --{name} writes {writes}; "
                "expected one of them",
                name=name,
                writes=writes,
            )


def _answer(
    table: PublishedTable,
    columns: list[Solutions],
    design: Design | None,
    arguments: argparse.Namespace,
) -> bool:
    """Write the results for published tests and for columns.

    Return whether any published test is impossible.
    """
    import json

    from slipscale.analysis.reconstruction import answers, report

    with _output(arguments.out) as file:

        def say(lines: list[str]) -> None:
            if not arguments.json:
                print("\n".join(lines), file=file, flush=True)

        say([table.title or "published table", ""])
        tests = _tests(table, columns)
        say(report.printed_test_lines(tests))
        _announce(columns)
        found = []
        with telling() as tell:
            for place, solutions in enumerate(columns, start=1):
                tell(f"column '{solutions.column.label}', {place} of {len(columns)}")
                found.append(
                    answers.column_answer(solutions, arguments.measure, variants=arguments.variants)
                )
                say([*report.column_lines(found[-1]), ""])
        known = _known_across(columns, design, arguments) if arguments.conclusions else None
        if known is not None:
            say(report.across_lines(known))
        say(report.verdict_lines(found, tests))
        if arguments.json:
            written = {
                "title": table.title,
                "measure": arguments.measure,
                "columns": [report.column_json(one) for one in found],
            }
            if table.tests:
                written["tests"] = report.printed_tests_json(tests)
            if known is not None:
                written["conclusions"] = report.across_json(known)
            print(json.dumps(written, indent=2), file=file)
    if arguments.html:
        from slipscale.analysis.reconstruction_page.page import Source, render

        source = Source(
            title=table.title,
            columns=tuple(zip(columns, found, strict=True)),
            tests=tuple(tests),
            across=known,
            measure=arguments.measure,
            seed=arguments.seed,
        )
        with _output(arguments.html) as file:
            file.write(render(source))
    return any(one.verdict == "impossible" for one in tests)


def _tests(table: PublishedTable, columns: list[Solutions]) -> list[PrintedTestAnswer]:
    """Return a verdict for each test published with the table."""
    if not table.tests:
        return []
    from slipscale.analysis.reconstruction.inference.printed_test_answers import answer

    return [answer(test, columns) for test in table.tests]


def _known_across(
    columns: list[Solutions], design: Design | None, arguments: argparse.Namespace
) -> Across | None:
    """Compare the columns; return None if the design is unknown or fewer than two are usable."""
    usable = [
        s for s in columns if (s.targets.wanted and s.witness) or (not s.refused and s.consistent)
    ]
    return _across(usable, design, arguments) if design and len(usable) > 1 else None


def _across(columns: list[Solutions], design: Design, arguments: argparse.Namespace) -> Across:
    from slipscale.analysis.reconstruction.answers import across, seconds_across
    from slipscale.analysis.reconstruction.counts.problem import duration

    seconds = seconds_across(columns, design)
    if seconds > WORTH_SAYING_S:
        print(f"conclusions across columns take {duration(seconds)}", file=sys.stderr)
    with telling() as tell:
        return across(columns, design, arguments.measure, arguments.seed, tell)


def _sample(columns: list[Solutions], arguments: argparse.Namespace) -> None:
    """Write sample data sets of each usable column, and report why other columns have none."""
    usable = _usable(columns)
    for solutions in columns:
        if solutions not in usable:
            why = solutions.not_drawn or solutions.reason
            print(f"column '{solutions.column.label}': no samples: {why}", file=sys.stderr)
    if usable:
        with _output(arguments.out) as file:
            _write_samples(columns, usable, arguments, file)


def _usable(columns: list[Solutions]) -> list[Solutions]:
    """Return the columns whose data sets can be sampled."""
    return [solutions for solutions in columns if not solutions.not_drawn and solutions.consistent]


def _status(columns: list[Solutions], unanswered: list[Solutions]) -> int:
    """Return the exit status: 1 if a column is inconsistent, otherwise 0.

    Raises
    ------
    UserError
        If no column is inconsistent, but some are ``unanswered`` because their data sets could not
        be counted. This error is raised after all answers have been written.
    """
    if not all(solutions.refused or solutions.consistent for solutions in columns):
        return ANSWER_IS_NO
    if unanswered:
        labels = ", ".join(f"'{solutions.column.label}'" for solutions in unanswered)
        raise UserError(
            "column {labels} not counted: {reason}", labels=labels, reason=unanswered[0].refused
        )
    return DONE


def _write_samples(
    columns: list[Solutions],
    usable: list[Solutions],
    arguments: argparse.Namespace,
    file: TextIO,
) -> None:
    """Write samples as CSV: one data set per row, or one rating per row if --long is given."""
    import csv

    import numpy as np

    from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
    from slipscale.faults.spreadsheet_cells import harmless_cell

    # Checks all columns before the first row is written.
    samplers = {
        place: Sampler(solutions, arguments.measure)
        for place, solutions in enumerate(columns)
        if solutions in usable
    }
    writer = csv.writer(file, lineterminator="\n")
    most = max(solutions.column.n for solutions in usable)
    ratings = [f"rating_{i}" for i in range(1, most + 1)]
    writer.writerow(["column", "sample", *(["place", "rating"] if arguments.long else ratings)])
    for place, sampler in samplers.items():
        column = sampler.solutions.column
        label = harmless_cell(column.label)
        names = [f"{float(column.scale.value(v)):.10g}" for v in range(column.scale.steps + 1)]
        # The samples of a column do not depend on other columns.
        generator = np.random.default_rng([arguments.seed, place])
        number = 0
        for block in sampler.stream(arguments.sample, generator):
            for row in block.tolist():
                number += 1
                if arguments.long:
                    writer.writerows(
                        [label, number, at, names[v]] for at, v in enumerate(row, start=1)
                    )
                else:
                    writer.writerow([label, number, *(names[v] for v in row)])


@contextmanager
def _output(path: Path | None) -> Iterator[TextIO]:
    if path is None:
        yield sys.stdout
        return
    try:
        file = path.open("w", encoding="utf-8", newline="")
    except OSError as error:
        raise UserError(
            "{path}: cannot be written ({reason})", path=path, reason=error.strerror
        ) from None
    with file:
        yield file


COMMANDS = {"reconstruct": (add_arguments, run)}
