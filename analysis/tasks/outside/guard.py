"""Load kinds of task from other packages, and catch errors in their functions.

A package declares a `TaskAnalysis` with an entry point in the group ``slipscale.analyses``. If code
of the package raises an exception or returns a wrong type, the report names the package and the
part that failed. The rest of the report is still written. Texts, tables and figures are computed
before any file is written, so that the report can list failures. Report sections are computed
afterwards, because they include the figures. Keys and files must be called ``own_NAME`` or
``own_NAME_...`` to avoid conflicts with Slipscale's names.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd

from slipscale import figure_style
from slipscale.analysis import json_form
from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.reading.delimited import Problems, Source
from slipscale.analysis.reading.labelled_tasks import Entries, TaskTrials
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Inputs, SessionTable, Statistic
from slipscale.analysis.tasks.kind import Analysis, SectionWriter, TaskAnalysis
from slipscale.analysis.tasks.table import KINDS
from slipscale.analysis.writing import html
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.plug_ins import ANALYSES, called, installed, package_of

T = TypeVar("T")


def every_kind() -> tuple[TaskAnalysis, ...]:
    """Return Slipscale's kinds of task, followed by those from installed packages."""
    return (*KINDS, *installed_kinds([]))


def installed_kinds(faults: list[str]) -> tuple[TaskAnalysis, ...]:
    """Return the kinds of task from installed packages that can be loaded, sorted by name.

    Parameters
    ----------
    faults : list of str
        List to which one sentence per failure is appended, during loading and in subsequent calls.

    Raises
    ------
    UserError
        Two packages provide analyses with the same name.
    """
    guards = [_Guard(point, faults) for point in installed(ANALYSES).values()]
    return tuple(kind for guard in guards if (kind := guard.kind()) is not None)


def evaluated(analysis: Analysis, faults: list[str]) -> Analysis:
    """Compute the results of other packages' analyses, and append failures to ``problems``.

    Parameters
    ----------
    faults : list of str
        The list that was passed to `installed_kinds`.
    """
    kinds = tuple(_made(kind, analysis) if kind.package else kind for kind in analysis.kinds)
    problems = (*analysis.problems, *(f"{fault}." for fault in faults))
    return replace(analysis, kinds=kinds, problems=problems)


def _made(kind: TaskAnalysis, analysis: Analysis) -> TaskAnalysis:
    """Return a copy of a task kind whose functions return results computed now."""
    made = {part: getattr(kind, part)(analysis) for part in PARTS}
    parts: dict[str, Any] = {part: lambda _, value=value: value for part, value in made.items()}
    return replace(kind, **parts)


@dataclass(frozen=True, slots=True)
class _Guard:
    point: EntryPoint
    faults: list[str]

    @property
    def named(self) -> str:
        return Message(
            "analysis '{point_name}' of the package {package_of}",
            point_name=self.point.name,
            package_of=package_of(self.point),
        )

    @property
    def version(self) -> str:
        return self.point.dist.version if self.point.dist else "unknown"

    def call(self, part: str, action: Callable[[], T], otherwise: Callable[[str], T]) -> T:
        """Call a function of the package, or return ``otherwise(message)`` if it fails."""
        subject = f"{self.named}: its {part}" if part else self.named
        try:
            return called(self.point, action, subject)
        except UserError as error:
            # The text of an exception raised by the package may not name the package.
            text = str(error)
            sentence = text if text.startswith(self.named) else f"{subject}: {text}"
            if sentence not in self.faults:
                self.faults.append(sentence)
            return otherwise(sentence)

    def kind(self) -> TaskAnalysis | None:
        """Return the kind of task with error handling added, or None if it cannot be loaded."""
        kind = self.call("", lambda: _declared(self.point.name, self.point.load()), lambda _: None)
        if kind is None:
            return None
        parts: dict[str, Any] = {part: self._part(kind, part) for part in PARTS}
        return replace(
            kind,
            package=package_of(self.point),
            version=self.version,
            trials=kind.trials and self._trials(kind.trials),
            statistics=tuple(self._statistic(each) for each in kind.statistics),
            sections=tuple(self._section(kind.name, each) for each in kind.sections),
            session_tables=self._session_tables(kind),
            **parts,
        )

    def _part(self, kind: TaskAnalysis, part: str) -> Callable[[Analysis], object]:
        check = PARTS[part]
        make: Callable[[Analysis], object] = getattr(kind, part)
        return lambda analysis: self.call(
            part, lambda: check(kind.name, make(analysis)), lambda _: check(kind.name, check.empty)
        )

    def _statistic(self, statistic: Statistic[object]) -> Statistic[object]:
        def computed(inputs: Inputs) -> object:
            # The package receives copies, so that it cannot change the data of other analyses.
            data = inputs.data.with_tables(lambda rows: rows.copy())
            found = statistic.compute(replace(inputs, data=data))
            if not isinstance(found, NotComputed):
                json_form.form(found)
                for family in statistic.families:
                    _ = [float(p) for p in family.read(found)]
            return found

        return replace(
            statistic,
            compute=lambda inputs: self.call("", lambda: computed(inputs), NotComputed),
        )

    def _section(self, name: str, write: SectionWriter) -> SectionWriter:
        whose = (
            f"This section was written by the analysis '{name}' in the package "
            f"{package_of(self.point)} {self.version}, which was installed on the computer that "
            "created this report. This analysis is not part of Slipscale."
        )

        def written(analysis: Analysis, svgs: Mapping[str, str]) -> html.ReportSection:
            section = write(analysis, svgs)
            if not isinstance(section, html.ReportSection):
                raise UserError(
                    "returned {name}, expected a ReportSection", name=type(section).__name__
                )
            section.blocks.append(html.paragraph(whose))
            return section

        def failed(sentence: str) -> html.ReportSection:
            return html.ReportSection(name, [html.paragraph(f"{sentence}.", "problem")], "open")

        return lambda analysis, svgs: self.call("section", lambda: written(analysis, svgs), failed)

    def _session_tables(
        self, kind: TaskAnalysis
    ) -> Callable[[Dataset, Prepared | None], list[SessionTable]]:
        return lambda data, prepared: self.call(
            "session_tables", lambda: list(kind.session_tables(data, prepared)), lambda _: []
        )

    def _trials(self, trials: TaskTrials) -> TaskTrials:
        def read(
            entries: Entries, folder: Path, problems: Problems, counts: dict[str, int]
        ) -> tuple[pd.DataFrame, list[Source]]:
            rows, sources = trials.read(entries, folder, problems, counts)
            people = pd.Categorical(rows[PARTICIPANT].astype(str))
            return rows.assign(**{PARTICIPANT: people}), list(sources)

        def none(_: str) -> tuple[pd.DataFrame, list[Source]]:
            return pd.DataFrame({PARTICIPANT: pd.Categorical([])}), []

        return replace(
            trials,
            label="",
            divide=None,
            belongs=lambda header: self.call(
                "belongs", lambda: bool(trials.belongs(header)), lambda _: False
            ),
            read=lambda entries, folder, problems, counts: self.call(
                "read", lambda: read(entries, folder, problems, counts), none
            ),
        )


@dataclass(frozen=True, slots=True)
class _Check:
    """A check of the values that a function in a `TaskAnalysis` returns."""

    empty: list[str] | dict[str, object]
    expected: str
    fits: Callable[[object], bool]
    files: bool = False

    def __call__(self, name: str, value: object) -> object:
        """Convert a value to a list or dict; raise `UserError` for a wrong type or file name."""
        found: list[object] | dict[object, object]
        if isinstance(self.empty, list) and isinstance(value, list | tuple):
            found = values = list(value)
        elif isinstance(self.empty, dict) and isinstance(value, Mapping):
            found, values = dict(value), list(value.values())
        else:
            raise UserError(f"returned {type(value).__name__}, expected {self.expected}")
        if wrong := [each for each in values if not self.fits(each)]:
            raise UserError(f"returned {type(wrong[0]).__name__}, expected {self.expected}")
        if self.files and (foreign := [each for each in found if not _is_own(name, str(each))]):
            raise UserError(
                "a file name must be own_{name} or begin with own_{name}_, but is '{foreign}'",
                name=name,
                foreign=foreign[0],
            )
        return found


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _are_texts(value: object) -> bool:
    return isinstance(value, list | tuple) and all(map(_is_text, value))


def _is_figure(value: object) -> bool:
    from matplotlib.figure import Figure

    if not isinstance(value, Figure):
        return False
    figure_style.svg(value)  # drawn now, because a failure later would stop the whole report
    return True


#: Fields of a declaration that depend only on the analysis, with the check of each result.
_TEXTS = _Check([], "a list of strings", _is_text)
PARTS: Mapping[str, _Check] = {
    "questions": _TEXTS,
    "design": _TEXTS,
    "answers": _TEXTS,
    "doubts": _TEXTS,
    "sentences": _Check({}, "lists of strings by heading", _are_texts),
    "figures": _Check({}, "matplotlib figures by file name", _is_figure, files=True),
    "tables": _Check(
        {}, "DataFrames by file name", lambda value: isinstance(value, pd.DataFrame), files=True
    ),
}


def _is_own(name: str, key: str) -> bool:
    return re.fullmatch(rf"own_{re.escape(name)}(_[a-z0-9_]+)?", key) is not None


def _declared(name: str, kind: object) -> TaskAnalysis:
    # The name is used in file names and in a key of inference.json.
    if not re.fullmatch("[a-z][a-z0-9_]*", name):
        raise UserError("expected a name of lower-case letters, digits and underscores")
    if not isinstance(kind, TaskAnalysis):
        raise UserError("its entry point must be a TaskAnalysis, but is {kind}", kind=repr(kind))
    if kind.name != name:
        raise UserError(
            "its name must be the name of the entry point, but is '{kind_name}'",
            kind_name=kind.name,
        )
    keys = [statistic.key for statistic in kind.statistics]
    keys += [kind.trials.name] if kind.trials is not None else []
    if foreign := [key for key in keys if not _is_own(name, key)]:
        raise UserError(
            "its key must be own_{name} or begin with own_{name}_, but is '{foreign}'",
            name=name,
            foreign=foreign[0],
        )
    return kind
