"""Define ``manifest.json``, which contains a frozen plan in machine-readable form."""

from __future__ import annotations

import hashlib
import json
from typing import Literal

from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.faults.frozen_table import FrozenTable

MANIFEST = "manifest.json"
STUDY = "study/study.toml"
FORMAT: Literal[1] = 1

Role = Literal["study", "named by the study", "population", "power", "notes", "page", "packages"]


class FrozenFile(FrozenTable):
    """A file in the bundle, and the study key that refers to it (``named_by``)."""

    path: str
    sha256: str
    role: Role
    named_by: str = ""


class Manifest(FrozenTable):
    """The manifest of a frozen plan.

    ``normalisation`` is the rule that `analyse` uses for simulated data from the study; ``tests``
    lists the fields of `slipscale.analysis.statistics.statistic.Inference` that have a result for
    these data. ``digest`` is the SHA-256 of all other fields, which contain the SHA-256 of every
    file.
    """

    format: Literal[1] = FORMAT
    frozen_utc: str
    name: str
    title: str
    participants: int
    sessions: tuple[str, ...]
    runs: int
    seed: int
    language: str
    stopping_rule: str
    existing_data: str
    sample_size: str
    choices: AnalysisChoices
    chosen: tuple[str, ...]
    normalisation: str
    tests: tuple[str, ...]
    software: dict[str, str]
    files: tuple[FrozenFile, ...]
    digest: str = ""

    def computed_digest(self) -> str:
        """Return the SHA-256 of all fields except ``digest``, in hexadecimal."""
        content = self.model_dump(mode="json", exclude={"digest"})
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    def signed(self) -> Manifest:
        """Return a copy of the manifest with its ``digest`` computed."""
        return self.model_copy(update={"digest": self.computed_digest()})

    def text(self) -> str:
        """Return the manifest as JSON text."""
        content = self.model_dump(mode="json")
        return json.dumps(content, indent=2, ensure_ascii=False) + "\n"
