import json
from dataclasses import replace

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.further_tables.person_columns import person_columns
from slipscale.experiments.dataset.rows_from_journal import EVENT_FLAGS
from slipscale.experiments.dataset.schema import (
    FLAGS,
    NOTES,
    PARTICIPANT,
    TABLE_NAME,
    columns,
    table_stem,
)
from slipscale.experiments.protocol_parts.base import Options
from slipscale.experiments.protocol_parts.registry import load_protocol, protocol_names
from slipscale.experiments.running.rehearsal import dry_run
from slipscale.experiments.steps.columns import Column
from slipscale.experiments.steps.steps import Adjust, Ask
from slipscale.experiments.study.file import study_text
from slipscale.experiments.study.person_questions import TAKEN
from slipscale.faults import UserError
from slipscale.stimuli.quantity import PLATE_AMPLITUDE
from tools.campaigns.torture.pilots import EVERY_OPTION

# The shipped study that has a protocol, where its name is another.
STUDIES = {"descending_difference": "biet2007", "magnitude_estimation": "biet2007"}
# Those that no shipped study has.
ONLY_THERE = ("category_scale", "identification", "limits", "oddity", "same_different")
STUDIES["pointing"] = "pointing2023"
STUDIES |= dict.fromkeys((*ONLY_THERE, "similarity", "sorting"), str(EVERY_OPTION))


def task_of(made, name):
    return next(task.task for task, options in made.tasks() if options.protocol == name)


@pytest.mark.parametrize("name", protocol_names())
def test_every_question_of_a_protocol_is_a_column_of_its_table(name, plan):
    study = STUDIES.get(name, name)
    made = plan(study_text(study), session="a" if study == str(EVERY_OPTION) else "")
    protocol, task = load_protocol(name), task_of(made, name)
    asked = {
        step.name
        for step in dry_run(made)
        if isinstance(step, Ask | Adjust)
        and task in (getattr(step, "task", ""), step.trial and step.trial.task)
    }
    assert asked <= set(protocol.response)
    assert protocol.answer in asked


@pytest.mark.parametrize("name", protocol_names())
def test_every_own_column_is_in_the_table_once_and_in_its_place(name):
    protocol = load_protocol(name)
    names = list(columns(protocol))
    assert len(set(names)) == len(names)
    at = names.index
    assert names[1 : at("phase")] == [PLATE_AMPLITUDE.named(name) for name in protocol.design]
    assert names[at("surface") + 1 : at("amplitude_um_pp")] == [
        PLATE_AMPLITUDE.named(name) for name in protocol.stimulus
    ]
    assert names[at("amplitude_readback_um_pp") + 1 : at("response_time")] == [
        PLATE_AMPLITUDE.named(name) for name in protocol.response
    ]


def own(name, **changes):
    return replace(load_protocol(name), **changes)


COLUMN = Column(value=lambda _: None, kind="label", description="")


@pytest.mark.parametrize(
    "changes, expected",
    [
        ({"task": "magnitude_estimation"}, "letters and digits"),
        ({"answer": "rating"}, "the answer 'rating' must be one of the response columns"),
        ({"stimulus": {}}, "'texture' must name the presented texture"),
        ({"design": {"estimate": COLUMN}}, "must be declared once"),
        ({"amplitudes": ()}, "ends in _level"),
    ],
)
def test_a_protocol_that_contradicts_itself_is_refused(changes, expected):
    with pytest.raises(UserError, match=expected):
        own("magnitude_estimation", **changes)


def test_a_protocol_may_not_take_a_column_that_every_task_has():
    protocol = own("magnitude_estimation", design={"onset": COLUMN})
    with pytest.raises(UserError, match="'magnitudeestimation': column onset"):
        columns(protocol)


class Tilted(Options):
    tilt_level: float = 3.0


def test_the_amplitudes_of_a_laboratorys_own_protocol_are_checked_too(monkeypatch, plan):
    # Neither shipped protocol has this option: the check must go by what is declared.
    tilted = own("descending_difference", options=Tilted, amplitudes=("tilt_level",))
    one_trial = replace(tilted, trials=lambda *_: 1)
    for module in ("checks_across_keys", "key_validators", "model", "file"):
        where = f"slipscale.experiments.study.{module}"
        monkeypatch.setattr(f"{where}.load_protocol", lambda _: one_trial)
        monkeypatch.setattr(f"{where}.protocol_names", lambda: ["tilted"], raising=False)
    text = 'name = "a"\ntitle = "a"\namplitudes_um_pp = [1.0]\n[[tasks]]\nprotocol = "tilted"\n'
    with pytest.raises(
        UserError, match=r"tilt_um_pp of item 1 of tasks: 3.0 is beyond the plate's"
    ):
        plan(text + "tilt_um_pp = 3.0").study  # noqa: B018 - parsed when it is looked at


def test_a_table_is_found_by_the_name_it_is_written_under():
    stem = table_stem(participant="01", session="02", task="magnitudeestimation", run="3")
    found = TABLE_NAME.fullmatch(f"{stem}.tsv")
    assert found.group("sub", "ses", "task", "run") == ("01", "02", "magnitudeestimation", "3")


def test_every_flag_that_an_event_leaves_is_explained():
    assert set(EVENT_FLAGS.values()) < set(FLAGS)


def test_the_columns_of_participants_are_those_no_question_may_take():
    assert (PARTICIPANT, *person_columns()) == TAKEN


ABSENT = ("protocol", "notes", "headphone_test", "quantity", "plate_quantity")


def test_a_sidecar_holds_what_the_schema_lists(laboratory, plan):

    laboratory.run()
    build_dataset(laboratory.folder)
    sidecars = list(laboratory.folder.glob("sub-*/beh/*_beh.json"))
    assert sidecars
    for path in sidecars:
        told = list(json.loads(path.read_text())["Slipscale"])
        # No task has a label, no notes, no headphone test, and levels are in µm.
        assert told == [name for name in NOTES if name not in ABSENT]
