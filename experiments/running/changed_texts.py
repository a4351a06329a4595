"""Detect changes in the text shown to participants since a run began."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace

from slipscale.experiments.journal.record import Record
from slipscale.experiments.languages.texts import texts_hash
from slipscale.experiments.study.file import read_study
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError


def changed_texts(plan: RunPlan, records: list[Record]) -> Iterator[str]:
    """Describe how the text shown to participants has changed since the run began."""
    texts = plan.texts()
    if records[0].data["texts_hash"] != texts_hash(texts):
        yield (
            "some texts on the screen differ from those at the start of the run, because the "
            "Slipscale version differs; the journal records this"
        )
    with suppress(UserError):
        study, text = read_study(plan.study_name)
        if study.name == plan.study.name and replace(plan, study_text=text).texts() != texts:
            yield (
                f"{plan.study_name}: its texts in '{plan.language}' have changed since the "
                "run began; the run continues with the earlier texts"
            )
