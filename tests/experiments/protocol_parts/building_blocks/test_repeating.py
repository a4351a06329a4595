from slipscale.experiments.protocol_parts.building_blocks.repeating import Repeating
from slipscale.experiments.steps.replies import Voided
from slipscale.experiments.steps.steps import EndBlock, EndTrial, Instruct
from slipscale.experiments.steps.trial import Trial


class Letters(Repeating[str]):
    """A task whose trials are letters, and consist of their end."""

    def trial(self, condition, number, repeats):
        trial = Trial(
            task="t",
            number=number,
            total=self.total,
            factors={"letter": condition},
            repeats=repeats,
        )
        answer = yield EndTrial(trial=trial)
        return answer.trials


def run(steps, voids):
    """Answer each step by the trials voided there (by its number in the run); return the steps."""
    seen, answer = [], None
    while True:
        try:
            step = steps.send(answer)
        except StopIteration:
            return seen
        seen.append(step)
        answer = Voided(trials=voids.get(len(seen), ()))


def told(steps):
    return [
        (s.trial.factors["letter"], s.trial.number, s.trial.total, s.trial.repeats)
        for s in steps
        if isinstance(s, EndTrial)
    ]


def test_every_voided_trial_raises_the_total_by_one_and_comes_again_at_the_end():
    task = Letters(3)
    steps = run(task.block("abc"), {1: (1,), 4: (4,)})
    assert told(steps) == [
        ("a", 1, 3, None),
        ("b", 2, 4, None),
        ("c", 3, 4, None),
        ("a", 4, 4, 1),
        ("a", 5, 5, 4),
    ]
    assert task.total == task.number == 5


def test_trials_voided_at_the_screen_come_again_and_the_screen_then_once_more():
    task = Letters(2)
    run(task.block("ab"), {})
    shown = []

    def screen():
        shown.append((task.number, task.total))
        return Instruct(text="over")

    steps = run(task.close(screen), {1: (1, 2)})
    assert [type(step) for step in steps] == [EndBlock, EndTrial, EndTrial, EndBlock]
    assert told(steps) == [("a", 3, 4, 1), ("b", 4, 4, 2)]
    assert shown == [(2, 2), (4, 4)]


def test_the_number_of_the_last_trial_is_the_total_whatever_was_voided():
    """As the session tells them: the operator's display and the break screens count by these."""
    for voids in ({}, {2: (1,)}, {1: (1,), 2: (2,), 3: (1,)}):
        task = Letters(2)
        steps = run(task.block("ab"), voids)
        assert told(steps)[-1][1:3] == (task.total, task.total)
