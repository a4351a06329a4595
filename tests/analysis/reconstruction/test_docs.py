"""The page on reconstruction: its Python prints what it says, its table is one that is read."""

import doctest
import re
from pathlib import Path

from slipscale.analysis.reconstruction.table.table_files import from_toml

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "reconstruct.md"


def test_every_line_of_python_prints_what_the_page_says(capsys):
    # The fence that ends a block of code is no output.
    page = PAGE.read_text(encoding="utf-8").replace("```\n", "\n")
    test = doctest.DocTestParser().get_doctest(page, {}, PAGE.name, str(PAGE), 0)
    found = doctest.DocTestRunner().run(test)
    assert found.attempted > 10
    assert not found.failed, capsys.readouterr().out


def test_the_file_on_the_page_is_a_table():
    (text,) = re.findall(
        r"^```toml\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )
    assert from_toml(text).columns[0].amplitude_um_pp == 0
