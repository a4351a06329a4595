"""Fuzz study files, which must be shown with all orders or rejected with an error message."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random

import tomlkit

from slipscale.experiments.running import study_commands
from slipscale.experiments.study.file import shipped_studies, study_text
from slipscale.faults import UserError
from tests.fuzzing.changes import changed_file
from tests.fuzzing.kind import Case, Kind
from tools.campaigns.torture.pilots import EVERY_OPTION

# The protocol that presents textures.
TEXTURED = "magnitude_estimation"
# Protocols that `slipscale analyse` recognises only if the task has no label.
ANALYSED_BY_NAME = ("magnitude_estimation", "descending_difference")


def short_studies() -> dict[str, str]:
    """Return one short study per protocol, with every option."""
    text = EVERY_OPTION.read_text(encoding="utf-8")
    found = {}
    for number, task in enumerate(tomlkit.parse(text)["tasks"]):
        document = tomlkit.parse(text)
        tasks = document["tasks"]
        del tasks[number + 1 :], tasks[:number]
        if task["protocol"] != TEXTURED:
            del document["textures"]
        if task["protocol"] in ANALYSED_BY_NAME:
            del document["tasks"][0]["label"]
        found[str(task["protocol"])] = tomlkit.dumps(document)
    return found


def _prepared(folder: Path) -> Callable[[Random], Case]:
    path = folder / "study.toml"
    shipped = [study_text(name) for name in shipped_studies()]
    texts = [*shipped, *short_studies().values()]

    def drawn(random: Random) -> Case:
        content = changed_file(random, random.choice(texts))
        return Case(name=path.name, content=content, use=lambda: _use(path, content))

    return drawn


def _use(path: Path, content: bytes) -> bool:
    path.write_bytes(content)
    try:
        shown = study_commands.show(str(path), "03", run="02")
    except UserError as error:
        return not str(error)
    if "surfaces of participant 03" not in shown:
        raise AssertionError("shown without its orders")
    return True


KIND = Kind(title="study files", prepared=_prepared)
