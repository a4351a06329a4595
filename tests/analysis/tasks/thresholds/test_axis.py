"""The axis of every threshold is chosen once, and each report names it."""

import numpy as np
import pandas as pd
import pytest
from pydantic import ValidationError
from scipy import optimize, special

from slipscale.analysis.tasks.difference.step_size_curve import psychometric
from slipscale.analysis.tasks.difference.yes_no import own_thresholds
from slipscale.analysis.tasks.thresholds.statistics import COMPARED, curve_of
from slipscale.commands import load_command
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES
from slipscale.experiments.study.analysis_choices import AnalysisChoices

#: Hecht, Shlaer and Pirenne (1942): quanta at the cornea, yes answers, and trials per level.
OBSERVERS = {
    "SH": [
        ((46.9, 73.1, 113.8, 177.4, 276.1, 421.7), (0, 3, 12, 26, 35, 35), 35),
        ((37.1, 58.5, 92.9, 148.6, 239.3, 386.4), (0, 3, 16, 32, 39, 40), 40),
    ],
    "SS": [
        ((24.1, 37.6, 58.6, 91.0, 141.9, 221.3), (0, 2, 9, 27, 47, 50), 50),
        ((23.5, 37.1, 58.5, 92.9, 148.6, 239.3), (0, 0, 6, 22, 47, 50), 50),
    ],
    "MHP": [((37.6, 58.6, 91.0, 141.9, 221.3, 342.8), (3, 3, 12, 33, 44, 50), 50)],
}
KNOWN = {
    "linear": {"SH": 126.07, "SS": 93.34, "MHP": 131.97},
    "logarithmic": {"SH": 116.8, "SS": 88.0, "MHP": 118.9},
}


@pytest.fixture
def steps():
    rows = [
        (who, level, float(place < yes))
        for who, series in OBSERVERS.items()
        for levels, counts, n in series
        for level, yes in zip(levels, counts, strict=True)
        for place in range(n)
    ]
    frame = pd.DataFrame(rows, columns=["participant_id", "level_before", "difference_felt"])
    return frame.assign(level=0.0)


@pytest.mark.parametrize("axis", ["linear", "logarithmic"])
def test_thresholds_of_yes_no_answers_follow_the_axis(steps, axis):
    found = own_thresholds(steps, 0.95, axis)
    for who, known in KNOWN[axis].items():
        assert found[who].threshold_level.value == pytest.approx(known, rel=1e-3)
        series = OBSERVERS[who]
        levels, yes = (np.concatenate([each[place] for each in series]) for place in (0, 1))
        n = np.repeat([each[2] for each in series], 6)
        x = levels if axis == "linear" else np.log(levels)

        def minus_log(b, x=x, yes=yes, n=n):
            odds = b[0] + b[1] * (x - x.mean()) / x.std()
            return -(yes * odds - n * np.logaddexp(0, odds)).sum()

        a, b = optimize.minimize(minus_log, [0.0, 1.0], method="Nelder-Mead", tol=1e-12).x
        half = x.mean() - a / b * x.std()
        plain = half if axis == "linear" else np.exp(half)
        assert plain == pytest.approx(known, rel=1e-3)


@pytest.mark.parametrize("axis", ["linear", "logarithmic"])
def test_the_curve_of_all_people_is_fitted_on_the_axis(steps, axis):
    found = psychometric(steps, axis=axis)
    at = found.half_yes if axis == "linear" else np.log(found.half_yes)
    assert special.expit(found.intercept + found.log_odds_per_unit * at) == pytest.approx(0.5)
    assert 85 < found.half_yes < 135  # between the observers
    assert found.axis == axis
    with_catches = pd.concat([steps, steps.assign(level_before=0.0, difference_felt=0.0)])
    again = psychometric(with_catches, axis=axis)
    assert (again.answers == found.answers) is (axis == "logarithmic")


@pytest.mark.parametrize("method", ["two_interval", "three_interval", "oddity", COMPARED])
@pytest.mark.parametrize("curve", [None, "log_normal", "logistic"])
def test_every_method_has_a_curve_on_the_chosen_axis(method, curve):
    for axis in ("linear", "logarithmic"):
        asked = {"axis": axis} | ({"threshold_curve": curve} if curve else {})
        if curve and CURVES[curve].logarithmic != (axis == "logarithmic"):
            with pytest.raises(ValidationError, match="is not on a"):
                AnalysisChoices(**asked)
            continue
        found = curve_of(method, AnalysisChoices(**asked))
        assert CURVES[found].logarithmic == (axis == "logarithmic")
        assert found == curve or not curve
    assert curve_of(method, AnalysisChoices()) == ("normal" if method == COMPARED else "weibull")


@pytest.mark.parametrize("word", ["log", "logarithmic"])
def test_the_beginning_of_an_axis_is_enough_on_the_command_line(word):
    parser, _ = load_command("analyse")
    assert parser.parse_args(["table.csv", "--axis", word]).axis == "logarithmic"
