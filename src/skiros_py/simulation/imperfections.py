"""What a simulation may be no better at than a real cell: measuring by hand, calibration, depth cameras.

All errors are drawn from the run's seed and scaled by one factor; 0 leaves them out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from skiros_py.geometry import Array, Pose
from skiros_py.ports.cell import BodySpec, CellSpec

_PLACE, _TURN = 0.010, math.radians(2.0)  # greatest errors of a pose that a person has measured [m, rad]
_MOUNTING, _TILT = 0.001, math.radians(0.2)  # standard deviations of a calibrated camera on its link [m, rad]
_NOISE_AT = 0.5  # distance at which a camera has the noise that is stated [m]
_STEP = 0.001  # distances come in steps [m]
_EDGE = 0.02  # difference of neighbouring distances that is an edge [m]
_LOST = 0.5  # share of pixels at edges that have no distance


def measured_off(spec: CellSpec, poses: Mapping[str, Pose], seed: int, scale: float) -> dict[str, Pose]:
    """Returns where bodies really are that a scene states as someone has measured them.

    What is fixed is moved and turned on the floor; what stands on it, and its compartments, come along.

    Args:
        spec: The cell.
        poses: The poses in the map that it states or draws, by body.
        seed: The run's seed.
        scale: Factor of all errors.
    """
    bodies = {body.id: body for body in spec.bodies}
    real: dict[str, Pose] = {}

    def place(body: BodySpec) -> Pose:
        if body.id not in real:
            below = bodies.get(body.place or "")
            carried = poses[body.id]
            if below is not None and below.id in poses:
                carried = place(below) @ (poses[below.id].inverse() @ carried)
            fixed = body.mass == 0.0 and body.carrier is None and not body.compartment
            real[body.id] = carried @ _error_on_floor(body.id, seed, scale) if fixed else carried
        return real[body.id]

    return {body.id: place(body) for body in spec.bodies if body.id in poses}


def _error_on_floor(name: str, seed: int, scale: float) -> Pose:
    x, y, turn = np.random.default_rng([seed, 1, *name.encode()]).uniform(-scale, scale, 3).tolist()
    return Pose.of(_PLACE * x, _PLACE * y, 0.0, yaw=_TURN * turn)


def mounting_error(camera: str, seed: int, scale: float) -> Pose:
    """Returns where the optical frame of a camera really is, in the frame where its calibration says that it is."""
    x, y, z, roll, pitch, yaw = np.random.default_rng([seed, 2, *camera.encode()]).normal(0.0, scale, 6).tolist()
    return Pose.of(_MOUNTING * x, _MOUNTING * y, _MOUNTING * z, roll=_TILT * roll, pitch=_TILT * pitch, yaw=_TILT * yaw)


def knocked(seed: int, move: float, tilt: float) -> Pose:
    """Returns a bad error of a camera's mounting: sideways, and tilted so that both add up in what it sees.

    Args:
        seed: Draws to which side.
        move: Distance [m].
        tilt: Angle [rad].
    """
    side = np.random.default_rng([seed, 3]).uniform(0.0, math.tau)
    x, y = math.cos(side), math.sin(side)
    half = tilt / 2.0  # about the axis (-y, x), which tips the optical axis towards that side
    return Pose((move * x, move * y, 0.0), (-math.sin(half) * y, math.sin(half) * x, 0.0, math.cos(half)))


def measured_depth(depth: Array, noise: float, rng: np.random.Generator, scale: float) -> Array:
    """Returns distances as a depth camera measures them.

    Noise grows with the square of the distance, distances come in steps, and some pixels at edges have none.

    Args:
        depth: True distances [m]; infinite where there is nothing.
        noise: Standard deviation at half a metre [m].
        rng: Source of the errors.
        scale: Factor of all that is more than this noise, the same at every distance.
    """
    from scipy.ndimage import maximum_filter, minimum_filter  # half a second of imports that most processes never need

    seen = np.isfinite(depth)
    distance = np.where(seen, depth, 0.0)
    growing = 1.0 + scale * ((distance / _NOISE_AT) ** 2 - 1.0)
    measured = depth + noise * np.maximum(growing, 0.0) * rng.normal(size=depth.shape)
    if scale > 0.0:
        measured[seen] = np.round(measured[seen] / (scale * _STEP)) * (scale * _STEP)
        jumps = maximum_filter(distance, 3) - minimum_filter(distance, 3) > _EDGE
        measured[jumps & (rng.random(depth.shape) < scale * _LOST)] = np.inf
    return np.asarray(measured)
