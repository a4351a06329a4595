"""The page "The paper", generated from the items of `slipscale reproduce`.

Each part of the paper (equation, table, figure) has a row per item that covers it, and the place of
its code. Figures are drawn when the site is built.
"""

from __future__ import annotations

from functools import cache

from slipscale import figure_style
from slipscale.analysis.reproduction.comparison import Comparison, compare, sources
from tools.site.tables import table

FOLDER = "validation"
FILM, CLOSED = "slipscale.stimuli.film.infinite_squeeze", "slipscale.stimuli.film.squeeze_film"
BEAM, BENT = "slipscale.hardware.plate.beam.BeamSection", "slipscale.hardware.plate.bending.Bending"
STUDY = "slipscale.hardware.plate.paper_study"
DRAWN = "slipscale.analysis.figures.drawings"
FINGER, GAS = f"{CLOSED}.Finger", f"{CLOSED}.Gas"
#: What each part is, in our words, and the place of its code.
EQUATIONS: dict[int, tuple[str, str]] = {
    1: ("film thickness h", f"{CLOSED}.film_thickness_um"),
    2: ("normalised thickness H, with ε, δ and k", f"{FILM}.thickness"),
    3: ("Reynolds equation of the film", "slipscale.stimuli.film.reynolds.solve"),
    4: ("squeeze number σ", f"{CLOSED}.squeeze_number"),
    5: ("steady film for σ → ∞", f"{FILM}.flux"),
    6: ("mean thickness H̄", f"{FILM}.mean_thickness"),
    7: ("solution Ψ∞² with the constant K1", f"{FILM}.psi_squared"),
    8: ("K1 from the edges", f"{FILM}.k1_of_edge"),
    9: ("Ψ∞ inside the contact", f"{FILM}.psi"),
    10: ("Ψ∞B² at the edges", f"{FILM}.edge_squared"),
    11: ("pressure P∞", f"{FILM}.pressure"),
    12: ("squeeze force F_s", f"{CLOSED}.mean_overpressure"),
    13: ("mean pressure over a period", f"{CLOSED}.mean_pressure"),
    14: ("finger pressure P_f = F_f/l0²", f"{CLOSED}.friction_from"),
    15: ("relative friction µ'/µ", f"{CLOSED}.relative_friction"),
    16: ("displacements", f"{BENT}.axial_displacement_um"),
    17: ("radius of curvature ρ", f"{BENT}.curvature_per_m"),
    18: ("strain S_xx", f"{BENT}.strain"),
    19: ("stress in the resonator", f"{BENT}.resonator_stress_pa"),
    20: ("constitutive equations", "slipscale.hardware.plate.materials.Piezoceramic"),
    21: ("stress in both layers", f"{BENT}.ceramic_stress_pa"),
    22: ("moment of all stresses", f"{BENT}.moment_n"),
    23: ("moments in balance", f"{BENT}.actuation_n"),
    24: ("curvature c", f"{BENT}.curvature_per_m"),
    25: ("1/a", f"{BEAM}.inverse_a"),
    26: ("α, β and f0", f"{BEAM}.alpha"),
    27: ("deflection w(x)", f"{BENT}.deflection_um"),
    28: ("static deflection at λ/4", f"{BEAM}.static_deflection_um"),
    29: ("amplification Q from energies", f"{BENT}.quality_factor"),
    30: ("energy of the ceramic", f"{BENT}.ceramic_energy_j_m"),
    31: ("energy of the ceramic, closed form", f"{BENT}.ceramic_energy_j_m"),
    32: ("energy of the section", f"{BENT}.energy_j_m"),
    33: ("energy of the section, integrals", f"{BENT}.energy_j_m"),
    34: ("energy and work of the contraction", f"{BENT}.work_j_m"),
    35: ("energy of the section, closed form", f"{BENT}.energy_j_m"),
    36: ("amplification Q, closed form", f"{BEAM}.quality_factor"),
    37: ("dynamic deflection", f"{BEAM}.dynamic_deflection_um_peak"),
    38: ("resonance frequency", f"{BEAM}.frequency_hz"),
    39: ("mass per length M_b", f"{BEAM}.mass_kg_m2"),
    40: ("flexural rigidity G_b", f"{BEAM}.rigidity_n_m"),
    41: ("condition for the neutral line", f"{BENT}.axial_force_n_m"),
    42: ("neutral line z0", f"{BEAM}.neutral_ratio"),
    43: ("first integral of (5)", f"{FILM}.flux"),
    44: ("slope for K = 0", f"{FILM}.relative_slope"),
    45: ("Ψ1² with K1(X)", f"{FILM}.psi_squared"),
    46: ("K1'(X)", f"{FILM}.slope_of_k1"),
    47: ("(43) at -X", f"{FILM}.flux"),
}
TABLES: dict[int, tuple[str, str]] = {
    1: ("constants of finger, plate and air", FINGER),
    2: ("constants of the plate", "slipscale.hardware.plate.materials"),
    3: ("mean, maximum deviation and SD of the estimates", "slipscale.analysis.published.biet2007"),
}
_FILM_FIGURES = "slipscale.analysis.figures.squeeze_film"
_PLATE_FIGURES = "slipscale.hardware.plate.design.figures"
FIGURES: dict[int, tuple[str, str]] = {
    1: ("the actuator: ceramics below, touch surface above", f"{DRAWN}.plate_figure"),
    2: ("profile of a fingertip with ridges", f"{DRAWN}.profile_figure"),
    3: ("squeeze number against frequency", f"{_FILM_FIGURES}.squeeze_number_figure"),
    4: ("film thickness, and mean pressure under the finger", f"{_FILM_FIGURES}.film_figure"),
    5: ("relative friction against amplitude", f"{_FILM_FIGURES}.friction_figure"),
    6: ("the half-wavelength section as a supported beam", f"{DRAWN}.section_figure"),
    7: ("the section bent by its ceramic", f"{DRAWN}.bending_figure"),
    8: ("dynamic deflection against half-wavelength", f"{_PLATE_FIGURES}.deflection_figure"),
    9: ("resonance frequency against half-wavelength", f"{_PLATE_FIGURES}.frequency_figure"),
    10: ("mesh of the finite-element model", f"{DRAWN}.mesh_figure"),
    11: ("shape of the (8;0) mode", f"{_PLATE_FIGURES}.mode_figure"),
    12: ("harmonic response", f"{_PLATE_FIGURES}.harmonic_figure"),
    13: ("measured mode, as the model predicts it", f"{DRAWN}.measured_mode_figure"),
    14: ("set-up of the experiment", f"{DRAWN}.bench_figure"),
    15: ("mean estimates against amplitude", "slipscale.analysis.tasks.estimation.figures.fig15"),
}
#: Statements of Section IV-B, in our words, and what a session of the study biet2007 does.
SENTENCES: tuple[tuple[str, str], ...] = (
    ("The plate's upper side is touched.", "The plate file describes this side; see Fig. 1."),
    (
        "Twelve naive students aged 18 to 25 take part, nine men and three women.",
        "`participants = 12`; participants state their age band and gender.",
    ),
    (
        "Everyone wears closed headphones, which mask the sound of friction.",
        (
            "Masking noise plays in the headphones if there is a sound device (`masking_noise` "
            "with `required = false`); otherwise, as in a pilot, the journal records that it is "
            "absent. The paper mentions no noise."
        ),
    ),
    (
        "The hand is in a box, with the elbow in front of the opening.",
        "The experimenter arranges this; the session does not record it.",
    ),
    (
        "The index finger strokes the plate backwards, in a straight line.",
        (
            "The instructions ask for a backward motion of the index finger, but not for a "
            "straight line. With a contact sensor, position and force are recorded."
        ),
    ),
    (
        "There are four surfaces: 0, 0.5, 1.2 and 2.3 µm peak to peak.",
        "`amplitudes_um_pp`; the amplitude commanded and read back is in every row.",
    ),
    (
        "In the first test, the amplitude decreases.",
        (
            "Task `descending_difference`, one series from the largest amplitude. One catch step "
            "per series is added, which the paper does not have."
        ),
    ),
    ("People state whether they feel a difference.", "A yes/no question after every step."),
    (
        "Whoever says yes is asked what has been removed.",
        "An open question with these words; answers are coded with a codebook.",
    ),
    (
        "All people feel the difference at once and call it less slippery.",
        "The report counts yes answers per step, and coded reports.",
    ),
    (
        "In the second experiment, people judge how slippery the plate is.",
        "Task `magnitude_estimation`: a number for every surface.",
    ),
    ("Each surface is rated after exploration.", "The question follows the exploration."),
    (
        "Surfaces come in random order.",
        (
            "Blocks in random order, from the seed. The paper states neither repetitions nor "
            "practice; the study has one repetition and one practice trial per amplitude."
        ),
    ),
    (
        "Estimates were multiplied to bring them to 100.",
        (
            "Participants first state the top of their scale, and estimates are divided by it. "
            "Other rules are possible; scaling each person's largest estimate to 100 contradicts "
            "Table III."
        ),
    ),
    (
        "Table III and Fig. 15 show the results.",
        "`table3.csv` and `fig15`, with the same statistics, next to the paper's values.",
    ),
)


@cache
def pages() -> dict[str, str]:
    """Return the page and its figures."""
    compared = compare()
    parts = [_introduction(compared), "## Equations\n\n" + _covered("eq", EQUATIONS, compared)]
    parts.append("## Tables\n\n" + _covered("table", TABLES, compared))
    parts.append("## Figures")
    drawn = {name: draw for source in sources() for name, draw in source.FIGURES.items()}
    files = {}
    for number, (what, _) in FIGURES.items():
        name = f"fig{number}"
        files[f"{FOLDER}/paper/{name}.svg"] = figure_style.svg(drawn[name](), salt=name)
        items = _covered("fig", {number: FIGURES[number]}, compared)
        parts.append(f"### Fig. {number}\n\n![Fig. {number}: {what}](paper/{name}.svg)\n\n{items}")
    rows = [list(row) for row in SENTENCES]
    session = table(["Section IV-B", "session of the study `biet2007`"], rows)
    parts.append(f"## The experiments, statement by statement\n\n{session}")
    files[f"{FOLDER}/the-paper.md"] = "\n\n".join(parts) + "\n"
    return files


def _introduction(compared: list[Comparison]) -> str:
    groups = [one.outcome.group for one in compared]
    elsewhere = sum(not one.outcome.covers for one in compared)
    return f"""# The paper

This page compares M. Biet, F. Giraud and B. Lemaire-Semail, "Squeeze Film Effect for the Design of
an Ultrasonic Tactile Plate" (IEEE T-UFFC 54(12), 2007) with Slipscale, equation by equation. It is
built from the items of `slipscale reproduce`.

- {groups.count("agrees")} independent items agree with the paper.
- {groups.count("differs")} independent items differ, for the stated reasons.
- {groups.count("by construction")} items agree by construction, which is no evidence:
  definitions, and values set to the published ones or computed from other numbers in the paper.
- For {groups.count("not published")} items, the paper gives no number.
  {elsewhere} of them are only printed by `slipscale reproduce`, because they are about the data
  sets that are consistent with Table III.

An equation's value is the relative difference between the equation as printed, with its signs,
factors and units, and a separate evaluation, so 0 means that the print is right."""


def _covered(kind: str, places: dict[int, tuple[str, str]], compared: list[Comparison]) -> str:
    rows = []
    for number, (what, place) in places.items():
        # The last two names identify the code; the file has the name of the module.
        part = f"**{number}** {what}, `{'.'.join(place.split('.')[-2:])}`"
        for one in compared:
            if f"{kind}.{number}" not in one.outcome.covers:
                continue
            outcome = one.outcome
            rows.append(
                [
                    part,
                    outcome.published or "–",
                    f"{outcome.shown} {outcome.unit}",
                    f"**{outcome.group}** (`{one.item}`): {outcome.reason}",
                ]
            )
            part = ""
    return table(["part and code", "paper", "computed", "agreement"], rows)
