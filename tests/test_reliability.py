"""docs/reliability.md: each promise's command is one, and finds the tests that it names."""

import shlex

import pytest

from tools import reliability

PROMISES = reliability.promises()


def test_the_page_has_its_promises():
    assert len(PROMISES) >= 15


@pytest.mark.parametrize("promise", PROMISES, ids=lambda promise: promise.command)
def test_a_promises_command_finds_what_it_names(promise):
    program, *words = [word for word in shlex.split(promise.command) if "SLIPSCALE_" not in word]
    if program == "make":
        targets = (reliability.ROOT / "Makefile").read_text(encoding="utf-8")
        assert f"\n{words[0]}: setup\n" in targets
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


def test_a_promise_that_does_not_hold_is_told(monkeypatch, capsys):
    lines = [reliability.Promise("kept", "true"), reliability.Promise("broken", "false")]
    monkeypatch.setattr(reliability, "promises", lambda: lines)
    assert reliability.main() == 1
    said = capsys.readouterr().out
    assert "holds" in said.splitlines()[0]
    assert "FAILS" in said.splitlines()[2]
