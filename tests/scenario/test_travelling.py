"""Arms move while their base drives: that saves time, touches nothing, and may be stopped at any moment."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from skiros_py.devices.arm import ArmState
from skiros_py.devices.mobile_base import BaseState
from skiros_py.simulation.truth import Truth
from skiros_py.station.session import Session

pytestmark = pytest.mark.physics

When = Callable[[Session, Callable[[], bool], Callable[[], None]], None]


def both_move(session: Session) -> bool:
    snapshot = session.cycle.board.snapshot
    base, arm = snapshot.state("base_1", BaseState), snapshot.state("arm_1", ArmState)
    return abs(base.linear) > 0.05 and max(map(abs, arm.velocities)) > 0.1


def test_a_stop_while_base_and_arm_leave_together_is_no_harm_and_the_next_order_goes_on(
    open_session: Callable[..., Session], when: When
) -> None:
    session = open_session("kitting_carried", seed=6)
    truth = Truth(session.simulation)
    session.cycle.observe(truth.watch)
    together: list[float] = []
    session.cycle.observe(lambda: together.append(session.cycle.board.now) if both_move(session) else None)

    assert session.run(["Holding(gripper_1, starter_1)"]).reached
    arriving = len(together)
    when(session, lambda: both_move(session) and len(together) > arriving + 20, session.stop)
    stopped = session.run(["RobotAtLocation(robot_1, pallet_b)"])

    assert arriving > 20
    assert (stopped.stopped, session.cycle.board.still) == (True, True)
    assert session.world.placement("robot_1").place == "floor"
    assert truth.placements()["starter_1"] == "gripper_1"

    report = session.run(["RobotAtLocation(robot_1, pallet_b)"])

    assert report.reached
    assert truth.placements()["starter_1"] == "gripper_1"
    assert set(truth.worst) == {("panda_leftfinger", "starter_1"), ("panda_rightfinger", "starter_1")}
