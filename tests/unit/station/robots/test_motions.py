"""The planned motions of devices: what planners answered, until it is done or given up."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from types import SimpleNamespace

import pytest

from skiros_py.api.robots import DeviceMotion
from skiros_py.devices.arm import ArmSpec, ArmState
from skiros_py.devices.mobile_base import BaseState
from skiros_py.execution.running import RunningModule
from skiros_py.execution.runtime import LibraryCall
from skiros_py.geometry import Pose
from skiros_py.station.robots.asked import Motions
from skiros_py.station.session import Options, Session

pytestmark = pytest.mark.physics
MOST_CYCLES = 4000


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    with Session("kitting", Options()) as opened:
        yield opened


@pytest.fixture
def motions(session: Session) -> Motions:
    noting = Motions()
    noting.open(session)
    return noting


def planned_for(device: str, session: Session, motions: Motions, running: RunningModule) -> DeviceMotion:
    """Steps until there is a motion for a device."""
    for _ in range(MOST_CYCLES):
        session.cycle.step()
        motion = motions.motion(session, device)
        if motion.poses or running.done:
            break
    return motion


def test_the_planned_path_of_an_arm_leads_from_its_current_to_its_final_tip_position(session, motions) -> None:
    before = session.cycle.board.snapshot
    wanted = [angle + 0.2 for angle in before.state("arm_1", ArmState).positions]
    deltas = (0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    running = session.start_module("jog_joints", {"arm": "arm_1", "deltas": deltas})
    way = [pose.position for pose in planned_for("arm_1", session, motions, running).poses]
    session.runtime.finish(running)

    assert session.cycle.board.snapshot.state("arm_1", ArmState).positions[0] == pytest.approx(wanted[0], abs=0.01)
    assert 2 <= len(way) <= 60
    axis = before.state("base_1", BaseState).pose @ Pose((0.22, 0.0, 0.0))
    radius = math.dist(way[0][:2], axis.position[:2])
    assert math.dist(way[0], way[-1]) == pytest.approx(radius * 0.2, rel=0.5)
    assert all(math.dist(a, b) < 0.05 for a, b in pairwise(way))


def test_a_planned_motion_is_removed_when_its_module_ends(session, motions) -> None:
    running = session.start_module("drive", {"Location": "pallet_a"})
    planned = planned_for("base_1", session, motions, running)
    assert planned.poses
    running.stop()
    session.runtime.finish(running)
    session.cycle.step()

    given_up = motions.motion(session, "base_1")
    assert given_up.poses == ()
    assert given_up.number == planned.number + 1


def test_the_planned_path_of_a_base_begins_at_its_pose_and_ends_with_its_final_yaw(session, motions) -> None:
    start = session.cycle.board.snapshot.state("base_1", BaseState).pose
    running = session.start_module("drive", {"Location": "pallet_a"})
    poses = planned_for("base_1", session, motions, running).poses
    session.runtime.finish(running)

    end = session.cycle.board.snapshot.state("base_1", BaseState).pose
    assert poses[0].position[:2] == pytest.approx(start.position[:2], abs=0.05)
    assert poses[-1].position[:2] == pytest.approx(end.position[:2], abs=0.05)
    assert Pose(poses[-1].position, poses[-1].orientation).yaw == pytest.approx(end.yaw, abs=0.05)
    assert motions.motion(session, "base_1").poses == ()


def test_the_number_of_planned_motions_kept_per_device_is_bounded(session, motions) -> None:
    for turn in (0.05, -0.05) * 6:
        deltas = (turn, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        session.run_module("jog_joints", {"arm": "arm_1", "deltas": deltas})
    assert 0 < motions.numbers()["arm_1"] <= 24


@pytest.mark.parametrize("answer", [None, (1, 2)])
def test_a_device_kind_without_planned_poses_has_an_empty_path(session, motions, monkeypatch, answer) -> None:
    monkeypatch.setattr(ArmSpec, "planned_poses", lambda *_: answer)
    running = session.start_module("jog_joints", {"arm": "arm_1", "deltas": (0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)})
    session.cycle.step()
    while not (motions.numbers()["arm_1"] or running.done):
        session.cycle.step()

    assert motions.numbers()["arm_1"]
    assert motions.motion(session, "arm_1").poses == ()
    session.runtime.finish(running)


def test_an_exception_in_an_adapter_does_not_hide_other_motions(session, motions) -> None:
    class Broken:
        def done(self) -> bool:
            raise ValueError("not ready, never was")

        def result(self) -> object:
            raise ValueError("nothing there")

    session.runtime.asked._listeners.notify(LibraryCall(SimpleNamespace(device="arm_1"), Broken()))

    assert motions.numbers()["arm_1"] == 0
    assert motions.motion(session, "arm_1").poses == ()
