"""Tables with the same header are parsed at once, with the results of reading each alone."""

import re

import pandas as pd
import pytest

from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.dialect import has_thousands_point
from slipscale.analysis.reading.foreign.together import read_together
from slipscale.analysis.reading.table_by_hand import Request, read_table

REQUEST = Request(
    required=("who", "level"), numbers=("level", "trial"), words=("who", "said"), identifier="who"
)
HEADER = "who,level,trial,said\n"
#: Files with whole numbers, decimals, missing cells, quotes, another order, and text in numbers.
FILES = {
    "whole.csv": HEADER + "a,1,1,yes\na,2,2,no\n",
    "decimals.csv": HEADER + "b,0.1,1,yes\nb,12.345,2,01\n",
    "missing.csv": HEADER + "c,NA,1,NA\n,3,2,n/a\nNA,4,,no\n",
    "quoted.csv": HEADER + '"NA",1,1,"yes, quite"\nd,2,2,no\n',
    "order.csv": "level,who,said,trial\n5,e,1.0,1\n6,e,1,2\n",
    "blank.csv": HEADER + "f,1,1,yes\n\nf,2,2,no\n,,,\nf,3,3,no\n",
    "more.csv": HEADER + "g,7,3,yes\ng,8,4,no\n",
    "empty.csv": HEADER,
}


def written(folder, files):
    for name, text in files.items():
        (folder / name).write_text(text)
    return [folder / name for name in files]


@pytest.mark.parametrize("text", [None, "x,five,1,yes\nx,6,2,no\n", 'x,"1,5",1,yes\n'])
def test_tables_read_together_are_those_read_alone(tmp_path, text):
    files = FILES if text is None else FILES | {"text.csv": HEADER + text}
    paths = written(tmp_path, files)
    problems, alone = Problems(), Problems()
    read, faults = read_together(paths, REQUEST, tmp_path, problems)
    assert not faults
    expected = [read_table(path, REQUEST, alone, tmp_path) for path in paths]
    assert [source for _, source in read.values()] == [source for _, source in expected]
    assert problems == alone
    assert [frame["file"].tolist()[:1] for frame, _ in read.values()][:3] == [[0], [1], [2]]
    found, other = (
        pd.concat([frame for frame, _ in each], ignore_index=True).drop(columns="file")
        for each in (read.values(), expected)
    )
    pd.testing.assert_frame_equal(found, other)


def test_twenty_tables_are_parsed_at_once(tmp_path, monkeypatch):
    paths = written(tmp_path, {f"s{n}.csv": HEADER + f"s{n},{n},1,yes\n" for n in range(1, 21)})
    parsed = []
    once = pd.read_csv
    monkeypatch.setattr(pd, "read_csv", lambda *a, **k: parsed.append(a) or once(*a, **k))
    read, _ = read_together(paths, REQUEST, tmp_path, Problems())
    assert (len(read), len(parsed)) == (20, 1)


def test_a_damaged_table_is_named_and_the_others_are_read(tmp_path):
    files = {f"s{n}.csv": HEADER + f"s{n},{n},1,yes\n" for n in range(3)}
    paths = written(tmp_path, files | {"s1.csv": HEADER + "s1,1,1\n"})
    read, faults = read_together(paths, REQUEST, tmp_path, Problems())
    assert (list(read), list(faults)) == ([0, 2], [1])
    assert "line 2 has 3 cells" in str(faults[1])


def test_points_between_thousands_are_found():
    text = re.compile(rb"(?<![\d.])[1-9]\d{0,2}\.\d{3}(?![\d.])")
    parts = [b"", b"0", b"1", b"12", b"012", b"123", b"1234", b"1.2", b"x", b"."]
    ends = [b"", b"0", b"00", b"080", b"0805", b"080.", b"080,5", b"080x"]
    cells = [b"%s.%s" % (part, end) for part in parts for end in ends]
    found = [cell for cell in cells if has_thousands_point(cell)]
    assert found == [cell for cell in cells if text.search(cell)]
    assert len(found) == 9
    # A table is searched in parts of a million bytes.
    for before in range(2**20 - 8, 2**20 + 8):
        assert has_thousands_point(b"0" * (before - 1) + b",1.080\n")
        assert not has_thousands_point(b"0" * (before - 1) + b",01.080\n")
