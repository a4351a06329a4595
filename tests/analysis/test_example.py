"""The page on the analysis in Python: what it says that lines print is what they print."""

import doctest
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "in-python.md"


def test_every_line_of_the_page_prints_what_the_page_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    # The fence that ends a block of code is no output.
    page = PAGE.read_text(encoding="utf-8").replace("```\n", "\n")
    test = doctest.DocTestParser().get_doctest(page, {}, PAGE.name, str(PAGE), 0)
    found = doctest.DocTestRunner().run(test)
    assert found.attempted > 20
    assert not found.failed, capsys.readouterr().out
    assert (tmp_path / "fig15.svg").read_text(encoding="utf-8").startswith("<?xml")
