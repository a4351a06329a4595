"""Components that the actions of a session share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from slipscale.experiments.journal.journal import Journal
    from slipscale.experiments.participants.base import Participant
    from slipscale.experiments.session.markers import Markers
    from slipscale.experiments.session.masking_noise import Noise
    from slipscale.experiments.session.progress import Progress
    from slipscale.experiments.session.surface_state import SurfaceState
    from slipscale.hardware.clock import Clock


@dataclass(frozen=True, slots=True, kw_only=True)
class Parts:
    """The participant, journal, clock, noise, markers, surface and progress of a session."""

    surface: SurfaceState
    participant: Participant
    journal: Journal
    clock: Clock
    noise: Noise
    markers: Markers
    progress: Progress
