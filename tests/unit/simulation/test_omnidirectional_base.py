"""A simulated base that drives sideways: it keeps its limits, stands, turns its wheels, and yields like any other."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from skiros_py.devices.arm import ArmSpec, ArmTarget
from skiros_py.devices.mobile_base import BaseSpec, BaseState, BaseTwist
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.cell import BodySpec, CellSpec, RobotSpec
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.simulation import Wrench
from skiros_py.simulation.cell import SimulatedCell
from skiros_py.simulation.truth import Truth
from skiros_py.station.session import Options, Session
from skiros_py.testing.conformance import CellDriverContract

ENGINES = ["pybullet", "mujoco"]
pytestmark = pytest.mark.physics


def robot(*, start: Pose | None = None) -> RobotSpec:
    """Returns the mobile iiwa without its camera, as its individuals describe it."""
    with Session("kitting_iiwa", Options(fake=True)) as session:
        found = session.spec.robots[0]
    base = found.of(BaseSpec)[0]
    devices = [device for device in found.devices if device.kind != "camera" and device.id != base.id]
    return RobotSpec(found.id, found.model, (replace(base, start=start or Pose()), *devices))


class _Contract(CellDriverContract):
    engine = ""

    def make(self, spec: CellSpec) -> CellDriver:
        return SimulatedCell(spec, seed=1, engine=self.engine)

    def spec(self) -> CellSpec:
        return CellSpec((), (robot(),))


class TestOnPyBullet(_Contract):
    engine = "pybullet"


class TestOnMujoco(_Contract):
    engine = "mujoco"


@pytest.fixture(params=ENGINES)
def make(request):
    cells = []

    def make(*bodies, start=None):
        cells.append(SimulatedCell(CellSpec(bodies, (robot(start=start),)), seed=1, engine=request.param))
        return cells[-1]

    yield make
    for cell in cells:
        cell.close()


def _drive(cell, twist, cycles):
    return [cell.exchange({"base_1": twist} if twist else {}).state("base_1", BaseState) for _ in range(cycles)]


def test_it_keeps_its_limits_sideways_and_stops_after_v_over_a(make):
    cell = make()

    speeds = [0.0, *(state.sideways for state in _drive(cell, BaseTwist(0.0, 0.0, 9.0), 300))]
    speeds += [state.sideways for state in _drive(cell, None, 300)]
    last_moving = max(number for number, speed in enumerate(speeds) if abs(speed) > 0.002)

    assert max(speeds) == pytest.approx(0.4, rel=0.01)
    assert max(abs(after - before) for before, after in itertools.pairwise(speeds)) <= 0.5 * cell.period * 1.1
    assert (last_moving - 300) * cell.period <= 0.4 / 0.5 + 0.05
    assert cell.read().state("base_1", BaseState).still


def test_it_goes_where_it_is_told_and_knows_it_by_odometry(make):
    cell = make(start=Pose.of(1.0, 0.0, 0.0, yaw=0.7))

    states = _drive(cell, BaseTwist(0.2, 0.3, -0.3), 600)
    true = Truth(cell).base_pose("base_1")

    step = states[-2].pose.inverse() @ states[-1].pose
    assert step.position[:2] == pytest.approx((0.2 * cell.period, -0.3 * cell.period), rel=0.02)
    assert true.distance(states[-1].pose) < 0.005
    assert true.position[0] < 2.5


def test_its_wheels_turn_as_rollers_at_45_degrees_make_them(make):
    cell = make()
    names = ("wheel_front_left", "wheel_front_right", "wheel_rear_left", "wheel_rear_right")
    wheels = cell.scene.robots[0].model.joints(names)

    _drive(cell, BaseTwist(0.0, 0.0, 0.3), 400)
    _drive(cell, None, 200)
    way = Truth(cell).base_pose("base_1").position[1]

    assert way > 0.3
    assert wheels.read().positions == pytest.approx([-way / 0.1, way / 0.1, way / 0.1, -way / 0.1], rel=0.03)


def test_it_stands_while_the_arm_swings(make):
    cell = make()
    before, home = Truth(cell).base_pose("base_1"), robot().of(ArmSpec)[0].home

    for cycle in range(600):
        swing = tuple(angle + 0.3 * math.sin(cycle / 60.0) for angle in home)
        cell.exchange({"arm_1": ArmTarget(swing, (0.3 * math.cos(cycle / 60.0) * 200.0 / 60.0,) * 7)})
    after = Truth(cell).base_pose("base_1")

    assert before.distance(after) < 1e-4
    assert abs(after.yaw - before.yaw) < 1e-4


def test_it_glides_into_what_it_does_not_see_no_harder_than_a_hand_bears(make):
    wall = BodySpec("thing", "Thing", Solid.box(1.2, 0.3, 0.5), pose=Pose((0.0, 0.305 + 0.2 + 0.15, 0.0)))
    cell = make(wall)
    truth, forces = Truth(cell), []

    for _ in range(300):
        _drive(cell, BaseTwist(0.0, 0.0, 0.4), 1)
        forces.append(sum(contact.force for contact in truth.contacts() if contact.body == "thing"))

    assert max(forces) > 20.0
    assert np.convolve(forces, np.ones(2) / 2.0).max() <= 280.0  # ISO/TS 15066, in 10 ms
    assert np.convolve(forces, np.ones(100) / 100.0).max() <= 140.0  # and after half a second


def test_it_lets_go_where_it_is_slowed_sideways_and_drives_on_once_it_stands(make):
    cell = make()
    _drive(cell, BaseTwist(0.0, 0.0, 0.4), 200)

    states = []
    for _ in range(40):
        cell.scene.engine.apply_wrench("robot_1", Wrench((0.0, -500.0, 0.0)), link="base_link")
        states += _drive(cell, BaseTwist(0.0, 0.0, 0.4), 1)
    released = _drive(cell, BaseTwist(0.0, 0.0, 0.4), 300)

    assert min(state.sideways for state in states) < -0.03
    assert released[-1].sideways == pytest.approx(0.4, abs=0.01)
