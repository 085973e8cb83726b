"""Parts are held by friction and nothing else: grasped, lifted, carried, placed and released."""

import itertools
import math

import numpy as np
import pytest

from skiros_py.devices.arm import ArmState, ArmTarget
from skiros_py.devices.gripper import GripperState, GripperTarget
from skiros_py.devices.mobile_base import BaseTwist
from skiros_py.geometry import Pose
from skiros_py.simulation.truth import Truth

pytestmark = pytest.mark.physics

LIFT = 0.12
MARGINS = {"pybullet": 0.0022, "mujoco": 0.0}
"""By so much do fingers stay away from what they press on [m]."""


def _move(cell, start, goal, duration):
    """Moves all joints along a smooth line that starts and ends at rest."""
    cycles = round(duration / cell.period)
    start, way = np.array(start), np.subtract(goal, start)
    for cycle in range(1, cycles + 1):
        s = cycle / cycles
        share, rate = 10 * s**3 - 15 * s**4 + 6 * s**5, (30 * s**2 - 60 * s**3 + 30 * s**4) / duration
        cell.exchange({"arm": ArmTarget(tuple(start + share * way), tuple(rate * way))})


def _line(cell, ik, start, goal_pose):
    """Moves the tool straight to a pose."""
    q, begin = np.array(start), ik.pose(start)
    steps = [Pose(tuple(p), goal_pose.orientation) for p in np.linspace(begin.position, goal_pose.position, 9)[1:]]
    way = [q]
    for step in steps:
        way.append(ik.solve(step, way[-1]))
    for before, after in itertools.pairwise(way):
        _move(cell, before, after, 0.15)
    return way[-1]


def _grip(cell, gap, force=30.0):
    cell.exchange({"gripper": GripperTarget(gap, force)})
    for _ in range(120):
        cell.exchange({})
    return cell.read().state("gripper", GripperState)


def _tool(x, y, z, yaw):
    """The tool pointing down, its fingers closing across the y axis of a part with that yaw."""
    return Pose.of(x, y, z, yaw=yaw) @ Pose.of(0.0, 0.0, 0.0, roll=math.pi)


def _pick(cell, ik, kitting, part, pose):
    """Grasps and lifts the part; returns the arm's angles at the end and what the gripper says."""
    home = np.array(kitting.HOME)
    height = kitting.TOP + part.grasp_height
    above = ik.solve(_tool(*pose.position[:2], height + LIFT, pose.yaw), home)
    _move(cell, home, above, 2.5)
    low = _line(cell, ik, above, _tool(*pose.position[:2], height, pose.yaw))
    gripper = _grip(cell, 0.0)
    return _line(cell, ik, low, _tool(*pose.position[:2], height + LIFT, pose.yaw)), gripper


@pytest.mark.parametrize(
    ("name", "engine"),
    [(n, "pybullet") for n in ("Starter", "Alternator", "Compressor", "RelayBox")]
    + [(n, "mujoco") for n in ("Starter", "Alternator")],
)
def test_a_part_is_grasped_lifted_and_placed_upright_where_it_is_released(make_cell, kitting, ik, name, engine):
    part = kitting.PARTS[name]
    spec = kitting.cell_spec(part.body(Pose.of(0.66, 0.08, kitting.TOP, yaw=0.4), "table"))
    cell = make_cell(spec, engine=engine)
    truth = Truth(cell)

    q, gripper = _pick(cell, ik, kitting, part, Pose.of(0.66, 0.08, kitting.TOP, yaw=0.4))
    held = truth.placements()["part"]
    height = kitting.TOP + part.grasp_height
    above = ik.solve(_tool(0.62, -0.12, height + LIFT, -0.3), q)
    _move(cell, q, above, 2.0)
    low = _line(cell, ik, above, _tool(0.62, -0.12, height + 0.004, -0.3))
    _grip(cell, gripper.gap + 0.016)
    _line(cell, ik, low, _tool(0.62, -0.12, height + LIFT, -0.3))
    pose = truth.pose("part")

    assert gripper.gap == pytest.approx(part.width + MARGINS[engine], abs=0.001)
    assert gripper.force == pytest.approx(30.0, abs=1.0)
    assert held == "gripper"
    assert truth.placements()["part"] == "table"
    assert pose.position == pytest.approx((0.62, -0.12, kitting.TOP), abs=0.004)
    assert pose.matrix()[2, 2] > 0.999


@pytest.mark.parametrize(
    ("name", "engine"), [("Starter", "pybullet"), ("Compressor", "pybullet"), ("Compressor", "mujoco")]
)
def test_a_held_part_slips_less_than_3_mm_while_the_robot_drives_1_m_and_turns_90_degrees(
    make_cell, kitting, ik, name, engine
):
    part = kitting.PARTS[name]
    cell = make_cell(kitting.cell_spec(part.body(Pose.of(0.66, 0.0, kitting.TOP), "table")), engine=engine)
    truth = Truth(cell)

    def in_hand():
        tool = truth.base_pose("base") @ ik.pose(cell.read().state("arm", ArmState).positions)
        return tool.inverse() @ truth.pose("part")

    q, _ = _pick(cell, ik, kitting, part, Pose.of(0.66, 0.0, kitting.TOP))
    _move(cell, q, kitting.HOME, 2.0)
    before, start = in_hand(), truth.base_pose("base")
    for twist in [BaseTwist(-0.5, 0.0)] * 420 + [BaseTwist(0.0, 0.0)] * 200 + [BaseTwist(0.0, 0.8)] * 420:
        cell.exchange({"base": twist})
    for _ in range(200):
        cell.exchange({})
    after, end = in_hand(), truth.base_pose("base")

    assert start.distance(end) > 0.99
    assert abs(end.yaw - start.yaw) > math.radians(89.0)
    assert truth.placements()["part"] == "gripper"
    assert before.distance(after) < 0.003


def test_a_part_knocked_out_of_the_gripper_changes_gap_and_force(make_cell, kitting, ik):
    part = kitting.PARTS["Compressor"]
    cell = make_cell(kitting.cell_spec(part.body(Pose.of(0.66, 0.0, kitting.TOP), "table")))

    _, holding = _pick(cell, ik, kitting, part, Pose.of(0.66, 0.0, kitting.TOP))
    cell.move_body("part", Pose((0.66, 0.3, kitting.TOP)))
    for _ in range(100):
        cell.exchange({})
    empty = cell.read().state("gripper", GripperState)

    assert (holding.gap, holding.force) > (0.045, 25.0)
    assert empty.gap < 0.001
    assert empty.force < 0.5
