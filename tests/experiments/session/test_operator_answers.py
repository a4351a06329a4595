"""Numbers that the participant says and the operator types: a whole session, kills, refusals."""

import csv
from types import SimpleNamespace

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.participants.simulated_people.in_session import SimulatedParticipant
from slipscale.experiments.session.operator import Request, UnattendedOperator
from slipscale.experiments.session.operator_answers import OperatorAnswers, _Given
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.steps import Ask
from slipscale.experiments.study.file import parse_study, study_text
from slipscale.faults import UserError
from tests.support.scripted import ScriptedParticipant

SPOKEN = study_text("biet2007") + '\n[keys]\nnumbers = "spoken"\n'


DECISION = ChoiceQuestion(prompt="Failed", options=(("again", "test again"), ("on", "go on")))


class Aloud(ScriptedParticipant):
    """Answers by keys, but for what the operator types: then only time passes."""

    def perform(self, step, watch):
        if isinstance(step, Ask) and step.by == "operator":
            for _ in range(100):
                self._clock.sleep(0.5)
                watch()
            raise AssertionError("nobody typed the answer")
        return super().perform(step, watch)


class Typist(UnattendedOperator):
    """Types each answer that is theirs, wrong ones first where there are some."""

    def __init__(self, *wrong, first=()):
        super().__init__()
        self.first = list(first)
        self.wrong = wrong
        self.typing = []
        self.asked = None
        self.messages = []

    def tell(self, status):
        super().tell(status)
        self.messages.append(status.message)
        if status.answering is not None and status.answering is not self.asked:
            self.typing = [*self.wrong, "42.5"]
        self.asked = status.answering

    def poll(self):
        if self.first:
            return Request(what="answer", reason=self.first.pop())
        if self.asked and self.typing:
            return Request(what="answer", reason=self.typing.pop(0))
        return super().poll()


def answer(step):
    return True if step.name == "difference_felt" else "less" if "report" in step.name else "man"


def rows(folder):
    (path,) = folder.glob("sub-01/beh/*magnitude*_beh.tsv")
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def aloud(laboratory):
    return lambda _: Aloud(answer, laboratory.clock)


def test_what_is_said_is_typed_by_the_operator_and_the_data_say_so(laboratory, plan):
    made = plan(SPOKEN)
    assert laboratory.run(made, person=aloud(laboratory), operator=Typist()) == "complete"
    build_dataset(laboratory.folder)
    for row in rows(laboratory.folder):
        assert (row["estimate"], row["response_time_source"]) == ("42.5", "operator")
        assert float(row["response_time"]) == 0.5
    steps = [record.data["what"] for record in laboratory.records(made, "begin")]
    by = {step["name"]: step["by"] for step in steps if step["type"] == "Ask"}
    assert by["estimate"] == by["scale_top"] == "operator"
    assert by["difference_felt"] == by["verbal_report"] == "participant"


def test_what_is_no_number_is_said_kept_and_typed_again(laboratory, plan):
    made, typist = plan(SPOKEN), Typist("1,000", "ten")
    laboratory.run(made, person=aloud(laboratory), operator=typist)
    build_dataset(laboratory.folder)
    assert {row["rejected_entries"] for row in rows(laboratory.folder)} == {"1,000; ten"}
    assert any("can be read in two ways" in message for message in typist.messages)


@pytest.mark.parametrize(
    "question, wrong, right, value",
    [
        (DECISION, ["12", "1 no wait 2", "not 1", "11"], "2", "on"),
        (DECISION, ["", "1,", "1\r2"], " 1 ", "again"),
        (YesNoQuestion(prompt="Felt?"), ["yn", "y?", "no"], "Y", True),
    ],
)
def test_a_decision_is_one_key_and_more_characters_are_refused(question, wrong, right, value):
    said = []
    answers = OperatorAnswers(SimpleNamespace(say=said.append), None)
    answers._question = Ask(name="decision", question=question, by="operator")
    for typed in wrong:
        answers.take(typed)
    assert answers._rejected == wrong
    assert len(said) == len(wrong)
    with pytest.raises(_Given) as given:
        answers.take(right)
    assert given.value.reply.value == value


def test_an_answer_that_nobody_waits_for_is_refused(laboratory, plan):
    typist = Typist(first=["5"])
    laboratory.run(plan(SPOKEN), person=aloud(laboratory), operator=typist)
    assert "no question is currently open" in typist.messages


def test_simulated_people_need_no_operator_and_say_what_they_would_type(laboratory, plan):
    laboratory.run(plan(SPOKEN))
    build_dataset(laboratory.folder)
    said = [row["estimate"] for row in rows(laboratory.folder)]
    laboratory.folder = laboratory.folder / "typed"
    laboratory.run(plan())
    build_dataset(laboratory.folder)
    assert said == [row["estimate"] for row in rows(laboratory.folder)]


@pytest.mark.parametrize("lines", range(190, 230, 7))
def test_a_session_killed_at_a_spoken_answer_goes_on_to_the_same_data(laboratory, plan, lines):
    made = plan(SPOKEN)
    laboratory.run(made, person=aloud(laboratory), operator=Typist())
    path = made.journal_path(laboratory.folder)
    whole = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(whole[:lines]))
    assert laboratory.run(made, person=aloud(laboratory), operator=Typist()) == "complete"
    build_dataset(laboratory.folder)
    assert {row["estimate"] for row in rows(laboratory.folder)} == {"42.5"}


def test_a_pause_while_the_participant_speaks_asks_again(laboratory, plan):
    class Pausing(Typist):
        paused = 0

        def poll(self):
            if self.asked and self.paused == 0:
                self.paused = 1
                return Request(what="pause")
            if self.paused == 1:
                self.paused = 2
                return Request(what="go_on")
            return super().poll()

    made = plan(SPOKEN)
    assert laboratory.run(made, person=aloud(laboratory), operator=Pausing()) == "complete"
    assert len(laboratory.records(made, "pause")) == 1


def test_how_numbers_are_given_is_one_of_two():
    with pytest.raises(UserError, match=r"keys\.numbers: .*'typed' or 'spoken', got 'sung'"):
        parse_study(SPOKEN.replace("spoken", "sung"), "mine.toml")


def test_the_simulated_participant_is_not_asked_by_hand(laboratory, plan):
    laboratory.run(plan(SPOKEN))
    assert isinstance(laboratory.person, SimulatedParticipant)
    sources = {
        record.data["answer"].get("time_source")
        for record in laboratory.records(plan(SPOKEN), "done")
        if record.data["answer"]
    }
    assert "operator" not in sources
