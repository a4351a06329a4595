import numpy as np
import pytest

from slipscale.figure_style import save
from slipscale.hardware.plate.beam import BeamSection
from slipscale.hardware.plate.design import figures
from slipscale.hardware.plate.geometry import QUICK
from slipscale.hardware.plate.paper_study import harmonic, prototype_modes


@pytest.fixture(scope="module")
def found():
    return prototype_modes(density=QUICK)


def test_deflection_figure_says_the_shortest_half_wave(tmp_path):
    figure = figures.deflection_figure(BeamSection.printed())
    path = tmp_path / "fig8.svg"
    save(figure, path)
    assert "8.20 mm" in path.read_text(encoding="utf-8")


def test_frequency_figure_shades_between_amplitude_and_frequency():
    figure = figures.frequency_figure(
        BeamSection.printed(),
        BeamSection.plane_strain(),
        {10.0: 42.9},
        least_mm=8.2,
        measured=(10.4, 30.5),
    )
    axes = figure.axes[0]
    # The limit is the Timoshenko beam's; the paper's beam would give 13.60 mm.
    assert "admissible to 13.43 mm\n(Timoshenko)" in [text.get_text() for text in axes.texts]
    assert {text.get_text() for text in axes.get_legend().get_texts()} >= {"3-D FE", "measured"}


def test_frequency_figure_draws_the_harmonic_peak_as_a_cross():
    figure = figures.frequency_figure(
        BeamSection.printed(), BeamSection.plane_strain(), harmonic_peak=(83 / 8, 34.77)
    )
    (cross,) = [line for line in figure.axes[0].lines if line.get_marker() == "x"]
    assert cross.get_xydata().tolist() == [[10.375, 34.77]]


def test_frequency_figure_shades_nothing_where_nothing_is_admissible():
    figure = figures.frequency_figure(
        BeamSection.printed(), BeamSection.plane_strain(), least_mm=18.0, floor_hz=25_000
    )
    assert not any("admissible" in text.get_text() for text in figure.axes[0].texts)


def test_mode_figure_shows_the_whole_plate_scaled_to_one(found):
    figure = figures.mode_figure(found)
    above = figure.axes[1]
    assert above.get_xlim() == pytest.approx((-41.5, 41.5), abs=0.5)
    values = above.collections[0].get_array()
    assert np.nanmax(np.abs(values)) == pytest.approx(1)
    assert "kHz" in figure.axes[0].get_title()


def test_harmonic_figure_names_peak_and_convention(found):
    figure = figures.harmonic_figure({"edge": harmonic(found)}, (34.77, 3.2))
    axes = figure.axes[0]
    assert "peak to peak" in axes.get_ylabel()
    assert any("µm at" in text.get_text() for text in axes.get_legend().get_texts())


def test_same_figure_gives_the_same_svg(tmp_path):
    for name in ("a.svg", "b.svg"):
        save(figures.deflection_figure(BeamSection.printed()), tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_the_amplitude_map_is_the_forced_response_with_its_nodal_lines(found):
    figure = figures.amplitude_map_figure(found, voltage_v=15.0)
    axes, bar = figure.axes
    assert bar.get_xlabel() == "Amplitude (µm peak to peak)"
    values = axes.collections[0].get_array().reshape(77, 131)
    # The edge antinode nearest to the middle: x = 0 or half a wave beside it, y = width / 2.
    x_mm = found.parts.layout.antinode_x_mm
    column = np.argmin(np.abs(np.linspace(-41.5, 41.5, 131) - x_mm))
    assert values[-1, column] == pytest.approx(harmonic(found).peak_um_pp, rel=0.03)
    assert np.nanmin(values) < 0.05 * np.nanmax(values)
    weaker = figures.amplitude_map_figure(found, voltage_v=7.5).axes[0].collections[0].get_array()
    assert np.nanmax(values) == pytest.approx(2 * np.nanmax(weaker))
