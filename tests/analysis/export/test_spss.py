"""Tables for SPSS, JASP and jamovi."""

import csv
import re
import shutil
import subprocess

import numpy as np
import pandas as pd
import pyreadstat
import pytest

from slipscale.analysis.export.files import write_export
from slipscale.analysis.export.spss import write_sav
from slipscale.analysis.pipeline import analyse

TABLE = pd.DataFrame(
    {
        "participant_id": ["01", "02", "é"],
        "estimate_0_5": [0.1, np.nan, 2.0],
        "trial": pd.array([1, None, 3], dtype="Int64"),
        "felt": [True, False, True],
        "said": ["less", None, "more"],
        "p (Holm)": [0.5, 0.25, 1e-9],
        "empty": [None, None, None],
    }
)


def test_an_spss_file_keeps_values_types_and_labels(tmp_path):
    write_sav(TABLE, tmp_path / "a.sav")
    found, about = pyreadstat.read_sav(tmp_path / "a.sav")
    assert found["participant_id"].tolist() == ["01", "02", "é"]
    assert found["estimate_0_5"].fillna(-1).tolist() == [0.1, -1, 2]
    assert found["trial"].fillna(-1).tolist() == [1, -1, 3]
    assert found["said"].tolist() == ["less", "", "more"]
    assert found["p_Holm"].tolist() == [0.5, 0.25, 1e-9]
    assert found["empty"].isna().all()
    assert about.variable_value_labels == {"felt": {0.0: "no", 1.0: "yes"}}
    assert about.column_labels == list(TABLE.columns)
    assert {k for k, v in about.variable_measure.items() if v == "nominal"} == {
        *("participant_id", "felt", "said"),
    }


@pytest.fixture(scope="module")
def exported(dataset_of_module, tmp_path_factory):
    out = tmp_path_factory.mktemp("exported")
    write_export(analyse(dataset_of_module()), out, ["spss"])
    return out


def test_every_table_has_an_spss_file(exported):
    names = {path.stem for path in (exported / "spss").glob("*.sav")}
    assert names >= {"wide", "estimates", "table3"}
    wide = pd.read_csv(exported / "wide.csv", dtype={"participant_id": str})
    found, _ = pyreadstat.read_sav(exported / "spss" / "wide.sav")
    np.testing.assert_allclose(found["estimate_1_2"], wide["estimate_1_2"])
    assert found["participant_id"].tolist() == wide["participant_id"].tolist()


def test_jasp_and_jamovi_find_the_types_of_the_wide_table(exported):
    """Both take a column as numbers if every cell is empty or a number with a point.

    JASP reads UTF-8 with a comma, and no quotes or empty names in the header; jamovi takes a column
    as text if one cell is no number, and names such as `estimate_0_5` need no quotes in formulas.
    """
    text = (exported / "wide.csv").read_text(encoding="utf-8")
    header, *rows = csv.reader(text.splitlines())
    assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) for name in header)
    assert len(set(header)) == len(header)
    assert {len(row) for row in rows} == {len(header)}
    number = re.compile(r"-?\d+(\.\d+)?(e[+-]?\d+)?")
    for name, *cells in zip(header, *rows, strict=True):
        if name.startswith(("estimate_", "log_")):
            assert all(number.fullmatch(cell) for cell in cells if cell), name
        elif name == "participant_id":
            assert not any(number.fullmatch(cell) for cell in cells)  # no number: nominal


@pytest.mark.skipif(not shutil.which("Rscript"), reason="R is not installed")
def test_r_finds_the_types_of_the_wide_table(exported):
    code = f"cat(sapply(read.csv('{(exported / 'wide.csv').as_posix()}'), class))"
    done = subprocess.run(["Rscript", "-e", code], capture_output=True, text=True, check=True)
    first, *others = done.stdout.split()
    assert first == "character"
    assert set(others[:4]) == {"numeric"}
