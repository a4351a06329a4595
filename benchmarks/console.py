"""The console: its first paint, what it costs the machine, and what it costs a session's frames.

    .venv/bin/python benchmarks/console.py [--pages 0 1 2 4 8] [--seconds 20] [--loads 10]

A laboratory folder with twelve participants; a stand-in for a session that, like one, looks into
its mailbox at each of 60 frames a second and tells its state five times a second; a console; and so
many pages in a headless Chromium. Frames are late when they begin more than 5 ms after their time.
Each number of pages is measured twice, in turn, so that a machine whose speed drifts treats them
alike.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import IO, Any

from playwright.sync_api import Browser, sync_playwright

PEOPLE = 12
PAGES = ("", "live", "study", "data", "pilot")

SESSION = """
import sys, time
from pathlib import Path
from experiments.journal.journal import Journal
from experiments.session.mailbox import Mailbox, mailbox_of
from experiments.session.operator import SessionStatus
from hardware.clock import SystemClock
path = Path(sys.argv[1])
with Journal.reopen(path, SystemClock()), Mailbox(mailbox_of(path), ("participant 12",)) as box:
    print("running", flush=True)
    for line in sys.stdin:
        frames, late, costs = int(float(line) * 60), 0, []
        began = time.perf_counter()
        for frame in range(frames):
            due = began + frame / 60
            time.sleep(max(due - time.perf_counter(), 0))
            now = time.perf_counter()
            late += now - due > 0.005
            box.poll()
            if frame % 12 == 0:
                box.tell(SessionStatus(state="waiting", trial=1, total=8, done=frame % 9))
            costs.append(time.perf_counter() - now)
        costs.sort()
        usual, most = costs[len(costs) // 2], costs[int(0.99 * frames)]
        print(late, frames, 1e3 * usual, 1e3 * most, flush=True)
"""


def laboratory(folder: Path) -> Path:
    """Fill a laboratory folder with simulated runs; return the journal of an interrupted one."""
    command = [sys.executable, "-P", "-m", "slipscale"]
    subprocess.run([*command, "lab", "init", folder], check=True, stdout=subprocess.DEVNULL)
    pilot = [*command, "pilot", "--participants", str(PEOPLE), "--seed", "1", "--out", "data"]
    subprocess.run(pilot, check=True, cwd=folder, stdout=subprocess.DEVNULL)
    path = max((folder / "data/sourcedata").glob("sub-*/*_journal.jsonl"))
    path.write_bytes(b"".join(path.read_bytes().splitlines(keepends=True)[:60]))
    return path


def processor_s(process: int) -> float:
    """Return the processor time that a process has taken (Linux)."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def asked(session: subprocess.Popen[str], seconds: float) -> list[float]:
    """Have the stand-in run its frames; return late ones, all, and what a frame's work took."""
    stdin, stdout = session.stdin, session.stdout
    if stdin is None or stdout is None:
        raise RuntimeError("the session has no pipes")
    _write(stdin, f"{seconds}\n")
    return [float(word) for word in stdout.readline().split()]


def _write(stream: IO[str], line: str) -> None:
    stream.write(line)
    stream.flush()


def first_paints(browser: Browser, address: str, loads: int) -> None:
    """Print each page's median time to the first contentful paint."""
    page = browser.new_page()
    page.goto(address)
    for name in PAGES:
        times: list[Any] = []
        for _ in range(loads):
            page.goto(f"{address.partition('?')[0]}{name}")
            painted = "performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? 0"
            while not (time_ms := page.evaluate(painted)):
                page.wait_for_timeout(20)
            times.append(time_ms)
        print(f"first paint, {name or 'today':<6} {statistics.median(times):6.0f} ms (median)")
    page.close()


def main() -> None:
    """Print a table: late frames and the console's processor time, by open pages."""
    parser = argparse.ArgumentParser(description="Measure the console.")
    parser.add_argument("--pages", type=int, nargs="+", default=[0, 1, 2, 4, 8])
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--loads", type=int, default=10)
    options = parser.parse_args()
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with tempfile.TemporaryDirectory() as place, sync_playwright() as play:
        folder = Path(place, "lab")
        journal = laboratory(folder)
        console = subprocess.Popen(
            [sys.executable, "-P", "-m", "slipscale", "lab", "--no-browser", "--port", "0"],
            cwd=folder,
            stdout=subprocess.PIPE,
            text=True,
        )
        session = subprocess.Popen(
            [sys.executable, "-P", "-c", SESSION, journal],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        rights = ["--no-sandbox"] if os.geteuid() == 0 else []
        browser = play.chromium.launch(executable_path=chromium, args=rights)
        try:
            if console.stdout is None or session.stdout is None:
                raise RuntimeError("no pipes")
            address = console.stdout.readline().split()[-1]
            session.stdout.readline()
            first_paints(browser, address, options.loads)
            print("pages   late frames        a frame's work (median, 99 %)   console's processor")
            for count in options.pages * 2:
                context = browser.new_context()
                for _ in range(count):
                    context.new_page().goto(address)
                before = processor_s(console.pid)
                late, frames, median_ms, most_ms = asked(session, options.seconds)
                share = (processor_s(console.pid) - before) / options.seconds
                context.close()
                print(
                    f"{count:>5}   {late:4.0f} of {frames:5.0f}       {median_ms:6.3f} ms, "
                    f"{most_ms:6.3f} ms              {100 * share:5.1f} %"
                )
        finally:
            browser.close()
            session.kill()
            console.kill()


if __name__ == "__main__":
    main()
