"""Whether the surface stands: by the plate's own tolerance, when presented and when rated."""

import pytest

from slipscale.experiments.session.followed_textures import Following
from slipscale.experiments.session.surface_state import SurfaceState
from slipscale.experiments.steps.steps import Present
from slipscale.hardware.address import DEFAULT_PLATE, Plate
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.errors import NotReached
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.plate.twin import Drive, Twin
from slipscale.hardware.records import Readback
from slipscale.stimuli.surface import VirtualSurface

AMPLITUDES_UM_PP = (0.0, 0.5, 1.2, 2.3)


def staged(level, limits=DEFAULT_PLATE.limits, noise_um=0.0):
    """Return a surface on which a surface stands, and its plate."""
    clock = VirtualClock()
    plate = MockPlate(clock=clock, plate=Plate(limits=limits), twin=Twin(noise_um=noise_um))
    plate.connect()
    surface = SurfaceState(plate, clock, lambda _: None, Following(plate, clock))
    surface.present(Present(surface=VirtualSurface(level=level)))
    return surface, plate


def drift(plate, level):
    """Have the plate vibrate with another amplitude, unasked."""
    plate.twin.set_drive(Drive(target_um_pp=level), plate.clock.now())
    plate.clock.sleep(0.1)


@pytest.mark.parametrize("level", AMPLITUDES_UM_PP)
@pytest.mark.parametrize("side", [-1, 1])
def test_what_would_not_be_presented_is_not_taken_for_the_surface_later(level, side):
    limits = PlateLimits()
    allowed = max(limits.tolerance * level, limits.deviation_level)
    if level + side * allowed < 0:
        side = 1
    surface, plate = staged(level)
    drift(plate, level + 0.9 * side * allowed)
    surface.confirm()
    drift(plate, level + 1.1 * side * allowed)
    with pytest.raises(NotReached, match="was measured"):
        surface.confirm()


def test_the_tolerance_is_the_plates_own():
    surface, plate = staged(1.2, PlateLimits(tolerance=0.2))
    drift(plate, 1.2 * 1.15)
    surface.confirm()


@pytest.mark.parametrize(
    "kind, believed", [("measured", True), ("applied", True), ("commanded", False), ("none", False)]
)
def test_a_reading_breaks_a_surface_only_where_the_plate_knows_what_it_does(
    monkeypatch, kind, believed
):
    surface, plate = staged(1.2)
    gone = Readback(level=None if kind == "none" else 0.3, kind=kind, time_s=0.0)
    monkeypatch.setattr(plate, "read_back", lambda: gone)
    if believed:
        with pytest.raises(NotReached):
            surface.confirm()
    else:
        surface.confirm()


def test_a_vibrometers_noise_alone_never_breaks_a_surface():
    """A fifth of the tolerance, in a whole session's readings."""
    for level in AMPLITUDES_UM_PP:
        surface, plate = staged(level, noise_um=PlateLimits().deviation_level / 5)
        for _ in range(500):
            plate.clock.sleep(0.1)
            surface.confirm()


def test_after_an_adjustment_an_interruption_brings_back_the_final_level():
    surface, plate = staged(1.2)
    final = VirtualSurface(level=1.7)
    surface.turn(final)
    surface.adjusted(final)
    surface.interrupt()
    plate.silence()
    ((step, made),) = surface.restore(lambda _: None)
    assert (step.surface, surface.level) == (final, 1.7)
    assert made.readback_level == pytest.approx(1.7, rel=0.05)
