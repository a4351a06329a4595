"""Compare data and analysis with a frozen plan, and describe each deviation."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence

from slipscale.analysis.preprocessing.sessions import sessions_of
from slipscale.analysis.preregistration.bundle import Bundle
from slipscale.analysis.preregistration.plan_in_words import results_of, with_results
from slipscale.analysis.reporting.files import software
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.kind import Analysis, Deviation, DeviationKind, PlanCheck
from slipscale.experiments.dataset.hand_exclusions import BY_HAND
from slipscale.experiments.dataset.schema import SIDECAR
from slipscale.experiments.study.file import study_hash
from slipscale.faults import UserError
from slipscale.faults.folders import visible
from slipscale.faults.message import Message

#: Kinds of deviation, keyed by setting of the [analysis] table. Other settings count as options.
KIND_OF_CHOICE: Mapping[str, DeviationKind] = {
    "exclusions": "exclusions",
    "thresholds": "exclusions",
    "normalisation": "normalisation",
    "zero_rule": "normalisation",
    "tests": "tests",
    "primary": "tests",
}
MISSING = "n/a"
#: Largest number of differences between tables and journals that are listed individually.
MOST_DIFFERENCES = 20


def check_plan(bundle: Bundle, analysis: Analysis, options: Sequence[str] = ()) -> PlanCheck:
    """Return the deviations of an analysis from its plan.

    Parameters
    ----------
    bundle : Bundle
        The frozen plan.
    analysis : Analysis
        Analysis of the collected data.
    options : sequence of str
        Command-line options that were used, but cannot be part of a plan.

    Raises
    ------
    UserError
        If the data belong to another study.
    """
    _same_study(bundle, analysis)
    found = [
        Deviation(kind=kind, what=what) for kind, look in LOOKS for what in look(bundle, analysis)
    ]
    found += _choices(bundle, analysis)
    found += [
        Deviation(
            kind="options",
            what=Message("{option} was used, but is not in the plan.", option=option),
        )
        for option in options
    ]
    plan = bundle.manifest
    return PlanCheck(
        plan=bundle.name,
        frozen_utc=plan.frozen_utc,
        digest=plan.digest,
        deviations=tuple(found),
    )


def _same_study(bundle: Bundle, analysis: Analysis) -> None:
    names = analysis.dataset.details.get("study", ())
    if names and bundle.manifest.name not in names:
        raise UserError(
            "--plan {bundle}: is for study '{study}', but the data are from '{names}'",
            bundle=bundle.name,
            study=bundle.manifest.name,
            names=", ".join(names),
        )


def _of_bundle(bundle: Bundle, _: Analysis) -> Iterator[str]:
    yield from bundle.damaged


def _of_study(bundle: Bundle, analysis: Analysis) -> Iterator[str]:
    """Yield differences between the planned study file, seed and language and those used."""
    data, plan = analysis.dataset, bundle.manifest
    studies = visible(data.folder / "code", "study*.toml") if data.folder else []
    if not studies:
        yield (
            "The data contain no study file (code/study.toml), so it is unknown whether the "
            "planned study was run."
        )
    planned = _flat(tomllib.loads(bundle.study_text))
    known = {study_hash(bundle.study_text)}
    for path in studies:
        try:
            text = path.read_text(encoding="utf-8-sig")
            own = _flat(tomllib.loads(text))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            yield f"{path.name} cannot be read ({error}), so it cannot be compared with the plan."
            continue
        known.add(study_hash(text))
        for key in sorted(planned.keys() | own.keys()):
            # Analysis settings are compared separately, with the values that were used.
            if planned.get(key) != own.get(key) and not key.startswith("analysis."):
                yield f"{path.name}: {key} is {_said(own, key)}; planned: {_said(planned, key)}."
    for digest in data.details.get("study_hash", ()):
        if digest not in known:
            yield (
                "Some runs used a study file that the data set does not contain (SHA-256 "
                f"{digest[:12]}...)."
            )
    for key, value in (("seed", str(plan.seed)), ("language", plan.language)):
        others = [other for other in data.details.get(key, ()) if other != value]
        if others:
            yield f"Some runs have {key} {', '.join(others)}; planned: {value}."


def _of_data(_: Bundle, analysis: Analysis) -> Iterator[str]:
    """Yield differences between tables and journals, or a note that there are no journals."""
    differences = analysis.dataset.journal_differences
    if differences is None:
        yield (
            "The data contain no journals (sourcedata/), so changes to tables after the sessions "
            "cannot be detected."
        )
        return
    yield from (f"{each}." for each in differences[:MOST_DIFFERENCES])
    if len(differences) > MOST_DIFFERENCES:
        more = len(differences) - MOST_DIFFERENCES
        yield (
            f"There are {more} more differences from the journals; slipscale data verify lists all."
        )


def _flat(table: object, key: str = "") -> dict[str, object]:
    """Flatten a TOML table to a mapping with dotted keys; tables in lists are numbered from 1."""
    if isinstance(table, dict):
        parts = [_flat(value, f"{key}.{name}" if key else name) for name, value in table.items()]
        return {name: value for part in parts for name, value in part.items()}
    if isinstance(table, list) and any(isinstance(each, dict) for each in table):
        parts = [_flat(value, f"{key}.{number}") for number, value in enumerate(table, start=1)]
        return {name: value for part in parts for name, value in part.items()}
    return {key: table}


def _said(table: Mapping[str, object], key: str) -> str:
    return json.dumps(table[key], ensure_ascii=False, default=str) if key in table else "left out"


def _of_participants(bundle: Bundle, analysis: Analysis) -> Iterator[str]:
    plan = bundle.manifest
    participants = len(analysis.flags)
    if participants != plan.participants:
        fewer = "fewer" if participants < plan.participants else "more"
        yield (
            f"{participants} participants have data; planned: {plan.participants} "
            f"({abs(participants - plan.participants)} {fewer})."
        )
    sessions = set(sessions_of(analysis.dataset))
    for label in [each for each in plan.sessions if each not in sessions]:
        yield f"There are no data for the planned session {label}."
    for label in sorted(sessions - set(plan.sessions)):
        yield f"There are data for session {label}, which was not planned."


def _of_hand(_: Bundle, analysis: Analysis) -> Iterator[str]:
    for who, reasons in sorted(analysis.excluded.items()):
        for reason in reasons:
            if reason.startswith(BY_HAND):
                yield f"{who} was excluded {reason}. A plan cannot name participants."


def _of_dates(bundle: Bundle, analysis: Analysis) -> Iterator[str]:
    """Yield sentences on runs that started before the plan was frozen; none for pilots."""
    data = analysis.dataset
    if data.mode == "pilot":
        return
    frozen = bundle.manifest.frozen_utc
    begun = _started(analysis)
    if unknown := begun.count(""):
        yield f"{unknown} runs have no start time."
    early = sorted(each for each in begun if each and each < frozen)
    if early:
        yield (
            f"{len(early)} of {len(begun)} runs began before the plan was frozen ({frozen}), the "
            f"first at {early[0]}."
        )
    if not begun:
        yield "The data do not state when they were recorded."


def _started(analysis: Analysis) -> list[str]:
    """Return the start time of each run from its sidecars, or an empty string if not stated."""
    folder = analysis.dataset.folder
    runs: dict[str, str] = {}
    for path in visible(folder, "sub-*/**/beh/*_beh.json") if folder else ():
        try:
            own = json.loads(path.read_text(encoding="utf-8"))[SIDECAR]
            started = str(own.get("started_utc", MISSING))
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            started = MISSING
        # A run has one table per task.
        parts = [part for part in path.stem.split("_") if not part.startswith("task-")]
        runs["_".join(parts)] = "" if started == MISSING else started.replace("Z", "+00:00")
    return list(runs.values())


def _of_rule(bundle: Bundle, analysis: Analysis) -> Iterator[str]:
    planned = bundle.manifest.normalisation
    if analysis.prepared is not None and analysis.rule != planned:
        yield f"Estimates were normalised by {analysis.rule}; planned: {planned}."


def _of_tests(bundle: Bundle, analysis: Analysis) -> Iterator[str]:
    done, results = with_results(analysis), results_of(analysis)
    for name in bundle.manifest.tests:
        result = results.get(name, NotComputed("the package with this analysis is not installed"))
        if isinstance(result, NotComputed):
            yield f"{name} was planned but has no result: {result.reason}."
    for name in done:
        if name not in bundle.manifest.tests:
            yield f"{name} was computed but not planned."


def _of_versions(bundle: Bundle, analysis: Analysis) -> Iterator[str]:
    planned, here = bundle.manifest.software, software(analysis)
    for name in sorted(planned.keys() | here.keys()):
        if planned.get(name) != here.get(name):
            yield f"{name} {here.get(name, 'is missing')}; planned: {planned.get(name, 'none')}."


def _choices(bundle: Bundle, analysis: Analysis) -> Iterator[Deviation]:
    """Yield deviations from the plan in the settings of the [analysis] table."""
    planned = _flat(bundle.manifest.choices.model_dump(mode="json"))
    used = _flat(analysis.dataset.choices.model_dump(mode="json"))
    for key in sorted(planned.keys() | used.keys()):
        if planned.get(key) != used.get(key):
            yield Deviation(
                kind=KIND_OF_CHOICE.get(key.partition(".")[0], "options"),
                what=f"analysis.{key} was {_said(used, key)}; planned: {_said(planned, key)}.",
            )
    for file in bundle.manifest.files:
        if file.named_by == "analysis.codebook":
            yield from _codebook(file.sha256, analysis)


def _codebook(planned: str, analysis: Analysis) -> Iterator[Deviation]:
    name = analysis.dataset.choices.codebook
    used = {source.name: source.sha256 for source in analysis.dataset.sources}
    if name and used.get(name) != planned:
        yield Deviation(
            kind="options",
            what=Message("The codebook {name} differs from the frozen codebook.", name=name),
        )


#: The checks, in the order of the report.
LOOKS: Sequence[tuple[DeviationKind, Callable[[Bundle, Analysis], Iterator[str]]]] = (
    ("bundle", _of_bundle),
    ("study", _of_study),
    ("data", _of_data),
    ("participants", _of_participants),
    ("exclusions", _of_hand),
    ("dates", _of_dates),
    ("normalisation", _of_rule),
    ("tests", _of_tests),
    ("versions", _of_versions),
)
