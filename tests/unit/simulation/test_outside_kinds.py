"""A kind of device from outside runs unchanged on every engine, without a robot, and where it stands."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pytest
from unit.simulation.kinematic_engine import KinematicEngine

from skiros_py.devices.camera import CameraSpec
from skiros_py.errors import DescriptionError
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.cell import BodySpec, CellSpec, RobotSpec
from skiros_py.ports.device import DeviceSpec, FakeRobot, Individual
from skiros_py.ports.simulation import SimulatedRobot
from skiros_py.simulation.cell import SimulatedCell
from skiros_py.simulation.truth import Truth

URDF = """<robot name="turntable">
  <link name="foot"><inertial><mass value="9"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="plate"><inertial><mass value="3"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><origin xyz="0 0 -0.02"/><geometry><box size="0.8 0.8 0.04"/></geometry></collision></link>
  <joint name="turn" type="continuous"><parent link="foot"/><child link="plate"/><origin xyz="0 0 0.5"/><axis xyz="0 0 1"/>
    <limit effort="100" velocity="2"/></joint>
</robot>"""  # noqa: E501 - a file
PLACE = Pose.of(1.0, 2.0, 0.0, yaw=math.pi / 2)
ENGINES = [KinematicEngine, pytest.param("pybullet", marks=pytest.mark.physics)]


@dataclass(frozen=True)
class Turned:
    """Angle of the plate [rad]."""

    angle: float


@dataclass(frozen=True)
class TurnTo:
    """Angle to turn to [rad]."""

    angle: float


@dataclass(frozen=True, slots=True)
class Turntable(DeviceSpec[Turned, TurnTo]):
    """A kind of device of somebody else, that carries bodies on its plate."""

    kind: ClassVar[str] = "turntable"
    device_class: ClassVar[str] = "test:Turntable"
    state_type: ClassVar[type] = Turned
    target_type: ClassVar[type] = TurnTo

    @classmethod
    def read(cls, individual: Individual) -> Self:
        return cls(individual.id)

    def fake(self, robot: FakeRobot) -> None:
        return None

    def simulate(self, robot: SimulatedRobot, rng: np.random.Generator) -> SimulatedTurntable:
        return SimulatedTurntable(robot)

    carries: ClassVar[bool] = True

    @property
    def platform_link(self) -> str:
        return "plate"


class SimulatedTurntable:
    braking_time = 0.1

    def __init__(self, robot: SimulatedRobot) -> None:
        self._joints = robot.joints(("turn",))
        self._angle = 0.0

    def command(self, target: TurnTo | None) -> None:
        self._angle = self._angle if target is None else target.angle
        self._joints.hold_positions((self._angle,), gain=0.2, effort=(100.0,), max_velocity=1.0)

    def state(self) -> Turned:
        return Turned(self._joints.read().positions[0])


@pytest.fixture
def make(site: Any) -> Iterator[Callable[..., SimulatedCell]]:
    code = "from pathlib import Path\nfrom skiros_py.ports.kinematics import RobotModel\n"
    code += 'TABLE = RobotModel("turntable", Path(__file__).parent / "turntable.urdf")\n'
    files = {"sk_turn/__init__.py": code, "sk_turn/turntable.urdf": URDF}
    site.install("sk-turn", {"robots": {"turntable": "sk_turn:TABLE"}}, files)
    cells: list[SimulatedCell] = []

    def make(bodies: Sequence[BodySpec], group: RobotSpec, engine: Any) -> SimulatedCell:
        cells.append(SimulatedCell(CellSpec(tuple(bodies), (), (group,)), seed=1, engine=engine))
        return cells[-1]

    yield make
    for cell in cells:
        cell.close()


@pytest.mark.parametrize("engine", ENGINES)
def test_a_turntable_without_a_robot_carries_what_is_fixed_to_it(make: Any, engine: Any) -> None:
    part = BodySpec("part", "Part", Solid.box(0.1, 0.1, 0.1), 0.5, Pose((0.3, 0.0, 0.02)), carrier="table_1")
    cell = make([part], RobotSpec("table_1", "turntable", (Turntable("table_1"),), PLACE), engine)

    before = cell.scene.pose("part")
    for _ in range(500):
        snapshot = cell.exchange({"table_1": TurnTo(math.pi / 2)})
    after = cell.scene.pose("part")

    assert before.position == pytest.approx((1.0, 2.3, 0.52), abs=0.01)
    assert snapshot.devices["table_1"].angle == pytest.approx(math.pi / 2, abs=0.01)
    assert after.position == pytest.approx((0.7, 2.0, 0.52), abs=0.02)


@pytest.mark.physics
def test_a_body_lying_on_a_robotless_device_is_on_it_in_truth(make: Any) -> None:
    part = BodySpec("part", "Part", Solid.box(0.1, 0.1, 0.1), 0.5, PLACE @ Pose((0.2, 0.0, 0.55)))
    other = BodySpec("other", "Part", Solid.box(0.1, 0.1, 0.1), 0.5, PLACE @ Pose((1.2, 0.0, 0.05)))
    cell = make([part, other], RobotSpec("table_1", "turntable", (Turntable("table_1"),), PLACE), "pybullet")
    for _ in range(100):
        cell.exchange({})

    assert Truth(cell).placements() == {"part": "table_1", "other": "floor"}


def test_a_device_that_carries_something_needs_a_model(make: Any) -> None:
    part = BodySpec("part", "Part", Solid.box(0.1, 0.1, 0.1), 0.5, Pose((0.3, 0.0, 0.02)), carrier="table_1")

    with pytest.raises(DescriptionError, match="table_1 carries part, but has no model: give it an sk:model"):
        make([part], RobotSpec("table_1", "", (Turntable("table_1"),), PLACE), KinematicEngine)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_camera_without_a_robot_sees_from_where_it_stands(make: Any, engine: Any) -> None:
    camera = CameraSpec("camera_1", "", 64, 48, math.radians(50.0), 0.1, 3.0, 0.0, 0.1)
    box = BodySpec("box", "Box", Solid.box(0.2, 0.2, 0.1), pose=Pose((1.0, 2.0, 0.0)))
    over_it = Pose.of(1.0, 2.0, 1.0, roll=math.pi)
    cell = make([box], RobotSpec("camera_1", "", (camera,), over_it), engine)

    depth = cell.capture("camera_1").result().depth

    assert depth[24, 32] == pytest.approx(0.9, abs=2e-3)
    assert depth[2, 2] == pytest.approx(1.0, abs=2e-3)
