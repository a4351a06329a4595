"""The campaign of kills and disk faults, in short: docs/reliability.md has its figures."""

import importlib.util
from pathlib import Path

import pytest

from experiments.study.file import read_study

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def torture():
    spec = importlib.util.spec_from_file_location("torture", ROOT / "tools" / "torture.py")
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    return tool


def test_no_fault_below_the_journal_changes_the_data(torture, capsys):
    assert torture.main(["--every", "60", "--study", "biet2007"]) == 0
    rows = capsys.readouterr().out.splitlines()[2:]
    assert len(rows) == len(torture.FAULTS)
    assert all(row.endswith("| 0 |") for row in rows)
    assert all(int(row.split("|")[3]) >= 2 for row in rows)


def test_a_journal_that_loses_an_answer_is_found(torture, monkeypatch, capsys):
    """The campaign itself can fail: here the journal takes half a record for a whole one."""
    put = torture.Journal._put

    def careless(journal, line):
        if len(journal.records) == 20:
            line = line[: len(line) // 2] + b"\n"
        put(journal, line)

    monkeypatch.setattr(torture.Journal, "_put", careless)
    with pytest.raises(torture.UserError, match="line 21: damaged"):
        torture.main(["--every", "60", "--study", "biet2007"])


def test_the_study_of_every_option_leaves_none_at_its_default(torture):
    study, _ = read_study(str(torture.EVERY_OPTION))
    for options in study.tasks:
        fields = type(options).model_fields
        unset = [name for name in fields if name not in options.model_fields_set]
        assert [name for name in unset if name != "start_um_pp"] == [], options.protocol
