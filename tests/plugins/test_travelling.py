"""Base and arm of one drive agree: the base waits where its arm is not that far yet."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from skiros_primitives import travelling
from skiros_primitives.floor_obstacles import covered_by_link
from skiros_primitives.travelling import TravellingArms
from skiros_py.geometry import Pose
from skiros_py.ports.motion import MotionPlan, Trajectory
from skiros_py.ports.paths import BaseLeg, BasePath
from skiros_py.skills.outcome import Execution

PERIOD, SAMPLES = 0.005, 200


class Cell:
    """What TravellingArms asks for: a clock, and where the base is."""

    def __init__(self) -> None:
        self.now = 0.0
        self.x = 0.0
        self.board: Any = SimpleNamespace(period=PERIOD, snapshot=None, guard=None)

    def pose(self, _snapshot: Any, _guard: Any) -> Pose:
        return Pose((self.x, 0.0, 0.0))


class Mover:
    """An arm that follows a plan."""

    def __init__(self) -> None:
        self.params = SimpleNamespace(arm="arm")
        self.touched = False

    def follow_plan(self, _planned: MotionPlan) -> Execution[None]:
        for _ in range(SAMPLES):
            yield


def leaving(monkeypatch: pytest.MonkeyPatch, touching: float) -> tuple[Cell, TravellingArms, Mover]:
    """Begins to stow an arm that is over things for a share of its motion; the base is to drive 2 m back."""
    cell: Any = Cell()
    arms = TravellingArms(cell, cell, "there", Pose((-5.0, 0.0, 0.0)))
    mover: Any = Mover()
    postures = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    arms._stowing = mover, MotionPlan(0, (Trajectory(postures, postures),))
    monkeypatch.setattr(travelling, "reaches_over", lambda _c, _r, _a, posture, *_poses: posture[0] < touching)
    moving = arms.move()
    next(moving)
    for _ in arms.find_clear(BasePath((BaseLeg(-2.0, 0.0, backwards=True),), 0.0)):
        pass
    return cell, arms, mover


@pytest.mark.parametrize("touching", [0.3, 0.7])
def test_a_base_starts_when_the_rest_of_its_arms_motion_is_clear(
    monkeypatch: pytest.MonkeyPatch, touching: float
) -> None:
    cell, arms, _ = leaving(monkeypatch, touching)
    end = SAMPLES * PERIOD

    cell.now = touching * end
    assert arms.must_wait()
    cell.now = (touching + 0.1) * end
    assert not arms.must_wait()


def test_a_base_waits_until_its_arm_is_stowed_where_that_touches_things(monkeypatch: pytest.MonkeyPatch) -> None:
    cell, arms, _ = leaving(monkeypatch, 2.0)
    cell.now = 100.0

    assert arms.must_wait()


def test_a_base_waits_on_its_way_for_an_arm_that_is_late_or_has_met_something(monkeypatch: pytest.MonkeyPatch) -> None:
    cell, arms, mover = leaving(monkeypatch, 0.0)

    assert not arms.must_wait()
    cell.x = -0.3
    assert arms.must_wait()
    cell.x = -0.1
    mover.touched = True
    assert arms.must_wait()
    assert arms.touched


def test_a_link_covers_what_it_sticks_out_around_it() -> None:
    upright = covered_by_link(np.array([(0.0, 0.0, 0.5), (0.0, 0.0, 0.7)]), 0.12)
    level = covered_by_link(np.array([(0.0, 0.0, 0.5), (0.2, 0.0, 0.5)]), 0.12)

    assert (upright.bottom, upright.top) == pytest.approx((0.47, 0.73))
    assert (level.bottom, level.top) == pytest.approx((0.38, 0.62))
    assert max(x for x, _ in upright.outline) == pytest.approx(0.12)
