"""The log of events: numbered without gaps, bounded in number and size, whatever is written."""

import json
import threading

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from skiros_py.station.events.log import EventLog, Kind

LEAVES = st.none() | st.booleans() | st.integers() | st.floats() | st.text(st.characters(exclude_categories=()))
ANYTHING = st.recursive(LEAVES, lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner), max_leaves=8)


def filled(count, kept=100):
    log = EventLog(kept)
    for number in range(count):
        log.append(Kind.WORLD, "scene", data={"n": number})
    return log


def numbers(events):
    return [event.number for event in events]


def test_events_are_numbered_without_gaps_from_one():
    log = filled(5)
    assert numbers(log.since(0)) == [1, 2, 3, 4, 5]
    assert (log.first, log.last) == (1, 5)


def test_an_empty_log_has_no_last_event_and_expects_the_first():
    log = EventLog(10)
    assert (log.first, log.last, log.since(0)) == (1, 0, [])


@given(count=st.integers(0, 60), kept=st.integers(1, 20), after=st.integers(0, 70), most=st.integers(1, 30))
def test_since_returns_kept_events_after_a_number_in_order_up_to_a_limit(count, kept, after, most):
    log = filled(count, kept)
    oldest = max(1, count - kept + 1)
    assert log.first == oldest
    assert numbers(log.since(after, most)) == list(range(max(oldest, after + 1), count + 1))[:most]


def test_many_threads_write_without_losing_or_doubling_a_number():
    log = EventLog(10_000)
    threads = [threading.Thread(target=lambda: [log.append(Kind.JOB, "x") for _ in range(500)]) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert numbers(log.since(0, 10_000)) == list(range(1, 4001))


@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.dictionaries(st.text(st.characters(exclude_categories=())), ANYTHING))
def test_any_event_data_becomes_one_line_of_standard_json(data):
    text = EventLog(1).append(Kind.TASK, "started", data=data).text
    assert text.isascii()
    assert "\n" not in text
    assert "\r" not in text
    json.loads(text, parse_constant=lambda word: (_ for _ in ()).throw(AssertionError(word)))


def test_values_that_json_cannot_represent_are_written_as_text():
    event = EventLog(1).append(Kind.TASK, "started", data={"kind": Kind.JOB, "of": object, 3: float("nan")})
    assert event.data == {"kind": "job", "of": "<class 'object'>", "3": None}


def test_a_too_long_event_is_kept_without_its_data_and_marked():
    event = EventLog(1).append(Kind.TASK, "planned", "a", data={"plan": "x" * 100_000})
    assert len(event.text) < 1000
    assert "too many for an event" in event.data["left_out"]


def test_the_log_is_bounded_in_size_and_not_only_in_number():
    log = EventLog(1000, room=10_000)
    for _ in range(500):
        log.append(Kind.WORLD, "scene", data={"x": "y" * 400})
    assert log.last == 500
    assert sum(len(event.text) for event in log.since(0, 1000)) <= 10_000


def test_an_event_with_very_many_elements_keeps_no_list_and_may_concern_any_element():
    few, many = (EventLog(1).append(Kind.WORLD, "scene", elements=map(str, range(n))) for n in (1000, 1001))
    assert few.touches("7")
    assert not few.touches("kit_1")
    assert many.touches("kit_1")


def test_an_exception_in_a_listener_affects_neither_writer_nor_other_listeners(caplog):
    log, heard = EventLog(10), []
    log.on_event(lambda: 1 / 0)
    end = log.on_event(lambda: heard.append(log.last))
    log.append(Kind.JOB, "ended")
    end()
    log.append(Kind.JOB, "ended")
    assert heard == [1]
    assert "a listener of events broke" in caplog.text
