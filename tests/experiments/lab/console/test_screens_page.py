"""The page of the screens: each screen of the study, in each language, and what cannot be read."""

import re

import pytest

from slipscale.experiments.study.file import read_study, study_text

LONG = "Please say how often you touch smooth things with your bare finger. " * 8


def labels(page):
    return re.findall(r'role="img" aria-label="([^"]*)"', page)


@pytest.fixture
def own_study(lab):
    (lab / "mine.toml").write_text(study_text("biet2007"))
    (lab / "slipscale.toml").write_text('study = "mine.toml"\nplate = "serial:COM9"\n')
    return lab / "mine.toml"


def test_every_screen_of_a_run_is_drawn_once_with_its_task(visitor, own_study, words_of):
    page = visitor.see("/screens")
    assert len(labels(page)) == 16
    assert labels(page)[0] == "Screen 1: instructions"
    assert "Screen 8: Descending difference: question" in labels(page)
    assert "All 16 screens are readable" in words_of(page)
    assert 'viewBox="0 0 1920 1080"' in page


def test_a_language_and_a_size_are_chosen_by_links(visitor, own_study):
    page = visitor.see("/screens?screens=fr&size=1280x1024")
    assert page.count('viewBox="0 0 1280 1024"') == 16
    assert "Merci de participer." in page
    for nonsense in ("size=0x0", "size=99999x1", "screens=xx"):
        assert 'viewBox="0 0 1920 1080"' in visitor.see(f"/screens?{nonsense}")


def test_a_screen_that_cannot_be_read_is_named_in_its_language(visitor, own_study, words_of):
    own_study.write_text(
        'name = "s"\ntitle = "S"\namplitudes_um_pp = [0, 1]\n[[about_you]]\nname = "touching"\n'
        f'prompt = {{ en = "{LONG}", fr = "Souvent ?" }}\noptions = ["often", "never"]\n'
        '[[tasks]]\nprotocol = "magnitude_estimation"\n'
    )
    page = words_of(visitor.see("/screens"))
    assert re.search(r"Language en 1 unreadable fr Screen", page)
    assert re.search(r"1 of [0-9]+ screens are not readable", page)
    assert "is too long for its place on the screen" in page
    assert "écrans" not in page
    assert "is too long for" not in visitor.see("/screens?screens=fr")


def test_the_size_of_the_screen_that_the_checklist_found_comes_first(visitor, own_study):
    class Check:
        running = False

        def said(self):
            return '[{"name": "display", "passed": true, "detail": "screen 0, 1600 x 900, focus"}]'

    visitor.jobs.jobs["check"] = Check()
    page = visitor.see("/screens")
    assert 'viewBox="0 0 1600 900"' in page
    assert "1600 × 900 (detected by the last check)" in page


def test_a_study_that_cannot_be_rehearsed_is_told_in_words(visitor, own_study, monkeypatch):
    own_study.write_text("name = 1")
    assert "mine.toml" in visitor.see("/screens")


def test_light_screens_are_drawn_light(visitor, own_study):
    assert 'fill="#26282b"' in visitor.see("/screens")
    own_study.write_text(own_study.read_text().replace("seed =", 'screens = "light"\nseed =', 1))
    visitor.console.state.now(fresh=True)
    page = visitor.see("/screens")
    assert 'fill="#f5f5f3"' in page
    assert 'fill="#26282b"' not in page


WELCOME = "/screens?key=session.welcome_title"


def before_of(visitor):
    return re.search(r'name="before" value="([0-9a-f]{64})"', visitor.see(WELCOME))[1]


def test_every_picture_names_its_texts_and_each_leads_to_its_form(visitor, own_study, words_of):
    page = visitor.see("/screens")
    assert '<g data-text="session.welcome_title">' in page
    assert "?key=magnitude_estimation.instructions&amp;screens=en" in page
    form = visitor.see(WELCOME)
    assert len(labels(form)) == 1
    assert "at most 1 lines of some 44 letters" in words_of(form)
    assert re.search(r'<textarea id="text-en".*?>\s*Welcome</textarea>', form, re.DOTALL)
    assert re.search(r'<textarea id="text-fr".*?>\s*Bienvenue</textarea>', form, re.DOTALL)
    assert len(labels(visitor.see("/screens?key=no.such.text"))) == 16


def test_what_is_typed_is_seen_before_it_is_saved(visitor, own_study, words_of):
    before = own_study.read_text()
    page = visitor.see(f"{WELCOME}&en=Good+morning")
    assert "Good morning</text>" in page
    assert "Welcome</text>" not in page
    told = words_of(visitor.see("/screens?key=session.welcome&en=Hello+%7Bname%7D"))
    assert "unknown placeholders or unbalanced braces" in told
    assert "too long" in words_of(visitor.see(f"{WELCOME}&en={'long+' * 30}"))
    assert own_study.read_text() == before


def test_texts_are_saved_by_language_and_an_empty_one_is_that_of_slipscale(visitor, own_study):
    texts = {"en": "Good morning", "fr": "Bonjour"}
    asked = {"key": "session.welcome_title", "before": before_of(visitor)}
    assert visitor.ask("text", **asked, texts=texts)[0] == 200
    study = read_study(str(own_study))[0]
    assert {each: study.texts[each]["session"]["welcome_title"] for each in texts} == texts
    assert "# " in own_study.read_text()  # comments stay
    assert "changed on disk" in visitor.ask("text", **asked, texts=texts)[1]
    asked["before"] = before_of(visitor)
    assert visitor.ask("text", **asked, texts={"en": "", "fr": "Bienvenue"})[0] == 200
    assert "Good morning" not in visitor.see("/screens")
    asked["before"] = before_of(visitor)
    status, said = visitor.ask("text", **asked, texts={"en": "{nobody}"})
    assert (status, "available placeholders" in said) == (409, True)


def test_a_text_of_a_shipped_study_is_not_changed(visitor, lab, words_of):
    (lab / "slipscale.toml").write_text('study = "matching"\nplate = "serial:COM9"\n')
    visitor.console.state.now(fresh=True)
    page = visitor.see(WELCOME)
    assert "make a copy" in words_of(page)
    assert "readonly" in page
    asked = {"key": "session.welcome_title", "before": before_of(visitor)}
    assert visitor.ask("text", **asked, texts={"en": "x"})[0] == 409
