"""Check the rules for lines, frames, repetitions and the stop byte."""

from __future__ import annotations

from collections.abc import Callable

from slipscale.faults.message import Message
from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.conformance.bench import Bench, differs

IDENTITY_FIELDS = 4
ENDINGS = (b"\r\n", b"\r\r\n")
NOT_SEQUENCES = ("0", "00", "007", "+7", "-7", "65536", "99999", "100000", "", "x")


def _plain_identity(bench: Bench) -> None:
    framed = bench.ask("*IDN?")
    fields = framed.split(",")
    if len(fields) != IDENTITY_FIELDS or fields[1] != wire.PROTOCOL:
        differs(
            Message("four fields, of which the second is {protocol}", protocol=wire.PROTOCOL),
            f"'{framed}'",
        )
    lines = bench.answers_to(b"*IDN?\n", at_most=1) + bench.answers_to(b"")
    if lines != [framed.encode("ascii") + b"\r"]:
        differs(
            "one answer to unframed *IDN?: the same identity as in the framed answer, followed by "
            "CR LF",
            repr(lines),
        )


def _one_answer(bench: Bench) -> None:
    lines = bench.answers_to(bench.frame("STAT?"), at_most=1) + bench.answers_to(b"")
    if len(lines) != 1:
        differs("one answer to a correct frame", str(len(lines)))


def _answers_fit_their_line(bench: Bench) -> None:
    for body in ("*IDN?", "LIM?", "STAT?"):
        lines = bench.answers_to(bench.frame(body, wire.LAST_SEQUENCE), at_most=1)
        lengths = [len(line) for line in lines]
        if not lines or not 0 < min(lengths) <= max(lengths) <= wire.LONGEST_LINE:
            got = ", ".join(map(str, lengths)) or "none"
            differs(
                Message(
                    "an answer to {body} of at most {longest_line} bytes",
                    body=body,
                    longest_line=wire.LONGEST_LINE,
                ),
                got,
            )


def _wrong_checksum(bench: Bench) -> None:
    frame = bench.frame("STAT?")
    star = frame.index(b"*")
    for wrong in (b"0000", b"FFFF", frame[star + 1 : -1][::-1] + b"0", b""):
        bench.expect_silence(frame[: star + 1] + wrong + b"\n", "a wrong checksum")
    lower = next(
        each
        for each in (bench.frame("STAT?") for _ in range(wire.LAST_SEQUENCE))
        if any(byte in b"ABCDEF" for byte in each[-5:-1])
    )
    bench.expect_silence(lower[:-5] + lower[-5:].lower(), "a checksum in lower case")


def _noise_before(bench: Bench) -> None:
    for noise in (b"#7 \x00\xff", b">7 STAT?", b"*IDN?"):
        bench.reply_to(noise + bench.frame("STAT?"), "a frame after noise")


def _tail(bench: Bench) -> None:
    for tail in (b" ", b"x", b"\x00", b"*0000"):
        frame = bench.frame("STAT?")[:-1]
        bench.expect_silence(frame + tail + b"\n", "a frame with trailing bytes")


def _line_ends(bench: Bench) -> None:
    for ending in ENDINGS:
        bench.reply_to(bench.frame("STAT?")[:-1] + ending, "a frame with CR before LF")


def _sequence_numbers(bench: Bench) -> None:
    for text in NOT_SEQUENCES:
        payload = f"{text} STAT?".encode("ascii")
        frame = b">%b*%04X\n" % (payload, wire.crc16(payload))
        bench.expect_silence(frame, f"SEQ '{text}'")
    for sequence in (1, 9, 10, wire.LAST_SEQUENCE):
        reply = bench.reply_to(bench.frame("STAT?", sequence))
        if reply.sequence != sequence:
            differs(f"SEQ {sequence}", str(reply.sequence))


def _bodies(bench: Bench) -> None:
    for body in (b"ST\x01AT?", b"STAT?\x00", b"STAT\xff", b"ST<AT?", b"STAT\t?", b""):
        payload = b"7 " + body
        frame = b">%b*%04X\n" % (payload, wire.crc16(payload))
        bench.expect_silence(
            frame, "a body that is empty or contains '<' or a non-printable character"
        )


def _longest_line(bench: Bench) -> None:
    def padded(length: int, ending: bytes = b"") -> bytes:
        frame = bench.frame("STAT?")[:-1] + ending
        return b"#" * (length - len(frame)) + frame + b"\n"

    longest = wire.LONGEST_LINE
    bench.reply_to(padded(longest), f"a line of {longest} bytes")
    for line in (
        padded(longest + 1),
        padded(longest + 1, b"\r"),
        padded(longest)[:-1] + b"x\n",
        padded(longest)[:-1] + b"x" * 200 + b"\n",
    ):
        bench.expect_silence(line, f"a line of {len(line) - 1} bytes")
    bench.reply_to(bench.frame("STAT?"), "the frame after an overlong line")


def _boot(bench: Bench) -> None:
    boots = {bench.run(body).boot for body in ("STAT?", "FOO", "LIM?", "STAT?")}
    if len(boots) != 1:
        differs("the same BOOT in every answer", ", ".join(sorted(boots)))


def _repetition(bench: Bench) -> None:
    _two_errors(bench)
    frame = bench.frame("SYST:ERR?")
    _expect_same(bench, frame, b"")
    _expect_left(bench, f'{wire.OUT_OF_RANGE},"{wire.MEANINGS[wire.OUT_OF_RANGE]}"')


def _repetition_after_other_lines(bench: Bench) -> None:
    for between, answers in ((b"noise\n>7 STAT?*0000\n", 0), (b"*IDN?\n", 1), (b"x" * 200, 0)):
        _two_errors(bench)
        frame = bench.frame("SYST:ERR?")
        first = bench.answers_to(frame, at_most=1)
        got = len(bench.answers_to(between, at_most=answers or None))
        if got != answers:
            differs(
                Message(
                    "{answers} answers to {between}", answers=answers, between=repr(between[:SHORT])
                ),
                str(got),
            )
        if between.endswith(b"x"):
            bench.expect_silence(b"\n", "a line of 200 bytes")
        again = bench.answers_to(frame, at_most=1)
        if again != first:
            differs(
                Message(
                    "the same answer {first} when the frame is repeated after {between}",
                    first=first,
                    between=repr(between[:SHORT]),
                ),
                repr(again),
            )


def _same_sequence_other_body(bench: Bench) -> None:
    _two_errors(bench)
    frame = bench.frame("SYST:ERR?")
    bench.reply_to(frame)
    sequence = int(frame[1:].split()[0])
    reply = bench.reply_to(
        bench.frame("OUTP ON", sequence), "a frame with the same SEQ but a different body"
    )
    if reply.code != wire.OUT_OF_RANGE:
        differs(
            "execution of the frame with the same SEQ but a different body", f"code {reply.code}"
        )


def _stop_is_not_answered(bench: Bench) -> None:
    bench.expect_silence(wire.STOP, "!")


def _stop_silences(bench: Bench) -> None:
    bench.settle(bench.some_level)
    bench.send(wire.STOP)
    bench.expect_state("OFF")


def _stop_inside_a_frame(bench: Bench) -> None:
    bench.settle(bench.some_level)
    frame = bench.frame(f"AMPL {bench.some_level / 2:.4f}")
    for place in range(1, len(frame)):
        bench.send(frame[:place] + wire.STOP + frame[place:])
    bench.expect_state("OFF")
    bench.wait(0.2)
    bench.expect_state("OFF")


def _frame_after_stop(bench: Bench) -> None:
    for before in (b"", b">7 AM", b"x" * 200):
        bench.reply_to(before + wire.STOP + bench.frame("STAT?"), "a frame directly after !")


def _repetition_after_stop(bench: Bench) -> None:
    frame = bench.frame(f"AMPL {bench.some_level:.4f}")
    _expect_same(bench, frame, wire.STOP)
    bench.expect_state("OFF")


def _two_errors(bench: Bench) -> None:
    bench.ask("*RST")
    bench.expect_code("FOO", wire.UNDEFINED_HEADER)
    bench.expect_code("OUTP ON", wire.OUT_OF_RANGE)


def _expect_same(bench: Bench, frame: bytes, between: bytes) -> None:
    first = bench.answers_to(frame, at_most=1)
    bench.send(between)
    for _ in range(2):
        again = bench.answers_to(frame, at_most=1)
        if again != first:
            differs(
                Message("the same answer {first} when the frame is repeated", first=first),
                repr(again),
            )


def _expect_left(bench: Bench, error: str) -> None:
    left = bench.ask("SYST:ERR?")
    if left != error:
        differs(
            Message(
                "{error} as the next error, because a repeated command is executed only once",
                error=error,
            ),
            left,
        )


SHORT = 20

RULES: tuple[tuple[str, Callable[[Bench], None]], ...] = (
    ("unframed *IDN? is answered with the identity and CR LF", _plain_identity),
    ("a correct frame gets one answer", _one_answer),
    ("the board's answers do not exceed the maximum line length", _answers_fit_their_line),
    ("a frame with a wrong checksum gets no answer", _wrong_checksum),
    ("noise before a frame is ignored", _noise_before),
    ("a frame with trailing bytes gets no answer", _tail),
    ("carriage returns before the line feed are ignored", _line_ends),
    ("SEQ is 1 to 65535 without sign or leading zero", _sequence_numbers),
    ("a body contains at least one character, no < and no non-printable characters", _bodies),
    ("lines have at most 96 bytes", _longest_line),
    ("BOOT stays the same while the board runs", _boot),
    ("a repeated frame gets the same answer and is not executed again", _repetition),
    (
        "a repeated frame is recognised after invalid frames and unframed *IDN?",
        _repetition_after_other_lines,
    ),
    ("a frame with the same SEQ but a different body is a new command", _same_sequence_other_body),
    ("the stop byte ! is not answered", _stop_is_not_answered),
    ("the stop byte ! silences the plate", _stop_silences),
    ("a frame that contains the stop byte ! is not executed", _stop_inside_a_frame),
    ("a frame that directly follows the stop byte ! is executed", _frame_after_stop),
    ("a repeated frame does not undo an earlier stop byte !", _repetition_after_stop),
)
