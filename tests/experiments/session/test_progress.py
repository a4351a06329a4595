"""What the operator is told of a session's pace."""

from types import SimpleNamespace

import pytest

from slipscale.experiments.session.operator import SessionStatus
from slipscale.experiments.session.progress import Progress
from slipscale.experiments.steps.steps import EndTrial
from slipscale.experiments.steps.trial import Trial
from slipscale.hardware.clock import VirtualClock


def test_the_time_left_is_that_of_the_trials_left_at_the_pace_so_far_without_pauses():
    clock, told = VirtualClock(), []
    progress = Progress(
        SimpleNamespace(tell=told.append),
        clock,
        noise=SimpleNamespace(state="absent"),
        surface=SimpleNamespace(state="off", temperature_c=None),
        status=SessionStatus(state="showing", planned=12),
    )

    def trial(number):
        clock.sleep(15.0)
        progress.ends(EndTrial(trial=Trial(task="a", number=number, total=12, phase="main")))

    trial(1)
    trial(2)
    progress.replayed()  # those were before the session was resumed: no pace
    progress.tell("showing")
    assert told[-1].time_left_s is None
    trial(3)
    with progress.away():
        clock.sleep(100.0)
    trial(4)
    progress.tell("showing")
    # 60 s in all; 2 trials since the resume, 8 are left.
    assert told[-1].elapsed_s == pytest.approx(60.0)
    assert told[-1].time_left_s == pytest.approx(60.0 / 2 * 8)
    for number in range(5, 14):  # one trial was repeated
        trial(number)
    progress.tell("showing")
    assert told[-1].time_left_s == 0.0
