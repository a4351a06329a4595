"""Model of a study file, which is immutable and validated as a whole.

All errors are reported at once, each with its location. A check that depends on another key is
skipped if that key is invalid; for example, levels are not checked if the plate's table is invalid.
"""

from __future__ import annotations

from itertools import chain
from typing import Annotated, Literal

from pydantic import AfterValidator, BeforeValidator, Field, SerializeAsAny

from slipscale.experiments.languages.texts import ENGLISH
from slipscale.experiments.protocol_parts.base import (
    Amplitude,
    AtLeastOne,
    EntityLabel,
    Label,
    Options,
    Seed,
    Switch,
    Words,
)
from slipscale.experiments.protocol_parts.registry import load_protocol
from slipscale.experiments.steps.screens.scene import DARK, Theme
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.experiments.study.factors import Factor, second_levels
from slipscale.experiments.study.headphone_test import HeadphoneTest
from slipscale.experiments.study.key_validators import (
    valid_attribute_words,
    valid_factors,
    valid_levels,
    valid_plate,
    valid_sessions,
    valid_stimulus,
    valid_stroke,
    valid_tasks,
    valid_texts,
    valid_textures,
    valid_vary,
)
from slipscale.experiments.study.levels import Levels
from slipscale.experiments.study.participant_keys import ParticipantKeys
from slipscale.experiments.study.person_questions import PersonQuestion
from slipscale.experiments.study.questionnaires import Questionnaire
from slipscale.experiments.study.stroke import Stroke
from slipscale.experiments.study.tables import (
    Cost,
    MaskingNoise,
    PlateSettings,
    SecondPlate,
    Simulated,
    StatedWords,
    StimulusTable,
    Texture,
)
from slipscale.faults.frozen_table import FrozenTable, setting
from slipscale.stimuli.attributes import ATTRIBUTES, SLIPPERINESS, AttributeWords
from slipscale.stimuli.quantity import Quantity
from slipscale.stimuli.quantity_table import QuantityTable
from slipscale.stimuli.textures import Texture as TextureSurface
from slipscale.stimuli.varied import Varied

# Maximum numbers of surfaces, tasks, sessions and questions: more than any study needs, but few
# enough for fast computation.
MOST = 100


class Study(FrozenTable):
    """The definition of a study; each field is a key of the study file."""

    name: Label = Field(
        description="Short label of the study: letters, digits and _, beginning with a letter. "
        "Every record of the study contains this label."
    )
    title: Words = Field(description="Title of the study and its data set.")
    authors: tuple[Words, ...] = setting((), "Authors listed in the data set description.")
    license: Words = setting("not decided", "Licence stated in the data set description.")
    language: str = setting(
        "en",
        "Language of the texts shown to the participant: en, fr, or one that the study provides "
        "(`texts_files`); the command-line option `--language` overrides it.",
    )
    seed: Seed = setting(1, "Random seed for all orders and simulations.", unit="none")
    participants: AtLeastOne = setting(
        12, "Number of planned participants, also used for pilots.", unit="participants"
    )
    made: QuantityTable = Field(
        default=QuantityTable(),
        validation_alias="quantity",
        description="Quantity that the plate produces and in which levels are given; default: the "
        "vibration amplitude in µm peak to peak. If the plate produces another quantity, the names "
        "of keys end in the unit of that quantity.",
    )
    attribute: str = setting(
        "",
        "Attribute that participants judge: a noun such as roughness, used in prompts, columns, "
        "axes and reports. The default is `judged` in [quantity], or slipperiness.",
    )
    attribute_falls: Switch = setting(
        False,
        "Whether the attribute decreases as the level increases, as roughness may with spatial "
        "period. If true, trend tests expect a decrease, and a forced choice in which the higher "
        "level is the correct answer asks which surface is less rough.",
    )
    attribute_words: Annotated[dict[str, StatedWords], AfterValidator(valid_attribute_words)] = (
        Field(
            default_factory=dict,
            validate_default=True,
            description=(
                "Words for an attribute that is not built into Slipscale: one table per language."
            ),
        )
    )
    vary: Annotated[str, AfterValidator(valid_vary)] = setting(
        "",
        "Key of the [stimulus] parameter that is varied, such as spatial_period_mm: all levels "
        "of the study are then values of that parameter. By default, levels are values of the "
        "plate's quantity.",
    )
    stimulus: Annotated[StimulusTable | None, AfterValidator(valid_stimulus)] = setting(
        None,
        ("Parameters that stay fixed in a study that varies one parameter."),
        validate_default=True,
    )
    plate: Annotated[PlateSettings, AfterValidator(valid_plate)] = setting(
        PlateSettings(), "Limits for all amplitudes in the study.", validate_default=True
    )
    second_plate: SecondPlate | None = setting(
        None, "A second actuator, for a plate `pair:FIRST+SECOND`; default: none."
    )
    levels: Annotated[
        tuple[Amplitude, ...], Field(max_length=MOST), AfterValidator(valid_levels)
    ] = setting(
        (),
        "Vibration amplitudes of the plain surfaces, all different; 0 is the plate at rest. Omit "
        "this key if the study has textures only.",
    )
    textures: Annotated[
        tuple[Texture, ...], Field(max_length=MOST), AfterValidator(valid_textures)
    ] = setting(
        (),
        "Surfaces with a modulated amplitude, for the protocols that present them.",
        validate_default=True,
    )
    factors: Annotated[tuple[Factor, ...], Field(max_length=4), AfterValidator(valid_factors)] = (
        setting(
            (),
            "Factors that are crossed with the levels. Each task is run in every combination of "
            "factor levels; the order is balanced across participants.",
            validate_default=True,
        )
    )
    tasks: Annotated[
        tuple[SerializeAsAny[Options], ...],
        Field(min_length=1, max_length=MOST),
        BeforeValidator(valid_tasks),
    ] = Field(
        description="The tasks of a run, in order: each names a protocol and sets its options."
    )
    task_order: Literal["fixed", "counterbalanced"] = setting(
        "fixed",
        "Order of the tasks. counterbalanced: every second participant has the reverse order.",
    )
    sessions: Annotated[
        tuple[EntityLabel, ...], Field(max_length=MOST), AfterValidator(valid_sessions)
    ] = setting(
        (),
        "Labels of the sessions in order, all different. By default, any label is accepted, and "
        "the number at its end determines the order.",
    )
    runs: AtLeastOne = setting(1, "Number of runs per session.", unit="runs")
    visits: Literal["advance", "same"] = setting(
        "advance",
        "Position of further sessions and runs in the counterbalancing. advance: each run takes "
        "the next position (the next Williams row, the other task order). same: all runs keep the "
        "participant's position. In either case, each run has a new order of surfaces.",
    )
    keys: ParticipantKeys = setting(
        ParticipantKeys(),
        "Keys for the participant that differ from the defaults, for a keypad, a response box or "
        "a pedal.",
    )
    screens: Theme = setting(
        DARK,
        "Whether the participant's screens are dark with light text, or light with dark text.",
    )
    progress_line: Switch = setting(
        False,
        "Whether a line at the bottom of the participant's screens shows how many trials of the "
        "task are finished.",
    )
    informed_consent: Switch = setting(
        False,
        "Whether the participant is first asked for consent, using the texts "
        "`session.consent...`. Without consent, the run does not continue.",
    )
    about_you: Annotated[tuple[PersonQuestion, ...], Field(max_length=MOST)] = setting(
        (), "Questions about the participant, asked before the tasks."
    )
    questionnaires: Annotated[tuple[Questionnaire, ...], Field(max_length=MOST)] = setting(
        (),
        "Questionnaires with several items, presented before or after the tasks. Each "
        "questionnaire has a separate table.",
    )
    headphone_test: HeadphoneTest | None = setting(
        None,
        "Check before the tasks whether headphones are worn and whether the masking noise is "
        "heard in both ears; by default, this is not checked.",
    )
    stroke: Annotated[Stroke | None, AfterValidator(valid_stroke)] = setting(
        None,
        "Requirements for strokes, and the treatment of trials that do not meet these "
        "requirements; default: no requirements.",
    )
    masking_noise: MaskingNoise | None = setting(
        None, "Pink noise in the headphones while the plate may be audible; default: none."
    )
    private_files: Switch = setting(
        True,
        "Whether journals and data set files can be read only by their owner, on systems that "
        "support this. If false, the system's default permissions apply.",
    )
    analysis: AnalysisChoices = setting(
        AnalysisChoices(), "The planned data analysis, fixed before anyone sees the data."
    )
    simulated: Simulated | None = setting(
        None,
        "Assumptions about simulated people; default: the shipped population, or the assumption "
        "that Slipscale lists for the quantity.",
    )
    cost: Cost | None = setting(None, "Costs of the study; by default, costs are not computed.")
    texts_files: tuple[Words, ...] = setting(
        (),
        "Names of files with the texts for other languages, in the study file's folder; "
        "`slipscale study texts` writes a template.",
    )
    texts: Annotated[dict[str, dict[str, object]], AfterValidator(valid_texts)] = Field(
        default_factory=dict,
        validate_default=True,
        description="Texts that replace the shipped texts: one table per language, keyed by text "
        "name.",
    )

    def __repr__(self) -> str:
        """Summarise the study in one line: name, title, participants, tasks and amplitudes."""
        tasks = ", ".join(task.protocol for task in self.tasks)
        levels, q = ", ".join(f"{each:g}" for each in self.levels), self.quantity
        return (
            f"Study '{self.name}' ({self.title}): {self.participants} participants; {tasks}; "
            f"{q.levels} {levels or 'none'} {q.unit_in_full}"
        )

    @property
    def _levels(self) -> Levels:
        return Levels.of(self.__dict__)

    @property
    def quantity(self) -> Quantity:
        """The quantity of all levels, which belongs to the plate or the varied parameter."""
        return self._levels.quantity

    def words_of(self, language: str) -> AttributeWords | None:
        """Return the wording for the judged attribute in a language, or None if it is unknown."""
        words = ATTRIBUTES.get(self.attribute or self.made.judged, {}).get(language)
        if own := self.attribute_words.get(language):
            usual = ATTRIBUTES[SLIPPERINESS].get(language, ATTRIBUTES[SLIPPERINESS][ENGLISH])
            words = usual._replace(
                adjective=own.adjective,
                noun=own.noun,
                masculine=own.masculine,
                plural=own.plural,
            )
        falls = self.attribute_falls or self.made.falls
        return words.falling if words and falls else words

    @property
    def plate_quantity(self) -> Quantity:
        """The quantity that the plate produces."""
        return self._levels.made

    @property
    def second_levels(self) -> tuple[float, ...]:
        """The levels of the second actuator; empty without a second actuator."""
        return second_levels(self.second_plate, self.factors)

    def quantity_notes(self) -> dict[str, dict[str, str]]:
        """Return descriptions of the study's quantities for records.

        The quantity of the levels is omitted if it is the default quantity, and the quantity that
        the plate produces is omitted unless the levels are another parameter of the stimuli.
        """
        stated = {} if self.quantity.of_plate else {"quantity": self.quantity}
        stated |= {"plate_quantity": self.plate_quantity} if self.vary else {}
        return {name: QuantityTable.stating(each).model_dump() for name, each in stated.items()}

    @property
    def levels_of_tasks(self) -> dict[str, tuple[float, ...]]:
        """Possible levels of each task that chooses its own levels, keyed by the task's label."""
        context = self._levels.context(self.levels)
        protocols = ((load_protocol(task.protocol).for_task(task), task) for task in self.tasks)
        return {
            protocol.task: tuple(protocol.possible_levels(task, context))
            for protocol, task in protocols
            if protocol.possible_levels
        }

    @property
    def range_level(self) -> tuple[float, float]:
        """The lowest and highest levels that simulated people can feel."""
        if not (self.vary or self.simulated):
            return 0.0, self.plate.level
        possible = [*self.levels, *chain.from_iterable(self.levels_of_tasks.values())]
        # The plate at rest is excluded, because the logarithm of 0 is not defined.
        return min(each for each in possible if each or self.vary), max(possible)

    @property
    def varied(self) -> Varied | None:
        """The stimulus at the first level; None unless a parameter of the stimulus is varied."""
        return self._levels.varied(self.levels)

    @property
    def texture_surfaces(self) -> tuple[TextureSurface, ...]:
        """The textures as surfaces, labelled T1, T2, ... in the order of the study file."""
        return tuple(t.surface(f"T{number}") for number, t in enumerate(self.textures, start=1))
