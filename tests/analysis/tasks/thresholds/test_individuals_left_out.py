"""Individual thresholds state whom they leave out, and a spread of zero is said."""

from types import SimpleNamespace

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.thresholds.section import _range
from slipscale.analysis.tasks.thresholds.sentences import _no_spread
from slipscale.stimuli.quantity import PLATE_AMPLITUDE


def person(threshold_um):
    level = SimpleNamespace(threshold_level=SimpleNamespace(value=threshold_um))
    return SimpleNamespace(function=NotComputed("below") if threshold_um is None else level)


def test_a_median_of_some_participants_is_said_to_be_biased():
    task = SimpleNamespace(participants=[person(each) for each in (0.11, 0.15, 0.165, None)])
    told = _range(task, PLATE_AMPLITUDE)
    assert told.startswith("Individual participants: 0.110 to 0.165 µm, median 0.150 (n = 3 of 4;")
    assert "biased" in told
    task.participants.pop()
    assert _range(task, PLATE_AMPLITUDE).endswith("median 0.150")


def test_equal_thresholds_are_said_to_be_indistinguishable():
    threshold = SimpleNamespace(value=0.2)
    for curve, none, some in (("weibull", 1e-7, 0.1), ("logistic", 1e-6, 0.05)):
        joint = SimpleNamespace(sd=none, threshold_level=threshold)
        assert "not distinguishable from 0" in _no_spread(joint, curve)
        joint.sd = some
        assert _no_spread(joint, curve) == ""
