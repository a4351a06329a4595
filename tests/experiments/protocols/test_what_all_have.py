"""Every task of intervals has practice, catch trials, rests and limits, in each language."""

import pytest

from slipscale.experiments.languages.texts import languages
from slipscale.experiments.running.rehearsal import dry_run
from slipscale.experiments.steps.steps import Adjust, Ask, Explore, Feedback, Instruct, Rest
from slipscale.experiments.study.file import study_text
from slipscale.experiments.study.run_plan import RunPlan

STUDIES = (
    *("difference_threshold", "detection_threshold", "constant_stimuli"),
    *("paired_comparison", "matching"),
)


@pytest.fixture(params=STUDIES, scope="module")
def steps(request):
    """The steps of a shipped study in each language, with a limit for every answer."""
    text = study_text(request.param)
    if "response_time_limit_s" not in text:
        text = text.replace("[[tasks]]\n", "[[tasks]]\nresponse_time_limit_s = 30.0\n")
    return {
        language: list(
            dry_run(
                RunPlan(
                    study_name=request.param,
                    study_text=text,
                    participant="01",
                    seed=1,
                    language=language,
                    mode="pilot",
                )
            )
        )
        for language in languages()
    }


def trials(steps):
    return {step.trial.number: step.trial for step in steps["en"] if step.trial}


def test_practice_comes_first_and_is_marked(steps):
    phases = [trial.phase for _, trial in sorted(trials(steps).items())]
    assert phases == sorted(phases, key=["practice", "main"].index)
    assert set(phases) == {"practice", "main"}


def test_catch_trials_are_among_the_others(steps):
    def caught(trial):
        return trial.factors.get("catch") is True or trial.factors.get("direction") == "equal"

    main = [caught(trial) for _, trial in sorted(trials(steps).items()) if trial.phase == "main"]
    assert 0 < sum(main) < len(main)


def test_there_are_rests_with_the_progress(steps):
    rests = [step for step in steps["en"] if isinstance(step, Rest)]
    assert rests
    assert all(0 < rest.done < rest.total for rest in rests)


def test_stroking_and_answering_have_limits(steps):
    of_trials = [step for step in steps["en"] if step.trial]
    assert all(step.maximum_s for step in of_trials if isinstance(step, Explore))
    answered = [step for step in of_trials if isinstance(step, Ask | Adjust)]
    assert answered
    assert all(step.time_limit_s for step in answered)


def test_every_screen_has_words_of_its_own_in_each_language(steps):
    def words(language):
        return {
            step.question.prompt if isinstance(step, Ask) else step.text
            for step in steps[language]
            if isinstance(step, Instruct | Explore | Ask | Adjust | Feedback | Rest)
        }

    assert words("en")
    assert not words("en") & words("fr")
