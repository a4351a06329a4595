import json

import pytest

from slipscale import commands
from slipscale.experiments.dataset.bids import build_dataset


@pytest.fixture
def dataset(laboratory):
    laboratory.run()
    build_dataset(laboratory.folder)
    return laboratory.folder


def test_verify_says_that_all_agrees(dataset, capsys):
    assert commands.main(["data", "verify", str(dataset)]) == 0
    assert capsys.readouterr().out == f"{dataset}: agrees with its journals (1)\n"


def test_verify_exits_1_and_names_each_difference_until_build_has_made_it_anew(dataset, capsys):
    table = next(dataset.glob("sub-01/beh/*magnitude*_beh.tsv"))
    table.write_text(table.read_text().replace("\tmain\t", "\tpractice\t", 1))
    assert commands.main(["data", "verify", str(dataset)]) == 1
    said = capsys.readouterr().err
    assert "phase is 'practice'; the journal has 'main'" in said
    assert f"to write the tables again from the journals: slipscale data build {dataset}" in said
    assert commands.main(["data", "verify", "--json", str(dataset)]) == 1
    (problem,) = json.loads(capsys.readouterr().out)
    assert problem["place"].startswith("row ")
    assert commands.main(["data", "build", str(dataset)]) == 0
    assert commands.main(["data", "verify", str(dataset)]) == 0


def test_a_folder_without_journals_is_named(tmp_path, capsys):
    assert commands.main(["data", "verify", str(tmp_path)]) == 2
    assert "no journals; expected a data set folder" in capsys.readouterr().err
