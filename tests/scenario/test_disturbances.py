"""What goes wrong on the way: the robot has to notice with its own sensors, and the report has to tell the truth."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest

from skiros_py.devices.arm import ArmSpec, ArmState
from skiros_py.devices.gripper import GripperState
from skiros_py.devices.mobile_base import BaseState
from skiros_py.geometry import Pose, Primitive, Solid
from skiros_py.ports.cell import BodySpec
from skiros_py.simulation.truth import Truth

pytestmark = pytest.mark.physics

STARTER, ALTERNATOR = "ObjectAtLocation(Starter, kit_1_a)", "ObjectAtLocation(Alternator, kit_1_b)"
SCENES = Path(__file__).parents[2] / "scenes"


def holds(session, part):
    return session.world.related(part, "sk:heldBy", "gripper_1")


def by_condition(report):
    return {c.condition: c for c in report.conditions}


def test_a_part_knocked_out_of_the_gripper_is_noticed_and_the_remaining_goal_is_reached(open_session, when):
    session = open_session("kitting", seed=2)
    driving = lambda: holds(session, "starter_1") and session.world.placement("robot_1").place == "floor"  # noqa: E731
    when(session, driving, lambda: session.simulation.move_body("starter_1", Pose((2.0, 2.6, 0.0))))

    report = session.run([STARTER, ALTERNATOR])

    found = by_condition(report)
    assert (found[STARTER].believed, found[STARTER].true) == (False, False)
    assert (found[ALTERNATOR].believed, found[ALTERNATOR].true) == (True, True)
    assert session.world.placement("starter_1").place == "floor"
    assert any(change.author == "watch_grasp" for change in session.world.changes)
    assert found[STARTER].reason


def test_a_part_let_go_just_before_a_stop_is_found_by_the_next_order(open_session, when):
    session = open_session("kitting_carried", seed=2)
    let_go = lambda: session.world.placement("starter_1").relation == "sk:mayBeIn"  # noqa: E731
    when(session, let_go, session.stop)

    stopped = session.run([STARTER])
    report = session.run([STARTER])

    assert (stopped.stopped, stopped.reached) == (True, False)
    assert by_condition(report)[STARTER].true
    assert report.reached
    assert "search" in [step.skill for step in report.steps]


def test_a_removed_part_is_marked_missing_after_two_clear_looks_and_not_deleted(open_session, when):
    session = open_session("kitting_carried", seed=2)
    when(session, lambda: True, lambda: session.simulation.remove_body("starter_1"))

    report = session.run([STARTER, ALTERNATOR])

    found = by_condition(report)
    assert (found[STARTER].believed, found[STARTER].true) == (False, False)
    assert "not seen in 2 clear looks" in found[STARTER].reason
    assert (found[ALTERNATOR].believed, found[ALTERNATOR].true) == (True, True)
    assert session.world.value("starter_1", "sk:missing") is True
    assert session.world.placement("starter_1").place == "unknown_location"


def test_a_part_hidden_from_the_camera_is_not_found(open_session):
    session = open_session("kitting_carried", seed=4)
    there = Truth(session.simulation).pose("starter_1")
    session.simulation.add_body(hood(there.position))

    report = session.run([STARTER])

    found = by_condition(report)[STARTER]
    assert (found.believed, found.true) == (False, False)
    assert session.world.value("starter_1", "sk:pose") is None
    assert session.world.placement("starter_1").place == "pallet_a"
    assert "hides" in found.reason


def test_another_part_of_the_same_type_is_taken_when_the_first_is_gone(open_session, when, tmp_path):
    scene = tmp_path / "two_starters.ttl"
    text = (SCENES / "kitting_carried.ttl").read_text(encoding="utf-8")
    scene.write_text(text + "\nscene:starter_2 a kitting:Starter ; sk:in scene:pallet_b .\n", encoding="utf-8")
    session = open_session(str(scene), seed=5)
    when(session, lambda: True, lambda: session.simulation.remove_body("starter_1"))

    report = session.run([STARTER])

    assert report.reached
    assert session.world.related("starter_2", "sk:in", "kit_1_a")


def test_a_stop_leaves_arm_and_base_standing_still(open_session, when):
    session = open_session("kitting", seed=1)
    moving = lambda: abs(session.cycle.board.snapshot.state("base_1", BaseState).linear) > 0.3  # noqa: E731
    when(session, moving, session.stop)

    report = session.run()

    assert report.stopped
    assert not report.reached
    assert session.cycle.board.still


def test_after_a_stop_the_next_goal_is_reached_and_a_lost_part_is_still_noticed(open_session, when):
    session = open_session("kitting_carried", seed=1)
    moving = lambda: abs(session.cycle.board.snapshot.state("base_1", BaseState).linear) > 0.3  # noqa: E731
    when(session, moving, session.stop)
    assert session.run().stopped
    said: list[str] = []
    session.monitor.subscribe(lambda event: said.append(event.text))
    lifted = lambda: any(text.startswith("holds starter_1") for text in said)  # noqa: E731
    when(session, lifted, lambda: session.simulation.move_body("starter_1", Pose((2.0, 2.6, 0.0))))

    report = session.run(["Holding(gripper_1, starter_1)"])

    assert not report.reached
    assert session.world.placement("starter_1").place == "floor"


def hood(over: tuple[float, float, float]) -> BodySpec:
    """A box without bottom, 0.16 m high, that hides what is under it from every side."""
    side, wall, height = 0.17, 0.01, 0.16
    half = side / 2.0
    walls = [Primitive("box", (side, wall, height), Pose((0.0, y, height / 2.0))) for y in (-half, half)] + [
        Primitive("box", (wall, side, height), Pose((x, 0.0, height / 2.0))) for x in (-half, half)
    ]
    lid = Primitive("box", (side, side, wall), Pose((0.0, 0.0, height)))
    return BodySpec("hood", "test:Hood", Solid((*walls, lid)), pose=Pose(over))


def test_after_a_stop_in_the_middle_of_a_grasp_the_arm_is_stowed_before_the_base_is_on_its_way(open_session, when):
    session = open_session("kitting_carried", seed=6)
    home = session.spec.robots[0].of(ArmSpec)[0].home
    truth = Truth(session.simulation)

    def away():
        now = session.cycle.board.snapshot.state("arm_1", ArmState).positions
        return max(abs(is_ - wanted) for is_, wanted in zip(now, home, strict=True))

    events: list[str] = []
    session.monitor.subscribe(lambda e: events.append(f"{e.module} {e.text}"))
    when(session, lambda: "grasp approaching" in events and away() > 0.5, session.stop)
    assert session.run().stopped
    assert away() > 0.5
    session.cycle.observe(truth.watch)
    start, extended_at = truth.base_pose("base_1"), []

    def look():
        base = session.cycle.board.snapshot.state("base_1", BaseState)
        if abs(base.linear) > 0.05 and away() > 0.06:
            extended_at.append(truth.base_pose("base_1"))

    session.cycle.observe(look)

    report = session.run(["RobotAtLocation(robot_1, pallet_b)"])

    assert report.reached
    end = truth.base_pose("base_1")
    assert extended_at
    assert all(pose.distance(start) < 0.4 or pose.distance(end) < 0.25 for pose in extended_at)
    assert truth.worst == {}


def test_a_pick_cancelled_while_lifting_puts_the_part_back_instead_of_dropping_it(open_session):
    session = open_session("kitting_carried", seed=6)
    session.run(["RobotAtLocation(robot_1, pallet_a)"])
    truth, texts, heights = Truth(session.simulation), [], []
    session.monitor.subscribe(lambda event: texts.append(event.text))
    devices = {"Arm": "arm_1", "Gripper": "gripper_1", "Camera": "camera_1", "Robot": "robot_1"}
    running = session.managers["arm_1"].start("pick", {**devices, "Container": "pallet_a", "Object": "starter_1"})

    while not running.done:
        session.cycle.step()
        heights.append(truth.pose("starter_1").position[2])
        if "lifting" in texts and heights[-1] > 0.51:
            running.cancel("somebody wants it so")

    falls = [(before - after) / session.cell.period for before, after in pairwise(heights)]
    assert max(heights) > 0.51
    assert max(falls) < 0.5
    assert truth.placements()["starter_1"] == "pallet_a"
    assert session.cycle.board.snapshot.state("gripper_1", GripperState).gap > 0.075
