"""The page of the study: read, judged, edited, and never changed under data."""

import json
import re

import pytest

from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.lab.folder import read_lab
from slipscale.experiments.languages.texts import to_translate
from slipscale.experiments.study.file import read_study, study_text


@pytest.fixture
def own_study(lab):
    text = study_text("biet2007").replace('name = "biet2007"', 'name = "mine"')
    (lab / "mine.toml").write_text(text)
    (lab / "slipscale.toml").write_text('study = "mine.toml"\nplate = "serial:COM9"\n')
    return lab / "mine.toml"


def before_of(visitor):
    return re.search(r'data-before="([0-9a-f]{64})"', visitor.see("/study"))[1]


def test_the_study_is_read_edited_and_judged_as_on_the_command_line(visitor, own_study, words_of):
    text, before = own_study.read_text(), before_of(visitor)
    assert "Descending difference" in words_of(visitor.see("/study"))
    changed = text.replace("seed = 2007", "seed = 7")
    assert visitor.edit(changed).json()["faults"] == []
    assert visitor.ask("save", text=changed, before=before)[0] == 200
    assert own_study.read_text() == changed


def test_a_texts_file_stays_a_file_of_its_own_when_the_study_is_edited(visitor, own_study):
    words = [f"{key} = {json.dumps(text)}" for key, text in to_translate({}).items()]
    (own_study.parent / "texts.de.toml").write_text("\n".join(['language = "de"', *words]))
    named = 'language = "de"\ntexts_files = ["texts.de.toml"]'
    text = re.sub(r"(?m)^language = .*$", named, own_study.read_text())
    text = re.sub(r"(?s)\[\[about_you\]\].*?(?=\[masking)", "", text)
    own_study.write_text(text)
    assert "Thank you for taking part" not in visitor.see("/study")
    changed = text.replace("seed = 2007", "seed = 7")
    assert visitor.ask("save", text=changed, before=before_of(visitor))[0] == 200
    assert own_study.read_text() == changed
    (own_study.parent / "texts.de.toml").write_text('language = "de"')
    [(_, said)] = visitor.edit(changed).json()["faults"]
    assert "texts are missing" in said


def test_a_file_that_was_spoilt_elsewhere_is_corrected_on_the_page(visitor, own_study):
    text = own_study.read_text()
    own_study.write_text(text.replace("seed = 2007", "seed = ["))
    assert "seed = [" in visitor.see("/study")
    assert visitor.ask("save", text=text, before=before_of(visitor))[0] == 200
    assert own_study.read_text() == text


def test_every_fault_is_told_at_its_line_and_nothing_is_saved(visitor, own_study):
    text, before = own_study.read_text(), before_of(visitor)
    faulty = text.replace("seed = 2007", "seed = -7").replace("series = 1", "series = 0")
    status, said = visitor.ask("save", text=faulty, before=before)
    assert status == 409
    found = [("6", "seed"), ("12", "series of item 1 of tasks")]
    assert re.findall(r"line (\d+), ([a-z 0-9]+)", said) == found
    edited = visitor.edit(faulty).json()
    assert [line for line, _ in edited["faults"]] == [6, 12]
    wrong = re.findall(r'id="(field-[^"]+)"[^>]+aria-invalid', edited["html"])
    assert wrong == ["field-seed", "field-tasks-0-series"]
    assert own_study.read_text() == text


def test_a_study_that_was_edited_on_disk_in_between_is_not_overwritten(visitor, own_study):
    before = before_of(visitor)
    own_study.write_text(own_study.read_text().replace("2007", "2008"))
    status, said = visitor.ask("save", text="x", before=before)
    assert (status, "was changed on disk" in said) == (409, True)


def test_a_study_with_data_is_never_edited_and_a_copy_is_offered(visitor, recorded, lab):
    (lab / "biet.toml").write_text(study_text("biet2007"))
    (lab / "slipscale.toml").write_text('study = "biet.toml"\nplate = "serial:COM9"\n')
    page = visitor.see("/study")
    assert "has data" in page
    assert 'data-study="save"' not in page
    text = (lab / "biet.toml").read_text()
    assert visitor.ask("save", text=text, before=before_of(visitor))[0] == 409
    assert visitor.ask("copy", name="second-one", text=text)[0] == 200
    assert 'name = "second_one"' in (lab / "second-one.toml").read_text()
    status, said = visitor.ask("copy", name="second-one", text=text)
    assert (status, "already exists" in said) == (409, True)


def test_a_shipped_study_is_not_edited(visitor):
    assert "comes with Slipscale" in visitor.see("/study")


def test_any_shipped_study_is_the_beginning_of_ones_own(visitor, lab, words_of):
    page = visitor.see("/study?from=matching")
    assert "This is the shipped study matching" in words_of(page)
    assert 'protocol = "matching"' in page.replace("&#34;", '"')
    assert 'data-study="save"' not in page
    assert "This is the shipped study" not in words_of(visitor.see("/study?from=../secret"))
    assert visitor.ask("copy", name="own", text=study_text("matching"))[0] == 200
    assert 'name = "own"' in (lab / "own.toml").read_text()


@pytest.mark.parametrize(
    "title, kept", [("Grip force and slip", "other"), ("A title of my own", "A title of my own")]
)
def test_a_copy_is_used_at_once_and_has_no_title_or_authors_of_the_original(
    visitor, lab, own_study, title, kept
):
    head = 'title = "Grip force and slip"\nauthors = ["A. N. Other"]\n'
    original = re.sub(r"(?m)^title = .*\n(authors = .*\n)?", head, own_study.read_text())
    own_study.write_text(original)
    visitor.console.state.now(fresh=True)
    text = original.replace("Grip force and slip", title)
    status, said = visitor.ask("copy", name="other", text=text)
    assert (status, "which this folder now uses" in said) == (200, True)
    study = read_study(str(lab / "other.toml"))[0]
    assert (study.title, study.authors) == (kept, ())
    assert read_lab(lab).study == "other.toml"


def test_a_copy_during_a_session_is_written_but_not_used(visitor, lab, session, status):
    with session(status):
        assert (
            "select it on the Settings page"
            in visitor.ask("copy", name="mine", text=study_text("matching"), template="matching")[1]
        )
    assert read_lab(lab).study != "mine.toml"


def test_the_study_is_compared_with_the_version_of_the_last_run(visitor, recorded, lab, words_of):
    path = next(recorded.rglob("sub-01*_journal.jsonl"))
    used = read_plan(path)[0].study_text
    (lab / "used.toml").write_text(used)
    (lab / "slipscale.toml").write_text('study = "used.toml"\nplate = "serial:COM9"\n')
    same = words_of(visitor.see("/study"))
    assert re.search(r"The study has not changed since the last run \(participant 0[12]\)", same)
    (lab / "used.toml").write_text(re.sub(r"(?m)^title = .*$", 'title = "<Other>"', used))
    visitor.console.state.now(fresh=True)
    page = visitor.see("/study")
    [now] = re.findall(r'<li class="now">.*?<code>(.*?)</code>', page)
    [before] = re.findall(r'<li class="before">.*?<code>(.*?)</code>', page)
    assert now == "title = &#34;&lt;Other&gt;&#34;"
    assert before.startswith("title = ")
    assert before != now
    assert "The study has changed since the last run" in words_of(page)


def test_a_change_in_the_form_keeps_comments_and_brings_form_trials_and_faults(visitor, own_study):
    text = own_study.read_text()
    set_it = {"what": "set", "kind": "number", "place": ["tasks", 1, "repetitions"], "value": "3"}
    edited = visitor.edit(text, change=set_it).json()
    assert edited["text"] == text.replace("repetitions = 1", "repetitions = 3")
    assert "one session: 20 trials" in edited["html"]
    assert 'class="surface"' in edited["html"]
    wrong = visitor.edit(text, change=set_it | {"value": "many"}).json()
    assert "expected a whole number, got &#39;many&#39;" in wrong["html"]
    assert wrong["faults"][0][0] == 17
    assert own_study.read_text() == text  # nothing is saved
    assert visitor.edit("x", change=set_it).status_code == 409
    assert "not TOML" in visitor.edit("x").json()["faults"][0][1]


def test_minutes_cost_and_balance_follow_from_the_text(visitor, own_study, words_of):
    priced = own_study.read_text() + "[cost]\nper_person = 10\nper_rig_hour = 0\n"
    page = words_of(visitor.edit(priced, "later").json()["html"])
    assert re.search(r"[\d.]+ minutes per participant", page)
    assert "10 EUR per participant, 120 EUR for 12 participants" in page
    assert "each surface follows every other surface" in page
    assert "12 12 Descending difference" in page
    assert "<p>" not in visitor.edit("seed = -1", "later").json()["html"]


def test_a_study_in_another_quantity_has_its_own_keys_and_unit(visitor):
    text = 'levels = [1]\n[quantity]\nname = "voltage"\nunit = "V"\nconvention = "peak"\n'
    page = visitor.edit(text).json()["html"]
    assert 'data-place="[&#34;voltages_v_peak&#34;]"' in page
    assert 'voltages <span class="quiet">V peak</span>' in page
