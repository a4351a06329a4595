"""What a fitted line hides: saturation, offset, drift, two resonances, mistaken units, edits."""

import datetime as dt
import math

import numpy as np
import pytest

from slipscale import commands
from slipscale.faults import UserError
from slipscale.hardware.calibration.record import (
    Calibration,
    Device,
    DriveChain,
    Point,
    Provenance,
    checksum,
    to_toml,
    write_calibration,
)
from slipscale.hardware.calibration.soundness import (
    RULES,
    Sweep,
    changed,
    implausible,
    mistake,
    unsound,
)
from slipscale.hardware.calibration.stored import read_calibration
from slipscale.hardware.calibration.sweep import SweepPlan, calibration_from, sweep

GAIN = 2.3 / 15
TODAY = dt.datetime.now(tz=dt.UTC).date()


def response(frequency_hz, resonance_hz=30_500.0):
    return 1 / math.hypot(1, 2 * 60 * (frequency_hz - resonance_hz) / resonance_hz)


def ideal(frequency_hz, voltage_v):
    return GAIN * voltage_v * response(frequency_hz)


def calibrated(measure=ideal, *, max_voltage_v=16.0, **drive):
    return calibration_from(
        sweep(SweepPlan(max_voltage_v=max_voltage_v), measure),
        device=Device(backend="mock", serial="twin"),
        made=Provenance(date=TODAY, by="a test", instrument="none"),
        drive=DriveChain(**drive),
    )


def saturating(frequency_hz, voltage_v):
    return min(ideal(frequency_hz, voltage_v), 1.6)


def hardening(frequency_hz, voltage_v):
    """A soft knee: 20 % are missing at the top."""
    return ideal(frequency_hz, voltage_v) * (1 - 0.25 * (voltage_v / 16) ** 2)


def with_offset(frequency_hz, voltage_v):
    return ideal(frequency_hz, voltage_v) + 0.15


def falling(frequency_hz, voltage_v):
    return ideal(frequency_hz, voltage_v) * (0.85 if 11 < voltage_v < 14 else 1)


def split(frequency_hz, voltage_v):
    other = 0.8 * response(frequency_hz, 31_000.0)
    return GAIN * voltage_v * max(response(frequency_hz), other)


class Drifting:
    """The plate weakens while it is swept."""

    def __init__(self):
        self.readings = 0

    def __call__(self, frequency_hz, voltage_v):
        self.readings += 1
        return ideal(frequency_hz, voltage_v) * (1 - 0.004 * max(self.readings - 124, 0))


@pytest.mark.parametrize(
    "measure, said",
    [
        (saturating, r"saturates|differ by \d+% from"),
        (hardening, r"saturates|differ by \d+% from"),
        (with_offset, r"an offset of 0\.1|differ by \d+% from"),
        (falling, r"falls from|differ by \d+% from"),
        (split, r"does not follow one resonance|differ by \d+% from"),
        (Drifting(), "changed during the sweep"),
    ],
)
def test_readings_of_a_plate_or_instrument_that_is_not_sound_are_refused(measure, said):
    calibrated()  # the ideal one is accepted
    with pytest.raises(UserError, match=said):
        calibrated(measure)


def judged(voltages_v, lost):
    """Apply the rules to a sweep whose slope falls by a fraction above 8 V."""
    voltage_v = np.array(voltages_v, float)
    sweep_ = Sweep(voltage_v, np.minimum(voltage_v, 8) + (1 - lost) * np.maximum(voltage_v - 8, 0))
    return [fault for rule in RULES for fault in rule(sweep_)]


def test_a_slope_that_falls_by_more_than_16_percent_above_half_the_range_is_saturation():
    (fault,) = judged(range(1, 17), 0.17)
    assert "saturates: its gain is 0.83 µm p-p per volt above 8 V, but 1 below 8 V" in fault
    assert judged(range(1, 17), 0.15) == []


def test_saturation_is_not_judged_from_fewer_than_four_readings_in_a_half():
    assert judged([*range(1, 9), 12, 14, 16], 0.17) == []
    assert len(judged([*range(1, 9), 10, 12, 14, 16], 0.17)) == 1
    assert judged([2, 5, 8, 10, 12, 14, 16], 0.17) == []


@pytest.mark.parametrize("swept, faults", [("fine", 1), ("coarse", 0)])
def test_the_fine_sweep_is_compared_with_the_resonance_if_there_is_one(swept, faults):
    ideal_one = calibrated()
    outlier = next(n for n, each in enumerate(ideal_one.points) if each.sweep == swept)
    points = list(ideal_one.points)
    points[outlier] = points[outlier].model_copy(update={"amplitude_um_pp": 9.0})
    found = unsound(ideal_one.model_copy(update={"points": tuple(points)}))
    assert len(found) == faults
    assert all("does not follow one resonance" in each for each in found)


def test_the_range_ends_with_the_largest_reading():
    def knee(frequency_hz, voltage_v):
        return ideal(frequency_hz, voltage_v) * (0.97 if voltage_v > 15 else 1)

    found = calibrated(knee)
    assert found.gain.amplitude_max_um_pp == pytest.approx(0.97 * 16 * GAIN)
    assert found.gain.amplitude_max_um_pp < found.gain.um_pp_per_v * 16


def edited(calibration, path, table, name, value):
    """Write a calibration with one number changed, under a correct checksum."""
    content = calibration.model_dump()
    content[table][name] = value
    forged = Calibration.model_construct(
        **{key: type(getattr(calibration, key)).model_construct(**content[key])
           for key in ("device", "made", "drive", "resonance", "gain")},
        points=tuple(Point.model_construct(**each) for each in content["points"]),
    )  # fmt: skip
    path.write_text(to_toml(forged), encoding="utf-8")
    assert checksum(forged) in path.read_text(encoding="utf-8")


NUMBERS = [
    (table, name, factor)
    for table, names in {
        "drive": ("amplifier_gain",),
        "resonance": ("frequency_hz", "frequency_ci95_hz", "quality_factor", "quality_factor_ci95",
                      "residual_um"),
        "gain": ("um_pp_per_v", "um_pp_per_v_ci95", "residual_um", "voltage_max_v",
                 "amplitude_max_um_pp"),
    }.items()
    for name in names
    for factor in (0.1, 0.99, 1.01, 2.0)
]  # fmt: skip


@pytest.fixture(scope="module")
def noisy():
    """A calibration whose intervals are not 0: readings with a deterministic scatter of 3 nm."""

    def measure(frequency_hz, voltage_v):
        return ideal(frequency_hz, voltage_v) + 0.003 * math.sin(frequency_hz + 977 * voltage_v)

    return calibrated(measure, amplifier_gain=20.0)


@pytest.mark.parametrize("table, name, factor", NUMBERS)
def test_a_number_that_was_changed_under_a_correct_checksum_is_refused(
    noisy, tmp_path, table, name, factor
):
    path = tmp_path / "plate.toml"
    write_calibration(noisy, path)
    assert read_calibration(path) == noisy
    value = getattr(getattr(noisy, table), name)
    edited(noisy, path, table, name, factor * value)
    with pytest.raises(UserError):
        read_calibration(path)


@pytest.mark.parametrize("place", [85, 100, -1])
@pytest.mark.parametrize("name", ["frequency_hz", "voltage_v", "amplitude_um_pp"])
def test_a_reading_that_was_changed_under_a_correct_checksum_is_refused(
    noisy, tmp_path, place, name
):
    path = tmp_path / "plate.toml"
    points = [each.model_dump() for each in noisy.points]
    points[place][name] *= 1.02
    forged = noisy.model_copy(update={"points": tuple(Point(**each) for each in points)})
    write_calibration(forged, path)
    with pytest.raises(UserError, match=r"stored readings give|differ|beyond|was made at"):
        read_calibration(path)


@pytest.mark.parametrize(
    "factor, plausible",
    [(1.0, True), (1000.0, False), (0.001, False), (20.0, False), (0.5, True)],
)
def test_units_are_bounded_by_default(factor, plausible):
    found = calibrated(lambda f, v: factor * ideal(f, v))
    assert (implausible(found, {}) == []) == plausible


@pytest.mark.parametrize(
    "ratio, gain, what",
    [
        (0.5, 1, "peak values mistaken for peak-to-peak values"),
        (1 / math.sqrt(2), 1, "RMS values mistaken for peak values"),
        (1000, 1, "nanometres mistaken for micrometres"),
        (0.001, 1, "millivolts mistaken for volts"),
        (20, 20, "the voltage before the amplifier"),
        (1.2, 20, ""),
    ],
)
def test_a_factor_names_the_mistake_that_brings_it(ratio, gain, what):
    assert mistake(ratio, gain).startswith(what)
    assert bool(mistake(ratio, gain)) == bool(what)


def test_a_gain_unlike_the_plates_last_one_is_told_with_the_likely_mistake():
    before, halved = calibrated(), calibrated(lambda f, v: ideal(f, v) / 2)
    assert changed(before, before) == ""
    assert (
        "a possible cause of this factor of 0.5: peak values mistaken for peak-to-peak values"
        in changed(halved, before)
    )


WORDS = ["plate", "calibrate", "--by", "A. Test", "--instrument", "none"]


def readings(path, factor=1.0):
    rows = ["sweep,frequency_hz,voltage_v,amplitude_um_pp"]
    points = sweep(SweepPlan(), lambda f, v: factor * ideal(f, v))
    rows += [f"{p.sweep},{p.frequency_hz},{p.voltage_v},{p.amplitude_um_pp}" for p in points]
    path.write_text("\n".join(rows), encoding="utf-8")


def test_nanometres_are_refused_before_a_file_is_written(tmp_path, capsys):
    table, out = tmp_path / "readings.csv", tmp_path / "plate.toml"
    readings(table, 1000.0)
    assert commands.main([*WORDS, "--csv", str(table), "--out", str(out)]) == 2
    assert (
        "um_pp_per_v_peak is 153.333, but plausible values are 0.005 to 2"
        in capsys.readouterr().err
    )
    assert not out.exists()


def test_a_peak_taken_for_peak_to_peak_is_found_by_the_plates_last_calibration(tmp_path, capsys):
    table, first, out = (tmp_path / name for name in ("r.csv", "first.toml", "second.toml"))
    readings(table)
    assert commands.main([*WORDS, "--csv", str(table), "--out", str(first)]) == 0
    readings(table, 0.5)
    again = [*WORDS, "--plate", f"mock:calibration={first}", "--csv", str(table), "--out", str(out)]
    assert commands.main(again) == 2
    assert "peak values mistaken for peak-to-peak values" in capsys.readouterr().err
    assert commands.main([*again, "--changed-plate"]) == 0
