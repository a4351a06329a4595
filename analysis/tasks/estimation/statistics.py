"""Declare the statistics of magnitude estimates.

Each declaration combines functions that compute a result with functions that describe it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants
from slipscale.analysis.statistics.mixed_model import MixedModel, mixed_model
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.power_law import PowerLaw, power_law
from slipscale.analysis.statistics.reliability import Reliability, reliability
from slipscale.analysis.statistics.repeated_measures import omnibus
from slipscale.analysis.statistics.repeated_measures.pairwise import (
    PairComparison,
    PairedT,
    pairwise,
)
from slipscale.analysis.statistics.statistic import (
    Family,
    Inputs,
    Named,
    Sentence,
    Statistic,
    of_estimates,
)
from slipscale.analysis.tasks.estimation import sentences as write
from slipscale.analysis.tasks.estimation.growth.bayesian_growth import (
    BayesianGrowth,
    bayesian_growth,
)
from slipscale.analysis.tasks.estimation.growth.statistics import Growth, growth
from slipscale.analysis.tasks.estimation.order_effects import OrderEffects, order_effects
from slipscale.analysis.tasks.estimation.robust_exponent import RobustExponent, robust_exponent

if TYPE_CHECKING:
    from slipscale.experiments.study.analysis_choices import SdConvention, ZeroRule

Pairs = tuple[PairComparison, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class NormalisationUsed:
    """Rules that were used to normalise the estimates.

    Parameters
    ----------
    rule : str or None
        A key of `slipscale.analysis.preprocessing.normalisation.RULES`; None without estimates.
    zero_rule : str
        Rule for estimates of zero, applied before logarithms are computed.
    zeros : int
        Number of estimates that are zero.
    standard_deviation : {"sample", "population"}
        Convention for the standard deviation in the report's Table III.
    """

    rule: str | None
    zero_rule: ZeroRule
    zeros: int
    standard_deviation: SdConvention


def _logs(pairs: Pairs) -> list[PairedT]:
    return [pair.logs for pair in pairs if pair.logs]


def slope_ps(slopes: Sequence[MeanOverParticipants | NotComputed]) -> list[float]:
    """Return the p-values of the mean slopes, except slopes that were not computed."""
    return [slope.p for slope in slopes if isinstance(slope, MeanOverParticipants)]


class _Friedman(Statistic[omnibus.Friedman]):
    key = "friedman"
    title = "Friedman"
    meaning = "Friedman's test of ranks across {q.levels}"
    compute = of_estimates(omnibus.friedman)
    families = (
        Family(name="{q.levels}, Friedman's test", primary="ranks", read=lambda found: [found.p]),
    )
    sentences = (Sentence(write=write.friedman, primary="ranks"),)
    methods = (
        "The ranks of estimates were compared between {q.levels} by Friedman's test "
        "[[friedman1937]]. " + omnibus.FRIEDMAN_ERRORS
    )
    conclusions = (Named("p", "{q.levels} differ (Friedman's test)"),)
    headlines = (Named("kendalls_w", "Kendall's W"),)


class _RmAnova(Statistic[omnibus.RmAnova]):
    key = "rm_anova"
    title = "Repeated-measures ANOVA, log estimates"
    meaning = "repeated-measures ANOVA of log estimates across {q.levels}"
    compute = of_estimates(omnibus.rm_anova)
    families = (
        Family(
            name="{q.levels}, repeated-measures analysis of variance",
            primary="logarithms",
            read=lambda found: [found.p_gg],
        ),
    )
    sentences = (Sentence(write=write.rm_anova, primary="logarithms"),)
    methods = (
        "Log estimates were compared in a repeated-measures analysis of variance with the "
        "Greenhouse–Geisser correction [[greenhouse1959]] and generalised eta squared "
        "[[olejnik2003]]."
    )
    conclusions = (Named("p_gg", "{q.levels} differ (repeated-measures ANOVA of logarithms)"),)


class _Pairwise(Statistic[Pairs]):
    key = "pairwise"
    title = "Pairwise comparisons"
    meaning = "each pair of {q.levels}: Wilcoxon, t and equivalence tests, and Bayes factor"
    compute = of_estimates(pairwise)
    families = (
        Family(
            name="pairs of {q.levels}, Wilcoxon's test",
            primary="ranks",
            corrected=True,
            read=lambda pairs: [pair.ranks.p for pair in pairs],
        ),
        Family(
            name="pairs of {q.levels}, paired t",
            primary="logarithms",
            corrected=True,
            read=lambda pairs: [logs.p for logs in _logs(pairs)],
        ),
        Family(
            name="pairs of {q.levels}, equivalence",
            corrected=True,
            read=lambda pairs: [logs.equivalence.p for logs in _logs(pairs)],
        ),
    )
    sentences = (
        Sentence(write=write.pairwise_ranks, primary="ranks"),
        Sentence(write=write.pairwise_logs, primary="logarithms"),
        Sentence(write=write.equivalence),
    )
    methods = (
        "Pairs of {q.levels} were compared by Wilcoxon signed-rank tests [[wilcoxon1945]] of "
        "estimates and by paired t tests of log estimates, each with Holm's correction "
        "[[holm1979]]. The equivalence of two {q.levels} was tested with two one-sided tests on "
        "the ratio of geometric means [[schuirmann1987]], with bounds of {bounds}, and with a "
        "Bayes factor with a Cauchy prior of scale 0.707 [[rouder2009]]."
    )
    conclusions = (
        Named("*.p_wilcoxon_holm", "{0[0]} and {0[1]} {q.unit} differ (Wilcoxon's test, Holm)"),
        Named("*.p_holm", "{0[0]} and {0[1]} {q.unit} differ (paired t test of logarithms, Holm)"),
        Named(
            "*.equivalence_p_holm",
            "{0[0]} and {0[1]} {q.unit} are equivalent (two one-sided tests, Holm)",
        ),
    )


class _PageTrend(Statistic[omnibus.PageTrend]):
    key = "page_trend"
    title = "Page's ordered trend"
    meaning = "Page's test of an ordered trend"
    compute = of_estimates(omnibus.page_trend)
    families = (Family(name="ordered trend, Page's test", read=lambda found: [found.p]),)
    sentences = (Sentence(write=write.page_trend),)
    methods = "An ordered trend was tested with Page's test [[page1963]]."
    conclusions = (Named("p", "estimates {q.grow} with {q.level} (Page's test)"),)


class _LinearTrend(Statistic[omnibus.LinearTrend]):
    key = "linear_trend"
    title = "Linear trend, log estimates"
    meaning = "linear trend of log estimates with {q.level}"
    compute = of_estimates(omnibus.linear_trend)
    families = (
        Family(name="linear trend", read=lambda found: slope_ps([found.log_slope_per_level])),
    )
    sentences = (Sentence(write=write.linear_trend),)
    methods = (
        "The linear trend is the mean of participants' regression slopes of log estimates on "
        "{q.name}, tested against 0."
    )
    conclusions = (Named("p", "log estimates have a linear trend"),)

    def parts(self, found: omnibus.LinearTrend) -> dict[str, object]:
        return {"Linear trend, log estimates": found.log_slope_per_level}


class _PowerLaw(Statistic[PowerLaw]):
    key = "power_law"
    title = "Exponent"
    meaning = "exponent of the power function (the mean of participants' slopes)"
    compute = of_estimates(power_law)
    sentences = (Sentence(write=write.power_law),)
    methods = (
        "The exponent is the mean of participants' regression slopes of log estimates on log "
        "{q.name} [[stevens1957]], with t-based intervals across participants."
    )
    headlines = (Named("exponent", "exponent of the power function"),)


class _MixedModel(Statistic[MixedModel]):
    key = "mixed_model"
    title = "Mixed model"
    meaning = "mixed model of log estimates on log {q.level}"
    compute = of_estimates(mixed_model)
    sentences = (Sentence(write=write.mixed_model),)
    methods = (
        "A mixed model of log estimates on log {q.name}, with random intercepts and slopes, "
        "was fitted by restricted maximum likelihood [[laird1982]]."
    )


class _RobustExponent(Statistic[RobustExponent]):
    key = "robust_exponent"
    title = "Robust exponent"
    meaning = "robust exponent, which gives little weight to lapses and outliers"
    compute = of_estimates(robust_exponent)
    sentences = (Sentence(write=write.robust_exponent),)
    methods = (
        "Robust exponents are Theil–Sen slopes across trials [[sen1968]], averaged as a 20 % "
        "trimmed mean [[tukey1963]]."
    )


class _Growth(Statistic[Growth]):
    key = "growth"
    title = "Growth functions"
    meaning = "comparison of growth functions"
    compute = of_estimates(growth)
    sentences = (Sentence(write=write.growth),)
    methods = (
        "Growth functions were fitted to participants' mean log estimates by least squares, "
        "with one scale factor per participant, and compared by the corrected Akaike information "
        "criterion [[hurvich1989]]."
    )
    conclusions = (
        Named("amplitude.best.*", "among the growth functions, {0} fits best"),
        Named(
            "friction.best.*",
            "among the functions of the predicted reduction in friction, {0} fits best",
        ),
        Named(
            "friction.exponent.p",
            "the exponent of the power function of the predicted reduction in friction differs "
            "from 0",
        ),
    )


class _BayesianGrowth(Statistic[BayesianGrowth]):
    key = "bayesian_growth"
    meaning = "hierarchical Bayesian power function"
    sentences = (Sentence(write=write.bayesian_growth),)
    methods = (
        "A hierarchical Bayesian power function, with participants' levels and exponents from "
        "a bivariate normal distribution, was sampled with NumPyro."
    )

    def compute(self, inputs: Inputs) -> BayesianGrowth | NotComputed:
        if not inputs.bayesian:
            return NotComputed("not requested (--bayesian)")
        return of_estimates(bayesian_growth)(inputs)


class _Order(Statistic[OrderEffects]):
    key = "order"
    title = "Order and carry-over"
    meaning = "drift over a session, and carry-over from the preceding surface"
    compute = of_estimates(order_effects)
    families = (
        Family(
            name="order and carry-over",
            read=lambda found: slope_ps(
                [found.log_slope_per_trial, found.log_slope_per_level_before]
            ),
        ),
    )
    sentences = (Sentence(write=write.order),)
    methods = (
        "The effects of trial position and of the preceding {q.stimulus} were estimated "
        "jointly, with a jackknife across participants [[tukey1958]]."
    )
    conclusions = (
        Named("position.p", "estimates drift over a session"),
        Named("carry_over.p", "estimates depend on the preceding surface"),
    )

    def parts(self, found: OrderEffects) -> dict[str, object]:
        return {
            "Order (trial position)": found.log_slope_per_trial,
            "Order (preceding {q.stimulus})": found.log_slope_per_level_before,
        }


class _Reliability(Statistic[Reliability]):
    key = "reliability"
    title = "Test-retest reliability"
    meaning = "reliability of repeated estimates"
    compute = of_estimates(reliability)
    sentences = (Sentence(write=write.reliability),)
    methods = (
        "Test-retest reliability is an intraclass correlation from variance components, with "
        "{q.levels} as a fixed effect and a jackknife across participants."
    )


class _Normalisation(Statistic[NormalisationUsed]):
    key = "normalisation"
    meaning = "the rule that puts participants' estimates on a common scale"
    test = False

    def compute(self, inputs: Inputs) -> NormalisationUsed:
        choices = inputs.data.choices
        return NormalisationUsed(
            rule=inputs.rule,
            zero_rule=choices.zero_rule,
            zeros=inputs.prepared.zeros if inputs.prepared else 0,
            standard_deviation=choices.standard_deviation,
        )


#: All statistics, in the order of ``inference.json`` and of the results section.
STATISTICS: tuple[Statistic[object], ...] = (
    FRIEDMAN := _Friedman(),
    RM_ANOVA := _RmAnova(),
    PAIRWISE := _Pairwise(),
    PAGE_TREND := _PageTrend(),
    LINEAR_TREND := _LinearTrend(),
    POWER_LAW := _PowerLaw(),
    MIXED_MODEL := _MixedModel(),
    ROBUST_EXPONENT := _RobustExponent(),
    GROWTH := _Growth(),
    BAYESIAN_GROWTH := _BayesianGrowth(),
    ORDER := _Order(),
    RELIABILITY := _Reliability(),
    NORMALISATION := _Normalisation(),
)
