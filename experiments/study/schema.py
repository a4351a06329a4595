"""The JSON Schema of a study file, for editors and for the reference in the documentation.

It is made from the models when it is asked for, not stored: the protocols that a laboratory has
installed belong to it, and a stored one would call their options faults.
"""

from __future__ import annotations

from copy import deepcopy
from typing import TYPE_CHECKING, Any

from pydantic.json_schema import models_json_schema

from slipscale.experiments.protocols.base import Options
from slipscale.experiments.protocols.registry import load_protocol, protocol_names
from slipscale.experiments.study.model import Study
from slipscale.stimuli.quantity import in_um

if TYPE_CHECKING:
    from pydantic import BaseModel

DIALECT = "https://json-schema.org/draft/2020-12/schema"

# The house writes a quantity's unit at the end of its name. The longest ending counts.
UNITS = {
    "_um_pp": "µm peak to peak",
    "_um_peak": "µm peak",
    "_mm_s": "mm/s",
    "_mm": "mm",
    "_hz": "Hz",
    "_s": "s",
    "_share": "share, 0 to 1",
}

Schema = dict[str, Any]  # JSON, as pydantic makes it


def study_schema() -> Schema:
    """Return the JSON Schema of a study file, with the options of every installed protocol.

    Each property has a ``description``, and each number a ``unit``. A property that may be left
    out without a value has no ``default``: TOML has no null.

    >>> study_schema()["properties"]["amplitudes_um_pp"]["unit"]
    'µm peak to peak'
    """
    options = {name: load_protocol(name).options for name in protocol_names()}
    models: list[type[BaseModel]] = [Study, *dict.fromkeys(options.values())]
    references, made = models_json_schema([(model, "validation") for model in models])
    parts: dict[str, Schema] = made["$defs"]
    key_of = {model: references[model, "validation"]["$ref"].split("/")[-1] for model in models}
    tasks = {f"task_{name}": deepcopy(parts[key_of[model]]) for name, model in options.items()}
    for name in options:
        tasks[f"task_{name}"]["properties"]["protocol"]["const"] = name
    root = parts[key_of[Study]]
    root["properties"]["tasks"]["items"] = {"oneOf": [{"$ref": f"#/$defs/{key}"} for key in tasks]}
    unused = {*key_of.values(), Options.__name__}
    tables = {key: part for key, part in parts.items() if key not in unused} | tasks
    for table in (root, *tables.values()):
        named = {in_um(key): value for key, value in table.get("properties", {}).items()}
        table["properties"] = {key: _in_toml(key, value) for key, value in named.items()}
        if "required" in table:
            table["required"] = [in_um(key) for key in table["required"]]
    return {"$schema": DIALECT, **root, "title": "Slipscale study", "$defs": tables}


def _in_toml(key: str, value: Schema) -> Schema:
    """Return a property as a TOML file may hold it: without null, with its unit."""
    value = {name: entry for name, entry in value.items() if name != "title"}
    choices = [each for each in value.pop("anyOf", []) if each.get("type") != "null"]
    value = {**choices[0], **value} if len(choices) == 1 else value
    if len(choices) > 1:
        value["anyOf"] = choices
    if "$ref" in value or value.get("default", ...) is None:
        # A table's keys have defaults of their own.
        value.pop("default", None)
    is_number = _type(value) in ("integer", "number")
    ending = next((ending for ending in UNITS if key.endswith(ending)), None)
    if is_number and "unit" not in value and ending:
        value["unit"] = UNITS[ending]
    return value


def _type(value: Schema) -> str | None:
    """Return the type of a property's values: of the entries where it is a list."""
    found = value.get("items", value).get("type")
    return None if found is None else str(found)
