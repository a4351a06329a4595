"""Columns that a protocol declares without a function for their values."""

from dataclasses import replace

from slipscale.experiments.protocols.limits import PROTOCOL
from slipscale.experiments.steps.columns import Column, TrialRecord
from slipscale.experiments.steps.trial import Trial

TRIAL = Trial(task="limits", number=1, total=1, factors={"series": 3, "practised": True})


def value(name, **answers):
    response = {"different": Column(description=""), name: Column(description="")}
    made = replace(PROTOCOL, design={}, stimulus={}, response=response)
    given = {asked: {"value": answer} for asked, answer in answers.items()}
    return made.response[name].value(TrialRecord(trial=TRIAL, answers=given))


def test_a_column_contains_the_factor_of_its_name():
    assert value("series") == 3
    assert value("practised") == "true"


def test_a_column_contains_the_answer_if_no_factor_has_its_name():
    assert value("different", different=False) == "false"
    assert value("sure", sure="yes") == "yes"
    assert value("sure") is None


def test_a_factor_comes_before_an_answer_of_the_same_name():
    assert value("series", series=9.0) == 3
