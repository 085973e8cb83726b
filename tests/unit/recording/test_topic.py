"""Topics: their schemas are such as Foxglove reads, and plug-ins bring further ones."""

from __future__ import annotations

import enum
import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from mcap.reader import make_reader

from skiros_py.behaviours import Wait
from skiros_py.devices.gripper import GripperSpec, GripperState
from skiros_py.geometry import Pose
from skiros_py.ports.adapters import GivenPorts
from skiros_py.ports.cell import CellSpec, RobotSpec
from skiros_py.ports.signals import Input, Signal
from skiros_py.ports.values import Snapshot
from skiros_py.recording import Recorder, Recording, RecordingWriter
from skiros_py.recording.recorder import Devices
from skiros_py.recording.topic import own_schema, plain
from skiros_py.skills.skill import RunnableDocument
from skiros_py.testing import Bench, tiny_world

PLUGIN = """
from skiros_py.recording import Schema, Topic

SCHEMA = Schema("example.Temperature", {"type": "object"})
TEMPERATURE = Topic("/temperature", SCHEMA, lambda time, value: {"celsius": value})


def record(recorder):
    board = recorder.runtime.cycle.board
    recorder.on_end(recorder.runtime.cycle.observe(lambda: recorder.put(TEMPERATURE, 20.0 + board.snapshot.time)))


def broken(recorder):
    raise RuntimeError("no sensor")
"""


class Colour(enum.Enum):
    RED = "red"


@dataclass(frozen=True)
class Inner:
    speed: float


@dataclass(frozen=True)
class Reading:
    time: float
    count: int
    good: bool
    name: str
    colour: Colour
    inner: Inner
    pose: Pose
    numbers: tuple[float, ...]
    inners: tuple[Inner, ...]
    words: Mapping[str, str]
    maybe: float | None
    image: Any


READING = Reading(
    0.12345678,
    3,
    True,
    "a",
    Colour.RED,
    Inner(np.float64(1.0)),
    Pose(),
    (1.0, 2.0),
    (Inner(2.0),),
    {"a": "b"},
    None,
    np.array([[1, 2]]),
)


def fits(schema: Mapping[str, Any]) -> bool:
    """Tells whether Foxglove can read a schema: it knows these types only, and neither references nor alternatives."""
    simple = ("boolean", "string", "number", "integer")

    def known(one: Mapping[str, Any]) -> bool:
        if "oneOf" in one:
            return all(isinstance(alternative["const"], int) for alternative in one["oneOf"])
        if one["type"] == "array":
            return one["items"]["type"] in simple or fits(one["items"])
        return one["type"] in simple or fits(one)

    return schema.get("type") == "object" and all(map(known, schema.get("properties", {}).values()))


def test_a_dataclass_becomes_plain_data_that_fits_its_schema() -> None:
    schema, message = own_schema(Reading), plain(READING)

    Draft202012Validator(dict(schema.data)).validate(json.loads(json.dumps(message)))
    assert schema.name == "skiros.Reading"
    assert fits(schema.data)
    assert set(schema.data["properties"]) == set(message) - {"maybe", "image"}
    assert message["time"] == 0.123457
    assert message["colour"] == "red"
    assert message["image"] == [[1, 2]]


@pytest.mark.parametrize("number", [float("nan"), float("inf")])
def test_a_number_that_json_cannot_represent_becomes_null(number: float) -> None:
    assert plain({"a": number}) == {"a": None}


def test_every_message_of_a_run_fits_the_schema_of_its_channel_for_a_plain_reader(tmp_path: Path) -> None:
    path = tmp_path / "one.mcap"
    with Bench(tiny_world()) as bench, Recorder(RecordingWriter(path), bench.runtime, {}) as recorder:
        recorder.on_end(bench.tasks.on_begin(recorder.follow))
        bench.pursue("In(Ball, slot_1)")

    topics = set()
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert schema is not None
            data = json.loads(schema.data)
            Draft202012Validator(data).validate(json.loads(message.data))
            assert fits(data), schema.name
            topics.add(channel.topic)
    assert {"/runs", "/tasks", "/trace", "/log", "/world/snapshot", "/world/changes"} <= topics
    assert any(topic.startswith("/devices/") for topic in topics)


def test_a_signal_in_use_has_a_channel_with_all_its_values(tmp_path: Path) -> None:
    path = tmp_path / "one.mcap"
    inputs = [Input(Signal("limit"), 0.5), Input(Signal("aim", length=2), (1.0, 2.0)), Input(Signal("unread"), 1.0)]
    with Bench(tiny_world(), signals=lambda _: inputs) as bench:
        read = ("limit", "aim", "gripper_1.still")
        bench.cycle.observe(lambda: list(map(bench.signals.read, read)))
        with Recorder(RecordingWriter(path), bench.runtime, {}):
            bench.advance(0.5)
            bench.signals.set("limit", True)
            bench.advance(0.5)

    with Recording(path) as recording:
        said = [(topic, message["value"]) for topic, _, message in recording.messages("/signals/")]
    assert said == [
        ("/signals/limit", 0.5),
        ("/signals/aim", [1.0, 2.0]),
        ("/signals/gripper_1.still", True),
        ("/signals/limit", True),
    ]


def test_each_revision_of_a_document_that_runs_is_recorded_once(tmp_path: Path) -> None:
    path = tmp_path / "one.mcap"
    with Bench(tiny_world()) as bench, Recorder(RecordingWriter(path), bench.runtime, {}):
        for revision in (3, 3, 4):
            bench.runtime.managers.documents["tree:rest"] = RunnableDocument(Wait(0.1), revision, "Rests.")
            bench.managers["arm_1"].start("tree:rest", {})
            bench.advance(0.2)

    with Recording(path) as recording:
        found = [message for _, _, message in recording.messages("/documents/tree:rest")]
    assert [(one["revision"], one["behaviour"]["seconds"]) for one in found] == [(3, 0.1), (4, 0.1)]


def test_a_plug_in_can_add_a_topic_and_a_failing_one_affects_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "topics_of_a_test.py").write_text(PLUGIN)
    info = tmp_path / "topics_of_a_test-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: topics-of-a-test\nVersion: 1.0\n")
    entries = "[skiros.topics]\ntemperature = topics_of_a_test:record\nbroken = topics_of_a_test:broken\n"
    (info / "entry_points.txt").write_text(entries)
    monkeypatch.syspath_prepend(str(tmp_path))
    path = tmp_path / "one.mcap"

    with Bench(tiny_world()) as bench:
        with Recorder(RecordingWriter(path), bench.runtime, {}):
            for _ in range(10):
                bench.cycle.step()
        bench.cycle.step()
        times = [bench.cycle.board.snapshot.time]

    with Recording(path) as recording:
        found = [(time, message["celsius"]) for _, time, message in recording.messages("/temperature")]
    assert len(found) == 10
    assert all(celsius == pytest.approx(20.0 + time) for time, celsius in found)
    assert found[-1][0] < times[0]
    assert "broken of topics-of-a-test 1.0" in caplog.text
    assert "no sensor" in caplog.text
    sys.modules.pop("topics_of_a_test")


BROKEN_LATER = """
from skiros_py.recording import Schema, Topic

TICKS = Topic("/ticks", Schema("example.Ticks", {"type": "object"}), lambda time, value: {"tick": value})


def record(recorder):
    ticks = []

    def on_cycle():
        ticks.append(len(ticks))
        if len(ticks) > 2:
            raise KeyError("boom")
        recorder.put(TICKS, len(ticks))

    def on_end():
        raise KeyError("the end")

    recorder.on_end(recorder.runtime.cycle.observe(on_cycle))
    recorder.on_end(on_end)
"""


def test_a_topic_that_raises_in_a_cycle_is_switched_off_and_named_and_the_run_goes_on(
    tmp_path: Path, site: Any, caplog: pytest.LogCaptureFixture
) -> None:
    site.install("sk-ticks", {"topics": {"ticks": "sk_ticks:record"}}, {"sk_ticks.py": BROKEN_LATER})
    path = tmp_path / "ticks.mcap"

    with Bench(tiny_world()) as bench, Recorder(RecordingWriter(path), bench.runtime, {}) as recorder:
        for _ in range(5):
            bench.cycle.step()

    with Recording(path) as recording:
        assert len(list(recording.messages("/ticks"))) == 2
    assert not recorder.writer.fault
    assert caplog.text.count("of topic 'ticks' of sk-ticks 0.3 was switched off: it raised KeyError: 'boom'") == 1
    assert "though this broke" in caplog.text


class Stubborn(GripperSpec):
    """A gripper whose kind has a mistake."""

    def joint_positions(self, state: Any) -> tuple[float, ...]:
        raise KeyError("boom")


def test_a_device_whose_kind_raises_is_no_longer_recorded_and_the_others_are(caplog: pytest.LogCaptureFixture) -> None:
    stubborn, gripper = (
        kind(name, (name,), "", 0.1, 20.0) for kind, name in ((Stubborn, "stubborn"), (GripperSpec, "gripper"))
    )
    devices = Devices(CellSpec((), (RobotSpec("robot", "", (stubborn, gripper)),)), GivenPorts())
    written: list[str] = []

    for cycle, gap in enumerate((0.0, 0.05)):
        states = {name: GripperState(gap, 0.0, True) for name in ("stubborn", "gripper")}
        devices.take(Snapshot(cycle, float(cycle), states), lambda topic, _time, _value: written.append(topic.name))

    assert written == ["/devices/gripper", "/joints", "/frames"] * 2
    assert caplog.text.count("/devices/stubborn is no longer recorded: its kind 'gripper' raised KeyError: 'boom'") == 1
