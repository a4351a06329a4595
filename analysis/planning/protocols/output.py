"""Present a comparison of protocols as sentences, a table, a figure, CSV and JSON."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.analysis.planning.protocols.studies import EXPONENT
from slipscale.faults import UserError
from slipscale.figure_style import CYCLE, INK, canvas, save, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.analysis.planning.protocols.precision import ProtocolPrecision

HEAD = (
    *("quantity", "study", "protocol", "participants", "amount", "number", "trials", "minutes"),
    *("value", "half_width_percent", "error", "low", "high", "without", "studies"),
)


def ranked(found: Sequence[ProtocolPrecision]) -> list[ProtocolPrecision]:
    """Sort rows by quantity, number of participants, and decreasing precision."""
    return sorted(
        found,
        key=lambda row: (row.study.quantity, row.participants, _or_last(row.half_width_percent)),
    )


def _or_last(width: float) -> float:
    return width if math.isfinite(width) else math.inf


def _groups(
    found: Sequence[ProtocolPrecision],
) -> Iterator[tuple[str, int, list[ProtocolPrecision]]]:
    """Group comparable rows, which have the same quantity and number of participants."""
    for (quantity, size), rows in groupby(
        ranked(found), key=lambda row: (row.study.quantity, row.participants)
    ):
        yield quantity, size, list(rows)


def value_of(row: ProtocolPrecision) -> str:
    """Format the measured value with its unit."""
    unit = "" if row.study.quantity == EXPONENT else " µm"
    return f"{row.value:.3g}{unit}"


def sentences(found: Sequence[ProtocolPrecision], minutes: float, population: str) -> list[str]:
    """Describe the comparison and its conclusions."""
    lines = [
        (
            f"All studies have the same simulated people (population '{population}') and as many "
            f"trials as the median person completes in {minutes:.1f} minutes. Values are "
            "half-widths of the 95 % interval for the group value in % of this value; smaller "
            "values are more precise."
        )
    ]
    for quantity, size, rows in _groups(found):
        best = rows[0]
        if not math.isfinite(best.half_width_percent):
            lines.append(f"{quantity}, {size} participants: no study yields an interval.")
            continue
        line = (
            f"{quantity}, {size} participants: {best.study.name} estimates it to within ± "
            f"{best.half_width_percent:.0f} %"
        )
        others = [
            f"{row.study.name} to ± {row.half_width_percent:.0f} %"
            for row in rows[1:]
            if math.isfinite(row.half_width_percent)
        ]
        lines.append(f"{', '.join([line, *others])}.")
    if len({row.study.quantity for row in found}) > 1:
        lines.append(
            "Exponents and thresholds answer different questions, so they must not be compared "
            "with each other."
        )
    return lines


def table(found: Sequence[ProtocolPrecision]) -> list[tuple[str, ...]]:
    """Return headings and rows for a terminal."""
    head = ("quantity", "study", "N", "trials", "amount", "minutes", "value", "±  %", "5 to 95 %")
    rows = [
        (
            row.study.quantity,
            row.study.name,
            str(row.participants),
            str(row.trials),
            f"{row.study.amount} {row.study.number}",
            f"{row.minutes:.1f}",
            value_of(row),
            f"{row.half_width_percent:.1f} ({row.error:.1f})",
            f"{row.low:.0f} to {row.high:.0f}",
        )
        for row in ranked(found)
    ]
    return [head, *rows]


def as_json(found: Sequence[ProtocolPrecision], minutes: float) -> dict[str, object]:
    """Return the comparison as JSON data."""
    return {
        "minutes": minutes,
        "rows": [dict(zip(HEAD, _cells(row), strict=True)) for row in ranked(found)],
    }


def _cells(row: ProtocolPrecision) -> list[str | int | float | None]:
    study = row.study
    numbers = (row.value, row.half_width_percent, row.error, row.low, row.high, row.without)
    return [
        *(study.quantity, study.name, study.title, row.participants),
        *(study.amount, study.number, row.trials, row.minutes),
        *(value if math.isfinite(value) else None for value in numbers),
        row.studies,
    ]


def write_comparison(folder: Path, found: Sequence[ProtocolPrecision], minutes: float) -> Path:
    """Write ``protocols.csv``, ``.json``, ``.svg`` and ``.png``; return the figure's path.

    Raises
    ------
    UserError
        If the folder cannot be written.
    """
    write_rows(folder, "protocols", HEAD, [_cells(row) for row in ranked(found)])
    try:
        content = json.dumps(as_json(found, minutes), indent=2)
        (folder / "protocols.json").write_text(content, encoding="utf-8")
        save(protocols_figure(found, minutes), folder / "protocols", (".svg", ".png"))
    except OSError as error:
        raise UserError("--out {folder}: {reason}", folder=folder, reason=error.strerror) from None
    return folder / "protocols.svg"


def write_rows(
    folder: Path, name: str, head: Sequence[str], rows: Iterable[Sequence[str | float | None]]
) -> None:
    """Write a CSV file to a folder, and create the folder if necessary.

    Raises
    ------
    UserError
        If the folder cannot be written.
    """
    lines = io.StringIO()
    writer = csv.writer(lines, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(["" if each is None else each for each in row] for row in rows)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.csv").write_text(lines.getvalue(), encoding="utf-8")
    except OSError as error:
        raise UserError("--out {folder}: {reason}", folder=folder, reason=error.strerror) from None


@styled
def protocols_figure(found: Sequence[ProtocolPrecision], minutes: float) -> Figure:
    """Plot each study's half-width: one panel per quantity, one colour per sample size."""
    quantities = list(dict.fromkeys(row.study.quantity for row in ranked(found)))
    sizes = sorted({row.participants for row in found})
    studies = {
        quantity: list(
            dict.fromkeys(row.study.name for row in ranked(found) if row.study.quantity == quantity)
        )
        for quantity in quantities
    }
    heights = [0.5 + len(names) for names in studies.values()]
    figure, panels = canvas(
        len(quantities),
        1,
        size=(6.6, 1.1 + 0.55 * sum(heights)),
        squeeze=False,
        sharex=True,
        gridspec_kw={"height_ratios": heights},
    )
    for axes, (quantity, names) in zip(panels[:, 0], studies.items(), strict=True):
        for number, size in enumerate(sizes):
            own = [
                row
                for row in found
                if (row.study.quantity, row.participants) == (quantity, size)
                and math.isfinite(row.half_width_percent)
            ]
            places = [
                names.index(row.study.name) + 0.22 * (number - (len(sizes) - 1) / 2) for row in own
            ]
            colour = CYCLE[number % len(CYCLE)]
            axes.hlines(
                places, [row.low for row in own], [row.high for row in own], color=colour, alpha=0.5
            )
            axes.plot(
                [row.half_width_percent for row in own],
                places,
                "os^Dv"[number % 5],
                color=colour,
                label=f"{size} participants",
            )
            for row, place in zip(own, places, strict=True):
                axes.annotate(
                    f" {row.half_width_percent:.0f} %", (row.high, place), va="center",
                    fontsize=8, color=INK,
                )  # fmt: skip
        axes.set_yticks(range(len(names)), names)
        axes.set_ylim(len(names) - 0.5, -0.5)
        axes.grid(axis="y", visible=False)
        axes.grid(axis="x", visible=True)
        axes.set_title(quantity[0].upper() + quantity[1:], fontsize=9, loc="left")
    furthest = max((row.high for row in found if math.isfinite(row.high)), default=1.0)
    panels[-1, 0].set_xlim(0, 1.1 * furthest)
    panels[-1, 0].set_xlabel(
        f"Half-width of the 95 % interval in % of the value, {minutes:.0f} minutes per "
        "participant\n(mean; line: 5 to 95 % of simulated studies)"
    )
    if len(sizes) > 1:
        handles, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=len(sizes))
    return figure
