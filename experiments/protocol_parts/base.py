"""Common interface for protocols: options, steps, columns and simulated answers.

A protocol is declared as a `Protocol`, which `registry` finds by its entry point. A protocol draws
all random numbers from its `Context`, so a study's seed and a run's labels (such as participant and
session) always give the same random numbers.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import AfterValidator, Field

from slipscale.experiments.languages.texts import ENGLISH, Texts, languages
from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.experiments.protocol_parts.ordering.williams import Place
from slipscale.experiments.steps.columns import Column, read_by_name
from slipscale.faults import UserError
from slipscale.faults.frozen_table import FrozenTable, setting
from slipscale.stimuli.level_names import is_level
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity
from slipscale.stimuli.surface import UNLISTED, Stimulus, VirtualSurface

if TYPE_CHECKING:
    from slipscale.experiments.protocol_parts.simulated_answers import SimulatedAnswer
    from slipscale.experiments.steps.steps import Steps
    from slipscale.stimuli.textures import Texture
    from slipscale.stimuli.varied import Varied

# Version of the rule that generates orders; stored in every journal
# (docs/decisions/random-orders.md).
ORDER_VERSION = 2
EVERYBODY = "every participant"  # contains a space, unlike any participant's label

# Strict, because TOML has types: "3", 3.0 and true are not accepted as 3.
Seed = Annotated[int, Field(strict=True, ge=0)]
# Counts above 1000 are rejected as typing errors.
Count = Annotated[int, Field(strict=True, ge=0, le=1000)]
AtLeastOne = Annotated[int, Field(strict=True, ge=1, le=1000)]
Switch = Annotated[bool, Field(strict=True)]
Seconds = Annotated[float, Field(strict=True, ge=0, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, gt=0, allow_inf_nan=False)]
# TOML allows -0.0, which abs() converts to 0.0.
Amplitude = Annotated[float, Field(strict=True, ge=0, allow_inf_nan=False), AfterValidator(abs)]
Words = Annotated[str, Field(strict=True, min_length=1)]
Label = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
# Part of a file name (a BIDS entity), so only letters and digits are allowed.
EntityLabel = Annotated[str, Field(strict=True, pattern="^[A-Za-z0-9]+$")]


class Options(FrozenTable):
    """Protocol options that a study can set; unknown keys are errors."""

    protocol: Words = Field(description="Name of the protocol's entry point.")
    label: EntityLabel | None = setting(
        None,
        "Task label for file names (letters and digits only); default: the protocol's label. If a "
        "study uses a protocol several times, each task needs its own label.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Context:
    """Information about a run that is passed to its protocol.

    Parameters
    ----------
    seed : int
        The study's seed.
    participant : str
        The participant's label.
    row : int
        The participant's position in the counterbalancing: 0, 1, ...
    visit : int
        Index of the run among the participant's planned runs: 0, 1, ...
    advance : bool
        Whether each run of a participant takes the next position in the counterbalancing.
    session, run : str
        The run's labels. Each run has its own presentation orders.
    levels : tuple of float
        The levels of the study's surfaces without texture, in the unit of ``quantity``.
    quantity : Quantity
        The quantity of all levels, whose name and unit appear in messages.
    texts : Mapping
        Text shown to the participant, by key.
    textures : tuple of Texture
        The study's textures.
    varied : Varied or None
        Stimulus whose varied parameter is set by the levels; None if the levels are in the plate's
        quantity.
    condition : str
        Label of the combination of factor levels. Each combination has its own presentation
        orders.
    task : str
        The label of the task, from which the task's random numbers are generated.
    """

    seed: int
    participant: str
    row: int
    levels: tuple[float, ...]
    texts: Texts
    quantity: Quantity = PLATE_AMPLITUDE
    task: str = ""
    textures: tuple[Texture, ...] = ()
    varied: Varied | None = None
    condition: str = ""
    visit: int = 0
    advance: bool = True
    session: str = ""
    run: str = "01"

    @property
    def surfaces(self) -> tuple[Stimulus, ...]:
        """All surfaces of the study: the plain surfaces, then the textures."""
        return (*(self.surface(amplitude) for amplitude in self.levels), *self.textures)

    def stream(self, *purpose: str | int) -> Stream:
        """Return this run's random number stream for a given purpose."""
        condition = (self.condition,) if self.condition else ()
        return Stream(self.seed, self.participant, self.session, self.run, *condition, *purpose)

    def shared_stream(self, *purpose: str | int) -> Stream:
        """Return a random number stream for a given purpose, identical for all participants."""
        return Stream(self.seed, EVERYBODY, *purpose)

    @property
    def place(self) -> Place:
        """The run's position in the counterbalancing."""
        return Place(row=self.row, visit=self.visit, advance=self.advance)

    def surface(self, level: float) -> Stimulus:
        """Return the surface at a given level, with a label that does not reveal the level."""
        known = self.levels
        label = f"S{known.index(level) + 1}" if level in known else UNLISTED
        if self.varied is not None:
            return self.varied.at(level, label)
        return VirtualSurface(level=level, label=label)

    def own_or_listed(self, own: tuple[float, ...] | None) -> tuple[float, ...]:
        """Return the task's levels (``own``) if given, otherwise the study's levels.

        Raises
        ------
        UserError
            If neither the task nor the study lists levels.
        """
        if not (own or self.levels):
            raise UserError(
                "neither the study nor the task lists {levels}", levels=self.quantity.levels
            )
        return own or self.levels


def _never(_options: object) -> bool:
    return False


@dataclass(frozen=True, slots=True, kw_only=True)
class Protocol:
    """Experimental method that presents surfaces and asks a participant about them.

    `slipscale.experiments.dataset.schema.columns` builds the trial table from the columns common to
    all tasks and the protocol's own columns (``design``, ``stimulus`` and ``response``).

    Parameters
    ----------
    task : str
        The BIDS task label: letters and digits only.
    title, description : str
        Title and description for readers of the data set.
    options : type of Options
        The options that a study can set.
    trials : callable
        Returns the expected number of trials in a run, including practice, given the options and
        the context.
    most_trials : callable, optional
        Returns the largest possible number of trials if no trial is repeated, given the same
        arguments. The default is ``trials``.
    steps : callable
        Returns a generator of the run's steps, given the options and the context.
    answer : str
        Column with the trial's main answer, whose response time is stored in the trial's row.
    instructions : str
        Text key of the participant's instructions. The data set quotes these instructions.
    simulated : Mapping
        Maps the name of each question to the function that answers it in a pilot
        (`slipscale.experiments.protocol_parts.simulated_answers`). If a function is missing, the
        protocol cannot be piloted.
    texts : Mapping
        The protocol's texts: for each language, a mapping from key to text. Keys begin with the
        protocol's name and a dot. The texts of shipped protocols are in
        `slipscale.experiments.languages`.
    design : Mapping
        Columns after the trial number, which locate the trial in the run (block, series, ...).
    stimulus : Mapping
        Columns before the amplitude: other stimulus properties (texture, previous surface,
        ...).
    response : Mapping
        Columns after the plate's readback: the answers, by question name, and the values needed to
        interpret the answers.
    intervals : int or callable
        Number of intervals per trial, or a function that returns it, given the options. Each
        interval has its own columns, which replace the columns for a single surface.
    amplitudes : tuple of str
        The options that contain an amplitude; the plate must be able to produce all these
        amplitudes. These options, and no others, have names that end in ``_level`` or ``_levels``.
    possible_levels : callable, optional
        Returns all amplitudes (or the smallest and the largest) that any sequence of answers could
        lead to, in µm peak to peak, given the options and the context. By default, the amplitudes
        are determined by a dry run of the task.
    finest_level : callable, optional
        Returns the smallest amplitude difference in the task and the amplitude at which it occurs,
        in µm peak to peak, given the options and the context. The tolerance of
        the plate's amplitude must not exceed the smallest difference.
    check : callable, optional
        Raises `UserError` if options and context are incompatible.
    needs_position : callable
        Returns whether any surface depends on the finger's position, given the options. If so, the
        position must be measured. The default is False.
    textures : bool
        Whether the protocol presents the study's textures. If True, and ``intervals`` is not given,
        the protocol must declare a column ``texture``.
    interval_columns : int
        Number of intervals for which the table has columns; set by `for_task`.
    package : str
        The package that provides the protocol, set by `registry.load_protocol`; empty for
        Slipscale.

    Raises
    ------
    UserError
        If the protocol's declaration is invalid.
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
    intervals: int | Callable[[Any], int] = 0
    amplitudes: tuple[str, ...] = ()
    possible_levels: Callable[[Any, Context], Iterable[float]] | None = None
    finest_level: Callable[[Any, Context], tuple[float, float]] | None = None
    check: Callable[[Any, Context], None] | None = None
    needs_position: Callable[[Any], bool] = _never
    textures: bool = False
    interval_columns: int = 0
    package: str = ""

    def __post_init__(self) -> None:
        for part in ("design", "stimulus", "response"):
            object.__setattr__(self, part, read_by_name(getattr(self, part)))
        columns = [*self.design.items(), *self.stimulus.items(), *self.response.items()]
        own = [name for name, _ in columns]
        named = {key for key in self.options.model_fields if is_level(key)}
        names = [name for name, column in columns if not column.as_stated]
        wrong = (
            (
                not re.fullmatch("[A-Za-z0-9]+", self.task),
                "the task label must contain only letters and digits",
            ),
            (
                self.answer not in self.response,
                f"the answer '{self.answer}' must be one of the response columns",
            ),
            (len(set(own)) < len(own), "each column must be declared once"),
            (
                any(
                    PLATE_AMPLITUDE.in_code[name] != name and not is_level(name)
                    for name in (*names, *self.options.model_fields)
                ),
                "a level's name must end in _level",
            ),
            (
                set(self.amplitudes) != named,
                "amplitudes must name every option that ends in _level",
            ),
            (
                self.textures and not self.intervals and "texture" not in own,
                "the column 'texture' must name the presented texture",
            ),
        )
        if faults := [expected for fault, expected in wrong if fault]:
            raise UserError(
                "{protocol}: invalid declaration: {faults}",
                protocol=self.named,
                faults="; ".join(faults),
            )

    @property
    def named(self) -> str:
        """The protocol's name in messages: its task label and the package that provides it."""
        return f"protocol '{self.task}'" + (
            f" of the package {self.package}" if self.package else ""
        )

    def titled(self, quantity: Quantity = PLATE_AMPLITUDE) -> str:
        """Return the title with the judged attribute filled in."""
        return self.title.format(q=quantity) if "{q." in self.title else self.title

    def for_task(self, options: Options) -> Protocol:
        """Return a copy with the label and number of intervals for a task's options."""
        shown = self.intervals(options) if callable(self.intervals) else self.intervals
        return replace(self, task=options.label or self.task, interval_columns=shown)

    def most(self, options: Options, context: Context) -> int:
        """Return the largest possible number of trials in a run if no trial is repeated."""
        return (self.most_trials or self.trials)(options, context)


def protocol_texts(protocol: Protocol, language: str) -> Mapping[str, str]:
    """Return the text that a protocol from another package provides in a language.

    The result is empty for shipped protocols. If only the study defines the language, the result is
    the protocol's English text or, without an English text, another translation. The study's
    translation then replaces this text.

    Raises
    ------
    UserError
        If the language ships with Slipscale, but the protocol has texts only in other languages.
    """
    if protocol.texts and language not in (*protocol.texts, *languages()):
        return protocol.texts.get(ENGLISH) or next(iter(protocol.texts.values()))
    if protocol.texts and language not in protocol.texts:
        raise UserError(
            "{protocol}: has no texts in '{language}', only in {texts}",
            protocol=protocol.named,
            language=language,
            texts=", ".join(protocol.texts),
        )
    return protocol.texts.get(language, {})
