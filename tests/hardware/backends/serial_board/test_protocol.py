import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.hardware.backends.serial_board.protocol import (
    LAST_SEQUENCE,
    LONGEST_LINE,
    BoardLimits,
    BoardReply,
    BoardStatus,
    ImpossibleValue,
    ListLimits,
    command_frame,
    crc16,
    format_limits,
    format_list_limits,
    format_status,
    list_commands,
    parse_command,
    parse_limits,
    parse_list_limits,
    parse_reply,
    parse_status,
    reply_frame,
)
from slipscale.stimuli.modulation import STEPS_MAX, Loop

BODIES = st.text(
    st.characters(min_codepoint=32, max_codepoint=126, exclude_characters="<>!"),
    min_size=1,
    max_size=60,
)
SEQUENCES = st.integers(1, 65_535)
BOOTS = st.integers(0, 2**32 - 1).map("{:08X}".format)
REPLIES = st.builds(BoardReply, SEQUENCES, BOOTS, st.integers(-999, 999), BODIES)


def crc_bit_by_bit(data):
    """Independent: CRC-16/CCITT-FALSE from its definition."""
    register = 0xFFFF
    for byte in data:
        register ^= byte << 8
        for _ in range(8):
            register = (register << 1) ^ (0x1021 if register & 0x8000 else 0)
            register &= 0xFFFF
    return register


@given(st.binary(max_size=80))
def test_the_checksum_is_the_one_of_the_definition(data):
    assert crc16(data) == crc_bit_by_bit(data)


@given(SEQUENCES, BODIES)
def test_a_command_arrives_as_it_was_sent(sequence, body):
    assert parse_command(command_frame(sequence, body)[:-1]) == (sequence, body)


@given(REPLIES)
def test_a_reply_arrives_as_it_was_sent(reply):
    assert parse_reply(reply_frame(reply)[:-1]) == reply


@given(REPLIES, st.data())
def test_no_single_changed_byte_is_ever_taken_for_a_reply(reply, data):
    frame = bytearray(reply_frame(reply)[:-1])
    at = data.draw(st.integers(0, len(frame) - 1))
    frame[at] ^= data.draw(st.integers(1, 255))
    assert parse_reply(bytes(frame)) is None


@given(REPLIES, st.binary(max_size=40).filter(lambda noise: b"\n" not in noise))
def test_noise_before_a_reply_does_not_hide_it(reply, noise):
    assert parse_reply(noise + reply_frame(reply)[:-1]) == reply


@given(REPLIES, st.data())
def test_a_truncated_reply_is_no_reply(reply, data):
    frame = reply_frame(reply)[:-1]
    assert parse_reply(frame[: data.draw(st.integers(0, len(frame) - 1))]) is None


@given(st.binary(max_size=120))
def test_no_bytes_whatever_break_the_parsers(data):
    parse_reply(data)
    parse_command(data)


def test_status_and_limits_survive_the_wire():
    status = BoardStatus(
        state="HOLD",
        target_level=2.3,
        level=2.2987,
        frequency_hz=30_499.6,
        voltage_v=14.981,
        temperature_c=24.1,
    )
    assert parse_status(format_status(status)) == status
    assert parse_limits(format_limits(BoardLimits())) == BoardLimits()


@pytest.mark.parametrize("value", ["", "HOLD", "HOLD,1,2,3,4", "HOLD,1,2,3,4,warm", "a,b,c,d,e,f"])
def test_a_value_that_is_no_status_is_refused(value):
    with pytest.raises(ValueError, match=r"unpack|float"):
        parse_status(value)


def test_the_limits_of_lists_survive_the_wire():
    limits = ListLimits(points=80, step_ms=3.5, edge_ms=1.25)
    assert parse_list_limits(format_list_limits(limits)) == limits


@pytest.mark.parametrize("value", ["", "64", "64,4", "64,4,2,1", "many,4,2", "64,0,2", "64,4,nan"])
def test_a_value_that_tells_no_limits_of_lists_is_refused(value):
    with pytest.raises(ValueError, match=r"unpack|int\(\)|but must be above 0|is not a number"):
        parse_list_limits(value)


@given(
    st.lists(st.floats(0, 99.9), min_size=2, max_size=STEPS_MAX),
    st.floats(0.004, 600),
    st.floats(0.01, 1),
)
def test_every_list_fits_into_its_lines_and_arrives_whole(amplitudes, step_s, part):
    loop = Loop(levels=tuple(amplitudes), step_s=step_s, edge_s=part * step_s, mean_level=1.0)
    *lines, play = list_commands(loop)
    assert all(len(command_frame(LAST_SEQUENCE, body)) <= LONGEST_LINE for body in (*lines, play))
    arrived = []
    for line in lines:
        first, *points = line.removeprefix("LIST:AMPL ").split(",")
        assert int(first) == len(arrived) + 1
        arrived += map(float, points)
    assert arrived == pytest.approx(amplitudes, abs=5.1e-5)
    count, step_ms, edge_ms = play.removeprefix("LIST:PLAY ").split(",")
    assert int(count) == len(amplitudes)
    assert float(step_ms) == pytest.approx(1000 * step_s, abs=5.1e-4)
    assert float(edge_ms) <= float(step_ms)


@pytest.mark.parametrize(
    "value, what",
    [
        ("0.0000,16.500,25000.0,40000.0,500,600", "largest amplitude is 0"),
        ("-2.5,16.500,25000.0,40000.0,500,600", "largest amplitude is -2.5"),
        ("2.5,0,25000.0,40000.0,500,600", "largest voltage is 0"),
        ("2.5,16.5,0,40000.0,500,600", "band is 0 to 40000"),
        ("2.5,16.5,40000.0,25000.0,500,600", "band is 40000 to 25000"),
        ("2.5,16.5,25000.0,40000.0,0,600", "watchdog time is 0 ms, but must be 400 to 2000"),
        ("2.5,16.5,25000.0,40000.0,50,600", "watchdog time is 50 ms"),
        ("2.5,16.5,25000.0,40000.0,60000,600", "watchdog time is 60000 ms"),
        ("2.5,16.5,25000.0,40000.0,500,0", "longest on-time is 0 s"),
    ],
)
def test_limits_that_no_board_may_have_are_told(value, what):
    with pytest.raises(ImpossibleValue, match=re.escape(what)):
        parse_limits(value)


def test_an_on_time_of_one_second_is_the_shortest_that_a_board_may_have():
    assert parse_limits("2.5,16.5,25000.0,40000.0,500,1").on_time_s == 1


@pytest.mark.parametrize("value", ["64,0,2", "64,4,-1", "1,4,2", "-64,4,2"])
def test_limits_of_lists_that_no_board_may_have_are_told(value):
    with pytest.raises(ImpossibleValue, match="but must"):
        parse_list_limits(value)


def test_a_board_without_sensor_and_thermometer_leaves_both_empty():
    value = "HOLD,1.2000,,30500.0,7.826,"
    status = parse_status(value)
    assert (status.level, status.temperature_c) == (None, None)
    assert format_status(status) == value


def sent_as(sequence_text, body=b"STAT?", tail=b""):
    payload = sequence_text + b" " + body
    return b">%b*%04X%b" % (payload, crc16(payload), tail)


@pytest.mark.parametrize("sequence", [b"0", b"01", b"00001", b"65536", b"99999", b"123456", b"+1"])
def test_a_sequence_number_is_1_to_65535_without_leading_zero(sequence):
    assert parse_command(sent_as(sequence)) is None
    assert parse_command(sent_as(b"65535")) == (65_535, "STAT?")


@pytest.mark.parametrize("body", [b"ST<AT?", b"ST!AT?", b"STAT\x80", b"STAT\t", b""])
def test_a_body_has_only_what_a_frame_may_carry(body):
    assert parse_command(sent_as(b"7", body)) is None


@pytest.mark.parametrize("tail", [b" ", b"x", b"\x00", b"*0000"])
def test_a_frame_with_a_tail_is_none(tail):
    assert parse_command(sent_as(b"7", tail=tail)) is None
