import csv
import datetime as dt
import json
import math
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy import stats

from slipscale import commands
from slipscale.faults import UserError
from slipscale.hardware.address import Plate
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.calibration.fit import fit_gain, fit_resonance, response
from slipscale.hardware.calibration.record import (
    EXPIRED_DAYS,
    OLD_DAYS,
    PEAK_OF,
    Calibration,
    Device,
    DriveChain,
    Point,
    Provenance,
    VoltageConvention,
    to_toml,
    write_calibration,
)
from slipscale.hardware.calibration.stored import read_calibration
from slipscale.hardware.calibration.sweep import SweepPlan, calibration_from, sweep
from slipscale.hardware.cli import calibrate
from slipscale.hardware.cli.calibrate import measured
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.errors import OverLimit, WrongDevice
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.plate.dynamics import Resonator
from slipscale.hardware.plate.twin import Surroundings, Twin
from slipscale.hardware.records import Output
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.surface import VirtualSurface

STEADY = Surroundings(warm_up_k=0, wander_k=0)
TODAY = dt.datetime.now(tz=dt.UTC).date()


def swept(twin, plan=None):
    plate = MockPlate(clock=VirtualClock(), twin=twin)
    plate.connect()

    def measure(frequency_hz, voltage_v):
        return measured(plate, plate.excite(frequency_hz=frequency_hz, voltage_v=voltage_v))

    return sweep(plan or SweepPlan(), measure)


def calibrated(twin):
    points = swept(twin)
    return calibration_from(
        points,
        device=Device(backend="mock", serial="twin"),
        made=Provenance(date=TODAY, by="a test", instrument="the twin's own"),
        drive=DriveChain(),
    )


@pytest.fixture(scope="module")
def calibration():
    return calibrated(Twin(seed=1))


def test_the_stated_uncertainties_cover_the_truth_as_often_as_they_say():
    """Squared errors in units of the uncertainty sum up as chi-squared says, over 60 seeds."""
    seeds = 60
    squares = np.zeros(3)
    for seed in range(seeds):
        found = calibrated(Twin(seed=seed, surroundings=STEADY))
        resonance, gain = found.resonance, found.gain
        squares += [
            ((resonance.frequency_hz - 30_500) / resonance.frequency_ci95_hz) ** 2,
            ((resonance.quality_factor - 60) / resonance.quality_factor_ci95) ** 2,
            ((gain.um_pp_per_v - 2.3 / 15) / gain.um_pp_per_v_ci95) ** 2,
        ]
    fewest, most = stats.chi2.ppf([0.0005, 0.9995], seeds) / stats.norm.ppf(0.975) ** 2
    assert np.all((squares >= fewest) & (squares <= most)), squares


def test_a_plate_in_a_room_that_warms_is_recovered_too(calibration):
    """Section IV-A: 30.5 kHz, and 2.3 µm p-p at 15 V. Warmth moves the resonance some hertz."""
    assert calibration.resonance.frequency_hz == pytest.approx(30_500, abs=6)
    assert calibration.gain.um_pp_per_v * 15 == pytest.approx(2.3, rel=0.005)
    assert calibration.resonance.quality_factor == pytest.approx(60, rel=0.05)


STRONG = Twin(surroundings=STEADY, resonator=Resonator(gain_um_pp_per_v=0.3))


def test_a_sweep_stops_where_the_measured_amplitude_exceeds_the_plates_limit():
    plate = MockPlate(clock=VirtualClock(), twin=STRONG)
    plate.connect()
    read = []

    def measure(frequency_hz, voltage_v):
        readback = plate.excite(frequency_hz=frequency_hz, voltage_v=voltage_v)
        read.append(readback.level)
        return readback.level

    with pytest.raises(OverLimit, match=r"2\.8\d* µm p-p at 9\.33333 V peak .*--max-voltage"):
        sweep(SweepPlan(), measure)
    assert max(read) <= plate.limits.level
    assert plate.output is Output.OFF
    assert len(swept(STRONG, SweepPlan(max_voltage_v=8.0))) > 0


def test_a_plate_may_be_calibrated_again_beyond_its_last_calibration(calibration):
    plate = MockPlate(clock=VirtualClock(), twin=STRONG, plate=Plate(calibration=calibration))
    plate.limits = replace(plate.limits, level=1.0)
    plate.connect()
    assert plate.excite(frequency_hz=30_500, voltage_v=7.0).level == pytest.approx(2.1, rel=0.02)
    with pytest.raises(OverLimit, match=r"more than the plate's limit of 2\.5 µm p-p"):
        plate.excite(frequency_hz=30_500, voltage_v=9.0)


def test_another_plate_is_found_where_it_is():
    twin = Twin(surroundings=STEADY, resonator=Resonator(resonance_hz=31_200, quality_factor=180))
    resonance = calibrated(twin).resonance
    assert resonance.frequency_hz == pytest.approx(31_200, abs=3)
    assert resonance.quality_factor == pytest.approx(180, rel=0.05)


def test_volts_are_the_inverse_of_micrometres(calibration):
    assert calibration.voltage_v_peak(2.3) == pytest.approx(15, rel=0.005)


def test_the_file_is_read_as_it_was_written(calibration, tmp_path):
    path = tmp_path / "plate.toml"
    write_calibration(calibration, path)
    assert read_calibration(path) == calibration


@given(st.text(st.characters(exclude_categories=["Cs"])))
@example("\x7f")
def test_any_text_in_a_file_is_read_as_it_was_written(calibration, tmp_path_factory, text):
    made = calibration.made.model_copy(update={"by": text})
    named = calibration.model_copy(update={"made": made})
    path = tmp_path_factory.getbasetemp() / "named.toml"
    write_calibration(named, path)
    assert read_calibration(path) == named


def test_a_driver_refuses_what_was_not_calibrated(tmp_path):
    narrow = calibration_from(
        swept(Twin(), SweepPlan(max_voltage_v=10)),
        device=Device(backend="mock", serial="twin"),
        made=Provenance(date=TODAY, by="a test", instrument="the twin's own"),
        drive=DriveChain(),
    )
    path = tmp_path / "plate.toml"
    write_calibration(narrow, path)
    with open_plate(f"mock:calibration={path}", clock=VirtualClock()) as driver:
        driver.present(VirtualSurface(level=1.5))
        with pytest.raises(OverLimit, match=r"outside 0 to 1\.5"):
            driver.present(VirtualSurface(level=1.6))
        assert driver.describe()["calibration"]["made"]["by"] == "a test"


def dated(calibration, date):
    return calibration.model_copy(
        update={"made": calibration.made.model_copy(update={"date": date})}
    )


def test_an_old_calibration_is_told_and_an_older_one_refused(calibration):
    later = TODAY + dt.timedelta(days=OLD_DAYS + 1)
    assert calibration.notes(TODAY) == ()
    assert calibration.notes(later) == ("the calibration is 181 days old; recalibrate",)
    calibration.check_date(TODAY + dt.timedelta(days=EXPIRED_DAYS))
    with pytest.raises(UserError, match="366 days old, expected at most 365 days"):
        calibration.check_date(TODAY + dt.timedelta(days=EXPIRED_DAYS + 1))
    calibration.check_date(TODAY - dt.timedelta(days=1))  # another time zone
    with pytest.raises(UserError, match="after today"):
        calibration.check_date(TODAY - dt.timedelta(days=2))


class Real(MockPlate):
    """A twin that passes for a plate at which a finger may be."""

    name = "real"
    simulated = False


def made_on(calibration, **device):
    return calibration.model_copy(update={"device": Device(**device)})


@pytest.mark.parametrize(
    "device, said",
    [
        ({"backend": "mock", "serial": "twin"}, "on backend 'mock', but this is 'real'"),
        ({"backend": "real", "serial": "0042"}, "on device '0042', but this is 'twin'"),
        ({"backend": "real"}, "on device '', but this is 'twin'"),
    ],
)
def test_a_calibration_of_another_device_is_refused_before_anything_is_presented(
    calibration, device, said
):
    other = made_on(calibration, **device)
    plate = Real(clock=VirtualClock(), plate=Plate(calibration=other))
    with pytest.raises(WrongDevice, match=said):
        plate.connect()
    assert [each.name for each in plate.log] == ["connect", "silence"]
    rehearsed = MockPlate(
        clock=VirtualClock(), plate=Plate(calibration=made_on(calibration, backend="scpi"))
    )
    rehearsed.connect()
    assert any("this is 'mock'" in note for note in rehearsed.notes)


@pytest.mark.parametrize("date", [dt.date(2020, 1, 1), dt.date(2099, 1, 1)])
def test_a_calibration_of_an_impossible_date_is_refused(calibration, date):
    own = made_on(dated(calibration, date), backend="real", serial="twin")
    with pytest.raises(UserError, match="recalibrate"):
        Real(clock=VirtualClock(), plate=Plate(calibration=own)).connect()


def test_a_file_that_was_changed_is_refused(calibration, tmp_path):
    path = tmp_path / "plate.toml"
    text = to_toml(calibration)
    path.write_text("# my plate\n" + text.replace(" = ", "  =  "), encoding="utf-8")
    assert read_calibration(path) == calibration  # its layout is free
    for changed in (
        text.replace('by = "a test"', 'by = "another"'),
        text.replace("temperature", "# temperature").replace("sha256", "# sha256"),
    ):
        path.write_text(changed, encoding="utf-8")
        with pytest.raises(UserError, match="changed after it was written"):
            read_calibration(path)


@pytest.mark.parametrize(
    "part, changes, said",
    [
        ("gain", {"um_pp_per_v": 2}, "readings of the"),
        (
            "resonance",
            {"frequency_hz": 31_000 / 30_500},
            "reading of the voltage sweep was made at",
        ),
        ("resonance", {"quality_factor": 20}, "readings of the fine sweep"),
        ("resonance", {"quality_factor": 1e7}, "less than or equal to 5000"),
    ],
    ids=["doubled gain", "resonance 500 Hz away", "Q = 1,200", "Q = 6e8"],
)
def test_numbers_that_do_not_follow_from_the_readings_are_refused(calibration, part, changes, said):
    """Even with a new checksum."""
    content = calibration.model_dump()
    for name, factor in changes.items():
        content[part][name] *= factor
    with pytest.raises(ValidationError, match=said):
        Calibration.model_validate(content)


def test_a_resonance_outside_the_plates_band_is_refused(calibration):
    with pytest.raises(UserError, match="outside the plate's band, 31000 to 40000 Hz"):
        calibration.narrow(PlateLimits(frequency_min_hz=31_000))
    resonance_hz = calibration.resonance.frequency_hz
    assert (
        calibration.narrow(PlateLimits(frequency_min_hz=resonance_hz)).frequency_min_hz
        == resonance_hz
    )
    assert (
        calibration.narrow(PlateLimits(frequency_max_hz=resonance_hz)).frequency_max_hz
        == resonance_hz
    )


def test_volts_of_the_file_are_volts_peak_to_the_driver(calibration):
    rms = DriveChain(voltage_convention="V RMS")
    found = calibration.model_copy(update={"drive": rms})
    factor = math.sqrt(2)
    assert found.voltage_v_peak(1) == pytest.approx(factor * calibration.voltage_v_peak(1))
    assert found.narrow(PlateLimits()).voltage_v == 16.5
    assert calibration.narrow(PlateLimits()).voltage_v == 16.0


@pytest.mark.parametrize(
    "damage, said",
    [
        (lambda text: text.replace("um_pp_per_v = ", "um_pp_per_v = -"), "gain.um_pp_per_v"),
        (lambda text: text.replace("by = ", "# by = "), "made.by: is missing"),
        (lambda text: text.replace("frequency_hz = ", "frequency_hz = nan # ", 1), "resonance"),
        (
            lambda text: text.replace("voltage_max_v = 16.0", "voltage_max_v = 99.0"),
            "is larger than every voltage in 'points'",
        ),
        (lambda text: text.replace("[made]", "[made]\ntemperature_c = inf"), "temperature_c"),
        (lambda text: text.replace("[gain]", "[gian]"), "gian: unknown key"),
        (lambda text: text.replace("[device]", "[device"), "is not TOML"),
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
    assert fit_resonance(scattered[:6]).resonance.frequency_hz == pytest.approx(30_500, abs=50)
    with pytest.raises(UserError, match="5 points, expected 6 or more"):
        fit_resonance(scattered[:5])
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


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("noise_um", [0.0, 0.01])
def test_a_flat_response_has_no_resonance(noise_um, seed):
    noise = np.random.default_rng(seed).normal(0, noise_um, 100)
    hz = np.linspace(29_000, 32_000, 100)
    flat = points("coarse", hz, dict(zip(hz, np.abs(0.1 + noise), strict=True)).get)
    with pytest.raises(UserError, match=r"no resonance|no peak"):
        fit_resonance(flat)


def test_a_gains_interval_covers_the_truth_under_noise_that_grows_with_the_reading():
    """Taken for constant, noise of 2 % left 95 % intervals that covered 86 %."""
    volts = np.repeat(np.linspace(0, 16, 13)[1:], 2)
    tries, misses = 400, 0
    for seed in range(tries):
        noise = np.random.default_rng(seed).normal(0, 0.02, volts.size)
        gain = fit_gain(
            [
                Point(sweep="voltage", frequency_hz=3e4, voltage_v=v, amplitude_um_pp=um)
                for v, um in zip(volts, 0.15 * volts * (1 + noise), strict=True)
            ]
        )
        misses += abs(gain.um_pp_per_v - 0.15) > gain.um_pp_per_v_ci95
    fewest, most = stats.binom.ppf([0.0005, 0.9995], tries, 0.05)
    assert fewest <= misses <= most


def test_a_plate_that_does_not_respond_is_refused():
    dead = [Point(sweep="voltage", frequency_hz=3e4, voltage_v=v, amplitude_um_pp=0)
            for v in range(8)]  # fmt: skip
    with pytest.raises(UserError, match="does not respond"):
        fit_gain(dead)
    with pytest.raises(UserError, match="5 points, expected 6"):
        fit_gain(dead[:5])


CSV_COLUMNS = ("sweep", "frequency_hz", "voltage_v", "amplitude_um_pp")
WORDS = ["plate", "calibrate", "--by", "T. Ester", "--instrument", "OFV-505, 2 µm/V"]


def test_the_command_writes_a_file_and_a_plot(tmp_path, capsys):
    out = tmp_path / "plate.toml"
    assert commands.main([*WORDS, "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "resonance  30497.8 ± 2.3 Hz" in printed
    assert f"wrote      {out} and {out.with_suffix('.png')}" in printed
    assert commands.main([*WORDS, "--measure-only", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (round(result["resonance"]["frequency_hz"], 1), result["file"]) == (30497.8, None)
    assert read_calibration(out).made.instrument == "OFV-505, 2 µm/V"
    assert out.with_suffix(".png").read_bytes().startswith(b"\x89PNG")


def test_a_file_that_cannot_be_written_is_told_before_anything_is_measured(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(calibrate, "typed", lambda *_: pytest.fail("a reading was asked for"))
    known = tmp_path / "plate.toml"
    known.write_text("data rest on it")
    (tmp_path / "drawn.png").write_text("a picture")
    for out, complaint in (
        (known, "plate.toml already exists"),
        (tmp_path / "drawn.toml", "drawn.png already exists"),
        (tmp_path / "x.png", "expected the name of a new TOML file"),
        (tmp_path / "x", "expected the name of a new TOML file"),
        (tmp_path / "no" / "x.toml", "writable folder"),
    ):
        assert commands.main([*WORDS, "--prompt", "--out", str(out)]) == 2
        assert complaint in capsys.readouterr().err
    assert known.read_text() == "data rest on it"
    assert (tmp_path / "drawn.png").read_text() == "a picture"


@pytest.mark.parametrize(
    "words",
    [
        *(["--temperature", each] for each in ("nan", "inf")),
        *([option, each] for option in ("--span", "--centre") for each in ("0", "-1", "nan")),
        *([option, "0"] for option in ("--sweep-voltage", "--max-voltage", "--amplifier-gain")),
    ],
)
def test_an_impossible_number_is_refused_before_anything_is_measured(
    tmp_path, monkeypatch, capsys, words
):
    monkeypatch.setattr(calibrate, "typed", lambda *_: pytest.fail("a reading was asked for"))
    assert commands.main([*WORDS, "--prompt", "--out", str(tmp_path / "x.toml"), *words]) == 2
    assert f"{words[0]}: '{words[1]}', expected a number" in capsys.readouterr().err


def test_readings_typed_at_a_prompt_give_the_calibration(tmp_path, monkeypatch, capsys):
    truth = Twin(surroundings=STEADY, noise_um=0)

    def type_it(prompt, alive):
        alive()
        hz, volts = (float(word.split()[0]) for word in prompt.split(":")[0].split(","))
        answers = {0: "two or so", 5: "b"}
        asked.append(prompt)
        amplitude = abs(truth.conditions(0).response_um_pp_per_v(hz)) * volts
        return answers.get(len(asked) - 1, f"{amplitude:.3f}".replace(".", ","))

    asked = []
    monkeypatch.setattr(calibrate, "typed", type_it)
    out = tmp_path / "plate.toml"
    assert commands.main([*WORDS, "--prompt", "--out", str(out)]) == 0
    assert "'two or so' is not a reading" in capsys.readouterr().out
    assert asked[4:6] == asked[6:8]  # b has the previous point read again
    assert read_calibration(out).resonance.frequency_hz == pytest.approx(30_500, abs=1)


def test_readings_in_a_csv_give_the_same_calibration_as_measured_ones(calibration, tmp_path):
    table = tmp_path / "readings.csv"
    with table.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(CSV_COLUMNS)
        for point in calibration.points:
            writer.writerow([getattr(point, name) for name in CSV_COLUMNS])
    out = tmp_path / "plate.toml"
    assert commands.main([*WORDS, "--csv", str(table), "--out", str(out)]) == 0
    assert read_calibration(out).resonance == calibration.resonance
    assert read_calibration(out).gain == calibration.gain


def test_a_gain_beside_the_drivers_is_refused_before_anything_is_driven(tmp_path, capsys):
    """The sweep was driven by the SPEC's gain and the file took the other: 320 V on a plate."""
    out = tmp_path / "plate.toml"
    spec = ["--plate", "scpi:TCPIP::127.0.0.1::9::SOCKET,gain=1"]
    assert commands.main([*WORDS, *spec, "--amplifier-gain", "20", "--out", str(out)]) == 2
    assert "has a gain of 1; set the gain only in" in capsys.readouterr().err
    assert commands.main([*WORDS, "--amplifier-gain", "20", "--out", str(out)]) == 2
    assert "plate 'mock' has a gain of 1" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize("convention", get_args(VoltageConvention))
def test_a_convention_changes_the_files_volts_and_not_the_plates(tmp_path, convention):
    out = tmp_path / "plate.toml"
    factor = PEAK_OF[convention]
    volts = ["--sweep-voltage", str(5 / factor), "--max-voltage", str(16 / factor)]
    words = [*WORDS, "--voltage-convention", convention, *volts, "--out", str(out)]
    assert commands.main(words) == 0
    found = read_calibration(out)
    assert found.drive.voltage_convention == convention
    assert found.gain.voltage_max_v == pytest.approx(16 / factor)
    assert found.voltage_v_peak(1.2) == pytest.approx(1.2 * 15 / 2.3, rel=0.01)


def test_more_volts_peak_than_the_plate_may_have_are_refused_in_any_convention(tmp_path, capsys):
    words = [*WORDS, "--voltage-convention", "V RMS", "--max-voltage", "16"]
    assert commands.main([*words, "--out", str(tmp_path / "plate.toml")]) == 3
    assert "V peak at the plate is outside 0 to 16.5" in capsys.readouterr().err


def test_readings_of_a_real_device_in_a_csv_need_its_serial_number(tmp_path, capsys):
    words = [*WORDS, "--csv", str(tmp_path / "readings.csv"), "--out", str(tmp_path / "plate.toml")]
    assert commands.main([*words, "--plate", "serial:/dev/ttyACM0"]) == 2
    assert "--csv also requires --serial" in capsys.readouterr().err


def test_a_csv_with_an_impossible_value_is_refused_with_its_line(tmp_path, capsys):
    table = tmp_path / "readings.csv"
    table.write_text(",".join(CSV_COLUMNS) + "\ncoarse,30000,1,0.1\ncoarse,30100,1,much\n")
    assert commands.main([*WORDS, "--csv", str(table)]) == 2
    assert "line 3: amplitude_um_pp is 'much'" in capsys.readouterr().err
