"""Moving the fingers of a parallel gripper and sensing the result."""

from __future__ import annotations

from skiros_py.devices.gripper import Gripper, GripperSpec, GripperState, GripperTarget
from skiros_py.skills.context import RunContext
from skiros_py.skills.primitive import Execution

_STILL_FOR = 0.1
_PATIENCE = 2.0
_FIRM = 0.5
"""Fraction of a gripper's maximum force that parts are held with: enough for its payload, but gentle."""


def firm_force(gripper: GripperSpec) -> float:
    """Returns the force per finger that parts are held with [N]."""
    return _FIRM * gripper.max_force


def move_fingers(context: RunContext, gripper: Gripper, gap: float, force: float) -> Execution[GripperState]:
    """Moves the fingers until they have been still for a moment, and returns the gripper state.

    Args:
        context: The run.
        gripper: The gripper.
        gap: Wanted gap between the pads [m]; 0 to close on whatever is between them.
        force: Greatest force per finger [N].
    """
    gripper.command(GripperTarget(gap, force))
    started, still_since = context.now, context.now
    while context.now < started + _PATIENCE:
        yield
        if not gripper.state.still or context.now < started + _STILL_FOR:
            still_since = context.now
        if context.now - still_since >= _STILL_FOR:
            break
    return gripper.state
