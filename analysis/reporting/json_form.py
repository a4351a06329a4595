"""Results as JSON: how each class of result is written.

The top-level keys of inference.json are the fields of
`slipscale.analysis.statistics.run_all.Inference`, those of results.json stand in
`slipscale.analysis.reporting.files`.

A class is written as its fields, under their names; what differs from that stands here, class by
class. An interval is ``[low, high]``, a key that is an amplitude is written ``0.5``, and NaN is
null.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import singledispatch
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from slipscale.analysis.own.declaration import OwnFinding
from slipscale.analysis.statistics.bayesian_growth import BayesianGrowth, IndividualExponent
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.descending_difference.coder_agreement import CoderAgreement
from slipscale.analysis.statistics.descending_difference.probit import DPrimeOfSize
from slipscale.analysis.statistics.descending_difference.step_size_curve import PsychometricCurve
from slipscale.analysis.statistics.descending_difference.yes_no import (
    CatchAnswers,
    DescendingDifference,
    Finding,
    SignalDetection,
    StepAnswers,
)
from slipscale.analysis.statistics.group_comparison import Effect
from slipscale.analysis.statistics.growth import FrictionGrowth
from slipscale.analysis.statistics.growth_models import RankedFit
from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants
from slipscale.analysis.statistics.mixed_model import MixedModel
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.omnibus import LinearTrend, RmAnova
from slipscale.analysis.statistics.order_effects import OrderEffects
from slipscale.analysis.statistics.pairwise import PairComparison
from slipscale.analysis.statistics.power_law import PowerLaw
from slipscale.analysis.statistics.psychometrics.psychometric_function import PsychometricFunction
from slipscale.analysis.statistics.reliability import IntraclassCorrelation
from slipscale.analysis.statistics.robustness import SubsetSummary
from slipscale.analysis.statistics.welch import GroupDifference, GroupMean, Welch

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Json: TypeAlias = "dict[str, Json] | list[Json] | str | float | int | bool | None"
JsonObject: TypeAlias = dict[str, Json]


def text(value: object) -> str:
    """Return a result as the text of a JSON file."""
    return json.dumps(form(value), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


@singledispatch
def form(value: object) -> Json:
    """Return a value as JSON can hold it.

    >>> form({0.5: ConfidenceInterval(1.0, float("nan"))})
    {'0.5': [1.0, None]}
    """
    if isinstance(value, np.generic):
        return form(value.item())
    if is_dataclass(value) and not isinstance(value, type):
        return _fields(value)
    if value is None or isinstance(value, str | int):
        return value
    raise TypeError(f"{type(value).__name__}: not a result")


@form.register(float)
def _(value: float) -> Json:
    return value if math.isfinite(value) else None


@form.register(Mapping)
def _(value: Mapping[object, object]) -> Json:
    return {
        f"{key:g}" if isinstance(key, float) else str(key): form(inner)
        for key, inner in value.items()
    }


@form.register(list)
@form.register(tuple)
def _(value: Sequence[object]) -> Json:
    return [form(inner) for inner in value]


@form.register(ConfidenceInterval)
def _(value: ConfidenceInterval) -> Json:
    return [form(bound) for bound in value]


def _fields(value: DataclassInstance, **renamed: str) -> JsonObject:
    """Return a class's fields by name; ``renamed`` maps a field to its key."""
    return {
        renamed.get(field.name, field.name): form(getattr(value, field.name))
        for field in fields(value)
    }


def _without(record: JsonObject, *names: str) -> JsonObject:
    return {key: value for key, value in record.items() if key not in names}


def _bounds(interval: ConfidenceInterval | None) -> Json:
    """Return an interval's bounds; those of one that is not defined are null."""
    return [None, None] if interval is None else form(interval)


def _interval_key(interval: ConfidenceInterval | None) -> str:
    """Return the key of an interval that says "ci95" only where it is one."""
    return "ci95" if interval is not None and interval.confidence == 0.95 else "ci"  # noqa: PLR2004


def record(value: object) -> JsonObject:
    """Return a result that has keys, with its keys."""
    found = form(value)
    if not isinstance(found, dict):
        raise TypeError(f"{type(value).__name__}: has no keys")
    return found


@form.register(RmAnova)
def _(found: RmAnova) -> Json:
    keys: JsonObject = {"scale": "log"}
    keys |= _fields(found, eta2_generalised_interval="eta2_generalised_ci")
    keys["eta2_generalised_ci"] = _bounds(found.eta2_generalised_interval)
    return keys if found.shapiro_p is not None else _without(keys, "shapiro_w", "shapiro_p")


@form.register(MeanOverParticipants)
@form.register(MixedModel)
def _(found: MeanOverParticipants | MixedModel) -> Json:
    return _fields(found, interval="ci")


@form.register(GroupMean)
@form.register(GroupDifference)
@form.register(Welch)
@form.register(Effect)
@form.register(BayesianGrowth)
@form.register(IndividualExponent)
def _(
    found: GroupMean | GroupDifference | Welch | Effect | BayesianGrowth | IndividualExponent,
) -> Json:
    return {
        "ci" if name == "interval" else name.replace("_interval", "_ci"): value
        for name, value in _fields(found).items()
    }


@form.register(PsychometricCurve)
def _(found: PsychometricCurve) -> Json:
    names = {"interval": "ci", "half_yes_interval": "half_yes_ci"}
    if found.measure == "removed_um_pp":
        names |= {"log_odds_per_unit": "log_odds_per_um", "half_yes": "half_yes_um"}
    return _fields(found, **names)


@form.register(PsychometricFunction)
def _(found: PsychometricFunction) -> Json:
    slope = found.slope
    return {
        "estimator": found.estimator,
        "threshold_um": form(found.threshold_um_pp.value),
        "threshold_ci": form(found.threshold_um_pp.interval),
        "slope": form(slope) if isinstance(slope, NotComputed) else form(slope.value),
        "slope_ci": [None, None] if isinstance(slope, NotComputed) else form(slope.interval),
        "lapse": found.lapse,
        "guess": found.guess,
        "trials": found.trials,
        "levels": found.levels,
    }


@form.register(PowerLaw)
def _(found: PowerLaw) -> Json:
    return _fields(found, interval=_interval_key(found.interval))


@form.register(CoderAgreement)
def _(found: CoderAgreement) -> Json:
    return _fields(found, interval="ci95")


@form.register(IntraclassCorrelation)
def _(found: IntraclassCorrelation) -> Json:
    return _fields(found, interval="ci")


@form.register(LinearTrend)
def _(found: LinearTrend) -> Json:
    return {
        "unit": "natural logarithm per um_pp",
        **record(found.log_slope_per_um_pp),
        "n": found.n,
        "n_incomplete": found.n_incomplete,
    }


@form.register(OrderEffects)
def _(found: OrderEffects) -> Json:
    return {
        "position": {
            "unit": "natural logarithm per trial",
            **record(found.log_slope_per_trial),
        },
        "carry_over": {
            "unit": "natural logarithm per um_pp",
            **record(found.log_slope_per_um_pp_before),
        },
    }


@form.register(PairComparison)
def _(pair: PairComparison) -> Json:
    keys: JsonObject = {
        "from_um_pp": pair.from_um_pp,
        "to_um_pp": pair.to_um_pp,
        "n": pair.n,
        "n_logs": pair.n_logs,
    }
    equal: JsonObject = {}
    if isinstance(pair.logs, NotComputed):
        keys |= {"reason": pair.logs.reason, "p": None}
        p_holm = None
    else:
        keys |= _without(
            _fields(pair.logs, ratio_interval="ratio_ci", d_z_interval="d_z_ci"),
            *("p_holm", "equivalence", "equivalence_p_holm", "bayes_factor"),
        )
        keys["d_z_ci"] = _bounds(pair.logs.d_z_interval)
        same = pair.logs.equivalence
        equal |= {
            "equivalence_ratio": same.bound,
            "equivalence_ci": form(same.interval),
            "equivalence_p": form(same.p),
            "equivalence_p_holm": form(pair.logs.equivalence_p_holm),
            "bayes_factor_10": form(pair.logs.bayes_factor),
        }
        p_holm = form(pair.logs.p_holm)
    return keys | {
        "p_wilcoxon": form(pair.ranks.p),
        "up": pair.ranks.up,
        "down": pair.ranks.down,
        "p_holm": p_holm,
        "p_wilcoxon_holm": form(pair.ranks.p_holm),
        **equal,
    }


@form.register(RankedFit)
def _(found: RankedFit) -> Json:
    return record(found.fit) | _without(_fields(found), "fit")


@form.register(FrictionGrowth)
def _(found: FrictionGrowth) -> Json:
    return record(found.comparison) | _without(_fields(found), "comparison")


@form.register(StepAnswers)
@form.register(CatchAnswers)
def _(found: StepAnswers | CatchAnswers) -> Json:
    keys = _fields(found, interval=_interval_key(found.interval))
    return _without(keys, "ci") if found.interval is None else keys


@form.register(DPrimeOfSize)
def _(found: DPrimeOfSize) -> Json:
    return _fields(found, interval=_interval_key(found.interval)) | {"at_ceiling": found.at_ceiling}


@form.register(SignalDetection)
def _(found: SignalDetection) -> Json:
    pooled = record(found.pooled)
    return {
        "pooled_d_prime": pooled["d_prime"],
        "pooled_criterion": pooled["criterion"],
        **_without(pooled, "d_prime", "criterion"),
        "by_size": form(found.by_size),
        "all_sizes": form(found.all_sizes),
        "mean_of_participants": form(found.mean_d_prime),
        "participants": form(found.participants),
    }


@form.register(Finding)
def _(found: Finding) -> Json:
    return _fields(found) | {
        "all_felt_a_difference": found.all_felt_a_difference,
        "all_said_less_slippery": found.all_said_less_slippery,
    }


@form.register(DescendingDifference)
def _(found: DescendingDifference) -> Json:
    detection = found.signal_detection
    keys = _fields(found)
    first: JsonObject = {"steps": keys.pop("steps"), "catch": keys.pop("catch")}
    first["d_prime"] = (
        form(detection) if isinstance(detection, NotComputed) else form(detection.pooled.d_prime)
    )
    return first | (_without(keys, "coders") if found.coders is None else keys)


@form.register(OwnFinding)
def _(found: OwnFinding) -> Json:
    keys: JsonObject = {"title": found.title, "package": found.package, "version": found.version}
    if isinstance(found.found, NotComputed):
        return keys | record(found.found)
    own = {"sentences": form(found.found.sentences), "numbers": form(found.found.numbers)}
    return {**keys, **own}


@form.register(SubsetSummary)
def _(found: SubsetSummary) -> Json:
    exponent = None if isinstance(found.power_law, NotComputed) else found.power_law
    friedman = None if isinstance(found.friedman, NotComputed) else found.friedman
    return {
        "participants": found.participants,
        "n": found.n,
        "exponent": form(exponent.exponent) if exponent else None,
        "exponent_ci": form(exponent.interval) if exponent else None,
        "friedman_chi2": form(friedman.chi2) if friedman else None,
        "friedman_p": form(friedman.p) if friedman else None,
        "means": form(found.means),
    }
