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
import reprlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import TypeVar

import pandas as pd

from slipscale import figure_style
from slipscale.analysis import json_form
from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.reading.delimited import Problems, Source
from slipscale.analysis.reading.labelled_tasks import Entries, TaskTrials
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Inputs, SessionTable, Statistic
from slipscale.analysis.tasks.kind import Analysis, TaskAnalysis
from slipscale.analysis.writing import html
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.plug_ins import ANALYSES, called, installed, package_of

T = TypeVar("T")
A = TypeVar("A", bound=Analysis)


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


def evaluated(analysis: A, faults: list[str]) -> A:
    """Compute the results of other packages' analyses, and append failures to ``problems``.

    Parameters
    ----------
    faults : list of str
        The list that was passed to `installed_kinds`.
    """
    kinds = tuple(
        kind.evaluated(analysis) if isinstance(kind, _GuardedKind) else kind
        for kind in analysis.kinds
    )
    problems = (*analysis.problems, *(f"{fault}." for fault in faults))
    return replace(analysis, kinds=kinds, problems=problems)


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
        return kind and _GuardedKind(self, kind, {})

    def trials(self, trials: TaskTrials) -> TaskTrials:
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


class _GuardedStatistic(Statistic[object]):
    """Another package's statistic, with error handling."""

    def __init__(self, guard: _Guard, kind: str, statistic: Statistic[object]) -> None:
        self._guard, self._kind, self._statistic = guard, kind, statistic
        for name in ("parts", *Statistic.__annotations__):
            setattr(self, name, getattr(statistic, name))

    def __reduce__(self) -> tuple[Callable[[str, str], object], tuple[str, str]]:
        """Pickle the names of the entry point and of the statistic."""
        return _statistic_named, (self._kind, self.key)

    def compute(self, inputs: Inputs) -> object:
        def computed() -> object:
            # The package receives copies, so that it cannot change the data of other analyses.
            data = inputs.data.with_tables(lambda rows: rows.copy())
            found = self._statistic.compute(replace(inputs, data=data))
            if not isinstance(found, NotComputed):
                json_form.form(found)
                for family in self.families:
                    _ = [float(p) for p in family.read(found)]
            return found

        return self._guard.call("", computed, NotComputed)


def _statistic_named(kind: str, key: str) -> Statistic[object]:
    return next(each for each in _kind_named(kind).statistics if each.key == key)


class _GuardedKind(TaskAnalysis):
    """Another package's kind of task, with error handling.

    Parameters
    ----------
    made : Mapping
        Results of the methods in `PARTS`, which are returned instead of being computed.
    """

    def __init__(self, guard: _Guard, kind: TaskAnalysis, made: Mapping[str, object]) -> None:
        self.name, self.package, self.version = kind.name, package_of(guard.point), guard.version
        self.trials = kind.trials and guard.trials(kind.trials)
        self.statistics = tuple(
            _GuardedStatistic(guard, kind.name, each) for each in kind.statistics
        )
        self._guard, self._kind = guard, kind
        for part, check in PARTS.items():
            setattr(self, part, partial(self._part, part, check, made))

    def __reduce__(self) -> tuple[Callable[[str], TaskAnalysis], tuple[str]]:
        """Pickle the name of the entry point, because another package's objects may have none."""
        return _kind_named, (self.name,)

    def evaluated(self, analysis: Analysis) -> TaskAnalysis:
        """Return a copy whose methods return results that are computed now."""
        made = {part: getattr(self, part)(analysis) for part in PARTS}
        return _GuardedKind(self._guard, self._kind, made)

    def sections(self, analysis: Analysis, svgs: Mapping[str, str]) -> list[html.ReportSection]:
        whose = (
            f"This section was written by the analysis '{self.name}' in the package "
            f"{self.package} {self.version}, which was installed on the computer that "
            "created this report. This analysis is not part of Slipscale."
        )

        def written() -> list[html.ReportSection]:
            found = list(self._kind.sections(analysis, svgs))
            for section in found:
                if not isinstance(section, html.ReportSection):
                    raise UserError(
                        "returned {name}, expected a ReportSection", name=type(section).__name__
                    )
                section.blocks.append(html.paragraph(whose))
            return found

        def failed(sentence: str) -> list[html.ReportSection]:
            paragraph = html.paragraph(f"{sentence}.", "problem")
            return [html.ReportSection(self.name, [paragraph], "open")]

        return self._guard.call("sections", written, failed)

    def session_tables(self, data: Dataset, prepared: Prepared | None) -> list[SessionTable]:
        return self._guard.call(
            "session_tables", lambda: list(self._kind.session_tables(data, prepared)), lambda _: []
        )

    def _part(
        self, part: str, check: _Check, made: Mapping[str, object], analysis: Analysis
    ) -> object:
        if part in made:
            return made[part]
        return self._guard.call(
            part,
            lambda: check(self.name, getattr(self._kind, part)(analysis)),
            lambda _: check(self.name, check.empty),
        )


def _kind_named(name: str) -> TaskAnalysis:
    return next(kind for kind in installed_kinds([]) if kind.name == name)


@dataclass(frozen=True, slots=True)
class _Check:
    """A check of the values that a method of a `TaskAnalysis` returns."""

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


#: Methods of a declaration that depend only on the analysis, with the check of each result.
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
    if not isinstance(kind, TaskAnalysis):
        raise UserError(
            "its entry point must be a TaskAnalysis, but is {kind}", kind=reprlib.repr(kind)
        )
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
