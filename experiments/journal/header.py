"""Create the journal records that are written when a session starts and when it is resumed."""

from __future__ import annotations

from dataclasses import asdict
from datetime import UTC, datetime

from slipscale.experiments.journal.plan_and_progress import software
from slipscale.experiments.journal.record import FORMAT
from slipscale.experiments.journal.serialisation import TRIAL_LEVELS
from slipscale.experiments.languages.texts import texts_hash
from slipscale.experiments.study.file import study_hash
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.hardware.driver import PlateDriver


def header(
    plan: RunPlan, plate: PlateDriver, spec: str, answered_by: str, masking: str
) -> dict[str, object]:
    """Return the header, which contains everything needed to resume or analyse the run."""
    content = asdict(plan)
    if not plan.population:
        del content["population"]  # Only pilots have a population.
    return {
        "format": FORMAT,
        **plan.study.quantity_notes(),
        TRIAL_LEVELS: plan.trial_levels,
        **content,
        "answered_by": answered_by,
        "masking_noise": masking,
        "study_hash": study_hash(plan.study_text),
        "texts_hash": texts_hash(plan.texts()),
        "plate_spec": spec,
        "plate": plate.describe(),
        "software": software(),
        "started_utc": _now_utc(),
    }


def resume_data(plan: RunPlan, plate: PlateDriver, spec: str, masking: str) -> dict[str, object]:
    """Return the record for a resumption, with everything that may differ from the header.

    The dates of later records are computed from this record's date and session time, because
    session time never decreases, even if the computer's clock was set back.
    """
    return {
        "plate_spec": spec,
        "plate": plate.describe(),
        "masking_noise": masking,
        "texts_hash": texts_hash(plan.texts()),
        "software": software(),
        "resumed_utc": _now_utc(),
    }


def _now_utc() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
