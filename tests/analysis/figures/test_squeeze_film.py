import pytest

from slipscale.analysis.figures import squeeze_film
from slipscale.figure_style import save


@pytest.mark.parametrize(
    "draw",
    [squeeze_film.squeeze_number_figure, squeeze_film.film_figure, squeeze_film.friction_figure],
)
def test_figure_has_units_on_its_axes_and_can_be_written(draw, tmp_path):
    figure = draw()
    for axes in figure.axes:
        assert axes.get_ylabel()
    assert figure.axes[-1].get_xlabel()
    save(figure, tmp_path / "figure.svg")
    assert (tmp_path / "figure.svg").stat().st_size > 5_000


def test_friction_figure_has_a_curve_for_each_roughness_of_table_i():
    legend = squeeze_film.friction_figure().axes[0].get_legend()
    assert {text.get_text() for text in legend.get_texts()} >= {
        f"{roughness} µm" for roughness in (0.4, 0.8, 1.2, 1.6)
    }


def test_ratio_to_the_closed_form_is_two_thirds_at_the_working_point():
    # Notes: 0.68-0.70 for squeeze numbers 1 to 200.
    numbers, ratio = squeeze_film.convergence_data([0.1, 1.0, 10.0])
    assert numbers == pytest.approx([1.5886, 15.886, 158.86], rel=1e-4)
    assert all(0.675 < r < 0.705 for r in ratio)
