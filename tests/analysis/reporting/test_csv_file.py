"""The CSV writer: pandas's own is the independent implementation."""

import numpy as np
import pandas as pd
from hypothesis import given
from hypothesis import strategies as st

from slipscale.analysis.writing.csv_file import write_csv
from slipscale.faults.spreadsheet_cells import harmless_cell

# Before Python 3.13 pandas leaves a lone CR unquoted, and no reader gives that cell back.
TEXTS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\r"), max_size=8)
ROWS = st.lists(
    st.tuples(
        st.one_of(TEXTS, st.none()),
        st.floats().map(lambda value: value + 0.0),  # no -0: it is one value with 0
        st.integers(-(2**53), 2**53),
        st.booleans(),
        st.sampled_from(["sub-01", "sub-02", None]),
    ),
    max_size=20,
)


@given(rows=ROWS)
def test_the_bytes_are_those_that_pandas_writes_of_harmless_cells(rows, tmp_path_factory):
    table = pd.DataFrame(rows, columns=["text", "a, b", "n", "felt", "participant_id"])
    table = table.assign(
        **{
            "a, b": table["a, b"].astype(float),
            "n": table["n"].astype("int64"),
            "participant_id": table["participant_id"].astype("category"),
        }
    )
    folder = tmp_path_factory.mktemp("csv")
    write_csv(table, folder / "ours.csv")
    table["text"] = table["text"].map(harmless_cell, na_action="ignore")
    table.to_csv(folder / "pandas.csv", index=False, lineterminator="\n")
    assert (folder / "ours.csv").read_bytes() == (folder / "pandas.csv").read_bytes()


def test_a_number_comes_back_to_the_last_bit(tmp_path):
    values = np.random.default_rng(1).lognormal(0, 20, 1000)
    write_csv(pd.DataFrame({"x": values}), tmp_path / "x.csv")
    back = [float(line) for line in (tmp_path / "x.csv").read_text().splitlines()[1:]]
    assert back == values.tolist()


def test_a_text_is_no_formula_and_a_negative_number_stays_one(tmp_path):
    table = pd.DataFrame({"=who": ["=A1", "@b"], "x": [-3.5, 2.0]})
    write_csv(table, tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text() == "'=who,x\n'=A1,-3.5\n'@b,2.0\n"
