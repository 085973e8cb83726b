"""What cannot be done ends as what it is: with a reason for a person, its kind as data, and the robot left safe."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from skiros_primitives.contact import believe_obstacle
from skiros_primitives.grasp import Grasp
from skiros_primitives.gripper import GripperControl, WatchGrasp
from skiros_primitives.put_down import PutDown
from skiros_primitives.registering import RegisterPart
from skiros_py.devices.arm import ArmSpec, ArmState
from skiros_py.devices.gripper import GripperState
from skiros_py.geometry import Pose
from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.motion.pinocchio.kinematics import kinematics_of
from skiros_py.ports.adapters import GivenPorts
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.kinematics import Dynamics, JointMotion, Kinematics
from skiros_py.ports.motion import ArmPlanner, MotionPlan, MotionRequest, NoMotion
from skiros_py.ports.perception import Detection, DetectionRequest, DetectionResult, PartDetector
from skiros_py.ports.values import CameraIntrinsics, Commands, DepthImage, Done, Pending, Snapshot
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.outcome import DEVICE_FAILED, Failure, Success
from skiros_py.skills.surroundings import map_pose
from skiros_py.testing import Bench, Blind, FaultyCell, Says, world_of
from skiros_py.world import vocabulary as v
from skiros_py.world.poses import write_pose
from skiros_skills import conditions
from skiros_skills.drive import DRIVE_FAKE
from skiros_skills.pick import PICK, PICK_FAKE
from skiros_skills.place import PLACE_FAKE

PART = Pose((0.72, 0.0, 0.5))
"""Within reach, where nothing stands."""
MODEL = kinematics_of("mobile_panda")
MODULES = (Grasp, PutDown, RegisterPart)
CAMERA = CameraIntrinsics(4, 4, 4.0, 4.0, 2.0, 2.0, 0.1, 4.0)


class Planner:
    """The planner of the arm, in this process."""

    spec: CellSpec

    def plan(self, request: MotionRequest) -> Pending[MotionPlan | NoMotion]:
        return Done(ArmMotion(self.spec.robots[0]).plan(request))


class Seer:
    """Sees the part where it is."""

    def detect(self, request: DetectionRequest) -> Pending[DetectionResult]:
        seen = Detection("kitting:Starter", PART, 0.0, 0.01, (0.1, 0.05, 0.06))
        return Done(DetectionResult(0.5, (seen,), 1.0))


class Seeing(FakeCell):
    """A fake that makes pictures."""

    def capture(self, camera: str) -> Pending[DepthImage]:
        depth, colour = np.zeros((4, 4), np.float32), np.zeros((4, 4, 3), np.uint8)
        return Done(DepthImage(self.read(), depth, colour, CAMERA), latency=0.1)


class Feeling(FakeCell):
    """A fake whose arm measures what its joints exert, until its sensors are unplugged.

    Args:
        spec: The cell.
        after: When that is [s].
        left: What is read then from each joint; None for nothing.
    """

    def __init__(self, spec: CellSpec, after: float, left: float | None) -> None:
        super().__init__(spec)
        self._after, self._left, self._before = after, left, np.zeros(7)
        self._joints = spec.robots[0].of(ArmSpec)[0].joints

    def read(self) -> Snapshot:
        return self._felt(super().read(), np.zeros(7))

    def exchange(self, commands: Commands) -> Snapshot:
        snapshot = super().exchange(commands)
        velocities = np.asarray(snapshot.state("arm_1", ArmState).velocities)
        accelerations, self._before = (velocities - self._before) / self.period, velocities
        return self._felt(snapshot, accelerations)

    def _felt(self, snapshot: Snapshot, accelerations: Any) -> Snapshot:
        state = snapshot.state("arm_1", ArmState)
        motion = JointMotion(self._joints, np.asarray(state.positions), np.asarray(state.velocities), accelerations)
        efforts = tuple(MODEL.efforts(motion).tolist())
        if snapshot.time >= self._after:
            efforts = () if self._left is None else (self._left,) * 7
        return replace(snapshot, devices={**snapshot.devices, "arm_1": replace(state, efforts=efforts)})


@contextmanager
def cell(driver: Callable[[CellSpec], CellDriver] = Seeing, **options: Any) -> Iterator[Bench]:
    """The kitting scene without physics, its arm planned for as in earnest."""
    world = world_of("kitting")
    with world.transaction("test", "made so") as tx:
        write_pose(tx, "starter_1", PART)
    planner = Planner()
    ports = GivenPorts({ArmPlanner: planner, Kinematics: MODEL, Dynamics: MODEL, PartDetector: Seer()})
    options = {"skills": (), "primitives": MODULES, "ports": ports, **options}

    def built(spec: CellSpec) -> CellDriver:
        planner.spec = spec
        return driver(spec)

    with Bench(world, cell=built, **options) as bench:
        yield bench


def arm(bench: Bench) -> tuple[float, ...]:
    return bench.context.board.snapshot.state("arm_1", ArmState).positions


def refused(outcome: object, cause: str, reason: str, *bodies: str) -> None:
    """Judges a failure by its kind, the bodies in the way, and a part of its reason."""
    assert isinstance(outcome, Failure), outcome
    assert reason in outcome.reason
    assert outcome.values == {"cause": cause} | ({"bodies": list(bodies)} if bodies else {})


def test_a_part_out_of_reach_is_refused_as_that_and_nothing_moves() -> None:
    with cell() as bench:
        with bench.world.transaction("test", "made so") as tx:
            write_pose(tx, "starter_1", Pose((4.0, 1.0, 0.5)))
        before = arm(bench)

        refused(bench.run("grasp", part="starter_1"), "reach", "starter_1 cannot be reached: ")

        assert arm(bench) == before


def test_a_compartment_that_something_stands_over_is_refused_with_its_name_and_the_part_stays_in_the_hand() -> None:
    with cell() as bench:
        with bench.world.transaction("test", "made so") as tx:
            tx.place("starter_1", v.HELD_BY, "gripper_1")
            write_pose(tx, "starter_1", Pose((0.0, 0.0, 0.032), (1.0, 0.0, 0.0, 0.0)), "gripper_1")
            write_pose(tx, "kit_1", Pose((0.75, 0.0, 0.5)))
        into = map_pose(bench.context, "kit_1_a")
        assert into is not None
        lid = believe_obstacle(bench.world, "test", into @ Pose((0.0, 0.0, 0.06)), (0.1, 0.1, 0.02), "seen")

        outcome = bench.run("put_down", part="starter_1", compartment="kit_1_a")

        refused(outcome, "collision", "kit_1_a cannot be reached: ", lid)
        assert isinstance(outcome, Failure)
        assert lid in outcome.reason
        assert bench.world.related("starter_1", v.HELD_BY, "gripper_1")


def test_an_arm_outside_its_limits_is_refused_with_the_joint_and_is_not_moved() -> None:
    with cell(lambda spec: FaultyCell(Seeing(spec), Says("arm_1", outside(spec)))) as bench:
        refused(bench.run("grasp", part="starter_1"), "limits", "panda_joint4 at 0.500 rad, outside its limits")


def outside(spec: CellSpec) -> ArmState:
    home = list(spec.robots[0].of(ArmSpec)[0].home)
    home[3] = 0.5
    return ArmState(tuple(home), (0.0,) * 7, True)


def test_a_gripper_that_closes_on_nothing_says_so_opens_and_the_part_has_to_be_looked_for() -> None:
    with cell() as bench:
        outcome = bench.run("grasp", part="starter_1")

        refused(outcome, "not grasped", "gap 0 mm, force 0 N, expected ")
        assert bench.world.value("starter_1", v.POSE) is None
        assert not bench.world.subjects(v.HELD_BY, "gripper_1")
        state = bench.context.board.snapshot.state("gripper_1", GripperState)
        assert state.gap == pytest.approx(0.08)
        joints = {f"panda_joint{number}": angle for number, angle in enumerate(arm(bench), start=1)}
        assert MODEL.pose("tcp", joints).position[2] > PART.position[2] + 0.12


def test_a_part_lost_while_driving_is_believed_on_the_floor_and_the_report_says_how_it_was_lost() -> None:
    closed = GripperState(0.0, 0.0, True)
    words = {one.name: one for one in vars(conditions).values() if isinstance(one, ConditionType)}
    options = {"skills": (DRIVE_FAKE, PICK_FAKE, PLACE_FAKE), "primitives": (WatchGrasp,), "conditions": words}
    with cell(lambda spec: FaultyCell(FakeCell(spec), Says("gripper_1", closed, after=12.0)), **options) as bench:
        bench.managers.watch()
        report = bench.pursue("ObjectAtLocation(starter_1, kit_1_a)")

        assert not report.reached
        assert [step.skill for step in report.steps][:2] == ["drive", "pick"]
        assert bench.world.placement("starter_1").place == "floor"
        assert "the fingers closed to 0 mm: starter_1 slipped out" in report.conditions[0].reason
        assert bench.cycle.board.still


@pytest.mark.parametrize("lost", [True, False])
def test_a_part_lost_while_a_pick_ends_is_not_believed_held_when_it_has_ended(lost: bool) -> None:
    words = {one.name: one for one in vars(conditions).values() if isinstance(one, ConditionType)}
    pick = replace(PICK_FAKE, post_sense=PICK.post_sense)
    options = {"skills": (DRIVE_FAKE, pick), "primitives": (GripperControl, WatchGrasp), "conditions": words}
    on_it = Says("gripper_1", GripperState(0.049, 15.0, True))
    with cell(lambda spec: FaultyCell(FakeCell(spec), *(() if lost else (on_it,))), **options) as bench:
        bench.managers.watch()
        with bench.world.transaction("test", "made so") as tx:
            tx.place("robot_1", v.AT, "pallet_a")

        outcome = bench.run("pick", Object="starter_1")

        assert isinstance(outcome, Failure if lost else Success)
        assert bench.world.related("starter_1", v.HELD_BY, "gripper_1") != lost


def test_a_camera_that_is_silent_for_a_second_is_asked_again() -> None:
    with cell(lambda spec: FaultyCell(Seeing(spec), Blind("camera_1", for_=3.0))) as bench:
        outcome = bench.run("register_part", part="starter_1")

        assert isinstance(outcome, Success), outcome
        assert bench.time > 3.0


def test_a_camera_that_stays_silent_ends_the_look_with_its_name_and_the_arm_stands() -> None:
    with cell(lambda spec: FaultyCell(Seeing(spec), Blind("camera_1"))) as bench:
        outcome = bench.run("register_part", part="starter_1")

        refused(outcome, "device", "camera 'camera_1' does not answer")
        assert isinstance(outcome, Failure)
        assert outcome.code == DEVICE_FAILED
        assert bench.cycle.board.still
        assert bench.world.value("starter_1", v.POSE) == PART


@pytest.mark.parametrize(("after", "left"), [(0.0, math.nan), (0.3, math.nan), (0.3, None)])
def test_an_arm_whose_force_sensors_are_unplugged_stands_at_once_and_says_why(after: float, left: float | None) -> None:
    with cell(lambda spec: Feeling(spec, after, left)) as bench:
        before = arm(bench)

        outcome = bench.run("grasp", part="starter_1")

        refused(outcome, "device", "arm_1 does not measure what its joints exert: it would feel no contact")
        assert bench.time == pytest.approx(after, abs=0.1)
        assert bench.cycle.board.still
        assert (arm(bench) == before) == (after == 0.0)
