"""What an outside analysis is, what it gets and what it returns.

A package names an `OwnAnalysis` by an entry point of the group ``slipscale.analyses``. Everything
here is frozen and checked when it is made, so that a wrong result is told where it comes from.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import pandas as pd

from slipscale.analysis.json_form import record
from slipscale.faults import UserError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.analysis.statistics.not_computed import NotComputed
    from slipscale.experiments.study.model import Study

CELL = (str, int, float, bool, type(None))


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnInput:
    """What an outside analysis gets.

    Parameters
    ----------
    dataset : Dataset
        Trials, participants and the frozen choices, after the study's exclusions; tables are
        copies. Those of tasks that Slipscale does not read itself are in ``dataset.others``.
    study : Study or None
        The study file; None where the data have none, or it does not read here.
    """

    dataset: Dataset
    study: Study | None


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnResult:
    """What an outside analysis returns.

    Parameters
    ----------
    sentences : tuple of str
        What was found, as a results section has it; at least one.
    numbers : Mapping
        Name -> number, text or None, or a tuple or mapping of these: for inference.json. Names
        carry their unit: ``slope_per_um_pp``. NaN is written as null.
    table : DataFrame, optional
        One row a case, with named columns of numbers and words.
    table_caption : str
        What its rows and columns are.
    figure : Figure, optional
        Of matplotlib.
    figure_caption, figure_alt : str
        What it shows: for readers, and for those who cannot see it. Needed where there is one.

    Raises
    ------
    UserError
        A field is of another type; the sentence names it.
    """

    sentences: tuple[str, ...]
    numbers: Mapping[str, Any]
    table: pd.DataFrame | None = None
    table_caption: str = ""
    figure: Figure | None = None
    figure_caption: str = ""
    figure_alt: str = ""

    def __post_init__(self) -> None:
        wrong = (
            (
                not isinstance(self.sentences, tuple)
                or not self.sentences
                or not all(isinstance(each, str) and each.strip() for each in self.sentences),
                "sentences: expected a tuple of one or more texts",
            ),
            (
                not isinstance(self.numbers, Mapping) or not _is_plain(self.numbers),
                (
                    "numbers: expected a mapping from names to numbers, texts, None, and tuples or "
                    "mappings of these"
                ),
            ),
            (
                self.table is not None and not _is_table(self.table),
                "table: expected a DataFrame with named columns, each once, of numbers and words",
            ),
            (
                self.figure is not None and not _is_figure(self.figure),
                "figure: expected a Figure of matplotlib",
            ),
            (
                self.figure is not None and not (self.figure_caption and self.figure_alt),
                "figure: expected a figure_caption and a figure_alt with it",
            ),
        )
        if faults := [words for fault, words in wrong if fault]:
            raise UserError("; ".join(faults))


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnAnalysis:
    """An outside analysis.

    Parameters
    ----------
    title : str
        The heading of its section in the report.
    run : callable
        Returns what was found, or `NotComputed` with the reason why there is nothing.
    """

    title: str
    run: Callable[[OwnInput], OwnResult | NotComputed]


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnFinding:
    """What an installed analysis found, or why it found nothing.

    Parameters
    ----------
    name, title : str
        The entry point's name, and the section's heading.
    package, version : str
        Who computed it.
    found : OwnResult or NotComputed
    failed : bool
        Whether there is no result because the plug-in is at fault.
    """

    name: str
    title: str
    package: str
    version: str
    found: OwnResult | NotComputed = field(repr=False)
    failed: bool = False

    def json_form(self) -> Mapping[str, object]:
        """Return the result under its keys."""
        keys: dict[str, object] = {
            "title": self.title,
            "package": self.package,
            "version": self.version,
        }
        found = self.found
        if isinstance(found, OwnResult):
            return {**keys, "sentences": found.sentences, "numbers": found.numbers}
        return {**keys, **record(found)}


def _is_plain(value: object) -> bool:
    """Return whether a value can be written as JSON."""
    if isinstance(value, Mapping):
        return all(isinstance(key, str) and _is_plain(each) for key, each in value.items())
    if isinstance(value, tuple | list):
        return all(_is_plain(each) for each in value)
    return isinstance(value, CELL)


def _is_table(table: object) -> bool:
    if not isinstance(table, pd.DataFrame) or not len(table.columns):
        return False
    named = all(isinstance(name, str) and name for name in table.columns)
    plain = (all(isinstance(cell, CELL) for cell in table[name].tolist()) for name in table)
    return named and table.columns.is_unique and all(plain)


def _is_figure(figure: object) -> bool:
    from matplotlib.figure import Figure  # noqa: PLC0415 - who made a figure has loaded it

    return isinstance(figure, Figure)
