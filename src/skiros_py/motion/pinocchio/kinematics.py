"""Kinematics of a whole robot."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pinocchio as pin

from skiros_py.errors import UnknownName
from skiros_py.geometry import Array, Pose
from skiros_py.ports.kinematics import JointRange
from skiros_py.ports.models import BASE_LINK, write_robot_urdf


class PinocchioKinematics:
    """The links and joints of a robot model; a :class:`skiros_py.ports.kinematics.Kinematics`.

    Args:
        urdf: Its description. Poses are seen from its base link, or from its root where it has no link of that name.

    Attributes:
        parents: The link on which each link is mounted.
        joints: The movable joints by name.
    """

    def __init__(self, urdf: Path) -> None:
        model = self._model = pin.buildModelFromUrdf(str(urdf))
        self._data = threading.local()
        self._joints = {name: joint for name, joint in zip(model.names, model.joints, strict=True) if joint.nv == 1}
        self.joints: Mapping[str, JointRange] = {name: self._range(joint) for name, joint in self._joints.items()}
        bodies = [frame for frame in model.frames if frame.type == pin.FrameType.BODY]
        self._frames = {str(frame.name): int(model.getFrameId(frame.name)) for frame in bodies}
        self._base = self._frames.get(BASE_LINK, next(iter(self._frames.values())))
        self.parents: Mapping[str, str] = dict(self._mounts())

    def pose(self, link: str, positions: Mapping[str, float]) -> Pose:
        """Returns the pose of a link in the frame of the base link.

        Raises:
            UnknownName: The robot has no such link.
        """
        frame = self._frame(link)
        data = self._computed(positions)
        return Pose.from_matrix(data.oMf[self._base].actInv(data.oMf[frame]).homogeneous)

    def poses(self, positions: Mapping[str, float]) -> dict[str, Pose]:
        """Returns the poses of all links in the frame of the base link."""
        data = self._computed(positions)
        base = data.oMf[self._base]
        return {link: Pose.from_matrix(base.actInv(data.oMf[self._frames[link]]).homogeneous) for link in self.parents}

    def jacobian(self, link: str, positions: Mapping[str, float], joints: Sequence[str]) -> Array:
        """Returns the velocity of a link per velocity of some joints, in the frame of the link, shape (6, joints).

        Raises:
            UnknownName: The robot has no such link or joint.
        """
        frame = self._frame(link)
        for joint in joints:
            if joint not in self._joints:
                raise UnknownName("joint", joint, self._joints)
        whole = pin.computeFrameJacobian(self._model, self._fresh(), self._posture(positions), frame, pin.LOCAL)
        return np.asarray(whole[:, [self._joints[joint].idx_v for joint in joints]])

    def _computed(self, positions: Mapping[str, float]) -> pin.Data:
        data = self._fresh()
        pin.framesForwardKinematics(self._model, data, self._posture(positions))
        return data

    def _fresh(self) -> pin.Data:
        """Returns the workspace of the calling thread."""
        if not hasattr(self._data, "own"):
            self._data.own = self._model.createData()
        return self._data.own

    def _posture(self, positions: Mapping[str, float]) -> Array:
        posture: Array = pin.neutral(self._model)
        for name, position in positions.items():
            joint = self._joints.get(name)
            if joint is not None and joint.nq == 1:
                posture[joint.idx_q] = position
            elif joint is not None:  # a joint that turns without end
                posture[joint.idx_q : joint.idx_q + 2] = math.cos(position), math.sin(position)
        return posture

    def _range(self, joint: pin.JointModel) -> JointRange:
        velocity = float(self._model.velocityLimit[joint.idx_v])
        speed = velocity if 0.0 < velocity < math.inf else None
        if joint.nq != 1:
            return JointRange(None, None, speed)
        lower, upper = self._model.lowerPositionLimit[joint.idx_q], self._model.upperPositionLimit[joint.idx_q]
        return JointRange(float(lower), float(upper), speed)

    def _mounts(self) -> list[tuple[str, str]]:
        """Returns the links below the base link, each with the link on which it is mounted."""
        found: dict[str, str] = {}
        base = str(self._model.frames[self._base].name)
        for link, index in self._frames.items():
            frame = self._model.frames[index]
            while frame.parentFrame != 0:
                frame = self._model.frames[frame.parentFrame]
                if frame.type == pin.FrameType.BODY:
                    break
            if frame.name != link and (frame.name == base or frame.name in found):
                found[link] = str(frame.name)
        return list(found.items())

    def _frame(self, link: str) -> int:
        if link not in self._frames:
            raise UnknownName("link", link, self._frames)
        return self._frames[link]


@cache
def kinematics_of(model: str) -> PinocchioKinematics:
    """Returns the kinematics of a robot model, which is loaded once.

    Raises:
        UnknownName: No distribution provides that model.
        SkirosError: It cannot be read.
    """
    with TemporaryDirectory(prefix="skiros-model-") as directory:
        return PinocchioKinematics(write_robot_urdf(model, Path(directory)))
