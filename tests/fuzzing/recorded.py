"""Short recorded runs of every protocol, whose journals and data sets are then altered."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.experiments.running.pilot import pilot_plans, run_simulated
from tests.fuzzing.study_files import short_studies
from tools.campaigns.torture.pilots import looked_up_once

if TYPE_CHECKING:
    from slipscale.experiments.study.run_plan import RunPlan


def record(folder: Path) -> dict[str, RunPlan]:
    """Record a run of each protocol, each in a data set named after the protocol.

    Returns
    -------
    dict of str to RunPlan
        Plan of the run, keyed by protocol.
    """
    plans = {}
    for protocol, text in short_studies().items():
        study = folder / f"{protocol}.toml"
        study.write_text(text, encoding="utf-8")
        plan = pilot_plans(str(study), participants=1, seed=None, language=None)[0]
        # The journal must not contain the path of the temporary folder.
        plans[protocol] = replace(plan, study_name=protocol)
        with looked_up_once():
            run_simulated(folder / protocol, plans[protocol], "mock")
    return plans
