"""A trial that timed out comes again, once: whoever never answers comes to the end."""

import pytest

from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.steps import Adjust, Ask, EndTrial
from slipscale.experiments.study.file import study_text

STUDIES = ("matching", "paired_comparison", "visual_analogue_scale")


@pytest.mark.parametrize("name", STUDIES)
def test_a_trial_that_times_out_again_is_not_repeated_again(plan, name):
    text = study_text(name).replace("[[tasks]]\n", "[[tasks]]\nrepeat_timed_out = true\n")
    if "response_time_limit_s" not in text:
        text = text.replace("[[tasks]]\n", "[[tasks]]\nresponse_time_limit_s = 9.0\n")
    made = plan(text, seed=3)
    steps, answer, over = made.steps(), None, []
    while len(over) < 1000:
        try:
            step = steps.send(answer)
        except StopIteration:
            break
        answer = None
        if isinstance(step, Ask | Adjust):
            answer = Reply(value=None if step.trial else "1", timed_out=bool(step.trial))
        elif isinstance(step, EndTrial):
            over.append(step.trial)
    first = [trial.number for trial in over if trial.repeats is None]
    repeats = [trial.repeats for trial in over if trial.repeats is not None]
    assert len(first) > 5
    assert sorted(repeats) == sorted(first)
    assert made.planned_trials() == len(first)
