"""A study: what to run, frozen, read from TOML, validated whole with every fault named at once."""

from __future__ import annotations

import hashlib
import re
import tomllib
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    SerializeAsAny,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from experiments.analysis_choices import AnalysisChoices
from experiments.protocols.base import (
    Amplitude,
    AtLeastOne,
    Count,
    Flag,
    Label,
    Options,
    Positive,
    Seconds,
    Words,
    load_protocol,
    protocol_names,
)
from experiments.texts import languages, load_texts
from experiments.textures import Texture
from faults import UserError
from hardware.driver import PlateLimits

if TYPE_CHECKING:
    from collections.abc import Iterable

    from stimuli.texture import Grating

# Where a fault is in the file, and pydantic's own record of it.
Fault = tuple[tuple[Any, ...], dict[str, Any]]
# Columns of participants.tsv that Slipscale fills itself.
TAKEN = ("participant_id", "mode", "complete")


class PersonQuestion(BaseModel):
    """A question about the participant, with given answers; names are never asked for.

    ``prompt`` defaults to the shipped text ``about_you.<name>``.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: Label
    options: Annotated[tuple[Words, ...], Field(min_length=2, max_length=9)]
    prompt: str = ""

    @field_validator("options")
    @classmethod
    def _distinct(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        if len(set(value)) < len(value):
            raise ValueError("expected options that are all different")
        return value

    @field_validator("name")
    @classmethod
    def _free(cls, value: str) -> str:
        if value in TAKEN:
            raise ValueError("expected another name: this one is a column already")
        return value


class MaskingNoise(BaseModel):
    """Pink noise in the headphones while the plate may sound."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    level_db: Annotated[float, Field(strict=True, le=0, ge=-100)] = -20.0
    fade_s: Seconds = 0.5
    required: Flag = False


class PlateSettings(BaseModel):
    """The plate's limits, where they differ from the shipped ones."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    amplitude_um_pp: Positive = PlateLimits().amplitude_um_pp


class Study(BaseModel):
    """What to run.

    Parameters
    ----------
    name, title : str
        A short label, and words for people.
    authors : tuple of str
    license : str
        For the data set's description.
    language : str
        What the participant reads.
    seed : int
        All orders, and all that is simulated, follow from it.
    participants : int
        How many are planned; a pilot runs as many.
    amplitudes_um_pp : tuple of float
        The surfaces, µm peak to peak.
    textures : tuple of Texture
        Surfaces that are modulated, for the protocols that present them.
    tasks : tuple of Options
        The protocols, in order, each with its options.
    task_order : {"fixed", "counterbalanced"}
        Counterbalanced: every other participant has the tasks in reverse.
    about_you : tuple of PersonQuestion
        Asked before the tasks.
    masking_noise : MaskingNoise, optional
    plate : PlateSettings
        Limits that every amplitude of the study must keep.
    analysis : AnalysisChoices
        How the data will be analysed, frozen before anything is looked at.
    texts : dict
        Texts in place of the shipped ones, by language.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: Label
    title: Words
    authors: tuple[Words, ...] = ()
    license: Words = "not decided"
    language: str = "en"
    seed: Count = 1
    participants: AtLeastOne = 12
    plate: PlateSettings = PlateSettings()
    amplitudes_um_pp: Annotated[tuple[Amplitude, ...], Field(min_length=1)]
    textures: tuple[Texture, ...] = ()
    tasks: Annotated[tuple[SerializeAsAny[Options], ...], Field(min_length=1)]
    task_order: Literal["fixed", "counterbalanced"] = "fixed"
    about_you: tuple[PersonQuestion, ...] = ()
    masking_noise: MaskingNoise | None = None
    analysis: AnalysisChoices = AnalysisChoices()
    texts: dict[str, dict[str, Any]] = Field(default_factory=dict)

    @field_validator("language")
    @classmethod
    def _shipped(cls, value: str) -> str:
        if value not in languages():
            raise ValueError(f"expected one of {', '.join(languages())}")
        return value

    @field_validator("amplitudes_um_pp")
    @classmethod
    def _presentable(cls, value: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        if len(set(value)) < len(value):
            raise ValueError("expected amplitudes that are all different")
        # Without a valid [plate] its own fault is told, and nothing can be said here.
        if isinstance(plate := info.data.get("plate"), PlateSettings):
            _within(plate, value)
        return value

    @field_validator("textures")
    @classmethod
    def _playable(cls, value: tuple[Texture, ...], info: ValidationInfo) -> tuple[Texture, ...]:
        if len({texture.name for texture in value}) < len(value):
            raise ValueError("expected names that are all different")
        if isinstance(plate := info.data.get("plate"), PlateSettings):
            _within(plate, [texture.grating().amplitude_um_pp for texture in value])
        return value

    @field_validator("tasks", mode="before")
    @classmethod
    def _by_protocol(cls, tables: Any) -> Any:
        if not isinstance(tables, list | tuple):
            raise ValueError("expected [[tasks]] tables, each with a protocol")  # noqa: TRY004 - pydantic gathers ValueErrors
        faults: list[Fault] = []
        tasks = []
        for place, table in enumerate(tables):
            try:
                tasks.append(_task(table))
            except ValidationError as error:
                faults += [(("tasks", place, *f["loc"]), dict(f)) for f in error.errors()]
            except ValueError as error:
                faults.append((("tasks", place, "protocol"), {"msg": str(error)}))
        if faults:
            raise _Faults(faults)
        return tasks

    @model_validator(mode="after")
    def _possible(self) -> Self:
        for language, replacements in self.texts.items():
            try:
                load_texts(language, replacements)
            except UserError as error:
                raise ValueError(str(error)) from error
        asked = [question.name for question in self.about_you]
        for name in sorted({name for name in asked if asked.count(name) > 1}):
            raise ValueError(f"about_you: '{name}' is asked more than once")
        protocols = [task.protocol for task in self.tasks]
        if len(set(protocols)) < len(protocols):
            # Their trials would fall into one table, under the same numbers.
            raise ValueError("tasks: expected each protocol once; repetitions or series repeat it")
        shipped = load_texts(self.language)
        for question in self.about_you:
            if not question.prompt and f"about_you.{question.name}" not in shipped:
                raise ValueError(f"about_you: '{question.name}' needs a prompt of its own")
        for task in self.tasks:
            for key in ("standard_um_pp", "start_um_pp"):
                _within(self.plate, [getattr(task, key, None) or 0.0])
        if self.textures and not any(load_protocol(t.protocol).textures for t in self.tasks):
            raise ValueError("textures: no task presents them; magnitude_estimation would")
        return self

    @property
    def gratings(self) -> tuple[Grating, ...]:
        """The textures as surfaces, labelled T1, T2, ... in the order of the study file."""
        return tuple(t.grating(f"T{number}") for number, t in enumerate(self.textures, start=1))


def _within(plate: PlateSettings, amplitudes_um_pp: Iterable[float]) -> None:
    """Raise ValueError unless the plate can make all these amplitudes."""
    beyond = [amplitude for amplitude in amplitudes_um_pp if amplitude > plate.amplitude_um_pp]
    if beyond:
        raise ValueError(
            f"{', '.join(map(str, beyond))} is beyond the plate's {plate.amplitude_um_pp} µm p-p"
        )


class _Faults(ValueError):
    """Faults inside the tasks, with their places."""

    def __init__(self, faults: list[Fault]) -> None:
        super().__init__("faults in the tasks")
        self.faults = faults


def _task(table: Any) -> Options:
    """Return the options of one [[tasks]] table."""
    if isinstance(table, Options):
        return table
    name = table.get("protocol") if isinstance(table, dict) else None
    if name not in protocol_names():
        raise ValueError(f"expected one of {', '.join(protocol_names())}, got {name!r}")
    return load_protocol(name).options.model_validate(table)


@lru_cache(maxsize=16)
def parse_study(text: str, source: str) -> Study:
    """Return the study that a TOML text describes.

    Parameters
    ----------
    text : str
        The study file's text.
    source : str
        Its name, for messages.

    Raises
    ------
    UserError
        One message that lists every fault with its line or key and what was expected.
    """
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{source} is not TOML: {error}") from None
    try:
        return Study.model_validate(table)
    except ValidationError as error:
        faults: list[Fault] = []
        for fault in error.errors():
            inner = fault.get("ctx", {}).get("error")
            faults += inner.faults if isinstance(inner, _Faults) else [(fault["loc"], dict(fault))]
        lines = sorted({_sentence(text, place, fault) for place, fault in faults})
        many = "a fault" if len(lines) == 1 else f"{len(lines)} faults"
        found = "".join(f"\n  {sentence}" for _, sentence in lines)
        raise UserError(f"{source} has {many}:{found}") from None


def _sentence(text: str, place: tuple[Any, ...], fault: dict[str, Any]) -> tuple[int, str]:
    """Return a fault's line (0: none) and the sentence about it."""
    where = ".".join(str(part + 1) if isinstance(part, int) else part for part in place)
    message = fault["msg"].removeprefix("Value error, ")
    if fault.get("type") == "extra_forbidden":
        message = "there is no such key"
    elif fault.get("type") == "missing":
        message = "is missing"
    elif isinstance(fault.get("input"), str | int | float):
        message = f"{message[0].lower()}{message[1:]}, got {fault['input']!r}"
    line = line_of(text, place)
    spot = f"line {line}, " if line else ""
    return line, f"{spot}{where}: {message}" if where else f"{spot}{message}"


def line_of(text: str, place: tuple[Any, ...]) -> int:
    r"""Return the line in a TOML text where a key stands, or its table, or 0.

    >>> line_of("a = 1\n[[tasks]]\nb = 2", ("tasks", 0, "b"))
    3
    """
    seen: dict[str, int] = {}
    table: tuple[Any, ...] = ()
    nearest = 0
    for number, line in enumerate(text.splitlines(), start=1):
        if header := re.match(r"\s*\[(\[?)\s*([\w.\-]+)\s*\]", line):
            name = header[2]
            seen[name] = seen.get(name, -1) + 1
            table = (*name.split("."), *([seen[name]] if header[1] else []))
            if table == place[: len(table)]:
                nearest = number
        elif (key := re.match(r"\s*([\w\-]+)\s*=", line)) and (*table, key[1]) == place[
            : len(table) + 1
        ]:
            return number
    return nearest


def shipped_studies() -> list[str]:
    """Return the names of the studies that come with Slipscale.

    >>> "biet2007" in shipped_studies()
    True
    """
    names = (entry.name for entry in files("experiments").joinpath("studies").iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def study_text(name: str) -> str:
    """Return the text of a study file, or of a shipped study by name.

    Raises
    ------
    UserError
        There is neither, or the file cannot be read as text.
    """
    if name in shipped_studies():
        return files("experiments").joinpath("studies", f"{name}.toml").read_text(encoding="utf-8")
    try:
        return Path(name).read_text(encoding="utf-8-sig")  # Windows' editors begin with a mark
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise UserError(
            f"study '{name}': {reason}; expected a TOML file or one of the shipped studies: "
            f"{', '.join(shipped_studies())}"
        ) from None


def read_study(name: str) -> tuple[Study, str]:
    """Return a study and the text it was read from."""
    text = study_text(name)
    return parse_study(text, name), text


def study_hash(text: str) -> str:
    """Return the SHA-256 of a study file's text, in hexadecimal."""
    return hashlib.sha256(text.encode()).hexdigest()
