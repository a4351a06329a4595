"""A laboratory's own simulated people: used by name, and their faults told in a sentence."""

from types import MappingProxyType, SimpleNamespace

import pytest

from slipscale import commands
from slipscale.experiments.participants.simulated_people import own_behaviour, population
from slipscale.experiments.participants.simulated_people.bare_run import bare_run
from slipscale.experiments.participants.simulated_people.own_behaviour import Behaviour
from slipscale.experiments.participants.simulated_people.population import (
    Population,
    read_population,
)
from slipscale.experiments.running.pilot import pilot_plans
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.steps import Ask, Explore
from slipscale.faults import UserError


class Modest(Behaviour):
    """Gives half of what it feels, and takes its time."""

    population = MappingProxyType({"trial_to_trial": 0.1})

    def estimate(self):
        return self.person.estimate() / 2

    def duration_s(self, step, usual_s):
        return usual_s + 10 if isinstance(step, Explore) else usual_s


class Faulty(Behaviour):
    """Cannot say what it feels."""

    def estimate(self):
        raise ZeroDivisionError("nothing felt")


class Wordy(Behaviour):
    """Says it in words."""

    def estimate(self):
        return "a lot"


class Instant(Behaviour):
    """Is done before it began."""

    def duration_s(self, _step, _usual_s):
        return -1.0


class Careless(Behaviour):
    """Forgets whom it changes."""

    def __init__(self, _person):
        pass


class Misnumbered(Behaviour):
    """Has a number that no population has."""

    population = MappingProxyType({"trial_to_tral": 0.1})


class Point:
    """An entry point of a package that is called ourlab."""

    module = __name__
    dist = SimpleNamespace(name="ourlab")

    def __init__(self, name, kind):
        self.name, self.kind = name, kind

    def load(self):
        return self.kind


@pytest.fixture(autouse=True)
def installed(monkeypatch):
    """Have a package installed that brings these people."""
    kinds = {
        "modest": Modest,
        "faulty": Faulty,
        "wordy": Wordy,
        "instant": Instant,
        "careless": Careless,
        "misnumbered": Misnumbered,
        "nobody": dict,
    }
    points = {name: Point(name, kind) for name, kind in kinds.items()}
    monkeypatch.setattr(own_behaviour, "installed", lambda _: points)
    return points


def run(people):
    """The steps and answers of a short run of magnitude estimation by these people."""
    (plan, *_) = pilot_plans("biet2007", participants=1, seed=None, language=None)
    return [(done.step, done.answer) for done in bare_run(plan, people)]


def estimates(people):
    return [
        answer.value
        for step, answer in run(people)
        if isinstance(step, Ask)
        and step.trial
        and isinstance(step.question, NumberQuestion)
        and isinstance(answer, Reply)
    ]


def test_a_packages_people_answer_as_their_class_says():
    own = read_population("modest")
    usual = own.model_copy(update={"behaviour": ""})
    assert own.name == own.behaviour == "modest"
    assert own.trial_to_trial == 0.1
    expected = [value / 2 for value in estimates(usual)]
    assert expected
    assert estimates(own) == expected


def test_they_take_as_long_as_their_class_says():
    def stroked_s(people):
        return [a.response_time_s for step, a in run(people) if isinstance(step, Explore)]

    own = read_population("modest")
    usual = own.model_copy(update={"behaviour": ""})
    assert stroked_s(own) == pytest.approx([each + 10 for each in stroked_s(usual)])


def test_a_population_file_may_name_them_with_numbers_of_its_own(tmp_path):
    file = tmp_path / "ours.toml"
    file.write_text('name = "ours"\nbehaviour = "modest"\nshared = 0.2\n')
    assert (read_population(str(file)).shared, read_population(str(file)).behaviour) == (
        (0.2, "modest")
    )
    file.write_text('behaviour = "shy"\n')
    with pytest.raises(UserError, match="'shy': no installed package provides it; expec"):
        read_population(str(file))


def test_a_population_without_them_is_written_as_it_always_was():
    assert "behaviour" not in Population().model_dump_json()
    people = read_population("modest")
    assert Population.model_validate_json(people.model_dump_json()) == people


@pytest.mark.parametrize(
    "name, said",
    [
        ("faulty", r"raised ZeroDivisionError: nothing felt \(module .*test_behaviour, line"),
        ("wordy", "answered 'a lot' to 'estimate', expected a number of 0 or more"),
        ("instant", "the duration of a step is -1.0; expected a number of seconds"),
        ("careless", "raised KeyError: 'person'"),
        ("misnumbered", "its population is invalid: trial_to_tral: unknown key"),
        ("nobody", "expected a class derived from Behaviour"),
    ],
)
def test_what_is_wrong_with_them_is_one_sentence_that_names_the_package(name, said):
    with pytest.raises(UserError, match=f"'{name}' of the package ourlab.*{said}"):
        estimates(read_population(name))


def test_the_name_of_a_shipped_population_is_refused(installed):
    installed["realistic"] = Point("realistic", Modest)
    with pytest.raises(UserError, match="'realistic' is a shipped population; expected a diff"):
        read_population("realistic")
    assert set(population.POPULATIONS) == {"biet2007", "realistic"}


def test_a_name_that_is_not_there_is_told_with_those_that_are():
    with pytest.raises(UserError, match=r"biet2007, realistic, .*modest"):
        read_population("nowhere")


def test_power_does_not_pretend_to_simulate_their_code(capsys):
    assert commands.main(["power", "--population", "modest", "--participants", "4"]) == 2
    assert "not the code of 'modest'" in capsys.readouterr().err
