"""What a protocol is made of, and where protocols are found.

A laboratory adds a protocol as an entry point of the group ``slipscale.protocols`` that names a
`Protocol`; the study file's ``protocol`` key is the entry point's name. What most protocols share
is beside this: the options of `pacing`, and `repeating`, which counts trials and has voided ones
come again.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import EntryPoints, entry_points
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from experiments.protocols.randomisation import Stream
from experiments.protocols.williams import Place
from faults import UserError
from stimuli.surface import VirtualSurface

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from experiments.languages.texts import Texts
    from experiments.protocols.steps import Steps, Trial, Value
    from stimuli.surface import Surface
    from stimuli.texture import Grating

PROTOCOLS = "slipscale.protocols"
Kind = Literal["number", "label", "text"]
# 1: the Williams rows, and orders that knew neither session nor run (docs/decisions/0130).
ORDER_VERSION = 2
EVERYBODY = "every participant"  # no participant's label: those have no spaces

# Strict: "3", 3.0 and true are not 3. TOML says what it means, and so does the fault.
Count = Annotated[int, Field(strict=True, ge=0)]
# A thousand of anything is more than a participant can bear; more is a slip of the finger.
AtLeastOne = Annotated[int, Field(strict=True, ge=1, le=1000)]
Switch = Annotated[bool, Field(strict=True)]
Seconds = Annotated[float, Field(strict=True, ge=0, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, gt=0, allow_inf_nan=False)]
# abs: TOML knows -0.0, and nobody means it.
Amplitude = Annotated[float, Field(strict=True, ge=0, allow_inf_nan=False), AfterValidator(abs)]
Words = Annotated[str, Field(strict=True, min_length=1)]
Label = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]


class Options(BaseModel):
    """What a study may set for a protocol; unknown keys are faults."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    protocol: Words = Field(description="Name of the protocol, as an entry point gives it.")


@dataclass(frozen=True, slots=True, kw_only=True)
class Context:
    """What a protocol knows of its run.

    Parameters
    ----------
    seed : int
        The study's seed.
    participant : str
        The participant's label.
    row : int
        The participant's place in the counterbalancing: 0, 1, ...
    visit : int
        Which of the participant's runs it is, as the study plans them: 0, 1, ...
    advance : bool
        Whether each visit takes the next place in the counterbalancing.
    session, run : str
        The run's labels: each has orders of its own.
    order_version : int
        The rule that orders are drawn by; 1 only to go on with a run that was begun with it.
    amplitudes_um_pp : tuple of float
        The study's surfaces, µm peak to peak.
    texts : Mapping
        What the participant reads, by key.
    textures : tuple of Grating
        The study's textures.
    """

    seed: int
    participant: str
    row: int
    amplitudes_um_pp: tuple[float, ...]
    texts: Texts
    textures: tuple[Grating, ...] = ()
    visit: int = 0
    advance: bool = True
    session: str = ""
    run: str = "01"
    order_version: int = ORDER_VERSION

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """All there is to present: the plain surfaces, then the textures."""
        return (*(self.surface(amplitude) for amplitude in self.amplitudes_um_pp), *self.textures)

    def stream(self, *purpose: str | int) -> Stream:
        """Return random numbers of this run's own for one purpose."""
        # In version 1 all of a participant's runs had the same.
        of_run = () if self.order_version == 1 else (self.session, self.run)
        return Stream(self.seed, self.participant, *of_run, *purpose)

    def shared_stream(self, *purpose: str | int) -> Stream:
        """Return random numbers that all participants have in common for one purpose."""
        return Stream(self.seed, EVERYBODY, *purpose)

    @property
    def place(self) -> Place:
        """Where the run stands in the counterbalancing."""
        return Place(row=self.row, visit=self.visit, advance=self.advance)

    def surface(self, amplitude_um_pp: float) -> VirtualSurface:
        """Return the surface of an amplitude, with a label that does not tell it."""
        known = self.amplitudes_um_pp
        label = f"S{known.index(amplitude_um_pp) + 1}" if amplitude_um_pp in known else "S0"
        return VirtualSurface(amplitude_um_pp=amplitude_um_pp, label=label)


@dataclass(slots=True, kw_only=True)
class TrialRecord:
    """A trial as the journal tells it, gathered for one row of the data set."""

    trial: Trial
    surface: Surface | None = None
    before: Surface | None = None
    readback_um_pp: float | None = None
    onset_s: float = 0.0
    end_s: float = 0.0
    exploration_time_s: float | None = None
    answers: dict[str, Mapping[str, Any]] = field(default_factory=dict)
    run_answers: Mapping[str, Value] = field(default_factory=dict)
    flags: list[str] = field(default_factory=list)

    def answer(self, name: str) -> Value:
        """Return the value of an answer, None where it was not given."""
        value: Value = self.answers.get(name, {}).get("value")
        return value


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A column of the data set: its value for a trial, and its meaning for the sidecar.

    Parameters
    ----------
    value : callable
        Returns the column's value for a trial; None is written as missing.
    kind : {"number", "label", "text"}
        What its cells hold: a number, one of few words (or a name), or free text.
    description : str
        For people who read the data set.
    units : str
        The unit as BIDS writes it; empty for a number without one.
    levels : Mapping
        All labels that can occur and their meanings; empty where they are not known beforehand.
    """

    value: Callable[[TrialRecord], Value]
    kind: Kind
    description: str
    units: str = ""
    levels: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Protocol:
    """A way to question a participant about surfaces.

    `experiments.dataset.schema.columns` makes the data set's table of it: the columns that every
    task has, and the protocol's own in the three places that are named here.

    Parameters
    ----------
    task : str
        The BIDS task label: letters and digits only.
    title, description : str
        For people who read the data set.
    options : type of Options
        What a study may set.
    trials : callable
        How many trials a run will have, practice included, from the options and the context.
    steps : callable
        The generator of steps, from the options and the context.
    answer : str
        The column of the trial's main answer: its response time is the row's.
    instructions : str
        The key of the text that instructs the participant (quoted in the data set).
    design : Mapping
        Own columns after the trial's number: where the trial stands (block, series, ...).
    stimulus : Mapping
        Own columns before the amplitude: what else was presented (texture, surface before, ...).
    response : Mapping
        Own columns after the amplitude read back: every answer that is asked for, by the name of
        its question, and what is needed to read it.
    amplitudes : tuple of str
        The options that hold an amplitude of the protocol's own: the plate must be able to make
        it. Every option whose name ends in ``_um_pp`` is one.
    textures : bool
        Whether it presents the study's textures; then ``texture`` is one of its columns.

    Raises
    ------
    UserError
        What is declared contradicts itself.
    """

    task: str
    title: str
    description: str
    options: type[Options]
    trials: Callable[[Any, Context], int]
    steps: Callable[[Any, Context], Steps]
    answer: str
    instructions: str
    design: Mapping[str, Column] = field(default_factory=dict)
    stimulus: Mapping[str, Column] = field(default_factory=dict)
    response: Mapping[str, Column]
    amplitudes: tuple[str, ...] = ()
    textures: bool = False

    def __post_init__(self) -> None:
        own = [*self.design, *self.stimulus, *self.response]
        named = {key for key in self.options.model_fields if key.endswith("_um_pp")}
        wrong = (
            (not re.fullmatch("[A-Za-z0-9]+", self.task), "the task has letters and digits only"),
            (self.answer not in self.response, f"'{self.answer}' is a column of the response"),
            (len(set(own)) < len(own), "each column is declared once"),
            (set(self.amplitudes) != named, "amplitudes names every option that ends in _um_pp"),
            (self.textures and "texture" not in own, "a column 'texture' says which was presented"),
        )
        if faults := [expected for fault, expected in wrong if fault]:
            raise UserError(f"protocol '{self.task}': expected that {'; that '.join(faults)}")


@cache
def _installed() -> EntryPoints:
    # Looking through all installed packages takes some 15 ms; they do not change under a run.
    return entry_points(group=PROTOCOLS)


def protocol_names() -> list[str]:
    """Return the names of all installed protocols, sorted."""
    return sorted(_installed().names)


def load_protocol(name: str) -> Protocol:
    """Return an installed protocol by name; KeyError if there is none."""
    loaded: Protocol = _installed()[name].load()
    return loaded
