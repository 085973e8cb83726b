from __future__ import annotations

import json

from skiros_py.tasks.trace import Trace, TraceEntry, TraceEventKind


def entry(number: int) -> TraceEntry:
    return TraceEntry(
        0.1 * number, TraceEventKind.STARTED, f"step {number} starts", number, "pick", {"Ball": "b"}, "arm_1"
    )


def test_a_trace_keeps_the_latest_and_counts_what_it_forgot() -> None:
    trace = Trace(longest=3)
    for number in range(5):
        trace.add(entry(number))

    assert [one.step for one in trace.entries] == [2, 3, 4]
    assert trace.forgotten == 2


def test_a_listener_hears_everything_until_it_leaves_and_may_break() -> None:
    trace, heard = Trace(), []

    def breaks(_entry: TraceEntry) -> None:
        raise SystemExit(1)

    trace.subscribe(breaks)
    leave = trace.subscribe(heard.append)
    trace.add(entry(1))
    leave()
    trace.add(entry(2))

    assert heard == [entry(1)]
    assert len(trace.entries) == 2


def test_entries_are_plain_data_and_sentences() -> None:
    trace = Trace()
    trace.add(entry(1))

    (plain,) = json.loads(json.dumps(trace.as_json()))
    assert plain == {
        "time": 0.1,
        "what": "started",
        "text": "step 1 starts",
        "step": 1,
        "skill": "pick",
        "arguments": {"Ball": "b"},
        "agent": "arm_1",
        "data": {},
        "id": "",
        "parent": "",
    }
    assert str(trace) == "   0.10 s  step 1 starts"
