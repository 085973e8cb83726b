"""Replays from snapshots and changes to what is answered."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import pytest

from skiros_py.api.replays import Replay
from skiros_py.devices.arm import ArmState
from skiros_py.devices.base import BaseState
from skiros_py.devices.gripper import GripperState
from skiros_py.geometry import Pose
from skiros_py.ports.values import Snapshot
from skiros_py.server.replays.answer import replay_text
from skiros_py.server.replays.lines import Kind, add_lines, read_lines
from skiros_py.server.replays.recording import MOST_FRAMES, Beginning, Recording
from skiros_py.station.session import open_world
from skiros_py.world.world import World


@pytest.fixture
def world() -> World:
    return open_world("kitting")


def snapshot(time: float, angle: float = 0.0, *, gripper: bool = True) -> Snapshot:
    arm = ArmState((angle, 0.5), (0.0, 0.0), still=True)
    base = BaseState(Pose.of(1.0, 2.0, 0.0, yaw=0.5), 0.0, 0.0, still=True)
    devices = {"arm_1": arm, "base_1": base} | (
        {"gripper_1": GripperState(gap=0.08, force=0.0, still=True)} if gripper else {}
    )
    return Snapshot(round(time * 200), time, devices)


def begun(file: Path, world: World, time: float = 10.0, *, run: str = "first", gripper: bool = True) -> Recording:
    return Recording(file, Beginning("kit", 1, run, snapshot(time, gripper=gripper), world.snapshot()))


def told(file: Path, *, over: bool = True) -> Replay:
    return Replay.model_validate_json(replay_text(read_lines(file), over=over))


def test_a_recording_is_told_with_where_everything_was_and_what_changed(tmp_path: Path, world: World) -> None:
    recording = begun(tmp_path / "one", world)
    recording.frame(snapshot(10.1, 0.1))
    with world.transaction("pick", "it is in the gripper") as tx:
        tx.place("starter_1", "sk:heldBy", "gripper_1")
    assert tx.change is not None
    recording.change(tx.change, world.snapshot(), snapshot(10.15))
    recording.frame(snapshot(10.2, 0.2))
    recording.end(10.3)

    replay = told(tmp_path / "one")
    assert (replay.job, replay.start, replay.end, replay.complete, replay.shifts) == ("kit", 10.0, 10.3, True, ())
    assert replay.frames.times == pytest.approx((10.0, 10.1, 10.2))
    assert [row[0] for row in replay.frames.arms["arm_1"]] == pytest.approx([0.0, 0.1, 0.2])
    assert replay.frames.grippers == {"gripper_1": (0.08, 0.08, 0.08)}
    assert replay.frames.bases["base_1"][0] == pytest.approx((1.0, 2.0, 0.5))
    (change,) = replay.changes
    held = {element.id: element.held_by for element in change.view.elements}
    assert (change.author, change.anew, held["starter_1"]) == ("pick", False, "gripper_1")
    assert "starter_1" in {element.id for element in replay.beginning.elements}
    assert change.view.shapes == {}


def test_while_nothing_moves_only_the_last_moment_of_it_is_kept(tmp_path: Path, world: World) -> None:
    recording = begun(tmp_path / "one", world)
    for number in range(1, 1001):
        recording.frame(snapshot(10.0 + number / 10.0))
    recording.frame(snapshot(110.1, 0.1))
    recording.end(110.1)
    assert told(tmp_path / "one").frames.times == pytest.approx((10.0, 110.0, 110.1))


@pytest.mark.parametrize("moments", [MOST_FRAMES + 10, 4 * MOST_FRAMES])
def test_of_a_long_job_as_many_frames_are_told_evenly_and_the_file_stays_small(
    tmp_path: Path, world: World, moments: int
) -> None:
    recording = begun(tmp_path / "one", world)
    for number in range(1, moments):
        recording.frame(snapshot(10.0 + number / 10.0, number * 1e-3))
    recording.end(10.0 + moments / 10.0)

    times = told(tmp_path / "one").frames.times
    gaps = [after - before for before, after in pairwise(times)]
    assert MOST_FRAMES / 4 < len(times) <= MOST_FRAMES
    assert times[0] == pytest.approx(10.0)
    assert times[-1] == pytest.approx(10.0 + moments / 10.0, abs=2.0)
    assert max(gaps) < 4.0 * min(gaps)
    assert (tmp_path / "one").stat().st_size < 400_000


def test_what_was_cut_off_is_told_as_far_as_it_is_kept_and_not_complete(tmp_path: Path, world: World) -> None:
    recording = begun(tmp_path / "one", world)
    recording.frame(snapshot(10.1, 0.1))
    recording.flush()
    whole = (tmp_path / "one").read_bytes()
    (tmp_path / "one").write_bytes(whole[:-3])

    replay = told(tmp_path / "one")
    assert replay.frames.times == pytest.approx((10.0,))
    assert not replay.complete


def test_what_goes_on_after_a_restart_follows_in_time_with_the_world_anew(tmp_path: Path, world: World) -> None:
    begun(tmp_path / "one", world, 50.0).frame(snapshot(50.1, 0.1))
    again = begun(tmp_path / "one", world, 0.2, run="second", gripper=False)
    again.frame(snapshot(0.3, 0.3, gripper=False))
    again.end(0.4)

    replay = told(tmp_path / "one")
    ((since, by),) = replay.shifts
    assert since == pytest.approx(51.0)
    assert by == pytest.approx(50.8)
    assert replay.frames.times == pytest.approx((50.0, 51.0, 51.1))
    assert [change.anew for change in replay.changes] == [True]
    assert len(replay.frames.grippers["gripper_1"]) == 3
    assert replay.end == pytest.approx(51.2)
    assert not replay.complete


def test_shifts_are_told_where_they_change_also_back_to_none(tmp_path: Path, world: World) -> None:
    begun(tmp_path / "one", world, 50.0).end(60.0)
    begun(tmp_path / "one", world, 1.0, run="second").end(3.0)
    begun(tmp_path / "one", world, 5.0, run="second").end(6.0)
    begun(tmp_path / "one", world, 500.0, run="third").end(501.0)
    assert told(tmp_path / "one").shifts == ((61.0, 60.0), (500.0, 0.0))


def test_a_job_that_was_held_and_went_on_is_complete(tmp_path: Path, world: World) -> None:
    begun(tmp_path / "one", world, 10.0).end(11.0)
    begun(tmp_path / "one", world, 20.0).end(21.0)
    replay = told(tmp_path / "one")
    assert (replay.start, replay.end, replay.shifts, replay.complete) == (10.0, 21.0, (), True)
    assert not told(tmp_path / "one", over=False).complete


def test_a_change_that_nobody_sees_is_left_out_and_what_goes_is_told(tmp_path: Path, world: World) -> None:
    recording = begun(tmp_path / "one", world)
    with world.transaction("anna", "a goal") as tx:
        tx.set_goals(("InKit(Starter, kit_1)",))
    assert tx.change is not None
    recording.change(tx.change, world.snapshot(), snapshot(10.1))
    with world.transaction("anna", "broken") as tx:
        tx.remove("starter_1")
    assert tx.change is not None
    recording.change(tx.change, world.snapshot(), snapshot(10.2))
    recording.end(10.3)
    assert [change.view.gone for change in told(tmp_path / "one").changes] == [("starter_1",)]


def test_what_is_too_much_is_left_out_and_said(tmp_path: Path, world: World) -> None:
    begun(tmp_path / "one", world).end(10.1)
    add_lines(tmp_path / "one", [(Kind.FULL, b"")])
    assert not told(tmp_path / "one").complete


def test_a_file_without_a_beginning_is_refused() -> None:
    with pytest.raises(ValueError, match="no beginning"):
        replay_text([(Kind.END, json.dumps({"time": 1.0}).encode())], over=True)
