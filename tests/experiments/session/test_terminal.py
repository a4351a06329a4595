"""The operator's terminal: what each key does in each state, and what the lines say."""

import io
import os
import sys

import pytest
from rich.console import Console

from slipscale.experiments.session.operator import Request, SessionStatus, UnattendedOperator
from slipscale.experiments.session.terminal import Keys, TerminalOperator
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.steps import Ask
from slipscale.experiments.steps.trial import Trial

GLISSE = "glissé"
THIRD = Trial(task="t", number=3, total=8)
FOURTH = Trial(task="t", number=4, total=8)
BEFORE = ("showing", "presenting", "waiting")


def operator(*keys, width=80, terminal=True, retries=0):
    """Return an operator who presses ``keys``, one a poll, and what their console shows."""
    shown = io.StringIO()
    console = Console(file=shown, width=width, force_terminal=terminal, color_system=None)
    presses = iter(keys)
    return TerminalOperator(console, lambda: next(presses, ""), retries=retries), shown


def asked(state, *keys, retries=0):
    """Return what is asked for when ``keys`` are pressed in a state, but for the polls between."""
    who, _ = operator(*keys, retries=retries)
    who.tell(SessionStatus(state=state, voidable=THIRD))
    return [request for _ in range(len(keys) + 1) if (request := who.poll())]


@pytest.mark.parametrize("state", BEFORE)
def test_p_pauses_a_running_session(state):
    assert asked(state, "p") == [Request(what="pause")]


def test_p_goes_on_from_a_pause():
    assert asked("paused", "p") == [Request(what="go_on")]


def test_r_retries_only_after_a_fault():
    assert asked("fault", "r") == [Request(what="retry")]
    assert [asked(state, "r") for state in (*BEFORE, "paused", "done")] == [[]] * 5


def test_the_first_fault_is_retried_by_itself():
    assert asked("fault", "", "", retries=1) == [Request(what="retry")]


def test_a_plate_that_may_still_vibrate_is_not_retried_before_the_operator_has_read_it():
    who, _ = operator("", "", "r", retries=1)
    who.tell(SessionStatus(state="fault", code="still_vibrating", message="Take the finger off"))
    assert [who.poll() for _ in range(3)] == [None, None, Request(what="retry")]
    assert "Take the finger off" in str(who.lines())


@pytest.mark.parametrize(
    "keys, expected",
    [
        ("a9\r", "expected a number from 1 to 1"),
        ("ax\r", "expected a number from 1 to 1"),
        ("v\r", "expected a reason"),
    ],
)
def test_an_enter_that_asks_for_nothing_says_what_is_expected(keys, expected):
    who, shown = operator(*keys, "1")
    question = Ask(name="age", question=NumberQuestion(prompt="?"))
    with who:
        who.tell(SessionStatus(state="waiting", voidable=THIRD, asked=(question,)))
        assert [who.poll() for _ in keys] == [None] * len(keys)
        assert expected in str(who.lines())
        assert expected in shown.getvalue()
        who.poll()
        assert expected not in str(who.lines())


@pytest.mark.parametrize("state", [*BEFORE, "paused", "fault"])
def test_s_stops_only_when_it_is_confirmed(state):
    assert asked(state, "s", "\r") == [Request(what="stop")]
    assert asked(state, "s", *"smoke", "\r") == [Request(what="stop", reason="smoke")]
    assert asked(state, "s", "y", "\x1b") == []
    assert asked(state, "s", "s") == []


@pytest.mark.parametrize("key", "psvry\x1b\r")
def test_no_key_does_anything_once_the_session_is_over(key):
    assert asked("done", key, "x", "\r", "y") == []


@pytest.mark.parametrize("state", [*BEFORE, "paused"])
def test_v_voids_with_the_reason_typed_letter_by_letter(state):
    keys = ["v", *"glx", "\x7f", *"issé", "\r"]
    assert asked(state, *keys) == [Request(what="void", reason=GLISSE, trial=THIRD)]


def test_letters_of_a_reason_are_no_commands():
    assert asked("waiting", "v", *"pvsr", "\n") == [
        Request(what="void", reason="pvsr", trial=THIRD)
    ]


def test_a_reason_is_needed_and_escape_takes_it_all_back():
    assert asked("waiting", "v", "\r", " ", "\r") == []
    assert asked("waiting", "v", *"oops", "\x1b", "p") == [Request(what="pause")]


def test_a_reason_is_limited_and_the_limit_is_shown():
    who, _ = operator("v", *"x" * 2001, "\r")
    who.tell(SessionStatus(state="waiting", voidable=THIRD))
    assert [who.poll() for _ in range(2002)] == [None] * 2002
    assert "expected 2000 characters or fewer" in who.lines().plain
    assert len(who.poll().reason) == 2000


def test_a_fault_does_not_swallow_the_reason_being_typed():
    who, _ = operator("v", "a", "b", "\r")
    who.tell(SessionStatus(state="waiting", voidable=THIRD))
    who.poll()
    who.poll()
    who.tell(SessionStatus(state="fault", message="unplugged"))
    assert "ab▏" not in who.lines().plain
    who.poll()
    assert "unplugged" in who.lines().plain
    assert "ab▏" in who.lines().plain
    assert who.poll() == Request(what="void", reason="ab", trial=THIRD)


def test_the_trial_voided_is_the_one_at_v_however_long_the_reason_takes():
    who, _ = operator("v", "a", "\r")
    who.tell(SessionStatus(state="waiting", trial=3, voidable=THIRD))
    who.poll()
    assert who.busy
    who.tell(SessionStatus(state="waiting", trial=4, voidable=FOURTH))
    assert "reason for voiding trial 3" in who.lines().plain
    who.poll()
    assert who.poll() == Request(what="void", reason="a", trial=THIRD)
    assert not who.busy


def test_where_nothing_can_be_voided_no_reason_is_asked_for():
    who, _ = operator("v", "p")
    who.tell(SessionStatus(state="showing"))
    assert who.poll() == Request(what="void")
    assert who.poll() == Request(what="pause")


def test_b_voids_the_trial_before_the_one_in_progress():
    who, _ = operator("b", "a", "\r")
    who.tell(SessionStatus(state="presenting", voidable=FOURTH, answered=THIRD))
    who.poll()
    assert "reason for voiding trial 3" in who.lines().plain
    who.poll()
    assert who.poll() == Request(what="void", reason="a", trial=THIRD)
    assert asked("waiting", "b", "x", "\r") == []  # there is none before


QUESTIONS = tuple(
    Ask(name=name, question=NumberQuestion(prompt="?")) for name in ("age_years", "scale_top")
)


@pytest.mark.parametrize("typed, question", [("1", QUESTIONS[0]), ("2", QUESTIONS[1])])
def test_a_asks_a_question_of_the_run_again_by_its_number(typed, question):
    who, _ = operator("a", "3", "\r", "\x7f", typed, "\r")
    who.tell(SessionStatus(state="waiting", asked=QUESTIONS))
    requests = [who.poll() for _ in range(6)]
    assert requests[:5] == [None] * 5  # there is no third
    assert requests[5] == Request(what="ask_again", question=question)


def test_the_questions_that_can_be_asked_again_are_listed():
    who, _ = operator("a")
    who.tell(SessionStatus(state="waiting", asked=QUESTIONS))
    who.poll()
    assert "1 age_years, 2 scale_top" in who.lines().plain


SAID = Ask(name="estimate", question=NumberQuestion(prompt="How slippery?"), by="operator")
ASKING = SessionStatus(state="waiting", voidable=THIRD, answering=SAID)


def test_what_the_participant_says_is_typed_and_enter_hands_it_in():
    who, _ = operator(*"12.5", "\r", "7", "\r")
    who.tell(ASKING)
    assert "How slippery? (Enter to submit" in str(who.lines())
    requests = [request for _ in range(8) if (request := who.poll())]
    assert requests == [Request(what="answer", reason="12.5"), Request(what="answer", reason="7")]
    who.tell(SessionStatus(state="waiting"))
    assert "How slippery?" not in str(who.lines())
    assert not who.busy


def test_escape_leaves_the_answer_for_the_other_keys_and_n_comes_back_to_it():
    who, _ = operator("1", "\x1b", "p", "n", "3", "\r")
    who.tell(ASKING)
    requests = [request for _ in range(7) if (request := who.poll())]
    assert requests == [Request(what="pause"), Request(what="answer", reason="3")]


def test_a_reason_being_typed_is_not_taken_away_by_a_question():
    who, _ = operator("v", "x", "\r", "n", "4", "\r")
    who.tell(SessionStatus(state="waiting", voidable=THIRD))
    who.poll()
    who.tell(ASKING)
    requests = [request for _ in range(6) if (request := who.poll())]
    assert [request.what for request in requests] == ["void", "answer"]


def test_an_empty_answer_is_none():
    who, _ = operator("\r", " ", "\r")
    who.tell(ASKING)
    assert [who.poll() for _ in range(4)] == [None] * 4


def test_a_fault_rings_the_bell_once_and_only_in_a_terminal():
    for terminal, rings in ((True, 1), (False, 0)):
        who, shown = operator(terminal=terminal)
        with who:
            who.tell(SessionStatus(state="waiting"))
            assert "\a" not in shown.getvalue()
            who.tell(SessionStatus(state="fault"))
            who.tell(SessionStatus(state="fault", message="still"))
        assert shown.getvalue().count("\a") == rings


def test_the_lines_tell_noise_plate_and_time_without_an_amplitude():
    who, _ = operator()
    who.tell(SessionStatus(state="waiting", noise="playing", plate="as commanded", elapsed_s=65.0))
    for said in ("noise playing", "plate as commanded", "elapsed 1:05"):
        assert said in who.lines().plain


def test_the_lines_tell_what_goes_on_and_what_the_keys_do():
    who, _ = operator()
    who.tell(
        SessionStatus(
            state="waiting", task="magnitudeestimation", trial=3, total=8, done=2, planned=12,
            time_left_s=125.0, faults=1, voided=2, message="trial 2 will be repeated",
        )
    )  # fmt: skip
    said = who.lines().plain
    for words in ("waiting", "trial 3 of 8", "session 2 of 12", "left 2:05", "faults 1", "voided 2",
                  "trial 2 will be repeated", "p pause"):  # fmt: skip
        assert words in said
    assert "µm" not in said
    who.tell(SessionStatus(state="waiting", level="2.3 µm p-p"))
    assert "2.3 µm p-p" in who.lines().plain
    who.tell(SessionStatus(state="done"))
    assert "pause" not in who.lines().plain


def test_no_line_breaks_in_a_terminal_of_the_usual_width():
    who, _ = operator()
    who.tell(
        SessionStatus(
            state="presenting", task="magnitudeestimation", trial=30, total=128, done=122,
            planned=212, time_left_s=7384.0, faults=10, voided=12, level="1.2345 µm p-p",
        )
    )  # fmt: skip
    assert max(len(line) for line in who.lines().plain.splitlines()) <= 80


def test_without_a_terminal_nothing_is_written_but_the_end():
    who, shown = operator(terminal=False)
    with who:
        for number in range(50):
            who.tell(SessionStatus(state="waiting", trial=number))
        assert shown.getvalue() == ""
        who.tell(SessionStatus(state="done"))
    assert "done" in shown.getvalue()
    assert shown.getvalue().endswith("\n")
    assert "\x1b" not in shown.getvalue()


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are Unix'")
def test_keys_that_come_together_are_read_one_by_one_and_none_is_lost():
    master, slave = os.openpty()
    with os.fdopen(slave, "r") as terminal, Keys(terminal) as keys:
        os.write(master, "vé\x1b[Aq".encode())
        os.write(master, "œ".encode()[:1])
        first = [keys() for _ in range(6)]
        os.write(master, "œ".encode()[1:] + b"\r")
        rest = [keys() for _ in range(3)]
    os.close(master)
    assert first == ["v", "é", "\x1b[A", "q", "", ""]
    assert rest[0] == "œ"
    assert rest[1] in ("\r", "\n")
    assert rest[2] == ""


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are Unix'")
def test_the_first_key_after_a_pasted_text_is_not_waited_for():
    master, slave = os.openpty()
    with os.fdopen(slave, "r") as terminal, Keys(terminal) as keys:
        for _ in range(25):
            os.write(master, b"x" * 1000)
            keys()
        os.write(master, b"p")
        assert "p" in [keys() for _ in range(2100)]
    os.close(master)


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are Unix'")
def test_the_terminal_is_left_as_it_was():
    import termios

    master, slave = os.openpty()
    with os.fdopen(slave, "r") as terminal:
        before = termios.tcgetattr(slave)
        with Keys(terminal):
            assert termios.tcgetattr(slave) != before
        assert termios.tcgetattr(slave) == before
    os.close(master)


def test_a_program_without_an_input_reads_no_keys(monkeypatch):
    monkeypatch.setattr(sys, "stdin", None)
    with Keys() as keys:
        assert keys() == ""
    with Keys(io.StringIO("p")) as keys:
        assert keys() == ""


def test_what_a_board_or_a_study_says_does_not_move_the_terminals_cursor():
    who, shown = operator("a")
    who.tell(SessionStatus(state="fault", message="lost\x1b[2J\x9b31m\u202e"))
    question = Ask(name="age\x1b[2J", question=NumberQuestion(prompt="?"))
    who.tell(SessionStatus(state="waiting", asked=(question,), message="lost\x1b[2J"))
    who.poll()
    assert "lost\\x1b[2J" in who.lines().plain
    assert "age\\x1b[2J" in who.lines().plain
    assert not set("\x1b\x9b\u202e") & set(who.lines().plain)
    assert "\x1b[2J" not in shown.getvalue()


def test_the_plates_temperature_is_told_where_it_is_known():
    who, _ = operator()
    who.tell(SessionStatus(state="waiting", plate="as commanded", temperature_c=23.46))
    assert "plate as commanded  23.5 °C" in who.lines().plain
    who.tell(SessionStatus(state="waiting", plate="as commanded"))
    assert "°C" not in who.lines().plain


def test_a_session_tells_the_operator_the_temperature_that_the_plate_reads(laboratory):
    class Noting(UnattendedOperator):
        def tell(self, status):
            super().tell(status)
            told.append(status.temperature_c)

    told = []
    laboratory.run(operator=Noting())
    assert told[0] is None  # nothing was read yet
    assert 15 < told[-1] < 35
