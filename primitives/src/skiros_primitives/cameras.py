"""Which camera sees a place best from where it is: in view, near enough, and with nothing in between."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from itertools import product

import numpy as np

from skiros_primitives.lookout import crossed, half_size
from skiros_primitives.views import hand_camera, robot_blocks
from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.camera import CameraSpec
from skiros_py.devices.localiser import LocaliserSpec
from skiros_py.errors import DeviceError
from skiros_py.geometry import Array
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import Obstacle, Vector
from skiros_py.ports.perception import Region
from skiros_py.skills.context import RunContext
from skiros_py.skills.surroundings import obstacles

_GRID = tuple(product((-1.0, -0.5, 0.0, 0.5, 1.0), repeat=2))
"""Points of a region that are looked at, as shares of its half lengths."""
_ABOVE = 0.02
"""Height above a surface at which it must be seen [m]: what lies there is higher, and its own edge hides nothing."""
_SEEN = 0.9
"""Least share of these points that a camera must see."""
_BORDER = 0.95
"""Share of a picture, from its middle, in which they must be."""
_RECOGNISED = 0.006
"""Greatest error of a point at which shapes can be distinguished [m]."""
_NOISE_AT = 0.5
"""Distance at which a camera has the noise that its description says [m]; it grows with the square of that."""
_MOUNTED, _TURNED = 0.001, math.radians(0.2)
"""Standard deviations of where a calibrated camera is on what carries it [m, rad]."""
_LINK = 0.07
"""How far links stick out around the line between their joints, where they hide something [m]."""
OVER = 0.46
"""Height above a surface from which a camera on an arm looks at it, as a rule [m]."""


def error_at(camera: CameraSpec, distance: float) -> float:
    """Returns the standard deviation of where a camera sees a point for what carries it, about [m].

    Args:
        camera: The camera.
        distance: How far the point is away [m].
    """
    pixel = distance * 2.0 * math.tan(camera.vertical_fov / 2.0) / camera.height
    return math.hypot(pixel, camera.noise * (distance / _NOISE_AT) ** 2, _MOUNTED, distance * _TURNED)


def localised_within(robot: RobotSpec, point: Vector, at: Vector) -> float:
    """Returns the standard deviation of where a point in the map is for a robot, by its localiser [m].

    Args:
        robot: The robot.
        point: The point [m].
        at: Where the robot is in the map [m].
    """
    far = math.dist(point[:2], at[:2])
    noise = (math.hypot(one.position_noise, far * one.heading_noise) for one in robot.of(LocaliserSpec))
    return max(noise, default=0.0)


def still_cameras(context: RunContext, arm: ArmSpec) -> Iterator[tuple[CameraSpec, RobotSpec]]:
    """Yields the cameras that an arm need not move: those of its robot, and those that belong to none."""
    own, hand = context.cell.group_of(arm.id), hand_camera(context, arm.id)
    for group in (own, *context.cell.single):
        for camera in group.of(CameraSpec):
            if camera is not hand and camera.id not in context.board.closed:
                yield camera, group


def best_camera(
    context: RunContext, arm: ArmSpec, region: Region, most: float | None, without: Collection[str] = ()
) -> str | None:
    """Returns the camera to look at a place with.

    That is the most exact one of those that see it from where they are, else the one on the arm; where the arm has
    none, whichever sees it best.

    Args:
        context: The run.
        arm: The arm, which works with what is seen.
        region: The place.
        most: Greatest error of where things are seen for the arm, as a standard deviation [m]; None where no camera
            may be less exact than the one on the arm, from above.
        without: Ids of cameras that have looked there in vain.
    """
    hand = hand_camera(context, arm.id)
    if most is None:
        most = math.inf if hand is None else error_at(hand, OVER)
    own, errors = context.cell.group_of(arm.id), dict[str, float]()
    for camera, group in still_cameras(context, arm):
        error = seen_within(context, camera, region) if camera.id not in without else None
        if error is not None:
            at = own.pose(context.board.snapshot, context.board.guard).position
            beside = 0.0 if group is own else localised_within(own, region.pose.position, at)
            errors[camera.id] = math.hypot(error, beside) if error <= _RECOGNISED else math.inf
    good = {id_: error for id_, error in errors.items() if error <= most}
    if hand is not None and not good:
        return hand.id
    return min(good or errors, key=errors.__getitem__, default=None)


def seen_within(context: RunContext, camera: CameraSpec, region: Region) -> float | None:
    """Returns how exactly a camera sees a region from where it is, at its farthest point [m]; None if it does not.

    Args:
        context: The run.
        camera: The camera.
        region: The place.
    """
    tree = context.frames.at(context.board.snapshot)
    try:
        at = tree.located(camera.id)
    except DeviceError:
        return None
    half_x, half_y = region.half_extents
    points = region.pose.apply(np.array([(x * half_x, y * half_y, _ABOVE) for x, y in _GRID]))
    local = at.inverse().apply(points)
    distance, up = np.linalg.norm(local, axis=1), math.tan(camera.vertical_fov / 2.0) * _BORDER
    across, down, deep = local.T
    inside = (deep > camera.near) & (deep < camera.far)
    inside &= (np.abs(across) < up * camera.width / camera.height * deep) & (np.abs(down) < up * deep)
    if inside.mean() < _SEEN:
        return None
    between = [*obstacles(context, parts=False)]
    for robot in context.cell.robots:
        between += robot_blocks(context, robot, tree, _LINK)
    free = inside & np.logical_not(_hidden(np.array(at.position), points, between))
    return error_at(camera, float(distance.max())) if free.mean() >= _SEEN else None


def _hidden(eye: Array, points: Array, between: Collection[Obstacle]) -> Array:
    """Returns which of some points something hides from an eye, shape (n,)."""
    hidden = np.zeros(len(points), dtype=bool)
    for one in between:
        for block in one.solid.primitives:
            back, half = (one.pose @ block.pose).inverse(), half_size(block)
            start = back.apply(eye)
            if (np.abs(start) > half).any():  # else the camera is on it
                hidden |= crossed(start, back.apply(points), half)
    return hidden
