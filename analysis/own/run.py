"""The installed outside analyses, one after another: one that fails does not stop the rest."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from slipscale import figure_style
from slipscale.analysis.own.declaration import OwnAnalysis, OwnFinding, OwnInput, OwnResult
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.experiments.study.file import parse_study
from slipscale.faults import UserError
from slipscale.faults.plug_ins import ANALYSES, called, installed, package_of

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.experiments.study.model import Study


def are_installed() -> bool:
    """Return whether a package brings an analysis."""
    return bool(installed(ANALYSES))


def own_analyses(data: Dataset) -> tuple[OwnFinding, ...]:
    """Return what each installed analysis finds in a data set, by name.

    Raises
    ------
    UserError
        Two packages give their analyses the same name.
    """
    points = installed(ANALYSES)
    if not points:
        return ()
    study = study_of(data)
    return tuple(_finding(point, data, study) for point in points.values())


def study_of(data: Dataset) -> Study | None:
    """Return the data set's study; None where it has none that reads here."""
    path = data.folder / "code" / "study.toml" if data.folder else None
    if path is None or not path.is_file():
        return None
    try:
        return parse_study(path.read_text(encoding="utf-8-sig"), str(path))
    except (OSError, UnicodeDecodeError, UserError):
        return None


def _finding(point: EntryPoint, data: Dataset, study: Study | None) -> OwnFinding:
    """Return what one finds, or the sentence on what is wrong with it."""
    named = f"analysis '{point.name}' of the package {package_of(point)}"
    title, failed = point.name, False
    found: OwnResult | NotComputed
    try:
        declared = _declared(point, named)
        title = declared.title
        # Copies: what one analysis does to its tables, the next does not see.
        own = OwnInput(dataset=data.with_tables(lambda rows: rows.copy()), study=study)
        found = _checked(point, called(point, lambda: declared.run(own), named), named)
    except UserError as error:
        said = str(error)
        # A sentence that the plug-in raised itself does not say whose it is.
        found = NotComputed(said if said.startswith(named) else f"{named}: {said}")
        failed = True
    return OwnFinding(
        name=point.name,
        title=title,
        package=package_of(point),
        version=point.dist.version if point.dist else "unknown",
        found=found,
        failed=failed,
    )


def _declared(point: EntryPoint, named: str) -> OwnAnalysis:
    # Its name is that of files and of a key of inference.json.
    if not re.fullmatch("[a-z][a-z0-9_]*", point.name):
        raise UserError(f"{named}: expected a name of small letters, digits and underscores")
    declared: object = called(point, point.load, named)
    if not isinstance(declared, OwnAnalysis) or not callable(declared.run):
        raise UserError(f"{named}: its entry point is {declared!r}, expected an OwnAnalysis")
    if not isinstance(declared.title, str) or not declared.title.strip():
        raise UserError(f"{named}: its title is {declared.title!r}, expected a text")
    return declared


def _checked(point: EntryPoint, found: object, named: str) -> OwnResult | NotComputed:
    """Return a result that can be written and drawn."""
    if not isinstance(found, OwnResult | NotComputed):
        raise UserError(
            f"{named} returned {type(found).__name__}, expected an OwnResult, or NotComputed"
        )
    if isinstance(found, OwnResult) and (figure := found.figure) is not None:
        # Drawn once here: a figure that fails later would take the whole report with it.
        called(point, lambda: figure_style.svg(figure), f"{named}: its figure")
    return found
