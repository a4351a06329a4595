"""Equations of the paper as printed, compared with separate evaluations."""

import pytest

from slipscale.analysis.reproduction import beam_equations, constants, film, film_equations

EQUATIONS = {**film_equations.ITEMS, **beam_equations.ITEMS}


@pytest.mark.parametrize(
    "number, difference, correction",
    [
        (4, 0.99, "l0²"),
        (10, 0.27694, "A²"),
        (11, 0.99999, "factor p0"),  # 1 - 1/p0, with p0 = 1e5 Pa
        (13, 0.99999, "factor p0"),
        (15, 0.52140, "0.48"),  # 0.99999 printed, 0.47860 computed
        (17, 2, "sign"),
        (21, 0.70783, "-4.9"),  # -4.9 and -16.77 C/m²
        (24, 2, "sign"),
        (27, 2, "sign"),
        (28, 2, "sign"),
        (37, 2, "sign"),
        (38, 0.84085, "2π"),
        (40, 0.951, "width b"),  # 1 - 0.049
        (41, 1, "(42)"),
    ],
)
def test_an_equation_with_a_misprint_differs_by_the_size_of_the_misprint(
    number, difference, correction
):
    found = EQUATIONS[f"eq.{number}"]()
    assert found.group == "differs"
    assert found.ours == pytest.approx(difference, abs=5e-6)
    assert correction in found.reason


def test_the_printed_deflection_at_mid_span_has_the_opposite_sign():
    bent = beam_equations._bent()
    span, section = beam_equations.HALF_WAVE_MM * 1e-3, bent.section
    printed = -3 * section.ceramic.d31_m_v * 15 * span**2 * section.inverse_a / (16 * 1e-6)
    assert printed * 1e6 == pytest.approx(-0.0191866, abs=1e-6)
    assert beam_equations._middle_um() == pytest.approx(0.0191866, abs=1e-6)


def test_identities_of_our_own_functions_are_no_evidence():
    groups = {name: compute().group for name, compute in EQUATIONS.items()}
    identities = {1, 2, 8, 9, 16, 18, 19, 20, 39}
    assert {n for n, group in groups.items() if group == "by construction"} == {
        f"eq.{number}" for number in identities
    }
    assert sum(group == "agrees" for group in groups.values()) == 15


@pytest.mark.parametrize(
    "name", ["fig1.area", "fig1.half_wave", "fig2.ridge_height", "fig10.gap", "table2.alpha"]
)
def test_arithmetic_on_the_papers_own_numbers_is_no_evidence(name):
    assert constants.ITEMS[name]().group == "by construction"


@pytest.mark.parametrize("name, printed", [("fig3.25kHz", "> 10"), ("fig5.hr1.6.hvib4", "> 0")])
def test_a_lower_bound_is_printed_as_one(name, printed):
    found = film.ITEMS[name]()
    assert (found.published, found.agrees) == (printed, True)


def test_the_zones_that_lift_the_finger_have_only_digits_that_hold():
    found = film.ITEMS["fig4.zones.closed_form"]()
    # The same share from the thickness at which the pressure is the finger's.
    import numpy as np

    from slipscale.stimuli.film.squeeze_film import FINGER, gap

    _, eps, delta = gap(3.0, 1.6)
    k = FINGER.wave_number
    edge = 1 + delta * np.cos(k / 2)
    ratio = 1.05 * edge / np.sqrt(edge**2 + 1.5 * eps**2)
    half_width = np.pi - np.arccos((eps * ratio / np.sqrt(ratio**2 - 1) - 1) / delta)
    # From the groove in the middle to each edge are 14.29 ridges.
    turns = k / 2 / (2 * np.pi)
    whole = int(turns)
    last = np.clip((turns - whole) * 2 * np.pi - (np.pi - half_width), 0, 2 * half_width)
    share = (whole * 2 * half_width + last) / (k / 2)
    assert found.shown == f"{float(share):.5g}" == "0.14906"
