"""The schema of study files says of every key what it means, and judges files as an editor does."""

import dataclasses
import json
import tomllib

import pytest
from jsonschema import Draft202012Validator

from slipscale import commands
from slipscale.experiments.protocol_parts.registry import load_protocol, protocol_names
from slipscale.experiments.protocols.magnitude_estimation import MagnitudeEstimation
from slipscale.experiments.study.file import shipped_studies, study_text
from slipscale.experiments.study.schema import study_schema

SCHEMA = study_schema()
Draft202012Validator.check_schema(SCHEMA)
TABLES = {"study": SCHEMA, **SCHEMA["$defs"]}
KEYS = [
    pytest.param(table["properties"][key], id=f"{name}.{key}")
    for name, table in TABLES.items()
    for key in table["properties"]
]
MINIMAL = 'name = "a"\ntitle = "A"\namplitudes_um_pp = [1.0]\n[[tasks]]\n'


def faults(text):
    found = Draft202012Validator(SCHEMA).iter_errors(tomllib.loads(text))
    return [fault.message for fault in found]


@pytest.mark.parametrize("key", KEYS)
def test_every_key_says_what_it_means(key):
    assert key["description"].endswith(".")


@pytest.mark.parametrize("key", KEYS)
def test_every_number_says_its_unit(key):
    if key.get("items", key).get("type") in ("integer", "number"):
        assert key["unit"]


@pytest.mark.parametrize("name", shipped_studies())
def test_shipped_studies_are_without_fault(name):
    assert faults(study_text(name)) == []


@pytest.mark.parametrize(
    "line",
    [
        'protocol = "magnitude_estimation"\nrepetition = 2',
        'protocol = "magnitude_estimation"\nrepetitions = 0',
        'protocol = "magnitude_estimation"\nseries = 2',
        'protocol = "no_such"',
        'protocol = "magnitude_estimation"\n[anaylsis]',
    ],
)
def test_a_fault_is_seen(line):
    assert faults(f'{MINIMAL}protocol = "magnitude_estimation"') == []
    assert faults(MINIMAL + line)


def test_a_laboratorys_own_protocol_belongs_to_it(monkeypatch):
    class Grip(MagnitudeEstimation):
        """Options of a laboratory's own."""

        grips: int = 3

    own = dataclasses.replace(load_protocol("magnitude_estimation"), options=Grip)
    names = [*protocol_names(), "grip"]
    monkeypatch.setattr("slipscale.experiments.study.schema.protocol_names", lambda: names)
    monkeypatch.setattr(
        "slipscale.experiments.study.schema.load_protocol",
        lambda name: own if name == "grip" else load_protocol(name),
    )
    table = study_schema()["$defs"]["task_grip"]["properties"]
    assert (table["protocol"]["const"], table["grips"]["default"]) == ("grip", 3)


def test_a_new_study_names_its_schema_which_lies_beside_it(tmp_path, capsys):
    path = tmp_path / "mine.toml"
    assert commands.main(["study", "new", str(path)]) == 0
    assert commands.main(["study", "validate", str(path)]) == 0
    first = path.read_text(encoding="utf-8").splitlines()[0]
    beside = path.with_name(first.removeprefix("#:schema "))
    capsys.readouterr()
    assert commands.main(["study", "schema"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == SCHEMA == json.loads(beside.read_text(encoding="utf-8"))
