"""Write a power analysis to files: a page, figures, CSV and JSON."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.analysis.planning.power.answers import Row, as_json, test_title, varying
from slipscale.analysis.planning.power.figures import catch_figure, power_figure, precision_figure
from slipscale.analysis.planning.power.grid import AXES
from slipscale.analysis.planning.power.terminal import summary
from slipscale.analysis.writing import html
from slipscale.faults import UserError
from slipscale.figure_style import save, svg

if TYPE_CHECKING:
    from markupsafe import Markup

    from slipscale.analysis.planning.power.design import Design


def write_power(folder: Path, design: Design, found: Sequence[Row], target: float) -> Path:
    """Write ``power.html``, ``power.csv``, ``power.json`` and the figures; return the page.

    Raises
    ------
    UserError
        If the folder cannot be written.
    """
    figures = {"power": power_figure(found, target), "precision": precision_figure(found)}
    if found[0].steps:
        figures["catch_steps"] = catch_figure(found)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        content = json.dumps(as_json(design, found, target), indent=2)
        (folder / "power.json").write_text(content, encoding="utf-8")
        with (folder / "power.csv").open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerows(_csv(found))
        for name, figure in figures.items():
            save(figure, folder / name, (".svg", ".png"))
        page = folder / "power.html"
        page.write_text(_page(design, found, target), encoding="utf-8")
    except OSError as error:
        raise UserError(
            "--out {folder}: {reason}; computed results are not lost if --cache was given",
            folder=folder,
            reason=error.strerror,
        ) from None
    return page


def _csv(found: Sequence[Row]) -> list[list[str]]:
    """Return the CSV table: the header, and one line per condition and test."""
    head = [*AXES, "test", "power", "low", "high", "false_alarms", "exponent_half_width", "studies"]
    head += ["catch_yes_half_width", "d_prime_lower_bound"] if found[0].steps else []
    lines = [head]
    for row in found:
        axes = [row.condition.told(axis) for axis in AXES]
        for name, share in row.power.items():
            alarms = row.false_alarms.get(name)
            lines.append(
                [
                    *axes,
                    name,
                    repr(share.value),
                    repr(share.low),
                    repr(share.high),
                    repr(alarms.value) if alarms else "",
                    repr(row.widths["exponent"].mean),
                    str(share.studies),
                    *(repr(sums.mean) for sums in row.steps.values()),
                ]
            )
    return lines


def _page(design: Design, found: Sequence[Row], target: float) -> str:
    blocks: list[Markup] = [
        html.figure(
            svg(power_figure(found, target), salt="power"),
            "Power of the weakest comparison against the number of participants. Bands are 95 % "
            "Monte Carlo intervals.",
            "Power curves that rise with the number of participants",
        ),
        html.figure(
            svg(precision_figure(found), salt="precision"),
            "Half-width of the confidence interval for the group exponent.",
            "A map of half-widths by number of participants and ratings per surface",
        ),
    ]
    if found[0].steps:
        blocks.append(
            html.figure(
                svg(catch_figure(found), salt="catch"),
                "Effect of the number of catch steps on the precision of the false-alarm "
                "rate and on the smallest d' that can be claimed. Bands: 95 % Monte Carlo "
                "intervals of the means.",
                "Two panels with the precision of the false-alarm rate and the lower bound of d', "
                "plotted against the number of catch steps",
            )
        )
    blocks.append(_table(found))
    return html.page(
        "power.html",
        "slipscale.analysis.planning",
        title=f"Power of {design.name}",
        sentences=summary(design, found, target),
        blocks=blocks,
    )


def _table(found: Sequence[Row]) -> Markup:
    axes, tests = varying(found), found[0].power
    steps = found[0].steps
    names = (
        *(axis.replace("_", " ") for axis in axes),
        *map(test_title, tests),
        "exponent ±",
        *steps,
    )
    columns = html.columns(*names)
    rows = [
        [
            *(row.condition.told(axis) for axis in axes),
            *(f"{row.power[name].value:.3f}" for name in tests),
            f"{row.widths['exponent'].mean:.3f}",
            *(f"{row.steps[name].mean:.3f}" for name in steps),
        ]
        for row in found
    ]
    return html.table(
        columns, rows, "Power of every test, and half-width of the interval for the exponent."
    )
