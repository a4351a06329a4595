"""Questionnaires: items with shared answers, a table of their own, both languages."""

import csv
import json

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.verification import verify
from slipscale.experiments.dataset.withdrawal import withdraw
from slipscale.experiments.running.lab_session import Setting, go_on
from slipscale.experiments.running.rehearsal import WAYS, dry_run
from slipscale.experiments.session.operator import Request, UnattendedOperator
from slipscale.experiments.steps.questions.base import CONSENT
from slipscale.experiments.steps.steps import Ask, Instruct
from slipscale.experiments.study.file import parse_study
from slipscale.faults import UserError
from tests.support.scripted import ScriptedParticipant

STUDY = """name = "mine"
title = "Mine"
language = "fr"
amplitudes_um_pp = [0.0, 1.2]
{more}
[[tasks]]
protocol = "magnitude_estimation"
practice = 0
repetitions = 1

[[questionnaires]]
name = "likert"
description = "Twenty made-up items"
title = {{ en = "You", fr = "Vous" }}
instructions = {{ en = "How much do you agree?", fr = "Êtes-vous d'accord ?" }}
{items}

[questionnaires.options]
"1" = {{ en = "not at all", fr = "pas du tout" }}
"2" = {{ en = "so so", fr = "moyennement" }}
"3" = {{ en = "fully", fr = "tout à fait" }}
"""
ITEM = '{{ name = "q{0:02d}", prompt = {{ en = "Item {0}", fr = "Énoncé {0}" }} }}'
AFTER = """
[[questionnaires]]
name = "effort"
description = "Made up"
when = "after"
options = ["easy", "hard"]
items = [{ name = "e1", prompt = "?", options = ["1", "2", "3"] }, { name = "e2", prompt = "?" }]
"""


def text_of(count=20, more=""):
    items = ", ".join(ITEM.format(number) for number in range(1, count + 1))
    return STUDY.format(items=f"items = [{items}]", more=more) + AFTER


def table(folder, name):
    with (folder / "phenotype" / f"{name}.tsv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def test_items_are_asked_in_order_before_and_after_the_tasks(plan, laboratory):
    made = plan(text_of(), language="fr")
    laboratory.run(made)
    steps = [record.data["what"] for record in laboratory.records(made, "begin")]
    names = [step.get("name") or step["type"] for step in steps]
    asked = [f"q{number:02d}" for number in range(1, 21)]
    assert names[: names.index("q20") + 1] == ["Instruct", "Instruct", *asked]
    assert names[-3:] == ["e1", "e2", "Instruct"]
    assert (steps[1]["title"], steps[1]["text"]) == ("Vous", "Êtes-vous d'accord ?")
    first = steps[names.index("q01")]["question"]
    assert first["prompt"] == "Énoncé 1"
    assert first["options"][0] == ["1", "pas du tout"]


def test_each_questionnaire_has_a_table_with_the_codes_of_its_items(plan, laboratory):
    for participant in ("01", "02"):
        laboratory.run(plan(text_of(), language="fr", participant=participant))
    folder = laboratory.folder
    assert build_dataset(folder) == []
    rows = table(folder, "likert")
    assert list(rows[0]) == ["participant_id", *(f"q{n:02d}" for n in range(1, 21))]
    assert [row["participant_id"] for row in rows] == ["sub-01", "sub-02"]
    assert {row[f"q{n:02d}"] for row in rows for n in range(1, 21)} == {"1", "2", "3"}
    about = json.loads((folder / "phenotype" / "likert.json").read_text())
    assert about["MeasurementToolMetadata"]["Description"] == "Twenty made-up items"
    assert about["q20"]["Description"] == "Item: Énoncé 20"
    assert about["q20"]["Levels"]["3"] == "tout à fait"
    assert json.loads((folder / "phenotype" / "effort.json").read_text())["e1"]["Levels"] == {
        "1": "1", "2": "2", "3": "3"
    }  # fmt: skip
    assert "q01" not in (folder / "participants.tsv").read_text()
    assert verify(folder) == []


def test_a_table_that_was_changed_by_hand_is_told(plan, laboratory):
    laboratory.run(plan(text_of(2), language="fr"))
    build_dataset(laboratory.folder)
    path = laboratory.folder / "phenotype" / "likert.tsv"
    path.write_text(path.read_text().replace("sub-01", "sub-07"))
    (problem,) = verify(laboratory.folder)
    assert problem.file == "phenotype/likert.tsv"


def test_visits_are_told_apart_where_there_are_several(plan, laboratory):
    study = text_of(1, more='sessions = ["a", "b"]\nruns = 2')
    for session, run in (("a", "01"), ("a", "02"), ("b", "01")):
        laboratory.run(plan(study, language="en", session=session, run=run))
    build_dataset(laboratory.folder)
    rows = [list(row.values())[:3] for row in table(laboratory.folder, "likert")]
    assert rows == [["sub-01", "ses-a", "01"], ["sub-01", "ses-a", "02"], ["sub-01", "ses-b", "01"]]


def test_an_interrupted_questionnaire_has_a_row_with_what_was_answered(plan, laboratory):
    made = plan(text_of(3), language="en")
    path = made.journal_path(laboratory.folder)
    laboratory.run(made)
    lines = path.read_bytes().splitlines(keepends=True)
    cut = next(n for n, line in enumerate(lines) if b'"name":"q03"' in line.replace(b": ", b":"))
    path.write_bytes(b"".join(lines[:cut]))
    build_dataset(laboratory.folder)
    (row,) = table(laboratory.folder, "likert")
    assert row["q02"] in {"1", "2", "3"}
    assert row["q03"] == "n/a"


def test_who_withdraws_is_in_no_table_of_a_questionnaire_any_more(plan, laboratory):
    for participant, study in (("01", text_of(2)), ("02", text_of(2).replace(AFTER, ""))):
        laboratory.run(plan(study, language="en", participant=participant))
    folder = laboratory.folder
    build_dataset(folder)
    own = folder / "phenotype" / "own.tsv"
    own.write_text("participant_id\nsub-02\n")
    withdraw(folder, "01")
    assert [row["participant_id"] for row in table(folder, "likert")] == ["sub-02"]
    assert not (folder / "phenotype" / "effort.tsv").exists()
    assert own.exists()


def test_an_item_is_asked_again_where_the_operator_wants(plan, laboratory):
    made = plan(text_of(2), language="en")

    class Again(UnattendedOperator):
        def tell(self, status):
            super().tell(status)
            self.asked = status.asked

        def poll(self):
            named = [ask for ask in getattr(self, "asked", ()) if ask.name == "q01"]
            if named and not getattr(self, "done", False):
                self.done = True
                return Request(what="ask_again", question=named[0])
            return super().poll()

    answers = iter(["1", "2"])

    def answer(step):
        return next(answers) if step.name == "q01" else 30.0 if step.trial else "2"

    def person(_):
        return ScriptedParticipant(
            lambda step: step.question.options[0][0] if step.name.startswith("e") and not step.trial
            else answer(step), laboratory.clock,
        )  # fmt: skip

    laboratory.run(made, person=person, operator=Again())
    build_dataset(laboratory.folder)
    assert table(laboratory.folder, "likert")[0]["q01"] == "2"


@pytest.mark.parametrize(
    "change, told",
    [
        (
            ('name = "likert"', 'name = "two words"'),
            "name of item 1 of questionnaires: expected letters",
        ),
        (
            ('name = "likert"', 'name = "magnitudeestimation"'),
            "there is already a 'magnitudeestimation'",
        ),
        (
            ('name = "effort"', 'name = "likert"'),
            "name of item 2 of questionnaires: there is already a 'likert'",
        ),
        (
            ('name = "q02"', 'name = "q01"'),
            "name of item 2 of items of item 1 of questionnaires: there is already a 'q01'",
        ),
        (
            ('name = "e1"', 'name = "q01"'),
            "name of item 1 of items of item 2 of questionnaires: there is already a 'q01'",
        ),
        (('name = "q02"', 'name = "session_id"'), "expected another code"),
        ((', fr = "tout à fait"', ""), "words for every code in the same languages"),
        (
            (', fr = "Énoncé 2"', ""),
            "prompt of item 2 of items of item 1 of questionnaires: 'q02' has no prompt in 'fr'",
        ),
        ((', fr = "Vous"', ""), "title of item 1 of questionnaires: expected words in 'fr'"),
        (
            ('en = "You"', 'tlh = "You"'),
            "title of item 1 of questionnaires: expected languages among en, fr",
        ),
        (('fr = "tout à fait"', 'fr = "moyennement"'), "expected different options"),
        (
            ('options = ["easy", "hard"]', 'options = ["easy"]'),
            "mine.toml: line 27, options of item 2 of questionnaires: expected at least 2 items",
        ),
        (('when = "after"', 'when = "between"'), "'before' or 'after'"),
        (('description = "Made up"', ""), "description of item 2 of questionnaires: is missing"),
    ],
)
def test_what_is_wrong_with_a_questionnaire_is_told_with_its_place(change, told):
    text = text_of(2)
    assert change[0] in text
    with pytest.raises(UserError) as fault:
        parse_study(text.replace(*change, 1), "mine.toml")
    assert told in str(fault.value)
    assert "questionnaires" in str(fault.value)


def test_shared_answers_without_words_are_told_once():
    text = text_of(20)
    for words in (', fr = "pas du tout"', ', fr = "moyennement"', ', fr = "tout à fait"'):
        text = text.replace(words, "")
    with pytest.raises(UserError) as fault:
        parse_study(text, "mine.toml")
    assert str(fault.value).count("has no words for its options in 'fr'") == 1


def test_words_that_are_missing_in_the_language_of_a_run_are_told_before_it(plan):
    own = text_of(2).replace(', fr = "Vous"', "").replace('"fr"', '"en"')
    with pytest.raises(UserError, match="'likert' lacks a title or instructions in 'fr'"):
        plan(own, language="fr").person_questions()


@pytest.mark.parametrize("language", ["en", "fr"])
def test_consent_comes_first_and_is_told_in_the_data_with_its_words(plan, laboratory, language):
    made = plan(text_of(1, more="informed_consent = true"), language=language)
    shown = []
    for step in made.steps():
        shown.append(step)
        if isinstance(step, Ask):
            break
    assert [type(step) for step in shown] == [Instruct, Instruct, Ask]
    laboratory.run(made)
    build_dataset(laboratory.folder)
    column = json.loads((laboratory.folder / "participants.json").read_text())[CONSENT]
    texts = made.texts()
    assert texts["session.consent"].strip() in column["Description"]
    assert texts["session.consent_question"] in column["Description"]


def test_who_takes_consent_back_ends_the_run_for_good(plan, laboratory):
    made = plan(text_of(1, more="informed_consent = true"), language="en", mode="participant")

    class Again(UnattendedOperator):
        told = None

        def tell(self, status):
            super().tell(status)
            self.told = status

        def poll(self):
            consent = [ask for ask in (self.told.asked if self.told else ()) if ask.name == CONSENT]
            if consent and self.told.trial == 2:
                return Request(what="ask_again", question=consent[0])
            return super().poll()

    given = iter(["yes", "no"])

    def answer(step):
        if step.name == CONSENT:
            return next(given)
        return 30.0 if step.trial else step.question.options[0][0]

    outcome = laboratory.run(
        made, person=lambda _: ScriptedParticipant(answer, laboratory.clock), operator=Again()
    )
    assert outcome == "stopped"
    assert "withdrew consent" in laboratory.records(made, "stop")[0].data["reason"]
    build_dataset(laboratory.folder)
    assert "\tno\t" in (laboratory.folder / "participants.tsv").read_text()
    with pytest.raises(UserError, match=r"withdrew consent.*slipscale data withdraw"):
        go_on(made.journal_path(laboratory.folder), Setting(plate="serial:/dev/null"))


def test_a_pilot_has_questionnaires_and_headphone_test_too(plan):
    """The dry run goes every way through a study before a pilot begins; some fail the test."""
    made = plan(text_of(3, more="informed_consent = true") + "\n[headphone_test]\n", language="en")
    for way in WAYS.values():
        names = [getattr(step, "name", "") for step in dry_run(made, way)]
        assert {"q01", "e2", "tones_1", "tones_6"} <= set(names)
    assert any(getattr(step, "name", "") == "decision" for step in dry_run(made))
