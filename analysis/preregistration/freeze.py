"""Freeze a study before data collection: collect and hash all files of the plan."""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass
from datetime import datetime
from importlib.metadata import distributions
from pathlib import Path

from slipscale.analysis.pipeline import analyse
from slipscale.analysis.preregistration.bundle import sha256
from slipscale.analysis.preregistration.manifest import MANIFEST, STUDY, FrozenFile, Manifest, Role
from slipscale.analysis.preregistration.named_files import NamedFile, named_files
from slipscale.analysis.preregistration.page import PAGE, render
from slipscale.analysis.preregistration.plan_in_words import with_results
from slipscale.analysis.reporting.files import software
from slipscale.analysis.tasks.kind import Analysis
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.bare_dataset import why_sessions, write_simulated
from slipscale.experiments.running.pilot import pilot_plans
from slipscale.experiments.running.rehearsal import check_answered
from slipscale.experiments.study.file import read_study, study_text
from slipscale.faults import UserError

POWER = "power"
#: File that identifies a folder written by `slipscale power --out`.
POWER_RESULT = "power.json"
NOTES = "notes"


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """Components of the plan to be frozen.

    Parameters
    ----------
    study_name : str
        A study file, or the name of a study that comes with Slipscale.
    population : Population
        Population from which the simulated participants are drawn.
    stopping_rule : str
        Rule for ending data collection. If empty, data collection ends after the planned number of
        participants.
    existing_data, sample_size : str
        Statements on data that already exist and on the rationale for the sample size; empty if not
        given.
    power : Path or None
        Folder with a finished result of `slipscale power --out`.
    notes : Path or None
        Text file with hypotheses and other information.
    """

    study_name: str
    population: Population
    stopping_rule: str = ""
    existing_data: str = ""
    sample_size: str = ""
    power: Path | None = None
    notes: Path | None = None


def freeze(wanted: Wanted, when: datetime) -> tuple[Manifest, dict[str, bytes]]:
    """Return the manifest of a plan, and all files of its bundle keyed by name.

    With the same plan and software, the bundle is identical byte for byte, except for the date.

    Parameters
    ----------
    wanted : Wanted
    when : datetime
        Current time, including the time zone.

    Raises
    ------
    UserError
        If the study has an error, a file cannot be read, the power result belongs to another study,
        or the study cannot be simulated.
    """
    study, text = read_study(wanted.study_name)
    # The file is read again, because the study's complete text contains file contents, not names.
    named = named_files(study_text(wanted.study_name), _folder_of(wanted.study_name))
    analysis = simulated(wanted.study_name, wanted.population)
    files: dict[str, tuple[bytes, Role, str]] = {STUDY: (text.encode(), "study", "")}
    files |= {name: (f.content, "named by the study", f.key) for name, f in _placed(named)}
    population = wanted.population.model_dump_json(indent=2) + "\n"
    files["population.json"] = (population.encode(), "population", "")
    files["packages.txt"] = (_packages().encode(), "packages", "")
    if wanted.power:
        for name, content in _power(wanted.power, study.name).items():
            files[f"{POWER}/{name}"] = (content, "power", "")
    if wanted.notes:
        files[f"{NOTES}{wanted.notes.suffix}"] = (_notes(wanted.notes).encode(), "notes", "")
    stopping = wanted.stopping_rule or (
        f"Data are collected from {study.participants} participants, whatever the results. Nobody "
        "inspects the results before data collection ends."
    )
    plan = Manifest(
        frozen_utc=when.isoformat(timespec="seconds"),
        name=study.name,
        title=study.title,
        participants=study.participants,
        sessions=study.sessions,
        runs=study.runs,
        seed=study.seed,
        language=study.language,
        stopping_rule=stopping,
        existing_data=wanted.existing_data,
        sample_size=wanted.sample_size,
        choices=study.analysis,
        chosen=tuple(sorted(study.analysis.model_fields_set)),
        normalisation=analysis.rule,
        tests=with_results(analysis),
        software=software(analysis),
        files=_listed(files),
    )
    page = render(
        plan,
        analysis,
        {name: entry[0] for name, entry in files.items()},
        study=wanted.study_name,
        people=wanted.population.name,
    )
    files[PAGE] = (page.encode(), "page", "")
    plan = plan.model_copy(update={"files": _listed(files)}).signed()
    contents = {name: content for name, (content, _, _) in files.items()}
    return plan, {**contents, MANIFEST: plan.text().encode()}


def simulated(study_name: str, population: Population) -> Analysis:
    """Analyse a simulated study, to show how real data will be analysed."""
    plans = pilot_plans(
        study_name, participants=None, seed=None, language=None, population=population
    )
    check_answered(plans[0])
    with tempfile.TemporaryDirectory(prefix="slipscale-") as temporary:
        folder = Path(temporary) / "study"
        sessions = bool(why_sessions(plans[0]))
        write_simulated(folder, plans, population, sessions=sessions)
        return analyse(folder)


def _listed(files: dict[str, tuple[bytes, Role, str]]) -> tuple[FrozenFile, ...]:
    return tuple(
        FrozenFile(path=name, sha256=sha256(content), role=role, named_by=key)
        for name, (content, role, key) in sorted(files.items())
    )


def _folder_of(study_name: str) -> Path | None:
    path = Path(study_name)
    return path.parent if path.is_file() else None


def _placed(named: list[NamedFile]) -> list[tuple[str, NamedFile]]:
    """Pair each named file with a unique path in the bundle."""
    taken: dict[str, int] = {}
    found = []
    for file in named:
        times = taken[file.path.name] = taken.get(file.path.name, 0) + 1
        name = file.path.name if times == 1 else f"{file.path.stem}_{times}{file.path.suffix}"
        found.append((f"study/files/{name}", file))
    return found


def _packages() -> str:
    """Return the names and versions of all installed packages, one per line."""
    found = {each.name.lower(): each.version for each in distributions() if each.name}
    return "".join(f"{name}=={version}\n" for name, version in sorted(found.items()))


def _power(folder: Path, study: str) -> dict[str, bytes]:
    """Return the files in a finished power result, which must belong to the study.

    Raises
    ------
    UserError
        If the folder does not contain a power result, or the result belongs to another study.
    """
    try:
        power = json.loads((folder / POWER_RESULT).read_text(encoding="utf-8"))
        of = str(power["study"])
        found = {path.name: path.read_bytes() for path in sorted(folder.iterdir())
                 if path.is_file()}  # fmt: skip
    except OSError as error:
        raise UserError(
            "--power {filename}: {reason}; expected the folder that slipscale power --out wrote",
            filename=error.filename or folder,
            reason=error.strerror,
        ) from None
    except (ValueError, KeyError, TypeError):
        raise UserError(
            "--power {folder}: {file} is not a result of slipscale power",
            folder=folder,
            file=POWER_RESULT,
        ) from None
    if of != study:
        raise UserError(
            "--power {folder}: belongs to study '{computed_for}'; expected '{study}'",
            folder=folder,
            computed_for=of,
            study=study,
        )
    return found


def _notes(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise UserError(
            "--notes {path}: {reason}; expected a text file", path=path, reason=reason
        ) from None
