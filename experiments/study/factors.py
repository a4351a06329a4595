"""Factors of a study, which are crossed with its levels: parameters or other conditions.

Each combination of the factors' levels is a condition. A task is run once per condition; the order
of conditions follows a Williams design across participants. Protocols need no code for conditions,
because this module renumbers the trials, and adds a column for each factor to the task's table.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Annotated, Any, TypeVar

from pydantic import Field

from slipscale.experiments.protocol_parts.base import Context, Label, Options, Protocol, Words
from slipscale.experiments.protocol_parts.ordering.williams import williams_blocks
from slipscale.experiments.steps.columns import Column
from slipscale.experiments.steps.replies import Answer, Voided
from slipscale.experiments.steps.steps import Adjust, EndBlock, Instruct, Present, Rest, Step, Steps
from slipscale.experiments.steps.trial import Trial, Value, factor_level
from slipscale.experiments.study.levels import Levels
from slipscale.experiments.study.tables import SecondPlate
from slipscale.faults import UserError
from slipscale.faults.frozen_table import FrozenTable, setting
from slipscale.faults.message import Message
from slipscale.faults.toml_lines import Place
from slipscale.faults.validation import Fault
from slipscale.stimuli.parameters import field_of
from slipscale.stimuli.quantity import Quantity
from slipscale.stimuli.textures import PARAMETERS

#: Columns of every task's table, whose names a factor cannot have.
TAKEN = frozenset({"trial", "phase", "surface", "onset", "duration", "repeats", "flag", "block"})
#: Tasks are repeated in each condition, so more conditions would overburden a participant.
MOST_CONDITIONS = 24
AnyStep = TypeVar("AnyStep", bound="Step")


class Factor(FrozenTable):
    """A factor: a stimulus parameter, or a condition announced to the participant."""

    name: Label = Field(
        description="Column of the factor in the data. If the name is the key of a parameter, "
        "such as finger_speed_mm_s, the factor changes that parameter in the stimulus and the "
        "textures."
    )
    levels: Annotated[
        tuple[float | Words, ...], Field(min_length=2, max_length=MOST_CONDITIONS)
    ] = Field(
        description="Levels of the factor, all different: numbers if the factor is a "
        "parameter, otherwise words."
    )
    description: str = setting("", "Description of the factor's column in the data set.")
    instructions: dict[str, dict[str, Words]] = Field(
        default_factory=dict,
        description="Texts that the participant reads before a condition: for each language, a "
        "table with one text per level.",
    )
    simulated: dict[str, Annotated[float, Field(strict=True, gt=0, allow_inf_nan=False)]] = Field(
        default_factory=dict,
        description="Multiplier for the sensation of simulated people at each level of the factor; "
        "default: 1.",
    )
    simulated_growth: dict[str, Annotated[float, Field(strict=True, gt=0, allow_inf_nan=False)]] = (
        Field(
            default_factory=dict,
            description="Multiplier for the exponent of simulated people's sensation at each level "
            "of the factor; the strongest sensation does not change. Default: 1.",
        )
    )
    simulated_sd: float = Field(
        default=0,
        ge=0,
        allow_inf_nan=False,
        description="Standard deviation across simulated people of the natural logarithm of each "
        "level's multiplier.",
        json_schema_extra={"unit": "none"},
    )


@dataclass(frozen=True, slots=True)
class Condition:
    """One combination of factor levels, keyed by factor name."""

    values: Mapping[str, Value]

    @property
    def label(self) -> str:
        """The condition as text, which also identifies its random number streams."""
        return " ".join(f"{name}={factor_level(value)}" for name, value in self.values.items())

    def context(self, context: Context, plate: Quantity) -> Context:
        """Return the context for a protocol in this condition.

        Raises
        ------
        UserError
            If a factor's level is outside the parameter's range.
        """
        fields: dict[str, Any] = {
            field: value
            for name, value in self.values.items()
            if (field := field_of(name, plate, PARAMETERS))
        }
        varied = context.varied
        return replace(
            context,
            condition=self.label,
            varied=varied and replace(varied, texture=replace(varied.texture, **fields)),
            textures=tuple(replace(each, **fields) for each in context.textures),
        )


def uncrossable(place: Place, factor: Factor, study: Mapping[str, Any]) -> Iterator[Fault]:
    """Yield the errors in a factor, given the study's valid fields."""
    levels = Levels.of(study)
    field = field_of(factor.name, levels.made, PARAMETERS)
    if len(set(factor.levels)) < len(factor.levels):
        yield (*place, "levels"), {"msg": "expected different values"}
    if factor.name in TAKEN or levels.made.in_file[factor.name] != factor.name:
        yield (
            (*place, "name"),
            {"msg": Message("'{factor}' is already a column of every task", factor=factor.name)},
        )
    if field and field == levels.vary:
        yield (*place, "name"), {"msg": Message("{factor} is already varied", factor=factor.name)}
    if field and not (levels.vary or study.get("textures")):
        yield (
            (*place, "name"),
            {"msg": "the study has no texture or [stimulus] with this parameter"},
        )
    known = {factor_level(each) for each in factor.levels}
    tables: dict[Place, Mapping[str, object]] = {
        ("simulated",): factor.simulated,
        ("simulated_growth",): factor.simulated_growth,
    }
    tables |= {("instructions", language): texts for language, texts in factor.instructions.items()}
    for key, table in tables.items():
        if strange := sorted(set(table) - known):
            message = Message(
                "unknown levels {levels}; expected levels of the factor", levels=", ".join(strange)
            )
            yield (*place, *key), {"msg": message}
    language = study.get("language", "en")
    if factor.instructions and known - set(factor.instructions.get(language, {})):
        yield (
            (*place, "instructions"),
            {"msg": Message("expected a text in '{language}' for each level", language=language)},
        )
    if field:
        yield from _unplayable(place, factor, levels, study)


def _unplayable(
    place: Place, factor: Factor, levels: Levels, study: Mapping[str, Any]
) -> Iterator[Fault]:
    """Yield errors for a factor's levels that the study's stimuli cannot present."""
    if words := [each for each in factor.levels if isinstance(each, str)]:
        yield (*place, "levels"), {"msg": Message("expected numbers, not '{word}'", word=words[0])}
        return
    textures = tuple(each.surface() for each in study.get("textures", ()))
    presented = levels.context(study.get("levels", ()), textures)
    for level in factor.levels:
        try:
            surfaces = Condition({factor.name: level}).context(presented, levels.made).surfaces
            for surface in surfaces:
                levels.follow(surface)
        except UserError as error:
            yield (*place, "levels"), {"msg": str(error)}
        else:
            yield from levels.beyond((*place, "levels"), *surfaces)


def second_levels(second: SecondPlate | None, factors: Iterable[Factor]) -> tuple[float, ...]:
    """Return the levels of the second actuator, or an empty tuple if there is none."""
    named = (each.levels for each in factors if second and each.name == second.factor)
    return tuple(level for level in next(named, ()) if isinstance(level, float))


def second_faults(second: SecondPlate, factors: Sequence[Factor]) -> Iterator[Fault]:
    """Yield errors in the definition of the factor that sets a second actuator's level."""
    named = [each for each in factors if each.name == second.factor]
    levels = second_levels(second, named)
    if not named:
        yield (
            ("factors",),
            {
                "msg": Message(
                    "[second_plate] requires a factor named {factor}", factor=second.factor
                )
            },
        )
    elif len(levels) < len(named[0].levels) or not 0 <= min(levels) <= max(levels) <= second.level:
        limit = second.quantity.quantity.short(second.level)
        message = Message(
            "expected the levels of {factor} to be numbers from 0 to {limit}",
            factor=second.factor,
            limit=limit,
        )
        yield ("factors",), {"msg": message}


def conditions_of(factors: Sequence[Factor]) -> list[Condition]:
    """Return all combinations of factor levels."""
    names = [factor.name for factor in factors]
    return [
        Condition(dict(zip(names, levels, strict=True)))
        for levels in product(*(factor.levels for factor in factors))
    ]


def crossed(
    protocol: Protocol,
    factors: Sequence[Factor],
    *,
    plate: Quantity,
    language: str,
    second: SecondPlate | None = None,
) -> Protocol:
    """Return a protocol that runs ``protocol`` once per condition.

    Without factors, return ``protocol`` unchanged.
    """
    if not factors:
        return protocol
    conditions = conditions_of(factors)

    def steps(options: Options, context: Context) -> Steps:
        total = protocol.trials(options, context)
        done = 0
        for number, condition in enumerate(ordered(conditions, context)):
            instructions = [
                text
                for factor in factors
                if (text := _instruction(factor, condition.values[factor.name], language))
            ]
            if instructions:
                yield Instruct(text="\n\n".join(instructions))
            inner = protocol.steps(options, condition.context(context, plate))
            left = total * (len(conditions) - number - 1)
            shift = _Shift(done, left, condition.values, second.factor if second else "")
            done = yield from _renumbered(inner, shift)

    def times(count: int) -> int:
        return count * len(conditions)

    return replace(
        protocol,
        steps=steps,
        trials=lambda options, context: times(protocol.trials(options, context)),
        most_trials=lambda options, context: times(protocol.most(options, context)),
        design={
            **{each.name: _column(each, plate, second) for each in factors},
            **protocol.design,
        },
    )


def ordered(conditions: Sequence[Condition], context: Context) -> list[Condition]:
    """Return the conditions in the participant's order."""
    (order,) = williams_blocks(
        len(conditions),
        1,
        lambda group, turn: context.shared_stream(context.task, "conditions", group, turn),
        context.place,
        no_immediate_repeat=False,
    )
    return [conditions[each] for each in order]


def _instruction(factor: Factor, level: Value, language: str) -> str:
    texts = factor.instructions.get(language, {})
    return texts.get(factor_level(level), "")


def _column(factor: Factor, plate: Quantity, second: SecondPlate | None) -> Column:
    field = field_of(factor.name, plate, PARAMETERS)
    quantity = PARAMETERS[field].parameter.quantity(plate) if field else None
    if second and factor.name == second.factor:
        quantity = second.quantity.quantity
    words = [each for each in factor.levels if isinstance(each, str)]
    return Column(
        value=lambda record: record.trial.factors[factor.name],
        kind="label" if words else "number",
        description=factor.description or (quantity.in_full_title if quantity else "Factor"),
        units=quantity.bids if quantity else "",
        levels={each: each for each in words},
        as_stated=True,
    )


@dataclass(frozen=True, slots=True)
class _Shift:
    """Renumbers the trials of one condition within the task.

    Parameters
    ----------
    before, after : int
        Number of trials in the previous conditions, and expected number in the remaining
        conditions.
    factors : Mapping
        The condition's values for the factor columns.
    second : str
        The factor that sets a second actuator's level; empty without a second actuator.
    """

    before: int
    after: int
    factors: Mapping[str, Value]
    second: str

    def trial(self, trial: Trial) -> Trial:
        return replace(
            trial,
            number=trial.number + self.before,
            total=trial.total + self.before + self.after,
            repeats=None if trial.repeats is None else trial.repeats + self.before,
            factors={**self.factors, **trial.factors},
        )

    def step(self, step: AnyStep) -> AnyStep:
        changed: dict[str, Any] = {"trial": self.trial(step.trial)} if step.trial else {}
        if isinstance(step, Present) and self.second:
            changed["second"] = self.factors[self.second]
        if isinstance(step, Present) and step.lead_in:
            changed["lead_in"] = tuple(self.step(each) for each in step.lead_in)
        elif isinstance(step, Adjust) and step.again:
            changed["again"] = tuple(self.step(each) for each in step.again)
        elif isinstance(step, EndBlock):
            changed["screen"] = self.step(step.screen)
        elif isinstance(step, Rest):
            changed |= {
                "done": step.done + self.before,
                "total": step.total + self.before + self.after,
            }
        return replace(step, **changed)


def _renumbered(steps: Steps, shift: _Shift) -> Generator[Step, Answer, int]:
    """Yield the steps with shifted trial numbers, and return the last trial number."""
    last, answer = shift.before, None
    while True:
        try:
            step = shift.step(steps.send(answer))
        except StopIteration:
            return last
        if step.trial:
            last = max(last, step.trial.number)
        answer = yield step
        if isinstance(answer, Voided):
            trials, dropped = (
                tuple(number - shift.before for number in numbers)
                for numbers in (answer.trials, answer.dropped)
            )
            answer = Voided(trials=trials, dropped=dropped)
