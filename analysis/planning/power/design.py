"""Extract the properties of a study that affect power: task, tests, normalisation, exclusions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

from slipscale.analysis.planning.power.grid import Condition
from slipscale.analysis.planning.power.yes_no_steps import StepTask
from slipscale.analysis.planning.simulated.estimates import Task
from slipscale.analysis.planning.simulated.fast_tests import DIVISORS, OMNIBUS, TESTS
from slipscale.analysis.reading.surface_labels import numbers_first
from slipscale.experiments.participants.simulated_people.growth import people_for
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.protocol_parts.base import Context, Options
from slipscale.experiments.protocols.descending_difference import DescendingDifference, descent
from slipscale.experiments.protocols.magnitude_estimation import MagnitudeEstimation
from slipscale.experiments.steps.trial import factor_level
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.experiments.study.factors import conditions_of
from slipscale.experiments.study.model import Study
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError

#: Tests that are computed for one study at a time.
SLOW = ("page_trend", "mixed_model")


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """Properties of a study that affect power and are the same in all conditions.

    Parameters
    ----------
    name : str
        Name of the study.
    task : Task
        The study's magnitude-estimation task.
    steps : StepTask or None
        The study's descending difference task.
    declared : bool
        Whether participants state the maximum of their scale.
    choices : AnalysisChoices
        The study's analysis choices.
    population : Population
    alpha : float
    varied : str
        Name of the varied quantity, such as "amplitude".
    """

    name: str
    task: Task
    steps: StepTask | None
    declared: bool
    choices: AnalysisChoices
    population: Population
    alpha: float
    varied: str = "amplitude"
    unit: str = "µm"

    @property
    def rule(self) -> str:
        """The normalisation rule that `analyse` would use."""
        return self.choices.normalisation or ("scale_top" if self.declared else "grand_maximum")

    @property
    def omnibus(self) -> str:
        """The omnibus test of the primary analysis."""
        return OMNIBUS[self.choices.primary]

    @property
    def tests(self) -> tuple[str, ...]:
        """Tests whose power is estimated: the planned tests, or by default all vectorised tests."""
        known = (*TESTS, *SLOW)
        named = self.choices.tests
        chosen = list(TESTS) if named is None else [test for test in known if test in set(named)]
        # These tests need at least three amplitudes. Two amplitudes are compared pairwise.
        if len(self.task.levels) < 3:  # noqa: PLR2004
            chosen = [test for test in chosen if test not in ("friedman", "page_trend")]
        return tuple(chosen)

    @property
    def factor_tests(self) -> dict[str, bool]:
        """For each test of a factor, whether the simulated population has the tested effect.

        Each factor is tested twice: its effect on means, and its interaction with the amplitude.
        """
        people = self.population
        return {
            f"{factor}{crossed}": any(name == factor and by != 1 for name, _, by in stated)
            for factor, _ in self.task.factors
            for crossed, stated in (
                ("", people.effects),
                (f" x {self.varied}", people.growths),
            )
        }

    @property
    def mixed_tests(self) -> dict[str, tuple[str, str, str]]:
        """Factor, level and key of `TERMS`, for each mixed-model test of a factor.

        Each level is compared with the factor's first level. The mapping is empty unless the study
        lists ``factors`` in its tests, because the fits are slow.
        """
        if "factors" not in (self.choices.tests or ()):
            return {}
        crossed = {"log_ratio": "", "exponent": f" x {self.varied}"}
        return {
            f"{factor} {level}{crossed[what]}, mixed model": (factor, level, what)
            for factor, levels in self.task.factors
            for level in sorted(levels, key=numbers_first)[1:]
            for what in crossed
        }

    @property
    def pairs(self) -> bool:
        """Whether amplitudes are compared pairwise."""
        return self.choices.tests is None or "pairwise" in self.choices.tests

    def task_of(self, condition: Condition) -> Task:
        """Adapt the task to a condition's repetitions, order and catch steps."""
        task = replace(self.task, repetitions=condition.repetitions)
        if condition.order is not None:
            task = replace(task, order=condition.order)
        own, steps = self.steps, self.steps_of(condition)
        if own is None or steps is None:
            return task
        more = steps.trials - own.trials
        if own.trials_before < task.trials_before:
            return replace(task, trials_before=task.trials_before + more)
        return replace(task, trials_after=task.trials_after + more)

    def steps_of(self, condition: Condition) -> StepTask | None:
        """Return the descending difference task with the condition's number of catch steps.

        The result is None if the study has no such task, or if catch steps were not requested.
        """
        if self.steps is None or condition.catch_steps is None:
            return None
        return replace(self.steps, catch_steps=condition.catch_steps)

    @property
    def identity(self) -> dict[str, object]:
        """Return all settings that affect a result, except the condition, as JSON data."""
        task = asdict(self.task)
        if not self.task.factors:
            del task["factors"]  # studies without factors keep their random numbers
        return {
            "task": task,
            "steps": None if self.steps is None else asdict(self.steps),
            "declared": self.declared,
            # These choices do not affect power, and would change the random numbers.
            "choices": self.choices.model_dump(
                mode="json", exclude={"threshold_reversals", "threshold_friction", "axis"}
            ),
            "population": self.population.model_dump(mode="json", exclude={"name"}),
            "alpha": self.alpha,
        }


def design_of(study: Study, text: str, population: Population, alpha: float) -> Design:
    """Extract the properties of a study that affect power.

    Raises
    ------
    UserError
        If the study has no magnitude-estimation task, or fewer than two amplitudes.
    """
    plan = RunPlan(
        study_name=study.name,
        study_text=text,
        participant="01",
        session=study.sessions[0] if study.sessions else "",
        seed=0,
        language=study.language,
        mode="pilot",
    )
    context = plan.context()
    counts = [(options, protocol.trials(options, context)) for protocol, options in plan.tasks()]
    places = estimation_of(study)
    if not places:
        raise UserError(
            "{study_name}: no task uses magnitude_estimation; for other tasks, slipscale power "
            "only compares thresholds between the levels of [[factors]]",
            study_name=study.name,
        )
    if len(study.levels) < 2:  # noqa: PLR2004
        raise UserError(
            "{study_name}: the study has one amplitude; expected two or more", study_name=study.name
        )
    place = places[0]
    options = counts[place][0]
    factors = tuple((each.name, tuple(map(factor_level, each.levels))) for each in study.factors)
    before, after = _around(counts, place)
    if not isinstance(options, MagnitudeEstimation):
        raise TypeError(type(options).__name__)
    return Design(
        name=study.name,
        task=Task(
            levels=tuple(sorted(study.levels)),
            repetitions=options.repetitions,
            practice=options.practice,
            order=options.randomisation,
            no_immediate_repeat=options.no_immediate_repeat,
            trials_before=before,
            trials_after=after,
            factors=factors,
        ),
        steps=_steps(counts, context, len(conditions_of(study.factors))),
        declared=options.scale_top == "declared",
        choices=_plannable(study),
        population=people_for(study, population),
        alpha=alpha,
        varied=study.quantity.name,
        unit=study.quantity.unit,
    )


def estimation_of(study: Study) -> list[int]:
    """Return the indices of the study's magnitude-estimation tasks."""
    return [n for n, each in enumerate(study.tasks) if isinstance(each, MagnitudeEstimation)]


def _around(counts: Sequence[tuple[Options, int]], place: int) -> tuple[int, int]:
    """Return the number of trials in the tasks before a given task, and in the tasks after it."""
    trials = [number for _, number in counts]
    return sum(trials[:place]), sum(trials[place + 1 :])


def _steps(
    counts: Sequence[tuple[Options, int]], context: Context, conditions: int
) -> StepTask | None:
    """Return the first descending difference task, or None if there is none or it has no steps.

    Series from all conditions are pooled.
    """
    for place, (options, _) in enumerate(counts):
        if isinstance(options, DescendingDifference):
            falling = descent(options, context)
            if len(falling) < 2:  # noqa: PLR2004
                return None
            before, after = _around(counts, place)
            return StepTask(
                descent_level=tuple(falling),
                series=options.series * conditions,
                catch_steps=options.catch_steps,
                trials_before=before,
                trials_after=after,
            )
    return None


def _plannable(study: Study) -> AnalysisChoices:
    """Return the study's analysis choices; raise UserError if simulations cannot be normalised."""
    choices = study.analysis
    if choices.normalisation not in (None, *DIVISORS):
        raise UserError(
            "{study_name}: normalisation '{normalisation}' requires a standard, which simulated "
            "studies do not have; expected one of {divisors}",
            study_name=study.name,
            normalisation=choices.normalisation,
            divisors=", ".join(DIVISORS),
        )
    return choices
