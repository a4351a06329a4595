"""What a laboratory's own protocol may get wrong: told in a sentence, before anybody sits down."""

from dataclasses import replace
from importlib.metadata import EntryPoint
from types import SimpleNamespace

import pytest

from slipscale.commands import main
from slipscale.experiments.protocol_parts import registry
from slipscale.experiments.protocol_parts.base import Options, Protocol
from slipscale.experiments.protocol_parts.registry import load_protocol
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
from slipscale.experiments.running.rehearsal import check_answered, surfaces
from slipscale.experiments.running.study_commands import validate
from slipscale.experiments.steps.columns import Column
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.steps import Ask, EndBlock, EndTrial, Explore, Instruct, Present
from slipscale.experiments.steps.trial import Trial
from slipscale.faults import RigError, UserError, plug_ins
from slipscale.stimuli.surface import VirtualSurface

STUDY = """
name = "outside"
title = "A protocol of our own"
amplitudes_um_pp = [0.5, 1.2]
participants = 1

[[tasks]]
protocol = "grip"
"""


class GripOptions(Options):
    """None of its own."""


def steps(_options, context, level=1.2, count=2):
    yield Instruct(text=context.texts["grip.instructions"])
    for number in range(1, count + 1):
        trial = Trial(task=context.task, number=number, total=2)
        yield Present(surface=VirtualSurface(level=level), trial=trial)
        yield Explore(text="Stroke it.", trial=trial)
        yield Ask(name="grip", question=NumberQuestion(prompt="How much grip?"), trial=trial)
        yield EndTrial(trial=trial)
    yield EndBlock(screen=Instruct(text="over"))


LARGE = 5


def repeating(_options, context):
    """Ask again until the answer is one that nobody gives."""
    trial = Trial(task=context.task, number=1, total=2)
    yield Present(surface=VirtualSurface(level=1.2), trial=trial)
    answer = None
    while answer is None or answer.value != -1:
        answer = yield Ask(name="grip", question=NumberQuestion(prompt="Grip?"), trial=trial)
    yield EndTrial(trial=trial)


def forever():
    while True:
        yield Instruct(text="Once more.")


def broken(*_):
    raise KeyError("lost")


GRIP = Protocol(
    task="grip",
    title="Grip",
    description="How much grip.",
    options=GripOptions,
    trials=lambda _options, _context: 2,
    steps=steps,
    answer="grip",
    instructions="grip.instructions",
    simulated={"grip": lambda _, person: round(person.impressions[-1])},
    texts={"en": {"grip.instructions": "Feel it."}, "fr": {"grip.instructions": "Touchez."}},
    response={
        "grip": Column(value=lambda r: r.answer("grip"), kind="number", description="Grip"),
    },
)


class Point:
    """An entry point of a package that is called ourlab."""

    module = __name__
    dist = SimpleNamespace(name="ourlab")

    def __init__(self, protocol):
        self.protocol = protocol

    def load(self):
        return self.protocol


@pytest.fixture
def pilot(monkeypatch, tmp_path):
    """Return a function that runs a pilot with a protocol of the name grip."""
    known = registry.installed(registry.PROTOCOLS)

    def run(protocol, text=STUDY, *, begun=False, **changes):
        points = {**known, "grip": Point(replace(protocol, **changes))}
        monkeypatch.setattr(registry, "installed", lambda _: points)
        file = tmp_path / f"outside{len(list(tmp_path.glob('*.toml')))}.toml"
        file.write_text(text, encoding="utf-8")
        plans = pilot_plans(str(file), participants=None, seed=None, language=None)
        folder = tmp_path / "data"
        try:
            run_pilot(folder, plans, tell=lambda _: None)
        except UserError:
            assert begun or not folder.exists() or not list(folder.rglob("*.jsonl"))
            raise
        return folder

    return run


def test_a_protocol_of_a_laboratorys_own_is_piloted(pilot):
    folder = pilot(GRIP)
    (table,) = folder.glob("sub-01/beh/*_task-grip_run-01_beh.tsv")
    assert len(table.read_text().splitlines()) == 3
    assert "Feel it." in (folder / "task-grip_beh.json").read_text()


def test_a_question_repeated_until_a_simulated_person_would_never_end_is_refused(pilot):
    """No rehearsal finds it: only simulated people answer so."""

    def until_even(_options, context):
        for number in (1, 2):
            trial = Trial(task=context.task, number=number, total=2)
            yield Present(surface=VirtualSurface(level=1.2), trial=trial)
            yield Explore(text="Stroke it.", trial=trial)
            question = Ask(name="grip", question=NumberQuestion(prompt="?"), trial=trial)
            while (yield question).value > LARGE:
                pass
            yield EndTrial(trial=trial)
        yield EndBlock(screen=Instruct(text="over"))

    with pytest.raises(UserError, match="trial 1: not finished after 1,000 steps"):
        pilot(GRIP, steps=until_even, simulated={"grip": lambda *_: 50.0}, begun=True)


def test_a_pilot_of_outside_tasks_alone_is_done_and_says_that_nothing_reads_them(
    pilot, tmp_path, monkeypatch, capsys
):
    pilot(GRIP)
    monkeypatch.chdir(tmp_path)
    assert main(["pilot", "outside0.toml", "--out", "again"]) == 0
    assert "The data were not analysed" in capsys.readouterr().out
    assert list((tmp_path / "again").glob("sub-01/beh/*_task-grip_run-01_beh.tsv"))


def test_validate_finds_a_protocol_that_never_ends(pilot, tmp_path):
    with pytest.raises(UserError, match="not finished"):
        pilot(GRIP, steps=repeating)
    (file,) = tmp_path.glob("outside0.toml")
    with pytest.raises(UserError, match="trial 1: not finished after 1,000 steps"):
        validate(str(file))


def test_a_study_may_replace_a_text_that_a_protocol_brings(pilot):
    text = STUDY.replace("[[tasks]]", '[texts.en.grip]\ninstructions = "Press."\n\n[[tasks]]')
    assert "Press." in (pilot(GRIP, text) / "task-grip_beh.json").read_text()
    with pytest.raises(UserError, match=r"grip\.instructoins: unknown text"):
        pilot(GRIP, text.replace("instructions", "instructoins"))


@pytest.mark.parametrize(
    "changes, said",
    [
        ({"simulated": {}}, "no simulated participant can answer 'grip'"),
        ({"texts": {"fr": GRIP.texts["fr"]}}, "has no texts in 'en', only in fr"),
        (
            {"instructions": "grip.intro"},
            "the protocol has no text for its instructions 'grip.intro'",
        ),
        (
            {"texts": {"en": {"session.rest": "Rest!", **GRIP.texts["en"]}}},
            "its en text 'session.rest' could replace another protocol's",
        ),
        (
            {"design": {"onset": GRIP.response["grip"]}},
            "column onset is in every task's table",
        ),
        (
            {"steps": lambda o, c: steps(o, c, count=3)},
            "continues after 2 trials, its declared maximum",
        ),
        (
            {"possible_levels": lambda _o, _c: (0.5, 1.0)},
            "presents 1.2 µm p-p, but declares 0.5 to 1",
        ),
        ({"possible_levels": lambda _o, _c: (0.5, 3.0)}, "3.0 is beyond the plate's 2.5 µm p-p"),
        (
            {"finest_level": lambda _o, _c: (0.04, 1.2)},
            "the plate's tolerance is 0.06 µm p-p at 1.2",
        ),
        ({"steps": lambda o, c: steps(o, c, level=2.6)}, "2.6 µm p-p is outside"),
        (
            {"steps": repeating},
            "trial 1: not finished after 1,000 steps",
        ),
        ({"steps": lambda *_: forever()}, "not finished after 10,000 steps"),
        (
            {
                "steps": lambda o, c: (
                    step for step in steps(o, c) if not isinstance(step, EndTrial)
                )
            },
            "its steps end without an EndTrial for trial 2, so its answers would be in no table",
        ),
        (
            {"trials": broken},
            r"trials raised KeyError: 'lost' \(module .*protocols, line",
        ),
        ({"trials": lambda *_: "two"}, "trials returned 'two', expected a whole number"),
        ({"steps": lambda *_: [1, 2]}, "its steps are of type list, expected a generator"),
        (
            {"steps": lambda *_: (each for each in ("Present",))},
            "its steps contain an object",
        ),
        ({"steps": broken}, "its steps raised KeyError"),
        ({"needs_position": broken}, "needs_position raised KeyError"),
        (
            {"possible_levels": lambda *_: (broken() for _ in "a")},
            "possible_levels raised KeyError",
        ),
    ],
)
def test_what_is_wrong_with_a_protocol_is_one_sentence_and_nothing_is_recorded(
    pilot, changes, said
):
    with pytest.raises((UserError, RigError), match=said):
        pilot(GRIP, **changes)


@pytest.mark.parametrize(
    "answer, said",
    [
        (broken, "to 'grip' raised KeyError"),
        (lambda *_: "much", "answered 'much' to 'grip', expected"),
        (lambda *_: [1.0, 2], r"answered \[1.0, 2\] to 'grip', expected"),
        (lambda *_: float("nan"), "answered nan to 'grip', expected"),
    ],
)
def test_a_simulated_answer_that_fails_is_a_sentence(pilot, answer, said):
    with pytest.raises(UserError, match=said):
        pilot(GRIP, simulated={"grip": answer}, begun=True)


@pytest.mark.parametrize("value", [broken, lambda _: object()], ids=["raises", "object"])
def test_a_column_that_fails_is_a_sentence_and_the_journal_stays(pilot, value, tmp_path):
    column = replace(GRIP.response["grip"], value=value)
    with pytest.raises(UserError, match=r"of the package ourlab: column 'grip' (raised|contains)"):
        pilot(GRIP, response={"grip": column}, begun=True)
    assert list((tmp_path / "data").rglob("*_journal.jsonl"))


def test_the_sentence_names_the_package(pilot):
    with pytest.raises(UserError, match="protocol 'grip' of the package ourlab: no simulated"):
        pilot(GRIP, simulated={})


def test_an_entry_point_that_is_no_protocol_is_refused(pilot, monkeypatch):
    monkeypatch.setattr(registry, "installed", lambda _: {"grip": Point(GripOptions)})
    with pytest.raises(UserError, match="expected a Protocol"):
        load_protocol("grip")


class Unregistered(NumberQuestion):
    """A kind of question that no package registers."""


def test_a_question_whose_kind_is_not_registered_is_refused_before_a_pilot(pilot):
    def asks(_options, context):
        trial = Trial(task=context.task, number=1, total=1)
        yield Present(surface=VirtualSurface(level=1.2), trial=trial)
        yield Ask(name="grip", question=Unregistered(prompt="Grip?"), trial=trial)
        yield EndTrial(trial=trial)

    said = "'grip' of the package ourlab: Unregistered is not an installed kind"
    with pytest.raises(UserError, match=said):
        pilot(GRIP, steps=asks)


@pytest.mark.parametrize(
    "method, found, said",
    [
        ("rehearsed", "much", r"rehearses the answer 'much'; expected a number"),
        ("rehearsed", [1.0], r"rehearses the answer \[1.0\]; expected a number"),
        ("movement_s", -1.0, "states a movement of -1.0 s; expected a number of seconds"),
    ],
)
def test_a_question_that_rejects_its_own_answer_is_refused_before_a_pilot(
    pilot, monkeypatch, method, found, said
):
    monkeypatch.setattr(NumberQuestion, method, lambda *_: found)
    with pytest.raises(UserError, match=r"'grip' \(NumberQuestion\) " + said):
        pilot(GRIP)


@pytest.mark.parametrize(
    "names, said",
    [
        (("ourlab.grip", "theirlab.grip"), r"both ourlab.* and theirlab.* provide 'grip' "),
        (("ourlab.my grip",), "the name 'my grip' in the group slipscale.protocols"),
        ((), "this installation of Slipscale is incomplete"),
    ],
)
def test_entry_points_that_are_ambiguous_misnamed_or_missing_are_refused(monkeypatch, names, said):
    places = [name.split(".") for name in names]
    points = [
        EntryPoint(name=name, value=f"{package}.grip:PROTOCOL", group="slipscale.protocols")
        for package, name in places
    ]
    monkeypatch.setattr(plug_ins, "entry_points", lambda **_: points)
    plug_ins.installed.cache_clear()
    try:
        with pytest.raises(UserError, match=said):
            plug_ins.installed("slipscale.protocols")
    finally:
        plug_ins.installed.cache_clear()


@pytest.mark.parametrize("study", ["difference_threshold", "matching"])
def test_a_shipped_study_rehearses_every_amplitude_that_its_pilot_presents(study, laboratory):
    plan = pilot_plans(study, participants=1, seed=None, language=None)[0]
    check_answered(plan)
    rehearsed = [surface.level for surface in surfaces(plan)]
    laboratory.run(plan)
    presented = [
        record.data["what"]["surface"]["level"]
        for record in laboratory.records(plan, kind="begin")
        if record.data["what"]["type"] == "Present"
    ]
    assert presented
    assert min(rehearsed) <= min(presented) <= max(presented) <= max(rehearsed)
