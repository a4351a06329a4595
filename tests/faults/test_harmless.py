import pytest

import slipscale
from faults import harmless


@pytest.mark.parametrize("text", ["\x1b[2J", "\x07", "\x9b31m", "\u202e", "\r", "\x00"])
def test_what_a_terminal_would_obey_is_shown(text):
    assert not any(each in harmless(f"a{text}b") for each in "\x1b\x07\x9b\u202e\r\x00")
    assert harmless(f"a{text}b").startswith("a\\")


def test_words_lines_and_units_stay_as_they_are():
    assert harmless("1.2 µm – « collé »\n\tline") == "1.2 µm – « collé »\n\tline"


def test_a_message_quotes_a_study_without_obeying_it(tmp_path, capsys):
    study = tmp_path / "\x1b[2Jstudy.toml"
    assert slipscale.main(["study", "validate", str(study)]) == 2
    assert "\\x1b[2J" in capsys.readouterr().err
