from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_primitives.jogging import JogBase, JogJoints, JogTool
from skiros_primitives.playback import even
from skiros_primitives.postures import MoveArm
from skiros_py.devices.arm import ArmState
from skiros_py.devices.mobile_base import BaseState
from skiros_py.skills.outcome import Failure, Success
from skiros_py.testing import Bench, tiny_world

POSE = "^^sk:poseLiteral"
WALL = '[{"kind": "box", "size": [0.1, 2.0, 1.0], "at": [0, 0, 0.5]}]'
AHEAD = f"""scene:wall_1 a sk:Furniture ; rdfs:label "wall" ; sk:on scene:floor ;
    sk:solid '{WALL}'^^<http://www.w3.org/1999/02/22-rdf-syntax-ns#JSON> ; """
ANGLES = st.lists(st.floats(-0.5, 0.5), min_size=2, max_size=7)


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench(tiny_world(), primitives=(JogBase, JogJoints, JogTool, MoveArm)) as made:
        yield made


def joints(bench: Bench) -> tuple[float, ...]:
    return bench.context.board.snapshot.state("arm_1", ArmState).positions


def test_jogged_joints_turn_by_the_given_deltas_and_the_arm_returns_home(bench: Bench) -> None:
    before = joints(bench)
    deltas = [0.1, -0.2, *[0.0] * (len(before) - 2)]

    outcome = bench.run("jog_joints", deltas=deltas)
    turned = joints(bench)
    home = bench.run("move_arm")

    assert isinstance(outcome, Success), outcome
    assert turned == pytest.approx([a + b for a, b in zip(before, deltas, strict=True)])
    assert home == Success("home")
    assert joints(bench) == pytest.approx(before)


def test_a_joint_jog_needs_one_small_delta_per_joint(bench: Bench) -> None:
    before = joints(bench)

    far = bench.run("jog_joints", deltas=[0.21, *[0.0] * (len(before) - 1)])
    few = bench.run("jog_joints", deltas=[0.1] * (len(before) - 1))

    assert isinstance(far, Failure)
    assert "parameter deltas takes" in far.reason
    assert "it must be between -0.2 and 0.2" in far.reason
    assert isinstance(few, Failure)
    assert f"has {len(before)} joints" in few.reason
    assert joints(bench) == before


def test_joints_can_be_jogged_without_an_arm_planner(bench: Bench) -> None:
    outcome = bench.run("jog_tool", translation=[0.0, 0.0, 0.05])

    assert outcome == Failure("there is no planner for the arm: jog the joints instead")


def test_a_large_tool_jog_is_refused(bench: Bench) -> None:
    far = bench.run("jog_tool", translation=[0.08, 0.08, 0.0])
    wide = bench.run("jog_tool", rotation=[0.0, 0.3, 0.3])

    assert isinstance(far, Failure)
    assert "not 0.113 m and 0 rad" in far.reason
    assert isinstance(wide, Failure)
    assert "not 0 m and 0.424 rad" in wide.reason


@pytest.mark.parametrize("step", [(0.1, 0.0, 0.0), (-0.2, 0.0, 0.0), (0.0, 0.0, 0.3), (0.05, -0.1, 0.1)])
def test_a_jogged_base_reaches_its_target(bench: Bench, step: tuple[float, float, float]) -> None:
    before = bench.context.board.snapshot.state("base_1", BaseState).pose

    outcome = bench.run("jog_base", dx=step[0], dy=step[1], dyaw=step[2])

    assert isinstance(outcome, Success), outcome
    came = before.inverse() @ bench.context.board.snapshot.state("base_1", BaseState).pose
    assert came.position[:2] == pytest.approx(step[:2], abs=0.005)
    assert came.yaw == pytest.approx(step[2], abs=0.01)


def test_after_jogging_a_base_its_robot_is_believed_on_the_floor(bench: Bench) -> None:
    with bench.world.transaction("person", "says where it is") as tx:
        tx.place("robot_1", "sk:at", "slot_1")

    bench.run("jog_base", dx=0.05)

    placement = bench.world.placement("robot_1")
    assert placement is not None
    assert placement.place == "floor"


@pytest.mark.parametrize(
    ("too_far", "reason"),
    [
        ({"dx": 0.21}, "it must be between -0.2 and 0.2"),
        ({"dx": 0.15, "dy": 0.15}, "one step is at most 0.2 m long, not 0.212 m"),
        ({"dyaw": 0.36}, "it must be between -0.35 and 0.35"),
    ],
)
def test_a_large_base_jog_is_refused(bench: Bench, too_far: dict[str, float], reason: str) -> None:
    outcome = bench.run("jog_base", **too_far)

    assert isinstance(outcome, Failure)
    assert reason in outcome.reason


def test_a_base_jog_is_refused_while_an_arm_is_stretched_out(bench: Bench) -> None:
    bench.run("jog_joints", deltas=[0.1, *[0.0] * (len(joints(bench)) - 1)])
    before = bench.context.board.snapshot.state("base_1", BaseState).pose

    outcome = bench.run("jog_base", dx=0.1)

    assert outcome == Failure("arm_1 is stretched out: bring it home before the base moves")
    assert bench.context.board.snapshot.state("base_1", BaseState).pose == before


def test_a_base_is_jogged_away_from_an_obstacle_but_not_into_it() -> None:
    with Bench(tiny_world(), primitives=(JogBase,)) as plain:
        front = max(x for x, _ in plain.context.cell.robots[0].outline)
    wall = f'{AHEAD} sk:pose "{front + 0.13} 0 0 0 0 0"{POSE} .'  # its near side is 8 cm ahead
    with Bench(tiny_world(wall), primitives=(JogBase,)) as near:
        blocked = near.run("jog_base", dx=0.1)
        away = near.run("jog_base", dx=-0.1)
        back = near.run("jog_base", dx=0.08)

    assert blocked == Failure("base_1 would touch wall_1")
    assert isinstance(away, Success)
    assert isinstance(back, Success)


@settings(max_examples=25, deadline=None)
@given(ANGLES, st.data())
def test_an_unplanned_motion_is_straight_starts_and_ends_at_rest_and_respects_the_limits(start, data) -> None:
    goal = data.draw(st.lists(st.floats(-0.5, 0.5), min_size=len(start), max_size=len(start)))

    trajectory = even(start, goal, 0.005)

    assert trajectory.positions[0] == pytest.approx(start)
    assert trajectory.positions[-1] == pytest.approx(goal)
    assert trajectory.velocities[[0, -1]] == pytest.approx(0.0)
    way = np.subtract(goal, start)
    shares = np.dot(trajectory.positions - np.asarray(start), way) / max(float(way @ way), 1e-12)
    assert trajectory.positions - np.asarray(start) == pytest.approx(np.outer(shares, way), abs=1e-6)
    assert np.abs(np.diff(trajectory.positions, axis=0)).max() <= 1.5 * 0.3 * 0.005 + 1e-9
    assert math.isfinite(float(np.abs(trajectory.velocities).max()))
