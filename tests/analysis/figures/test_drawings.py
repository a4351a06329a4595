"""The drawings of the paper's plate, finger and mode show the models' numbers."""

from itertools import pairwise

import numpy as np
import pytest

from slipscale.analysis.figures import drawings
from slipscale.analysis.reproduction import comparison


def test_the_plate_s_ceramics_alternate_along_its_length():
    below, side = drawings.plate_figure().axes
    signs = [text.get_text() for text in below.texts]
    assert len(signs) == 35
    assert [signs[5 * column] for column in range(7)] == ["−", "+"] * 3 + ["−"]
    corners = np.vstack([patch.get_xy() for patch in side.patches])
    assert np.ptp(corners, axis=0) == pytest.approx([83, 3])


def test_the_section_s_middle_rises_and_its_supports_stay():
    (axes,) = drawings.bending_figure().axes
    neutral = axes.get_lines()[0].get_ydata()
    assert neutral[0] == neutral[-1] == pytest.approx(1.6755, abs=1e-4)
    assert neutral.max() - neutral[0] == pytest.approx(0.0192 * 50, abs=0.01)


def test_the_predicted_mode_has_eight_nodal_lines_and_the_model_s_amplitude():
    (axes,) = drawings.measured_mode_figure().axes
    x, shape = axes.get_lines()[0].get_data()
    nodes = x[:-1][np.diff(np.sign(shape)) != 0]
    assert len(nodes) == 8
    assert np.abs(nodes[4:]) == pytest.approx([5.79, 17.15, 28.06, 37.49], abs=1.0)
    assert 2 * np.abs(shape).max() == pytest.approx(3.227, abs=0.002)


def test_every_figure_of_the_paper_is_drawn():
    drawn = {name for source in comparison.sources() for name in source.FIGURES}
    assert {f"fig{number}" for number in range(1, 16)} <= drawn
    assert set(drawings.DRAWINGS) <= drawn


def test_the_mesh_shows_the_gaps_between_ceramics():
    above, side = drawings.mesh_figure().axes
    # A quarter has 4 x 3 ceramics, half of which are cut by the planes of symmetry.
    assert len(above.patches) == 1 + 4 * 3
    ceramics = [patch.get_xy()[:, 0] for patch in side.patches[1:]]
    gaps = [right.min() - left.max() for left, right in pairwise(ceramics)]
    assert gaps == pytest.approx([1.0, 1.0, 1.0])


def test_the_set_up_of_the_experiment_has_no_vibrometer():
    assert not any("vibrometer" in name for _, name, _ in drawings.BENCH)
