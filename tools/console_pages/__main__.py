"""Take screenshots of every console page in both themes and two widths; run axe-core on the pages.

Usage: python -m tools.console_pages FOLDER [--axe axe.min.js] [--language fr] [--only NAME ...]
       python -m tools.console_pages docs/images --documentation

Without --axe, npm downloads axe-core to a temporary folder. The exit status is 1 if axe-core finds
a serious or critical problem. Requires Chromium, but no display.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from pathlib import Path
from typing import Literal

from playwright.sync_api import (
    Browser,
    Error,
    Page,
    Response,
    StorageState,
    ViewportSize,
    sync_playwright,
)

from slipscale.experiments.lab.console.page_texts import languages
from tools.console_pages.scenes import NOTHING, SCENES
from tools.console_pages.stage import COMMAND, Stage, laboratory

AXE = "axe-core@4.14.1"
WIDTHS = {"wide": 1400, "phone": 400, "4k": 3840}
THEMES: tuple[Literal["light", "dark"], ...] = ("light", "dark")
# Heights of the screenshots for the documentation.
DOCUMENTED = {"today": 1000, "live": 1150, "data": 1150}
GRAVE = ("serious", "critical")
FRESH_S = 1.2  # the console reads its folder once per second


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
        raise SystemExit("without npm to download axe-core, give its axe.min.js with --axe")
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
    """Return a list that collects the page's errors and GET responses other than 200."""
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
    """Open the console's one-time address, and return the browser's state."""
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
    parser = argparse.ArgumentParser(description="Check the pages of the console.")
    parser.add_argument("folder", type=Path, help="output folder")
    parser.add_argument("--axe", type=Path, help="axe.min.js of the npm package axe-core")
    parser.add_argument(
        "--documentation", action="store_true", help="only the screenshots of the documentation"
    )
    parser.add_argument(
        "--language", default="en", choices=languages(), help="language of the pages"
    )
    parser.add_argument("--only", nargs="+", metavar="NAME", choices=SCENES, help="scenes to take")
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
