"""A base docks where its arm reaches what is wanted: at the driving pose where it does, or else beside that."""

from __future__ import annotations

from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.stepping import run

from skiros_primitives import docking
from skiros_primitives.docking import docking_pose
from skiros_py.geometry import Pose
from skiros_py.ports.motion import MotionPlan, MotionRequest, NoMotion, PoseMove
from skiros_py.ports.values import Done
from skiros_py.skills.primitive import Execution
from skiros_py.testing.conformance.cells import small_cell

TAUGHT = Pose((1.0, 0.0, 0.0))
ROBOT = small_cell(cameras=False).robots[0]


class Arm:
    """Stands for run and planner: the arm reaches so far ahead of its base, and lower the nearer it is."""

    def __init__(self, reach: float) -> None:
        self.reach, self.asked = reach, 0
        self.ports = SimpleNamespace(find=lambda *_: self)
        self.port = lambda *_: self
        self.now, self.lockstep, self.waiting = 0.0, True, nullcontext
        self.context = self

    def plan(self, request: MotionRequest) -> Done[MotionPlan | NoMotion]:
        self.asked += 1
        (route,) = request.routes
        assert isinstance(route[0], PoseMove)
        away = request.base.inverse() @ route[0].pose
        there = float(np.hypot(away.position[0], away.position[1])) <= self.reach
        return Done(MotionPlan(0, ()) if there else NoMotion("out of reach"))

    def wait(self, pending: Done[Any]) -> Execution[Any]:
        yield from ()
        return pending.result()

    def seed(self) -> int:
        return 0


def free(_pose: Pose) -> Execution[bool]:
    yield from ()
    return True


def chosen(monkeypatch: pytest.MonkeyPatch, arm: Arm, *wanted: Pose, is_free: Any = free) -> Pose:
    monkeypatch.setattr(docking, "held_by", lambda *_: None)
    monkeypatch.setattr(docking, "obstacles", lambda *_, **__: ())
    monkeypatch.setattr(docking, "_touching", lambda *_: set())
    monkeypatch.setattr(docking, "_wanted", lambda *_: [[pose] for pose in wanted])
    primitive: Any = arm
    found: Pose = run(docking_pose(primitive, ROBOT, "kit_1", TAUGHT, is_free))
    return found


NEAR, FAR, LEFT = Pose((1.6, 0.0, 0.9)), Pose((1.74, 0.0, 0.9)), Pose((1.7, 0.14, 0.9))


def test_where_the_farthest_place_is_reached_it_docks_as_taught_and_asks_no_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    arm = Arm(0.75)

    assert chosen(monkeypatch, arm, NEAR, FAR) == TAUGHT
    assert arm.asked == 1


def test_where_nothing_is_wanted_nothing_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    arm = Arm(0.75)

    assert chosen(monkeypatch, arm) == TAUGHT
    assert arm.asked == 0


def test_it_docks_nearer_where_the_arm_does_not_reach_as_taught(monkeypatch: pytest.MonkeyPatch) -> None:
    found = chosen(monkeypatch, Arm(0.70), NEAR, FAR)

    assert found.position[0] > TAUGHT.position[0]


def test_it_docks_beside_where_nearer_is_not_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    found = chosen(monkeypatch, Arm(0.645), LEFT)

    assert found.position[1] > 0.0


def test_it_docks_as_taught_where_no_other_place_is_free_or_better(monkeypatch: pytest.MonkeyPatch) -> None:
    def taken(_pose: Pose) -> Execution[bool]:
        yield from ()
        return False

    assert chosen(monkeypatch, Arm(0.70), NEAR, FAR, is_free=taken) == TAUGHT
    assert chosen(monkeypatch, Arm(0.10), NEAR, FAR) == TAUGHT
