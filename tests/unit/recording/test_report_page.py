"""The page about a run: complete in itself, and nothing in it is taken for HTML that is not."""

from __future__ import annotations

from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.errors import FileError
from skiros_py.recording import Recording, RecordingWriter, Schema, Topic
from skiros_py.recording.pictures import OVERVIEW
from skiros_py.recording.report import report_page
from skiros_py.recording.timeline import draw, lanes, span
from skiros_py.world.change import Change, ElementEdit, PropertyEdit
from skiros_py.world.element import Element

_EVIL = "<img src=x onerror=alert(1)>\"'&</style></svg><script>alert(2)</script>"
_EVENT = {"kind": "skill", "module": "pick", "code": 0, "text": "", "target": "", "agent": "arm_1", "caller": ""}
_ENTRY: dict[str, Any] = {"what": "started", "text": "", "step": 1, "skill": "pick", "arguments": {}, "agent": "arm_1"}
_REPORT: dict[str, Any] = {"steps": [], "simulated": 2.0, "wall": 1.0, "no_plan": [], "fault": "", "outcome": "reached"}
_ANY = Schema("any", {"type": "object"})
_RUNS, _TRACE, _TASKS, _CHANGES, _PICTURES = (
    Topic(name, _ANY) for name in ("/runs", "/trace", "/tasks", "/world/changes", OVERVIEW)
)
_CONDITION: dict[str, Any] = {"believed": True, "true": None, "tries": 1, "simulated": 1.5}


class _Page(HTMLParser):
    """Reads a page: its tags, texts and what it would load."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: set[str] = set()
        self.loads: list[str] = []
        self.handlers: list[str] = []
        self.text = ""
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.loads += [value or "" for name, value in attrs if name in ("src", "href", "action", "data")]
        self.handlers += [name for name, _ in attrs if name.startswith("on")]
        if tag not in ("meta", "img", "br", "line", "rect"):
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.fixture(scope="module")
def evil(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The page about a run in which every text is an attack."""
    path = tmp_path_factory.mktemp("runs") / "evil.mcap"
    writer = RecordingWriter(path)
    writer.put_metadata("run", dict.fromkeys(("scene", "digest", "driver", "planner"), _EVIL))
    writer.put_metadata("run", {"robots": {_EVIL: [_EVIL, _EVIL]}, "versions": {_EVIL: _EVIL}})
    words = dict.fromkeys(("module", "text", "target", "agent"), _EVIL)
    writer.put(_RUNS, 0.0, {**_EVENT, **words, "time": 0.0, "status": "started"})
    writer.put(_RUNS, 1.0, {**_EVENT, **words, "time": 1.0, "status": "error"})
    waits = {"what": "waits", "text": _EVIL, "agent": _EVIL, "skill": _EVIL}
    writer.put(_TRACE, 0.5, {**_ENTRY, **waits, "task": 1, "time": 0.5})
    report = {**_REPORT, "fault": _EVIL, "no_plan": [_EVIL], "outcome": _EVIL}
    report["conditions"] = [{**_CONDITION, "condition": _EVIL, "reason": _EVIL}]
    writer.put(_TASKS, 2.0, {"number": 1, "name": _EVIL, "goal": [_EVIL], "report": report})
    ball = Element("ball_1", "tiny:Ball", _EVIL, {})
    edits = (ElementEdit("ball_1", None, ball), PropertyEdit("ball_1", "rdfs:label", "", _EVIL))
    writer.put(_CHANGES, 0.2, Change(1, _EVIL, _EVIL, 0.2, edits).as_json())
    writer.put(_PICTURES, 1.0, {"caption": _EVIL, "data": ""})
    writer.put_metadata("run", {"ended": {"time": 2.0, "wall": 1.0, "fault": _EVIL}})
    writer.close()
    with Recording(path) as record:
        return report_page(record)


def test_texts_of_a_run_are_escaped_in_html(evil: str) -> None:
    page = _Page(evil)

    assert "script" not in page.tags
    assert not page.handlers
    assert page.text.count(_EVIL) > 15
    assert page.open == []


def test_a_report_page_loads_no_external_resources(evil: str) -> None:
    page = _Page(evil)

    assert page.loads
    assert all(load.startswith(("data:image/webp;base64,", "#picture-")) for load in page.loads)
    assert "url(" not in evil
    assert "@import" not in evil


def test_a_report_page_shows_the_outcome_the_failures_and_an_unfinished_recording(tmp_path: Path) -> None:
    path = tmp_path / "one.mcap"
    writer = RecordingWriter(path)
    writer.put(_RUNS, 0.0, _event(0.0, "started", target="starter_1"))
    writer.put(_RUNS, 1.0, _event(1.0, "error", target="starter_1", text="the gripper is empty"))
    missing = {**_CONDITION, "condition": "In(a, b)", "believed": False, "reason": "b is full"}
    report = {**_REPORT, "conditions": [missing], "outcome": "not reached"}
    writer.put(_TASKS, 1.0, {"number": 1, "name": "task 1", "goal": [], "report": report})
    writer.close()

    with Recording(path) as record:
        text = _Page(report_page(record)).text
    for told in ("task 1: not reached", "In(a, b)", "b is full", "the gripper is empty", "was not finished"):
        assert told in text


def test_an_empty_recording_gives_a_valid_page(tmp_path: Path) -> None:
    writer = RecordingWriter(tmp_path / "one.mcap")
    writer.close()

    with Recording(tmp_path / "one.mcap") as record:
        assert "No task was begun" in report_page(record)


def _event(time: float, status: str, **said: str) -> dict[str, Any]:
    return {**_EVENT, "time": time, "status": status, **said}


def test_module_starts_and_ends_become_bars() -> None:
    events = [
        _event(0.0, "started", target="ball"),
        _event(0.1, "started", kind="primitive", module="grasp", caller="pick"),
        _event(0.4, "terminated", kind="primitive", module="grasp", caller="pick"),
        _event(0.5, "preempted", target="ball"),
        _event(0.6, "started", agent="base_1", module="drive"),
    ]
    arm, base = lanes(events, [], {"robot_1": ["arm_1", "base_1"]}, 2.0)

    assert [(bar.label, bar.start, bar.end, bar.how, bar.row) for bar in arm.bars] == [
        ("pick ball", 0.0, 0.5, "cut", 0),
        ("grasp", 0.1, 0.4, "good", 1),
    ]
    assert [(bar.label, bar.end, bar.how) for bar in base.bars] == [("drive", 2.0, "open")]
    assert (arm.robot, base.robot) == ("robot_1", "robot_1")


def test_a_wait_lasts_until_its_step_starts() -> None:
    waits = {**_ENTRY, "task": 1, "time": 1.0, "what": "waits", "step": None, "text": "arm_1: pick waits: kit_1"}
    other = {**_ENTRY, "task": 1, "time": 2.0, "skill": "place", "step": 2}
    starts = {**_ENTRY, "task": 1, "time": 3.0, "step": 3}
    (lane,) = lanes([], [waits, other, starts], {}, 9.0)

    assert [(bar.kind, bar.start, bar.end) for bar in lane.bars] == [("wait", 1.0, 3.0)]


def test_a_wait_within_a_skill_lasts_until_its_subsystem_continues() -> None:
    events = [
        _event(0.0, "started"),
        _event(0.0, "running", text="waits for kit_1 (place)"),
        _event(0.5, "started", agent="arm_2"),
        _event(2.0, "started", kind="primitive", module="grasp", caller="pick"),
    ]
    arm, _ = lanes(events, [], {}, 3.0)

    assert [(bar.label, bar.start, bar.end) for bar in arm.bars if bar.kind == "wait"] == [
        ("waits for kit_1 (place)", 0.0, 2.0)
    ]


@st.composite
def _histories(draw_: st.DrawFn) -> list[dict[str, Any]]:
    """Events in order of time, as any number of modules may tell them, some cut off."""
    times = sorted(draw_(st.lists(st.floats(0.0, 1e4), max_size=30)))
    statuses = st.sampled_from(["started", "running", "terminated", "error", "preempted"])
    words = {"module": st.sampled_from("ab"), "agent": st.sampled_from(["arm", "base"])}
    kinds = {"kind": st.sampled_from(["skill", "primitive"]), "caller": st.sampled_from(["", "a"])}
    texts = {"text": st.sampled_from(["", "waits for kit_1 (place)"])}
    said = st.fixed_dictionaries(words | kinds | texts)
    return [_event(time, draw_(statuses), **draw_(said)) for time in times]


@given(_histories())
def test_bars_of_any_events_never_overlap_and_stay_on_the_page(events: list[dict[str, Any]]) -> None:
    begin, end = span(events, [], 0.0, None)
    rows = lanes(events, [], {}, end)
    drawing = draw(rows, begin, end, [])

    begun = [bar for lane in rows for bar in lane.bars if bar.kind != "wait"]
    assert len(begun) == sum(event["status"] == "started" for event in events)
    for lane in rows:
        by_row: dict[int, list[tuple[float, float]]] = {}
        for bar in lane.bars:
            assert begin <= bar.start <= bar.end <= end
            by_row.setdefault(bar.row, []).append((bar.start, bar.end))
        for taken in by_row.values():
            assert all(a[1] <= b[0] + 1e-6 for a, b in pairwise(taken))
    bars = [bar for lane in rows for bar in lane.bars]
    assert all(drawing.left - 1e-6 <= bar.x and bar.x + bar.width <= drawing.width for bar in bars)
    assert all(bar.y + drawing.row <= drawing.height for bar in bars)


def test_a_recording_damaged_anywhere_gives_a_page_or_an_error_message(tmp_path: Path) -> None:
    path = tmp_path / "one.mcap"
    writer = RecordingWriter(path)
    for number in range(40):
        writer.put(_RUNS, number, _event(number, "started", target=f"ball_{number}"))
        writer.put(_TRACE, number, {**_ENTRY, "task": 1, "time": number})
        change = Change(number, "pick", "why", number, (PropertyEdit("ball_1", "sk:mass", 1.0, 2.0),))
        writer.put(_CHANGES, number, change.as_json())
    writer.put(_TASKS, 40.0, {"number": 1, "name": "task", "goal": [], "report": {**_REPORT, "conditions": []}})
    writer.close()
    whole, random = path.read_bytes(), np.random.default_rng(5)

    outcomes = set()
    for at in random.integers(0, len(whole), 120).tolist():
        damage = random.bytes(12)
        path.write_bytes(whole[:at] + damage + whole[at + len(damage) :])
        try:
            with Recording(path) as record:
                report_page(record)
                record.as_json()
            outcomes.add("page")
        except FileError:
            outcomes.add("message")
    assert outcomes == {"page", "message"}
