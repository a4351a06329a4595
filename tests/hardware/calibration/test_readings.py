"""Readings from files: what an oscilloscope wrote becomes the amplitude that was there."""

import csv
from contextlib import nullcontext

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale import commands
from slipscale.faults import UserError
from slipscale.hardware.calibration.readings import (
    Trace,
    read_points,
    read_trace,
    um_pp_from_velocity,
)
from slipscale.hardware.calibration.stored import read_calibration

FREQUENCY_HZ = 30_500.0
MM_S_PER_V = 50.0
WORDS = ["plate", "calibrate", "--by", "A. Test", "--instrument", "simulated"]


def trace(v_peak, *, frequency_hz=FREQUENCY_HZ, step_s=1e-6, samples=2500, offset_v=0.0, noise_v=0):
    times_s = step_s * np.arange(samples) - 1e-3
    noise = noise_v * np.random.default_rng(1).standard_normal(samples)
    hum = 0.3 * np.sin(2 * np.pi * 50 * times_s)
    sine = v_peak * np.sin(2 * np.pi * frequency_hz * times_s + 0.7)
    return Trace(times_s=times_s, volts_v=sine + hum + offset_v + noise)


@given(st.floats(0.01, 10), st.floats(25_000, 40_000), st.floats(-2, 2))
def test_a_sines_amplitude_is_found_under_offset_and_hum(v_peak, frequency_hz, offset_v):
    found = trace(v_peak, frequency_hz=frequency_hz, offset_v=offset_v)
    assert found.amplitude_v_peak(frequency_hz) == pytest.approx(v_peak, rel=0.01, abs=0.01)


def test_noise_averages_out():
    assert trace(0.5, noise_v=0.2).amplitude_v_peak(FREQUENCY_HZ) == pytest.approx(0.5, abs=0.02)


def test_the_papers_amplitude_has_this_velocity():
    """2.3 µm peak to peak at 30.5 kHz: π f A."""
    velocity_mm_s = np.pi * FREQUENCY_HZ * 2.3e-3
    assert um_pp_from_velocity(velocity_mm_s, FREQUENCY_HZ) == pytest.approx(2.3)


HEADINGS = {
    "tektronix": ("Record Length,2.5e+03,,{t},{v},", "Sample Interval,1e-06,,{t},{v},"),
    "keysight": ("x-axis,1", "second,Volt", "{t},{v}"),
    "siglent": ("Record Length,Analog:2500", "Model Number,SDS1104X-E", "Second,Value", "{t},{v}"),
    "semicolons": ("Time;Channel A", "(s);(V)", "{t};{v}"),
}


@pytest.mark.parametrize("make", HEADINGS)
def test_the_files_of_common_makes_are_read(tmp_path, make):
    there = trace(1.0)
    *heading, line = HEADINGS[make]
    pairs = list(zip(there.times_s, there.volts_v, strict=True))
    # Tektronix writes its heading beside the first samples.
    lines = [each.format(t=f"{pairs[0][0]:.9e}", v=f"{pairs[0][1]:.6f}") for each in heading]
    beside = sum("{t}" in each for each in heading)
    lines += [line.format(t=f"{t:.9e}", v=f"{v:.6f}") for t, v in pairs[beside:]]
    path = tmp_path / "scope.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    found = read_trace(path)
    assert found.times_s.size == there.times_s.size
    assert found.amplitude_v_peak(FREQUENCY_HZ) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    "made, why",
    [
        ({"step_s": 1.0}, "samples are 1 s apart"),
        ({"step_s": 1e-5}, r"samples are 1e-05 s apart; expected at least 4 samples per period"),
        ({"samples": 100}, "shorter than 5 periods"),
        ({"step_s": -1e-6}, "are not evenly spaced"),
    ],
)
def test_a_trace_that_cannot_hold_the_sine_is_refused(made, why):
    with pytest.raises(ValueError, match=why):
        trace(1.0, **made).amplitude_v_peak(FREQUENCY_HZ)


@pytest.mark.parametrize("share, even", [(0.009, True), (0.02, False), (5.0, False)])
def test_times_that_are_uneven_by_more_than_a_hundredth_of_a_step_are_refused(share, even):
    there = trace(1.0)
    times_s = there.times_s.copy()
    times_s[1000:] += share * (times_s[1] - times_s[0])
    uneven = Trace(times_s=times_s, volts_v=there.volts_v)
    with nullcontext() if even else pytest.raises(ValueError, match="are not evenly spaced"):
        assert uneven.amplitude_v_peak(FREQUENCY_HZ) == pytest.approx(1.0, rel=1e-3)


def table(tmp_path, *rows):
    path = tmp_path / "readings.csv"
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def test_a_calibration_from_traces_is_that_of_the_amplitudes(tmp_path):
    amplitudes, traces = tmp_path / "um.toml", tmp_path / "scope.toml"
    assert commands.main([*WORDS, "--out", str(amplitudes)]) == 0
    expected = read_calibration(amplitudes)
    rows = ["sweep,frequency_hz,voltage_v,trace"]
    for number, point in enumerate(expected.points):
        volts = np.pi * point.frequency_hz * point.amplitude_um_pp * 1e-3 / MM_S_PER_V
        there = trace(volts, frequency_hz=point.frequency_hz, samples=300)
        with (tmp_path / f"{number}.csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows(zip(there.times_s, there.volts_v, strict=True))
        rows.append(f"{point.sweep},{point.frequency_hz},{point.voltage_v},{number}.csv")
    words = ["--from-csv", str(table(tmp_path, *rows)), "--mm-s-per-volt", str(MM_S_PER_V)]
    assert commands.main([*WORDS, *words, "--out", str(traces)]) == 0
    found = read_calibration(traces)
    assert found.resonance.frequency_hz == pytest.approx(expected.resonance.frequency_hz, abs=5)
    assert found.gain.um_pp_per_v == pytest.approx(expected.gain.um_pp_per_v, rel=0.01)


def test_a_velocity_is_an_amplitude_at_its_frequency(tmp_path):
    path = table(tmp_path, "sweep,frequency_hz,voltage_v,velocity_mm_s_peak", "fine,30500,5,100")
    (point,) = read_points(path)
    assert point.amplitude_um_pp == pytest.approx(2 * 100e3 / (2 * np.pi * 30_500))


def test_a_plate_that_stands_still_reads_0(tmp_path):
    path = table(tmp_path, "sweep,frequency_hz,voltage_v,velocity_mm_s_peak", "fine,30500,0,0")
    (point,) = read_points(path)
    assert point.amplitude_um_pp == 0


@pytest.mark.parametrize(
    "rows, why",
    [
        (["sweep,frequency_hz,voltage_v"], "expected one of the columns .* got none of them"),
        (["sweep,frequency_hz,voltage_v,trace,amplitude_um_pp"], "got amplitude_um_pp and trace"),
        (
            ["sweep,frequency_hz,voltage_v,velocity_mm_s_peak", "fine,30500,5,fast"],
            "line 2: velocity_mm_s_peak is 'fast', expected a number, 0 or more",
        ),
        (
            ["sweep,frequency_hz,voltage_v,velocity_mm_s_peak", "fine,30500,5,-1"],
            "line 2: velocity_mm_s_peak is '-1', expected a number, 0 or more",
        ),
        (
            ["sweep,frequency_hz,voltage_v,trace", "fine,30500,5,none.csv"],
            "line 2: trace is 'none.csv': No such file",
        ),
        (
            ["sweep,frequency_hz,voltage_v,trace", "fine,30500,5,broken.csv"],
            "line 2: trace is 'broken.csv': line 3 does not end with a time and a voltage",
        ),
        (
            ["sweep,frequency_hz,voltage_v,trace", "fine,30500,5,readings.csv"],
            "'readings.csv': no line ends with a time and a voltage",
        ),
    ],
)
def test_a_table_that_cannot_be_read_is_refused_with_its_line(tmp_path, rows, why):
    (tmp_path / "broken.csv").write_text("0,1\n1e-6,2\nhello\n2e-6,1\n")
    with pytest.raises(UserError, match=why):
        read_points(table(tmp_path, *rows), mm_s_per_v=MM_S_PER_V)


def test_traces_without_the_vibrometers_range_are_refused(tmp_path):
    path = table(tmp_path, "sweep,frequency_hz,voltage_v,trace", "fine,30500,5,readings.csv")
    with pytest.raises(UserError, match="require --mm-s-per-volt"):
        read_points(path)
