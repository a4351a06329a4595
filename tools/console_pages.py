"""Take screenshots of every console page in both themes and two widths; run axe-core on the pages.

Usage: python tools/console_pages.py FOLDER [--axe axe.min.js] [--language fr] [--only NAME ...]
       python tools/console_pages.py docs/images --documentation

Without --axe, npm downloads axe-core to a temporary folder. The exit status is 1 if axe-core finds
a serious or critical problem. Requires Chromium, but no display.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
from contextlib import contextmanager
from http import HTTPStatus
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from playwright.sync_api import sync_playwright

from slipscale.experiments.dataset.backup import NO_BACKUP
from slipscale.experiments.lab.console.actions.folder import power_folder
from slipscale.experiments.lab.console.page_texts import LANGUAGES
from slipscale.hardware.errors import ConnectionLost

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from playwright.sync_api import Browser, Error, Page, Response, StorageState, ViewportSize

AXE = "axe-core@4.14.1"
WIDTHS = {"wide": 1400, "phone": 400, "4k": 3840}
THEMES: tuple[Literal["light", "dark"], ...] = ("light", "dark")
DOCUMENTED = {"today": 1000, "live": 1150, "data": 1150}  # scene -> height of the screenshot
GRAVE = ("serious", "critical")
FRESH_S = 1.2  # the console reads its folder once per second
LONGEST_MS = 120_000.0
COMMAND = [sys.executable, "-P", "-m", "slipscale"]

# A stand-in for a session: it reports a given status and locks the journal.
SESSION = """
import json, sys, threading, time
from pathlib import Path
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.journal.plan_and_progress import latest_s, read_plan
from slipscale.experiments.steps.questions import NumberQuestion
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
    """A laboratory folder with its console, and changes to make between two screenshots."""

    def __init__(self, folder: Path, page: Page, address: str) -> None:
        self.folder = folder
        self._page = page  # stays open: what uses the plate ends without a page
        self._address = address
        self._session: subprocess.Popen[str] | None = None

    def do(self, action: str, until: str, path: str = "bench", **fields: Any) -> None:
        """Ask the console for an action; wait until a page shows an element."""
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
        """Make a session run that reports these values."""
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

    def hide(self, *names: str) -> None:
        """Move files and folders of the laboratory away, and those moved away earlier back."""
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
        """End what uses the plate, and calibrate it."""
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
        """Write a fault into the settings."""
        with (self.folder / "slipscale.toml").open("a") as file:
            file.write("colour = 3\n")


def nothing(_: Stage) -> None:
    """Change nothing."""


UNREACHABLE = "--backup /media/disk: no such folder; connect its disk, or create it"
NOTHING = "nothing"  # an address without a page


PAGES = ("live", "study", "planning", "data", "pilot", "bench", "settings", "screens")

# Name of a screenshot -> preparation, page, and selector of the button to press.
SCENES: dict[str, tuple[Callable[[Stage], object], str, str]] = {
    "today-new": (lambda stage: stage.hide("slipscale.toml", "data", "pilots"), "", ""),
    **{f"{page}-new": (nothing, page, "") for page in PAGES},
    "today-empty": (lambda stage: stage.hide("data", "pilots"), "", ""),
    **{f"{page}-empty": (nothing, page, "") for page in PAGES},
    "today": (Stage.hide, "", ""),
    "bench": (nothing, "bench", ""),
    "planning": (nothing, "planning", ""),
    "today-asks": (nothing, "", "[data-do=begin]"),
    "live-nothing": (nothing, "live", ""),
    "keys": (nothing, "", "[data-open=keys]"),
    "study": (nothing, "study", ""),
    "person": (nothing, "person?label=08", ""),
    "person-asks": (nothing, "person?label=01", "[data-do=withdraw]"),
    "study-template": (nothing, "study?from=matching", ""),
    "screens": (nothing, "screens", ""),
    "screens-french": (nothing, "screens?screens=fr&size=1280x1024", ".screens a"),
    "settings": (nothing, "settings", ""),
    "data-blind": (nothing, "data", ""),
    "pilot": (nothing, "pilot", ""),
    "pilot-report": (nothing, "pilot/001/report", ""),
    "live": (lambda stage: stage.tell(), "live", ""),
    "today-live": (nothing, "", ""),
    "live-void": (nothing, "live", "[data-key=v]"),
    "live-answer": (
        lambda stage: stage.tell(answering="How slippery is this surface?"),
        "live",
        "",
    ),
    "live-answer-asks": (nothing, "live", "[data-key=e]"),
    "live-paused": (lambda stage: stage.tell(state="paused", plate="lost"), "live", ""),
    "live-fault": (
        lambda stage: stage.tell(
            state="fault",
            plate="lost",
            faults=2,
            voided=1,
            message=str(ConnectionLost("mock plate: the line is lost")),
        ),
        "live",
        "",
    ),
    "live-warned": (
        lambda stage: stage.tell(warnings=[f"{NO_BACKUP}: {UNREACHABLE}"]),
        "live",
        "",
    ),
    "live-unblinded": (lambda stage: stage.tell(unblinded=True, level="1.2 µm"), "live", ""),
    "data": (Stage.unblind, "data", ""),
    "data-report": (nothing, "data/report", ""),
    "planning-computed": (Stage.plan, "planning", ""),
    "planning-frozen": (
        lambda stage: stage.do("freeze", "main a[download]", "planning"),
        "planning",
        "",
    ),
    "pilot-runs": (
        lambda stage: stage.do("pilot", "progress", "pilot", participants=40, seed=3),
        "pilot",
        "",
    ),
    "today-failed": (lambda stage: stage.do("begin", "#next .bad", "", participant="09"), "", ""),
    "today-checked": (lambda stage: stage.do("check", "#checklist .checks", ""), "", ""),
    "person-excluded": (
        lambda stage: stage.do(
            "exclude",
            ".tag.damaged",
            "person?label=02",
            participant="02",
            excluded=True,
            reason="fever",
        ),
        "person?label=02",
        "",
    ),
    "person-withdrew": (
        lambda stage: stage.do(
            "withdraw", ".tag.withdrew", "person?label=03", participant="03", word="03"
        ),
        "person?label=03",
        "",
    ),
    "settings-tested": (
        lambda stage: stage.do("test", ".checks", "settings", plate="mock"),
        "settings",
        "",
    ),
    "bench-faulty": (lambda stage: stage.use("serial:/dev/ttyACM0,plate=none.toml"), "bench", ""),
    "bench-presents": (lambda stage: stage.use("mock"), "bench", "[data-form=surface] button"),
    "bench-typed": (
        lambda stage: stage.calibrate("#reading-typed:not([readonly])", table="typed"),
        "bench",
        "",
    ),
    "bench-calibrated": (lambda stage: stage.calibrate("[data-do=adopt]"), "bench", ""),
    "bench-verdicts": (
        lambda stage: stage.do("conform", "#conformance li"),
        "bench",
        "",
    ),
    "today-odd": (Stage.damage, "", ""),
    "data-odd": (lambda stage: stage.do("work", "#work .bad", "data", what="verify"), "data", ""),
    "study-compared": (nothing, "study", ""),
    "study-faulty": (lambda stage: stage.edit("participants =", "people ="), "study", ""),
    "study-broken": (lambda stage: stage.edit("people =", "people = ["), "study", ""),
    "study-gone": (Stage.lose, "", ""),
    "settings-faulty": (Stage.spoil, "settings", ""),
    "nothing": (nothing, NOTHING, ""),
}


@contextmanager
def console(folder: Path) -> Iterator[str]:
    """Start a console; yield its address."""
    words = [*COMMAND, "lab", "--no-browser", "--port", "0"]
    process = subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, text=True)
    with process:
        try:
            if process.stdout is None:
                raise RuntimeError("the console has no pipe")
            yield process.stdout.readline().split()[-1]
        finally:
            process.terminate()


def axe_source(given: Path | None, place: Path) -> str:
    """Return axe-core's script from a file, or from the package that npm downloads."""
    if given:
        return given.read_text(encoding="utf-8")
    npm = shutil.which("npm")
    if not npm:
        raise SystemExit("no npm to fetch axe-core with: name its axe.min.js with --axe")
    subprocess.run([npm, "pack", "--silent", AXE], cwd=place, check=True, stdout=subprocess.DEVNULL)
    [archive] = place.glob("axe-core-*.tgz")
    with tarfile.open(archive) as files:
        member = files.extractfile("package/axe.min.js")
        return member.read().decode() if member else ""


def faults(page: Page, source: str) -> list[str]:
    """Return axe-core's findings on a page: severity, rule and place."""
    page.evaluate(source)
    found = page.evaluate("axe.run(document, {resultTypes: ['violations'], iframes: false})")
    return [
        f"{each['impact']}: {each['id']}: {', '.join(node['target'][0] for node in each['nodes'])}"
        for each in found["violations"]
    ]


def complaints(page: Page) -> list[str]:
    """Return a list that collects the page's errors, and what is not answered with 200."""
    found: list[str] = []

    def raised(error: Error) -> None:
        found.append(f"serious: {error}")

    def answered(response: Response) -> None:
        if response.status != HTTPStatus.OK and response.request.method == "GET":
            found.append(f"serious: {response.status} for {response.url}")

    page.on("pageerror", raised)
    page.on("response", answered)
    return found


def look(
    browser: Browser,
    address: str,
    out: Path,
    name: str,
    *,
    source: str,
    language: str,
    opened: StorageState,
) -> list[str]:
    """Take a scene's screenshots; return axe-core's findings, each with its screenshot."""
    _, path, press = SCENES[name]
    told = []
    for theme in THEMES:
        for width_name, width in WIDTHS.items():
            context = browser.new_context(
                color_scheme=theme,
                viewport={"width": width, "height": 900},
                locale=language,
                storage_state=opened,
            )
            page = context.new_page()
            picture = f"{name}-{theme}-{width_name}"
            wrong = complaints(page) if path != NOTHING else []
            page.goto(address + path)
            if press:
                page.locator(press).first.click()
            page.screenshot(path=out / f"{picture}.png", full_page=not press)
            told += [f"{picture}: {each}" for each in (*faults(page, source), *wrong)]
            overflow = page.evaluate("document.documentElement.scrollWidth - innerWidth")
            if overflow > 0:
                told.append(f"{picture}: serious: wider than the window by {overflow} px")
            context.close()
    return told


def enter(browser: Browser, address: str) -> StorageState:
    """Return the browser's state after it has opened the address, which is possible only once."""
    context = browser.new_context()
    page = context.new_page()
    page.goto(address)
    page.get_by_role("navigation").wait_for()
    held = context.storage_state()
    context.close()
    return held


def document(browser: Browser, address: str, out: Path, name: str, opened: StorageState) -> None:
    """Take a scene's screenshot for the documentation."""
    size: ViewportSize = {"width": 1000, "height": DOCUMENTED[name]}
    page = browser.new_page(color_scheme="light", viewport=size, locale="en", storage_state=opened)
    page.goto(address + SCENES[name][1])
    page.screenshot(path=out / f"console-{name}.png")
    page.close()


def main() -> int:
    """Take all screenshots and print axe-core's findings; return 1 if one is severe."""
    parser = argparse.ArgumentParser(description="Look at every page of the console.")
    parser.add_argument("folder", type=Path, help="for the pictures")
    parser.add_argument("--axe", type=Path, help="axe.min.js of the npm package axe-core")
    parser.add_argument(
        "--documentation", action="store_true", help="only the documentation's pictures"
    )
    parser.add_argument("--language", default="en", choices=LANGUAGES, help="of the pages")
    parser.add_argument("--only", nargs="+", metavar="NAME", choices=SCENES, help="these alone")
    options = parser.parse_args()
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    options.folder.mkdir(parents=True, exist_ok=True)
    told: list[str] = []
    with tempfile.TemporaryDirectory() as place, sync_playwright() as play:
        source = "" if options.documentation else axe_source(options.axe, Path(place))
        laboratory(Path(place, "lab"))
        rights = ["--no-sandbox"] if os.geteuid() == 0 else []
        browser = play.chromium.launch(executable_path=chromium, args=rights)
        with console(Path(place, "lab")) as door:
            opened, address = enter(browser, door), door.partition("?")[0]
            kept = browser.new_page(storage_state=opened)
            stage = Stage(Path(place, "lab"), kept, address)
            wanted = {*(DOCUMENTED if options.documentation else options.only or SCENES)}
            for name, (prepare, _, _) in SCENES.items():
                if not wanted:
                    break
                prepare(stage)
                if name not in wanted:
                    continue
                wanted.remove(name)
                time.sleep(FRESH_S)
                if options.documentation:
                    document(browser, address, options.folder, name, opened)
                    continue
                found = look(
                    browser,
                    address,
                    options.folder,
                    name,
                    source=source,
                    language=options.language,
                    opened=opened,
                )
                print("\n".join(found) or f"{name}: nothing", flush=True)
                told += found
            stage.end()
        browser.close()
    return 1 if any(f": {impact}: " in line for line in told for impact in GRAVE) else 0


if __name__ == "__main__":
    sys.exit(main())
