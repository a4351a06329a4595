"""The page of the settings: it writes the same slipscale.toml, and makes one in a new folder."""

import hashlib
import json
from html import unescape
from types import SimpleNamespace

import pytest

from slipscale.experiments.lab.console.jobs import Job
from slipscale.experiments.lab.folder import LabFile, read_lab

DEFAULTS = LabFile().model_dump(mode="json") | {"markers": ""}


def save(visitor, folder, **changes):
    file = folder / "slipscale.toml"
    text = file.read_text() if file.exists() else ""
    before = hashlib.sha256(text.encode()).hexdigest()
    return visitor.ask("settings", settings=DEFAULTS | changes, before=before)


def test_every_key_of_the_file_has_a_labelled_field(visitor):
    page, french = (unescape(visitor.see(f"/settings?lang={code}")) for code in ("en", "fr"))
    for key, field in LabFile.model_fields.items():
        assert f'name="{key}"' in page
        assert f'<label for="setting-{key}">' in page
        assert str(field.description) in page
        assert str(field.description) not in french


def test_what_is_saved_is_what_commands_read_and_comments_stay(visitor, lab):
    file = lab / "slipscale.toml"
    file.write_text(f"# ours\n{file.read_text()}")
    (lab / "copy").mkdir()
    said = save(visitor, lab, plate="mock", screen=1, markers="lsl", backup="copy", language="fr")
    assert said == (200, "saved: slipscale.toml")
    found = read_lab(lab)
    assert (found.plate, found.screen, found.markers) == ("mock", 1, ("lsl",))
    assert (found.backup, found.language) == ("copy", "fr")
    text = file.read_text()
    assert text.startswith("# ours\n")
    assert text.count("#") == 3 + len(LabFile.model_fields)


def test_a_new_folder_is_set_up_in_the_browser(visitor, lab):
    (lab / "slipscale.toml").unlink()
    assert "not set up yet" in visitor.see("/settings")
    assert save(visitor, lab, study="matching")[0] == 200
    assert read_lab(lab).study == "matching"
    assert "not set up yet" not in visitor.see("/settings")


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"study": "gone.toml"}, "gone.toml"),
        ({"plate": "serail:COM1"}, "serail"),
        ({"language": "xx"}, "xx"),
        ({"backup": "/not/there"}, "backup: /not/there: no such folder"),
        ({"pilots": "data"}, "a folder other than the folder for participants' data"),
        ({"screen": -1}, "screen"),
        ({"plate": "mock\n[x]"}, ""),
    ],
)
def test_what_cannot_be_used_is_refused_and_nothing_is_written(visitor, lab, changes, words):
    before = (lab / "slipscale.toml").read_text()
    status, said = save(visitor, lab, **changes)
    if status == 200:  # a plate's options are judged when it is opened; the file holds them whole
        assert read_lab(lab).plate == changes["plate"]
        return
    assert (status, words in said) == (409, True)
    assert (lab / "slipscale.toml").read_text() == before


def test_a_file_that_changed_on_disk_is_not_overwritten(visitor, lab):
    said = visitor.ask("settings", settings=DEFAULTS, before="0" * 64)
    assert said[0] == 409
    assert "was changed on disk" in said[1]


def test_a_file_with_a_fault_is_never_overwritten_by_defaults(visitor, lab):
    file = lab / "slipscale.toml"
    file.write_text('plate = "serial:COM9"\nbakup = "x"\n')
    page = visitor.see("/settings")
    assert "bakup" in page
    assert '<form id="settings"' not in page
    assert save(visitor, lab)[0] == 409
    assert "bakup" in file.read_text()


def test_settings_wait_for_the_end_of_a_session(visitor, session, status, lab):
    with session(status):
        assert "is running; end it first" in save(visitor, lab)[1]


def test_a_plate_is_tried_before_it_is_saved(visitor, lab, tmp_path, words_of):
    assert visitor.ask("test", plate="--help")[0] == 200
    ((kind, *words),) = visitor.jobs.started
    assert (kind, words[-3:]) == ("test", ["--only", "plate", "--plate=--help"])
    (tmp_path / "out").write_text(
        json.dumps([{"name": "plate", "passed": True, "detail": "ok", "remedy": ""}])
    )
    process = SimpleNamespace(poll=lambda: 0)
    paths = {"output": tmp_path / "out", "errors": tmp_path / "none"}
    visitor.jobs.jobs["test"] = Job(kind="test", about="the test", process=process, **paths)
    assert "plate ok" in words_of(visitor.see("/settings"))
    assert "The checks have not been run since" in words_of(visitor.see("/"))  # it is no checklist
