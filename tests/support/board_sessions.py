"""Complete sessions on emulated boards, shared by tests and benchmarks."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.running.begin_or_resume import plate_for, run_plan
from slipscale.experiments.session.operator import Operator, Request, UnattendedOperator
from slipscale.experiments.session.parts import Setup
from slipscale.experiments.study.run_plan import RunPlan

if TYPE_CHECKING:
    from slipscale.experiments.participants.base import Participant
    from slipscale.experiments.session.session import RunOutcome
    from slipscale.hardware.clock import Clock
    from tests.support.controlled_board import ControlledBoard

STUDY = """
name = "wire"
title = "On an emulated board"
authors = ["A. Test"]
language = "en"
seed = 1
participants = 1
amplitudes_um_pp = [0.5, 1.2, 2.3]

[[tasks]]
protocol = "magnitude_estimation"
repetitions = 1
practice = 0
randomisation = "blocked"
scale_top = "declared"
"""

TEXTURES = """
[[textures]]
name = "ridges"
waveform = "square"
spatial_period_mm = 2.5
mean_um_pp = 1.4
depth_um_pp = 0.4
finger_speed_mm_s = 50.0

[[textures]]
name = "waves"
spatial_period_mm = 5.0
mean_um_pp = 0.9
depth_um_pp = 0.9         # down to 0: silence is told from a groove by the mean
finger_speed_mm_s = 50.0

[[tasks]]"""
TEXTURED = STUDY.replace("[[tasks]]", TEXTURES.lstrip(), 1)
MEANS_UM_PP = {"ridges": 1.4, "waves": 0.9}
OF_A_TEXTURE = 100  # offset that marks estimates of textures


def board_plan(text: str, *, seed: int) -> RunPlan:
    """Return the plan of a study's only run."""
    return RunPlan(
        study_name="wire", study_text=text, participant="01", seed=seed, language="en", mode="pilot"
    )


def felt(board: ControlledBoard) -> float:
    """Return ten times the plate's true amplitude or, for a texture, ten times its mean plus 100.

    Tests use this as the estimate, to check that each estimate is in the row of its surface.
    """
    state = board.state()
    if state["state"] == "LIST":  # at any point of its swing
        return round(OF_A_TEXTURE + 10 * float(state["target_level"]), 1)
    return round(10 * float(state["amplitude_um_pp"]), 1)


def due(texture: str, amplitude_um_pp: float) -> tuple[float, float]:
    """Return the estimate and the readback that a surface's row must contain."""
    mean_um_pp = MEANS_UM_PP.get(texture, amplitude_um_pp)
    return 10 * mean_um_pp + (OF_A_TEXTURE if texture in MEANS_UM_PP else 0), mean_um_pp


class PatientOperator(UnattendedOperator):
    """An operator who waits until the board is plugged in again before retrying.

    Parameters
    ----------
    back_s : float
        Time after which the board is plugged in again.
    clock : Clock
        The board's clock.
    retries : int
        Number of retries.
    """

    def __init__(self, back_s: float, clock: Clock, retries: int = 3) -> None:
        super().__init__(retries=retries)
        self._back_s = back_s
        self._clock = clock

    def poll(self) -> Request | None:
        """Request a retry after a while."""
        if self._state == "fault":
            self._clock.sleep(1.2 * self._back_s)
        return super().poll()


def run_on_board(
    board: ControlledBoard,
    plan: RunPlan,
    folder: Path,
    person: Participant,
    clock: Clock,
    *,
    operator: Operator | None = None,
    connected: Callable[[], object] = lambda: None,
    first: str = "",
) -> RunOutcome:
    """Run a session on the board; ``connected`` is called once the plate is connected.

    If ``first`` is the SPEC of another plate, the board is the second of two actuators.

    Raises
    ------
    PlateFault
        If the plate could not be connected, or the operator gave up.
    """
    spec = f"pair:{first}+serial:{board.port}" if first else f"serial:{board.port}"
    plate = plate_for(plan, spec, clock)
    with Journal.create(plan.journal_path(folder), clock) as journal, plate:
        connected()
        return run_plan(
            plan,
            Setup(
                plate=plate,
                participant=person,
                journal=journal,
                clock=clock,
                operator=operator or UnattendedOperator(),
            ),
            spec=spec,
        )


def rows_of(folder: Path) -> list[dict[str, str]]:
    """Build the data set; return the rows of its magnitude estimation."""
    build_dataset(folder)
    rows: list[dict[str, str]] = []
    for table in folder.glob("sub-01/beh/*_task-magnitudeestimation_*_beh.tsv"):
        with table.open(encoding="utf-8", newline="") as file:
            rows += csv.DictReader(file, delimiter="\t")
    return rows
