"""A day in a real browser beside a real PsychoPy window, where there is a Chromium.

The short day is part of every test run. The whole day, some three minutes, is asked for:
SLIPSCALE_WHOLE_DAY=1 python -m pytest tests/experiments/lab/console/test_browser.py -k whole
"""

import itertools
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from contextlib import contextmanager

import pytest

from slipscale.experiments.journal.locks import is_being_written
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.lab.folder import init, read_lab
from slipscale.experiments.lab.roster import read_roster
from slipscale.experiments.session.mailbox import read_status
from slipscale.experiments.study.file import read_study

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
REFUSED = re.compile("status of (?!409)")  # 409: an action that is not possible now
PATIENCE_MS = 300_000.0
sync_api.expect.set_options(timeout=PATIENCE_MS)


@contextmanager
def console(folder, port="0"):
    """Open a console in a process of its own; yield the process and its address."""
    words = [sys.executable, "-P", "-m", "slipscale", "lab", "--no-browser", "--port", port]
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
        page.keyboard.press("?")
        page.get_by_text("write a note").wait_for()
        page.close()
        (tmp_path / "slipscale.toml").write_text('study = "short.toml"')
        for each in pages[1:]:
            each.get_by_text("gone.toml").first.wait_for(state="detached")


def test_a_new_folder_is_set_up_without_a_file_being_written_by_hand(page, tmp_path):
    with console(tmp_path) as (_, address):
        page.goto(address)
        page.get_by_text("set the folder up on the Settings page").wait_for()
        page.get_by_role("link", name="Settings").click()
        page.get_by_label("Plate", exact=True).fill("nonsense:")
        page.get_by_role("button", name="Save").click()
        page.get_by_text("unknown backend 'nonsense'").wait_for()
        assert page.locator("[aria-invalid=true]").get_attribute("name") == "plate"
        page.get_by_label("Plate", exact=True).fill("mock")
        page.get_by_label("Participant's window is not full screen").check()
        page.get_by_role("button", name="Test", exact=True).click()
        page.locator("#plate-test .good").wait_for()
        page.get_by_role("button", name="Save").click()
        page.get_by_text("These settings are stored in slipscale.toml").wait_for()
    assert (read_lab(tmp_path).plate, read_lab(tmp_path).windowed) == ("mock", True)
    assert page.complaints == []


def test_a_table_of_another_program_is_uploaded_explained_and_analysed(page, tmp_path):
    table = tmp_path / "outcomes.csv"
    rows = [(who, size, turn) for who in (1, 2, 3) for size in (2, 4, 8) for turn in range(10)]
    coded = [f"s{w},{s},{'hit' if (7 * w + 3 * t) % 11 < s + 2 else 'miss'}" for w, s, t in rows]
    table.write_text("\n".join(["who,size,__proto__", *coded]))
    with console(tmp_path) as (_, address):
        page.goto(address)
        page.get_by_role("link", name="Data").click()
        page.get_by_role("link", name="Analyse a table from another program").click()
        page.get_by_label("Table", exact=True).set_input_files(
            {"name": "big.csv", "mimeType": "text/csv", "buffer": b"1" * 10_000_001}
        )
        page.get_by_role("button", name="Upload").click()
        page.get_by_text("The file is larger than 10 MB").wait_for()
        page.get_by_label("Table", exact=True).set_input_files(table)
        page.get_by_role("button", name="Upload").click()
        page.get_by_text("outcomes.csv: first of 90 rows").wait_for()
        page.get_by_label("__proto__").select_option("estimates (numbers)")
        page.get_by_role("button", name="Check the choices").click()
        page.locator("#choices .why", has_text="are not numbers").wait_for()
        assert page.locator("[aria-invalid=true]").get_attribute("name") == "__proto__"
        page.get_by_label("__proto__").select_option("answers: yes or no, right or wrong")
        page.get_by_role("button", name="Check the choices").click()
        page.get_by_label("“hit” means").select_option("yes or correct")
        page.get_by_label("“miss” means").select_option("no or wrong")
        page.get_by_role("button", name="Check the choices").click()
        page.get_by_text("90 answers of 3 people at 3 levels").wait_for()
        page.get_by_label("unit of the levels").fill("mm")
        page.get_by_role("button", name="Make the report").click()
        page.get_by_role("link", name="Report of").click(timeout=60_000)
        report = page.frame_locator("iframe")
        report.get_by_text("3 participants; 90 stimuli").first.wait_for()
    assert page.complaints == []


def test_the_screens_of_a_study_are_looked_at_with_the_keyboard_alone(page, tmp_path):
    init(tmp_path, {"study": "matching"}, None)
    with console(tmp_path) as (_, address):
        page.goto(address)
        page.get_by_role("link", name="Français").press("Enter")
        page.get_by_role("link", name="Étude", exact=True).press("Enter")
        page.get_by_role("link", name="Écrans de l’étude").press("Enter")
        page.get_by_role("link", name="fr", exact=True).press("Enter")
        page.wait_for_url("**screens=fr**")  # and until it is loaded: before, pictures are wide
        page.get_by_text("écrans sont lisibles").wait_for()
        small = page.get_by_role("img").nth(2).bounding_box()["width"]
        page.locator(".screens figure > a").nth(2).press("Enter")
        page.wait_for_url("**#screen-3")
        third = page.get_by_role("img").nth(2)
        wait_until(page, lambda: third.bounding_box()["width"] > 1.5 * small)
    assert page.complaints == []


def test_a_participant_is_excluded_and_withdraws_with_the_keyboard_alone(page, tmp_path):
    init(tmp_path, {"study": "matching"}, None)
    words = [sys.executable, "-P", "-m", "slipscale", "pilot", "matching", "--participants", "2"]
    subprocess.run([*words, "--out", "data"], cwd=tmp_path, check=True, capture_output=True)
    with console(tmp_path) as (_, address):
        page.goto(address)
        page.get_by_role("link", name="01", exact=True).press("Enter")
        press(page, "Exclude from the analysis")
        confirm(page, "wore a glove")
        page.locator("#exclusion").get_by_text("wore a glove").wait_for()
        page.get_by_role("button", name="Include again").wait_for()
        for typed, told in (
            ("02", "expected the participant's label, 01"),
            ("01", "has withdrawn"),
        ):
            press(page, "Remove all their data")
            confirm(page, typed)
            page.locator("#said").get_by_text(told).wait_for()
        page.get_by_text("This participant withdrew.").wait_for()
    assert not list((tmp_path / "data").rglob("sub-01*"))
    assert list((tmp_path / "data").rglob("sub-02*_journal.jsonl"))
    assert page.complaints == []


#: Types before the page's script runs.
EARLY = """document.addEventListener("readystatechange", () => {
    const field = document.getElementById("field-participants");
    if (location.search && field && document.readyState === "interactive") field.value = "-3";
});"""


def test_a_study_is_written_in_the_form_with_keyboard_and_mouse(page, tmp_path):
    init(tmp_path, {"study": "biet2007"}, None)
    expect = sync_api.expect
    page.add_init_script(EARLY)
    with console(tmp_path) as (_, address):
        page.goto(address)
        page.get_by_role("link", name="Study", exact=True).press("Enter")
        page.get_by_role("link", name="matching", exact=True).press("Enter")
        page.get_by_text("This is the shipped study matching").wait_for()
        people = page.get_by_label("participants", exact=False).first
        page.locator("#panel-form").get_by_text("expected 1 or more, got -3").wait_for()
        people.fill("5")
        expect(page.locator("#study-faults")).to_be_empty()
        expect(people).to_be_focused()
        page.get_by_text("minutes per participant").wait_for()
        page.get_by_label("New:").select_option("magnitude_estimation")
        page.get_by_role("button", name="Add tasks").press("Enter")
        page.get_by_role("button", name="Move up: magnitude estimation").press("Enter")
        expect(page.locator("#study-timeline b").first).to_contain_text("Magnitude estimation")
        expect(page.get_by_role("button", name="Move down: magnitude estimation")).to_be_focused()
        page.set_viewport_size({"width": 1000, "height": 3000})  # both cards are on the screen
        handles = page.locator(".handle > span")
        handles.nth(1).drag_to(handles.nth(0))
        expect(page.locator("#study-timeline b").first).to_contain_text("Matching")
        page.get_by_role("tab", name="Text of the file").press("Enter")
        text = page.get_by_role("textbox", name="The study file")
        own = text.input_value()
        text.fill(own.replace("participants = 5", "participants = -5"))
        page.locator("#study-faults").get_by_text("participants").wait_for()
        expect(page.locator("#study-lines b")).to_have_count(1)
        text.fill(own)
        expect(page.locator("#study-faults")).to_be_empty()
        page.get_by_label("Name of the copy").fill("own")
        page.get_by_role("button", name="Save as a copy").press("Enter")
        page.get_by_text("which this folder now uses").wait_for()
        expect(page.get_by_role("heading", level=1)).to_have_text("own")
        assert page.locator("#said").bounding_box()["y"] >= 0
        page.evaluate("scrollTo(0, document.body.scrollHeight)")
        assert page.locator("#said").bounding_box()["y"] >= 0  # whatever is in view
    study = read_study(str(tmp_path / "own.toml"))[0]
    assert (study.name, study.participants) == ("own", 5)
    assert [task.protocol for task in study.tasks] == ["matching", "magnitude_estimation"]
    assert read_lab(tmp_path).study == "own.toml"
    assert page.complaints == []


def test_a_text_is_changed_on_the_picture_of_its_screen_in_both_languages(page, tmp_path):
    text = read_study("matching")[1].replace('name = "matching"', 'name = "mine"')
    (tmp_path / "mine.toml").write_text(text)
    init(tmp_path, {"study": "mine.toml"}, None)
    expect = sync_api.expect
    with console(tmp_path) as (_, address):
        page.goto(address)
        page.goto(address.partition("/?")[0] + "/screens")
        page.locator("[data-text='session.welcome_title']").first.click()
        page.get_by_label("en", exact=True).fill("Good morning")
        expect(page.locator("svg [data-text='session.welcome_title']")).to_have_text("Good morning")
        page.get_by_label("fr", exact=True).fill("Bonjour")
        page.get_by_role("button", name="Save").press("Enter")
        page.wait_for_url("**/screens?screens=en**")
        page.locator("#said").get_by_text("saved: mine.toml").wait_for()
        expect(page.locator("ol.screens li").first).to_contain_text("Good morning")
        page.locator("#texts-1 summary").press("Enter")
        page.evaluate("refresh()")  # a renewed page keeps open what is open
        page.get_by_role("link", name="session.welcome_title").press("Enter")
        expect(page.get_by_label("fr", exact=True)).to_have_value("Bonjour")
    own = read_study(str(tmp_path / "mine.toml"))[0].texts
    assert own["en"] == {"session": {"welcome_title": "Good morning"}}
    assert own["fr"] == {"session": {"welcome_title": "Bonjour"}}
    assert page.complaints == []


def test_the_last_changes_of_a_study_are_undone_one_by_one(page, tmp_path):
    init(tmp_path, {"study": "matching"}, None)
    expect = sync_api.expect
    with console(tmp_path) as (_, address):
        page.goto(address)
        page.get_by_role("link", name="Study", exact=True).press("Enter")
        people, text = (
            page.get_by_label("participants", exact=False).first,
            page.locator("textarea#study-text"),
        )
        first = people.input_value()
        undo = page.get_by_role("button", name="Undo the last change")
        expect(undo).to_be_disabled()
        for count in ("6", "7"):
            people.fill(count)
            expect(text).to_have_value(re.compile(f"participants = {count}"))
        for count in ("6", first):
            undo.press("Enter")
            expect(people).to_have_value(count)
        expect(undo).to_be_disabled()
    assert page.complaints == []


@pytest.fixture
def page(display):
    with sync_api.sync_playwright() as play:
        rights = ["--no-sandbox"] if os.geteuid() == 0 else []
        browser = play.chromium.launch(executable_path=CHROMIUM, args=rights, timeout=PATIENCE_MS)
        context = browser.new_context(locale="en", viewport={"width": 1000, "height": 800})
        context.set_default_timeout(PATIENCE_MS)
        page = context.new_page()
        page.complaints = []
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.on(
            "console", lambda line: REFUSED.search(line.text) and page.complaints.append(line.text)
        )
        page.requested = []
        page.on("request", lambda request: page.requested.append(request.url))
        yield page
        browser.close()


def press(page, name):
    """Press Enter on a button until it asks.

    A key is lost that comes before the page's script has begun, or while what has changed on the
    page replaces the button.
    """
    asking = page.locator("#sure").is_visible
    button = page.get_by_role("button", name=name)

    def asks():
        return asking() or button.press("Enter") or asking()

    wait_until(page, asks)


def confirm(page, words=None):
    if words is not None:
        page.locator("#sure input[name=reason]").wait_for()
        page.keyboard.type(words)
        assert (
            page.locator("#sure input[name=reason]").input_value() == words
        )  # no shortcut's letter before it
    page.locator("#sure .main").click()


def to_live(page, link):
    """Go to the page of the running session, and wait until its script hears keys."""
    page.get_by_role("link", name=link, exact=True).click()
    page.wait_for_url("**/live")
    page.wait_for_load_state()


def press_until(page, text):
    """Press the space bar in the participant's window until the page shows a text."""

    def shown():
        if page.get_by_text(text).count():
            return True
        subprocess.run(["xdotool", "key", "space"], check=True)
        page.wait_for_timeout(500)  # for the next screen, not for the page
        return False

    wait_until(page, shown)


def test_a_short_day(page, tmp_path):
    (tmp_path / "short.toml").write_text(STUDY)
    init(tmp_path, {"study": "short.toml", "windowed": "true"}, None)
    run = tmp_path / "pilots/rehearsals/sourcedata/sub-01/sub-01_run-01_journal.jsonl"
    with console(tmp_path) as (first, address):
        page.goto(address)
        page.get_by_role("button", name="Rehearse").click()
        assert "token" not in page.url
        confirm(page)
        to_live(page, "Show the session")
        page.get_by_text("Before the first trial").wait_for()
        press_until(page, "Trial 1 of 2")
        page.keyboard.press("n")
        confirm(page, "a door <b>slammed</b>")
        page.get_by_text("a door <b>slammed</b>").wait_for()
        page.keyboard.press("p")
        page.locator(".state-paused").wait_for()
        first.kill()
        page.get_by_text("The console does not respond").wait_for()
    assert is_being_written(run)
    with console(tmp_path, re.search(r":(\d+)/", address)[1]) as (_, address):
        old, page = page, page.context.new_page()  # an old page keeps a new one from nothing
        page.goto(address)
        to_live(page, "Live")
        page.locator(".state-paused").wait_for()
        old.locator(".state-paused").wait_for()
        page.keyboard.press("p")
        page.locator(".state-paused").wait_for(state="detached")
        page.keyboard.press("v")
        confirm(page, "a slip")
        page.get_by_text("a slip").wait_for()
        os.kill(read_status(run).process, signal.SIGKILL)
        page.get_by_text("No session is running").wait_for()
        page.goto(address.partition("/?")[0])
        page.get_by_role("button", name="Resume participant").click()
        confirm(page)
        to_live(page, "Show the session")
        page.get_by_role("button", name="Stop").wait_for()
        page.keyboard.press("s")
        confirm(page, "enough")
        page.get_by_text("No session is running").wait_for()
    wait_until(page, lambda: not is_being_written(run))
    plan, records = read_plan(run)
    kinds = [record.kind for record in records]
    assert plan.mode == "pilot"
    assert [kinds.count(k) for k in ("note", "pause", "go_on", "void", "resume")] == [1] * 5
    assert (records[-1].kind, records[-1].data["reason"]) == (
        "stop",
        "requested by the operator: enough",
    )
    # Until the new page has its cookie, the old one is refused.
    assert [each for each in old.complaints if "status of 403" not in each] == []
    assert {url.partition("/")[0] for url in old.requested} == {"http:"}
    assert {url.split("/")[2].partition(":")[0] for url in old.requested} == {"127.0.0.1"}


# The whole day ------------------------------------------------------------------------------------

# A plate that counts as real: people's answers on a mock plate would be a pilot's.
BENCH = """
from pathlib import Path
from slipscale.hardware.backends import mock
class Bench(mock.MockPlate):
    name = "bench"
    simulated = False
def open_plate(address, *, clock, seed):
    faults = "fault=lost@present/4+lost@connect/2"  # the session itself retries the first, once
    fault = faults if Path("faulty").exists() else ""
    plate = mock.open_plate(fault, clock=clock, seed=seed)
    plate.__class__ = Bench
    return plate
"""


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """Install a backend of the name bench, for every process that is started here."""
    site = tmp_path / "site"
    info = site / "bench-1.0.dist-info"
    info.mkdir(parents=True)
    (site / "bench_plate.py").write_text(BENCH)
    (info / "METADATA").write_text("Name: bench\nVersion: 1.0\n")
    points = "[slipscale.backends]\nbench = bench_plate:open_plate\n"
    (info / "entry_points.txt").write_text(points)
    monkeypatch.setenv("PYTHONPATH", str(site), prepend=os.pathsep)


def command(folder, *words):
    """Run a slipscale command in the folder; return what it says."""
    ran = subprocess.run(
        [sys.executable, "-P", "-m", "slipscale", *words],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


def answer_until(page, reached, run):
    """Be the participant, until the page says what is waited for: go on, type a number, send it.

    The next key is pressed when the page shows what the session last told, so that none of its
    states is missed.
    """

    def up_to_date():
        status = read_status(run)
        told = f"{status.done} of {status.planned} trials" if status else "No session is running"
        return page.get_by_text(told).count()

    presses = itertools.count()

    def answered():
        if reached():
            return True
        press = next(presses)
        key = ("space", str(1 + press % 9), "Return")[press % 3]
        subprocess.run(["xdotool", "key", key], check=True)
        page.wait_for_timeout(100)
        wait_until(page, up_to_date)
        return False

    wait_until(page, answered)


def begin_session(page):
    page.bring_to_front()
    to_page(page, "Today")
    page.get_by_role("button", name="Begin the session").click()
    confirm(page)
    to_live(page, "Show the session")
    page.get_by_text("Before the first trial").wait_for()


def to_page(page, name):
    pages = page.get_by_role("navigation", name="Slipscale")
    pages.get_by_role("link", name=name, exact=True).click()
    page.wait_for_load_state()


def shows(page, text):
    return lambda: page.get_by_text(text).count() > 0


def wait_until(page, reached):
    """Wait for what only Python can look at: the page allows no script but its own."""
    end_s = time.monotonic() + PATIENCE_MS / 1000
    while not reached():
        if time.monotonic() > end_s:
            pytest.fail(f"the page never came so far: {page.inner_text('body')}")
        page.wait_for_timeout(100)


def counts(page):
    """Return how many people each amplitude of Table III has."""
    return page.locator("#results tbody tr td:nth-child(2)").all_inner_texts()


def set_plate(page, spec, **more):
    """Write the folder's settings on their page."""
    to_page(page, "Settings")
    page.get_by_label("Plate", exact=True).fill(spec)
    for label, value in more.items():
        page.get_by_label(label, exact=True).fill(value)
    page.get_by_label("Participant's window is not full screen").check()
    with page.expect_navigation():  # the page is loaded again once they are written
        page.get_by_role("button", name="Save").click()


def a_study_is_written_in_the_form(page):
    """From the paper's: one task, three surfaces, three participants, no questions, no noise."""
    to_page(page, "Study")
    for label, value in (
        ("title", "A day in the laboratory"),
        ("participants", "3"),
        ("amplitudes µm peak to peak", "0, 1, 2"),
    ):
        page.get_by_label(label, exact=True).fill(value)
    for card in ("descending difference", "age_band", "gender", "masking_noise"):
        page.get_by_role("button", name=f"Remove {card}").click()
        page.get_by_role("button", name=f"Remove {card}").wait_for(state="detached")
    page.get_by_label("practice").fill("0")
    page.locator("#study-timeline").get_by_text("3 trials").first.wait_for()
    page.get_by_label("Name of the copy").fill("day")
    page.get_by_role("button", name="Save as a copy").click()
    page.get_by_text("which this folder now uses").wait_for()


def an_emulated_board_is_calibrated(page, lab):
    to_page(page, "Plate")
    page.get_by_role("button", name="Start an emulated board").click()
    spec = page.locator("#plate code").inner_text()
    set_plate(page, spec, Study="day.toml")
    to_page(page, "Plate")
    page.get_by_label("Who calibrates").fill("Ada")
    page.get_by_label("Instrument: model and range").fill("emulated")
    page.get_by_role("button", name="Calibrate", exact=True).click()
    page.get_by_role("button", name="Use this calibration").click()
    confirm(page)
    wait_until(page, lambda: read_lab(lab).plate == f"{spec},calibration=calibration-1.toml")
    page.get_by_role("button", name="Present").click()
    page.locator("#surface .huge").wait_for()  # what the board reads back
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Switch off").click()
    page.get_by_text("The plate is off.").wait_for()


def a_fault_a_note_a_pause_and_a_void(page, lab, run):
    (lab / "faulty").touch()
    begin_session(page)
    (lab / "faulty").unlink()
    answer_until(page, shows(page, "Trial 2 of 3"), run)
    page.keyboard.press("n")
    confirm(page, "the heating came on")
    page.get_by_text("the heating came on").wait_for()
    page.keyboard.press("p")
    page.locator(".state-paused").wait_for()
    page.keyboard.press("p")
    page.locator(".state-paused").wait_for(state="detached")
    page.keyboard.press("v")
    confirm(page, "coughed")
    page.get_by_text("coughed").wait_for()
    # The fourth presentation: the pause presented the second surface again.
    answer_until(page, lambda: page.locator(".state-fault").count() > 0, run)
    page.keyboard.press("r")
    page.locator(".state-fault").wait_for(state="detached")
    answer_until(page, shows(page, "No session is running"), run)
    to_page(page, "Today")
    page.get_by_text("1 of 3 planned participants have started; 1 finished").wait_for()
    page.get_by_text("the heating came on").wait_for()


def a_killed_session_goes_on(page, run):
    to_page(page, "Live")
    page.get_by_text(re.compile("Trial [23] of 3")).wait_for()
    os.kill(read_status(run).process, signal.SIGKILL)
    page.get_by_text("No session is running").wait_for()
    to_page(page, "Today")
    page.get_by_role("button", name="Resume participant").click()
    confirm(page)
    to_live(page, "Show the session")
    page.get_by_role("button", name="Stop").wait_for()
    answer_until(page, shows(page, "No session is running"), run)


def results_grow(page, watching, run):
    """Unblind after two of three: results come by themselves, and grow with the third."""
    watching.get_by_role("button", name="Unblind").click()
    confirm(watching, "unblind")
    wait_until(watching, lambda: counts(watching) == ["2"] * 3)
    wait_until(watching, lambda: watching.locator(".paper img").count() == 1)
    figure = watching.locator(".paper img").get_attribute("src")
    watching.evaluate("window.stays = true")
    times = watching.locator("#runs circle")
    answered = times.count()
    begin_session(page)
    answer_until(page, shows(page, "Trial 2 of 3"), run)
    wait_until(watching, lambda: times.count() > answered)  # while the session runs
    answer_until(page, shows(page, "No session is running"), run)
    wait_until(watching, lambda: counts(watching) == ["3"] * 3)
    renewed = watching.locator(".paper img")
    wait_until(watching, lambda: renewed.count() and renewed.get_attribute("src") != figure)
    assert watching.evaluate("window.stays")  # without a reload


def analysed_at_a_press(watching):
    watching.get_by_role("button", name="Analyse").wait_for()
    watching.get_by_role("button", name="Analyse").click()
    watching.locator(".steps li").first.wait_for()
    watching.get_by_role("button", name="Analyse").wait_for()
    with watching.expect_download() as download:
        watching.get_by_role("link", name="Download the data set").click()
    watching.get_by_role("link", name="The report").click()
    report = watching.frame_locator("iframe.report")
    report.get_by_role("heading", name="A day in the laboratory").first.wait_for()
    with zipfile.ZipFile(download.value.path()) as archive:
        return archive.namelist()


def one_withdraws_and_the_rest_is_exported(page, lab):
    page.bring_to_front()
    to_page(page, "Today")
    page.get_by_role("link", name="03", exact=True).click()
    page.get_by_role("button", name="Remove all their data").click()
    confirm(page, "03")
    page.get_by_text("This participant withdrew.").wait_for()
    to_page(page, "Data")
    page.get_by_role("button", name="Analyse").click()
    page.locator(".steps li").first.wait_for()
    page.get_by_role("button", name="Analyse").wait_for()
    page.get_by_label("Search").fill("coughed")
    page.get_by_text("1 of 2 runs").wait_for()
    page.get_by_role("button", name="Export").click()
    page.get_by_role("link", name="Download the export").wait_for()
    page.get_by_role("button", name="Export").wait_for()
    assert (lab / "data/derivatives/slipscale/export/report.docx").exists()


@pytest.mark.skipif(
    not os.environ.get("SLIPSCALE_WHOLE_DAY"), reason="minutes; set SLIPSCALE_WHOLE_DAY=1"
)
def test_a_whole_day(page, tmp_path, bench):
    lab = tmp_path / "lab"
    lab.mkdir()
    names = [f"sub-{label}/sub-{label}_run-01_journal.jsonl" for label in ("01", "02", "03")]
    one, two, three = [lab / "data/sourcedata" / name for name in names]
    with console(lab) as (first, address):
        page.goto(address)
        set_plate(page, "mock")
        a_study_is_written_in_the_form(page)
        an_emulated_board_is_calibrated(page, lab)
        set_plate(page, "bench:")
        to_page(page, "Study")
        page.get_by_role("link", name="Screens of the study").click()
        page.get_by_text("screens are readable").wait_for()
        to_page(page, "Today")
        page.get_by_role("button", name="Check everything").click()
        page.get_by_text("Ready.").wait_for()
        a_fault_a_note_a_pause_and_a_void(page, lab, one)
        begin_session(page)
        answer_until(page, shows(page, "Trial 2 of 3"), two)
        first.kill()
        page.get_by_text("The console does not respond").wait_for()
    assert is_being_written(two)
    with console(lab) as (_, address):
        page.goto(address)
        a_killed_session_goes_on(page, two)
        watching = page.context.new_page()
        watching.goto(address.partition("/?")[0] + "/data")
        results_grow(page, watching, three)
        assert f"data/sourcedata/{names[2]}" in analysed_at_a_press(watching)
        one_withdraws_and_the_rest_is_exported(page, lab)

    study, text = read_study(str(lab / "day.toml"))
    people = read_roster(lab / "data", study, text).people
    assert [person.state for person in people] == ["done", "done", "withdrew"]
    assert not three.exists()
    assert {read_plan(path)[0].mode for path in (one, two)} == {"participant"}
    kinds = [[record.kind for record in read_plan(path)[1]] for path in (one, two)]
    happened = ("fault", "retry", "note", "pause", "go_on", "void")
    assert [kinds[0].count(kind) for kind in happened] == [2, 1, 1, 1, 1, 1]
    assert [each.count("resume") for each in kinds] == [0, 1]
    assert "agrees with its journals (2)" in command(lab, "data", "verify")
    assert page.complaints == []
    assert {url.split("/")[2].partition(":")[0] for url in page.requested} == {"127.0.0.1"}
