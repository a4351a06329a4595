"""The study editor's form and the changes it makes: every key of the schema, comments kept."""

import re
import tomllib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipscale.experiments.lab.console.actions.study_changes import Change, changed
from slipscale.experiments.lab.console.study_form import StudyForm
from slipscale.experiments.study.file import OF_PLATE, shipped_studies, study_text
from slipscale.experiments.study.schema import study_schema
from slipscale.faults import UserError

TEXT = study_text("biet2007")


def change(text, what, *place, **more):
    return changed(text, Change(what=what, place=place, **more))


def comments(text):
    return sorted(re.findall("#.*", text))


def places(table):
    yield from (field.place for field in table.fields)
    yield from (part.place for part in table.absent)
    inner = [*table.tables, *(item for cards in table.lists for item in cards.items)]
    for each in inner:
        yield from places(each)


def test_the_form_has_a_field_for_every_key_of_the_schema():
    tasks = [f'[[tasks]]\nprotocol = "{name}"\n' for name in shipped_studies()[1:]]
    protocols = study_schema()["$defs"]
    table = tomllib.loads("".join(tasks))
    table["tasks"] = [t for t in table["tasks"] if f"task_{t['protocol']}" in protocols]
    found = set(places(StudyForm(table, ()).root))
    for number, task in enumerate(table["tasks"]):
        declared = protocols[f"task_{task['protocol']}"]["properties"].keys() - {"protocol"}
        assert {("tasks", number, key) for key in declared} <= found
    lists = {"tasks", "textures", "factors", "about_you", "questionnaires"}
    assert {(key,) for key in study_schema()["properties"].keys() - lists} <= found


def test_a_varied_parameter_gives_its_own_keys_and_the_plate_keeps_its_own():
    form = StudyForm(tomllib.loads(study_text("biet2008")), ())
    fields = {field.place: field for field in every_field(form.root)}
    levels, mean = fields["spatial_periods_mm",], fields["stimulus", "mean_um_pp"]
    assert (levels.value, levels.unit) == ("3.5, 4, 4.5, 5, 5.5, 6.25, 7.1", "mm")
    assert (mean.value, mean.unit) == ("1", "µm peak to peak")
    assert fields["tasks", 0, "standard_mm"].value == "5"
    assert {fields[key,].value for key in ("vary", "attribute")} == {
        "spatial_period_mm",
        "coarseness",
    }
    assert not [place for place in fields if "um_pp" in place[-1] and place[0] not in OF_PLATE]
    [factors] = [cards for cards in form.root.lists if cards.name == "factors"]
    assert (factors.items, factors.offered) == ((), ())


def every_field(table):
    yield from table.fields
    for each in [*table.tables, *(item for cards in table.lists for item in cards.items)]:
        yield from every_field(each)


@pytest.mark.parametrize("name", shipped_studies())
def test_no_change_of_a_shipped_study_loses_a_comment_or_alters_another_key(name):
    text = study_text(name)
    table = tomllib.loads(text)
    last = len(table["tasks"]) - 1
    after = change(text, "set", "participants", kind="number", value="7")
    assert tomllib.loads(after) == table | {"participants": 7}
    added = change(after, "item", "tasks", value="matching")
    assert tomllib.loads(added)["tasks"] == [*table["tasks"], {"protocol": "matching"}]
    moved = change(added, "move", "tasks", last + 1, to=0)
    assert tomllib.loads(moved)["tasks"] == [{"protocol": "matching"}, *table["tasks"]]
    removed = change(moved, "remove", "tasks", 0)
    assert tomllib.loads(removed) == table | {"participants": 7}
    assert comments(removed) == comments(text)


def test_tables_entries_and_the_last_item_of_a_list_come_and_go():
    priced = change(TEXT, "set", "cost", "per_person", kind="number", value="12,5")
    assert tomllib.loads(priced)["cost"] == {"per_person": 12.5}
    assert "cost" not in tomllib.loads(change(priced, "remove", "cost"))
    options = ("about_you", 1, "options")
    asked = tomllib.loads(change(TEXT, "entry", *options, value="no say"))["about_you"][1]
    assert asked["options"]["no say"] == {"en": "no say", "fr": "no say"}
    one = change(TEXT, "remove", "about_you", 0)
    assert "about_you" not in tomllib.loads(change(one, "remove", "about_you", 0))
    none = change(TEXT, "set", "seed", kind="number", value="")
    assert "seed" not in tomllib.loads(none)


@pytest.mark.parametrize(
    "what, place",
    [("remove", ("none",)), ("move", ("tasks", 9)), ("set", ("seed", "x")), ("entry", ("seed",))],
)
def test_a_change_at_a_place_that_is_not_there_is_refused(what, place):
    with pytest.raises(UserError, match="cannot make this change"):
        change(TEXT, what, *place, value="x")


@settings(max_examples=15, deadline=None)
@given(st.text(max_size=20), st.sampled_from(["text", "number", "numbers", "lines"]))
def test_whatever_is_typed_leaves_a_file_with_everything_else_as_it_was(typed, kind):
    after = tomllib.loads(change(TEXT, "set", "title", kind=kind, value=typed))
    before = tomllib.loads(TEXT)
    assert after | {"title": 0} == before | {"title": 0}
