from __future__ import annotations

import json

from skiros_py.planning.plan import Step
from skiros_py.tasks.trace import StepRun, Trace, TraceEntry, TraceEventKind


def trace_of(longest: int = 100) -> Trace:
    return Trace("kit 1", lambda: 0.1, longest=longest)


def start(trace: Trace, number: int) -> None:
    run = StepRun(number, Step("pick", {"Ball": "b"}), "arm_1", 0.1)
    trace.write(TraceEventKind.STARTED, f"step {number} starts", run=run)


def test_a_trace_keeps_the_latest_and_counts_what_it_forgot() -> None:
    trace = trace_of(longest=3)
    for number in range(1, 6):
        start(trace, number)

    assert [one.step for one in trace.entries] == [3, 4, 5]
    assert trace.forgotten == 2


def test_a_listener_hears_everything_until_it_leaves_and_may_break() -> None:
    trace, heard = trace_of(), list[TraceEntry]()

    def breaks(_entry: TraceEntry) -> None:
        raise SystemExit(1)

    trace.subscribe(breaks)
    leave = trace.subscribe(heard.append)
    start(trace, 1)
    leave()
    start(trace, 2)

    assert [entry.step for entry in heard] == [1]
    assert len(trace.entries) == 2


def test_entries_are_plain_data_and_sentences() -> None:
    trace = trace_of()
    start(trace, 1)

    (plain,) = json.loads(json.dumps([entry.as_json() for entry in trace.entries]))
    assert plain == {
        "time": 0.1,
        "what": "started",
        "text": "step 1 starts",
        "step": 1,
        "skill": "pick",
        "arguments": {"Ball": "b"},
        "agent": "arm_1",
        "data": {},
        "id": "kit 1#1",
        "parent": "kit 1",
        "texts": {},
    }
    assert str(trace) == "   0.10 s  step 1 starts"
