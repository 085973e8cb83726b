"""Replays from snapshots and changes to the document that the page gets."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import pytest

from skiros_py.api.view import Replay
from skiros_py.devices.arm import ArmState
from skiros_py.devices.gripper import GripperState
from skiros_py.devices.localiser import LocaliserState
from skiros_py.devices.mobile_base import BaseState
from skiros_py.geometry import Pose
from skiros_py.ports.adapters import GivenPorts
from skiros_py.ports.values import Snapshot
from skiros_py.recording import Recording, RecordingWriter
from skiros_py.recording.recorder import Devices
from skiros_py.skills.cell_reader import read_cell
from skiros_py.station.recordings.replay import MOST_FRAMES, replay_text
from skiros_py.station.recordings.topics import Scene
from skiros_py.station.worlds import open_world
from skiros_py.world.change import Change
from skiros_py.world.world import World


@pytest.fixture
def world() -> World:
    return open_world("kitting")


def snapshot(time: float, angle: float = 0.0, *, gripper: bool = True) -> Snapshot:
    arm = ArmState((angle, *(0.5,) * 6), (0.0,) * 7, still=True)
    base = BaseState(Pose.of(1.0, 2.0, 0.0, yaw=0.5), 0.0, 0.0, still=True)
    grippers = {"gripper_1": GripperState(gap=0.08, force=0.0, still=True)} if gripper else {}
    localiser = LocaliserState(base.pose)
    return Snapshot(round(time * 200), time, {"arm_1": arm, "base_1": base, "localiser_1": localiser, **grippers})


def platforms(snapshot: Snapshot) -> dict[str, Pose]:
    return {"base_1": snapshot.state("base_1", BaseState).pose}


class Job:
    """Records a job as it is recorded while it runs."""

    def __init__(self, file: Path, world: World, time: float = 10.0, *, run: str = "first", gripper: bool = True):
        self.world = world
        self.writer = RecordingWriter(file, part={"run": run, "start": time})
        self.writer.put_metadata("run", {"job": "kit", "ended": None})
        self.devices, self.scene = (
            Devices(read_cell(world, ("robot_1",), simulated=False), GivenPorts()),
            Scene(platforms),
        )
        self.last = snapshot(time, gripper=gripper)
        self.frame(self.last)
        index = world.snapshot()
        self.writer.defer(lambda write: self.scene.begin(index, snapshot(time, gripper=gripper), write))

    def frame(self, snapshot: Snapshot) -> None:
        self.last = snapshot
        self.writer.defer(lambda write: self.devices.take(snapshot, write))
        while self.writer._queue.qsize() > 10_000:
            pass

    def change(self, change: Change | None, snapshot: Snapshot) -> None:
        assert change is not None
        index = self.world.snapshot()
        self.writer.defer(lambda write: self.scene.take(change, index, snapshot, write))

    def end(self, time: float, *, cut_off: bool = False) -> None:
        if not cut_off:
            last = Snapshot(0, time, self.last.devices)
            self.frame(last)
            self.writer.defer(self.devices.end)
            self.writer.put_metadata("run", {"ended": {"time": time}})
        self.writer.close()
        assert self.writer.fault == ""


def replayed(file: Path, *, over: bool = True, start: float = 0.0, end: float = math.inf) -> Replay:
    with Recording(file) as recording:
        return Replay.model_validate_json(replay_text(recording, over=over, start=start, end=end))


def test_a_replay_has_joints_frames_and_states_of_all_devices_and_the_visible_changes(
    tmp_path: Path, world: World
) -> None:
    job = Job(tmp_path / "one", world)
    job.frame(snapshot(10.1, 0.1))
    with world.transaction("pick", "it is in the gripper") as tx:
        tx.place("starter_1", "sk:heldBy", "gripper_1")
    job.change(tx.change, snapshot(10.15))
    job.frame(snapshot(10.2, 0.2))
    job.end(10.3)

    replay = replayed(tmp_path / "one")
    assert (replay.job, replay.start, replay.end, replay.complete, replay.shifts) == ("kit", 10.0, 10.3, True, ())
    assert replay.frames.times == pytest.approx((10.0, 10.1, 10.2, 10.3))
    assert replay.frames.joints["robot_1/panda_joint1"] == pytest.approx([0.0, 0.1, 0.2, 0.2])
    assert replay.frames.joints["robot_1/panda_finger_joint1"] == (0.04, 0.04, 0.04, 0.04)
    assert replay.frames.frames["base_1"][0] == pytest.approx(
        (1.0, 2.0, 0.0, 0.0, 0.0, math.sin(0.25), math.cos(0.25)), abs=1e-5
    )
    assert replay.frames.states["gripper_1"][0] == {"gap": 0.08, "force": 0.0, "still": True}
    (change,) = replay.changes
    held = {element.id: element.held_by for element in change.view.elements}
    assert (change.author, change.whole, held["starter_1"]) == ("pick", False, "gripper_1")
    assert "starter_1" in {element.id for element in replay.beginning.elements}
    assert change.view.shapes == {}


def test_a_range_begins_with_the_world_at_its_start_and_joins_its_neighbours(tmp_path: Path, world: World) -> None:
    job = Job(tmp_path / "one", world)
    for number in range(1, 101):
        job.frame(snapshot(10.0 + number / 10.0, number / 100.0))
        if number == 35:
            with world.transaction("pick", "it is in the gripper") as tx:
                tx.place("starter_1", "sk:heldBy", "gripper_1")
            job.change(tx.change, snapshot(13.55))
        if number == 65:
            with world.transaction("place", "it is broken") as tx:
                tx.remove("relay_box_1")
            job.change(tx.change, snapshot(16.55))
    job.end(20.1)

    whole = replayed(tmp_path / "one")
    first, second, third = (replayed(tmp_path / "one", start=at, end=at + 3.02) for at in (10.0, 14.02, 17.04))
    assert {(part.start, part.end, part.complete) for part in (first, second, third)} == {(10.0, 20.1, True)}
    assert first.beginning == whole.beginning
    assert [len(part.changes) for part in (whole, first, second, third)] == [2, 0, 1, 0]
    held = {element.id: element.held_by for element in second.beginning.elements}
    assert held["starter_1"] == "gripper_1"
    assert second.beginning.shapes == whole.beginning.shapes
    assert held.keys() - {element.id for element in third.beginning.elements} == {"relay_box_1"}
    assert second.frames.times == pytest.approx([14.0 + number / 10.0 for number in range(32)])
    angles = dict(zip(whole.frames.times, whole.frames.joints["robot_1/panda_joint1"], strict=True))
    assert second.frames.joints["robot_1/panda_joint1"] == tuple(angles[time] for time in second.frames.times)


def test_a_range_in_which_nothing_moves_has_the_frames_around_it(tmp_path: Path, world: World) -> None:
    job = Job(tmp_path / "one", world)
    for number in range(1, 1001):
        job.frame(snapshot(10.0 + number / 10.0))
    job.frame(snapshot(110.1, 0.1))
    job.end(110.1)
    assert replayed(tmp_path / "one", start=50.0, end=60.0).frames.times == pytest.approx((10.0, 110.0))


def test_only_the_last_frame_of_a_standstill_is_kept(tmp_path: Path, world: World) -> None:
    job = Job(tmp_path / "one", world)
    for number in range(1, 1001):
        job.frame(snapshot(10.0 + number / 10.0))
    job.frame(snapshot(110.1, 0.1))
    job.end(110.1)
    assert replayed(tmp_path / "one").frames.times == pytest.approx((10.0, 110.0, 110.1))


@pytest.mark.parametrize("moments", [MOST_FRAMES + 10, 3 * MOST_FRAMES])
def test_the_replay_of_a_long_job_has_evenly_spaced_frames_and_the_file_stays_small(
    tmp_path: Path, world: World, moments: int
) -> None:
    job = Job(tmp_path / "one", world)
    for number in range(1, moments):
        job.frame(snapshot(10.0 + number / 10.0, number * 1e-3))
    job.end(10.0 + moments / 10.0)

    times = replayed(tmp_path / "one").frames.times
    gaps = [after - before for before, after in pairwise(times)]
    assert MOST_FRAMES / 4 < len(times) <= MOST_FRAMES
    assert times[0] == pytest.approx(10.0)
    assert times[-1] == pytest.approx(10.0 + moments / 10.0, abs=2.0)
    assert max(gaps) < 4.0 * min(gaps)
    with Recording(tmp_path / "one") as recording:
        messages = sum(recording.topics.values())
    assert (tmp_path / "one").stat().st_size < 50_000 + 25 * messages


def test_the_replay_of_a_truncated_recording_has_the_readable_frames_and_is_incomplete(
    tmp_path: Path, world: World
) -> None:
    job = Job(tmp_path / "one", world)
    job.writer.defer(lambda _write: job.writer._file.flush())
    job.writer.defer(lambda _write: None)
    job.frame(snapshot(10.1, 0.1))
    job.end(10.2)
    whole = (tmp_path / "one").read_bytes()
    with Recording(tmp_path / "one") as recording:
        second = recording._reader.chunks[1]
    (tmp_path / "one").write_bytes(whole[: second.chunk_start_offset + second.chunk_length - 3])

    replay = replayed(tmp_path / "one")
    assert replay.frames.times == pytest.approx((10.0,))
    assert not replay.complete


def test_a_job_that_is_continued_after_a_restart_follows_in_time_with_the_whole_world(
    tmp_path: Path, world: World
) -> None:
    first = Job(tmp_path / "one", world, 50.0)
    first.frame(snapshot(50.1, 0.1))
    first.end(50.1, cut_off=True)
    second = Job(tmp_path / "one", world, 0.2, run="second", gripper=False)
    second.frame(snapshot(0.3, 0.3, gripper=False))
    second.end(0.4)

    replay = replayed(tmp_path / "one")
    ((since, by),) = replay.shifts
    assert since == pytest.approx(51.1)
    assert by == pytest.approx(50.9)
    assert replay.frames.times == pytest.approx((50.0, 50.1, 51.1, 51.2, 51.3))
    assert [change.whole for change in replay.changes] == [True]
    assert len(replay.frames.joints["robot_1/panda_finger_joint1"]) == 5
    assert replay.end == pytest.approx(51.3)
    assert not replay.complete
    before = replayed(tmp_path / "one", start=50.0, end=50.5)
    assert before.frames.times == pytest.approx((50.0, 50.1, 51.1))
    assert [change.whole for change in before.changes] == [True]  # or it would seem to move until 51.1


def test_shifts_are_listed_where_they_change_also_back_to_none(tmp_path: Path, world: World) -> None:
    for start, end, run in ((50.0, 60.0, "first"), (1.0, 3.0, "second"), (5.0, 6.0, "second"), (500.0, 501.0, "third")):
        Job(tmp_path / "one", world, start, run=run).end(end)
    assert replayed(tmp_path / "one").shifts == ((61.0, 60.0), (500.0, 0.0))


def test_the_replay_of_a_job_that_was_held_and_continued_is_complete(tmp_path: Path, world: World) -> None:
    Job(tmp_path / "one", world, 10.0).end(11.0)
    Job(tmp_path / "one", world, 20.0).end(21.0)
    replay = replayed(tmp_path / "one")
    assert (replay.start, replay.end, replay.shifts, replay.complete) == (10.0, 21.0, (), True)
    assert not replayed(tmp_path / "one", over=False).complete


def test_invisible_changes_are_left_out_and_removed_elements_are_listed(tmp_path: Path, world: World) -> None:
    job = Job(tmp_path / "one", world)
    with world.transaction("anna", "a goal") as tx:
        tx.set_goals(("InKit(Starter, kit_1)",))
    job.change(tx.change, snapshot(10.1))
    with world.transaction("anna", "broken") as tx:
        tx.remove("starter_1")
    job.change(tx.change, snapshot(10.2))
    job.end(10.3)
    assert [change.view.gone for change in replayed(tmp_path / "one").changes] == [("starter_1",)]


def test_the_replay_of_a_job_with_dropped_messages_is_incomplete(tmp_path: Path, world: World) -> None:
    job = Job(tmp_path / "one", world)
    job.writer.put_metadata("left out", {"/devices/arm_1": 3})
    job.end(10.1)
    assert not replayed(tmp_path / "one").complete


def test_a_file_without_a_beginning_is_refused(tmp_path: Path) -> None:
    RecordingWriter(tmp_path / "one").close()
    with pytest.raises(ValueError, match="no beginning"):
        replayed(tmp_path / "one")
