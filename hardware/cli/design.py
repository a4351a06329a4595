"""Implement `slipscale plate design`."""

from __future__ import annotations

import json
import os
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.hardware.plate.design.requirements import Brief, DrawnPlate
    from slipscale.hardware.plate.design.sizing import Candidate, Design
    from slipscale.hardware.plate.design.verdict import Judged

from slipscale.faults import ANSWER_IS_NO, DONE


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale plate design``."""
    parser.add_argument(
        "brief",
        nargs="?",
        type=Path,
        help="TOML file with requirements and materials (docs/explanation/plate-models.md); "
        "default: the paper's plate",
    )
    parser.add_argument("--out", type=Path, help="folder for design.json and the figures")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    parser.add_argument(
        "--fe",
        metavar="LENGTHxCOLUMNS",
        help="also solve one plate on a finer mesh, e.g. 11x7: mode shape, resonance, amplitude",
    )
    parser.add_argument(
        "--fine",
        action="store_true",
        help=("with --fe: use an even finer mesh, which takes about ten times as long"),
    )


def run(arguments: Namespace) -> int:
    """Compute plate designs for the given requirements; return 1 if no plate meets them."""
    # Set before NumPy is imported: more threads are not faster for matrices of this size.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Imported late, to keep `slipscale plate --help` fast.
    from slipscale.hardware.plate.design import requirements as briefs
    from slipscale.hardware.plate.design.sizing import design
    from slipscale.hardware.plate.design.verdict import judge, judge_drawn, placed

    if arguments.fine and not arguments.fe:
        raise UserError("--fine refines the mesh of --fe: name a plate with --fe, e.g. --fe 11x7")
    brief = briefs.read(arguments.brief) if arguments.brief else briefs.Brief()
    for each in brief.plate:
        placed(brief, each)  # Checked before the finite-element solution, which takes seconds.
    found = design(brief)
    chosen = _chosen(brief, found, arguments.fe) if arguments.fe else None
    plates = [judge(brief, each, found.frequency_min_hz) for each in found.candidates]
    drawn = [judge_drawn(brief, each, found.frequency_min_hz) for each in brief.plate]
    result = _as_json(brief, found, plates)
    result["drawn_plates"] = [
        {"name": plate.name, **_verdict(each)}
        for plate, each in zip(brief.plate, drawn, strict=True)
    ]
    modes = None
    if chosen:
        modes, result["finite_elements"] = _solve(brief, found, chosen, fine=arguments.fine)
    if arguments.out:
        _write(arguments.out, brief, result, modes)
    print(json.dumps(result, indent=2) if arguments.json else _as_text(result, arguments.out))
    return DONE if any(each.admissible for each in (*plates, *drawn)) else ANSWER_IS_NO


def _solve(
    brief: Brief, found: Design, chosen: Candidate | DrawnPlate, *, fine: bool
) -> tuple[object, dict[str, object]]:
    from slipscale.hardware.plate.design.requirements import DrawnPlate
    from slipscale.hardware.plate.design.sizing import drawn_layout
    from slipscale.hardware.plate.design.verdict import judged, solve, solve_drawn
    from slipscale.hardware.plate.geometry import DEFAULT, DRAWN_MM, FINE, density_of

    if isinstance(chosen, DrawnPlate):
        density = density_of(drawn_layout(brief, chosen), DRAWN_MM[fine])
        modes, solution = solve_drawn(brief, chosen, density)
        name, place = chosen.name, "finger"
    else:
        name, place = _name(chosen), None
        modes, solution = solve(brief, chosen, FINE if fine else DEFAULT)
    verdict = judged(brief, solution, found.frequency_min_hz, place=place)
    return modes, {"plate": name, **_verdict(verdict)}


def _name(plate: Candidate) -> str:
    return f"{plate.ceramic_length_mm:g}x{plate.columns}"


def _chosen(brief: Brief, found: Design, plate: str) -> Candidate | DrawnPlate:
    known: dict[str, Candidate | DrawnPlate] = {_name(each): each for each in found.candidates}
    known |= {each.name: each for each in brief.plate}
    if plate not in known:
        raise UserError(
            "--fe {plate}: expected one of the plates listed: {known}",
            plate=plate,
            known=", ".join(known),
        )
    return known[plate]


def _as_json(brief: Brief, found: Design, plates: list[Judged]) -> dict[str, object]:
    from dataclasses import asdict

    return {
        "title": brief.title,
        "requirements": brief.requirements.model_dump(),
        **asdict(found),
        "candidates": [
            {**asdict(candidate), **_verdict(each)}
            for candidate, each in zip(found.candidates, plates, strict=True)
        ],
    }


def _verdict(judged: Judged) -> dict[str, object]:
    from dataclasses import asdict

    solution = asdict(judged.solution) if judged.solution else None
    if solution:
        places = solution.pop("amplitude_um_peak")
        solution |= {f"amplitude_{place}_um_peak": each for place, each in places.items()}
    return {
        "finite_elements": solution,
        "admissible": judged.admissible,
        "why_not": list(judged.why_not),
        "beyond_shipped_limits": list(judged.needs),
    }


def _as_text(result: dict[str, Any], out: Path | None) -> str:
    wanted = result["requirements"]
    low, high = result["half_wave_min_mm"], result["half_wave_max_mm"]
    lines = [
        (
            f"{result['title']}: {wanted['voltage_v']:g} V, "
            f"{wanted['amplitude_um_peak']:g} µm peak at the {wanted['finger_place']}, workspace "
            f"{wanted['workspace_mm'][0]:g} x {wanted['workspace_mm'][1]:g} mm"
        ),
        "",
        f"half-wavelength from {low:.2f} mm (shortest for this amplitude, eq. 37)",
        (
            f"                to   {high:.2f} mm (longest above "
            f"{result['frequency_min_hz'] / 1e3:.3g} kHz, Timoshenko beam; "
            f"{result['half_wave_max_printed_mm']:.2f} mm by eq. 38)"
        ),
        (
            f"relative friction at this amplitude and a roughness of {wanted['roughness_um']:g} "
            f"µm: {result['relative_friction']:.2f} by the Reynolds equation,"
        ),
        (
            f"          {result['relative_friction_closed_form']:.2f} by the paper's closed form"
            + ("" if result["closed_form_holds"] else " (not valid: squeeze number below 10)")
            + ","
        ),
        (
            "          "
            + " to ".join(f"{end:.2f}" for end in result["relative_friction_band"])
            + " if asperities and film share the load (not validated);"
        ),
        (
            "          the film models of Biet et al. (2007) ignore the finger's speed, assume a "
            "contact area of 1 cm² at any force, and predict almost no effect of frequency"
        ),
        "",
        ("                                      beam model (µm peak)   finite elements (µm peak)"),
        (
            "plate     ceramics  size (mm)       λ/2 (mm)  kHz    µm     "
            "kHz    middle edge  admissible"
        ),
    ]
    for c in result["candidates"]:
        name = f"{c['ceramic_length_mm']:g}x{c['columns']}"
        size = f"{c['length_mm']:g} x {c['width_mm']:g}"
        lines.append(
            f"{name:<9} {c['columns']} x {c['rows']:<5} {size:<15} {c['half_wave_mm']:<9.2f} "
            f"{c['frequency_hz'] / 1e3:<6.2f} {c['amplitude_um_peak']:<6.2f} "
            f"{_solution_as_text(c['finite_elements'])} "
            f"{'yes' if c['admissible'] else 'no: ' + '; '.join(c['why_not'])}"
        )
    if result["drawn_plates"]:
        lines += ["", "custom plates               kHz    µm peak: finger  largest  admissible"]
    for drawn in result["drawn_plates"]:
        fe = drawn["finite_elements"]
        lines.append(
            f"{drawn['name']:<26} {fe['resonance_hz'] / 1e3:<6.2f} "
            f"{fe['amplitude_finger_um_peak']:>15.2f}  {fe['amplitude_largest_um_peak']:<7.2f}  "
            f"{'yes' if drawn['admissible'] else 'no: ' + '; '.join(drawn['why_not'])}"
        )
    every = [*result["candidates"], *result["drawn_plates"]]
    solved = [each["finite_elements"] for each in every if each["finite_elements"]]
    if apart := [each["uncertainty"] for each in solved if each["uncertainty"] is not None]:
        lines += ["", f"Amplitudes of the last two meshes agree within {max(apart):.1%}."]
    admissible = [each for each in every if each["admissible"]]
    if not admissible:
        lines += ["", f"No plate meets the requirements: {_why_none(result)}."]
    for needed in sorted({each for c in admissible for each in c["beyond_shipped_limits"]}):
        lines += [
            "",
            f"This value is outside the limits that apply without a plate file: {needed}.",
        ]
    if "finite_elements" in result:
        fe = result["finite_elements"]
        solution = fe["finite_elements"]
        lines += [
            "",
            (
                f"finer mesh, {fe['plate']}: resonance {solution['resonance_hz'] / 1e3:.2f} kHz, "
                "amplitude in µm peak: "
                + ", ".join(
                    f"{solution[f'amplitude_{place}_um_peak']:.2f} {words}"
                    for place, words in _PLACES.items()
                    if f"amplitude_{place}_um_peak" in solution
                )
                + ", shorted electrodes: "
                + ("admissible" if fe["admissible"] else "; ".join(fe["why_not"]))
            ),
        ]
    if out:
        lines += ["", f"figures and design.json in {out}"]
    return "\n".join(lines)


_PLACES = {
    "edge": "at the edge",
    "middle": "in the middle",
    "finger": "at the finger",
    "largest": "at most",
}


def _solution_as_text(solution: dict[str, float] | None) -> str:
    if solution is None:
        return f"{'-':<6} {'-':<6} {'-':<5}"
    return (
        f"{solution['resonance_hz'] / 1e3:<6.2f} {solution['amplitude_middle_um_peak']:<6.2f} "
        f"{solution['amplitude_edge_um_peak']:<5.2f}"
    )


def _why_none(result: dict[str, Any]) -> str:
    if result["half_wave_min_mm"] > result["half_wave_max_mm"]:
        return (
            "the required amplitude needs a longer half-wavelength than the minimum frequency "
            "allows"
        )
    if not any(c["beam_admissible"] for c in result["candidates"]):
        return "no available ceramic gives a half-wavelength within the bounds"
    return "the last column states why the finite-element model excludes each plate"


def _write(out: Path, brief: Brief, result: dict[str, Any], modes: Any) -> None:
    from slipscale.figure_style import save
    from slipscale.hardware.plate.design import figures
    from slipscale.hardware.plate.design.sizing import sections
    from slipscale.hardware.plate.paper_study import harmonic

    printed, wide = sections(brief)
    wanted = brief.requirements
    drawn = {
        "deflection": figures.deflection_figure(
            printed, wanted.voltage_v, wanted.amplitude_um_peak
        ),
        "frequency": figures.frequency_figure(
            printed,
            wide,
            floor_hz=result["frequency_min_hz"],
            least_mm=result["half_wave_min_mm"],
        ),
    }
    if modes is not None:
        edge = harmonic(modes, voltage_v=wanted.voltage_v)
        drawn["mode"] = figures.mode_figure(modes)
        drawn["map"] = figures.amplitude_map_figure(modes, voltage_v=wanted.voltage_v)
        drawn["harmonic"] = figures.harmonic_figure(
            {"middle of the upper edge" if brief.plate else "edge antinode": edge},
            voltage_v=wanted.voltage_v,
        )
    try:
        out.mkdir(parents=True, exist_ok=True)
        (out / "design.json").write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
        for name, figure in drawn.items():
            for suffix in ("svg", "png"):
                save(figure, out / f"{name}.{suffix}")
    except OSError as error:
        raise UserError(
            "--out {out}: cannot be written: {reason}", out=out, reason=error.strerror
        ) from error


COMMANDS = {"design": (add_arguments, run)}
