"""The console: its first paint, and what it costs a running session: frames and times of keys.

    xvfb-run -s "-screen 0 1280x800x24" .venv/bin/python benchmarks/console.py [--write]

A laboratory folder with twelve participants; a session with a real PsychoPy window that looks into
its mailbox at each frame, tells its state five times a second, and is answered by a thread that
notes when it presses (`benchmarks/console_session.py`); a console; and so many pages in a headless
Chromium. A frame is late where it comes more than half a frame after its time. Each number of pages
is measured twice, in turn, so that a machine whose speed drifts treats them alike. Some two and a
half minutes.

``--write`` puts the tables into docs/how-to/console.md, in place of those that are there.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, sync_playwright

PEOPLE = 12
PAGES = ("", "live", "study", "data", "pilot")
HERE = Path(__file__).resolve().parent
DOCS = HERE.parent / "docs" / "how-to" / "console.md"
MARK = "<!-- benchmarks/console.py writes what follows -->"
END = "<!-- end of what benchmarks/console.py writes -->"
LATE = 1.5  # frames


@dataclass(slots=True)
class Cost:
    """What was measured with so many pages open, over all rounds."""

    frames_ms: list[float] = field(default_factory=list)
    work_ms: list[float] = field(default_factory=list)
    lags_ms: list[float] = field(default_factory=list)
    processor_s: float = 0.0
    seconds: float = 0.0

    def row(self, pages: int, frame_ms: float) -> str:
        """Return a line of the table."""
        late = sum(time_ms > LATE * frame_ms for time_ms in self.frames_ms)
        lags, work = self.lags_ms, self.work_ms
        cells = [
            f"{pages}",
            f"{late} of {len(self.frames_ms)} ({100 * late / len(self.frames_ms):.1f} %)",
            f"{statistics.median(work):.2f}, {quantile(work, 0.99):.2f}",
            f"{len(lags)}",
            f"{statistics.median(lags):.2f}, {quantile(lags, 0.975):.2f}",
            f"{100 * self.processor_s / self.seconds:.1f} %",
        ]
        return f"| {' | '.join(cells)} |"


HEADING = (
    "| pages | late frames | a frame's work for the mailbox, ms (median, 99 %) | keys | "
    "recorded minus true time of a key, ms (median, 97.5 %) | the console's share of a "
    "core |\n| --- | --- | --- | --- | --- | --- |"
)


def quantile(values: list[float], share: float) -> float:
    """Return the value below which a share of them lies."""
    return sorted(values)[min(int(share * len(values)), len(values) - 1)]


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


def lines_of(process: subprocess.Popen[str], asked: str = "") -> str:
    """Write a line to a process, if there is one to write; return the next that it says."""
    if process.stdin is not None and asked:
        process.stdin.write(asked)
        process.stdin.flush()
    if process.stdout is None or not (line := process.stdout.readline()):
        raise RuntimeError(f"process {process.args!r} ended")
    return line


def first_paints(browser: Browser, address: str, loads: int) -> list[str]:
    """Return each page's median time to the first contentful paint, in words."""
    page = browser.new_page()
    page.goto(address)
    told = []
    for name in PAGES:
        times: list[Any] = []
        for _ in range(loads):
            page.goto(f"{address.partition('?')[0]}{name}")
            painted = "performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? 0"
            while not (time_ms := page.evaluate(painted)):
                page.wait_for_timeout(20)
            times.append(time_ms)
        told.append(f"{name or 'today'} {statistics.median(times):.0f} ms")
    page.close()
    return told


def costs(
    browser: Browser,
    address: str,
    processes: tuple[subprocess.Popen[str], subprocess.Popen[str]],
    counts: list[int],
    seconds: float,
) -> dict[int, Cost]:
    """Return what so many pages cost, each number measured twice, in turn."""
    console, session = processes
    found = {count: Cost() for count in counts}
    for count in counts * 2:
        context = browser.new_context()
        for _ in range(count):
            context.new_page().goto(address)
        before_s = processor_s(console.pid)
        told = json.loads(lines_of(session, f"{seconds}\n"))
        cost = found[count]
        cost.processor_s += processor_s(console.pid) - before_s
        cost.seconds += seconds
        for name, values in told.items():
            getattr(cost, name).extend(values)
        context.close()
    return found


def main() -> None:
    """Measure; print the tables, and write them where the documentation has them."""
    parser = argparse.ArgumentParser(description="Measure the console.")
    parser.add_argument("--pages", type=int, nargs="+", default=[0, 1, 2, 4, 8])
    parser.add_argument("--seconds", type=float, default=8.0, help="of each of two rounds")
    parser.add_argument("--loads", type=int, default=7, help="of each page, for the first paint")
    parser.add_argument(
        "--write", action="store_true", help="write the tables to docs/how-to/console.md"
    )
    options = parser.parse_args()
    load_before = os.getloadavg()[0]
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with tempfile.TemporaryDirectory() as place, sync_playwright() as play:
        folder = Path(place, "lab")
        journal = laboratory(folder)
        pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "text": True}
        console = subprocess.Popen(
            [sys.executable, "-P", "-m", "slipscale", "lab", "--no-browser", "--port", "0"],
            cwd=folder,
            **pipes,
        )
        session = subprocess.Popen(
            [sys.executable, HERE / "console_session.py", journal], stdin=subprocess.PIPE, **pipes
        )
        rights = ["--no-sandbox"] if os.geteuid() == 0 else []
        browser = play.chromium.launch(executable_path=chromium, args=rights)
        try:
            address = lines_of(console).split()[-1]
            while lines_of(session) != "running\n":
                pass  # what PsychoPy says as it starts
            paints = first_paints(browser, address, options.loads)
            processes = (console, session)
            found = costs(browser, address, processes, options.pages, options.seconds)
        finally:
            browser.close()
            session.kill()
            console.kill()
            session.wait()
            console.wait()
    frame_ms = statistics.median([time for cost in found.values() for time in cost.frames_ms])
    rows = [cost.row(pages, frame_ms) for pages, cost in sorted(found.items())]
    said = (
        f"First paint (median): {', '.join(paints)}.\n\n{HEADING}\n" + "\n".join(rows) + "\n\n"
        f"{datetime.now(UTC):%Y-%m-%d}, {os.cpu_count()} cores, load {load_before:.1f} before it "
        f"began, Python {platform.python_version()}, a virtual screen with frames of "
        f"{frame_ms:.1f} ms."
    )
    print(said)
    if options.write:
        text = DOCS.read_text(encoding="utf-8")
        new = f"{MARK}\n\n{said}\n\n{END}"
        DOCS.write_text(
            re.sub(f"{MARK}.*{END}", lambda _: new, text, flags=re.DOTALL), encoding="utf-8"
        )


if __name__ == "__main__":
    main()
