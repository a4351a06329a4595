"""Compare all numbers in the paper with the values that Slipscale computes.

A source is a module that defines ``ITEMS`` and ``FIGURES``. ``ITEMS`` maps each item's name to a
function that returns an `Outcome`. ``FIGURES`` maps each figure's name to a function that returns a
Matplotlib figure. The recorded values are stored in one JSON file per source, in the folder
``recorded``. For each item, ``agrees`` is True if the computed value rounds to the published value,
and ``drifted`` is True if the computed value differs from the recorded value. ``reason`` explains
why the computed value differs from the paper.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from types import ModuleType
from typing import Literal

from slipscale.analysis.published.biet2007 import agrees
from slipscale.faults import UserError
from slipscale.figure_style import save

#: Modules that define ``ITEMS``, and files with recorded values, in the order of the output.
SOURCES: tuple[tuple[str, str], ...] = (
    ("slipscale.analysis.reproduction.table3", "table3.json"),
    ("slipscale.analysis.reproduction.datasets", "datasets.json"),
    ("slipscale.analysis.reproduction.film", "film.json"),
    ("slipscale.analysis.reproduction.plate", "plate.json"),
    ("slipscale.analysis.reproduction.constants", "constants.json"),
    ("slipscale.analysis.reproduction.film_equations", "film_equations.json"),
    ("slipscale.analysis.reproduction.beam_equations", "beam_equations.json"),
)
#: Relative change above which a value has drifted. Smaller changes may be due to rounding, which
#: differs between processors and library versions.
DRIFT = 1e-6
#: Floating-point numbers represent all whole numbers below this limit exactly.
EXACT = 2**53

Group = Literal["agrees", "differs", "by construction", "not published"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """The published value of an item and the value that Slipscale computes.

    Parameters
    ----------
    published : str or None
        Number as published, or None if the paper does not give a number.
    ours : float
        Number that Slipscale computes.
    unit : str
        Unit of both numbers.
    reason : str
        How the computed value was obtained, or why it differs from the published value.
    rule : callable, optional
        Function that returns whether the published and the computed value agree, for statements
        such as "> 10". By default, the computed value must round to the published number.
    must_agree : bool
        Whether a disagreement is an error in Slipscale.
    by_construction : bool
        Whether agreement is no evidence: the computed value is set to the published one, computed
        from other numbers in the paper, or restates a definition.
    covers : tuple of str
        Parts of the paper that the item stands for, such as ``"eq.14"`` or ``"fig.5"``.
    exact : int, optional
        The computed value as an exact integer, if the float ``ours`` may be rounded.
    text : str, optional
        The computed value as text, for values such as bounds, which must not be rounded to the
        nearest number.
    """

    published: str | None
    ours: float
    unit: str
    reason: str
    rule: Callable[[str, float], bool] = agrees
    must_agree: bool = False
    by_construction: bool = False
    covers: tuple[str, ...] = ()
    exact: int | None = None
    text: str | None = None

    @property
    def shown(self) -> str:
        """The computed value, formatted for printing."""
        if self.text is not None:
            return self.text
        return f"{self.ours:.5g}" if self.exact is None else f"{self.exact:,}"

    @property
    def agrees(self) -> bool | None:
        """Whether the computed value agrees with the paper; None if the paper gives no value."""
        return None if self.published is None else self.rule(self.published, self.ours)

    @property
    def group(self) -> Group:
        """Group of the summary. Agreement by construction is no evidence."""
        if self.agrees is None:
            return "not published"
        if not self.agrees:
            return "differs"
        return "by construction" if self.by_construction else "agrees"


def item(
    compute: Callable[[], float],
    published: str | None,
    unit: str,
    reason: str,
    *,
    rule: Callable[[str, float], bool] = agrees,
    by_construction: bool = False,
    covers: tuple[str, ...] = (),
) -> Callable[[], Outcome]:
    """Create an item, which is a function that computes a value and returns an `Outcome`."""
    return lambda: Outcome(
        published=published,
        ours=compute(),
        unit=unit,
        reason=reason,
        rule=rule,
        by_construction=by_construction,
        covers=covers,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """Result of comparing one item with the paper and with the recorded value."""

    item: str
    outcome: Outcome
    recorded: float | None

    @property
    def drifted(self) -> bool:
        """Whether the computed value differs from the recorded value."""
        if self.recorded is None:
            return True
        return not math.isclose(self.outcome.ours, self.recorded, rel_tol=DRIFT, abs_tol=1e-12)

    @property
    def failed(self) -> bool:
        """Whether the value has drifted, or disagrees although `must_agree` is True."""
        return self.drifted or (self.outcome.must_agree and self.outcome.agrees is False)

    def record(self) -> dict[str, object]:
        """Return the item as JSON data, as printed by ``--json``."""
        text = self.outcome.published
        return {
            "item": self.item,
            "published": _number_or_text(text),
            "ours": self.outcome.ours,
            "unit": self.outcome.unit,
            "agrees": self.outcome.agrees,
            "covers": self.outcome.covers,
            "by_construction": self.outcome.by_construction,
            "reason": self.outcome.reason,
            "recorded": self.recorded,
            "drifted": self.drifted,
        }


def _number_or_text(text: str | None) -> float | str | None:
    try:
        return None if text is None else float(text)
    except ValueError:
        return text


def sources() -> list[ModuleType]:
    """Import and return the modules in `SOURCES`."""
    return [import_module(name) for name, _ in SOURCES]


def recorded_values() -> dict[str, float]:
    """Return the recorded values of all items, keyed by item name."""
    values: dict[str, float] = {}
    for _, name in SOURCES:
        values |= json.loads(
            files("slipscale.analysis.reproduction")
            .joinpath("recorded", name)
            .read_text(encoding="utf-8")
        )
    return values


def record(items: Mapping[str, Callable[[], Outcome]], name: str) -> None:
    """Compute the values of all given items and store them in a JSON file."""
    found = {item: compute().ours for item, compute in items.items()}
    values = {item: int(v) if abs(v) < EXACT and v == int(v) else v for item, v in found.items()}
    Path(__file__).with_name("recorded").joinpath(name).write_text(
        json.dumps(values, indent=2) + "\n", encoding="utf-8"
    )


def item_names() -> list[str]:
    """Return the names of all items in the order in which they are printed."""
    return [name for source in sources() for name in source.ITEMS]


def choose(wanted: Sequence[str]) -> list[str]:
    """Return the items with the given names or prefixes.

    >>> choose(["fig15"])
    ['fig15.0', 'fig15.0.5', 'fig15.1.2', 'fig15.2.3']
    """
    known = item_names()
    if not wanted:
        return known
    chosen: list[str] = []
    for word in wanted:
        exact = [word] if word in known else []
        matches = exact or [name for name in known if name.startswith(f"{word}.")]
        if not matches:
            beginnings = dict.fromkeys(name.partition(".")[0] for name in known)
            raise UserError(
                "unknown item '{word}'; expected one of {items}, or a complete name such as "
                "{example}",
                word=word,
                items=", ".join(beginnings),
                example=known[0],
            )
        chosen += [name for name in matches if name not in chosen]
    return chosen


def compare(
    wanted: Sequence[str] = (), progress: Callable[[str], None] | None = None
) -> list[Comparison]:
    """Compute the chosen values, and compare them with the paper and with the recorded values."""
    calls = {name: call for source in sources() for name, call in source.ITEMS.items()}
    recorded = recorded_values()
    comparisons = []
    for name in choose(wanted):
        if progress:
            progress(name)
        comparisons.append(
            Comparison(item=name, outcome=calls[name](), recorded=recorded.get(name))
        )
    return comparisons


def write_figures(
    out: Path, wanted: Sequence[str] = (), progress: Callable[[str], None] | None = None
) -> list[Path]:
    """Write the figures for the chosen items as SVG and PNG, and return the paths."""
    # A figure belongs to all items with its name as prefix, such as fig15.0.5 for fig15.
    chosen = {name.split(".")[0] for name in choose(wanted)}
    paths: list[Path] = []
    try:
        for source in sources():
            for name, draw in source.FIGURES.items():
                if wanted and name.split(".")[0] not in chosen:
                    continue
                if progress:
                    progress(name)
                paths += save(draw(), out / name, (".svg", ".png"))
    except OSError as error:
        raise UserError(
            "{filename}: cannot be written ({reason})",
            filename=error.filename or out,
            reason=error.strerror or error,
        ) from error
    return paths
