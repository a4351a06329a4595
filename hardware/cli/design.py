"""`slipscale plate design`: from a brief in TOML to half waves, plate sizes and figures."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from faults import UserError

if TYPE_CHECKING:
    from argparse import ArgumentParser, Namespace

    from hardware.plate.design.requirements import Brief
    from hardware.plate.design.sizing import Candidate, Design

from faults import ANSWER_IS_NO, DONE


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line of ``slipscale plate design``."""
    parser.add_argument(
        "brief",
        nargs="?",
        type=Path,
        help="TOML file of requirements and materials "
        "(docs/plate-models.md); without it, the paper's",
    )
    parser.add_argument("--out", type=Path, help="folder for design.json and the figures")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    parser.add_argument(
        "--fe",
        metavar="LENGTHxCOLUMNS",
        help="solve one plate by finite elements too, e.g. 11x7: mode shape, resonance, amplitude",
    )
    parser.add_argument("--fine", action="store_true", help="with --fe: a mesh ten times dearer")


def run(arguments: Namespace) -> int:
    """Run the command; exit status 0, or 1 if no plate meets the brief."""
    # Imported here so that `slipscale plate --help` needs neither pydantic nor NumPy.
    from hardware.plate.design import requirements as briefs  # noqa: PLC0415
    from hardware.plate.design.sizing import design  # noqa: PLC0415

    if arguments.fine and not arguments.fe:
        raise UserError("--fine makes --fe's mesh finer: name a plate with --fe, e.g. --fe 11x7")
    brief = briefs.read(arguments.brief) if arguments.brief else briefs.Brief()
    found = design(brief)
    result = _as_json(brief, found)
    modes = None
    if arguments.fe:
        modes, result["finite_elements"] = _solve(brief, found, arguments.fe, fine=arguments.fine)
    if arguments.out:
        _write(arguments.out, brief, result, modes)
    print(json.dumps(result, indent=2) if arguments.json else _as_text(result, arguments.out))
    return DONE if found.admissible else ANSWER_IS_NO


def _solve(brief: Brief, found: Design, plate: str, *, fine: bool) -> tuple[Any, dict[str, Any]]:
    from hardware.plate.design.sizing import layout_of  # noqa: PLC0415
    from hardware.plate.geometry import DEFAULT, FINE  # noqa: PLC0415
    from hardware.plate.paper_study import harmonic, plate_modes  # noqa: PLC0415

    chosen = _candidate(found, plate)
    layout = layout_of(brief, chosen)
    modes = plate_modes(layout, near_hz=chosen.frequency_hz, density=FINE if fine else DEFAULT)
    voltage_v = brief.requirements.voltage_v
    edge = harmonic(modes, voltage_v=voltage_v)
    middle = harmonic(modes, voltage_v=voltage_v, where_mm=(layout.antinode_x_mm, 0.0))
    return modes, {
        "plate": plate,
        "resonance_hz": float(modes.frequency_hz[modes.driven]),
        "amplitude_edge_um_pp": edge.peak_um_pp,
        "amplitude_centre_um_pp": middle.peak_um_pp,
        "unknowns": int(3 * modes.parts.nodes.shape[1]),
    }


def _candidate(found: Design, plate: str) -> Candidate:
    known = {f"{c.ceramic_length_mm:g}x{c.columns}": c for c in found.candidates}
    if plate not in known:
        raise UserError(f"--fe {plate}: expected one of the plates listed: {', '.join(known)}")
    return known[plate]


def _as_json(brief: Brief, found: Design) -> dict[str, Any]:
    from dataclasses import asdict  # noqa: PLC0415

    return {"title": brief.title, "requirements": brief.requirements.model_dump(), **asdict(found)}


def _as_text(result: dict[str, Any], out: Path | None) -> str:
    wanted = result["requirements"]
    low, high = result["half_wave_min_mm"], result["half_wave_max_mm"]
    lines = [
        (
            f"{result['title']}: {wanted['voltage_v']:g} V, "
            f"{wanted['amplitude_um_peak']:g} µm peak, workspace "
            f"{wanted['workspace_mm'][0]:g} x {wanted['workspace_mm'][1]:g} mm"
        ),
        "",
        f"half wave from {low:.2f} mm (amplitude, eq. 37)",
        (
            f"          to   {high:.2f} mm "
            f"({result['frequency_min_hz'] / 1e3:.3g} kHz, Timoshenko; "
            f"{result['half_wave_max_printed_mm']:.2f} by eq. 38)"
        ),
        (
            f"relative friction at that amplitude on {wanted['roughness_um']:g} µm roughness: "
            f"{result['relative_friction']:.2f} by the Reynolds equation,"
        ),
        (
            f"          {result['relative_friction_closed_form']:.2f} by the paper's closed form"
            + ("" if result["closed_form_holds"] else " (squeeze number below 10: out of range)")
        ),
        "",
        "plate     ceramics  size (mm)       λ/2 (mm)  kHz    µm peak  σ     admissible",
    ]
    for c in result["candidates"]:
        name = f"{c['ceramic_length_mm']:g}x{c['columns']}"
        size = f"{c['length_mm']:g} x {c['width_mm']:g}"
        lines.append(
            f"{name:<9} {c['columns']} x {c['rows']:<5} {size:<15} {c['half_wave_mm']:<9.2f} "
            f"{c['frequency_hz'] / 1e3:<6.2f} {c['amplitude_um_peak']:<8.2f} "
            f"{c['squeeze_number']:<5.1f} {'yes' if c['admissible'] else 'no'}"
        )
    if not any(c["admissible"] for c in result["candidates"]):
        reason = (
            "the amplitude needs a longer half wave than the frequency allows"
            if low > high
            else "no ceramic at hand gives a half wave between the bounds"
        )
        lines += ["", f"No plate meets the brief: {reason}."]
    if "finite_elements" in result:
        fe = result["finite_elements"]
        lines += [
            "",
            (
                f"finite elements, {fe['plate']}: {fe['resonance_hz'] / 1e3:.2f} kHz, "
                f"{fe['amplitude_edge_um_pp']:.2f} µm p-p at the edge, "
                f"{fe['amplitude_centre_um_pp']:.2f} in the middle, shorted electrodes"
            ),
        ]
    if out:
        lines += ["", f"figures and design.json in {out}"]
    return "\n".join(lines)


def _write(out: Path, brief: Brief, result: dict[str, Any], modes: Any) -> None:
    from figure_style import save  # noqa: PLC0415
    from hardware.plate.design import figures  # noqa: PLC0415
    from hardware.plate.design.sizing import sections  # noqa: PLC0415
    from hardware.plate.paper_study import harmonic  # noqa: PLC0415

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
        drawn["harmonic"] = figures.harmonic_figure(
            {"edge antinode": edge}, voltage_v=wanted.voltage_v
        )
    try:
        out.mkdir(parents=True, exist_ok=True)
        (out / "design.json").write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
        for name, figure in drawn.items():
            for suffix in ("svg", "png"):
                save(figure, out / f"{name}.{suffix}")
    except OSError as error:
        raise UserError(f"--out {out}: cannot be written: {error.strerror}") from error


COMMANDS = {"design": (add_arguments, run)}
