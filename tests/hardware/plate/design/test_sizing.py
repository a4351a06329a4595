import argparse
import json
import subprocess
import sys

import pytest

from faults import UserError
from hardware.cli.design import COMMANDS
from hardware.plate.design import requirements as briefs
from hardware.plate.design.requirements import Brief
from hardware.plate.design.sizing import design
from hardware.plate.geometry import QUICK

ADD_ARGUMENTS, RUN = COMMANDS["design"]


def command(*words):
    parser = argparse.ArgumentParser()
    ADD_ARGUMENTS(parser)
    return RUN(parser.parse_args(words))


def test_the_paper_s_brief_leads_to_the_paper_s_bounds_and_plate():
    found = design(Brief())
    assert round(found.half_wave_min_mm, 1) == 8.2  # Section III-B
    assert found.half_wave_max_printed_mm == pytest.approx(13.60, abs=0.005)
    admissible = {(c.ceramic_length_mm, c.columns) for c in found.admissible}
    assert (11.0, 7) in admissible  # Section III-C-2: 83 x 49 mm of 11 mm ceramics
    assert all(length == 11.0 for length, _ in admissible)  # 15 mm ceramics are too slow
    prototype = next(c for c in found.candidates if (c.ceramic_length_mm, c.columns) == (11.0, 7))
    assert (prototype.length_mm, prototype.width_mm, prototype.rows) == (83.0, 49.0, 5)
    # Free-free half wave, within a percent of the finite elements' (8;0) mode.
    assert prototype.frequency_hz == pytest.approx(35.7e3, rel=0.01)


def test_every_plate_covers_the_workspace():
    found = design(Brief.model_validate({"requirements": {"workspace_mm": [80, 30]}}))
    assert all(c.length_mm >= 80 and c.width_mm >= 30 for c in found.candidates)


def test_squeeze_number_alone_sets_the_frequency_when_no_floor_is_asked_for():
    found = design(Brief.model_validate({"requirements": {"frequency_min_hz": 0}}))
    assert found.frequency_min_hz == pytest.approx(21.37e3, rel=1e-3)  # notes on Fig. 3


def test_more_amplitude_or_less_voltage_asks_for_a_longer_half_wave():
    base = design(Brief()).half_wave_min_mm
    assert (
        design(Brief.model_validate({"requirements": {"amplitude_um_peak": 6.0}})).half_wave_min_mm
        > base
    )
    assert design(Brief.model_validate({"requirements": {"voltage_v": 3.75}})).half_wave_min_mm == (
        pytest.approx(2 * base)
    )


def test_command_prints_the_candidates_and_succeeds(capsys):
    assert command() == 0
    said = capsys.readouterr().out
    assert "8.20 mm" in said
    assert "83 x 49" in said


def test_impossible_brief_ends_with_status_1_and_the_reason(tmp_path, capsys):
    path = tmp_path / "strong.toml"
    path.write_text("[requirements]\namplitude_um_peak = 9.0\n", encoding="utf-8")
    assert command(str(path)) == 1
    assert "longer half wave than the frequency allows" in capsys.readouterr().out


def test_command_writes_json_and_figures_with_finite_elements(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("hardware.plate.geometry.DEFAULT", QUICK)
    out = tmp_path / "plate"
    assert command("--json", "--fe", "11x5", "--out", str(out)) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((out / "design.json").read_text(encoding="utf-8"))
    assert printed["finite_elements"]["resonance_hz"] == pytest.approx(36e3, rel=0.03)
    names = ("deflection", "frequency", "mode", "harmonic")
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
    assert "line 2, requirements.voltage_v: is beyond the safe limit, expected above 0, at" in said
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
        "import sys; import hardware.cli.design; "
        "print([m for m in ('numpy', 'scipy', 'skfem', 'matplotlib', 'pydantic') "
        "if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
