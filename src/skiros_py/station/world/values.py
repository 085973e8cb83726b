"""Conversion of property values between the world model and plain data."""

from __future__ import annotations

from typing import Any

from skiros_py.api.world import GivenPose, GivenValue
from skiros_py.errors import UsageError
from skiros_py.geometry import Pose
from skiros_py.world.element import Value
from skiros_py.world.poses import write_pose
from skiros_py.world.transaction import Transaction
from skiros_py.world.vocabulary import POSE


def plain(value: Value | None, frame: str | None = None) -> Any:
    """Returns a value as plain data.

    Args:
        value: The value.
        frame: For a pose, the element in whose frame it is.
    """
    if isinstance(value, Pose):
        pose = {"position": list(value.position), "orientation": list(value.orientation)}
        return pose if frame is None else {**pose, "frame": frame}
    return list(value) if isinstance(value, tuple) else value


def given(value: GivenValue) -> Value:
    """Returns a received value as a value of the world model."""
    if isinstance(value, GivenPose):
        return Pose(value.position, value.orientation)
    return tuple(value) if isinstance(value, list) else value


def set_value(tx: Transaction, element: str, property_: str, value: GivenValue | None) -> None:
    """Writes an element's own value, for ``sk:pose`` also the frame; None removes it.

    Raises:
        UsageError: A frame is given for a property other than ``sk:pose``.
    """
    frame = value.frame if isinstance(value, GivenPose) else None
    if property_ != POSE and frame is not None:
        raise UsageError(
            "{property} of {element} is always in the element's own frame: leave out 'frame'",
            property=property_,
            element=element,
        )
    says_frame = isinstance(value, GivenPose) and "frame" in value.model_fields_set
    if property_ == POSE and (value is None or says_frame):
        pose = given(value) if value is not None else None
        if tx.view.has(element) and (pose is None or isinstance(pose, Pose)):
            write_pose(tx, element, pose, frame)
            return
    tx.set(element, property_, None if value is None else given(value))
