"""Published tables as people type them, by the thousand: understood, or refused in a sentence.

A campaign of all such tests: ``make fuzz TEXTS=100000``.
"""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.reconstruction.constraints import targets
from analysis.reconstruction.table_files import SHIPPED, read
from faults import UserError
from tools.fuzzing import bounded, campaign, changed_file

TOML = [path.read_text(encoding="utf-8") for path in sorted(SHIPPED.glob("*.toml"))]
CSV = """label,n,mean,sd,scale_minimum,scale_maximum,maximum_deviation,rounding
0 um,12,12.75,12.75,0,100,27.25,
1.2 um,12,46.2,20.1,0,100,,truncated
"1,2",7,3.14,0.90,1,7,,
"""


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz")


TABLES = st.one_of(
    st.sampled_from(TOML).flatmap(changed_file).map(lambda content: ("toml", content)),
    st.sampled_from([(CSV, ","), (CSV.replace(",", ";"), ";")])
    .flatmap(lambda table: changed_file(*table))
    .map(lambda content: ("csv", content)),
)


@campaign(quick=300)
@given(TABLES)
def test_a_published_table_is_understood_or_refused_in_a_sentence(place, file):
    ending, content = file
    path = place / f"table.{ending}"
    path.write_bytes(content)
    with bounded():
        try:
            table = read(path)
        except UserError as error:
            assert str(path) in str(error)  # noqa: PT017 - wherever the fault is
            return
        assert table.columns
        assert [targets(column) for column in table.columns]
