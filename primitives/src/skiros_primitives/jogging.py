"""Common parts of the jogging primitives."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_py.ports.motion import MotionPlan, NoMotion, Trajectory
from skiros_py.skills.primitive import Execution

_SPEED = 0.3
"""Mean joint speed of an unplanned motion [rad/s]."""


def even(start: Sequence[float], goal: Sequence[float], period: float) -> Trajectory:
    """Returns a straight motion from rest to rest, for arms without a planner.

    Args:
        start: Joint angles where it begins [rad].
        goal: Joint angles where it ends [rad].
        period: Time between two samples [s].
    """
    way = np.asarray(goal) - np.asarray(start)
    count = max(2, int(np.ceil(np.abs(way).max(initial=0.0) / _SPEED / period)) + 1)
    share = np.linspace(0.0, 1.0, count)[:, None]
    smooth, rate = share**2 * (3.0 - 2.0 * share), 6.0 * share * (1.0 - share) / ((count - 1) * period)
    return Trajectory(np.asarray(start) + smooth * way, rate * way)


def slip(arm: ArmPrimitive, planned: MotionPlan) -> Execution[NoMotion | None]:
    """Follows a plan and keeps the floor below the arm's end position reserved; returns why it did not arrive."""
    refusal = yield from arm.follow_all(*planned.legs)
    if refusal is None:
        arm.context.floor.stretch(arm.params.arm, planned.ends)
    return refusal
