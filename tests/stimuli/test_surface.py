import math

import pytest

from faults import UserError
from stimuli.surface import VirtualSurface, peak_from_pp, pp_from_peak


def test_peak_is_half_of_peak_to_peak_and_back():
    assert VirtualSurface(amplitude_um_pp=2.3).amplitude_um_peak == 1.15
    assert pp_from_peak(peak_from_pp(1.2)) == 1.2


@pytest.mark.parametrize("amplitude", [-0.1, math.nan, math.inf])
def test_impossible_amplitude_is_refused_with_its_value(amplitude):
    with pytest.raises(UserError, match=str(amplitude)):
        VirtualSurface(amplitude_um_pp=amplitude)
