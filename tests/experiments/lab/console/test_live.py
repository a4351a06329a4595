"""The page of the running session: the plate's history, steering from the day's page, the blind."""

import re
from dataclasses import replace

import anyio
import pytest

from slipscale.experiments.lab.blind_summary import Event, PlateReading, RunSummary, summary
from slipscale.experiments.lab.console import app, state
from slipscale.experiments.lab.console.pages.history import deviations, history


def read(*used, temperature_c=None):
    """Return presentations, ten seconds apart."""
    return tuple(
        PlateReading(time_s=10.0 * n, used_tolerance=share, temperature_c=temperature_c)
        for n, share in enumerate(used)
    )


def test_nothing_is_told_of_fewer_than_eight_presentations():
    """Of one alone the deviation could tell which amplitude that was."""
    readings = read(*[0.1] * 7, 0.6, *[0.2] * 7)
    [only] = deviations(readings)
    assert (only.begin_s, only.end_s, only.largest, only.median) == (0.0, 70.0, 0.6, 0.1)
    assert deviations(readings[:7]) == []


def test_within_the_eight_their_order_is_not_told():
    shares = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8]
    forth, back = (deviations(read(*order))[0] for order in (shares, shares[::-1]))
    assert forth == back


def test_presentations_that_were_not_measured_are_no_deviations():
    assert len(deviations(read(*[0.1, None] * 8))) == 1


def test_the_history_shows_the_limit_the_warmth_and_the_faults():
    last = PlateReading(time_s=120.0, used_tolerance=None, temperature_c=27.5)
    warm = (*read(*[0.5] * 8, temperature_c=21.0), last)
    fault = Event(time_s=60.0, kind="fault", words="not_reached")
    found = history(RunSummary(readings=warm, events=(fault,), duration_s=120.0))
    [bar] = found.bars
    assert found.limit < bar.top == bar.middle
    assert [label for _, label in found.warmth_ticks] == ["21.0", "27.5"]
    assert (len(found.warmth), found.minutes) == (9, 2.0)
    assert found.warmth[0][0] < found.faults[0] < found.warmth[-1][0] == 630.0


def test_a_temperature_that_only_flickers_is_no_rise():
    found = history(RunSummary(readings=read(*[None] * 9, temperature_c=21.0), duration_s=90.0))
    assert [label for _, label in found.warmth_ticks] == ["20.0", "22.0"]
    assert found.bars == ()


def test_the_deviation_is_told_of_many_presentations_together(
    visitor, session, status, words_of, monkeypatch
):
    """Of a single one it could tell which amplitude that was."""
    for count, told in ((7, False), (8, True)):
        readings = read(*(0.1,) * (count - 1), 0.42)
        run = RunSummary(readings=readings)
        monkeypatch.setattr(state, "summary", lambda _, run=run: run)
        with session(status):
            visitor.console.state.now(fresh=True)
            assert ("42 % of the tolerance" in words_of(visitor.see("/live"))) is told


def test_the_deviation_is_a_share_of_what_the_plate_allows(recorded):
    path = next((recorded / "sourcedata/sub-01").glob("*_journal.jsonl"))
    used = [reading.used_tolerance for reading in summary(path).readings]
    assert len(used) > 8
    assert all(0 <= share <= 1 for share in used)
    assert max(used) > 0


@pytest.mark.parametrize("run", [RunSummary(), RunSummary(readings=read(0.1, 0.2))])
def test_before_there_is_anything_there_is_no_history(run):
    assert history(run) is None


def test_the_page_shows_temperature_where_the_board_tells_it(visitor, session, status, words_of):
    with session(replace(status, temperature_c=23.42)):
        assert "temperature 23.4 °C" in words_of(visitor.see("/live"))
    with session(status):
        visitor.console.state.now(fresh=True)
        assert " °C</dd>" not in visitor.see("/live")


def test_the_day_steers_the_session_as_its_own_page_does(visitor, session, status):
    """Start, pause, go on, void with a reason, stop with a confirmation, notes: in one place."""
    with session(status):
        pages = [visitor.see(path) for path in ("/", "/live")]
    asked = [set(re.findall(r"&#34;what&#34;: &#34;([a-z_]+)", page)) for page in pages]
    assert asked[0] == {"pause", "void", "note", "stop"}
    assert asked[1] == asked[0] | {"unblind"}
    for page in pages:
        keys = dict(re.findall(r'what&#34;: &#34;([a-z]+)&#34;.*?data-key="(.)"', page))
        assert keys["pause"] == "p"
    with session(replace(status, state="paused")):
        visitor.console.state.now(fresh=True)
        assert "&#34;go_on&#34;" in visitor.see("/")


def test_the_operators_notes_stand_on_the_page_of_the_day(visitor, session, status, words_of):
    assert "No notes yet" in words_of(visitor.see("/"))
    with session(status) as (_, journal):
        journal.write("note", text="a door <slammed>")
        visitor.console.state.now(fresh=True)
        page = visitor.see("/")
    assert "a door &lt;slammed&gt;" in page
    assert "02 run 01" in words_of(page)


def test_the_amplitude_is_shown_after_a_typed_word_and_a_request_to_the_session(
    visitor, session, status
):
    with session(status) as (box, _):
        page = visitor.see("/live")
        token = re.search(r"&#34;token&#34;: &#34;([0-9a-f]+)", page)[1]
        assert "Show the amplitude" in page
        refused, said = visitor.ask("ask", token=token, what="unblind", word="yes")
        assert (refused, "expected the word" in said, box.poll()) == (409, True, None)
        assert visitor.ask("ask", token=token, what="unblind", word="unblind")[0] == 200
        assert box.poll().what == "unblind"
        box.tell(replace(status, unblinded=True))
        visitor.console.state.now(fresh=True)
        page = visitor.see("/live")
    assert "Show the amplitude" not in page
    assert "amplitude (unblinded)" in page


def test_what_a_session_tells_is_shown_at_once(visitor, session, status, words_of):
    """The folder is read once a second; who paused the session must not wait for that."""
    with session(status) as (box, _):
        assert "running" in words_of(visitor.see("/live"))
        box.tell(replace(status, state="paused"))
        assert "PAUSED" in words_of(visitor.see("/live"))
    assert "No session is running" in words_of(visitor.see("/live"))


def test_pages_are_told_at_once_that_a_session_told_something(
    visitor, session, status, monkeypatch
):
    monkeypatch.setattr(app, "LOOK_S", 1000.0)

    async def hear(box):
        stream = visitor.console._changes()
        first = await anext(stream)
        box.tell(replace(status, state="paused"))
        with anyio.fail_after(20):
            second = await anext(stream)
        await stream.aclose()
        return first, second

    visitor.see("/live")
    with session(status) as (box, _):
        visitor.console.state.now(fresh=True)
        first, second = anyio.run(hear, box)
    assert first.startswith("data: ")
    assert second.startswith("data: ")
    assert first != second
