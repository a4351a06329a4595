"""Generate the JSON Schema of study files for editors and reference documentation.

The schema is generated on request, because it includes the protocols that a laboratory has
installed. Editors with a stored schema would report the options of a laboratory's own protocols as
errors.
"""

from __future__ import annotations

from copy import deepcopy
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from slipscale.experiments.protocol_parts.base import Options
from slipscale.experiments.protocol_parts.registry import load_protocol, protocol_names
from slipscale.experiments.study.factors import Factor
from slipscale.experiments.study.model import Study
from slipscale.stimuli.level_names import Names
from slipscale.stimuli.quantity import PLATE_AMPLITUDE
from slipscale.stimuli.textures import PARAMETERS

DIALECT = "https://json-schema.org/draft/2020-12/schema"

# Units of quantities by the ending of their names; longer endings come first.
UNITS = {
    "_um_pp": "µm peak to peak",
    "_um_peak": "µm peak",
    "_mm_s": "mm/s",
    "_mm": "mm",
    "_hz": "Hz",
    "_deg": "°",
    "_s": "s",
    "_n": "N",
    "_share": "share, 0 to 1",
}

# Keys for levels in another quantity, such as standard_mm; the study's quantity determines which
# key applies.
IN_ANOTHER_UNIT = (
    f"_({'|'.join(ending[1:] for ending in UNITS if ending != '_s')}|(.+_)?(pp|peak|rms))$"
)

Schema = dict[str, Any]


def study_schema() -> Schema:
    """Return the JSON Schema of study files, including the options of every installed protocol.

    Each property has a ``description``, and each number a ``unit``. An optional property without a
    default value has no ``default``, because TOML has no null.

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
    # A factor's levels are words or parameter values, so its key `levels` is given no unit.
    own = tables.get(Factor.__name__)
    for table in (root, *tables.values()):
        given = table.get("properties", {})
        names = Names(str) if table is own else PLATE_AMPLITUDE.in_file
        named = {names[key]: value for key, value in given.items()}
        table["properties"] = {key: _in_toml(key, value) for key, value in named.items()}
        if "required" in table:
            required = table["required"]
            table["required"] = [key for key in required if names[key] == key]
        if levels := [names[key] for key in given if names[key] != key]:
            table["patternProperties"] = {f"{IN_ANOTHER_UNIT}|{_in_seconds(levels)}": {}}
    return {"$schema": DIALECT, **root, "title": "Slipscale study", "$defs": tables}


def _in_seconds(levels: list[str]) -> str:
    """Return a pattern for the keys of levels in seconds, but for no other keys in ``_s``."""
    varied = [each.parameter for each in PARAMETERS.values() if each.parameter.unit == "s"]
    nouns = [each.quantity(PLATE_AMPLITUDE).nouns for each in varied]
    return f"^({'|'.join([*nouns, *(key.removesuffix('_um_pp') for key in levels)])})_s$"


def _in_toml(key: str, value: Schema) -> Schema:
    """Adapt a property's schema for TOML files: remove null, and add the unit."""
    value = {name: entry for name, entry in value.items() if name != "title"}
    choices = [each for each in value.pop("anyOf", []) if each.get("type") != "null"]
    value = {**choices[0], **value} if len(choices) == 1 else value
    if len(choices) > 1:
        value["anyOf"] = choices
    if "$ref" in value or value.get("default", ...) is None:
        # The keys of a table have their own defaults.
        value.pop("default", None)
    is_number = _type(value) in ("integer", "number")
    ending = next((ending for ending in UNITS if key.endswith(ending)), None)
    if is_number and "unit" not in value and ending:
        value["unit"] = UNITS[ending]
    return value


def _type(value: Schema) -> str | None:
    """Return the type of a property or, for a list, of its elements."""
    found = value.get("items", value).get("type")
    return None if found is None else str(found)
