import argparse
import json
import subprocess
import sys

import pytest

from slipscale.faults import UserError
from slipscale.hardware.cli.design import COMMANDS
from slipscale.hardware.plate.design import requirements as briefs
from slipscale.hardware.plate.design import verdict
from slipscale.hardware.plate.design.requirements import Brief
from slipscale.hardware.plate.design.sizing import design, layout_of
from slipscale.hardware.plate.design.verdict import Solution, converged, judged, solve
from slipscale.hardware.plate.geometry import QUICK, density_of

ADD_ARGUMENTS, RUN = COMMANDS["design"]


def command(*words):
    parser = argparse.ArgumentParser()
    ADD_ARGUMENTS(parser)
    return RUN(parser.parse_args(words))


def test_the_paper_s_brief_leads_to_the_paper_s_bounds_and_plate():
    found = design(Brief())
    assert round(found.half_wave_min_mm, 1) == 8.2  # Section III-B
    assert found.half_wave_max_printed_mm == pytest.approx(13.60, abs=0.005)
    admissible = {(c.ceramic_length_mm, c.columns) for c in found.beam_admissible}
    assert (11.0, 7) in admissible  # Section III-C-2: 83 x 49 mm of 11 mm ceramics
    assert all(length == 11.0 for length, _ in admissible)  # 15 mm ceramics are too slow
    prototype = next(c for c in found.candidates if (c.ceramic_length_mm, c.columns) == (11.0, 7))
    assert (prototype.length_mm, prototype.width_mm, prototype.rows) == (83.0, 49.0, 5)
    # Free-free half wave, within a percent of the finite elements' (8;0) mode.
    assert prototype.frequency_hz == pytest.approx(35.7e3, rel=0.01)


def test_friction_of_a_design_is_a_range_by_the_second_model():
    base, more = (
        design(Brief.model_validate({"requirements": {"amplitude_um_peak": peak}}))
        for peak in (0.5, 1.5)
    )
    least, most = base.relative_friction_band
    assert 0 <= least < most < 1
    assert more.relative_friction_band[1] < most


def test_every_plate_covers_the_workspace():
    found = design(Brief.model_validate({"requirements": {"workspace_mm": [80, 30]}}))
    assert all(c.length_mm >= 80 and c.width_mm >= 30 for c in found.candidates)


def test_squeeze_number_alone_sets_the_frequency_when_no_floor_is_asked_for():
    found = design(Brief.model_validate({"requirements": {"frequency_min_hz": 0}}))
    assert found.frequency_min_hz == pytest.approx(21.37e3, rel=1e-3)  # notes on Fig. 3


def test_more_amplitude_or_less_voltage_asks_for_a_longer_half_wave():
    base = design(Brief()).half_wave_min_mm
    far = Brief.model_validate({"requirements": {"amplitude_um_peak": 6.0, "normal_force_n": 5}})
    assert design(far).half_wave_min_mm > base
    quarter = Brief.model_validate({"requirements": {"voltage_v": 3.75}})
    assert design(quarter).half_wave_min_mm == pytest.approx(2 * base)


@pytest.fixture
def one_mesh(monkeypatch):
    """The coarsest mesh alone: what refinement adds has a test of its own."""
    monkeypatch.setattr(verdict, "BRICKS_MM", verdict.BRICKS_MM[:1])


@pytest.mark.usefixtures("one_mesh")
def test_the_verdict_is_the_finite_elements_at_the_place_of_the_finger(tmp_path, capsys):
    """The beam says yes to 1.5 µm peak on 107 x 49 mm; that plate makes 1.2 and 0.85 µm."""
    assert command() == 1
    said = capsys.readouterr().out
    assert "8.20 mm" in said
    assert "83 x 49" in said
    assert "0.00 to 0.84 if asperities and film share the load (not validated)" in said
    assert (
        "assume a contact area of 1 cm² at any force, and predict almost no effect of frequency"
        in said
    )
    assert "the last column states why the finite-element model excludes each plate" in said
    path = tmp_path / "edge.toml"
    path.write_text('[requirements]\nfinger_place = "edge"\n', encoding="utf-8")
    assert command(str(path), "--json") == 0
    found = json.loads(capsys.readouterr().out)
    plates = {f"{c['ceramic_length_mm']:g}x{c['columns']}": c for c in found["candidates"]}
    assert [name for name, c in plates.items() if c["beam_admissible"]][-1] == "11x9"
    meets = [name for name, c in plates.items() if c["admissible"]]
    assert meets == ["11x5", "11x6", "11x7", "11x8"]
    wide = plates["11x9"]
    assert wide["finite_elements"]["amplitude_edge_um_peak"] == pytest.approx(1.17, rel=0.06)
    assert wide["finite_elements"]["amplitude_middle_um_peak"] == pytest.approx(0.81, rel=0.07)
    assert wide["why_not"][0].startswith("the amplitude at the edge is 1.2")
    assert plates["11x7"]["beyond_shipped_limits"] == ["3 µm p-p (default limit: 2.5)"]


@pytest.mark.parametrize(
    "amplitude_um_peak, resonance_hz, missing, needed",
    [
        (1.0, 30e3, [], []),
        (1.0, 45e3, [], ["45.00 kHz (default limits: 25 to 40)"]),
        (
            1.0,
            24e3,
            ["the plate resonates at 24.00 kHz, but at least 25 kHz is required"],
            ["24.00 kHz"],
        ),
        (
            1.3,
            30e3,
            ["the amplitude at the middle is 1.20 µm peak, but 1.3 is required"],
            ["2.6 µm p-p"],
        ),
    ],
)
def test_a_solved_plate_is_held_against_brief_and_driver(
    amplitude_um_peak, resonance_hz, missing, needed
):
    brief = Brief.model_validate({"requirements": {"amplitude_um_peak": amplitude_um_peak}})
    solution = Solution(
        resonance_hz=resonance_hz,
        amplitude_um_peak={"middle": 1.2, "edge": 2.0},
        unknowns=1,
    )
    found = judged(brief, solution, 25_000)
    assert list(found.why_not) == missing
    assert found.admissible == (not missing)
    assert all(told.startswith(start) for told, start in zip(found.needs, needed, strict=True))


@pytest.mark.parametrize(
    "text, said",
    [
        ("[requirements]\nnormal_force_n = 0.01", "carries 0.17 N, more than the finger's 0.01 N"),
        ("[ceramic]\nquality_factor = 1e6", "ceramic.quality_factor: .*2000"),
        ("[requirements]\nworkspace_mm = [3000, 2000]", "workspace_mm.*300"),
        ("[requirements]\namplitude_um_peak = 500", "amplitude_um_peak: .*20"),
        ("[ceramic]\nlengths_mm = [0.1]", "lengths_mm.* 2"),
    ],
)
def test_what_no_plate_can_do_is_refused_with_what_is_wrong(tmp_path, text, said):
    path = tmp_path / "brief.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UserError, match=said):
        command(str(path))


def test_impossible_brief_ends_with_status_1_and_the_reason(tmp_path, capsys):
    path = tmp_path / "strong.toml"
    path.write_text(
        "[requirements]\namplitude_um_peak = 9.0\nnormal_force_n = 5\n", encoding="utf-8"
    )
    assert command(str(path)) == 1
    assert "longer half-wavelength than the minimum frequency allows" in capsys.readouterr().out


@pytest.mark.usefixtures("one_mesh")
def test_command_writes_json_and_figures_with_finite_elements(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("slipscale.hardware.plate.geometry.DEFAULT", QUICK)
    out = tmp_path / "plate"
    assert command("--json", "--fe", "11x5", "--out", str(out)) == 1
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((out / "design.json").read_text(encoding="utf-8"))
    assert printed["finite_elements"]["finite_elements"]["resonance_hz"] == pytest.approx(
        36e3, rel=0.03
    )
    names = ("deflection", "frequency", "mode", "map", "harmonic")
    written = {path.name for path in out.iterdir()}
    assert written == {"design.json"} | {f"{n}.{s}" for n in names for s in ("svg", "png")}


@pytest.mark.parametrize(
    "words, said",
    [
        (["--fe", "12x3"], "--fe 12x3: expected one of the plates listed: 11x5"),
        (["--fine"], "name a plate with --fe"),
        (["nowhere.toml"], "nowhere.toml: cannot be read"),
    ],
)
def test_wrong_command_is_refused_in_a_sentence(words, said):
    with pytest.raises(UserError, match=said):
        command(*words)


def test_every_fault_of_a_brief_is_named_at_once(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        "[requirements]\nvoltage_v = 30\nspeed = 1\n"
        "[ceramic]\nthickness_mm = -1.0\nlengths_mm = []\n"
        "[resonator]\npoisson = 0.7\n",
        encoding="utf-8",
    )
    with pytest.raises(UserError) as caught:
        briefs.read(path)
    said = str(caught.value)
    assert f"{path} has 5 faults" in said
    assert "line 2, requirements.voltage_v: must be above 0 and at most" in said
    for place in ("requirements.speed", "ceramic.thickness_mm", "ceramic.lengths_mm"):
        assert place in said
    assert "line 8, resonator.poisson: " in said


@pytest.mark.parametrize("value", ["nan", "inf", "-1", '"much"'])
def test_numbers_that_are_none_are_refused(tmp_path, value):
    path = tmp_path / "brief.toml"
    path.write_text(f"[resonator]\nyoung_pa = {value}\n", encoding="utf-8")
    with pytest.raises(UserError, match=r"resonator\.young_pa"):
        briefs.read(path)


def test_text_that_is_no_toml_is_refused(tmp_path):
    path = tmp_path / "brief.toml"
    path.write_text("voltage = = 3", encoding="utf-8")
    with pytest.raises(UserError, match="is not TOML"):
        briefs.read(path)


def test_ceramic_that_is_not_positive_definite_is_refused_by_name():
    soft = [[-1e10 if i == j else 0.0 for j in range(6)] for i in range(6)]
    brief = Brief.model_validate({"ceramic": {"name": "PZT-X", "full": {"stiffness_pa": soft}}})
    with pytest.raises(UserError, match="PZT-X: stiffness_pa is not positive definite"):
        design(brief)


def test_help_needs_no_heavy_import():
    code = (
        "import sys; import slipscale.hardware.cli.design; "
        "print([m for m in ('numpy', 'scipy', 'skfem', 'matplotlib', 'pydantic') "
        "if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_plate_is_refined_until_its_amplitude_converges():
    """A ceramic 30 mm wide: 44 % between the first two meshes that were once compared."""
    brief = Brief.model_validate(
        {"ceramic": {"width_mm": 30.0, "lengths_mm": [11.0]},
         "requirements": {"workspace_mm": [30.0, 25.0]}}
    )  # fmt: skip
    plate = next(each for each in design(brief).candidates if each.beam_admissible)
    layout = layout_of(brief, plate)
    solution = converged(layout, lambda density: solve(brief, plate, density))
    _, finer = solve(brief, plate, density_of(layout, 1.3))
    assert solution.uncertainty <= 0.04
    for place in ("middle", "edge"):
        assert solution.amplitude_um_peak[place] == pytest.approx(
            finer.amplitude_um_peak[place], rel=0.06
        )


def test_a_plate_whose_meshes_disagree_is_not_admissible():
    amplitudes = {"middle": 2.0, "edge": 2.0}
    solution = Solution(
        resonance_hz=35e3, amplitude_um_peak=amplitudes, unknowns=1, uncertainty=0.2
    )
    told = judged(Brief(), solution, 25_000)
    assert "the amplitude is uncertain by 20%" in "; ".join(told.why_not)


def test_a_border_of_the_resonator_enlarges_the_plate_and_not_the_ceramics():
    plain = briefs.Brief()
    wide = plain.model_copy(
        update={"resonator": plain.resonator.model_copy(update={"border_mm": (4.0, 2.5)})}
    )
    first, other = design(plain).candidates[0], design(wide).candidates[0]
    sizes = (other.length_mm - first.length_mm, other.width_mm - first.width_mm)
    assert sizes == (8.0, 5.0)
    assert other.half_wave_mm == first.half_wave_mm
    assert layout_of(wide, other).ceramic_length_mm == first.ceramic_length_mm == 11.0
