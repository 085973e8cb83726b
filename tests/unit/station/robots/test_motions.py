"""Where robots are about to go: what planners answered, until it is done or given up."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import pytest

from skiros_py.api.robots import RobotMotion
from skiros_py.devices.arm import ArmState
from skiros_py.devices.mobile_base import BaseState
from skiros_py.execution.running import RunningModule
from skiros_py.station.robots.motions import Motions
from skiros_py.station.session import Options, Session

pytestmark = pytest.mark.physics
MOST_CYCLES = 4000


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    with Session("kitting", Options()) as opened:
        yield opened


@pytest.fixture
def motions(session: Session) -> Iterator[Motions]:
    noting = Motions()
    noting.open(session)
    yield noting
    noting.close(session)


def planned_for(devices: str, session: Session, motions: Motions, running: RunningModule) -> RobotMotion:
    """Steps until there is a motion for the arms, or the base."""
    for _ in range(MOST_CYCLES):
        session.cycle.step()
        motion = motions.motion(session.spec.robots[0])
        if getattr(motion, devices) or running.done:
            break
    return motion


def test_the_way_of_an_arm_goes_from_where_its_tip_is_to_where_it_stands_at_last(session, motions) -> None:
    before = session.cycle.board.snapshot
    wanted = [angle + 0.2 for angle in before.state("arm_1", ArmState).positions]
    deltas = (0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    running = session.start_module("jog_joints", {"arm": "arm_1", "deltas": deltas})
    (way,) = planned_for("arms", session, motions, running).arms
    session.runtime.finish(running)

    assert session.cycle.board.snapshot.state("arm_1", ArmState).positions[0] == pytest.approx(wanted[0], abs=0.01)
    assert way.arm == "arm_1"
    assert 2 <= len(way.points) <= 60
    radius = math.dist(way.points[0][:2], before.state("base_1", BaseState).pose.position[:2])
    assert math.dist(way.points[0], way.points[-1]) == pytest.approx(radius * 0.2, rel=0.5)
    assert all(math.dist(a, b) < 0.05 for a, b in pairwise(way.points))


def test_a_motion_is_given_up_with_the_module_that_planned_it(session, motions) -> None:
    running = session.start_module("drive", {"Location": "pallet_a"})
    planned = planned_for("base", session, motions, running)
    assert planned.base
    running.stop()
    session.runtime.finish(running)
    session.cycle.step()

    given_up = motions.motion(session.spec.robots[0])
    assert given_up.base == ()
    assert given_up.number == planned.number + 1


def test_the_way_of_a_base_begins_where_it_stands_and_ends_with_its_last_turn(session, motions) -> None:
    start = session.cycle.board.snapshot.state("base_1", BaseState).pose
    running = session.start_module("drive", {"Location": "pallet_a"})
    way = planned_for("base", session, motions, running).base
    session.runtime.finish(running)

    end = session.cycle.board.snapshot.state("base_1", BaseState).pose
    assert (way[0].x, way[0].y) == pytest.approx(start.position[:2], abs=0.05)
    assert (way[-1].x, way[-1].y) == pytest.approx(end.position[:2], abs=0.05)
    assert way[-1].heading == pytest.approx(end.yaw, abs=0.05)
    assert motions.motion(session.spec.robots[0]).base == ()


def test_what_nobody_looks_at_is_not_piled_up(session, motions) -> None:
    for turn in (0.05, -0.05) * 6:
        deltas = (turn, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        session.run_module("jog_joints", {"arm": "arm_1", "deltas": deltas})
    assert 0 < motions.numbers()["robot_1"] <= 16
