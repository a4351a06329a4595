"""Published studies as real sessions: a window, an emulated board, sensors, a kill and a resume.

Minutes per study: set SLIPSCALE_WINDOW_STUDIES=1. Shortened studies present every kind of stimulus
and question; textures follow the finger that a sensor line reports.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from contextlib import ExitStack

import pytest

from slipscale.experiments.dataset.verification import verify
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.study.file import study_text
from tests.experiments.running.test_run_window import JOURNAL, table_of
from tests.support.session_window import SessionWindow

pytestmark = [
    pytest.mark.window,
    pytest.mark.skipif(
        not sys.platform.startswith("linux")
        or not shutil.which("xdotool")
        or "SLIPSCALE_WINDOW_STUDIES" not in os.environ,
        reason="minutes; set SLIPSCALE_WINDOW_STUDIES=1 (under X11, with xdotool)",
    ),
]

ALONE = "practice = 0\ncatch_trials = 0"
#: Study -> its task in file names, what is shortened, and the number of trials that remain.
STUDIES = {
    "samur2009": ("differencethreshold", {"most_trials = 30": f"most_trials = 2\n{ALONE}"}, 4),
    "biet2008": ("constantstimuli", {"repetitions = 20": f"repetitions = 1\n{ALONE}"}, 6),
    "saleem2020": ("magnitudeestimation", {"repetitions = 3": "repetitions = 1\npractice = 0"}, 5),
    "bernard2020": ("detectionthreshold", {"most_trials = 30": f"most_trials = 1\n{ALONE}"}, 2),
    "meyer2015": ("samedifferent", {"repetitions = 8": f"repetitions = 1\n{ALONE}"}, 6),
    "hollins1993": ("sorting", {"groups = 7": "groups = 7\nrepetitions = 1"}, 7),
    "gueorguiev2017": (  # a change at a position
        "differencethreshold",
        {"most_trials = 30": f"most_trials = 2\n{ALONE}"},
        4,
    ),
    "monnoyer2016": (  # a change at a force
        "magnitudeestimation",
        {"repetitions = 3": "repetitions = 1\npractice = 0"},
        6,
    ),
    "vezzoli2015": (  # two actuators: the board, and a simulated one
        "magnitudeestimation",
        {"repetitions = 2": "repetitions = 1\npractice = 0", "[0.6, 1.0, 1.5, 2.3]": "[0.6, 2.3]"},
        4,
    ),
    "pointing2023": (
        "pointing",
        {
            "[20.0, 40.0, 80.0]": "[80.0]",
            "[4.0, 10.0]": "[10.0]",
            "movements = 15": "movements = 2\npractice = 1",
        },
        5,
    ),
}
STROKE_S = 1.0  # the least time for which a person strokes a surface
AIM_S = 0.5  # the least time between two places that a person points at
CENTRE_PX, SCREEN_PX = (640, 400), 800


class Person(SessionWindow):
    """Answers each kind of question by what it asks."""

    def answer(self, step):
        question = step.get("question") or {}
        if step["type"] == "Explore":
            time.sleep(STROKE_S)
        if step["type"] != "Ask":
            self.press("space")
        elif "start_mm" in question:
            for place in ("start_mm", "target_mm"):
                self.click(question[place], question["screen_height_mm"])
        elif "options" in question:
            self.press("1")
        elif "minimum" in question:
            self.press("2", "Return")
        elif "positive" in question:
            self.press("1", "2", "Return")
        else:
            self.press("y")

    def click(self, place_mm, height_mm):
        x, y = (round(each / height_mm * SCREEN_PX) for each in place_mm)
        # The window fills the screen.
        at = (str(CENTRE_PX[0] + x), str(CENTRE_PX[1] - y))
        subprocess.run(["xdotool", "mousemove", *at, "click", "1"], check=True)
        time.sleep(AIM_S)


@pytest.fixture
def start(display):
    """Start a command with a window; whatever happens, nothing is left running."""
    with ExitStack() as started:
        yield lambda *words, folder: started.enter_context(Person(*words, folder=folder))


@pytest.fixture
def lines():
    """Return the ports of two emulated sensors, each in its own process."""
    words = [sys.executable, "-m", "slipscale.hardware.contact.emulated_line"]
    started = [
        subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    yield [process.stdout.readline().split()[-1] for process in started]
    for process in started:
        process.kill()
        process.communicate()


def assert_the_stroke_decides(rows):
    """Each interval is within 30 % of its condition's speed, or its trial is rejected."""
    for _, row in rows.iterrows():
        outcomes = []
        for number in (1, 2):
            speed = float(row[f"interval{number}_exploration_speed_mm_s"])
            share = speed / float(row["finger_speed_mm_s"]) - 1
            expected = "within" if abs(share) <= 0.3 else "too_fast" if share > 0 else "too_slow"
            assert row[f"interval{number}_stroke"] == expected
            outcomes.append(expected)
        assert ("voided" in row["flag"]) is (set(outcomes) != {"within"})


@pytest.mark.parametrize("name", STUDIES)
def test_a_published_study_is_run_killed_resumed_and_whole(name, start, emulate, lines, tmp_path):
    task, changes, trials = STUDIES[name]
    text = study_text(name)
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    (tmp_path / f"{name}.toml").write_text(text, "utf-8")
    board = emulate()
    places, forces = lines
    pointed = name == "pointing2023"
    paired = name == "vezzoli2015"
    position = {"pointing2023": "mouse:mm_per_pixel=0.375", "gueorguiev2017": "emulated_stage"}
    person = start(
        *("run", f"{name}.toml", "--participant", "01", "--windowed", "--out", ".", "--pilot"),
        *("--plate", f"pair:serial:{board.port}+mock" if paired else f"serial:{board.port}"),
        *("--position", position.get(name, f"lasers:{places}")),
        *("--force", f"load_cells:{forces},normal=3,lateral=4"),
        folder=tmp_path,
    )
    journal, seen, before = tmp_path / JOURNAL, 0, []
    while step := person.next_step(journal):
        seen += step["trial"] is not None
        if seen == 3 and not before:
            person.kill()
            before = read_plan(journal)[1]
            person = start("resume", JOURNAL, "--windowed", folder=tmp_path)
            continue
        person.answer(step)
    status, _, err = person.end()
    assert (status, err.count("Traceback")) == (0, 0), err
    records = read_plan(journal)[1]
    assert before
    assert records[: len(before)] == before
    assert records[-1].kind == "end"
    assert verify(tmp_path) == []
    rows = table_of(tmp_path, task)
    repeated = (rows["repeats"] != "n/a").sum()
    assert len(rows) == trials + repeated
    if name == "bernard2020":
        assert_the_stroke_decides(rows)
    else:
        assert not any(record.kind == "void" for record in records)
    if name in ("gueorguiev2017", "monnoyer2016"):
        changes = rows[[column for column in rows if column.endswith("changes")]].astype(float)
        assert changes.size >= len(rows)
        assert (changes > 0).all(axis=None)
    if paired:
        off = rows["second_readback_v_peak"].astype(float) - rows["second_voltage_v_peak"]
        assert off.abs().max() < 5
    if pointed:
        assert set(rows["selection"]) == {"target"}
    else:
        assert any(record.kind == "contact" for record in records)
