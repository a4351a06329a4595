"""Prepare a laboratory folder and its running console for screenshots."""

from __future__ import annotations

import base64
import io
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipscale.experiments.lab.console.actions.folder import power_folder

if TYPE_CHECKING:
    from playwright.sync_api import Page


LONGEST_MS = 120_000.0
COMMAND = [sys.executable, "-P", "-m", "slipscale"]
# A stand-in for a session: it reports a given status and locks the journal.
SESSION = """
import json, sys, threading, time
from pathlib import Path
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.journal.plan_and_progress import latest_s, read_plan
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.steps import Ask
from slipscale.experiments.steps.trial import Trial
from slipscale.experiments.session.mailbox import Mailbox, mailbox_of
from slipscale.experiments.session.operator import SessionStatus
from slipscale.hardware.clock import SystemClock
path = Path(sys.argv[1])
heading = ("participant 08, run 01", "study mine", "plate serial:/dev/ttyACM0")
usual = {"state": "waiting", "task": "t", "trial": 5, "total": 8, "done": 9, "planned": 12,
    "elapsed_s": 412.0, "time_left_s": 138.0, "plate": "as commanded", "noise": "playing",
    "temperature_c": 23.4, "voidable": Trial(task="t", number=5, total=8),
    "answered": Trial(task="t", number=4, total=8)}
clock = SystemClock(latest_s(read_plan(path)[1]))
with Journal.reopen(path, clock) as journal, Mailbox(mailbox_of(path), heading) as box:
    def beat():
        while True:
            box.poll()
            time.sleep(0.5)
    threading.Thread(target=beat, daemon=True).start()
    journal.write("note", text="the heating came on; a door slammed twice in the corridor")
    for line in sys.stdin:
        told = json.loads(line)
        if prompt := told.pop("answering", ""):
            question = NumberQuestion(prompt=prompt)
            told["answering"] = Ask(name="estimate", question=question, by="operator")
        box.tell(SessionStatus(**usual | told))
        print("told", flush=True)
"""


def journals(folder: Path) -> list[Path]:
    """Return the journals of a laboratory folder's participants, in order."""
    return sorted((folder / "data/sourcedata").glob("sub-*/*_journal.jsonl"))


def cut(journal: Path, lines: int) -> None:
    """Interrupt a run after a number of records."""
    journal.write_bytes(b"".join(journal.read_bytes().splitlines(keepends=True)[:lines]))


def laboratory(folder: Path) -> None:
    """Create a laboratory folder: eight participants, the last one interrupted, and an analysis."""
    folder.mkdir()
    slipscale(folder, "study", "new", "mine.toml", "--title", "Slipperiness", "--author", "A. B.")
    with (folder / "mine.toml").open("a") as file:
        file.write('\n[analysis]\nexclusions = ["constant", "zeros"]\n')
    plate = "serial:/dev/ttyACM0,calibration=plate.toml"
    slipscale(folder, "lab", "init", ".", "--study", "mine.toml", "--plate", plate)
    slipscale(folder, "pilot", "--participants", "8", "--seed", "1", "--out", "data")
    slipscale(folder, "pilot", "--participants", "3", "--seed", "2")
    last = journals(folder)[-1]
    lines = last.read_bytes().splitlines(keepends=True)
    strokes = [at for at, line in enumerate(lines) if b'"begin"' in line and b'"Explore"' in line]
    last.write_bytes(b"".join(lines[: strokes[-3] + 1]))


def slipscale(folder: Path, *words: str) -> None:
    """Run a command in a folder."""
    quiet = subprocess.DEVNULL
    subprocess.run([*COMMAND, *words], cwd=folder, check=True, stdout=quiet, stderr=quiet)


class Stage:
    """Laboratory folder with a running console; the methods change what the pages show."""

    def __init__(self, folder: Path, page: Page, address: str) -> None:
        self.folder = folder
        # This page stays open, because the console ends jobs on the plate when no page is open.
        self._page = page
        self._address = address
        self._session: subprocess.Popen[str] | None = None

    def do(self, action: str, until: str, path: str = "bench", **fields: Any) -> None:
        """Request an action, and wait until a page contains the element ``until``."""
        self._page.goto(self._address + path)
        answer = self._page.request.post(
            f"{self._address}do/{action}",
            data=fields,
            headers={"origin": self._address.rstrip("/"), "x-slipscale": "1"},
        )
        if not answer.ok:
            raise RuntimeError(f"{action}: {answer.text()}")
        self._page.locator(until).first.wait_for(state="attached", timeout=LONGEST_MS)

    def tell(self, **changes: Any) -> None:
        """Start a simulated session if none is running, and make it report these values."""
        if self._session is None:
            self._session = subprocess.Popen(
                [*COMMAND[:-2], "-c", SESSION, journals(self.folder)[-1]],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
        if self._session.stdin is None or self._session.stdout is None:
            raise RuntimeError("the session has no pipes")
        self._session.stdin.write(json.dumps(changes) + "\n")
        self._session.stdin.flush()
        self._session.stdout.readline()

    def end(self) -> None:
        """End the running session."""
        if self._session and self._session.stdin:
            self._session.stdin.close()
            self._session.wait()
        self._session = None

    def unblind(self) -> None:
        """End the session and unblind."""
        self.end()
        record = [{"unblinded_utc": "2026-11-20T09:00:00+00:00", "done": 7, "planned": 12}]
        (self.folder / "data/sourcedata/unblinded.json").write_text(json.dumps(record))

    def damage(self) -> None:
        """Damage a journal, and edit the study."""
        lines = journals(self.folder)[2].read_bytes().splitlines(keepends=True)
        journals(self.folder)[2].write_bytes(b"".join([*lines[:9], b"rubbish\n", *lines[10:]]))
        study = self.folder / "mine.toml"
        study.write_text(study.read_text().replace("seed = 2007", "seed = 2008"))

    def upload(self, table: str) -> None:
        """Upload a table, and wait for its description."""
        self._upload("outcomes.csv", table.encode(), "#choices form")

    def upload_workbook(self, table: str) -> None:
        """Upload a table as the second sheet of a workbook."""
        import openpyxl

        book, stored = openpyxl.Workbook(), io.BytesIO()
        rows = [line.split(",") for line in table.splitlines()]
        for name, cells in (("notes", rows[:2]), ("data", rows)):
            sheet = book.create_sheet(name)
            for row in cells:
                sheet.append(row)
        book.save(stored)
        self._upload("outcomes.xlsx", stored.getvalue(), "select[name=sheet]")

    def _upload(self, name: str, content: bytes, until: str) -> None:
        sent = {"name": name, "content": base64.b64encode(content).decode()}
        self.do("upload", until, "table", tables=[sent])

    def describe(self, choices: dict[str, Any], until: str) -> None:
        """Describe the uploaded table with some choices."""
        self.do("describe", until, "table", number="001", **choices)

    def report(self, choices: dict[str, Any]) -> None:
        """Describe the uploaded table, and make its report."""
        self.describe(choices, "[value=report]")
        self.do("report", "#table-report a", "table", number="001", **choices)

    def hide(self, *names: str) -> None:
        """Restore hidden files and folders, then move others out of the laboratory folder."""
        aside = self.folder.with_name("aside")
        aside.mkdir(exist_ok=True)
        for path in aside.iterdir():
            path.rename(self.folder / path.name)
        for name in names:
            (self.folder / name).rename(aside / name)

    def use(self, plate: str) -> None:
        """Use another plate."""
        settings = self.folder / "slipscale.toml"
        settings.write_text(re.sub("(?m)^plate.*$", f'plate = "{plate}"', settings.read_text()))

    def calibrate(self, until: str, **fields: str) -> None:
        """Stop the job that uses the plate, and calibrate the plate."""
        self.do("release", "#running:not([data-hold])")
        self.do("calibrate", until, by="Ada", instrument="OFV-5000", **fields)

    def plan(self) -> None:
        """Compute the power of a few conditions."""
        study = self.folder / "mine.toml"
        grid = (
            "--participants",
            "6",
            "12",
            "24",
            "--effect",
            "1",
            "0.5",
            "--repetitions",
            "1",
            "2",
        )
        out = self.folder / power_folder(study.read_text())
        slipscale(self.folder, "power", study.name, *grid, "--studies", "20", "--out", str(out))

    def edit(self, old: str, new: str) -> None:
        """Replace a part of the study."""
        study = self.folder / "mine.toml"
        study.write_text(study.read_text().replace(old, new))

    def lose(self) -> None:
        """Remove the study file."""
        (self.folder / "mine.toml").unlink()

    def spoil(self) -> None:
        """Add an unknown key to the settings."""
        with (self.folder / "slipscale.toml").open("a") as file:
            file.write("colour = 3\n")
