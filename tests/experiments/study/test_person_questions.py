"""Questions about the participant: codes for the data, words for the reader, bounds for numbers."""

import json

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.session.operator import Request, UnattendedOperator
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.questions.whole_number import WholeNumberQuestion
from slipscale.experiments.steps.steps import Ask, Instruct
from slipscale.experiments.study.file import parse_study
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError
from tests.support.scripted import ScriptedParticipant

STUDY = """name = "mine"
title = "Mine"
amplitudes_um_pp = [0.0, 1.2]
{more}
[[tasks]]
protocol = "magnitude_estimation"
practice = 0
{asked}
"""
HAND = """[[about_you]]
name = "handedness"
[about_you.options]
left = {en = "left", fr = "gauche"}
right = {en = "right", fr = "droite"}
"""
AGE = """[[about_you]]
name = "age_years"
minimum = 18
maximum = 99
"""


def plan(asked="", more="", language="fr"):
    return RunPlan(
        study_name="mine",
        study_text=STUDY.format(asked=asked, more=more),
        participant="01",
        seed=1,
        language=language,
        mode="pilot",
    )


def test_the_participant_reads_their_language_and_the_data_hold_the_code():
    for language, words in (("fr", ("gauche", "droite")), ("en", ("left", "right"))):
        (ask,) = plan(HAND, language=language).person_questions()
        assert ask.question.options == tuple(zip(("left", "right"), words, strict=True))


def test_the_shipped_study_has_nothing_english_in_french_but_the_codes(plan_of_shipped):
    english, french = plan_of_shipped("en"), plan_of_shipped("fr")
    for one, other in zip(english.person_questions(), french.person_questions(), strict=True):
        codes = [code for code, _ in one.question.options]
        assert codes == [code for code, _ in other.question.options]
        words = [
            (a[1], b[1]) for a, b in zip(one.question.options, other.question.options, strict=True)
        ]
        assert all(a != b for a, b in words)


@pytest.fixture
def plan_of_shipped():
    from slipscale.experiments.study.file import study_text

    return lambda language: RunPlan(
        study_name="biet2007",
        study_text=study_text("biet2007"),
        participant="01",
        seed=1,
        language=language,
        mode="pilot",
    )


def test_a_list_of_options_as_older_studies_have_it_stays_valid():
    (ask,) = plan('[[about_you]]\nname = "sex"\noptions = ["m", "f"]\n').person_questions()
    assert ask.question.options == (("m", "m"), ("f", "f"))


def test_words_that_are_missing_in_the_language_of_a_run_are_told_not_replaced():
    own = HAND.replace(', fr = "gauche"', "").replace(', fr = "droite"', "")
    with pytest.raises(UserError, match="'handedness' has no words for its options in 'fr'"):
        plan(own, language="fr").person_questions()


@pytest.mark.parametrize(
    "asked, told",
    [
        (HAND.replace("fr =", "xx ="), "expected languages among en, fr"),
        (HAND.replace('left = {en = "left", ', "left = {"), "in the same languages"),
        (HAND.replace('"droite"', '"gauche"'), "different options"),
        (HAND.replace('en = "left", ', "").replace(
            'en = "right", ', ""), "has no words for its options in 'en'"),
        (AGE + 'options = ["1", "2"]\n', "either options, or minimum and maximum"),
        ('[[about_you]]\nname = "sex"\n', "either options, or minimum and maximum"),
        (AGE.replace("maximum = 99\n", ""), "both minimum and maximum"),
        (AGE.replace("99", "18"), "a minimum below the maximum"),
        (AGE.replace("18", "-1"), "minimum"),
        (AGE.replace("99", "99.5"), "maximum"),
        (AGE.replace("age_years", "informed_consent"), "another name"),
        (AGE.replace("age_years", "shoe_size"), "needs its own prompt"),
        (AGE + 'prompt = {fr = "Quel âge ?"}\n', "no prompt in 'en'"),
        (AGE + 'prompt = {xx = "?"}\n', "expected languages among en, fr"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_question_is_told_with_its_place(asked, told):
    with pytest.raises(UserError, match=told) as fault:
        parse_study(STUDY.format(asked=asked, more=""), "mine.toml")
    assert "about_you" in str(fault.value)


def test_an_age_in_years_is_typed_within_its_bounds():
    (ask,) = plan(AGE).person_questions()
    assert (ask.question.minimum, ask.question.maximum) == (18, 99)
    assert ask.question.prompt == "Quel est votre âge, en années ?"


def answer(step):
    question = step.question
    if isinstance(question, ChoiceQuestion):
        return question.options[0][0]
    return 34.0 if isinstance(question, WholeNumberQuestion) else 42.0


def test_the_table_of_participants_says_what_each_code_means(laboratory):
    agreed = plan(AGE + HAND, 'informed_consent = true\nlanguage = "fr"', language="en")
    laboratory.run(agreed, person=lambda _: ScriptedParticipant(answer, laboratory.clock))
    build_dataset(laboratory.folder)
    described = json.loads((laboratory.folder / "participants.json").read_text(encoding="utf-8"))
    assert described["handedness"]["Levels"] == {"left": "gauche", "right": "droite"}
    assert described["informed_consent"]["Levels"]["yes"] == "agreed to take part"
    assert "Levels" not in described["age_years"]


def test_words_that_are_their_own_codes_are_levels_too():
    study = parse_study(
        STUDY.format(
            asked='[[about_you]]\nname = "sex"\noptions = ["m", "f"]\nprompt = "?"\n', more=""
        ),
        "mine.toml",
    )
    assert study.about_you[0].levels("en") == {"m": "m", "f": "f"}


def test_age_and_consent_stand_in_the_table_of_participants(laboratory):
    agreed = plan(AGE + HAND, "informed_consent = true")
    laboratory.run(agreed, person=lambda _: ScriptedParticipant(answer, laboratory.clock))
    build_dataset(laboratory.folder)
    header, row = (laboratory.folder / "participants.tsv").read_text().splitlines()
    told = dict(zip(header.split("\t"), row.split("\t"), strict=True))
    assert (told["informed_consent"], told["age_years"], told["handedness"]) == (
        "yes",
        "34",
        "left",
    )


def test_a_simulated_participant_agrees_and_has_an_age_within_the_bounds(laboratory):
    agreed = plan(AGE, "informed_consent = true")
    assert laboratory.run(agreed) == "complete"
    build_dataset(laboratory.folder)
    header, row = (laboratory.folder / "participants.tsv").read_text().splitlines()
    told = dict(zip(header.split("\t"), row.split("\t"), strict=True))
    assert told["informed_consent"] == "yes"
    assert 18 <= int(told["age_years"]) <= 99


def test_without_consent_nothing_goes_on_and_the_refusal_is_in_the_journal(laboratory):
    refused = plan(AGE, "informed_consent = true")

    class Stops(UnattendedOperator):
        def poll(self):
            refusals = laboratory.records(refused, kind="done")
            said = [r for r in refusals if (r.data["answer"] or {}).get("value") == "no"]
            return Request(what="stop", reason="no consent") if len(said) == 2 else None

    script = lambda _: ScriptedParticipant(lambda _step: "no", laboratory.clock)  # noqa: E731
    assert laboratory.run(refused, person=script, operator=Stops()) == "stopped"
    seen = laboratory.person.seen
    assert {step.name for step in seen if isinstance(step, Ask)} == {"informed_consent"}
    assert "Sans votre accord" in [s.text for s in seen if isinstance(s, Instruct)][2]
    assert laboratory.records(refused, kind="stop")[0].data["reason"].endswith("no consent")
