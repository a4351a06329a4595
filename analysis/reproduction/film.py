"""Compare squeeze-film results with the paper: squeeze number, pressure, friction, perception.

To record the computed values in ``film.json``, run ``python -m
slipscale.analysis.reproduction.film``. Do this only after an intended change to a model, and
explain in the commit message why the numbers changed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import TYPE_CHECKING

from slipscale.analysis.published.biet2007 import TABLE3
from slipscale.analysis.reproduction.comparison import Outcome, item, record
from slipscale.stimuli.surface import peak_from_pp

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.stimuli.film.periodic_film import FilmState


# Positions across half of the contact, between which the pressure is interpolated.
POSITIONS = 100_000


def more_than(limit: float) -> Callable[[str, float], bool]:
    """Return a rule: whether the computed value exceeds a published lower bound."""
    return lambda _published, ours: ours > limit


def _squeeze(frequency_hz: float, peak: float, roughness: float) -> float:
    from slipscale.stimuli.film.squeeze_film import squeeze_number

    return float(squeeze_number(frequency_hz, peak, roughness))


def _friction(peak: float, roughness: float) -> float:
    from slipscale.stimuli.film.squeeze_film import relative_friction

    return float(relative_friction(peak, roughness, 40_000).relative_friction)


@cache
def _film(amplitude_um_pp: float) -> FilmState:
    from slipscale.stimuli.film.reynolds import WorkingPoint, solve

    return solve(
        WorkingPoint(
            amplitude_um_peak=peak_from_pp(amplitude_um_pp), roughness_um=0.6, frequency_hz=30_500
        )
    )


def reynolds(amplitude_um_pp: float) -> Outcome:
    """Compute the mean overpressure at one amplitude from the full Reynolds equation."""
    from slipscale.stimuli.film.squeeze_film import mean_overpressure

    ours = _film(amplitude_um_pp).overpressure
    closed = float(mean_overpressure(peak_from_pp(amplitude_um_pp), 0.6))
    return Outcome(
        published=None,
        ours=ours,
        unit="p0",
        reason=f"from the full equation (3); the closed form (13) gives {closed:.5f}, "
        f"{closed / ours:.2f} times as much",
        covers=("eq.3",),
    )


def _above_the_finger(closed_form: bool) -> float:
    """Return the proportion of the contact where film pressure exceeds finger pressure."""
    import numpy as np

    from slipscale.stimuli.film.reynolds import WorkingPoint, solve
    from slipscale.stimuli.film.squeeze_film import (
        AIR,
        FINGER,
        NORMAL_FORCE_N,
        mean_pressure,
    )

    length_mm = FINGER.contact_length_mm
    finger = 1 + NORMAL_FORCE_N / (length_mm * 1e-3) ** 2 / AIR.pressure_pa
    if closed_form:
        x = np.linspace(0, length_mm / 2, POSITIONS)
        over = mean_pressure(x, 3.0, 1.6) - finger
        left, right = over[:-1], over[1:]
        return float(np.clip(np.maximum(left, right) / np.abs(right - left), 0, 1).mean())
    state = solve(WorkingPoint(amplitude_um_peak=3.0, roughness_um=1.6, frequency_hz=40_000))
    return float(2 * state.width @ (state.mean_pressure > finger))


def _stimuli_figure(name: str) -> Figure:
    from slipscale.analysis.figures import squeeze_film

    figure: Figure = getattr(squeeze_film, name)()
    return figure


def draw_perception() -> Figure:
    """Plot the estimates in Table III against the friction that models predict."""
    from slipscale.analysis.figures.friction import perception_figure

    return perception_figure(
        [float(row.amplitude_um_pp) for row in TABLE3],
        [float(row.mean) for row in TABLE3],
        [float(row.standard_deviation) for row in TABLE3],
    )


# Values are computed, and large libraries imported, only on request.
ITEMS: Mapping[str, Callable[[], Outcome]] = {
    # Section IV-A
    "squeeze_number.30.5kHz": item(
        partial(_squeeze, 30_500, 1.15, 0.6),
        "15.9",
        "",
        "2.3 µm is peak to peak, so h_vib is 1.15 µm; computed with equation (4) and l0²",
        covers=("eq.4", "fig.13"),
    ),
    # Section II-C: the paper's criterion
    "fig3.25kHz": item(
        partial(_squeeze, 25_000, 3.0, 1.6),
        "> 10",
        "",
        "the paper requires more than 10; a value of 10 is reached at 21.4 kHz",
        rule=more_than(10),
        covers=("eq.4", "fig.3"),
    ),
    # Section II-C: zones in which the film lifts the finger
    "fig4.zones.closed_form": item(
        partial(_above_the_finger, closed_form=True),
        "> 0",
        "of contact",
        "with the closed form, the film pressure exceeds the contact pressure of the finger at "
        "0.5 N in some zones, as stated in the paper",
        rule=more_than(0),
        covers=("eq.13", "eq.14", "fig.4"),
    ),
    "fig4.zones.reynolds": item(
        partial(_above_the_finger, closed_form=False),
        "> 0",
        "of contact",
        "with the full equation (3) at 40 kHz, the mean film pressure is at most 1.035 p0, which "
        "is less than the finger's contact pressure of 1.05 p0 in all zones",
        rule=more_than(0),
        covers=("eq.3", "fig.4"),
    ),
    # Section II-D: the paper's guideline
    "fig5.hr0.6.hvib1.5": item(
        partial(_friction, 1.5, 0.6),
        "0.5",
        "µ'/µ",
        "closed form at 0.5 N; the paper states 'half of the relative friction coefficient'",
        covers=("eq.12", "eq.14", "eq.15", "fig.5"),
    ),
    # Section II-C: the plate with the highest roughness
    "fig5.hr1.6.hvib4": item(
        partial(_friction, 4.0, 1.6),
        "> 0",
        "µ'/µ",
        "friction is zero only above 4 µm; the value computed for 5 µm is below zero (levitation)",
        rule=more_than(0),
        covers=("eq.12", "eq.14", "eq.15", "fig.5"),
    ),
    **{f"reynolds.{pp}um": partial(reynolds, pp) for pp in (0.5, 1.2, 2.3)},
}

FIGURES: Mapping[str, Callable[[], Figure]] = {
    "fig3": partial(_stimuli_figure, "squeeze_number_figure"),
    "fig4": partial(_stimuli_figure, "film_figure"),
    "fig5": partial(_stimuli_figure, "friction_figure"),
    "reynolds": partial(_stimuli_figure, "closed_form_figure"),
    "perception": draw_perception,
}


if __name__ == "__main__":
    record(ITEMS, "film.json")
