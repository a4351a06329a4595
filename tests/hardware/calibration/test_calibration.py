import csv
import datetime as dt
import math
import tomllib

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy import stats

import slipscale
from faults import UserError
from hardware.backends.mock import MockPlate
from hardware.calibration.fit import fit_gain, fit_resonance, response
from hardware.calibration.record import (
    OLD_DAYS,
    Calibration,
    Device,
    DriveChain,
    Point,
    Provenance,
    read_calibration,
    to_toml,
    write_calibration,
)
from hardware.calibration.sweep import SweepPlan, calibration_from, sweep
from hardware.cli.calibrate import CSV_COLUMNS, read_back
from hardware.clock import VirtualClock
from hardware.errors import OverLimit
from hardware.plate.dynamics import Resonator
from hardware.plate.twin import Surroundings, Twin
from hardware.records import PlateIdentity
from hardware.registry import open_plate
from stimuli.surface import VirtualSurface

STEADY = Surroundings(warm_up_k=0, wander_k=0)


def calibrated(twin):
    plate = MockPlate(clock=VirtualClock(), twin=twin)
    plate.connect()
    points = sweep(SweepPlan(), lambda hz, v: read_back(plate, hz, v))
    return calibration_from(
        points,
        device=Device(backend="mock", serial="twin"),
        made=Provenance(date=dt.date(2026, 11, 21), by="a test", instrument="the twin's own"),
        drive=DriveChain(),
    )


@pytest.fixture(scope="module")
def calibration():
    return calibrated(Twin(seed=1))


def test_the_stated_uncertainties_cover_the_truth_as_often_as_they_say():
    """95 % intervals over 200 seeds: the number of misses lies where the binomial puts it."""
    seeds = 200
    misses = np.zeros(3, int)
    for seed in range(seeds):
        found = calibrated(Twin(seed=seed, surroundings=STEADY))
        resonance, gain = found.resonance, found.gain
        misses += [
            abs(resonance.frequency_hz - 30_500) > resonance.frequency_ci95_hz,
            abs(resonance.quality_factor - 60) > resonance.quality_factor_ci95,
            abs(gain.um_pp_per_v - 2.3 / 15) > gain.um_pp_per_v_ci95,
        ]
    fewest, most = stats.binom.ppf([0.0005, 0.9995], seeds, 0.05)
    assert np.all((misses >= fewest) & (misses <= most)), misses


def test_a_plate_in_a_room_that_warms_is_recovered_too(calibration):
    """Section IV-A: 30.5 kHz, and 2.3 µm p-p at 15 V. Warmth moves the resonance some hertz."""
    assert calibration.resonance.frequency_hz == pytest.approx(30_500, abs=6)
    assert calibration.gain.um_pp_per_v * 15 == pytest.approx(2.3, rel=0.005)
    assert calibration.resonance.quality_factor == pytest.approx(60, rel=0.05)


def test_another_plate_is_found_where_it_is():
    twin = Twin(surroundings=STEADY, resonator=Resonator(resonance_hz=31_200, quality_factor=180))
    resonance = calibrated(twin).resonance
    assert resonance.frequency_hz == pytest.approx(31_200, abs=3)
    assert resonance.quality_factor == pytest.approx(180, rel=0.05)


def test_volts_are_the_inverse_of_micrometres(calibration):
    assert calibration.voltage_v(2.3) == pytest.approx(15, rel=0.005)


def test_the_file_is_read_as_it_was_written(calibration, tmp_path):
    path = tmp_path / "plate.toml"
    write_calibration(calibration, path)
    assert read_calibration(path) == calibration


@given(st.text(st.characters(exclude_categories=["Cs"])))
@example("\x7f")
def test_any_text_in_a_file_is_read_as_it_was_written(calibration, text):
    made = calibration.made.model_copy(update={"by": text})
    named = calibration.model_copy(update={"made": made})
    assert Calibration.model_validate(tomllib.loads(to_toml(named))) == named


def test_a_driver_refuses_what_was_not_calibrated(tmp_path):
    plate = MockPlate(clock=VirtualClock(), twin=Twin())
    plate.connect()
    plan = SweepPlan(max_voltage_v=10)
    points = sweep(plan, lambda hz, v: read_back(plate, hz, v))
    narrow = calibration_from(
        points,
        device=Device(backend="mock", serial="twin"),
        made=Provenance(date=dt.date(2026, 11, 21), by="a test", instrument="the twin's own"),
        drive=DriveChain(),
    )
    path = tmp_path / "plate.toml"
    write_calibration(narrow, path)
    with open_plate(f"mock:calibration={path}", clock=VirtualClock()) as driver:
        driver.present(VirtualSurface(amplitude_um_pp=1.5))
        with pytest.raises(OverLimit, match=r"outside 0 to 1\.5"):
            driver.present(VirtualSurface(amplitude_um_pp=1.6))
        assert driver.describe()["calibration"]["made"]["by"] == "a test"


def test_an_old_calibration_and_one_of_another_plate_are_told(calibration):
    this = PlateIdentity(manufacturer="", model="", serial="twin", firmware="")
    other = PlateIdentity(manufacturer="", model="", serial="0042", firmware="")
    today = calibration.made.date
    later = today + dt.timedelta(days=OLD_DAYS + 1)
    assert calibration.notes(this, today) == ()
    assert calibration.notes(other, today) == (
        "the calibration belongs to plate 'twin', this is '0042'",
    )
    assert calibration.notes(this, later) == ("the calibration is 181 days old; calibrate anew",)


@pytest.mark.parametrize(
    "damage, said",
    [
        (lambda text: text.replace("um_pp_per_v = ", "um_pp_per_v = -"), "gain.um_pp_per_v"),
        (lambda text: text.replace("by = ", "# by = "), "made.by: Field required"),
        (lambda text: text.replace("frequency_hz = ", "frequency_hz = nan # ", 1), "resonance"),
        (lambda text: text.replace("voltage_max_v = 16.0", "voltage_max_v = 99.0"), "beyond"),
        (lambda text: text.replace("[gain]", "[gian]"), "gain: Field required; gian: Extra"),
        (lambda text: text.replace("[device]", "[device"), "not a TOML file"),
        (lambda text: text.replace('"V peak"', '"volts"'), "drive.voltage_convention"),
    ],
)
def test_a_file_with_a_fault_is_refused_with_the_place(calibration, tmp_path, damage, said):
    path = tmp_path / "plate.toml"
    text = to_toml(calibration)
    assert damage(text) != text
    path.write_text(damage(text), encoding="utf-8")
    with pytest.raises(UserError, match=r"plate\.toml") as caught:
        read_calibration(path)
    assert said in str(caught.value)


def test_no_such_file(tmp_path):
    with pytest.raises(UserError, match="No such file"):
        read_calibration(tmp_path / "none.toml")


def points(sweep_name, frequencies, amplitude):
    return [
        Point(sweep=sweep_name, frequency_hz=hz, voltage_v=1, amplitude_um_pp=amplitude(hz))
        for hz in frequencies
    ]


def test_a_resonance_has_three_parameters_and_a_gain_one():
    """Residuals are divided by readings less parameters: by hand, on seven scattered readings."""
    noise = np.array([3, -2, 4, -1, -4, 2, -3]) * 1e-3
    hz = np.linspace(30_000, 31_000, 7)
    clean = response(hz, 30_500, 60, 0.15)
    scattered = points("fine", hz, dict(zip(hz, clean + noise, strict=True)).get)
    peak = fit_resonance(scattered)
    found = peak.resonance
    left = (
        clean
        + noise
        - response(hz, found.frequency_hz, found.quality_factor, peak.height_um_pp_per_v)
    )
    assert found.residual_um == pytest.approx(math.sqrt(left @ left / (7 - 3)), rel=1e-9)
    volts = np.arange(1.0, 8.0)
    line = [
        Point(sweep="voltage", frequency_hz=3e4, voltage_v=v, amplitude_um_pp=um)
        for v, um in zip(volts, 0.15 * volts + noise, strict=True)
    ]
    gain = fit_gain(line)
    left = 0.15 * volts + noise - gain.um_pp_per_v * volts
    assert gain.residual_um == pytest.approx(math.sqrt(left @ left / (7 - 1)), rel=1e-9)


def test_a_sweep_beside_the_resonance_is_refused():
    beside = points(
        "coarse",
        np.linspace(26_000, 27_000, 30),
        lambda hz: 0.15 / math.sqrt(1 + (120 * (hz - 30_500) / 30_500) ** 2),
    )
    with pytest.raises(UserError, match="no peak between 26000 and 27000 Hz"):
        fit_resonance(beside)


def test_a_plate_that_does_not_respond_is_refused():
    dead = [Point(sweep="voltage", frequency_hz=3e4, voltage_v=v, amplitude_um_pp=0)
            for v in range(8)]  # fmt: skip
    with pytest.raises(UserError, match="does not respond"):
        fit_gain(dead)
    with pytest.raises(UserError, match="5 points, expected 6"):
        fit_gain(dead[:5])


WORDS = ["plate", "calibrate", "--by", "T. Ester", "--instrument", "OFV-505, 2 µm/V"]


def test_the_command_writes_a_file_and_a_plot(tmp_path, capsys):
    out = tmp_path / "plate.toml"
    assert slipscale.main([*WORDS, "--out", str(out)]) == 0
    assert "resonance  30497.8 ± 2.3 Hz" in capsys.readouterr().out
    assert read_calibration(out).made.instrument == "OFV-505, 2 µm/V"
    assert out.with_suffix(".png").read_bytes().startswith(b"\x89PNG")


def test_a_file_that_cannot_be_written_is_told_before_anything_is_measured(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr("builtins.input", lambda _: pytest.fail("a reading was asked for"))
    known = tmp_path / "plate.toml"
    known.write_text("data rest on it")
    for out, complaint in ((known, "exists already"), (tmp_path / "no" / "x.toml", "a folder")):
        assert slipscale.main([*WORDS, "--prompt", "--out", str(out)]) == 2
        assert complaint in capsys.readouterr().err
    assert known.read_text() == "data rest on it"


def test_readings_typed_at_a_prompt_give_the_calibration(tmp_path, monkeypatch, capsys):
    truth = Twin(surroundings=STEADY, noise_um=0)

    def type_it(prompt):
        hz, volts = (float(word.split()[0]) for word in prompt.split(":")[0].split(","))
        answers = {"first": "two or so"} if not asked else {}
        asked.append(prompt)
        amplitude = abs(truth.conditions(0).response_um_pp_per_v(hz)) * volts
        return answers.get("first", f"{amplitude:.3f}".replace(".", ","))

    asked = []
    monkeypatch.setattr("builtins.input", type_it)
    out = tmp_path / "plate.toml"
    assert slipscale.main([*WORDS, "--prompt", "--out", str(out)]) == 0
    assert "'two or so' is no reading" in capsys.readouterr().out
    assert read_calibration(out).resonance.frequency_hz == pytest.approx(30_500, abs=1)


def test_readings_in_a_csv_give_the_same_calibration_as_measured_ones(calibration, tmp_path):
    table = tmp_path / "readings.csv"
    with table.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(CSV_COLUMNS)
        for point in calibration.points:
            writer.writerow([getattr(point, name) for name in CSV_COLUMNS])
    out = tmp_path / "plate.toml"
    assert slipscale.main([*WORDS, "--csv", str(table), "--out", str(out)]) == 0
    assert read_calibration(out).resonance == calibration.resonance
    assert read_calibration(out).gain == calibration.gain


def test_a_csv_with_an_impossible_value_is_refused_with_its_line(tmp_path, capsys):
    table = tmp_path / "readings.csv"
    table.write_text(",".join(CSV_COLUMNS) + "\ncoarse,30000,1,0.1\ncoarse,30100,1,much\n")
    assert slipscale.main([*WORDS, "--csv", str(table)]) == 2
    assert "line 3: amplitude_um_pp is 'much'" in capsys.readouterr().err
