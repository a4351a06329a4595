"""Objects with which a session interacts, and components that its actions share."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from slipscale.experiments.session.markers import Markers
from slipscale.experiments.session.sound.masking_noise import Noise, NoNoise
from slipscale.experiments.session.sound.question_sounds import NoSounds, Sounds

if TYPE_CHECKING:
    from slipscale.experiments.journal.journal import Journal
    from slipscale.experiments.participants.base import Participant
    from slipscale.experiments.session.operator import Operator
    from slipscale.experiments.session.progress import Progress
    from slipscale.experiments.session.resonance_tracking import ResonanceTracking
    from slipscale.experiments.session.surface_state import SurfaceState
    from slipscale.hardware.clock import Clock
    from slipscale.hardware.driver import PlateDriver


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """The objects with which a session interacts.

    A session with a virtual clock, a mock plate and a simulated participant can therefore be
    reproduced byte for byte.

    Parameters
    ----------
    plate : PlateDriver
        The connected plate.
    participant : Participant
    journal : Journal
        A reopened journal or a new one.
    clock : Clock
    operator : Operator
    noise : Noise
        Masking noise, which plays from the first surface of a block to the next text or rest.
    sounds : Sounds
        Plays the sounds of the headphone test.
    markers : Markers
        Sends markers to external recorders.
    tracking : ResonanceTracking or None
        Re-tunes the resonance between trials.
    unblind : bool
        Whether the operator sees the amplitude; the journal records this.
    warnings : tuple of str
        Problems that are shown to the operator from the start of the session.
    """

    plate: PlateDriver
    participant: Participant
    journal: Journal
    clock: Clock
    operator: Operator
    noise: Noise = field(default_factory=NoNoise)
    sounds: Sounds = field(default_factory=lambda: NoSounds("this session has no sound output"))
    markers: Markers = field(default_factory=Markers)
    tracking: ResonanceTracking | None = None
    unblind: bool = False
    warnings: tuple[str, ...] = ()


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
