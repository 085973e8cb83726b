"""Streams are places in one log: each gets what it chose, nobody is waited for, gaps are told."""

import asyncio
import json

import pytest

from skiros_py.server import streams as module
from skiros_py.server.access.roles import Caller, Role
from skiros_py.server.problems import Problem
from skiros_py.server.streams import EVERYTHING, Choice, Streams, position_text
from skiros_py.station.events.log import EventLog, Kind

CALLER = Caller("anna", Role.VIEWER)


@pytest.fixture
def log():
    return EventLog(100)


@pytest.fixture
def streams(log):
    return Streams(log, 10)


def read(frame):
    """Returns the fields of one or more server-sent events."""
    blocks = frame.decode().strip("\n").split("\n\n")
    return [dict(line.split(": ", 1) for line in block.split("\n") if not line.startswith(":")) for block in blocks]


def write(log, count, kind=Kind.JOB, **more):
    for _ in range(count):
        log.append(kind, "running", **more)


def take(streams, count, choice=EVERYTHING, after=None, then=lambda: None, caller=CALLER):
    """Follows until so many frames came; ``then`` is called after the first."""

    async def run():
        frames = streams.follow(choice, caller, after)
        got = [await anext(frames)]
        then()
        while len(got) < count:
            got.append(await anext(frames))
        await frames.aclose()
        return got

    return asyncio.run(asyncio.wait_for(run(), 20))


def test_a_new_stream_sends_its_position_at_once(streams, log):
    write(log, 3)
    (first,) = take(streams, 1)
    assert read(first) == [{"id": position_text(log, 3), "retry": "1000"}]


def test_a_stream_receives_events_from_its_start(streams, log):
    write(log, 3)
    _, frame = take(streams, 2, then=lambda: write(log, 2))
    assert [one["id"] for one in read(frame)] == [position_text(log, 4), position_text(log, 5)]


def test_a_stream_continues_after_the_last_received_event(streams, log):
    write(log, 5)
    _, frame = take(streams, 2, after=position_text(log, 2))
    assert [json.loads(one["data"])["number"] for one in read(frame)] == [3, 4, 5]


def test_after_lost_events_a_stream_gets_a_reset_and_then_only_new_events(streams, log):
    write(log, 150)
    first, second = take(streams, 2, after=position_text(log, 3), then=lambda: write(log, 1))
    (reset,) = read(first)
    assert (reset["event"], reset["id"]) == ("reset", position_text(log, 150))
    assert json.loads(reset["data"])["code"] == "gone"
    assert [one["id"] for one in read(second)] == [position_text(log, 151)]


def test_a_slow_reader_gets_a_reset_instead_of_a_silent_gap(streams, log):
    write(log, 1)
    _, frame = take(streams, 2, then=lambda: write(log, 500))
    (reset,) = read(frame)
    assert json.loads(reset["data"])["why"] == "the events 2 to 401 are not kept any more"
    assert reset["id"] == position_text(log, 501)


@pytest.mark.parametrize(
    ("choice", "expected"),
    [
        (Choice(kinds=frozenset({Kind.WORLD})), [2]),
        (Choice(job="a"), [1]),
        (Choice(element="kit_1"), [2]),
        (Choice(types=frozenset({"ended"})), [3]),
        (Choice(kinds=frozenset({Kind.JOB}), types=frozenset({"scene"})), []),
    ],
)
def test_each_stream_receives_only_its_selected_events(streams, log, choice, expected):
    log.append(Kind.JOB, "running", "a", job="a")
    log.append(Kind.WORLD, "scene", elements=["kit_1", "starter_1"])
    log.append(Kind.JOB, "ended", "b", job="b")
    log.append(Kind.SYSTEM, "reset")
    assert [event.number for event in log.since(0) if choice.takes(event)] == expected


def test_a_quiet_stream_sends_its_position_regularly(streams, log, monkeypatch):
    monkeypatch.setattr(module, "_QUIET", 0.05)
    monkeypatch.setattr(module, "_LOOK", 0.01)
    chosen = Choice(kinds=frozenset({Kind.ALARM}))
    _, frame = take(streams, 2, chosen, then=lambda: write(log, 90))
    assert frame.startswith(b": still here\n")
    assert read(frame) == [{"id": position_text(log, 90)}]


def test_a_burst_of_events_wakes_all_streams_once(streams, log):
    woken = []

    async def run():
        frames = [streams.follow(EVERYTHING, CALLER, None) for _ in range(5)]
        for one in frames:
            await anext(one)
        waiting = [asyncio.create_task(anext(one)) for one in frames]
        await asyncio.sleep(0.01)
        loop = asyncio.get_running_loop()
        original = loop.call_soon_threadsafe
        loop.call_soon_threadsafe = lambda *given: (woken.append(1), original(*given))
        await asyncio.to_thread(write, log, 50)
        got = await asyncio.gather(*waiting)
        loop.call_soon_threadsafe = original
        for one in frames:
            await one.aclose()
        return got

    got = asyncio.run(run())
    assert all(len(read(frame)) == 50 for frame in got)
    assert len(woken) < 10  # the helper thread's own end is among them


def test_streams_with_the_same_selection_share_one_encoding(streams, log):
    async def run():
        frames = [streams.follow(Choice(job=job), CALLER, "") for job in ("kit", "kit", "other")]
        for one in frames:
            await anext(one)
        log.append(Kind.JOB, "running", "kit", job="kit")
        log.append(Kind.JOB, "running", "other", job="other")
        got = [await anext(one) for one in frames]
        for one in frames:
            await one.aclose()
        return got

    first, second, other = asyncio.run(asyncio.wait_for(run(), 20))
    assert first is second
    assert [one["id"] for one in read(other)] == [position_text(log, 2)]


def test_a_batch_of_long_events_is_bounded_in_bytes_and_loses_none(streams, log, monkeypatch):
    monkeypatch.setattr(module, "_LARGEST", 10_000)
    write(log, 20, data={"text": "x" * 3000})
    write(log, 1, data={"text": "y" * 30_000})
    write(log, 1)
    _, *frames = take(streams, 10, after="")
    assert [len(read(frame)) for frame in frames] == [3, 3, 3, 3, 3, 3, 2, 1, 1]
    assert [json.loads(one["data"])["number"] for frame in frames for one in read(frame)] == list(range(1, 23))


def test_the_number_of_streams_is_limited_in_total_and_to_half_per_caller(streams):
    from contextlib import ExitStack

    others = [Caller(f"c{n}", Role.VIEWER, f"k{n}") for n in range(5)]
    with ExitStack() as stack:
        for _ in range(5):
            stack.enter_context(streams.listening(CALLER))
        with pytest.raises(Problem, match="5 of one caller"):
            stack.enter_context(streams.listening(CALLER))
        for other in others:
            stack.enter_context(streams.listening(other))
        with pytest.raises(Problem, match="10 in total"):
            stack.enter_context(streams.listening(Caller("late", Role.VIEWER)))
    assert streams.open == 0


def test_a_stream_ends_when_its_caller_loses_access(streams, log):
    allowed = [True]
    streams.allowed = lambda caller: allowed[0]

    async def run():
        got = []
        async for frame in streams.follow(EVERYTHING, CALLER, None):
            got.append(frame)
            allowed[0] = False
            write(log, 1)
        return got

    assert len(asyncio.run(asyncio.wait_for(run(), 20))) == 1


def test_all_streams_end_with_the_server_and_no_new_ones_start(streams):
    async def run():
        frames = streams.follow(EVERYTHING, CALLER, None)
        await anext(frames)
        ending = asyncio.create_task(anext(frames, None))
        await asyncio.sleep(0.01)
        streams.end()
        return await ending

    assert asyncio.run(asyncio.wait_for(run(), 20)) is None
    with pytest.raises(Problem), streams.listening(CALLER):
        pass
