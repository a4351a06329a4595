"""What a protocol is made of: options, steps, columns and simulated answers.

A protocol is declared once, as a `Protocol`; `registry` finds it by its entry point. All its random
numbers come from its `Context`: the same seed and labels give the same run. `building_blocks` has
what several protocols share.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from slipscale.experiments.languages.texts import ENGLISH, languages
from slipscale.experiments.protocols.ordering.randomisation import Stream
from slipscale.experiments.protocols.ordering.williams import Place
from slipscale.faults import UserError
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, in_code, in_um
from slipscale.stimuli.surface import VirtualSurface

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from slipscale.experiments.languages.texts import Texts
    from slipscale.experiments.protocols.simulated_answers import SimulatedAnswer
    from slipscale.experiments.protocols.steps import Steps, Trial, Value
    from slipscale.stimuli.quantity import Quantity
    from slipscale.stimuli.surface import Surface
    from slipscale.stimuli.texture import Grating

Kind = Literal["number", "label", "text"]
# The rule that orders are drawn by; every journal names it (docs/decisions/random-orders.md).
ORDER_VERSION = 2
EVERYBODY = "every participant"  # no participant's label: those have no spaces

# Strict: "3", 3.0 and true are not 3. TOML says what it means, and so does the fault.
Seed = Annotated[int, Field(strict=True, ge=0)]
# A thousand of anything is more than a participant can bear; more is a slip of the finger.
Count = Annotated[int, Field(strict=True, ge=0, le=1000)]
AtLeastOne = Annotated[int, Field(strict=True, ge=1, le=1000)]
Switch = Annotated[bool, Field(strict=True)]
Seconds = Annotated[float, Field(strict=True, ge=0, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, gt=0, allow_inf_nan=False)]
# abs: TOML knows -0.0, and nobody means it.
Amplitude = Annotated[float, Field(strict=True, ge=0, allow_inf_nan=False), AfterValidator(abs)]
Words = Annotated[str, Field(strict=True, min_length=1)]
Label = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
# A part of file names (BIDS entity): letters and digits only.
EntityLabel = Annotated[str, Field(strict=True, pattern="^[A-Za-z0-9]+$")]


class Options(BaseModel):
    """What a study may set for a protocol; unknown keys are faults."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    protocol: Words = Field(description="Name of the protocol, as an entry point gives it.")
    label: EntityLabel | None = Field(
        default=None,
        description="Label of the task in file names, letters and digits; left out: the "
        "protocol's. A study that has a protocol several times gives each its own.",
    )


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
    levels : tuple of float
        The study's surfaces, in its quantity.
    quantity : Quantity
        What every level is in: messages name keys and units by it.
    texts : Mapping
        What the participant reads, by key.
    textures : tuple of Grating
        The study's textures.
    task : str
        The task's label, for its trials and its random numbers.
    """

    seed: int
    participant: str
    row: int
    levels: tuple[float, ...]
    texts: Texts
    quantity: Quantity = PLATE_AMPLITUDE
    task: str = ""
    textures: tuple[Grating, ...] = ()
    visit: int = 0
    advance: bool = True
    session: str = ""
    run: str = "01"

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """All there is to present: the plain surfaces, then the textures."""
        return (*(self.surface(amplitude) for amplitude in self.levels), *self.textures)

    def stream(self, *purpose: str | int) -> Stream:
        """Return random numbers of this run's own for one purpose."""
        return Stream(self.seed, self.participant, self.session, self.run, *purpose)

    def shared_stream(self, *purpose: str | int) -> Stream:
        """Return random numbers that all participants have in common for one purpose."""
        return Stream(self.seed, EVERYBODY, *purpose)

    @property
    def place(self) -> Place:
        """Where the run stands in the counterbalancing."""
        return Place(row=self.row, visit=self.visit, advance=self.advance)

    def surface(self, level: float) -> VirtualSurface:
        """Return the surface of an amplitude, with a label that does not tell it."""
        known = self.levels
        label = f"S{known.index(level) + 1}" if level in known else "S0"
        return VirtualSurface(level=level, label=label)


@dataclass(slots=True, kw_only=True)
class IntervalRecord:
    """An interval of a trial as the journal tells it."""

    surface: Surface
    readback_level: float | None = None
    onset_s: float = 0.0
    exploration_time_s: float | None = None


@dataclass(slots=True, kw_only=True)
class TrialRecord:
    """A trial as the journal tells it, gathered for one row of the data set.

    ``surface`` and what follows it are those of a trial without intervals; ``intervals`` are those
    of one that has some, by their number.
    """

    trial: Trial
    surface: Surface | None = None
    before: Surface | None = None
    readback_level: float | None = None
    onset_s: float = 0.0
    end_s: float = 0.0
    exploration_time_s: float | None = None
    answers: dict[str, Mapping[str, Any]] = field(default_factory=dict)
    run_answers: Mapping[str, Value] = field(default_factory=dict)
    flags: list[str] = field(default_factory=list)
    intervals: dict[int, IntervalRecord] = field(default_factory=dict)
    measured: Mapping[str, float | None] = field(default_factory=dict)

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

    `slipscale.experiments.dataset.schema.columns` makes the data set's table of it: the columns
    that every task has, and the protocol's own in the three places that are named here.

    Parameters
    ----------
    task : str
        The BIDS task label: letters and digits only.
    title, description : str
        For people who read the data set.
    options : type of Options
        What a study may set.
    trials : callable
        How many trials a run is expected to have, practice included, from the options and the
        context.
    most_trials : callable, optional
        The most there can be if none is repeated, likewise; left out: as many as are expected.
    steps : callable
        The generator of steps, from the options and the context.
    answer : str
        The column of the trial's main answer: its response time is the row's.
    instructions : str
        The key of the text that instructs the participant (quoted in the data set).
    simulated : Mapping
        For the name of each question, who answers it in a pilot (`slipscale.experiments.protocols.
        simulation`). A pilot of a protocol that lacks one is refused.
    texts : Mapping
        The protocol's own texts: for each language a mapping from key to text. Keys begin with
        the protocol's name and a dot. Shipped protocols have theirs in
        `slipscale.experiments.languages`.
    design : Mapping
        Own columns after the trial's number: where the trial stands (block, series, ...).
    stimulus : Mapping
        Own columns before the amplitude: what else was presented (texture, surface before, ...).
    response : Mapping
        Own columns after the amplitude read back: every answer that is asked for, by the name of
        its question, and what is needed to read it.
    intervals : callable, optional
        How many intervals a trial has, from the options: each has columns of its own, in place
        of the one surface's. Left out: a trial presents one surface.
    amplitudes : tuple of str
        The options that hold an amplitude of the protocol's own: the plate must be able to make
        it. Every option whose name ends in ``_level`` or ``_levels`` is one.
    possible_levels : callable, optional
        Every amplitude (or the least and the largest) that could be presented, whatever is
        answered, µm peak to peak, from the options and the context. Left out: those that a
        rehearsal comes across.
    finest_level : callable, optional
        The smallest difference of amplitudes that matters to the task, and the amplitude at which
        it occurs, µm peak to peak, from the options and the context: the plate must hold an
        amplitude better than that.
    check : callable, optional
        Raises `UserError` where options and context do not fit together.
    textures : bool
        Whether it presents the study's textures; then ``texture`` is one of its columns, unless
        its trials have intervals.
    interval_columns : int
        For how many intervals the table has columns; `for_task` sets it.
    package : str
        The package that brings it, empty for Slipscale's own;
        `registry.load_protocol` sets it.

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
    most_trials: Callable[[Any, Context], int] | None = None
    steps: Callable[[Any, Context], Steps]
    answer: str
    instructions: str
    simulated: Mapping[str, SimulatedAnswer] = field(default_factory=dict)
    texts: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    design: Mapping[str, Column] = field(default_factory=dict)
    stimulus: Mapping[str, Column] = field(default_factory=dict)
    response: Mapping[str, Column]
    intervals: Callable[[Any], int] | None = None
    amplitudes: tuple[str, ...] = ()
    possible_levels: Callable[[Any, Context], Iterable[float]] | None = None
    finest_level: Callable[[Any, Context], tuple[float, float]] | None = None
    check: Callable[[Any, Context], None] | None = None
    textures: bool = False
    interval_columns: int = 0
    package: str = ""

    def __post_init__(self) -> None:
        own = [*self.design, *self.stimulus, *self.response]
        named = {key for key in self.options.model_fields if in_um(key) != key}
        names = (*own, *self.options.model_fields)
        wrong = (
            (not re.fullmatch("[A-Za-z0-9]+", self.task), "the task has letters and digits only"),
            (self.answer not in self.response, f"'{self.answer}' is a column of the response"),
            (len(set(own)) < len(own), "each column is declared once"),
            (any(in_code(name) != name for name in names), "a level's name ends in _level"),
            (set(self.amplitudes) != named, "amplitudes names every option that ends in _level"),
            (
                self.textures and not self.intervals and "texture" not in own,
                "a column 'texture' says which was presented",
            ),
        )
        if faults := [expected for fault, expected in wrong if fault]:
            raise UserError(f"{self.named}: expected that {'; that '.join(faults)}")

    @property
    def named(self) -> str:
        """What sentences call it: its task, and the package that brings it."""
        return f"protocol '{self.task}'" + (
            f" of the package {self.package}" if self.package else ""
        )

    def for_task(self, options: Options) -> Protocol:
        """Return the protocol as a task of a study has it: under its label, with its intervals."""
        shown = self.intervals(options) if self.intervals else 0
        return replace(self, task=options.label or self.task, interval_columns=shown)

    def most(self, options: Options, context: Context) -> int:
        """Return the most trials that a run can have if none is repeated."""
        return (self.most_trials or self.trials)(options, context)


def protocol_texts(protocol: Protocol, language: str) -> Mapping[str, str]:
    """Return the texts that a protocol brings in a language: none for a shipped one.

    For a language of the study's own, which has texts in place of them, any language's will do.

    Raises
    ------
    UserError
        It brings texts, but none in that language, a shipped one.
    """
    if protocol.texts and language not in (*protocol.texts, *languages()):
        return protocol.texts.get(ENGLISH) or next(iter(protocol.texts.values()))
    if protocol.texts and language not in protocol.texts:
        raise UserError(
            f"{protocol.named}: has no texts in '{language}'; it has them in "
            f"{', '.join(protocol.texts)}"
        )
    return protocol.texts.get(language, {})
