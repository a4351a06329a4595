"""The campaign of texts, in short: docs/validation/measured/campaigns.md has its figures."""

import json
import sys
import time
from itertools import count
from random import Random

import pytest

from slipscale.faults import UserError
from tools.fuzzing import __main__ as fuzzing
from tools.fuzzing import bounds, campaign, changes
from tools.fuzzing.kind import Case, Kind

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="limits of POSIX")
TEXTS = 40


@pytest.mark.parametrize("name", campaign.KINDS)
def test_texts_of_any_content_are_used_or_refused_in_a_sentence(name):
    outcome = campaign.tried(name, range(TEXTS))
    assert outcome.finds == []
    # Neither broken beyond all reading nor untouched.
    assert 0.05 < outcome.used / outcome.tried < 0.95


@pytest.fixture
def kind(monkeypatch):
    """Put a kind in the place of all, whose texts do what a test says."""

    def put(use):
        made = Kind(
            title="texts of a test",
            prepared=lambda _: (
                lambda random: Case(name="text", content=bytes([random.randrange(256)]), use=use)
            ),
        )
        monkeypatch.setattr(campaign, "kind_of", lambda _: made)
        monkeypatch.setattr(fuzzing, "kind_of", lambda _: made)

    return put


def test_an_error_is_kept_with_its_place_and_its_text(kind):
    numbers = count()

    def use():
        if next(numbers) == 3:
            raise KeyError("lost")
        return True

    kind(use)
    outcome = campaign.tried("any", range(10))
    assert (outcome.tried, outcome.used) == (10, 9)
    (find,) = outcome.finds
    assert (find.kind, find.number) == ("any", 3)
    assert (
        find.what == f"KeyError at test_fuzzing.py:{use.__code__.co_firstlineno + 2} in use: 'lost'"
    )


def test_a_text_that_takes_too_long_is_broken_off_and_kept(kind, monkeypatch):
    monkeypatch.setattr(bounds, "MOST_S", 0.05)

    def use():
        try:
            while True:
                time.process_time()
        except Exception:  # noqa: BLE001 - what hides errors does not hide this
            return True

    kind(use)
    assert [find.number for find in campaign.tried("any", [7]).finds] == [7]


def test_what_no_signal_ends_is_kept_as_well(kind, monkeypatch):
    monkeypatch.setattr(bounds, "_too_long", lambda *_: None)
    monkeypatch.setattr(bounds, "MOST_S", 0.01)

    def use():
        began_s = time.process_time()
        while time.process_time() - began_s < 0.02:
            pass
        return True

    kind(use)
    assert len(campaign.tried("any", [1]).finds) == 1


def test_a_text_that_takes_too_much_memory_is_kept(kind):
    kept = []

    def use():
        kept.append(bytes(bounds.MOST_BYTES // 50))  # as a cache that grows
        return True

    kind(use)
    finds = campaign.tried("any", range(120)).finds
    assert finds
    assert finds[0].what.startswith("MemoryError")


def test_the_same_number_is_the_same_text_in_every_process():
    text = "a = 1\nb = 2.5\n" * 3
    made = [changes.changed_file(Random(f"any {number}"), text) for number in range(200)]
    assert made == [changes.changed_file(Random(f"any {number}"), text) for number in range(200)]
    assert len(set(made)) > 150


def test_the_campaign_goes_on_where_it_was_and_tries_its_finds_again(tmp_path, monkeypatch, capsys):
    asked = []

    def chunk(name, numbers):
        asked.append((name, list(numbers)))
        bad = [fuzzing.Find(kind=name, number=n, what="E at x: y") for n in numbers if n == 3]
        return fuzzing.Outcome(tried=len(numbers), used=1, finds=bad)

    monkeypatch.setattr(fuzzing, "STATE", tmp_path / "build" / "fuzz.json")
    monkeypatch.setattr(fuzzing, "chunk", chunk)
    words = ["--kind", "journals", "--processes", "1"]
    assert fuzzing.main([*words, "--texts", "5"]) == 1
    assert "1 × E at x: y; python -m tools.fuzzing --show journals 3" in capsys.readouterr().err
    assert fuzzing.main([*words, "--texts", "8"]) == 1
    assert asked == [("journals", [0, 1, 2, 3, 4]), ("journals", [3]), ("journals", [5, 6, 7])]
    assert json.loads(fuzzing.STATE.read_text())["journals"]["tried"] == 8
    assert "| journals | 8 | 2 |" in capsys.readouterr().out


def test_a_process_of_the_campaign_tells_what_it_found(tmp_path):
    outcome = fuzzing.chunk("laboratory_files", range(3))
    assert (outcome.tried, outcome.finds) == (3, [])


def test_a_text_that_ends_the_process_is_a_find(monkeypatch):
    """The count of texts that had begun is what the process left behind."""

    def ended(_, **given):
        place = fuzzing.Path(_[-1])
        place.write_bytes((2).to_bytes(fuzzing.WIDTH))
        return type("Done", (), {"returncode": -9, "stdout": "", "stderr": ""})

    monkeypatch.setattr(fuzzing.subprocess, "run", ended)
    outcome = fuzzing.chunk("journals", range(100, 110))
    assert (outcome.tried, outcome.finds[0].number) == (2, 101)
    assert outcome.finds[0].what == "ended the process with signal 9"


def test_a_text_can_be_shown_and_used(capsys):
    assert fuzzing.main(["--show", "laboratory_files", "1"]) == 0
    assert capsys.readouterr().out.startswith("slipscale.toml\nb")


def test_a_refusal_without_words_is_no_sentence(kind):
    def use():
        raise UserError("")

    kind(use)
    assert campaign.tried("any", [1]).finds
