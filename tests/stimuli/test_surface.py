import math

import pytest

from slipscale.faults import UserError
from slipscale.stimuli.surface import VirtualSurface, peak_from_pp, pp_from_peak


def test_peak_is_half_of_peak_to_peak_and_back():
    assert VirtualSurface(level=2.3).amplitude_um_peak == 1.15
    assert pp_from_peak(peak_from_pp(1.2)) == 1.2


@pytest.mark.parametrize("amplitude", [-0.1, math.nan, math.inf])
def test_impossible_amplitude_is_refused_with_its_value(amplitude):
    with pytest.raises(UserError, match=str(amplitude)):
        VirtualSurface(level=amplitude)


def test_silent_surface_has_the_plate_s_own_friction():
    still = VirtualSurface(level=0.0)
    assert still.predicted_relative_friction() == pytest.approx(1.0, abs=1e-9)
    assert still.predicted_relative_friction(model="closed form") == 1.0


def test_predicted_friction_falls_along_the_experiment_s_amplitudes():
    surfaces = [VirtualSurface(level=a) for a in (0.0, 0.5, 1.2, 2.3)]
    solved = [s.predicted_relative_friction() for s in surfaces]
    closed = [s.predicted_relative_friction(model="closed form") for s in surfaces]
    assert solved == sorted(solved, reverse=True)
    assert closed[1:] < solved[1:]
