"""A language of the study's own: its file, what is refused of it, and where its words go."""

import json
import re
import tomllib
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.languages.screen_room import LETTERS, not_drawn, too_long
from slipscale.experiments.languages.texts import flatten, languages, shipped_texts, to_translate
from slipscale.experiments.running.changed_texts import changed_texts
from slipscale.experiments.running.study_commands import texts, validate
from slipscale.experiments.study.file import read_study
from slipscale.experiments.study.own_language import _quoted
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError

GERMAN = {
    "session.welcome_title": "Willkommen",
    "session.welcome": "Danke, dass Sie teilnehmen.\n\nEs gibt keine falschen Antworten.",
    "magnitude_estimation.estimate": "Wie rutschig ist diese Oberfläche?",
    "window.yes_key": "j",
    "window.no_key": "n",
    "window.decimal": ",",
}
STUDY = """name = "mine"
title = "Meine"
language = "de"
texts_files = ["texts.de.toml"]
amplitudes_um_pp = [0.0, 1.2]
informed_consent = true

[[tasks]]
protocol = "magnitude_estimation"
repetitions = 1
practice = 0

[[tasks]]
protocol = "descending_difference"
series = 1

[[about_you]]
name = "hand"
prompt = { de = "¤ Welche Hand?" }
options = { right = { de = "¤ rechts" }, left = { de = "¤ links" } }
"""


def marked(key, text):
    """Return a text that shows where it came from; options stay as many as they are."""
    return GERMAN.get(key) or " | ".join(f"¤ {part}" for part in text.split(" | "))


def german(**changes):
    """Return the lines of a complete language file; a change to None leaves the text out."""
    words = {key: marked(key, text) for key, text in to_translate({}).items()}
    words |= {key.replace("__", "."): value for key, value in changes.items()}
    lines = [f"{key} = {_quoted(text)}" for key, text in words.items() if text is not None]
    return "\n".join(['language = "de"', *lines]) + "\n"


@pytest.fixture
def study(tmp_path):
    """Return the study's path; its language file is complete."""
    (tmp_path / "texts.de.toml").write_text(german(), encoding="utf-8")
    path = tmp_path / "mine.toml"
    path.write_text(STUDY, encoding="utf-8")
    return path


def plan_of(path):
    made, text = read_study(str(path))
    return RunPlan(
        study_name=str(path), study_text=text, participant="01", seed=made.seed, language="de",
        mode="pilot",
    )  # fmt: skip


def test_a_whole_session_shows_the_studys_own_words_and_no_others(study, laboratory):
    plan = plan_of(study)
    laboratory.run(plan)
    shown = []
    for step in (record.data["what"] for record in laboratory.records(plan, "begin")):
        screen = step.get("screen") or step
        if screen.get("text") or screen.get("question"):
            shown.append(screen.get("text") or screen["question"]["prompt"])
        shown += [words for _, words in (screen.get("question") or {}).get("options", ())]
    foreign = [text for text in shown if not text.startswith("¤") and text not in GERMAN.values()]
    assert len(shown) > 20
    assert foreign == []
    assert plan.texts()["window.yes_key"] == "j"


def test_the_words_travel_with_the_data_whatever_becomes_of_their_file(study, laboratory):
    plan = plan_of(study)
    laboratory.run(plan)
    (study.parent / "texts.de.toml").unlink()
    build_dataset(laboratory.folder)
    code = laboratory.folder / "code" / "study.toml"
    sidecar = json.loads(next(laboratory.folder.glob("sub-01/beh/*.json")).read_text())
    header = laboratory.records(plan, "header")[0].data
    assert sidecar["Slipscale"]["language"] == "de"
    assert sidecar["Slipscale"]["texts_hash"] == header["texts_hash"]
    assert read_study(str(code))[0].texts["de"]["session"]["welcome_title"] == "Willkommen"
    assert "texts_files" not in code.read_text(encoding="utf-8")
    described = json.loads((laboratory.folder / "participants.json").read_text())
    assert described["hand"]["Levels"] == {"right": "¤ rechts", "left": "¤ links"}


def test_words_that_changed_before_a_resume_are_noticed_and_those_of_before_stay(study, laboratory):
    plan = plan_of(study)
    laboratory.run(plan)
    path = plan.journal_path(laboratory.folder)
    begun, records = read_plan(path)
    assert list(changed_texts(begun, records)) == []
    file = study.parent / "texts.de.toml"
    file.write_text(german(session__welcome="Guten Tag."), encoding="utf-8")
    (said,) = changed_texts(begun, records)
    assert "its texts in 'de' have changed since the run began" in said
    assert begun.texts()["session.welcome"] == GERMAN["session.welcome"]
    records[0].data["texts_hash"] = "of another version"
    assert "the Slipscale version differs" in next(changed_texts(begun, records))


def test_a_text_that_comes_with_a_newer_slipscale_is_asked_for_and_no_old_run_is_lost(study):
    """What the next version adds is what this file lacks."""
    file = study.parent / "texts.de.toml"
    file.write_text(german(matching__turn=None, window__full=None), encoding="utf-8")
    with pytest.raises(UserError, match=r"texts\.de: 2 texts are missing: matching\.turn, window"):
        read_study(str(study))
    file.write_text(german(), encoding="utf-8")
    plan = plan_of(study)
    line = re.search(r"(?m)^window\.full = .*$", plan.study_text)[0]
    older = replace(plan, study_text=plan.study_text.replace(line, ""))
    assert older.texts()["window.full"] == shipped_texts("en")["window.full"]


@pytest.mark.parametrize(
    "changes, told",
    [
        ({"session__rest": ""}, "1 texts are missing: session.rest"),
        ({"session__wellcome": "Hallo"}, r"texts\.de\.session\.wellcome: unknown text"),
        ({"window__progress": "{done} sind vorbei"}, r"window\.progress: {total} is missing"),
        (
            {"window__progress": "{done} {total} {x}"},
            r"line \d+, window\.progress: contains unknown",
        ),
        ({"comparing__options": "das erste | das zweite"}, "expected 3 answers"),
        ({"window__yes_key": "n"}, "expected two different letters"),
        ({"window__decimal": "'"}, r"window\.decimal: expected a point or a comma"),
        ({"session__rest": "Пауза 休み"}, r"cannot display '休' \(U\+4F11\)"),
        ({"session__rest": "הפסקה"}, "from right to left"),
        ({"session__welcome": "Wort " * 500}, "too long for its place"),
        ({"matching__title": "Donaudampfschiff" * 4}, "too long for its place"),
    ],
)
def test_what_would_fail_on_the_screen_is_refused_when_the_study_is_read(study, changes, told):
    (study.parent / "texts.de.toml").write_text(german(**changes), encoding="utf-8")
    with pytest.raises(UserError, match=told):
        validate(str(study))


@pytest.mark.parametrize(
    "text, told",
    [
        ("session.rest = 3\nlanguage = 'de'", "line 1, session.rest: expected words in quotes"),
        ("[session]\nrest = 'Pause'", "language: expected a language code"),
        ("language = 'Deutsch!'", "expected a language code, such as de"),
        ("language = 'fr'", "language 'fr' already exists"),
        ("language = 'de", "is not TOML"),
        (None, "cannot be read"),
    ],
)
def test_a_file_that_is_none_is_refused_with_its_name(study, text, told):
    file = study.parent / "texts.de.toml"
    file.unlink() if text is None else file.write_text(text)
    with pytest.raises(UserError, match=told) as fault:
        read_study(str(study))
    assert "texts.de.toml" in str(fault.value)


@pytest.mark.parametrize(
    "change, told",
    [
        (('language = "de"', 'language = "tlh"'), "language: expected one of en, fr, de"),
        (("{ de = ", "{ nl = "), "prompt of item 1 of about_you: 'hand' has no prompt in 'de'"),
        (('["texts.de.toml"]', '["texts.de.toml", "texts.de.toml"]'), "already exists"),
        (('["texts.de.toml"]', '"texts.de.toml"'), "texts_files: expected a list"),
        (('["texts.de.toml"]', '["texts.de.toml"]\ntexts = 1.5'), "texts: expected a table"),
        (("texts.de.toml", "../texts.de.toml"), "a file next to the study file, without a folder"),
        (("texts.de.toml", "/etc/passwd"), "a file next to the study file, without a folder"),
        (("texts.de.toml", "texts\\u0000.toml"), "a file next to the study file, without a folder"),
        (("amplitudes", 'texts = {en = {window = {full = "x"}}}\namplitudes'), "not texts = {"),
    ],
)
def test_a_study_that_does_not_fit_its_language_is_refused(study, change, told):
    study.write_text(STUDY.replace(*change), encoding="utf-8")
    with pytest.raises(UserError) as fault:
        read_study(str(study))
    assert told in str(fault.value)


def test_the_template_has_every_text_with_its_english_and_place(study):
    out = study.parent / "new.toml"
    (study.parent / "texts.de.toml").unlink()  # it need not be there yet
    said = texts(str(study), "de", out)
    assert 'texts_files = ["new.toml"]' in said
    written = out.read_text(encoding="utf-8")
    table = tomllib.loads(written)
    assert table.pop("language") == "de"
    assert flatten(table) == dict.fromkeys(to_translate({}), "")
    assert "# {done} of {total} trials are done\n# (a line of small print" in written
    assert "filled in: {done}, {total})\nprogress" in written


def test_the_template_keeps_what_is_translated_already(study):
    out = study.parent / "new.toml"
    texts(str(study), "de", out)
    table = tomllib.loads(out.read_text(encoding="utf-8"))
    assert table["session"]["welcome"] == GERMAN["session.welcome"]
    with pytest.raises(UserError, match="already exists"):
        texts(str(study), "de", out)
    for code, told in (
        ("fr", "such as session.welcome, session.thanks, magnitude_estimation.instructions"),
        ("Deutsch!", "expected a language code"),
    ):
        with pytest.raises(UserError, match=told):
            texts(str(study), code, out.with_name("other.toml"))


@pytest.mark.parametrize("language", languages())
def test_the_shipped_texts_fit_their_places_and_can_be_drawn(language):
    for key, text in shipped_texts(language).items():
        assert (key, not_drawn(text), too_long(key, text)) == (key, "", "")


@given(st.text())
def test_any_text_is_written_as_toml_reads_it(text):
    assert tomllib.loads(f"a = {_quoted(text)}")["a"] == text


def test_the_letters_said_to_be_drawn_are_in_the_windows_fonts():
    spec = find_spec("psychopy")
    if spec is None:
        pytest.skip("the window's fonts come with PsychoPy")
    TTFont = pytest.importorskip("fontTools.ttLib").TTFont

    for name in ("NotoSans-Regular.ttf", "NotoSans-Bold.ttf"):
        font = TTFont(Path(spec.origin).parent / "assets" / "fonts" / name)
        assert {ord(letter) for letter in LETTERS} <= set(font.getBestCmap())


def test_a_language_may_stand_in_the_study_file_itself_and_is_checked_alike(study):
    whole = german().replace('language = "de"', "[texts.de]")
    inside = STUDY.replace('texts_files = ["texts.de.toml"]\n', "") + whole
    study.write_text(inside, encoding="utf-8")
    assert "no fault" in validate(str(study))
    study.write_text(inside.replace("{done}", "viele"), encoding="utf-8")
    with pytest.raises(UserError, match=r"texts\.de\.window\.progress: {done} is missing"):
        validate(str(study))
