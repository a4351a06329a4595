"""A short day in a real browser beside a real PsychoPy window, where there is a Chromium."""

import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

import pytest

from experiments.journal.locks import is_being_written
from experiments.journal.run_record import read_plan
from experiments.lab.folder import init
from experiments.session.mailbox import read_status

sync_api = pytest.importorskip("playwright.sync_api")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = [
    pytest.mark.window,
    pytest.mark.skipif(
        not CHROMIUM or not sys.platform.startswith("linux") or not shutil.which("xdotool"),
        reason="needs Chromium, and X11 for key presses",
    ),
]
STUDY = """
name = "short"
title = "A short study"
amplitudes_um_pp = [0, 1]
[[tasks]]
protocol = "magnitude_estimation"
practice = 0
"""
PATIENCE_MS = 60_000.0
LOADED = 60  # times that a key is pressed until its screen has come, on a loaded machine


@contextmanager
def console(folder):
    """Open a console in a process of its own; yield the process and its address."""
    words = [sys.executable, "-P", "-m", "slipscale", "lab", "--no-browser", "--port", "0"]
    process = subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, text=True)
    with process:
        try:
            yield process, process.stdout.readline().split()[-1]
        finally:
            process.kill()


def test_eight_pages_of_one_browser_all_see_what_changes(page, tmp_path):
    """A browser allows six connections to a host: a held one for each page would be too many."""
    (tmp_path / "short.toml").write_text(STUDY)
    init(tmp_path, {"study": "short.toml"}, None)
    with console(tmp_path) as (_, address):
        pages = [page, *(page.context.new_page() for _ in range(7))]
        for each in pages:
            each.goto(address)
        (tmp_path / "slipscale.toml").write_text('study = "gone.toml"')
        for each in pages:
            each.get_by_text("gone.toml").first.wait_for()
        page.close()
        (tmp_path / "slipscale.toml").write_text('study = "short.toml"')
        for each in pages[1:]:
            each.get_by_text("gone.toml").first.wait_for(state="detached")


@pytest.fixture
def page(display):
    with sync_api.sync_playwright() as play:
        rights = ["--no-sandbox"] if os.geteuid() == 0 else []
        browser = play.chromium.launch(executable_path=CHROMIUM, args=rights)
        context = browser.new_context(locale="en", viewport={"width": 1000, "height": 800})
        context.set_default_timeout(PATIENCE_MS)
        page = context.new_page()
        page.complaints = []
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.requested = []
        page.on("request", lambda request: page.requested.append(request.url))
        yield page
        browser.close()


def confirm(page, words=None):
    if words is not None:
        page.locator("dialog input").fill(words)
    page.locator("dialog .main").click()


def to_live(page, link):
    """Go to the page of the running session, and wait until its script hears keys."""
    page.get_by_role("link", name=link, exact=True).click()
    page.wait_for_url("**/live")
    page.wait_for_load_state()


def press_until(page, text):
    """Press the space bar in the participant's window until the page shows a text."""
    for _ in range(LOADED):
        if page.get_by_text(text).count():
            return
        subprocess.run(["xdotool", "key", "space"], check=True)
        page.wait_for_timeout(700)
    pytest.fail(f"the page never showed {text!r}: {page.inner_text('main')}")


def test_a_short_day(page, tmp_path):
    (tmp_path / "short.toml").write_text(STUDY)
    init(tmp_path, {"study": "short.toml", "windowed": "true"}, None)
    run = tmp_path / "pilots/rehearsals/sourcedata/sub-01/sub-01_run-01_journal.jsonl"
    with console(tmp_path) as (first, address):
        page.goto(address)
        assert "token" not in page.url
        page.get_by_role("button", name="Rehearse").click()
        confirm(page)
        to_live(page, "See it")
        page.get_by_text("Before the first trial").wait_for()
        press_until(page, "Trial 1 of 2")
        page.keyboard.press("n")
        confirm(page, "a door <b>slammed</b>")
        page.get_by_text("a door <b>slammed</b>").wait_for()
        page.keyboard.press("p")
        page.locator(".state-paused").wait_for()
        first.kill()
        page.get_by_text("The console does not answer").wait_for()
    assert is_being_written(run)
    with console(tmp_path) as (_, address):
        page.goto(address)
        to_live(page, "Live")
        page.locator(".state-paused").wait_for()
        page.keyboard.press("p")
        page.locator(".state-paused").wait_for(state="detached")
        page.keyboard.press("v")
        confirm(page, "a slip")
        page.get_by_text("a slip").wait_for()
        os.kill(read_status(run).process, signal.SIGKILL)
        page.get_by_text("No session runs now").wait_for()
        page.goto(address.partition("/?")[0])
        page.get_by_role("button", name="Go on").click()
        confirm(page)
        to_live(page, "See it")
        page.get_by_role("button", name="Stop").wait_for()
        page.keyboard.press("s")
        confirm(page, "enough")
        page.get_by_text("No session runs now").wait_for()
    for _ in range(LOADED):
        if not is_being_written(run):
            break
        time.sleep(0.1)
    plan, records = read_plan(run)
    kinds = [record.kind for record in records]
    assert plan.mode == "pilot"
    assert [kinds.count(k) for k in ("note", "pause", "go_on", "void", "resume")] == [1] * 5
    assert (records[-1].kind, records[-1].data["reason"]) == (
        "stop",
        "asked by the operator: enough",
    )
    assert page.complaints == []
    assert {url.partition("/")[0] for url in page.requested} == {"http:"}
    assert {url.split("/")[2].partition(":")[0] for url in page.requested} == {"127.0.0.1"}
