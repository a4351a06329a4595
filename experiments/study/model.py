"""A study: what to run, frozen, and validated whole.

Whatever is wrong is found at once, each fault with its place; only what cannot be judged for
another fault (the limits of a plate whose own table is wrong) waits for that.
"""

from __future__ import annotations

import math
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

from experiments.languages.texts import (
    FEWEST_ANSWERS,
    NUMBER_KEYS,
    languages,
    shipped_texts,
    text_faults,
)
from experiments.protocols.base import (
    Amplitude,
    AtLeastOne,
    Context,
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
from experiments.study.analysis_choices import AnalysisChoices
from faults import UserError
from faults.validation import refuse
from hardware.limits import PlateLimits
from stimuli.texture import Grating, Waveform

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from faults.toml_lines import Place
    from faults.validation import Fault


# Columns of participants.tsv that Slipscale fills itself.
TAKEN = ("participant_id", "mode", "complete")


class PersonQuestion(BaseModel):
    """A question about the participant, with given answers; names are never asked for.

    ``prompt`` defaults to the shipped text ``about_you.<name>``.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: Label
    options: Annotated[tuple[Words, ...], Field(min_length=FEWEST_ANSWERS, max_length=NUMBER_KEYS)]
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


class Texture(BaseModel):
    """A grating that the study presents as one more surface.

    Parameters
    ----------
    name : str
        What the data call it.
    spatial_period_mm : float
        Length of one period.
    mean_um_pp, depth_um_pp : float
        The amplitude swings from mean - depth to mean + depth, µm peak to peak.
    waveform : {"sine", "square", "triangle", "sawtooth"}
    finger_speed_mm_s : float
        No plate tracks the finger: the texture is played as a finger of this speed would meet
        it. Stated in every study, because the data depend on it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: Label
    spatial_period_mm: Positive
    mean_um_pp: Positive
    depth_um_pp: Positive
    waveform: Waveform = "sine"
    finger_speed_mm_s: Positive

    @model_validator(mode="after")
    def _playable(self) -> Self:
        try:
            self.grating().loop()
        except UserError as error:
            raise ValueError(str(error)) from error
        return self

    def grating(self, label: str = "") -> Grating:
        """Return the surface, with a label that does not tell which it is."""
        return Grating(label=label, **self.model_dump())


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
        faults = list(_beyond(("amplitudes_um_pp",), info, *value))
        if len(set(value)) < len(value):
            faults.append((("amplitudes_um_pp",), {"msg": "expected them to be all different"}))
        refuse(faults)
        return value

    @field_validator("textures")
    @classmethod
    def _playable(cls, value: tuple[Texture, ...], info: ValidationInfo) -> tuple[Texture, ...]:
        faults = list(_named_twice("textures", [texture.name for texture in value]))
        for number, texture in enumerate(value):
            faults += _beyond(("textures", number), info, texture.grating().amplitude_um_pp)
        refuse(faults)
        return value

    @field_validator("tasks", mode="before")
    @classmethod
    def _by_protocol(cls, tables: Any, info: ValidationInfo) -> Any:
        if not isinstance(tables, list | tuple):
            raise ValueError("expected [[tasks]] tables, each with a protocol")  # noqa: TRY004 - pydantic gathers ValueErrors
        faults: list[Fault] = []
        tasks: list[Options] = []
        for number, table in enumerate(tables):
            place = ("tasks", number)
            try:
                task = _task(table)
            except ValidationError as error:
                faults += [((*place, *f["loc"]), dict(f)) for f in error.errors()]
            except ValueError as error:
                faults.append(((*place, "protocol"), {"msg": str(error)}))
            else:
                faults += _impossible(place, task, tasks, info)
                tasks.append(task)
        refuse(faults or _unpresented(tasks, info))
        return tasks

    @field_validator("about_you")
    @classmethod
    def _answerable(
        cls, value: tuple[PersonQuestion, ...], info: ValidationInfo
    ) -> tuple[PersonQuestion, ...]:
        refuse(_unanswerable(value, info))
        return value

    @field_validator("texts")
    @classmethod
    def _readable(cls, value: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
        refuse(_unreadable(value))
        return value

    @property
    def gratings(self) -> tuple[Grating, ...]:
        """The textures as surfaces, labelled T1, T2, ... in the order of the study file."""
        return tuple(t.grating(f"T{number}") for number, t in enumerate(self.textures, start=1))


# What is wrong across keys. Where the other key has a fault of its own, that is told and nothing
# can be said here: `info.data` holds only what is valid.


def _named_twice(table: str, names: list[str]) -> Iterator[Fault]:
    for number, name in enumerate(names):
        if name in names[:number]:
            yield (table, number, "name"), {"msg": f"there is a '{name}' already"}


def _beyond(place: Place, info: ValidationInfo, *amplitudes_um_pp: float) -> Iterator[Fault]:
    plate = info.data.get("plate")
    limit_um_pp = plate.amplitude_um_pp if plate else math.inf
    if beyond := ", ".join(str(each) for each in amplitudes_um_pp if each > limit_um_pp):
        yield place, {"msg": f"{beyond} is beyond the plate's {limit_um_pp} µm p-p"}


def _impossible(
    place: Place, task: Options, before: list[Options], info: ValidationInfo
) -> Iterator[Fault]:
    """Yield what makes a task impossible in this study."""
    if any(task.protocol == other.protocol for other in before):
        # Their trials would fall into one table, under the same numbers.
        once = "expected each protocol once; repetitions or series repeat it"
        yield (*place, "protocol"), {"msg": once}
    protocol = load_protocol(task.protocol)
    for key in protocol.amplitudes:
        yield from _beyond((*place, key), info, getattr(task, key, None) or 0.0)
    amplitudes_um_pp, textures = info.data.get("amplitudes_um_pp"), info.data.get("textures")
    if amplitudes_um_pp is None or textures is None:
        return
    context = Context(
        seed=0,
        participant="",
        row=0,
        amplitudes_um_pp=amplitudes_um_pp,
        texts={},
        textures=tuple(texture.grating() for texture in textures),
    )
    if not protocol.trials(task, context):
        yield place, {"msg": "has no trials with these amplitudes"}


def _unpresented(tasks: list[Options], info: ValidationInfo) -> Iterator[Fault]:
    presented = any(load_protocol(task.protocol).textures for task in tasks)
    if info.data.get("textures") and not presented:
        yield ("textures", 0), {"msg": "no task presents them; magnitude_estimation would"}


def _unanswerable(questions: Sequence[PersonQuestion], info: ValidationInfo) -> Iterator[Fault]:
    yield from _named_twice("about_you", [question.name for question in questions])
    if language := info.data.get("language"):
        shipped = shipped_texts(language)
        for number, question in enumerate(questions):
            if not question.prompt and f"about_you.{question.name}" not in shipped:
                own = f"'{question.name}' needs a prompt of its own"
                yield ("about_you", number, "prompt"), {"msg": own}


def _unreadable(texts: dict[str, dict[str, Any]]) -> Iterator[Fault]:
    for language, own in texts.items():
        place = ("texts", language)
        if language not in languages():
            yield place, {"msg": f"expected one of {', '.join(languages())}"}
            continue
        for key, sentence in text_faults(language, own):
            yield (*place, *key.split(".")), {"msg": sentence}


def _task(table: Any) -> Options:
    """Return the options of one [[tasks]] table."""
    if isinstance(table, Options):
        return table
    name = table.get("protocol") if isinstance(table, dict) else None
    if name not in protocol_names():
        raise ValueError(f"expected one of {', '.join(protocol_names())}, got {name!r}")
    return load_protocol(name).options.model_validate(table)
