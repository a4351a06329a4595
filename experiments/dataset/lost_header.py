"""Recover runs whose journal header is damaged from the sidecars of their tables.

The header is the first record of a journal. Without this record, a journal does not identify its
study. The sidecars repeat the header, and the study file in the data set is identified by its hash.
A run without tables cannot be recovered.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from slipscale.experiments.dataset.schema import SIDECAR, TABLE_NAME
from slipscale.experiments.journal.plan_and_progress import plan_from
from slipscale.experiments.journal.record import Record
from slipscale.experiments.journal.record_shapes import checked
from slipscale.experiments.journal.serialisation import TRIAL_LEVELS, in_code
from slipscale.experiments.protocol_parts.base import ORDER_VERSION
from slipscale.experiments.study.file import study_hash
from slipscale.experiments.study.run_plan import RunPlan, journal_path
from slipscale.faults.folders import visible


def header_from_tables(dataset: Path, journal: Path) -> tuple[RunPlan, Record] | None:
    """Return the plan and header of a run, reconstructed from the sidecars and the study file.

    Return None if the run has no tables, or if their sidecars do not contain enough information.
    """
    for entries in _sidecars(dataset, journal):
        record = Record(number=0, time_s=0.0, kind="header", data={**entries, TRIAL_LEVELS: []})
        if not checked([record])[1]:
            plan = plan_from(record)
            record.data[TRIAL_LEVELS] = plan.trial_levels
            return plan, record
    return None


def _sidecars(dataset: Path, journal: Path) -> Iterator[dict[str, object]]:
    """Yield the content of a journal header as recorded in each sidecar of the run."""
    studies = _studies(dataset)
    for table in visible(dataset, f"{journal.parent.name}/**/beh/*_beh.tsv"):
        found = TABLE_NAME.fullmatch(table.name)
        if found is None:
            continue
        labels = {
            "participant": found["sub"],
            "session": found["ses"] or "",
            "run": found["run"] or "",
        }
        if journal_path(dataset, **labels) != journal:
            continue
        try:
            entry = json.loads(table.with_suffix(".json").read_text(encoding="utf-8"))[SIDECAR]
            name, text = entry["study"], studies[entry["study_hash"]]
        except (OSError, ValueError, LookupError, TypeError, RecursionError):
            continue
        # Sidecars do not contain the order version, but only one version exists so far.
        orders = {"order_version": ORDER_VERSION}
        entry = in_code(entry)(entry)
        yield {**entry, **labels, **orders, "study_name": name, "study_text": text}


def _studies(dataset: Path) -> dict[str, str]:
    """Return the content of each study file in a data set, keyed by its hash."""
    texts = []
    for path in visible(dataset / "code", "study*.toml"):
        try:
            texts.append(path.read_bytes().decode())  # the hash depends on the line endings
        except (OSError, UnicodeDecodeError):
            continue
    return {study_hash(text): text for text in texts}
