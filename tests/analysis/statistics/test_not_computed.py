"""A result or a reason: how conditions read it."""

import pytest

from slipscale.analysis.statistics.not_computed import (
    NotComputed,
    all_computed,
    computed,
    fold,
    missing,
)

REASON = NotComputed("too few")


def test_a_reason_is_false_so_that_a_condition_asks_for_the_result():
    assert not REASON


@pytest.mark.parametrize("result", [0.0, (), "", 1.5])
def test_functions_keep_results_that_are_false_themselves(result):
    assert computed(result) == result
    assert all_computed([REASON, result]) == [result]
    assert missing([REASON, result]) == [REASON]
    assert fold(result, str, str) == str(result)


def test_a_reason_is_read_where_there_is_no_result():
    assert computed(REASON) is None
    assert fold(REASON, repr, str.upper) == "TOO FEW"
