"""Everything that is concluded from a data set, in one frozen structure."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from slipscale.analysis.reading.delimited import read_tables
from slipscale.analysis.reading.trial_tables import STEP_AMPLITUDES
from slipscale.analysis.statistics import omnibus
from slipscale.analysis.statistics.bayesian_growth import bayesian_growth
from slipscale.analysis.statistics.descending_difference.coder_agreement import agreement
from slipscale.analysis.statistics.descending_difference.verbal_coding import SHIPPED, load_codebook
from slipscale.analysis.statistics.descending_difference.yes_no import analyse_differences
from slipscale.analysis.statistics.exponent_and_weber import exponent_and_weber
from slipscale.analysis.statistics.group_comparison import compare_groups, membership
from slipscale.analysis.statistics.growth import growth
from slipscale.analysis.statistics.matching import matching
from slipscale.analysis.statistics.mixed_model import mixed_model
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.order_effects import order_effects
from slipscale.analysis.statistics.pairwise import pairwise
from slipscale.analysis.statistics.power_law import exponents, power_law
from slipscale.analysis.statistics.productions import Counterpart, productions
from slipscale.analysis.statistics.psychometrics.forced_choice import thresholds
from slipscale.analysis.statistics.ratings import ratings
from slipscale.analysis.statistics.ratio_judgements import log_cells, ratios
from slipscale.analysis.statistics.reliability import reliability
from slipscale.analysis.statistics.scaling.task_scales import scales
from slipscale.analysis.statistics.session_effects import session_effects

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas as pd

    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.analysis.statistics.bayesian_growth import BayesianGrowth
    from slipscale.analysis.statistics.descending_difference.yes_no import DescendingDifference
    from slipscale.analysis.statistics.exponent_and_weber import ExponentAndWeber
    from slipscale.analysis.statistics.group_comparison import GroupComparison
    from slipscale.analysis.statistics.growth import Growth
    from slipscale.analysis.statistics.matching import MatchedReference
    from slipscale.analysis.statistics.mixed_model import MixedModel
    from slipscale.analysis.statistics.omnibus import Friedman, LinearTrend, PageTrend, RmAnova
    from slipscale.analysis.statistics.order_effects import OrderEffects
    from slipscale.analysis.statistics.pairwise import PairComparison
    from slipscale.analysis.statistics.power_law import PowerLaw
    from slipscale.analysis.statistics.productions import TaskProductions
    from slipscale.analysis.statistics.psychometrics.forced_choice import TaskThresholds
    from slipscale.analysis.statistics.ratings import TaskRatings
    from slipscale.analysis.statistics.ratio_judgements import TaskRatios
    from slipscale.analysis.statistics.reliability import Reliability
    from slipscale.analysis.statistics.scaling.task_scales import TaskScale
    from slipscale.analysis.statistics.session_effects import SessionEffects
    from slipscale.experiments.study.analysis_choices import SdConvention, Test, ZeroRule

T = TypeVar("T")


@dataclass(frozen=True, slots=True, kw_only=True)
class NormalisationUsed:
    """How estimates were brought to one scale.

    Parameters
    ----------
    rule : str or None
        A key of `slipscale.analysis.preprocessing.normalisation.RULES`; None without estimates.
    zero_rule : str
        What happened to estimates of zero before logarithms were taken.
    zeros : int
        How many estimates are zero.
    standard_deviation : {"sample", "population"}
        Convention of Table III.
    """

    rule: str | None
    zero_rule: ZeroRule
    zeros: int
    standard_deviation: SdConvention


@dataclass(frozen=True, slots=True, kw_only=True)
class Inference:
    """Every test's result, or why there is none: one field a test, in ``inference.json``'s order.

    See each class for its numbers.
    """

    rm_anova: RmAnova | NotComputed
    friedman: Friedman | NotComputed
    page_trend: PageTrend | NotComputed
    linear_trend: LinearTrend | NotComputed
    pairwise: tuple[PairComparison, ...] | NotComputed
    mixed_model: MixedModel | NotComputed
    power_law: PowerLaw | NotComputed
    growth: Growth | NotComputed
    bayesian_growth: BayesianGrowth | NotComputed
    order: OrderEffects | NotComputed
    reliability: Reliability | NotComputed
    sessions: SessionEffects | NotComputed
    groups: GroupComparison | NotComputed
    normalisation: NormalisationUsed
    difference: DescendingDifference | NotComputed
    thresholds: tuple[TaskThresholds, ...] | NotComputed
    scales: tuple[TaskScale, ...] | NotComputed
    matching: tuple[MatchedReference, ...] | NotComputed
    ratings: tuple[TaskRatings, ...] | NotComputed
    ratios: tuple[TaskRatios, ...] | NotComputed
    productions: tuple[TaskProductions, ...] | NotComputed
    exponent_and_weber: tuple[ExponentAndWeber, ...] | NotComputed


def conclude(
    data: Dataset,
    prepared: Prepared | None,
    rule: str | None,
    *,
    bayesian: bool = False,
    psignifit: bool = True,
) -> Inference:
    """Run every test that the study chose.

    Parameters
    ----------
    data : Dataset
        After exclusions.
    prepared : Prepared or None
        Magnitude estimates; None where there are none.
    rule : str or None
        How they were normalised.
    bayesian : bool
        Whether to sample the hierarchical Bayesian power function, which takes half a minute.
    psignifit : bool
        Whether to fit thresholds by psignifit too, which takes a second a participant and task.
    """
    chosen = data.choices.tests

    def chosen_only(name: Test, test: Callable[[], T | NotComputed]) -> T | NotComputed:
        if chosen is not None and name not in chosen:
            return NotComputed("not chosen in the study file")
        return test()

    def run(name: Test, test: Callable[[Prepared], T]) -> T | NotComputed:
        def tested() -> T | NotComputed:
            return NotComputed("no magnitude estimates") if prepared is None else test(prepared)

        return chosen_only(name, tested)

    def of_task(
        name: Test, test: Callable[[pd.DataFrame, float], T], trials: pd.DataFrame
    ) -> T | NotComputed:
        return chosen_only(name, lambda: test(trials, data.choices.confidence))

    found_thresholds = of_task(
        "thresholds", partial(thresholds, psignifit=psignifit), data.forced_choices
    )
    return Inference(
        rm_anova=run("rm_anova", omnibus.rm_anova),
        friedman=run("friedman", omnibus.friedman),
        page_trend=run("page_trend", omnibus.page_trend),
        linear_trend=run("linear_trend", omnibus.linear_trend),
        pairwise=run("pairwise", pairwise),
        mixed_model=run("mixed_model", mixed_model),
        power_law=run("power_law", power_law),
        growth=run("growth", partial(growth, film=data.quantity.of_plate)),
        bayesian_growth=run("bayesian_growth", bayesian_growth)
        if bayesian
        else NotComputed("not asked for (--bayesian)"),
        order=run("order", order_effects),
        reliability=run("reliability", reliability),
        sessions=chosen_only("sessions", lambda: session_effects(data, prepared)),
        groups=run("groups", partial(compare_groups, group_of=membership(data))),
        normalisation=NormalisationUsed(
            rule=rule,
            zero_rule=data.choices.zero_rule,
            zeros=prepared.zeros if prepared else 0,
            standard_deviation=data.choices.standard_deviation,
        ),
        difference=chosen_only("difference", lambda: difference(data)),
        thresholds=found_thresholds,
        scales=of_task("scales", scales, data.comparisons),
        matching=of_task("matching", matching, data.matches),
        ratings=of_task("ratings", ratings, data.ratings),
        ratios=of_task("ratios", ratios, data.ratios),
        productions=of_task(
            "productions",
            partial(productions, counterpart=counterpart(data, prepared)),
            data.productions,
        ),
        exponent_and_weber=chosen_only(
            "exponent_and_weber",
            lambda: exponent_and_weber(prepared, found_thresholds, data.choices.confidence),
        ),
    )


def counterpart(data: Dataset, prepared: Prepared | None) -> Counterpart | None:
    """Return the exponents that production is compared with: of estimates, else of ratios."""
    if prepared is not None and not prepared.refused:
        return Counterpart(
            name="magnitude estimation", exponents=exponents(prepared.logs)["exponent"]
        )
    main = data.ratios[~data.ratios["catch"].astype(bool)]
    if not len(main):
        return None
    logs = log_cells(main, "comparison_um_pp", "ratio")
    return Counterpart(name="ratio judgements", exponents=exponents(logs)["exponent"])


def difference(data: Dataset) -> DescendingDifference | NotComputed:
    """Return the descending difference, with the data set's own code book and coders."""
    folder, name = data.folder, data.choices.codebook
    book = load_codebook(folder / name if folder and name else SHIPPED)
    # Of a plate the amplitude before the step; elsewhere the reference of the stimulus.
    base = STEP_AMPLITUDES[0 if data.quantity.of_plate else 1]
    found = analyse_differences(data.differences, book, data.choices.confidence, base)
    codes = folder / "code" / "verbal_codes.tsv" if folder else None
    if isinstance(found, NotComputed) or codes is None or not codes.is_file():
        return found
    frame, _ = read_tables([codes], codes.parent, required=("verbal_report", "coder", "category"))
    return replace(found, coders=agreement(frame))
