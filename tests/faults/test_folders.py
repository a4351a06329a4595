"""Hidden files, such as those of macOS, are in no list of files."""

import re

from slipscale.faults.folders import visible
from tests.support.own_modules import FOLDERS, ROOT

#: Places that list files themselves, because hidden ones belong to them or cannot occur.
THEMSELVES = {
    "analysis/planning/distribution/files.py",  # is the folder empty?
    "analysis/preregistration/bundle.py",  # packs what it wrote itself
    "analysis/preregistration/freeze.py",  # unpacks what it wrote itself
    "analysis/reconstruction/table/table_files.py",  # shipped tables
    "experiments/cli/sessions.py",  # folders of pilots
    "experiments/dataset/merging.py",  # is the folder empty?
    "experiments/dataset/remains.py",  # every file may hold a withdrawn person's data
    "experiments/dataset/withdrawal.py",  # hidden drafts and copies are withdrawn, too
    "experiments/lab/console/app.py",  # every file, for the time of the last change
    "experiments/lab/console/page_texts.py",  # shipped catalogues
    "experiments/lab/console/presence.py",  # its own files
    "experiments/lab/console/state.py",  # numbered folders and plans
    "experiments/languages/texts.py",  # shipped languages
    "experiments/running/pilot.py",  # numbered folders
    "experiments/session/mailbox.py",  # its own files
    "experiments/study/file.py",  # shipped studies
    "hardware/emulator/compiled.py",  # sources of the firmware
    "faults/folders.py",
}


def test_hidden_files_and_files_in_hidden_folders_are_left_out(tmp_path):
    for name in ("a.tsv", "._a.tsv", "b/c.tsv", "b/._c.tsv", ".git/d.tsv"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    found = [path.relative_to(tmp_path).as_posix() for path in visible(tmp_path, "**/*.tsv")]
    assert found == ["a.tsv", "b/c.tsv"]


def test_files_are_listed_in_one_place():
    listing = re.compile(r"\.(?:r?glob|iterdir)\(")
    found = {
        path.relative_to(ROOT).as_posix()
        for folder in FOLDERS
        for path in (ROOT / folder).rglob("*.py")
        if listing.search(path.read_text("utf-8"))
    }
    assert found == THEMSELVES


def test_a_hidden_folder_as_root_is_no_reason_to_find_nothing(tmp_path):
    (tmp_path / ".lab").mkdir()
    (tmp_path / ".lab" / "a.csv").touch()
    assert [path.name for path in visible(tmp_path / ".lab", "*.csv")] == ["a.csv"]
