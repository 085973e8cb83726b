"""What a new arm needs and its model does not tell: reach over a table, a home posture, loads and efforts."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from skiros_py.geometry import Array, Pose
from skiros_py.motion.pinocchio.arm_model import ArmModel
from skiros_py.motion.pinocchio.collision import add_distant_pairs
from skiros_py.motion.pinocchio.kinematics import IkSolver

_YAWS = (0.0, math.pi / 2.0, math.pi, -math.pi / 2.0)
_SAMPLES = 500
_INSET = 0.1
"""Distance of a home posture from the joint limits [rad]; a tenth of the range where that is less."""
_AMPLE = 0.5
"""Distance from the limits beyond which more is no better [rad]."""


def reach_above(arm: ArmModel, height: float) -> float:
    """Returns how far in front of the shoulder the tip, pointing down, gets at a height [m]."""
    distances = np.linspace(0.3, 1.0, 29) * arm.reach
    return float(max((one for one in distances if _postures(arm, one, height, count=1, restarts=16)), default=0.0))


def find_home(arm: ArmModel, ahead: float, height: float) -> Array | None:
    """Returns a posture with the tip pointing down in front of the shoulder, the elbow high, far from all limits.

    Args:
        arm: The arm.
        ahead: Where the tip is, in front of the shoulder [m].
        height: Its height above the floor [m].

    Returns:
        Joint angles in which as few links as possible touch each other [rad]; None where there is no such posture.
    """
    shapes = arm.collision_shapes(math.inf)
    add_distant_pairs(arm.model, shapes)
    data, results = arm.model.createData(), shapes.createData()

    def worth(q: Array) -> tuple[int, float]:
        pin.computeCollisions(arm.model, data, shapes, results, q, False)
        touching = sum(result.isCollision() for result in results.collisionResults)
        elbow = float(arm.joint_places(q)[2:, 2].min(initial=math.inf))
        room = float(np.minimum(q - arm.lower, arm.upper - q).min())
        return -touching, 2.0 * min(elbow, 10.0) + min(room, _AMPLE) - 0.1 * float(np.abs(q).max())

    return max(_postures(arm, ahead, height, count=6, restarts=30), key=worth, default=None)


def _postures(arm: ArmModel, ahead: float, height: float, *, count: int, restarts: int) -> list[Array]:
    solver, rng = IkSolver(arm), np.random.default_rng(0)
    middle, half = (arm.upper + arm.lower) / 2.0, (arm.upper - arm.lower) / 2.0
    half = np.minimum(half - np.minimum(_INSET, half / 5.0), math.pi)
    found: list[Array] = []
    for yaw in _YAWS:
        down = Pose.of(arm.shoulder[0] + ahead, arm.shoulder[1], height, roll=math.pi, yaw=yaw).matrix()
        found += solver.branches(down, middle, (middle - half, middle + half), rng, count=count, restarts=restarts)
        if len(found) >= count:
            break
    return found


def degrees_of_freedom(arm: ArmModel) -> int:
    """Returns in how many directions the tip moves and turns where the arm is most agile: 6 for one that is free."""
    rng = np.random.default_rng(0)
    postures = rng.uniform(arm.lower, arm.upper, (20, arm.model.nq))
    return max(int(np.linalg.matrix_rank(arm.tip_jacobian(q)[1], tol=1e-3)) for q in postures)


def load_of(arm: ArmModel) -> tuple[float, Array]:
    """Returns the mass behind the last joint [kg] and its centre in the frame of that joint [m]."""
    inertia = arm.model.inertias[arm.model.njoints - 1]
    return float(inertia.mass), np.array(inertia.lever)


def holding_efforts(arm: ArmModel, payload: float) -> Array:
    """Returns the greatest efforts that hold the arm and a payload [kg] at its tip, in any posture [N m or N]."""
    model, tip = arm.model.copy(), arm.model.frames[arm.tip]
    model.appendBodyToJoint(tip.parentJoint, pin.Inertia(payload, np.zeros(3), np.zeros((3, 3))), tip.placement)
    data, rng = model.createData(), np.random.default_rng(0)
    postures = rng.uniform(arm.lower, arm.upper, (_SAMPLES, model.nq))
    return np.abs([pin.computeGeneralizedGravity(model, data, q) for q in postures]).max(axis=0)  # type: ignore[no-any-return]
