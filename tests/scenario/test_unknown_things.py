"""Things that no scene names: what a scanner sees is driven around, what an arm meets is felt at once; truth judges."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from skiros_primitives.contact import believe_obstacle
from skiros_py.devices.arm import ArmState
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.cell import BodySpec
from skiros_py.simulation.truth import Truth
from skiros_py.skills.outcome import Success
from skiros_py.station.session import Session
from skiros_py.world import vocabulary as v

pytestmark = pytest.mark.physics


def felt(session: Session, body: str) -> list[float]:
    """Collects the force with which the robot presses on a body, cycle by cycle [N]."""
    forces: list[float] = []
    truth = Truth(session.simulation)
    session.cycle.observe(
        lambda: forces.append(sum(contact.force for contact in truth.contacts() if contact.body == body))
    )
    return forces


@pytest.mark.parametrize(("x", "y", "size", "mass"), [(2.5, 1.45, 0.25, 0.0), (2.9, 1.5, 0.35, 8.0)])
def test_a_thing_in_the_way_is_seen_and_driven_around(
    open_session: Callable[..., Session], x: float, y: float, size: float, mass: float
) -> None:
    session = open_session("kitting", seed=1)
    crate = BodySpec("crate", "test:Crate", Solid.box(size, size, 0.5), pose=Pose((x, y, 0.0)), mass=mass)
    session.simulation.add_body(crate)
    forces = felt(session, "crate")

    report = session.run(["RobotAtLocation(robot_1, pallet_a)"])

    assert report.reached
    assert max(forces) == 0.0
    seen = [session.world.value(obstacle, v.POSE) for obstacle in session.world.instances(v.OBSTACLE)]
    assert seen
    assert all(isinstance(pose, Pose) and math.dist(pose.position[:2], (x, y)) < 0.5 for pose in seen)


def test_a_thing_that_stands_beside_a_part_is_seen_by_the_camera_and_not_touched(
    open_session: Callable[..., Session],
) -> None:
    session = open_session("kitting_carried", seed=1)
    x, y, z = Truth(session.simulation).pose("starter_1").position
    post = BodySpec("post", "test:Post", Solid.box(0.05, 0.05, 0.3), pose=Pose((x + 0.11, y + 0.05, z)), mass=0.0)
    session.simulation.add_body(post)
    forces = felt(session, "post")

    report = session.run(["Holding(gripper_1, starter_1)"])

    unknown = session.runtime.context.pictures.unknown["robot_1"]
    assert max(forces) == 0.0
    assert any(math.dist(one.pose.position[:2], (x + 0.11, y + 0.05)) < 0.05 for one in unknown)
    assert [one.believed for one in report.conditions] == [one.true for one in report.conditions]


def test_a_thing_in_the_way_of_an_arm_is_seen_before_it_moves_there_and_not_touched(
    open_session: Callable[..., Session],
) -> None:
    session = open_session("kitting", seed=1)
    assert session.run(["RobotAtLocation(robot_1, pallet_a)"]).reached
    wall = BodySpec("wall", "test:Wall", Solid.box(0.04, 0.3, 0.3), pose=Pose((4.74, 1.55, 0.45)), mass=0.0)
    session.simulation.add_body(wall)
    forces, texts = felt(session, "wall"), list[str]()
    session.monitor.subscribe(lambda event: texts.append(str(event.text)))

    report = session.run(["Holding(gripper_1, starter_1)"])
    home = session.run_module("move_arm", {"arm": "arm_1"})

    assert max(forces) == 0.0
    assert isinstance(home, Success)
    assert texts.index("unknown_seen") < texts.index("approaching")
    assert [one.believed for one in report.conditions] == [one.true for one in report.conditions]


def test_a_thing_that_appears_below_a_moving_arm_is_seen_by_its_camera_and_not_touched(
    open_session: Callable[..., Session], when: Callable[[Session, Callable[[], bool], Callable[[], None]], None]
) -> None:
    session = open_session("kitting", seed=3)
    assert session.run(["RobotAtLocation(robot_1, pallet_a)"]).reached
    bar = BodySpec("bar", "test:Bar", Solid.box(0.04, 0.6, 0.04), pose=Pose((4.86, 1.6, 0.60)), mass=0.0)
    texts: list[str] = []
    session.monitor.subscribe(lambda event: texts.append(f"{event.module} {event.text}"))
    when(session, lambda: "grasp approaching" in texts, lambda: session.simulation.add_body(bar))
    forces = felt(session, "bar")

    report = session.run(["Holding(gripper_1, starter_1)"])

    assert max(forces) == 0.0
    assert any("arm_1 stops on its way" in text for text in texts)
    assert [one.believed for one in report.conditions] == [one.true for one in report.conditions]


def test_a_thing_that_was_seen_and_taken_away_is_forgotten(open_session: Callable[..., Session]) -> None:
    session = open_session("kitting", seed=1)
    there = Pose((2.6, 1.5, 0.0))
    believe_obstacle(session.world, "test", there, (0.4, 0.4, 0.6), "seen before")

    report = session.run(["RobotAtLocation(robot_1, pallet_a)"])

    assert report.reached
    assert not session.world.instances(v.OBSTACLE)


@pytest.mark.parametrize("engine", ["pybullet", "mujoco"])
def test_a_base_that_meets_what_it_cannot_see_moves_back_and_says_so(
    open_session: Callable[..., Session], engine: str
) -> None:
    session = open_session("kitting", seed=1, simulation=engine)
    assert session.run(["RobotAtLocation(robot_1, pallet_a)"]).reached
    behind = Pose((4.22 - 0.525 - 0.12 - 0.15, 1.6, 0.0))
    session.simulation.add_body(BodySpec("box", "test:Box", Solid.box(0.3, 0.4, 0.5), pose=behind, mass=0.0))
    forces = felt(session, "box")

    report = session.run(["RobotAtLocation(robot_1, kit_1)"])

    held = [sum(forces[k : k + 100]) / 100.0 for k in range(len(forces) - 100)]
    assert max(forces) > 0.0
    assert max(np.convolve(forces, np.ones(2) / 2.0)) <= 280.0  # 10 ms mean: ISO/TS 15066, hand, transient
    assert max(held) <= 140.0
    assert sum(forces[-100:]) == 0.0
    assert session.world.instances(v.OBSTACLE)
    assert [one.believed for one in report.conditions] == [one.true for one in report.conditions]


def test_an_arm_that_meets_something_yields_at_once_and_says_so(
    open_session: Callable[..., Session], when: Callable[[Session, Callable[[], bool], Callable[[], None]], None]
) -> None:
    session = open_session("kitting", seed=3)
    assert session.run(["RobotAtLocation(robot_1, pallet_a)"]).reached
    bar = BodySpec("bar", "test:Bar", Solid.box(0.04, 0.6, 0.04), pose=Pose((4.86, 1.6, 0.78)), mass=0.0)
    texts: list[str] = []
    session.monitor.subscribe(lambda event: texts.append(f"{event.module} {event.text}"))
    when(session, lambda: "grasp approaching" in texts, lambda: session.simulation.add_body(bar))  # no look shows it
    forces = felt(session, "bar")

    report = session.run(["Holding(gripper_1, starter_1)"])

    pressed = np.array(forces)
    assert pressed.max() > 0.0
    assert ((pressed[1:] + pressed[:-1]) / 2.0).max() <= 280.0  # 10 ms mean: ISO/TS 15066, hand, transient
    assert pressed[-200:].mean() <= 140.0
    assert session.world.instances(v.OBSTACLE) or "grasp unknown_seen" in texts  # a picture from the side shows it
    assert [one.believed for one in report.conditions] == [one.true for one in report.conditions]


def test_an_arm_is_turned_aside_before_its_base_drives_to_where_it_would_reach_over_something(
    open_session: Callable[..., Session],
) -> None:
    session = open_session("kitting", seed=1)
    believe_obstacle(session.world, "test", Pose((4.75, 1.6, 0.85)), (0.2, 0.6, 0.3), "a shelf over the pallet")

    elsewhere = session.run_module("stow_arms", {"robot": "robot_1", "location": "kit_1"})
    home = session.cycle.board.snapshot.state("arm_1", ArmState).positions
    there = session.run_module("stow_arms", {"robot": "robot_1", "location": "pallet_a"})
    aside = session.cycle.board.snapshot.state("arm_1", ArmState).positions

    assert isinstance(elsewhere, Success)
    assert isinstance(there, Success)
    assert abs(abs(aside[0] - home[0]) - math.pi / 2.0) < 0.05
