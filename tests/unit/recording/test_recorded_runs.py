"""What a record says of a run is what happened in it."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from skiros_py.devices.arm import ArmState
from skiros_py.errors import FileError
from skiros_py.ports.values import Done
from skiros_py.recording import Recorder, Recording, RecordingWriter
from skiros_py.recording.pictures import RunPictures, record_pictures
from skiros_py.recording.recorder import Devices
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.testing import Bench, tiny_world, world_of
from skiros_py.world.index import Index

GOAL = "In(Ball, slot_1)"
PICTURE = np.zeros((6, 8, 3), dtype=np.uint8)


def recording_of(bench: Bench, path: Path, *sources: Callable[[Recorder], None], **about: object) -> Recorder:
    def tasks(recorder: Recorder) -> None:
        recorder.on_end(bench.tasks.on_begin(recorder.follow))

    return Recorder(RecordingWriter(path), bench.runtime, about, (tasks, *sources))


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Bench, Path]]:
    path = tmp_path_factory.mktemp("runs") / "one.mcap"
    with Bench(tiny_world()) as bench:
        pictures = record_pictures(lambda _snapshot, _agent: Done(PICTURE))
        with recording_of(bench, path, pictures, scene="tiny") as recorder:
            recorder.conclude(bench.pursue(GOAL))
        yield bench, path


@pytest.fixture
def record(run: tuple[Bench, Path]) -> Iterator[Recording]:
    with Recording(run[1]) as record:
        yield record


def test_a_recording_contains_every_module_event_and_trace_entry(run: tuple[Bench, Path], record: Recording) -> None:
    bench, _ = run

    assert [(e["time"], e["module"], e["status"]) for e in record.events] == [
        (e.time, e.module, e.status.value) for e in bench.events
    ]
    assert [e["what"] for e in record.trace][:2] == ["begun", "planned"]
    assert record.trace[-1]["what"] == "finished"


def test_a_recording_contains_the_outcome_of_each_task(record: Recording) -> None:
    (task,) = record.tasks

    assert task["report"]["outcome"] == "reached"
    assert [c["believed"] for c in task["report"]["conditions"]] == [True]
    assert record.complete
    assert record.meta["scene"] == "tiny"


def test_states_of_devices_are_recorded_twenty_times_a_second_while_something_moves(
    run: tuple[Bench, Path], record: Recording
) -> None:
    bench, _ = run
    frames = list(record.frames())
    last = bench.cycle.board.snapshot

    assert all(after.time - before.time > 0.044 for before, after in pairwise(frames[:-1]))
    assert frames[-1].time == pytest.approx(last.time)
    assert {name: arm.positions for name, arm in last.of(ArmState).items()} == {
        name: pytest.approx(frames[-1].devices[name]["positions"], abs=1e-5) for name in last.of(ArmState)
    }
    assert record.frame(frames[-1].time) == frames[-1]
    assert record.frame(-1.0) == frames[0]


def test_the_recorded_world_at_any_time_is_the_world_model_of_that_time(
    run: tuple[Bench, Path], record: Recording
) -> None:
    bench, _ = run
    beginning = Index(bench.world.ontology)
    ball = next(p for p in bench.world.instances("tiny:Ball") if _place(bench.world.snapshot(), p) == "slot_1")
    seen = [_place(record.world_at(time, beginning), ball) for time in (0.0, float("inf"))]
    moved = [c.time for c in record.changes() if any(getattr(e, "element", "") == ball for e in c.edits)]

    assert seen[0] != "slot_1"
    assert seen[1] == "slot_1"
    assert _place(record.world_at(moved[-1] - 0.01, beginning), ball) != "slot_1"
    assert _place(record.world_at(moved[-1], beginning), ball) == "slot_1"


def test_a_picture_is_taken_at_the_end_of_a_skill_and_names_it(record: Recording) -> None:
    pictures = list(record.pictures())
    ends = [e["time"] for e in record.events if e["kind"] == "skill" and e["status"] == "terminated"]

    assert [picture.time for picture in pictures] == ends
    assert all(picture.data.startswith(b"RIFF") and picture.caption.endswith("done") for picture in pictures)


def test_recording_does_not_change_a_run(run: tuple[Bench, Path]) -> None:
    with Bench(tiny_world()) as bench:
        bench.pursue(GOAL)

    assert [str(event) for event in bench.events] == [str(event) for event in run[0].events]


def test_a_run_that_raises_leaves_a_recording_with_the_exception(tmp_path: Path) -> None:
    path = tmp_path / "broken.mcap"
    with Bench(tiny_world()) as bench:
        with pytest.raises(KeyError, match="gone"), recording_of(bench, path):
            {}["gone"]
        bench.cycle.step()  # it is recorded no longer

    with Recording(path) as record:
        assert record.complete
        assert record.meta["ended"]["fault"] == "KeyError: 'gone'"


def test_closed_recorders_leave_no_listeners_behind(tmp_path: Path) -> None:
    with Bench(tiny_world()) as bench:
        before = listeners(bench)
        for name in "ab":
            with recording_of(bench, tmp_path / name, record_pictures(lambda *_: Done(PICTURE))):
                assert listeners(bench) > before
        assert listeners(bench) == before


def listeners(bench: Bench) -> int:
    return len(bench.monitor._listeners) + len(bench.cycle._observers) + len(logging.getLogger("skiros_py").handlers)


def test_a_recording_is_never_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "one.mcap"
    path.write_text("mine")

    with Bench(tiny_world()) as bench, pytest.raises(FileError, match="there is a recording already"):
        recording_of(bench, path)
    assert path.read_text() == "mine"


def _place(index: Index, element: str) -> str:
    placement = index.placement(element)
    return "" if placement is None else placement.place


def test_a_source_or_picture_taker_that_raises_is_switched_off_by_name_and_the_run_goes_on(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    calls = []

    def broken_camera(_snapshot: object, _agent: str) -> Done:
        calls.append(_agent)
        raise IndexError("tuple index out of range")

    def broken_source(_recorder: Recorder) -> None:
        raise ZeroDivisionError("no time")

    with Bench(tiny_world()) as bench:
        pictures = RunPictures(bench.runtime, broken_camera, tmp_path / "run.gif")
        with recording_of(bench, tmp_path / "one.mcap", broken_source, record_pictures(broken_camera)):
            report = bench.pursue(GOAL)
        pictures.write()

    assert report.reached
    assert len(calls) == 2
    switched_off = [record.getMessage() for record in caplog.records if "is switched off" in record.getMessage()]
    assert [text for text in switched_off if "broken_source" in text and "ZeroDivisionError: no time" in text]
    assert [text for text in switched_off if "record_pictures" in text and "IndexError" in text]
    assert [text for text in switched_off if "--record" in text and "IndexError" in text]


def test_failing_kinematics_of_a_robot_do_not_affect_frames_of_other_robots(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class BrokenForOne:
        def find(self, _port: type, device: str) -> None:
            if device.endswith("_1"):
                raise IndexError("list index out of range")

    spec = read_cell(world_of("", robots=2), ["robot_1", "robot_2"])
    devices, written = Devices(spec, BrokenForOne()), {}
    devices.take(FakeCell(spec).read(), lambda topic, _time, value: written.update({topic.name: value}))

    assert {frame for _, frame, _ in written["/frames"]} >= {"base_2"}
    assert "base_1" not in {frame for _, frame, _ in written["/frames"]}
    assert "frames of robot_1 are no longer recorded: IndexError" in caplog.text
