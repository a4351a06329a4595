"""A table is described: columns, options that apply, and their consequence."""

import json

import pytest

from slipscale.analysis.cli.describing import describe
from slipscale.commands import main
from slipscale.faults import UserError

ROWS = [f"{who},{level},{int(level > 1)}" for who in "abc" for level in (1, 2, 4) * 2]


@pytest.fixture
def table(tmp_path):
    path = tmp_path / "x.csv"
    path.write_text("\n".join(["who,size:mm,correct", *ROWS]))
    return path


def test_a_proposal_without_questions_has_a_consequence(table):
    table.write_text(table.read_text().replace("size:mm", "size"))
    found = describe([table], {}).as_json()
    assert found["amounts"] == {"answers": 18, "people": 3, "levels": 3}
    assert found["roles"] == {"participant": "who", "stimulus": "size", "answer": "correct"}
    assert found["columns"][1]["head"] == ["1", "2", "4", "1", "2"]
    assert (found["open"], found["fault"], found["rows"]) == ([], "", 18)


def test_given_options_replace_the_proposal_and_a_column_may_contain_a_colon(table):
    given = {"participant": "who", "stimulus": "size:mm:", "answer": "correct", "alternatives": 2}
    found = describe([table], given).as_json()
    assert found["amounts"] == {"answers": 18, "people": 3, "levels": 3}
    assert (found["roles"]["stimulus"], found["unit"]) == ("size:mm", "")
    assert found["alternatives"] == 2
    assert "--alternatives 2" in found["command"]


def test_what_a_table_does_not_reveal_has_no_consequence(tmp_path):
    path = tmp_path / "x.csv"
    path.write_text("a,b,c\n" + "".join(f"{n % 3},{n % 4},{n % 5}\n" for n in range(60)))
    found = describe([path], {}).as_json()
    assert found["open"] == ["stimulus", "results"]
    assert found["candidates"]["stimulus"] == ["a", "b", "c"]
    assert (found["roles"], found["amounts"]) == ({}, None)


def test_the_exit_status_says_whether_the_options_fit(table, capsys, tmp_path):
    out = tmp_path / "out"
    options = ("--participant", "who", "--response", "correct", "--out", str(out))
    assert main(["analyse", str(table), "--describe", *options]) == 1
    assert "--stimulus" in json.loads((out / "description.json").read_text())["fault"]
    assert "who: text, 3 values (a, b, c)" in capsys.readouterr().out
    assert (
        main(["analyse", str(table), "--describe", "--json", *options, "--stimulus", "size:mm:"])
        == 0
    )
    assert json.loads(capsys.readouterr().out)["amounts"]["answers"] == 18


def test_a_folder_without_tables_cannot_be_described(tmp_path):
    with pytest.raises(UserError, match="no table found; expected a table"):
        describe([tmp_path], {})
