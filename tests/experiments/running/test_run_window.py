"""``slipscale run`` as a lab runs it: its own process, a real window, a hand on the keyboard."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

from slipscale.experiments.dataset.verification import verify
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.session.mailbox import LiveRequest, post, read_status
from slipscale.experiments.study.file import study_text

pytestmark = [
    pytest.mark.clock,
    pytest.mark.window,
    pytest.mark.skipif(
        not sys.platform.startswith("linux") or not shutil.which("xdotool"),
        reason="key presses come from xdotool, under X11",
    ),
]

SLIPSCALE = Path(sys.executable).with_name("slipscale")
JOURNAL = "sourcedata/sub-01/sub-01_run-01_journal.jsonl"
SAID = "moins glissé, ça colle à peine où"
PATIENCE_S = 60.0
SHOWN = ("Instruct", "Explore", "Ask", "Rest", "EndBlock")


class Hand:
    """A person who reads the journal over the session's shoulder and presses what fits."""

    def __init__(self, process, folder):
        self.process = process
        self.journal = folder / JOURNAL
        self.answered = -1
        self.retry = None
        self.size = 0  # of the journal when it was last read

    def press(self, *words):
        subprocess.run(["xdotool", *words], check=True)

    def step(self):
        """Wait for the next step that needs an answer; return what it is, or None at the end."""
        deadline = time.monotonic() + PATIENCE_S
        again = time.monotonic() + 4.0
        while time.monotonic() < deadline:
            if self.retry and time.monotonic() > again:
                # On a loaded machine a key can come before its screen.
                self.press("key", self.retry)
                again += 4.0
            if self.process.poll() is not None:
                return None
            size = self.journal.stat().st_size if self.journal.exists() else 0
            if size != self.size:
                self.size = size
                last = read_plan(self.journal)[1][-1]
                new = last.number > self.answered
                if new and last.kind == "take_up":
                    # The surface is presented again, and must be stroked again.
                    self.answered = last.number
                    self.retry = "space"
                elif new and last.kind == "fault" and (status := read_status(self.journal)):
                    # On a loaded machine a board or a sensor can miss its time.
                    self.answered = last.number
                    post(self.journal, LiveRequest(token=status.token, what="retry"))
                elif new and last.kind == "begin" and last.data["what"]["type"] in SHOWN:
                    self.answered = last.number
                    self.retry = None
                    # The screen is up a few frames after the record: longer where others run too.
                    busy = os.getloadavg()[0] / (os.cpu_count() or 1)
                    time.sleep(0.4 * min(max(1.0, busy), 4.0))
                    return last.data["what"]
            time.sleep(0.02)
        pytest.fail(f"the session did not go on after {read_plan(self.journal)[1][-1]}")

    def answer(self, step):
        """Answer a step as a sensible person would."""
        name = step.get("name")
        self.retry = {None: "space", "difference_felt": "o", "age_band": "1", "gender": "1"}.get(
            name, "Return"
        )
        if name is None:
            self.press("key", "space")
        elif name in ("estimate", "scale_top"):
            self.press("key", "1", "2", "comma", "5", "KP_Enter")
        elif name == "difference_felt":
            self.press("key", "o")
        elif name == "verbal_report":
            # xdotool types accents faithfully only where the layout has keys for them; the server
            # forgets the layout with its last window.
            subprocess.run(["setxkbmap", "fr"], check=True)
            self.press("type", "--delay", "20", SAID)
            self.press("key", "Return")
        else:
            self.press("key", "1")

    def until(self, name):
        """Answer everything until a question of that name is on the screen; return it."""
        while step := self.step():
            if step.get("name") == name:
                return step
            self.answer(step)
        return pytest.fail(f"the session ended before it asked for {name}")


@pytest.fixture
def start(display):
    """Start the command; whatever happens, nothing is left running."""
    started = []

    def begin(*words, folder):
        started.append(_popen(*words, folder=folder))
        return started[-1]

    yield begin
    for process in started:
        process.kill()
        process.communicate()


def _popen(*words, folder):
    return subprocess.Popen(
        [SLIPSCALE, *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
        env=os.environ | {"HOME": str(folder)},
    )


def table_of(folder, task):
    path = folder / f"sub-01/beh/sub-01_task-{task}_run-01_beh.tsv"
    return pd.read_csv(path, sep="\t", keep_default_na=False)


def test_a_session_from_welcome_to_thanks_with_escape_kill_and_resume(start, tmp_path):
    """One long afternoon: Escape and no, Escape and yes, resume, power cut, resume, the end."""
    shorter = study_text("biet2007").replace("[0.0, 0.5, 1.2, 2.3]", "[0.0, 1.2]")
    (tmp_path / "shorter.toml").write_text(shorter, encoding="utf-8")
    run = ("run", "shorter.toml", "--participant", "01", "--windowed", "--language", "fr")
    process = start(*run, "--out", ".", folder=tmp_path)
    hand = Hand(process, tmp_path)
    hand.until("difference_felt")
    hand.press("key", "Escape")
    time.sleep(1.0)
    hand.press("key", "n")  # do not stop
    time.sleep(1.0)
    hand.answer({"name": "difference_felt"})
    hand.until("scale_top")
    hand.press("key", "Escape")
    time.sleep(1.0)
    hand.press("key", "o")  # stop
    out, err = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, err.count("Traceback")) == (130, 0)
    assert f"slipscale resume {JOURNAL}" in out
    assert read_plan(tmp_path / JOURNAL)[1][-1].kind == "stop"

    resume = ("resume", JOURNAL, "--windowed")
    process = start(*resume, folder=tmp_path)
    hand.process = process
    hand.until("estimate")
    hand.answer({"name": "estimate"})
    hand.until("estimate")
    hand.press("key", "9", "9")  # half an answer
    time.sleep(0.5)
    before = read_plan(hand.journal)[1]
    process.send_signal(signal.SIGKILL)
    process.communicate()

    process = start(*resume, folder=tmp_path)
    hand.process = process
    while step := hand.step():
        hand.answer(step)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, err.count("Traceback")) == (0, 0), err
    records = read_plan(hand.journal)[1]
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
    process = start(
        *("run", "aged.toml", "--participant", "01", "--windowed", "--out", "."), folder=tmp_path
    )
    hand = Hand(process, tmp_path)
    hand.until("age_years")
    hand.press("key", "1", "7", "Return")  # refused
    hand.press("key", "3", "4")
    time.sleep(1.0)
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, err.count("Traceback")) == (130, 0), err
    records = read_plan(tmp_path / JOURNAL)[1]
    assert records[-1].kind == "stop"
    (left,) = [record.data for record in records if record.kind == "unfinished"]
    assert (left["name"], left["entry"], list(left["rejected"])) == ("age_years", "34", ["17"])

    process = start("run", "aged.toml", "--participant", "01", "--out", ".", folder=tmp_path)
    _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 2
    assert f"slipscale resume {JOURNAL}" in err

    hand.process = process = start("resume", JOURNAL, "--windowed", folder=tmp_path)
    hand.until("age_years")
    hand.press("key", "Return")  # it stands there already
    hand.retry = "Return"
    assert hand.step()["type"] == "Instruct"
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=PATIENCE_S)
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
    "in a text": ("Instruct", (), None),
    "in a choice": ("handedness", (), None),
    "at a stroke": ("Explore", (), None),
    "while typing": ("estimate", ("9", "9"), None),
    "at Enter": ("estimate", ("1", "2", "comma", "5", "KP_Enter"), None),
    "in a rest": ("EndBlock", (), None),
}


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
    hand = Hand(start(*words, folder=tmp_path), tmp_path)
    while step := hand.step():
        left = [each for each in moments if each[0] in (step["type"], step.get("name"))]
        if not left:
            hand.answer(step)
            continue
        moments.remove(left[0])
        _, keys, kind = left[0]
        if keys:
            hand.press("key", *keys)
        while kind and read_plan(hand.journal)[1][-1].number <= hand.answered:
            time.sleep(0.005)
        before = read_plan(hand.journal)[1]
        hand.process.send_signal(signal.SIGKILL)
        hand.process.communicate()
        hand.process = start("resume", JOURNAL, "--windowed", folder=tmp_path)
        while len(read_plan(hand.journal)[1]) <= len(before):
            assert hand.process.poll() is None, hand.process.communicate()
            time.sleep(0.05)
        assert read_plan(hand.journal)[1][: len(before)] == before
    _, err = hand.process.communicate(timeout=PATIENCE_S)
    assert (hand.process.returncode, err.count("Traceback")) == (0, 0), err
    assert not moments
    assert verify(tmp_path) == []
    assert unfelt(read_plan(hand.journal)[1]) == []
    rows = table_of(tmp_path, "magnitudeestimation")
    assert list(rows["trial"]) == list(range(1, 9))
    assert list(rows["estimate"]) == [12.5] * 8
    if in_volts:
        pairs = zip(rows["voltage_v_peak"], rows["voltage_readback_v_peak"], strict=True)
        assert all(abs(made - asked) <= 2.5 for asked, made in pairs)
