"""The laboratory folder, whose ``slipscale.toml`` sets the defaults of all commands."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

from pydantic import Field, ValidationInfo, field_validator

from slipscale.experiments.dataset.files import write_file
from slipscale.experiments.languages.texts import CODE
from slipscale.experiments.study.file import read_study
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError
from slipscale.faults.frozen_table import FrozenTable, setting
from slipscale.faults.toml_file import parse_toml, read_toml
from slipscale.hardware.registry import backend_names, unknown_backend

FILE = "slipscale.toml"
Text = Annotated[str, Field(min_length=1)]


class LabFile(FrozenTable):
    """Contents of ``slipscale.toml``. Paths are relative to the folder that contains the file."""

    study: Text = setting(
        "biet2007", "A TOML file, or the name of a study that comes with Slipscale."
    )
    plate: Text = setting(
        "mock", "The plate's SPEC, with its calibration: serial:/dev/ttyACM0,calibration=plate.toml"
    )
    screen: Annotated[int, Field(strict=True, ge=0)] = setting(
        0, "Number of the participant's monitor, from 0.", unit="none"
    )
    windowed: Annotated[bool, Field(strict=True)] = setting(
        False, "Whether to run in a window instead of full screen."
    )
    language: str = setting(
        "", "Language of the text shown to participants; default: the study's language."
    )
    markers: tuple[Text, ...] = setting(
        (), "Outputs for event markers, one SPEC each: lsl, serial:PORT, parallel:ADDRESS."
    )
    position: str = setting("", "Finger-position sensor; default: the study's sensor.")
    force: str = setting("", "Finger-force sensor; default: the study's sensor.")
    sound_required: Annotated[bool, Field(strict=True)] = setting(
        False,
        "Whether every session with masking noise requires a sound device; if false, the study's "
        "own setting applies.",
    )
    data: Text = setting("data", "Folder for participants' data.")
    pilots: Text = setting("pilots", "Folder for pilots, including rehearsals with a person.")
    backup: str = setting(
        "", "Folder on another disk, to which each run's journal is copied at the end."
    )

    @field_validator("plate")
    @classmethod
    def _known(cls, value: str) -> str:
        if value.partition(":")[0] not in backend_names():
            raise ValueError(unknown_backend(value))
        return value

    @field_validator("language")
    @classmethod
    def _a_code(cls, value: str) -> str:
        # A study can define further languages.
        if value and not CODE.fullmatch(value):
            raise ValueError("expected a language code, such as en, fr or de")
        return value

    @field_validator("pilots")
    @classmethod
    def _apart(cls, value: str, info: ValidationInfo) -> str:
        if Path(value) == Path(info.data.get("data", "")):
            raise ValueError("expected a folder other than the folder for participants' data")
        return value


def read_lab(folder: Path) -> LabFile | None:
    """Read the ``slipscale.toml`` of a folder; return None if there is none.

    Raises
    ------
    UserError
        If the file is invalid.
    """
    path = folder / FILE
    return read_toml(path, LabFile) if path.exists() else None


def init(folder: Path, answers: dict[str, str], ask: Callable[[str, str], str] | None) -> LabFile:
    """Write the ``slipscale.toml`` of a laboratory folder.

    Parameters
    ----------
    folder : Path
        A new folder, or an existing folder without a ``slipscale.toml``.
    answers : dict
        Values given on the command line, by settings key.
    ask : callable or None
        Called with a question and the default for an empty answer; returns the answer. If ``ask``
        is None, settings that are not in ``answers`` keep their defaults.

    Raises
    ------
    UserError
        If the file already exists or cannot be written, or an answer is invalid.
    """
    path = folder / FILE
    if path.exists():
        raise UserError("{path} already exists; edit it, or name another folder", path=path)
    given = dict(answers)
    for key, question in QUESTIONS.items():
        if ask and key not in given:
            given[key] = ask(question, str(LabFile.model_fields[key].default))
    text = rendered(given)
    lab = parse_toml(text, FILE, LabFile)
    _check_study(folder, lab)
    write_file(path, text)
    return lab


def _check_study(folder: Path, lab: LabFile) -> None:
    """Raise `UserError` if the study cannot be read or has no texts in the language."""
    own = folder / lab.study
    study, study_text = read_study(str(own) if own.is_file() else lab.study)
    RunPlan(
        study_name=study.name,
        study_text=study_text,
        participant="01",
        seed=study.seed,
        language=lab.language or study.language,
        mode="pilot",
    ).person_questions()


def lab_text(folder: Path) -> str:
    """Return the text of a folder's ``slipscale.toml``; empty if there is none."""
    try:
        return (folder / FILE).read_text(encoding="utf-8-sig", errors="replace")
    except OSError:
        return ""


def write_settings(folder: Path, lab: LabFile) -> None:
    """Write settings to a folder's ``slipscale.toml``, and keep its comments and order.

    Raises
    ------
    UserError
        If the existing file is invalid, the study or the backup folder cannot be used, or the file
        cannot be written.
    """
    import tomlkit

    read_lab(folder)
    _check_study(folder, lab)
    if lab.backup and not (folder / lab.backup).is_dir():
        raise UserError(
            "backup: {backup}: no such folder; connect its disk, or create it", backup=lab.backup
        )
    document = tomlkit.parse(lab_text(folder) or rendered({}))
    for key, value in lab.model_dump(mode="json").items():
        if key not in document or document[key] != value:
            document[key] = value
    write_file(folder / FILE, tomlkit.dumps(document))


QUESTIONS = {
    "study": "Which study? A TOML file, or the name of a study that comes with Slipscale",
    "plate": "Which plate? Enter mock, or a port and a calibration, such as "
    "serial:/dev/ttyACM0,calibration=plate.toml",
    "screen": "Which screen does the participant see? 0 is the first screen",
    "language": "Which language do participants read? Leave empty for the study's language",
    "data": "In which folder are participants' data saved?",
    "backup": "To which folder on another disk is each run copied? Leave empty for no copies",
}


def rendered(given: dict[str, str]) -> str:
    """Return the text of a new ``slipscale.toml`` that explains every key."""
    import tomlkit

    document = tomlkit.document()
    document.add(
        tomlkit.comment("Default options for slipscale commands that are started in this folder.")
    )
    document.add(tomlkit.comment("Options on the command line override these defaults."))
    for key, field in LabFile.model_fields.items():
        value = given.get(key)
        document.add(tomlkit.nl())
        document.add(tomlkit.comment(str(field.description)))
        default = list(field.default) if isinstance(field.default, tuple) else field.default
        document.add(key, default if value is None else _typed(value, default))
    return tomlkit.dumps(document)


def _typed(value: str, default: object) -> object:
    """Convert an answer to the type of its key; an invalid answer is returned unchanged."""
    if isinstance(default, bool):
        return {"true": True, "false": False}.get(value, value)
    if isinstance(default, int) and value.isdecimal():
        return int(value)
    return value
