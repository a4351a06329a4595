"""docs/validation/index.md: each command exists and finds its tests."""

import shlex

import pytest

from tools.campaigns import __main__ as campaigns
from tools.campaigns import reliability
from tools.campaigns.__main__ import CAMPAIGNS, main

PROMISES = reliability.promises()


def test_the_page_has_its_promises():
    assert len(PROMISES) >= 15


@pytest.mark.parametrize("promise", PROMISES, ids=lambda promise: promise.command)
def test_a_promises_command_finds_what_it_names(promise):
    program, *words = [word for word in shlex.split(promise.command) if "SLIPSCALE_" not in word]
    if program == "make":
        targets = (reliability.ROOT / "Makefile").read_text(encoding="utf-8")
        assert f"\n{words[0]}: set-test\n" in targets
        return
    assert program == "pytest"
    wanted = words[words.index("-k") + 1].split(" or ") if "-k" in words else [""]
    paths = [reliability.ROOT / word for word in words if word.startswith("tests/")]
    assert paths
    for path in paths:
        files = [path] if path.is_file() else sorted(path.rglob("test_*.py"))
        names = [
            line for file in files for line in file.read_text().splitlines() if "def test_" in line
        ]
        assert any(word in name for word in wanted for name in names), path


@pytest.fixture
def lines(monkeypatch, tmp_path):
    """Put other promises into the page's place; return the page."""

    def put(*commands):
        made = [reliability.Promise(f"promise {command}", command) for command in commands]
        monkeypatch.setattr(reliability, "promises", lambda: made)
        page = tmp_path / "page.md"
        page.write_text("a\n<!-- figures: make reliability -->\nold\n<!-- end of figures -->\nb\n")
        monkeypatch.setattr(campaigns, "PAGE", page)
        return page

    return put


def test_a_promise_that_does_not_hold_is_told(lines, capsys):
    page = lines("true", "false")
    assert main(["reliability", "--write"]) == 1
    said = capsys.readouterr().out
    assert "promise true\n      true\n      holds" in said
    assert "promise false\n      false\n      FAILS" in said
    assert "1 of 2 guarantees hold" in said
    text = page.read_text()
    assert text.startswith("a\n<!-- figures: make reliability -->\nLatest results (")
    assert "Does not hold: promise false\n<!-- end of figures -->\nb\n" in text


def test_promises_that_all_hold_are_counted_with_their_tests(lines, capsys):
    lines("echo 3 passed", "echo 4 passed in 2 s")
    assert main(["reliability"]) == 0
    assert "2 of 2 guarantees hold: 7 tests" in capsys.readouterr().out


def test_tests_that_were_all_left_out_show_nothing(lines):
    lines("echo pytest 2 skipped")
    assert main(["reliability"]) == 1


def test_one_promise_can_be_run_by_its_number_and_all_be_listed(lines, capsys):
    lines("true", "false")
    assert main(["reliability", "--line", "1"]) == 0
    assert main(["reliability", "--list"]) == 0
    assert capsys.readouterr().out.count("FAILS") == 0


def test_figures_that_have_no_place_on_the_page_are_told(lines):
    lines()
    with pytest.raises(LookupError, match="no markers around the results of tea"):
        campaigns.put("tea", "none")


def test_all_campaigns_are_listed_and_an_unknown_one_is_refused(capsys):
    with pytest.raises(SystemExit) as listed:
        main(["--help"])
    assert listed.value.code == 0
    printed = capsys.readouterr().out
    for name in CAMPAIGNS:
        assert name in printed
        with pytest.raises(SystemExit) as helped:
            main([name, "--help"])
        assert helped.value.code == 0
        assert f"python -m tools.campaigns {name}" in capsys.readouterr().out
    with pytest.raises(SystemExit) as refused:
        main(["tea"])
    assert refused.value.code == 2
    assert "invalid choice: 'tea'" in capsys.readouterr().err
