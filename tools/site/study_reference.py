"""The study file reference, generated from its JSON Schema."""

from __future__ import annotations

import json
from collections.abc import Iterator
from importlib.resources import files
from typing import Any

from slipscale.experiments.study.schema import study_schema
from tools.site.tables import code, table

INTRODUCTION = """# Study file

A study is one [TOML](https://toml.io) file. This page lists every key for Slipscale's own
protocols. It is generated from the models that check the file. `slipscale study validate` reports
every other key as a fault, with its line. `slipscale study new mine.toml` writes a file to start
from and, next to it, `study.schema.json`, which the first line of the file names. Editors that
support TOML schemas (Taplo, Even Better TOML) then complete keys, show these meanings and mark
faults while you type. If you install your own protocol, `slipscale study schema` prints the schema
with its options. The schema is also available as a file: [study.schema.json](study.schema.json).

The name of each number ends with its unit; amplitudes are peak to peak.
"""
LIMITS = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}
TYPES = {
    "integer": "whole number",
    "number": "number",
    "string": "text",
    "boolean": "true or false",
    "object": "table",
}
HEADER = ["key", "meaning", "type", "unit", "default"]


def pages() -> dict[str, str]:
    """Return the page, and the schema as a file."""
    schema = study_schema()
    sections = [section(*part) for part in parts(schema)]
    texts = (
        files("slipscale.experiments").joinpath("languages", "en.toml").read_text(encoding="utf-8")
    )
    shipped = (
        "## [texts.en]\n\nThe shipped texts by key. A study can replace any of them in a "
        "table such as `[texts.en.session]`; keep the words in {braces}.\n\n"
        f'??? note "All shipped texts, in English"\n\n    ```toml\n{_indented(texts)}\n    ```\n'
    )
    return {
        "reference/study-file.md": "\n\n".join([INTRODUCTION, *sections, shipped]),
        "reference/study.schema.json": json.dumps(schema, indent=2, ensure_ascii=False),
    }


def parts(schema: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield each table of a study file with its heading and schema."""
    yield "Top of the file", schema
    yield from _below(schema, schema, "")


def _below(
    schema: dict[str, Any], part: dict[str, Any], path: str
) -> Iterator[tuple[str, dict[str, Any]]]:
    for key, value in part["properties"].items():
        several = "items" in value
        for choice in value.get("items", value).get("oneOf", [value.get("items", value)]):
            if "$ref" not in choice:
                continue
            inner = schema["$defs"][choice["$ref"].rpartition("/")[2]]
            name = f"[[{path}{key}]]" if several else f"[{path}{key}]"
            protocol = inner["properties"].get("protocol", {}).get("const")
            yield (f"{name}, {protocol}" if protocol else name), inner
            yield from _below(schema, inner, f"{path}{key}.")


def section(heading: str, part: dict[str, Any]) -> str:
    """Return a table's section."""
    rows = [row(key, value, part) for key, value in part["properties"].items()]
    about = "" if heading == "Top of the file" else f"{_sentence(part)}\n\n"
    return f"## {heading}\n\n{about}{table(HEADER, rows)}"


def row(key: str, value: dict[str, Any], part: dict[str, Any]) -> list[str]:
    """Return a key's row of the table."""
    entry = value.get("items", value)
    kind = " or ".join(_kind(choice) for choice in value.get("anyOf", [value]))
    limits = " and ".join(
        f"{sign} {entry[name]:g}" for name, sign in LIMITS.items() if name in entry
    )
    allowed = " One of: " + ", ".join(map(code, entry["enum"])) + "." if "enum" in entry else ""
    default = "must be given" if key in part.get("required", ()) else ""
    if "default" in value:
        default = code(json.dumps(value["default"], ensure_ascii=False))
    if "const" in value:
        kind, default = code(json.dumps(value["const"])), "must be given"
    return [
        code(key),
        value["description"] + allowed,
        f"{kind} {limits}".strip(),
        value.get("unit", ""),
        default,
    ]


def _kind(value: dict[str, Any]) -> str:
    """Describe the type of a key: one of the schema's types, or a list of such values.

    >>> _kind({"type": "array", "items": {"type": "string"}})
    'list: text'
    """
    entry = value.get("items", value)
    kind = TYPES.get(entry.get("type", "object"), "")
    if "items" not in value:
        return kind
    return "tables" if kind == "table" else f"list: {kind}"


def _sentence(part: dict[str, Any]) -> str:
    words = part.get("description", "").partition("\n\n")[0]
    return " ".join(words.replace("``", "`").split())


def _indented(text: str) -> str:
    return "\n".join(f"    {line}".rstrip() for line in text.splitlines())
