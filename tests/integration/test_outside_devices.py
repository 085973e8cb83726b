"""Kinds of device of a foreign distribution: planned with, commanded, encoded, faulted without a line in the core."""

from __future__ import annotations

import json
import math
import re
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from integration.test_rest_replays import api, awaited, written
from mcap.reader import make_reader
from support.serving import serving

from skiros_py.api.modules import ModuleRunInfo
from skiros_py.api.view import Replay
from skiros_py.client import Client, ProblemError
from skiros_py.errors import DeviceError
from skiros_py.execution.runtime import LibraryMonitor
from skiros_py.geometry import Pose
from skiros_py.planning.plan import Plan
from skiros_py.ports.adapters import GivenPorts
from skiros_py.ports.board import DeviceBoard, DeviceHandle
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.device import MobileSpec
from skiros_py.ports.device_kinds import load_device_kinds
from skiros_py.ports.perception import DetectionRequest, DetectionResult, PartDetector, Region
from skiros_py.ports.values import CameraIntrinsics, DepthImage, Done, Snapshot
from skiros_py.recording import Recording, RecordingWriter
from skiros_py.simulation.cell import SimulatedCell
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.skills.conditions import Expression
from skiros_py.skills.outcome import Success
from skiros_py.skills.surroundings import map_pose, obstacles, write_seen
from skiros_py.station.recordings.replay import replay_text
from skiros_py.station.recordings.runs import recorder_of
from skiros_py.station.recordings.topics import camera_of
from skiros_py.station.robots.asked import Motions, Observations
from skiros_py.station.session import Options, Session
from skiros_py.station.world.view import view_of
from skiros_py.testing import TINY_ONTOLOGY, Bench, Deaf, FaultyCell, Frozen, Noisy, robot_turtle, world_of
from skiros_py.world.world import World

ONTOLOGY = """
@prefix lab: <https://example.org/lab#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
<https://example.org/lab> a owl:Ontology ; rdfs:label "lab" ; rdfs:comment "Devices of a lab." ;
    owl:imports <https://w3id.org/skiros-py/core> .
lab:Wrench a owl:Class ; rdfs:subClassOf sk:Device ; rdfs:label "wrench sensor" ; rdfs:comment "Feels forces." .
lab:Turntable a owl:Class ; rdfs:subClassOf sk:Device ; rdfs:label "turntable" ; rdfs:comment "Turns what it carries." .
lab:Omni a owl:Class ; rdfs:subClassOf sk:Base ; rdfs:label "omni base" ; rdfs:comment "Drives to any side." .
lab:Hand a owl:Class ; rdfs:subClassOf sk:Gripper ; rdfs:label "hand" ; rdfs:comment "Has three fingers." .
"""

DEVICES = '''
import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from skiros_py.devices.mobile_base import BaseSpec
from skiros_py.geometry import Pose
from skiros_py.ports.device import DeviceSignal, DeviceSpec, MobileSpec, read_mobile, require_numbers
from skiros_py.ports.paths import PosePath


@dataclass(frozen=True)
class WrenchState:
    force: tuple[float, float, float]
    torque: tuple[float, float, float]


@dataclass(frozen=True)
class Wrench(DeviceSpec[WrenchState, None]):
    """A force-torque sensor in a joint of its robot."""

    kind: ClassVar[str] = "wrench"
    device_class: ClassVar[str] = "lab:Wrench"
    state_type: ClassVar[type] = WrenchState
    signals: ClassVar[Any] = (
        DeviceSignal("force", lambda s: s.force, "N", "force", "own"),
        DeviceSignal("pull", lambda s: math.hypot(*s.force), "N", "size of the force"),
    )
    joint: str = ""

    @classmethod
    def read(cls, individual):
        return cls(individual.id, individual.text("sk:joints"))

    def fake(self, robot):
        return Feeling(None)

    def simulate(self, robot, rng):
        return Feeling(robot.joints((self.joint,)))

    def noisy(self, state, sigma, rng):
        return replace(state, force=tuple(f + e for f, e in zip(state.force, rng.normal(0.0, sigma, 3).tolist())))


class Feeling:
    braking_time = 0.0

    def __init__(self, joints):
        self.joints = joints

    def command(self, target):
        pass

    def state(self):
        if self.joints is None:
            return WrenchState((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        (wrench,) = self.joints.reactions()
        return WrenchState(wrench.force, wrench.torque)


@dataclass(frozen=True)
class TableState:
    angle: float
    speed: float


@dataclass(frozen=True)
class TableTarget:
    speed: float


@dataclass(frozen=True)
class Turntable(DeviceSpec[TableState, TableTarget]):
    kind: ClassVar[str] = "turntable"
    device_class: ClassVar[str] = "lab:Turntable"
    state_type: ClassVar[type] = TableState
    target_type: ClassVar[type] = TableTarget
    carries: ClassVar[bool] = True
    jog: ClassVar[tuple[str, ...]] = ("turn",)
    signals: ClassVar[Any] = (DeviceSignal("angle", lambda s: s.angle, "rad", "how far it is turned"),)
    joint_names = ("turn",)
    platform_link = "plate"

    def joint_positions(self, state):
        return (state.angle,)

    def simulate(self, robot, rng):
        return TurningJoint(robot)

    @classmethod
    def read(cls, individual):
        return cls(individual.id)

    def fake(self, robot):
        return Turning(robot.period)

    def still(self, state):
        return state.speed == 0.0

    def check(self, target):
        DeviceSpec.check(self, target)
        require_numbers(self.id, target, (target.speed,))

    def scaled(self, target, rate):
        return TableTarget(target.speed * rate)

    def mixed(self, contributions):
        total = sum(one.weight for one in contributions)
        return TableTarget(sum(one.weight * one.target.speed for one in contributions) / total)

    def platform(self, state):
        return Pose.of(0.0, 0.0, 0.5, yaw=state.angle) if self.id == "table_1" else None


class TurningJoint:
    braking_time = 0.1

    def __init__(self, robot):
        self.joints = robot.joints(("turn",))

    def command(self, target):
        self.joints.drive_velocities((0.0 if target is None else target.speed,), effort=100.0)

    def state(self):
        read = self.joints.read()
        return TableState(read.positions[0], round(read.velocities[0], 3))


class Turning:
    braking_time = 0.0

    def __init__(self, period):
        self.period, self.now = period, TableState(0.0, 0.0)

    def command(self, target):
        speed = 0.0 if target is None else target.speed
        self.now = TableState(self.now.angle + speed * self.period, speed)

    def state(self):
        return self.now


@dataclass(frozen=True)
class OmniState:
    pose: Pose
    x: float
    y: float
    angular: float


@dataclass(frozen=True)
class OmniTwist:
    x: float
    y: float
    angular: float


@dataclass(frozen=True)
class Omni(MobileSpec[OmniState, OmniTwist]):
    kind: ClassVar[str] = "omni"
    device_class: ClassVar[str] = "lab:Omni"
    state_type: ClassVar[type] = OmniState
    target_type: ClassVar[type] = OmniTwist
    jog: ClassVar[tuple[str, ...]] = ("jog_base",)
    teach: ClassVar[tuple[str, ...]] = ("teach_driving_pose",)

    @classmethod
    def read(cls, individual):
        return cls(individual.id, *read_mobile(individual))

    def pose(self, state):
        return state.pose

    def still(self, state):
        return not (state.x or state.y or state.angular)

    def direct_path(self, start, goal):
        return PosePath((goal,))

    def follow(self, path, pose, *, max_linear=math.inf, max_angular=math.inf):
        linear, angular = min(max_linear, 0.8), min(max_angular, 1.0)
        for driven, there in path.poses(pose(), way=0.1):
            while True:
                away = pose().inverse() @ there
                x, y, _ = away.position
                distance, turn = math.hypot(x, y), away.yaw
                if distance < 0.005 and abs(turn) < 0.005:
                    break
                speed = min(linear, 8.0 * distance)
                along = speed / distance if distance else 0.0
                yield driven, OmniTwist(along * x, along * y, max(-angular, min(angular, 8.0 * turn)))
        return True

    def fake(self, robot):
        return Rolling(self.start, robot.period)

    def simulate(self, robot, rng):
        return Sliding(self.start, robot)


class Sliding:
    braking_time = 0.1

    def __init__(self, start, robot):
        self.joints = robot.joints(("base_x", "base_y", "base_yaw"))
        self.joints.reset((*start.position[:2], start.yaw))
        self.now = OmniTwist(0.0, 0.0, 0.0)

    def command(self, target):
        self.now = target or OmniTwist(0.0, 0.0, 0.0)
        yaw = self.joints.read().positions[2]
        x, y = self.now.x, self.now.y
        along = (x * math.cos(yaw) - y * math.sin(yaw), x * math.sin(yaw) + y * math.cos(yaw), self.now.angular)
        self.joints.drive_velocities(along, effort=2000.0)

    def state(self):
        x, y, yaw = self.joints.read().positions
        return OmniState(Pose.of(x, y, 0.0, yaw=yaw), self.now.x, self.now.y, self.now.angular)


class Rolling:
    braking_time = 0.0

    def __init__(self, start, period):
        self.period, self.now = period, OmniState(start, 0.0, 0.0, 0.0)

    def command(self, target):
        x, y, turn = (0.0, 0.0, 0.0) if target is None else (target.x, target.y, target.angular)
        step = Pose.of(x * self.period, y * self.period, 0.0, yaw=turn * self.period)
        self.now = OmniState(self.now.pose @ step, x, y, turn)

    def state(self):
        return self.now


@dataclass(frozen=True)
class HandState:
    fingers: tuple[float, ...]


@dataclass(frozen=True)
class HandTarget:
    fingers: tuple[float, ...]


@dataclass(frozen=True)
class Hand(DeviceSpec[HandState, HandTarget]):
    kind: ClassVar[str] = "three-finger gripper"
    device_class: ClassVar[str] = "lab:Hand"
    state_type: ClassVar[type] = HandState
    target_type: ClassVar[type] = HandTarget
    joints: tuple[str, ...] = ()

    @classmethod
    def read(cls, individual):
        return cls(individual.id, tuple(individual.text("sk:joints").split()))

    @property
    def joint_names(self):
        return self.joints

    def joint_positions(self, state):
        return state.fingers

    def fake(self, robot):
        return Closing(len(self.joints))

    def simulate(self, robot, rng):
        return Fingers(robot.joints(self.joints))


class Fingers:
    braking_time = 0.0

    def __init__(self, joints):
        self.joints, self.wanted = joints, (0.0,) * len(joints.names)

    def command(self, target):
        self.wanted = self.wanted if target is None else target.fingers
        self.joints.hold_positions(self.wanted, gain=0.2, effort=[20.0] * len(self.wanted), max_velocity=1.0)

    def state(self):
        return HandState(self.joints.read().positions)


class Closing:
    braking_time = 0.0

    def __init__(self, count):
        self.now = HandState((0.0,) * count)

    def command(self, target):
        self.now = self.now if target is None else HandState(target.fingers)

    def state(self):
        return self.now
'''

SCENE = """
scene:robot_1 a sk:Robot ; sk:model "tiny" ; sk:at scene:unknown_location ; sk:hasA scene:base_1 , scene:arm_1 .
scene:base_1 a lab:Omni ; sk:pose "0 0 0 0 0 0"^^sk:poseLiteral ;
    sk:footprint "-0.3 -0.3 0.3 -0.3 0.3 0.3 -0.3 0.3"^^sk:vectorLiteral .
scene:arm_1 a sk:Arm ; sk:joints "shoulder elbow" ; sk:tip "tip" ; sk:home "0 0"^^sk:vectorLiteral ;
    sk:hasA scene:hand_1 , scene:wrench_1 .
scene:hand_1 a lab:Hand ; sk:joints "a b c" .
scene:wrench_1 a lab:Wrench ; sk:joints "wrist" .
scene:table_1 a lab:Turntable ; sk:pose "2 0 0 0 0 0"^^sk:poseLiteral ; sk:on scene:floor ;
    sk:solid '[{"kind": "cylinder", "size": [0.6, 0.05], "at": [0, 0, -0.025]}]'^^rdf:JSON .
scene:eye_1 a sk:Camera ; sk:pose "0 0 2 3.14159265 0 0"^^sk:poseLiteral ; sk:on scene:floor ; sk:width 64 ;
    sk:height 48 ; sk:verticalFov 0.9 ; sk:minDepth 0.05 ; sk:maxDepth 5.0 ; sk:depthNoise 0.001 ; sk:latency 0.1 .
scene:box_a a tiny:Box ; sk:on scene:floor ; sk:pose "3 3 0 0 0 0"^^sk:poseLiteral .
scene:ball_2 a tiny:Ball ; sk:on scene:floor ; sk:mass 0.1 ; sk:pose "1 1 0 0 0 0"^^sk:poseLiteral .
scene:ball_1 a tiny:Ball ; sk:on scene:floor ; sk:mass 0.1 ; sk:pose "0.5 0 0 0 0 0"^^sk:poseLiteral ;
    sk:poseFrame scene:table_1 .
"""


def install_devices(site: Any) -> None:
    """Installs the kinds of device."""
    names = {"wrench": "Wrench", "turntable": "Turntable", "omni": "Omni", "hand": "Hand"}
    site.install(
        "lab-devices", {"devices": {n: f"lab_devices:{c}" for n, c in names.items()}}, {"lab_devices.py": DEVICES}
    )


@pytest.fixture
def lab(site, tmp_path: Path) -> Path:
    """The distribution, installed; returns its ontology."""
    install_devices(site)
    file = tmp_path / "lab.ttl"
    file.write_text(ONTOLOGY, encoding="utf-8")
    return file


@pytest.fixture
def world(lab: Path) -> World:
    return world_of(SCENE, ontologies=(TINY_ONTOLOGY, lab), robots=0)


def spec_of(world: World) -> CellSpec:
    return read_cell(world, ["robot_1"], simulated=False)


def test_each_device_individual_is_read_by_the_kind_with_the_most_specific_class(world: World) -> None:
    kinds, faults = load_device_kinds()
    devices = {id_: device.kind for id_, device in spec_of(world).devices.items()}

    assert {"arm", "base", "camera", "gripper", "wrench", "turntable", "omni"} <= set(kinds.by_name)
    assert not [fault for fault in faults if fault.distribution.startswith("lab-devices")]
    assert devices == {
        "base_1": "omni",
        "arm_1": "arm",
        "hand_1": "three-finger gripper",
        "wrench_1": "wrench",
        "table_1": "turntable",
        "eye_1": "camera",
    }


def test_a_device_kind_whose_ontology_is_not_loaded_is_ignored(lab: Path) -> None:
    world = world_of("", ontologies=(TINY_ONTOLOGY,))

    assert [device.kind for device in read_cell(world, ["robot_1"]).devices.values()] == ["arm", "gripper", "base"]


def test_a_device_without_a_robot_is_part_of_the_cell(world: World) -> None:
    spec = spec_of(world)

    assert [group.id for group in spec.robots] == ["robot_1"]
    assert {group.id: group.place.position for group in spec.single} == {
        "table_1": (2.0, 0.0, 0.0),
        "eye_1": (0.0, 0.0, 2.0),
    }


def test_a_robot_with_plug_in_devices_is_planned_with_and_reaches_its_goal(world: World) -> None:
    with Bench(world, robots=["robot_1"]) as bench:
        report = bench.pursue("At(robot_1, box_a)")

    assert report.reached


def test_plug_in_devices_move_on_command_and_stop_on_request(world: World) -> None:
    lab = pytest.importorskip("lab_devices")
    with Bench(world, robots=["robot_1"]) as bench:
        board = bench.context.board
        base, hand = DeviceHandle(board, "base_1"), DeviceHandle(board, "hand_1")
        for _ in range(200):
            base.command(lab.OmniTwist(0.0, 0.5, 0.0))
            hand.command(lab.HandTarget((0.1, 0.2, 0.3)))
            bench.cycle.step()
        moving = board.still
        bench.cycle.stop_all()

        assert base.state.pose.position == pytest.approx((0.0, 0.5, 0.0), abs=0.01)
        assert hand.state.fingers == (0.1, 0.2, 0.3)
        assert (moving, board.still) == (False, True)
        with pytest.raises(DeviceError, match="no commands"):
            DeviceHandle(board, "wrench_1").command(lab.OmniTwist(0.0, 0.0, 0.0))


def test_a_body_on_a_turntable_moves_with_it_also_one_that_was_seen_there(world: World) -> None:
    lab = pytest.importorskip("lab_devices")
    with Bench(world, robots=["robot_1"]) as bench:
        table = DeviceHandle(bench.context.board, "table_1")
        with world.transaction(author="test", reason="test") as tx:
            write_seen(bench.context, tx, "ball_2", Pose.of(1.5, 0.0, 0.5), "table_1")
            write_seen(bench.context, tx, "box_a", Pose.of(3.0, 3.0, 0.0), "floor")
        before = map_pose(bench.context, "ball_1")
        for _ in range(200):
            table.command(lab.TableTarget(math.pi / 2.0))
            bench.cycle.step()
        after, seen, still = (map_pose(bench.context, one) for one in ("ball_1", "ball_2", "box_a"))

    assert seen.position == pytest.approx((2.0, -0.5, 0.5), abs=0.01)
    assert still.position == (3.0, 3.0, 0.0)
    assert before.position == pytest.approx((2.5, 0.0, 0.5), abs=1e-6)
    assert after.position == pytest.approx((2.0, 0.5, 0.5), abs=0.01)


def test_arms_keep_away_from_a_device_without_a_robot_that_has_a_shape(world: World) -> None:
    with Bench(world, robots=["robot_1"]) as bench:
        around = {one.id: one.pose.position for one in obstacles(bench.context, parts=False)}

    assert around["table_1"] == pytest.approx((2.0, 0.0, 0.5))
    assert not {"arm_1", "hand_1", "eye_1"} & around.keys()


def test_states_and_targets_survive_a_round_trip_through_json(world: World) -> None:
    lab = pytest.importorskip("lab_devices")
    spec = spec_of(world)
    snapshot = FakeCell(spec).read()

    for id_, state in snapshot.devices.items():
        device = spec.devices[id_]
        assert device.decode_state(json.loads(json.dumps(device.encode(state)))) == state
    target = lab.TableTarget(0.5)
    assert spec.devices["table_1"].decode_target(spec.devices["table_1"].encode(target)) == target
    with pytest.raises(DeviceError, match="table_1: no target of kind 'turntable'"):
        spec.devices["table_1"].decode_target({"sped": 0.5})


def test_foreign_devices_are_faulted_like_any_other(world: World) -> None:
    lab = pytest.importorskip("lab_devices")
    cell = FaultyCell(FakeCell(spec_of(world)), Deaf("base_1"), Frozen("table_1"), Noisy("wrench_1", 1.0))

    now = cell.exchange({"base_1": lab.OmniTwist(1.0, 0.0, 0.0), "table_1": lab.TableTarget(1.0)})

    assert now.devices["base_1"].pose == Pose()
    assert now.devices["table_1"].angle == 0.0
    assert any(now.devices["wrench_1"].force)


def test_values_of_plug_in_devices_are_available_to_conditions_and_users(world: World) -> None:
    with Bench(world, robots=["robot_1"]) as bench:
        verdict = Expression("device.pull < 1.0").evaluate(bench.world, {"device": "wrench_1"})
        offered = [signal.name for signal in bench.context.board.devices["wrench_1"].signals]

    assert verdict
    assert offered == ["force", "pull"]


def test_the_rate_of_a_paused_run_slows_foreign_speeds_down(world: World) -> None:
    lab = pytest.importorskip("lab_devices")
    board = DeviceBoard(FakeCell(spec_of(world)))

    class Paused:
        devices = None
        rate = 0.5

    board.owner = Paused()
    DeviceHandle(board, "table_1").command(lab.TableTarget(1.0))

    assert board.exchange().devices["table_1"].speed == 0.5


def test_a_robot_without_a_base_stands_at_its_declared_pose(lab: Path) -> None:
    scene = """
        scene:robot_1 a sk:Robot ; sk:model "tiny" ; sk:at scene:unknown_location ; sk:hasA scene:arm_1 ;
            sk:pose "1 2 0 0 0 0"^^sk:poseLiteral ; sk:footprint "0 0 1 0 1 1"^^sk:vectorLiteral .
        scene:arm_1 a sk:Arm ; sk:joints "shoulder" ; sk:tip "tip" ; sk:home "0"^^sk:vectorLiteral .
    """
    world = world_of(scene, ontologies=(TINY_ONTOLOGY, lab), robots=0)
    with Bench(world) as bench:
        (robot,) = bench.context.cell.robots
        bench.advance(0.1)

        assert robot.carrier is None
        assert robot.pose(bench.cycle.board.snapshot, bench.cycle.board.guard) == Pose((1.0, 2.0, 0.0))
        assert robot.outline == ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0))
        assert not isinstance(robot.devices[0], MobileSpec)


def test_in_physics_a_wrist_sensor_measures_weight_and_a_camera_without_a_robot_sees(lab: Path) -> None:
    scene = """
        scene:wrench_1 a lab:Wrench ; sk:joints "panda_joint7" .
        scene:robot_1 sk:hasA scene:wrench_1 .
        scene:base_1 sk:pose "0 0 0 0 0 0"^^sk:poseLiteral .
        scene:eye_1 a sk:Camera ; sk:pose "0 2 2 3.14159265 0 0"^^sk:poseLiteral ; sk:on scene:floor ; sk:width 64 ;
            sk:height 48 ; sk:verticalFov 0.9 ; sk:minDepth 0.05 ; sk:maxDepth 5.0 ; sk:depthNoise 0.001 ;
            sk:latency 0.1 .
    """
    robot = "https://w3id.org/skiros-py/robots/mobile_panda"
    cell = SimulatedCell(read_cell(world_of(scene, ontologies=(lab,), imports=(robot,)), ["robot_1"]), seed=1)
    try:
        for _ in range(100):
            snapshot = cell.exchange({})
        image = cell.capture("eye_1").result()
    finally:
        cell.close()

    assert 5.0 < math.hypot(*snapshot.devices["wrench_1"].force) < 50.0
    assert image.depth[24, 32] == pytest.approx(2.0, abs=0.02)


# ---------------------------------------------------------------------- the same kinds in a session, on two engines

LINK = """<link name="{0}"><inertial><mass value="{1}"/>
    <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial></link>"""
BOX = '<visual><geometry><box size="0.3 0.3 0.1"/></geometry></visual>'
JOINT = """<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><origin xyz="{4}"/><axis xyz="{5}"/>
    <limit lower="-9" upper="9" effort="3000" velocity="3"/></joint>"""
FINGERS = [(f"{name}", "revolute", "palm", f"finger_{name}", f"0.05 0.0{number} 0", "0 1 0")
           for number, name in enumerate("abc")]  # fmt: skip
URDFS = {
    "carrier": (
        (("map", 0), ("x", 1), ("y", 1), ("base_link", 30), ("mast", 5), ("palm", 2), *((f[3], 0.1) for f in FINGERS)),
        (
            ("base_x", "prismatic", "map", "x", "0 0 0", "1 0 0"),
            ("base_y", "prismatic", "x", "y", "0 0 0", "0 1 0"),
            ("base_yaw", "revolute", "y", "base_link", "0 0 0", "0 0 1"),
            ("mount", "fixed", "base_link", "mast", "0 0 1", "0 0 1"),
            ("wrist", "fixed", "mast", "palm", "0.3 0 0", "0 0 1"),
            *FINGERS,
        ),
    ),
    "turntable": ((("foot", 9), ("plate", 3)), (("turn", "continuous", "foot", "plate", "0 0 0.5", "0 0 1"),)),
}
LAB = """
@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix lab: <https://example.org/lab#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
<https://example.org/lab_scene> a owl:Ontology ; owl:imports <https://w3id.org/skiros-py/core> .
scene:this a sk:Scene ; rdfs:label "lab" .
scene:floor a sk:Floor ; sk:pose "0 0 0 0 0 0"^^sk:poseLiteral ; sk:size "9 9"^^sk:vectorLiteral .
scene:unknown_location a sk:UnknownLocation .
scene:robot_1 a sk:Robot ; sk:model "carrier" ; sk:at scene:unknown_location ; sk:hasA scene:base_1 , scene:hand_1 ,
    scene:wrench_1 .
scene:base_1 a lab:Omni ; sk:pose "0 0 0 0 0 0"^^sk:poseLiteral ;
    sk:footprint "-0.3 -0.3 0.3 -0.3 0.3 0.3 -0.3 0.3"^^sk:vectorLiteral .
scene:hand_1 a lab:Hand ; sk:joints "a b c" .
scene:wrench_1 a lab:Wrench ; sk:joints "a" .
scene:plate_1 a lab:Turntable ; sk:model "turntable" ; sk:pose "2 0 0 0 0 0"^^sk:poseLiteral ; sk:on scene:floor .
scene:eye_1 a sk:Camera ; sk:pose "0 3 2 3.14159265 0 0"^^sk:poseLiteral ; sk:on scene:floor ; sk:width 64 ;
    sk:height 48 ; sk:verticalFov 0.9 ; sk:minDepth 0.05 ; sk:maxDepth 5.0 ; sk:depthNoise 0.0 ; sk:latency 0.1 .
scene:bench_1 a lab:Bench ; rdfs:label "bench" ; sk:on scene:floor ; sk:pose "0 -2.5 0 0 0 0"^^sk:poseLiteral ;
    sk:drivingPose "0 0.9 0 0 0 0"^^sk:poseLiteral .
scene:cube_1 a lab:Cube ; sk:on scene:floor ; sk:poseFrame scene:plate_1 ;
    sk:pose "0.3 0 0.02 0 0 0"^^sk:poseLiteral .
"""
CUBE = """
@prefix rdf: <http://www.w3.org/1999/02/22-rdf-syntax-ns#> .
lab:Bench a owl:Class ; rdfs:subClassOf sk:Furniture , sk:Location ; sk:primaryParent sk:Furniture ;
    rdfs:label "bench" ; rdfs:comment "A work bench." ;
    sk:solid '[{"kind": "box", "size": [0.8, 0.6, 0.7], "at": [0, 0, 0.35]}]'^^rdf:JSON .
lab:Cube a owl:Class ; rdfs:subClassOf sk:Manipulatable ; rdfs:label "cube" ; rdfs:comment "A cube." ;
    sk:mass 0.5 ; sk:solid '[{"kind": "box", "size": [0.1, 0.1, 0.1], "at": [0, 0, 0.05]}]'^^rdf:JSON .
"""
ENGINE = "from unit.simulation.kinematic_engine import KinematicEngine"
MODELS = """
from pathlib import Path
from skiros_py.ports.kinematics import RobotModel
CARRIER, TURNTABLE = (RobotModel(n, Path(__file__).with_name(n + ".urdf")) for n in ("carrier", "turntable"))
"""


def install_cell(site: Any, form: str = LINK, ontology: str = ONTOLOGY + CUBE) -> None:
    """Installs the laboratory's robots, engine and ontology; its devices are a distribution of their own.

    Args:
        site: Where.
        form: A link of its models, with its name and mass to be filled in.
        ontology: Its ontology.
    """
    urdfs = {
        f"lab_cell/{name}.urdf": f'<robot name="{name}">'
        + "".join(form.format(*link) if link[1] else f'<link name="{link[0]}"/>' for link in links)
        + "".join(JOINT.format(*joint) for joint in joints)
        + "</robot>"
        for name, (links, joints) in URDFS.items()
    }
    files = {"lab_cell/__init__.py": MODELS, "lab_engine.py": ENGINE, "lab_onto/__init__.py": ""}
    files["lab_onto/ontologies/lab.ttl"] = ontology
    site.install(
        "lab-cell",
        {
            "robots": {"carrier": "lab_cell:CARRIER", "turntable": "lab_cell:TURNTABLE"},
            "engines": {"kinematic": "lab_engine:KinematicEngine"},
            "ontologies": {"lab": "lab_onto"},
        },
        files | urdfs,
    )


@pytest.fixture(params=["kinematic", pytest.param("pybullet", marks=pytest.mark.physics)])
def cell(request: Any, lab: Path, site: Any, tmp_path: Path) -> Iterator[Session]:
    """A session of the laboratory, in physics: every kind of its devices, and its robots, come from outside."""
    install_cell(site)
    scene = tmp_path / "lab_scene.ttl"
    scene.write_text(LAB, encoding="utf-8")
    with Session(str(scene), Options(simulation=request.param, seed=1)) as session:
        yield session


def test_in_a_session_foreign_devices_move_are_seen_recorded_and_replayed(cell: Session, tmp_path: Path) -> None:
    lab = pytest.importorskip("lab_devices")
    board, file = cell.cycle.board, tmp_path / "lab.mcap"
    base, hand, plate = (DeviceHandle(board, id_) for id_ in ("base_1", "hand_1", "plate_1"))
    with recorder_of(cell, RecordingWriter(file, part={"run": "one", "start": 0.0}), job="lab"):
        for _ in range(300):
            base.command(lab.OmniTwist(0.0, 0.5, 0.0))
            hand.command(lab.HandTarget((0.1, 0.2, 0.3)))
            plate.command(lab.TableTarget(math.pi / 3.0))
            cell.cycle.step()
        for _ in range(40):
            cell.cycle.step()

    tree = cell.runtime.context.frames.at(board.snapshot)
    angle = plate.state.angle
    assert angle == pytest.approx(math.pi / 2.0, abs=0.05)
    assert base.state.pose.position == pytest.approx((0.0, 0.75, 0.0), abs=0.05)
    assert hand.state.fingers == pytest.approx((0.1, 0.2, 0.3), abs=0.02)
    assert tree.link("hand_1", "palm").position == pytest.approx((0.3, base.state.pose.position[1], 1.0), abs=0.01)

    believed, real = map_pose(cell.runtime.context, "cube_1"), cell.simulation.scene.pose("cube_1")
    seen = {one.id: one for one in view_of(cell.world.snapshot(), None, tree.platforms()).elements}["cube_1"]
    assert believed.position == pytest.approx((2.0 + 0.3 * math.cos(angle), 0.3 * math.sin(angle), 0.52), abs=0.01)
    assert real.position == pytest.approx(believed.position, abs=0.02)
    assert (seen.carrier, seen.pose.position) == ("plate_1", (0.3, 0.0, 0.02))

    with file.open("rb") as stream:
        attached = {one.name for one in make_reader(stream).iter_attachments()}
    assert attached == {"scene.ttl", "carrier.urdf", "turntable.urdf"}
    with Recording(file) as recording:
        replay = Replay.model_validate_json(replay_text(recording, over=True))
        frames = [one["child_frame_id"] for _, _, all_ in recording.messages("/frames") for one in all_["transforms"]]
    assert {"base_1", "plate_1", "eye_1", "robot_1/finger_c", "plate_1/plate"} <= set(frames)
    joints, poses, states = replay.frames.joints, replay.frames.frames, replay.frames.states
    assert joints["plate_1/turn"][-1] == pytest.approx(angle, abs=1e-4)
    assert [joints[f"robot_1/{name}"][-1] for name in "abc"] == pytest.approx(hand.state.fingers, abs=1e-4)
    assert poses["plate_1"][-1][5] == pytest.approx(math.sin(angle / 2.0), abs=1e-3)
    assert poses["base_1"][-1][1] == pytest.approx(base.state.pose.position[1], abs=1e-4)
    assert states["hand_1"][-1]["fingers"] == pytest.approx(hand.state.fingers, abs=1e-4)
    assert set(states["wrench_1"][-1]) == {"force", "torque"}


def test_over_rest_foreign_devices_have_models_and_their_joints_move_live_and_in_a_replay(
    lab: Path, site: Any, tmp_path: Path
) -> None:
    install_cell(site)
    scene = tmp_path / "lab_scene.ttl"
    scene.write_text(LAB, encoding="utf-8")
    with serving(str(scene), tmp_path / "data") as server, api(server) as http:
        server.services.station.control.call(
            lambda session: session.cycle.start(turning(session.cycle.board), "turning")
        )
        http.put("/jobs/aside", json={"goal": "RobotAtLocation(robot_1, bench_1)"}).raise_for_status()
        awaited(http, "aside", "Ended")
        live, replay = http.get("/state").json()["joints"], written(http, "aside")
        plate = http.get("/devices/plate_1").json()
        while (model := http.get("/robots/plate_1/model")).status_code == 202:
            time.sleep(0.1)

    joints = replay.frames.joints
    assert {"plate_1/turn", "robot_1/a", "robot_1/b", "robot_1/c"} == set(live) == set(joints)
    for name in live:
        assert len(joints[name]) == len(replay.frames.times)
        assert joints[name][-1] > joints[name][0] + 0.1, name
    assert replay.frames.frames["plate_1"][0] != replay.frames.frames["plate_1"][-1]
    assert (plate["model"], plate["place"]["position"]) == ("turntable", [2.0, 0.0, 0.0])
    assert 'joint name="turn"' in model.text


def turning(board: DeviceBoard) -> Iterator[None]:
    """Turns the plate and bends the fingers."""
    lab = pytest.importorskip("lab_devices")
    plate, hand = DeviceHandle(board, "plate_1"), DeviceHandle(board, "hand_1")
    angle = 0.0
    while True:
        angle += 0.002
        plate.command(lab.TableTarget(0.5))
        hand.command(lab.HandTarget((angle, angle, angle)))
        yield


def test_in_physics_foreign_devices_are_faulted_and_a_camera_without_a_robot_sees(cell: Session) -> None:
    lab = pytest.importorskip("lab_devices")
    faulty = FaultyCell(cell.simulation, Deaf("base_1"), Frozen("plate_1"), Noisy("wrench_1", 1.0))
    for _ in range(100):
        now = faulty.exchange({"base_1": lab.OmniTwist(1.0, 0.0, 0.0), "plate_1": lab.TableTarget(1.0)})
    image = cell.cycle.board.capture("eye_1").result()

    assert now.devices["base_1"].pose.position == pytest.approx((0.0, 0.0, 0.0), abs=0.01)
    assert now.devices["plate_1"].angle == pytest.approx(0.0, abs=0.01)
    assert any(now.devices["wrench_1"].force)
    assert image.depth[24, 32] == pytest.approx(2.0, abs=0.02)


@pytest.mark.physics
def test_the_overview_picture_of_a_cell_without_a_robot_shows_the_whole_cell(
    lab: Path, site: Any, tmp_path: Path
) -> None:
    install_cell(site, form=LINK.replace("</link>", BOX + "</link>"))
    scene = tmp_path / "lab_scene.ttl"
    scene.write_text(re.sub(r"scene:(robot|base|hand|wrench)_1 a .*?\n(?=scene:)", "", LAB, flags=re.DOTALL))
    with Session(str(scene), Options(seed=1)) as session:
        camera = camera_of(session)
        assert camera is not None
        picture = camera(session.cycle.board.snapshot, "plate_1").result().astype(int)
        seen = np.argwhere(np.ptp(picture, axis=2) > 30)

    assert session.spec.robots == ()
    assert len(seen) > 100, "the floor is grey: only bodies have colours"
    assert seen.min(axis=0).min() > 0
    assert (seen.max(axis=0) < np.array(picture.shape[:2]) - 1).all()


def test_a_plug_in_base_is_planned_with_driven_and_jogged_by_the_built_in_skills(cell: Session) -> None:
    lab = pytest.importorskip("lab_devices")
    planned = cell.plan("RobotAtLocation(robot_1, bench_1)")
    report = cell.run("RobotAtLocation(robot_1, bench_1)")
    arrived = cell.spec.robots[0].pose(cell.cycle.board.snapshot, cell.cycle.board.guard)
    jogged = cell.run_module("jog_base", {"base": "base_1", "robot": "robot_1", "dy": 0.1})
    aside = cell.spec.robots[0].pose(cell.cycle.board.snapshot, cell.cycle.board.guard)

    assert isinstance(planned.outcome, Plan)
    assert [(step.skill, step.arguments["Base"]) for step in planned.outcome.steps] == [("drive", "base_1")]
    assert report.reached, report
    assert arrived.position[:2] == pytest.approx((0.0, -1.6), abs=0.03)
    assert isinstance(jogged, Success), jogged
    assert aside.position[:2] == pytest.approx((arrived.position[0], arrived.position[1] + 0.1), abs=0.01)
    assert isinstance(cell.cycle.board.snapshot.devices["base_1"], lab.OmniState)


# ------------------------------------------------------------------ a device that acts by itself

FEEDER_CLASS = """
@prefix xsd: <http://www.w3.org/2001/XMLSchema#> .
lab:Feeder a owl:Class ; rdfs:subClassOf lab:Turntable , sk:Agent ; rdfs:label "feeder" ; rdfs:comment "Feeds." .
lab:turned a owl:DatatypeProperty ; rdfs:label "turned" ; rdfs:domain lab:Feeder ; rdfs:range xsd:boolean ;
    rdfs:comment "True once it was turned." .
"""
FEEDER = '''
from dataclasses import dataclass

from lab_devices import TableTarget
from skiros_py.behaviours import Do, P
from skiros_py.ports.board import DeviceHandle
from skiros_py.skills.conditions import Compare, ConditionType, Role
from skiros_py.skills.outcome import Success
from skiros_py.skills.parameters import Kind, Param, param
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill, SkillDescription

TURNED = ConditionType(
    "Turned", (Role("feeder", "lab:Feeder"),), Compare("lab:turned", "=", "feeder", True), "It was turned."
)


class Turn(Primitive):
    """Turns a feeder."""

    name = "turn"

    @dataclass(frozen=True, slots=True)
    class Params:
        feeder: str = param("lab:Feeder", "The feeder.", kind=Kind.HARDWARE)
        by: float = param("number", "How far it turns.", default=1.0, unit="rad", limits=(0.0, 2.0))

    def execute(self):
        feeder = DeviceHandle(self.context.board, self.params.feeder)
        end = feeder.state.angle + self.params.by
        while feeder.state.angle < end:
            feeder.command(TableTarget(2.0))
            yield
        self.assert_effects(reason="it was turned")
        return Success("turned")


FEED = Skill(
    SkillDescription(
        name="feed",
        help="Turns a feeder.",
        agent="Feeder",
        target="Feeder",
        params=(Param("Feeder", "lab:Feeder", "The feeder.", Kind.HARDWARE),),
        post=(TURNED("Feeder"),),
    ),
    Do.of("turn", feeder=P("Feeder")),
    driver="fake",
)
'''


def install_feeder(site: Any) -> None:
    """Installs the feeder's skill, primitive and condition."""
    points = {"skills": {"feed": "lab_feeder:FEED"}, "primitives": {"turn": "lab_feeder:Turn"}}
    site.install("lab-feeder", {**points, "conditions": {"Turned": "lab_feeder:TURNED"}}, {"lab_feeder.py": FEEDER})


@pytest.mark.parametrize("robots", [0, 1])
def test_a_device_without_a_robot_that_is_an_agent_is_planned_with_and_run(
    lab: Path, site: Any, monkeypatch: pytest.MonkeyPatch, robots: int
) -> None:
    install_feeder(site)
    lab.write_text(ONTOLOGY + FEEDER_CLASS, encoding="utf-8")
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(lab))
    feeder = 'scene:feeder_1 a lab:Feeder ; sk:pose "2 0 0 0 0 0"^^sk:poseLiteral ; sk:on scene:floor .'
    head = LAB.partition("scene:robot_1")[0].replace("imports <", "imports <https://example.org/lab> , <")
    scene = lab.with_name("feeder_scene.ttl")
    scene.write_text("\n".join([head, feeder, *map(robot_turtle, range(1, robots + 1))]), encoding="utf-8")

    with Session(str(scene), Options(fake=True)) as session:
        planned = session.plan("Turned(feeder_1)")
        report = session.run("Turned(feeder_1)")

        assert isinstance(planned.outcome, Plan)
        assert [(step.skill, dict(step.arguments)) for step in planned.outcome.steps] == [
            ("feed", {"Feeder": "feeder_1"})
        ]
        assert report.reached
        assert session.managers.who_runs("turn").agent == "feeder_1"


@pytest.mark.usefixtures("lab")
def test_devices_of_outside_kinds_are_jogged_and_taught_with_over_http(site: Any, tmp_path: Path) -> None:
    install_cell(site, ontology=ONTOLOGY + CUBE + FEEDER_CLASS)
    install_feeder(site)
    scene = tmp_path / "lab_scene.ttl"
    scene.write_text(LAB.replace("a lab:Turntable", "a lab:Feeder"), encoding="utf-8")

    with serving(str(scene), tmp_path / "data") as served, Client(served.url) as client:

        def ended(run: ModuleRunInfo) -> ModuleRunInfo:
            while run.status not in ("succeeded", "failed", "stopped"):
                run = client.modules.get_run(run.id)
            return run

        base, plate, hand = (client.devices.get(id_) for id_ in ("base_1", "plate_1", "hand_1"))
        aside = ended(client.devices.jog("base_1", {"dy": 0.1}))
        turned = ended(client.devices.jog("plate_1", {"by": 0.5}))
        taught = ended(client.devices.teach("base_1", {"location": "bench_1"}))
        with pytest.raises(ProblemError, match="it must be between 0 and 2"):
            client.devices.jog("plate_1", {"by": 3.0})
        with pytest.raises(ProblemError, match="devices of kind 'three-finger gripper' have no module to jog"):
            client.devices.jog("hand_1")
        robot, now = client.robots.get("robot_1"), client.robots.state("robot_1")

    assert [(one.module, one.agent) for one in (*base.jog, *base.teach)] == [
        ("jog_base", "base_1"),
        ("teach_driving_pose", "base_1"),
    ]
    assert [(one.module, one.agent) for one in plate.jog] == [("turn", "plate_1")]
    assert ([joint.name for joint in hand.joints], hand.jog) == (["a", "b", "c"], ())
    assert [run.status for run in (aside, turned, taught)] == ["succeeded"] * 3, (aside, turned, taught)
    assert ([device.kind for device in robot.devices], robot.carrier) == (
        ["omni", "three-finger gripper", "wrench"],
        "base_1",
    )
    assert now.pose.position == now.frames["base_1"].position == pytest.approx([0.0, 0.1, 0.0], abs=0.01)
    assert now.devices["hand_1"].state == {"fingers": [0.0, 0.0, 0.0]}
    assert taught.changes[0]["edits"][0]["new"]["type"] == "sk:TaughtDrivingPose"


# ------------------------------------------------------------------ planned motions and observations, for displays

STEREO = '''
from dataclasses import dataclass
from typing import ClassVar

from skiros_py.ports.device import DeviceSpec


@dataclass(frozen=True, slots=True)
class Stereo(DeviceSpec[None, None]):
    """Two cameras that see depth together."""

    kind: ClassVar[str] = "stereo camera"
    device_class: ClassVar[str] = "lab:Stereo"

    @classmethod
    def read(cls, individual):
        return cls(individual.id)

    def fake(self, robot):
        """Returns nothing: it is only asked."""
'''
STEREO_CLASS = """
lab:Stereo a owl:Class ; rdfs:subClassOf sk:Device ; rdfs:label "stereo camera" ; rdfs:comment "Sees depth." .
"""


@pytest.mark.usefixtures("lab")
def test_observations_of_robotless_and_plug_in_cameras_are_shown(site: Any, tmp_path: Path) -> None:
    install_cell(site, ontology=ONTOLOGY + CUBE + STEREO_CLASS)
    site.install("lab-stereo", {"devices": {"stereo": "lab_stereo:Stereo"}}, {"lab_stereo.py": STEREO})
    scene = tmp_path / "lab_scene.ttl"
    stereo = 'scene:stereo_1 a lab:Stereo ; sk:on scene:floor ; sk:pose "0 3 2 3.14159265 0 0"^^sk:poseLiteral .'
    scene.write_text(LAB + stereo, encoding="utf-8")
    intrinsics = CameraIntrinsics(2, 2, 100.0, 100.0, 0.5, 0.5, 0.1, 3.0)
    image = DepthImage(Snapshot(0, 0.0), np.ones((2, 2), np.float32), np.zeros((2, 2, 3), np.uint8), intrinsics)
    observations = Observations()
    with Session(str(scene), Options(fake=True)) as session:
        detector = SimpleNamespace(detect=lambda _: Done(DetectionResult(0.0, (), 1.0)))
        session.runtime.asked = LibraryMonitor(GivenPorts({PartDetector: detector}))
        observations.open(session)
        before = observations.numbers()
        for camera in ("eye_1", "stereo_1", "stereo_1"):
            request = DetectionRequest(
                image, Pose.of(0.0, 3.0, 2.0, roll=math.pi), Region(Pose(), (0.1, 0.1)), (), camera=camera
            )
            session.runtime.asked.port(PartDetector).detect(request)
        shown = [observations.observation(session, camera) for camera in ("eye_1", "stereo_1")]

        assert before == {"eye_1": 0, "stereo_1": 0}
        assert observations.numbers() == {"eye_1": 1, "stereo_1": 2}
        assert [(look.number, look.camera, look.pose.position) for look in shown] == [
            (1, "eye_1", (0.0, 3.0, 2.0)),
            (2, "stereo_1", (0.0, 3.0, 2.0)),
        ]


def test_the_planned_path_of_an_outside_base_is_shown_until_it_has_arrived(cell: Session) -> None:
    motions = Motions()
    motions.open(cell)
    running, shown = cell.start_module("drive", {"Location": "bench_1"}), []
    while not running.done:
        cell.cycle.step()
        shown.append(motions.motion(cell, "base_1"))

    assert motions.numbers().keys() == {"base_1"}, "the other kinds plan no motions"
    path = next(motion.poses for motion in shown if motion.poses)
    assert path[0].position == pytest.approx((0.0, 0.0, 0.0), abs=0.02)
    assert path[-1].position == pytest.approx((0.0, -1.6, 0.0), abs=0.03)
    assert motions.motion(cell, "base_1").poses == ()
