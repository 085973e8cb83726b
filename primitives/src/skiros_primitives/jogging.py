"""What the primitives share that move a robot by hand, a little at a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_py.ports.motion import MotionPlan, NoMotion, Trajectory
from skiros_py.skills.primitive import Execution

_SPEED = 0.3
"""Mean joint speed of a motion that nobody plans [rad/s]."""


def even(start: Sequence[float], goal: Sequence[float], period: float) -> Trajectory:
    """Returns a straight motion from rest to rest, for arms that nothing is planned for.

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
    """Follows what was planned, and keeps the floor below where the arm ends; returns why it did not get there."""
    refusal = yield from arm.follow_all(*planned.legs)
    if refusal is None:
        arm.context.floor.stretch(arm.params.arm, planned.ends)
    return refusal
