"""``slipscale run`` as a lab runs it: its own process, a real window, a hand on the keyboard."""

from __future__ import annotations

import os
import shutil
import signal
import sys
from contextlib import ExitStack

import pandas as pd
import pytest

from slipscale.experiments.dataset.verification import verify
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.study.file import study_text
from tests.support.session_window import SAID, SessionWindow

pytestmark = [
    pytest.mark.window,
    pytest.mark.skipif(
        not sys.platform.startswith("linux") or not shutil.which("xdotool"),
        reason="key presses come from xdotool, under X11",
    ),
]

JOURNAL = "sourcedata/sub-01/sub-01_run-01_journal.jsonl"


@pytest.fixture
def start(display):
    """Start a command with a window; whatever happens, nothing is left running."""
    with ExitStack() as started:
        yield lambda *words, folder: started.enter_context(SessionWindow(*words, folder=folder))


def table_of(folder, task):
    path = folder / f"sub-01/beh/sub-01_task-{task}_run-01_beh.tsv"
    return pd.read_csv(path, sep="\t", keep_default_na=False)


def test_a_session_from_welcome_to_thanks_with_escape_kill_and_resume(start, tmp_path):
    """One long afternoon: Escape and no, Escape and yes, resume, power cut, resume, the end."""
    shorter = study_text("biet2007").replace("[0.0, 0.5, 1.2, 2.3]", "[0.0, 1.2]")
    (tmp_path / "shorter.toml").write_text(shorter, encoding="utf-8")
    run = ("run", "shorter.toml", "--participant", "01", "--windowed", "--language", "fr")
    hand = start(*run, "--out", ".", folder=tmp_path)
    hand.until("difference_felt")
    hand.escape(no="n")
    hand.answer({"name": "difference_felt"})
    hand.until("scale_top")
    hand.escape(yes="o")
    status, out, err = hand.end()
    assert (status, err.count("Traceback")) == (130, 0)
    assert f"slipscale resume {JOURNAL}" in out
    journal = tmp_path / JOURNAL
    assert read_plan(journal)[1][-1].kind == "stop"

    resume = ("resume", JOURNAL, "--windowed")
    hand = start(*resume, folder=tmp_path)
    hand.until("estimate")
    hand.answer({"name": "estimate"})
    hand.until("estimate")
    hand.type_until_shown("9", "9", entry="99")  # half an answer
    before = read_plan(journal)[1]
    hand.kill()

    hand = start(*resume, folder=tmp_path)
    while step := hand.next_step():
        hand.answer(step)
    status, _, err = hand.end()
    assert (status, err.count("Traceback")) == (0, 0), err
    records = read_plan(journal)[1]
    assert records[: len(before)] == before
    assert records[-1].kind == "end"
    assert unfelt(records) == []
    assert verify(tmp_path) == []

    assert_the_tables_hold_the_answers(tmp_path)


def assert_the_tables_hold_the_answers(folder):
    estimates = table_of(folder, "magnitudeestimation")
    steps = table_of(folder, "descendingdifference")
    assert estimates[["estimate", "scale_top"]].to_numpy().tolist() == [[12.5, 12.5]] * 4
    flags = list(estimates["flag"])
    assert set(flags[1].split(";")) == {"resumed", "represented"}
    assert flags[:1] + flags[2:] == ["n/a"] * 3
    assert set(steps["difference_felt"]) == {"yes"}
    assert set(steps["verbal_report"]) == {SAID}
    assert set(estimates["response_time_source"]) <= {"ptb", "window"}
    sidecar = folder / "sub-01/beh/sub-01_task-magnitudeestimation_run-01_beh.json"
    assert '"mode": "pilot"' in sidecar.read_text()  # nobody feels anything on a mock plate


AGED = """name = "aged"
title = "With an age"
amplitudes_um_pp = [0.0, 1.2]
[[about_you]]
name = "age_years"
minimum = 18
maximum = 99
[[tasks]]
protocol = "magnitude_estimation"
"""


def test_what_was_typed_when_a_session_is_terminated_is_there_when_it_goes_on(start, tmp_path):
    (tmp_path / "aged.toml").write_text(AGED)
    hand = start(
        *("run", "aged.toml", "--participant", "01", "--windowed", "--out", "."), folder=tmp_path
    )
    hand.until("age_years")
    hand.press("1", "7", "Return")  # refused
    hand.type_until_shown("3", "4", entry="34")
    hand.process.send_signal(signal.SIGTERM)
    status, _, err = hand.end()
    assert (status, err.count("Traceback")) == (130, 0), err
    records = read_plan(tmp_path / JOURNAL)[1]
    assert records[-1].kind == "stop"
    (left,) = [record.data for record in records if record.kind == "unfinished"]
    assert (left["name"], left["entry"], list(left["rejected"])) == ("age_years", "34", ["17"])

    hand = start("run", "aged.toml", "--participant", "01", "--out", ".", folder=tmp_path)
    status, _, err = hand.end()
    assert status == 2
    assert f"slipscale resume {JOURNAL}" in err

    hand = start("resume", JOURNAL, "--windowed", folder=tmp_path)
    hand.until("age_years")
    hand.press("Return")  # it stands there already
    assert hand.next_step()["type"] == "Instruct"
    hand.process.send_signal(signal.SIGTERM)
    hand.end()
    answers = [r.data["answer"] or {} for r in read_plan(tmp_path / JOURNAL)[1] if r.kind == "done"]
    assert [(a["value"], list(a["rejected"])) for a in answers if a.get("value")] == [
        (34.0, ["17"])
    ]


KILLED = """name = "killed"
title = "Killed"
amplitudes_um_pp = [0.0, 1.2]
[[about_you]]
name = "handedness"
options = ["left", "right"]
prompt = "?"
[[tasks]]
protocol = "magnitude_estimation"
practice = 0
repetitions = 4
scale_top = "none"
"""
KILLED_IN_VOLTS = KILLED.replace("amplitudes_um_pp = [0.0, 1.2]", "voltages_v_peak = [0.0, 60.0]")
KILLED_IN_VOLTS += """[quantity]
name = "voltage"
unit = "V"
convention = "peak"
[plate]
voltage_v_peak = 130.0
tolerance_v_peak = 2.5
"""
# Where the session is killed, one place after the other, and what is pressed before that.
MOMENTS = {
    "between trials": ("estimate", ("1", "2", "comma", "5", "KP_Enter"), "done"),
    "in a text": ("Instruct", (), ""),
    "in a choice": ("handedness", (), ""),
    "at a stroke": ("Explore", (), ""),
    "while typing": ("estimate", ("9", "9"), ""),
    "at Enter": ("estimate", ("1", "2", "comma", "5", "KP_Enter"), ""),
    "in a rest": ("Rest", (), ""),
}


def kinds(journal):
    return [record.kind for record in read_plan(journal)[1]]


def unfelt(records):
    """Return the trials whose estimate was given in a process in which nothing was felt of them."""
    felt, step, found = set(), {}, []
    for record in records:
        if record.kind == "resume":
            felt = set()
        elif record.kind == "begin":
            step = record.data["what"]
        elif record.kind == "represented" or (
            record.kind == "done" and step["type"] == "Explore" and step["trial"]
        ):
            felt.add(step["trial"]["number"])
        elif record.kind == "done" and step.get("name") == "estimate":
            found += [step["trial"]["number"]] if step["trial"]["number"] not in felt else []
    return found


@pytest.mark.skipif(
    "SLIPSCALE_WINDOW_KILLS" not in os.environ,
    reason="minutes; set SLIPSCALE_WINDOW_KILLS=1 (above, one kill while a number is typed)",
)
@pytest.mark.parametrize("in_volts", [False, True])
def test_a_window_that_is_killed_anywhere_loses_no_answer(
    in_volts, start, emulate, tmp_path, plate_in_volts
):
    moments = list(MOMENTS.values())
    (tmp_path / "killed.toml").write_text(KILLED_IN_VOLTS if in_volts else KILLED)
    words = ["run", "killed.toml", "--participant", "01", "--windowed", "--out", "."]
    if in_volts:
        plate = plate_in_volts("serial")
        board = emulate("--plate", str(plate))
        words += ["--plate", f"serial:{board.port},plate={plate}", "--pilot"]
    hand, journal = start(*words, folder=tmp_path), tmp_path / JOURNAL
    while step := hand.next_step(journal):
        left = [each for each in moments if each[0] in (step["type"], step.get("name"))]
        if not left:
            hand.answer(step)
            continue
        moments.remove(left[0])
        _, keys, kind = left[0]
        done = kinds(journal).count(kind)
        if keys:
            hand.press(*keys)
        assert not kind or hand.wait_for(lambda _, k=kind, n=done: kinds(journal).count(k) > n)
        hand.kill()
        before = read_plan(journal)[1]
        hand = start("resume", JOURNAL, "--windowed", folder=tmp_path)
        assert hand.wait_for(lambda shown: shown.number > 0)
        assert read_plan(journal)[1][: len(before)] == before
    status, _, err = hand.end()
    assert (status, err.count("Traceback")) == (0, 0), err
    assert not moments
    assert verify(tmp_path) == []
    assert unfelt(read_plan(journal)[1]) == []
    rows = table_of(tmp_path, "magnitudeestimation")
    assert list(rows["trial"]) == list(range(1, 9))
    assert list(rows["estimate"]) == [12.5] * 8
    if in_volts:
        pairs = zip(rows["voltage_v_peak"], rows["voltage_readback_v_peak"], strict=True)
        assert all(abs(made - asked) <= 2.5 for asked, made in pairs)
