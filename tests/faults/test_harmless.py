import pytest

from slipscale import commands
from slipscale.faults import harmless


@pytest.mark.parametrize("text", ["\x1b[2J", "\x07", "\x9b31m", "\u202e", "\r", "\x00"])
def test_what_a_terminal_would_obey_is_shown(text):
    assert not any(each in harmless(f"a{text}b") for each in "\x1b\x07\x9b\u202e\r\x00")
    assert harmless(f"a{text}b").startswith("a\\")


def test_words_lines_and_units_stay_as_they_are():
    assert harmless("1.2 µm – « collé »\n\tline") == "1.2 µm – « collé »\n\tline"


def test_a_message_quotes_a_study_without_obeying_it(tmp_path, capsys):
    study = tmp_path / "\x1b[2Jstudy.toml"
    assert commands.main(["study", "validate", str(study)]) == 2
    assert "\\x1b[2J" in capsys.readouterr().err


def test_a_study_is_shown_and_judged_without_being_obeyed(tmp_path, capsys):
    study = tmp_path / "study.toml"
    text = (
        'name = "mine"\ntitle = "\\u001b[2JMine"\namplitudes_um_pp = [0.0, 1.2]\n'
        '[[tasks]]\nprotocol = "magnitude_estimation"\n'
    )
    study.write_text(text, encoding="utf-8")
    assert commands.main(["study", "show", str(study)]) == 0
    shown = capsys.readouterr().out
    assert "\\x1b[2JMine" in shown
    assert "\x1b" not in shown


@pytest.mark.parametrize("unit", ["[/red]", "[bold]m"])
def test_a_table_is_analysed_without_its_words_being_obeyed(tmp_path, capsys, unit):
    table = tmp_path / "t.csv"
    table.write_text("who,level,estimate\na,1,2\na,2,3\nb,1,2\nb,2,5\nb,2,\x1b[2J\n")
    words = ["--participant", "who", "--stimulus", f"level:{unit}", "--response", "estimate"]
    assert commands.main(["analyse", str(table), *words, "--out", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr()
    assert harmless(unit) in shown.out
    assert "'\\x1b[2J' instead of a number" in shown.err
    assert "\x1b" not in shown.out + shown.err


def test_a_unit_that_cannot_be_printed_is_refused(tmp_path, capsys):
    table = tmp_path / "t.csv"
    table.write_text("who,level,estimate\na,1,2\n")
    words = ["--participant", "who", "--stimulus", "level:\x1b[31mm", "--response", "estimate"]
    assert commands.main(["analyse", str(table), *words]) == 2
    assert "stimulus.unit: expected printable characters" in capsys.readouterr().err
