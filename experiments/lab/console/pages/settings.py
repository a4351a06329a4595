"""The settings page, with one field per key in slipscale.toml."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from serial.tools.list_ports import comports

from slipscale.experiments.lab.console.actions.forms import text_hash
from slipscale.experiments.lab.console.pages.view import View
from slipscale.experiments.lab.console.state import findings
from slipscale.experiments.lab.folder import FILE, LabFile, lab_text, read_lab
from slipscale.experiments.languages.texts import languages
from slipscale.experiments.study.file import shipped_studies
from slipscale.faults import UserError
from slipscale.faults.folders import visible
from slipscale.hardware.cli.ports import listing


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """A setting on the page: its input type, value, choices and explanation."""

    key: str
    kind: str
    value: object
    offered: tuple[str, ...]
    why: str


def settings(view: View) -> dict[str, object]:
    """Return the values for the settings page, one field per key in slipscale.toml."""
    test = view.jobs.last("test")
    over = test is not None and not test.running
    text, fault = lab_text(Path()), ""
    try:
        lab = read_lab(Path()) or LabFile()
    except UserError as error:
        lab, fault = LabFile(), str(error)
    return {
        "there": bool(text),
        "before": text_hash(text),
        "fault": fault,
        "fields": [_field(key, getattr(lab, key)) for key in LabFile.model_fields],
        "testing": bool(test and test.running),
        "tested": findings(test.said()) if test and over else None,
        "test_failed": test.complained() if test and over and not findings(test.said()) else "",
    }


def _field(key: str, value: object) -> Field:
    kinds: dict[type, str] = {bool: "checkbox", int: "number"}
    offered: dict[str, Callable[[], list[str]]] = {
        "study": lambda: [*(path.name for path in visible(Path(), "*.toml")), *shipped_studies()],
        "plate": lambda: ["mock", *(port["spec"] for port in listing((), comports)["ports"])],
        "language": languages,
    }
    return Field(
        key=key,
        kind=kinds.get(type(value), "text"),
        value=" ".join(value) if isinstance(value, tuple) else value,
        offered=tuple(name for name in offered.get(key, list)() if name != FILE),
        why=str(LabFile.model_fields[key].description),
    )
