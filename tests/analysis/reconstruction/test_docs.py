"""The page on reconstruction: its table is one that is read."""

import re
from pathlib import Path

from slipscale.analysis.reconstruction.table.table_files import from_toml

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "reconstruct.md"


def test_the_file_on_the_page_is_a_table():
    (text,) = re.findall(
        r"^```toml\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )
    assert from_toml(text).columns[0].amplitude_um_pp == 0
