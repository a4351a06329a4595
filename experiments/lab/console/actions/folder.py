"""Save settings and studies, test a plate, compute power, freeze the plan, and run a pilot."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

from pydantic import Field, field_validator

from slipscale.experiments.dataset.files import write_file
from slipscale.experiments.lab.console.actions.desk import Actions, Desk
from slipscale.experiments.lab.console.actions.forms import (
    LARGEST_STUDY,
    Digest,
    Form,
    Nothing,
    Words,
    text_hash,
    unused,
)
from slipscale.experiments.lab.console.actions.own_text import with_texts
from slipscale.experiments.lab.console.actions.study_changes import Change, changed
from slipscale.experiments.lab.console.state import PLANNING, Snapshot, frozen_plans
from slipscale.experiments.lab.folder import FILE, LabFile, lab_text, read_lab, write_settings
from slipscale.experiments.running.run_state import studies
from slipscale.experiments.study.file import parse_whole, shipped_studies, study_text
from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.toml_file import toml_table

# Values of the planning sliders, which require less than a minute of computing time.
GRID = (
    *("--participants", "6", "8", "12", "16", "20", "24", "32", "40"),
    *("--repetitions", "1", "2", "3", "--effect", "1", "0.75", "0.5", "--studies", "300"),
)


class Settings(Form):
    """New settings for the laboratory folder, and a digest of the settings that the page showed."""

    settings: LabFile
    before: Digest

    @field_validator("settings", mode="before")
    @classmethod
    def _listed(cls, value: object) -> object:
        """Convert typed markers, separated by spaces, to a list."""
        if isinstance(value, dict) and isinstance(value.get("markers"), str):
            return value | {"markers": value["markers"].split()}
        return value


class Test(Form):
    """Test a plate before saving it in the settings."""

    plate: Annotated[str, Field(min_length=1, max_length=300)]


def _settings(desk: Desk, request: Settings) -> str:
    desk.check_free(desk.state.now(fresh=True))  # also works in a folder without settings
    if text_hash(lab_text(Path())) != request.before:
        raise UserError(
            "{file} was changed on disk after this page was loaded; reload the page, and make "
            "the change again",
            file=FILE,
        )
    write_settings(Path(), request.settings)
    desk.state.now(fresh=True)
    return Message("saved: {file}", file=FILE)


def _test(desk: Desk, request: Test) -> str:
    desk.check_free(desk.state.now(fresh=True))
    words = ("check", "--json", "--only", "plate", f"--plate={request.plate}")
    desk.jobs.start("test", "the test of the plate", *words)
    return "testing"


class Freeze(Form):
    """Freeze the plan, with the further information that a registry requires."""

    sample_size: Words
    existing_data: Words
    stopping: Words


class Pilot(Form):
    """Run a simulated pilot."""

    participants: Annotated[int, Field(ge=1, le=500)]
    seed: Annotated[int, Field(ge=0, le=2**31)]


class Study(Form):
    """New content of a study file, and a digest of the content that the page showed."""

    text: Annotated[str, Field(max_length=LARGEST_STUDY)]
    before: Digest


class OwnText(Form):
    """Change one text of the study in each language; see `with_texts`."""

    key: Annotated[str, Field(max_length=200)]
    texts: dict[Annotated[str, Field(max_length=40)], Annotated[str, Field(max_length=20_000)]]
    before: Digest


class Copy(Form):
    """Copy the study under another name, and use the copy in this folder.

    ``template`` is the shipped study on which the text is based; empty for the folder's own study.
    """

    name: Annotated[str, Field(pattern="^[A-Za-z][A-Za-z0-9_-]{0,60}$")]
    text: Annotated[str, Field(max_length=LARGEST_STUDY)]
    template: Annotated[str, Field(max_length=100)] = ""


def power_folder(study_text: str) -> Path:
    """Return the folder for power results; each version of a study has its own folder."""
    return PLANNING / f"power-{text_hash(study_text)[:12]}"


def why_not_edited(found: Snapshot) -> str:
    """Return the reason why the study file cannot be edited here; empty if it can."""
    name = found.defaults.study
    if name in shipped_studies():
        return Message("'{name}' comes with Slipscale: make a copy, and edit the copy", name=name)
    if found.study and found.study.name in studies(found.defaults.data):
        return Message(
            "'{name}' already has data, which would not match a changed study; make a copy",
            name=name,
        )
    return ""


def _power(desk: Desk, _: Nothing) -> str:
    found = desk.now()
    out = power_folder(found.study_text)
    planned = str(found.study.participants) if found.study else GRID[1]
    grid = GRID if planned in GRID[: GRID.index("--repetitions")] else (GRID[0], planned, *GRID[1:])
    words = ("power", found.defaults.study, *grid, "--steps", "--json", "--out", str(out))
    desk.jobs.start("power", "the power", *words)
    return "computing"


def _freeze(desk: Desk, request: Freeze) -> str:
    found = desk.now()
    if not all(
        (request.sample_size.strip(), request.existing_data.strip(), request.stopping.strip())
    ):
        raise UserError(
            "a plan states why this sample size, which data exist already, and when data "
            "collection ends; answer all three questions"
        )
    power = power_folder(found.study_text)
    options = {
        "--sample-size": request.sample_size,
        "--existing-data": request.existing_data,
        "--stopping": request.stopping,
    }
    words = [f"{option}={text.strip()}" for option, text in options.items() if text.strip()]
    if (power / "power.json").is_file():
        words += ["--power", str(power)]
    PLANNING.mkdir(exist_ok=True)
    path = unused(f"{PLANNING}/plan-{{:03d}}.zip", len(frozen_plans()) + 1)
    study = found.defaults.study
    desk.jobs.start("freeze", "the plan", "study", "freeze", study, "--out", str(path), *words)
    return Message("freezing: {path}", path=path)


def _pilot(desk: Desk, request: Pilot) -> str:
    desk.now()
    numbers = ("--participants", str(request.participants), "--seed", str(request.seed))
    desk.jobs.start("pilot", "the pilot", "pilot", *numbers, parts=request.participants)
    return "the pilot is running"


def _save(desk: Desk, request: Study) -> str:
    # `desk.now` would raise an error for an invalid study, which this request may correct.
    path = _study_file(desk.state.now(fresh=True))
    if text_hash(study_text(str(path))) != request.before:
        raise UserError(
            "{path}: was changed on disk after this page was loaded; copy your text, reload the "
            "page, and edit it again",
            path=path,
        )
    parse_whole(request.text, str(path))
    write_file(path, request.text)
    desk.now()
    return Message("saved: {path_name}", path_name=path.name)


def _own_text(desk: Desk, request: OwnText) -> str:
    path = _study_file(desk.state.now(fresh=True))
    text = with_texts(study_text(str(path)), request.key, request.texts)
    return _save(desk, Study(text=text, before=request.before))


def _study_file(found: Snapshot) -> Path:
    """Return the path of the study file; raise `UserError` if it may not be edited."""
    if why := found.problem if found.defaults.file is None else why_not_edited(found):
        raise UserError(why)
    return Path(found.defaults.study)


def _copy(desk: Desk, request: Copy) -> str:
    found = desk.now()
    path = Path(f"{request.name}.toml")
    if path.exists() or request.name in shipped_studies():
        raise UserError("{path}: already exists; choose another name", path=path)
    parse_whole(request.text, path.name)
    label = re.sub("[^A-Za-z0-9]+", "_", request.name)
    text = re.sub(r"(?m)^name\s*=.*$", f'name = "{label}"', request.text, count=1)
    original = toml_table(study_text(request.template or found.defaults.study), path.name)
    text = _without_authors(text, original, request.name)
    parse_whole(text, path.name)
    write_file(path, text)
    lab = read_lab(Path())
    try:
        desk.check_free(found)
    except UserError:
        lab = None
    if lab is None:
        return Message("wrote {path}; to use it, select it on the Settings page", path=path)
    write_settings(Path(), lab.model_copy(update={"study": str(path)}))
    desk.now()
    return Message(
        "wrote {path}, which this folder now uses; enter its title and its authors", path=path
    )


def _without_authors(text: str, original: Mapping[str, object], name: str) -> str:
    """Remove the original's authors from a copy; replace its title by the copy's name."""
    own = toml_table(text, name)
    for key, value in (("authors", ""), ("title", name)):
        if key in own and own[key] == original.get(key):
            text = changed(text, Change(what="set", place=(key,), value=value))
    return text


ACTIONS: Actions = {
    "settings": (Settings, _settings),
    "test": (Test, _test),
    "power": (Nothing, _power),
    "freeze": (Freeze, _freeze),
    "pilot": (Pilot, _pilot),
    "save": (Study, _save),
    "text": (OwnText, _own_text),
    "copy": (Copy, _copy),
}
