"""The session that `benchmarks/console.py` measures: a real window, keys, and a mailbox.

Reads a number of seconds from each line of its input; for so long it asks questions in the window,
has a thread press the key at random moments (as `benchmarks/response_times.py` does), and looks
into its mailbox at each frame as a session does. Answers with a line of JSON.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from itertools import pairwise
from pathlib import Path

from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.languages.texts import load_texts
from slipscale.experiments.participants.psychopy_window import PsychoPyWindow
from slipscale.experiments.protocols.steps import Ask, YesNoQuestion
from slipscale.experiments.session.mailbox import Mailbox, mailbox_of
from slipscale.experiments.session.operator import SessionStatus
from slipscale.hardware.clock import SystemClock

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from benchmarks.response_times import Finger

TELL_S = 0.2  # a session tells its state between steps; this one more often


def measure(
    window: PsychoPyWindow, box: Mailbox, finger: Finger, seconds: float
) -> dict[str, list[float]]:
    """Return times between frames, what the mailbox took of a frame, and lags of keys, in ms."""
    frames: list[float] = []
    work: list[float] = []
    lags: list[float] = []
    step = Ask(name="x", question=YesNoQuestion(prompt="?"))
    end_s = time.perf_counter() + seconds
    told_s = 0.0
    while time.perf_counter() < end_s:
        shown: list[float] = []
        hand = threading.Thread(target=finger.press)

        def watch(shown: list[float] = shown, hand: threading.Thread = hand) -> None:
            nonlocal told_s
            now_s = time.perf_counter()
            shown.append(now_s)
            box.poll()
            if now_s - told_s > TELL_S:
                told_s = now_s
                box.tell(SessionStatus(state="waiting", trial=1, total=8, done=len(lags) % 9))
            work.append((time.perf_counter() - now_s) * 1000)
            if len(shown) == 2:  # the question is on the screen
                hand.start()

        window._await_release(lambda: None)  # noqa: SLF001  so that frame 2 is the question's
        reply = window.perform(step, watch)
        hand.join()
        if reply.onset_s is None or reply.response_time_s is None:
            raise RuntimeError("the window did not time a key")
        lags.append((reply.onset_s + reply.response_time_s - finger.pressed_s) * 1000)
        frames += [(later - sooner) * 1000 for sooner, later in pairwise(shown)]
    return {"frames_ms": frames, "work_ms": work, "lags_ms": lags}


def main() -> None:
    """Answer until the input ends."""
    path = Path(sys.argv[1])
    clock = SystemClock()
    finger = Finger(clock)
    with (
        Journal.reopen(path, clock),
        Mailbox(mailbox_of(path), ("participant 12",)) as box,
        PsychoPyWindow(
            texts=load_texts("en"), clock=clock, pilot=False, precise_times=True
        ) as window,
    ):
        print("running", flush=True)
        for line in sys.stdin:
            print(json.dumps(measure(window, box, finger, float(line))), flush=True)


if __name__ == "__main__":
    main()
