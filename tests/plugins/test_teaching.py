from __future__ import annotations

from collections.abc import Iterator

import pytest

from skiros_primitives.teaching import TeachDrivingPose, TeachGrasp, TeachPlacingPose
from skiros_py.devices.gripper import Gripper, GripperTarget
from skiros_py.geometry import Pose
from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.skills.outcome import Failure, Success
from skiros_py.testing import Bench, tiny_world
from skiros_py.world.world import World

POSE = "^^sk:poseLiteral"
PLACE = f'scene:slot_1 sk:pose "2 1 0.5 0 0 1.5"{POSE} .'
CUBE = '[{"kind": "box", "size": [0.05, 0.05, 0.05]}]'
PRIMITIVES = (TeachDrivingPose, TeachGrasp, TeachPlacingPose)


def lessons(world: World) -> list[str]:
    return [name for name in world.abstracts("sk:TaughtPose") if name.startswith("learned:")]


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench(tiny_world(PLACE), primitives=PRIMITIVES) as made:
        with made.world.transaction("gripper", "feels it") as tx:
            held = tx.add("tiny:Ball", id="held", properties={"sk:solid": CUBE, "sk:pose": Pose.of(0, 0, 0.1, roll=3)})
            tx.place(held, "sk:heldBy", "gripper_1")
            tx.relate(held, "sk:poseFrame", "gripper_1")
        yield made


def test_the_base_pose_is_learned_for_the_class_of_the_place(bench: Bench) -> None:
    outcome = bench.run("teach_driving_pose", location="slot_1")

    assert isinstance(outcome, Success), outcome
    (lesson,) = lessons(bench.world)
    assert bench.world.element(lesson).label == "driving pose for Slot"
    learned = bench.world.value("slot_1", "sk:drivingPose")
    assert isinstance(learned, Pose)
    assert (Pose.of(2, 1, 0.5, yaw=1.5) @ learned).distance(Pose()) < 1e-9
    assert bench.world.value("slot_2", "sk:drivingPose") == learned


def test_a_person_may_choose_only_a_wider_class(bench: Bench) -> None:
    assert isinstance(bench.run("teach_driving_pose", location="slot_1", type="sk:Location"), Success)

    refused = bench.run("teach_driving_pose", location="slot_1", type="tiny:Box")

    assert isinstance(bench.world.value("floor", "sk:drivingPose"), Pose)
    assert isinstance(refused, Failure)
    assert refused.reason.startswith("type: slot_1 is no tiny:Box; teach it for one of tiny:Slot, sk:Container")
    assert len(lessons(bench.world)) == 1


def test_teaching_at_an_unknown_place_is_refused(bench: Bench) -> None:
    outcome = bench.run("teach_driving_pose", location="slot_2")

    assert outcome == Failure("the position of slot_2 is unknown")


def test_a_place_becomes_plannable_once_its_docking_pose_is_taught(bench: Bench) -> None:
    goal = "At(robot_1, slot_1)"
    before = bench.plan(goal).outcome

    bench.run("teach_driving_pose", location="slot_1")

    assert isinstance(before, NoPlan)
    assert isinstance(bench.plan(goal).outcome, Plan)


def test_a_held_part_teaches_its_grasp(bench: Bench) -> None:
    Gripper(bench.context.board, "gripper_1").command(GripperTarget(0.05, 5.0))
    bench.advance(0.1)

    outcome = bench.run("teach_grasp", part="held")

    assert isinstance(outcome, Success), outcome
    pose, width = (bench.world.value("ball_1", name) for name in ("sk:graspPose", "sk:graspWidth"))
    assert width == pytest.approx(0.05)
    assert isinstance(pose, Pose)
    assert (pose @ Pose.of(0, 0, 0.1, roll=3)).distance(Pose()) < 1e-9


def test_fully_open_fingers_teach_no_grasp(bench: Bench) -> None:
    outcome = bench.run("teach_grasp", part="held")

    assert outcome == Failure("gripper_1 is wide open: close it on held")
    assert lessons(bench.world) == []


def test_a_part_seen_in_a_container_teaches_its_placement(bench: Bench) -> None:
    with bench.world.transaction("camera", "seen") as tx:
        tx.set("ball_1", "sk:pose", Pose.of(2, 1, 0.51, yaw=1.6))

    outcome = bench.run("teach_placing_pose", part="ball_1", container="slot_1")

    assert isinstance(outcome, Success), outcome
    learned = bench.world.value("slot_2", "sk:placingPose")
    assert isinstance(learned, Pose)
    assert learned.position == pytest.approx((0.0, 0.0, 0.01))
    assert learned.yaw == pytest.approx(0.1)
