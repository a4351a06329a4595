"""Forces of an ATI Net F/T box, over datagrams on this computer."""

import struct

import pytest

from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.contact.emulated_net_ft import COUNTS_PER_N, EmulatedNetFT, record
from slipscale.hardware.contact.net_ft import STOP, STREAM, Record
from slipscale.hardware.contact.registry import open_source
from slipscale.hardware.contact.source import SensorFault, Surroundings
from tests.support.patient_host import PatientHost


@pytest.fixture
def around():
    return Surroundings(clock=PatientHost())


def wait_for(source, count, clock=None):
    """Return at least so many samples; silence raises a fault."""
    clock, found = clock or PatientHost(), []
    while len(found) < count:
        found += source.take()
        clock.sleep(0.001)
    return found


def test_a_record_is_the_published_one():
    sent = record(7, (1.0, -2.0, 3.5))
    assert (
        sent.hex()
        == "0000000700000007000000000" + "00f4240ffe17b8000356 7e0".replace(" ", "") + "0" * 24
    )
    assert Record.read(sent) == (7, 0, (1_000_000, -2_000_000, 3_500_000, 0, 0, 0))
    with pytest.raises(struct.error):
        Record.read(sent[:-1])


def test_forces_come_in_newtons_by_axis_and_the_box_is_stopped(around):
    with EmulatedNetFT(lambda _: (0.25, 0.125, -0.5)) as box:
        with open_source("force", box.spec, around) as source:
            found = wait_for(source, 20)
            assert source.describe()["name"] == "ati"
        with open_source("force", f"{box.spec},normal=z,lateral=-y", around) as source:
            turned = wait_for(source, 2)
        assert source.unreadable == 0
        while box.commands[-1] != STOP:
            pass
    assert {each.values for each in found} == {(0.5, 0.25)}
    assert {each.values for each in turned} == {(-0.5, -0.125)}
    assert [each.time_s for each in found] == sorted(each.time_s for each in found)
    assert set(box.commands) == {STREAM, STOP}


def test_the_tare_is_the_mean_at_the_start(around):
    with (
        EmulatedNetFT(lambda _: (0.25, 0.0, -0.5)) as box,
        open_source("force", f"{box.spec},tare=0.001", around) as source,
    ):
        found = wait_for(source, 3)
    assert found[-1].values == pytest.approx((0.0, 0.0), abs=1e-9)


def lost(number, sent):
    if number % 4:
        yield sent


def twice(_number, sent):
    yield sent
    yield sent


def short(number, sent):
    yield sent if number % 2 else sent[:20]


def failing(number, sent):
    yield sent if number % 2 else sent[:8] + b"\x80\x02\0\0" + sent[12:]


def late(number, sent):
    if number % 2 == 0:
        yield record(number + 1, (0.25, 0.0, -0.5))
        yield sent


FAULTS = {each.__name__: each for each in (lost, twice, short, failing, late)}


@pytest.mark.parametrize("name", FAULTS)
def test_records_that_are_lost_late_short_or_report_an_error_are_counted_and_never_used(
    around, name
):
    with (
        EmulatedNetFT(lambda _: (0.25, 0.0, -0.5), datagrams=FAULTS[name]) as box,
        open_source("force", box.spec, around) as source,
    ):
        found = wait_for(source, 12)
        assert source.unreadable >= 3
    assert {each.values for each in found} == {(0.5, 0.25)}


def nothing(_number, _sent):
    yield from ()


def errors(_number, sent):
    yield sent[:8] + b"\x80\x02\0\0" + sent[12:]


class Skipping(PatientHost):
    """A patient computer whose time goes on when a test says so: silence without waiting."""

    skipped_s, skips = 0.0, False

    def now(self):
        return super().now() + self.skipped_s

    def sleep(self, seconds):
        super().sleep(seconds)
        self.skipped_s += self.skips


@pytest.mark.parametrize(
    "kind, said",
    [(nothing, "ati sent no reading. Check"), (errors, "the last line was 'status 0x80020000'")],
)
def test_a_box_without_readings_is_a_fault_with_its_status(kind, said):
    clock = Skipping()
    with EmulatedNetFT(datagrams=kind) as box:
        source = open_source("force", box.spec, Surroundings(clock=clock))
        readings = source._readings

        def read(data):
            found = readings(data)
            clock.skips = kind is nothing or source.unreadable > 0
            return found

        source._readings = read
        with pytest.raises(SensorFault, match=said), source:
            pytest.fail("it was connected")


def test_a_box_that_falls_silent_is_a_fault_and_is_started_again():
    quiet, clock = [], Skipping()

    def until_quiet(_number, sent):
        if not quiet:
            yield sent

    with (
        EmulatedNetFT(datagrams=until_quiet) as box,
        open_source("force", box.spec, Surroundings(clock=clock)) as source,
    ):
        wait_for(source, 5)
        quiet.append(True)
        clock.skips = True
        with pytest.raises(SensorFault, match="sent no reading"):
            wait_for(source, 10**9, clock)
        clock.skips = False
        quiet.clear()
        source.begin()
        assert len(wait_for(source, 3)) >= 3
        assert box.commands.count(STREAM) == 2


@pytest.mark.parametrize(
    "spec, said",
    [
        ("ati:box", "counts_per_n"),
        ("ati:counts_per_n=1", "expected ati:HOST"),
        ("ati:box,counts_per_n=0", "counts_per_n"),
        ("ati:box,counts_per_n=1,normal=w", "expected one of x, y, z, -x, -y, -z"),
        ("ati:box,counts_per_n=1,normal=x", "two axes"),
        ("ati:box,counts_per_n=1,port=70000", "from 1 to 65535"),
    ],
)
def test_a_wrong_spec_is_one_sentence(spec, said):
    with pytest.raises(UserError, match=said):
        open_source("force", spec, Surroundings(clock=VirtualClock()))


def test_counts_per_newton_scale_the_forces(around):
    with EmulatedNetFT(lambda _: (0.25, 0.0, -0.5)) as box:
        spec = box.spec.replace(str(COUNTS_PER_N), str(2 * COUNTS_PER_N))
        with open_source("force", spec, around) as source:
            assert wait_for(source, 1)[0].values == (0.25, 0.125)
