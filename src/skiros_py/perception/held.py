"""How a part sits in a gripper: its shape, rendered at poses near the expected one, compared with a picture of it.

All happens in the frame of the arm's tip, whose y axis is the direction in which the fingers close: the part may have
slid along the pads, or turned between them.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from skiros_py.geometry import Array, Pose, Primitive, rotation_matrix
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
"""What is lower, or farther away, than any point of the part by more than this is background [m]."""
_AROUND = 0.01
"""How far beside what is known to stand around it is seen [m], besides the error of where that is."""
_AGREES = 0.004
_FEWEST = 80
"""Number of rays that must meet the part to tell how it sits."""
_LEAST_SHARE = 0.75


class _Block:
    """One block of a solid in a fixed turn, and the rays in its frame."""

    def __init__(self, block: Primitive, turn: Array, directions: Array) -> None:
        self._turn, self._box = turn, block.kind == "box"
        ways = (directions @ turn).T.copy()
        self._ways = np.where(np.abs(ways) < 1e-12, 1e-12, ways)
        self._radius = block.size[0]
        self._axes = slice(0, 3) if self._box else slice(2, 3)
        self._inverse = 1.0 / self._ways[self._axes]
        half = np.asarray(block.size if self._box else block.size[1:]) / 2.0
        self._spans = half[:, None] * np.abs(self._inverse)
        self._across = (self._ways[:2] ** 2).sum(axis=0)

    def met(self, eye: Array) -> Array:
        """Returns at which multiple of its direction each ray enters the block; infinite where it misses it.

        Args:
            eye: Where the rays start, seen from the middle of the block [m].
        """
        start = eye @ self._turn
        middles = -start[self._axes, None] * self._inverse
        enter, leave = (middles - self._spans).max(axis=0), (middles + self._spans).min(axis=0)
        meets = enter > 0.0
        if not self._box:
            x, y = self._ways[:2]
            half_b = x * start[0] + y * start[1]
            root = half_b**2 - self._across * (start[:2] @ start[:2] - self._radius**2)
            reach = np.sqrt(np.maximum(root, 0.0))
            enter = np.maximum(enter, (-half_b - reach) / self._across)
            leave = np.minimum(leave, (-half_b + reach) / self._across)
            meets = (root >= 0.0) & (enter > 0.0)
        return np.where(meets & (leave >= enter), enter, np.inf)


class _Comparison:
    """A solid at poses near the expected one, compared with what the rays of the camera measured.

    All is in the frame of the tip. Only rays that pass where the part may be count, and that measured something; what
    is behind the limit is background. A move is a shift in x, y and z [m] and a turn about the tip's y axis [rad].
    """

    def __init__(self, request: HeldRequest, stride: int) -> None:
        self._solid, self._guess = request.solid, request.guess
        k, depth = request.image.intrinsics, request.image.depth[::stride, ::stride].astype(np.float64)
        v, u = np.mgrid[0 : k.height : stride, 0 : k.width : stride]
        known = np.isfinite(depth) & (depth >= k.near) & (depth <= k.far)
        rays = np.column_stack([(u[known] - k.cx) / k.fx, (v[known] - k.cy) / k.fy, np.ones(known.sum())])
        directions = rays @ rotation_matrix(request.camera_pose.orientation).T
        self._eye, self._nearest = np.asarray(request.camera_pose.position), k.near
        corners = request.guess.apply(np.array(list(itertools.product(*np.transpose(request.solid.bounds())))))
        deepest = float(request.camera_pose.inverse().apply(corners)[:, 2].max()) + _BELOW
        low, high = corners.min(axis=0) - _MARGIN, corners.max(axis=0) + _MARGIN
        zone = _Block(Primitive("box", tuple((high - low).tolist())), np.eye(3), directions)
        near = zone.met(self._eye - (low + high) / 2.0) < np.inf
        self._directions, up = directions[near], np.asarray(request.up)
        falls = np.maximum(-(self._directions @ up), 1e-9)  # a hand that leans sees what it stands over from the side
        self._limit = np.minimum(deepest, (self._eye @ up - (corners @ up).min() + _BELOW) / falls)
        measured = depth[known][near]
        other = _is_other(self._eye + measured[:, None] * self._directions, request)
        self._measured = np.where(other, self._limit, np.minimum(measured, self._limit))
        self._turned: dict[float, list[tuple[Array, _Block]]] = {}
        self._prices: dict[tuple[float, ...], float] = {}

    def misfits(self, move: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Returns by how much the moved solid contradicts each ray [m], and which rays meet it.

        What is nearer than the camera measures, which may look through that, is neither right nor wrong.
        """
        depths = self._limit.copy()
        for position, block in self._blocks(float(move[3])):
            np.minimum(depths, block.met(self._eye - move[:3] - position), out=depths)
        close = depths < self._nearest
        misfit = np.minimum(np.abs(depths - self._measured), _CLIP)
        return np.where(close, _TOO_CLOSE, misfit), (depths < self._limit) & ~close

    def price(self, move: Array) -> float:
        """Returns what speaks against a move; each is looked at once."""
        key = tuple(np.round(move, 9).tolist())
        if key not in self._prices:
            self._prices[key] = float(self.misfits(move)[0].sum() + _UNLIKELY @ np.abs(move))
        return self._prices[key]

    def _blocks(self, turn: float) -> list[tuple[Array, _Block]]:
        """Returns the blocks of the solid, turned but not shifted, and where their middles are [m]."""
        if turn not in self._turned:
            poses = [_moved(self._guess, np.array([0.0, 0.0, 0.0, turn])) @ one.pose for one in self._solid.primitives]
            self._turned[turn] = [
                (np.asarray(pose.position), _Block(one, rotation_matrix(pose.orientation), self._directions))
                for one, pose in zip(self._solid.primitives, poses, strict=True)
            ]
        return self._turned[turn]


def _is_other(points: Array, request: HeldRequest) -> NDArray[np.bool_]:
    """Returns which points in the frame of the tip belong to what stands around, and not to the part where expected."""
    found = np.zeros(len(points), np.bool_)
    for one in request.around:
        local = one.pose.inverse().apply(points)
        for block in one.solid.primitives:
            found |= block.outside(local) < _AROUND + one.error
    expected = request.guess.inverse().apply(points[found])
    found[found] = np.min([block.outside(expected) for block in request.solid.primitives], axis=0) > _AGREES
    return found


def sits(request: HeldRequest) -> HeldResult:
    """Finds how a part sits in the gripper.

    Args:
        request: The picture, and the pose that is expected.

    Returns:
        The pose; none where too little of the part is seen at any pose, or what is seen has another shape.
    """
    coarse, fine = _Comparison(request, _COARSE), _Comparison(request, _FINE)
    starts = [np.array([shift, 0.0, 0.0, turn]) for shift, turn in itertools.product(_SHIFTS, _TURNS)]
    starts.sort(key=coarse.price)
    rough = [_downhill(coarse, start, _STEP) for start in starts[:_KEPT]]
    found = _downhill(fine, min(rough, key=coarse.price), _STEP / 4.0)
    misfit, covered = fine.misfits(found)
    agreeing = int((covered & (misfit <= _AGREES)).sum())
    counted = (covered | (misfit > 0.0)) & (misfit != _TOO_CLOSE)
    if agreeing < _FEWEST:
        expected = int(fine.misfits(np.zeros(4))[1].sum()) >= 2 * _FEWEST
        return HeldResult(None, math.inf, expected, Message("it is not seen between the fingers"))
    cost = float(misfit[counted].mean())
    share = agreeing / int(counted.sum())
    if share < _LEAST_SHARE:
        why = Message("only {percent:.0f} % of what is seen between the fingers has its shape", percent=100.0 * share)
        return HeldResult(None, cost, True, why)
    return HeldResult(_moved(request.guess, found), cost, True)


def _downhill(comparison: _Comparison, start: Array, step: Array) -> Array:
    """Searches in some directions, with halved steps where none is better; returns the best move."""
    at, cost = start, comparison.price(start)
    halvings = 0
    for _ in range(_ROUNDS):
        tried = [(comparison.price(one), one) for one in at + _DIRECTIONS * step]
        least, nearest = min(tried, key=lambda one: one[0])
        if least < cost:
            at, cost = nearest, least
        elif halvings == _HALVINGS:
            break
        else:
            step, halvings = step / 2.0, halvings + 1
    return at


def _moved(guess: Pose, move: Array) -> Pose:
    """Returns a pose turned about the tip's y axis, then shifted."""
    x, y, z, turn = (float(value) for value in move)
    return Pose.of(x, y, z, pitch=turn) @ guess
