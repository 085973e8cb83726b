"""How a part sits in a gripper: its shape, rendered at poses near the expected one, compared with a picture of it.

All happens in the frame of the arm's tip, whose y axis is the direction in which the fingers close: the part may have
slid along the pads, or turned between them.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from skiros_py.geometry import Array, Pose, Primitive, Solid
from skiros_py.messages import Message
from skiros_py.ports.perception import HeldRequest, HeldResult

_SHIFTS = np.arange(-0.036, 0.0361, 0.006)
"""Where along the pads the search begins, relative to the expected pose [m]."""
_TURNS = np.deg2rad([-4.0, 0.0, 4.0])
"""How the part is turned there [rad]."""
_KEPT = 3
_COARSE, _FINE = 7, 3
"""Every so many pixels are compared."""
_MARGIN = np.array([0.070, 0.020, 0.020])
"""How far from where it is expected the part may reach; what is beside that is not looked at [m]."""
_STEP = np.array([0.003, 0.003, 0.003, math.radians(3.0)])
"""First steps in x, y, z and about y."""
_WAYS = [np.array(way) for way in itertools.product((-1, 0, 1), repeat=len(_STEP))]
_DIRECTIONS = np.stack([way for way in _WAYS if np.abs(way).sum() == 1 or (np.abs(way).sum() == 2 and way[3])])
"""Along each axis, and while turning too: a turn alone moves what is seen, too."""
_UNLIKELY = np.array([0.0, 15.0, 60.0, 1.0])
"""What a move costs: parts slide along the pads rather than across; without unit, for a turn [m/rad]."""
_HALVINGS = 2
_ROUNDS = 40
_CLIP = 0.015
_TOO_CLOSE = 0.005
"""Misfit where the part would be nearer than the camera measures [m]."""
_BELOW = 0.020
"""What is farther away than the lowest point of the part by more than this is background [m]."""
_AGREES = 0.004
_FEWEST = 80
"""Number of rays that must meet the part to tell how it sits."""
_LEAST_SHARE = 0.75


@dataclass(frozen=True, slots=True, eq=False)
class _Rays:
    """Rays of the camera in the frame of the tip, with the depth measured along each; background has the limit."""

    eye: Array
    directions: Array
    measured: Array
    nearest: float
    limit: float

    @classmethod
    def of(cls, request: HeldRequest, stride: int) -> _Rays:
        """Takes the rays that pass where the part may be, and that measured something."""
        k, depth = request.image.intrinsics, request.image.depth[::stride, ::stride].astype(np.float64)
        v, u = np.mgrid[0 : k.height : stride, 0 : k.width : stride]
        known = np.isfinite(depth) & (depth >= k.near) & (depth <= k.far)
        rays = np.column_stack([(u[known] - k.cx) / k.fx, (v[known] - k.cy) / k.fy, np.ones(known.sum())])
        directions = rays @ Rotation.from_quat(request.camera_pose.orientation).as_matrix().T
        eye = np.asarray(request.camera_pose.position)
        corners = request.guess.apply(np.array(list(itertools.product(*np.transpose(request.solid.bounds())))))
        limit = float(request.camera_pose.inverse().apply(corners)[:, 2].max()) + _BELOW
        low, high = corners.min(axis=0) - _MARGIN, corners.max(axis=0) + _MARGIN
        zone = Primitive("box", tuple((high - low).tolist()))
        near = _met(zone, Pose(tuple(((low + high) / 2.0).tolist())), eye, directions) < np.inf
        return cls(eye, directions[near], np.minimum(depth[known][near], limit), k.near, limit)

    def rendered(self, solid: Solid, pose: Pose) -> Array:
        """Returns the depth at which each ray meets a solid, or the limit [m]."""
        depths = np.full(len(self.directions), self.limit)
        for block in solid.primitives:
            np.minimum(depths, _met(block, pose @ block.pose, self.eye, self.directions), out=depths)
        return depths

    def misfits(self, solid: Solid, pose: Pose) -> tuple[Array, NDArray[np.bool_]]:
        """Returns by how much a solid at a pose contradicts each ray [m], and which rays meet it.

        What is nearer than the camera measures, which may look through that, is neither right nor wrong.
        """
        depths = self.rendered(solid, pose)
        close = depths < self.nearest
        misfit = np.minimum(np.abs(depths - self.measured), _CLIP)
        return np.where(close, _TOO_CLOSE, misfit), (depths < self.limit) & ~close


def sits(request: HeldRequest) -> HeldResult:
    """Finds how a part sits in the gripper.

    Args:
        request: The picture, and the pose that is expected.

    Returns:
        The pose; none where too little of the part is seen at any pose, or what is seen has another shape.
    """
    solid, guess = request.solid, request.guess
    coarse, fine = _Rays.of(request, _COARSE), _Rays.of(request, _FINE)
    starts = [np.array([shift, 0.0, 0.0, turn]) for shift, turn in itertools.product(_SHIFTS, _TURNS)]
    starts.sort(key=partial(_price, coarse, solid, guess))
    rough = [_downhill(coarse, solid, guess, start, _STEP) for start in starts[:_KEPT]]
    best = min(rough, key=partial(_price, coarse, solid, guess))
    pose = _moved(guess, _downhill(fine, solid, guess, best, _STEP / 4.0))
    misfit, covered = fine.misfits(solid, pose)
    agreeing = int((covered & (misfit <= _AGREES)).sum())
    counted = (covered | (misfit > 0.0)) & (misfit != _TOO_CLOSE)
    if agreeing < _FEWEST:
        expected = int(fine.misfits(solid, guess)[1].sum()) >= 2 * _FEWEST
        return HeldResult(None, math.inf, expected, Message("it is not seen between the fingers"))
    cost = float(misfit[counted].mean())
    share = agreeing / int(counted.sum())
    if share < _LEAST_SHARE:
        why = Message("only {percent:.0f} % of what is seen between the fingers has its shape", percent=100.0 * share)
        return HeldResult(None, cost, True, why)
    return HeldResult(pose, cost, True)


def _downhill(rays: _Rays, solid: Solid, guess: Pose, start: Array, step: Array) -> Array:
    """Searches in some directions, with halved steps where none is better; returns the best move."""
    at, cost = start, _price(rays, solid, guess, start)
    halvings = 0
    for _ in range(_ROUNDS):
        tried = [(_price(rays, solid, guess, one), one) for one in at + _DIRECTIONS * step]
        least, nearest = min(tried, key=lambda one: one[0])
        if least < cost:
            at, cost = nearest, least
        elif halvings == _HALVINGS:
            break
        else:
            step, halvings = step / 2.0, halvings + 1
    return at


def _price(rays: _Rays, solid: Solid, guess: Pose, move: Array) -> float:
    return float(rays.misfits(solid, _moved(guess, move))[0].sum() + _UNLIKELY @ np.abs(move))


def _moved(guess: Pose, move: Array) -> Pose:
    """Returns a pose turned about the tip's y axis, then shifted."""
    x, y, z, turn = (float(value) for value in move)
    return Pose.of(x, y, z, pitch=turn) @ guess


def _met(block: Primitive, pose: Pose, eye: Array, directions: Array) -> Array:
    """Returns at which multiple of its direction each ray enters a block; infinite where it misses it."""
    turn = Rotation.from_quat(pose.orientation).as_matrix()
    start, ways = (eye - np.asarray(pose.position)) @ turn, directions @ turn
    ways = np.where(np.abs(ways) < 1e-12, 1e-12, ways)
    half = np.asarray(block.size if block.kind == "box" else (np.inf, np.inf, block.size[1])) / 2.0
    ends = np.stack([(-half - start) / ways, (half - start) / ways])
    enter, leave = ends.min(axis=0).max(axis=1), ends.max(axis=0).min(axis=1)
    if block.kind != "box":
        a = (ways[:, :2] ** 2).sum(axis=1)
        half_b = ways[:, :2] @ start[:2]
        root = half_b**2 - a * (start[:2] @ start[:2] - block.size[0] ** 2)
        reach = np.sqrt(np.maximum(root, 0.0))
        enter = np.where(root >= 0.0, np.maximum(enter, (-half_b - reach) / a), np.inf)
        leave = np.minimum(leave, (-half_b + reach) / a)
    return np.where((leave >= enter) & (enter > 0.0), enter, np.inf)
