"""Finds where a camera sits on its hand, from pictures of a marker board taken from around it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import islice
from typing import ClassVar

from skiros_primitives.board_views import board_views
from skiros_primitives.looking import LookingParams, LookingPrimitive
from skiros_py.devices.camera import CameraSpec
from skiros_py.geometry import Pose
from skiros_py.messages import Message
from skiros_py.ports.calibration import (
    BoardPicture,
    CalibrationRequest,
    CalibrationResult,
    CameraCalibrator,
    MarkerBoard,
    face_of,
)
from skiros_py.ports.motion import NoMotion, PoseMove
from skiros_py.skills.cell_reader import read_board
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import map_pose, solid_of
from skiros_py.world import vocabulary as v

_VIEWS = 15
_TRIES = 45
"""Of so many views, those are taken that the arm reaches, until there are enough."""


class CalibrateCamera(LookingPrimitive):
    """Takes pictures from all around the board; writes where the camera is, unless they leave that open."""

    name: ClassVar[str] = "calibrate_camera"

    @dataclass(frozen=True, slots=True)
    class Params(LookingParams):
        """Parameters."""

        camera: str = param(v.CAMERA, "The camera to calibrate, on the arm.", kind=Kind.HARDWARE)
        board: str = param(v.MARKER_BOARD, "The board, which the arm reaches all around.")

    def execute(self) -> Execution[Outcome]:
        """Looks from around, and finds the camera."""
        if not self.carries(self.params.camera):
            known = {"camera": self.params.camera, "arm": self.params.arm}
            return Failure(Message("{camera} is not on {arm}: it cannot be moved around a board", **known))
        board, solid = read_board(self.world, self.params.board), solid_of(self.world, self.params.board)
        where = map_pose(self.context, self.params.board)
        if board is None or solid is None or where is None:
            return Failure(Message("the position of {board} is unknown", board=self.params.board))
        face = where @ face_of(board, solid)
        pictures = yield from self._pictures(board, face)
        calibrator = self.context.port(CameraCalibrator, self.params.camera)
        believed, robot = self.context.frames.mounting(self.params.camera), self.base_pose
        request = CalibrationRequest(pictures, board, believed, robot.inverse() @ face)
        result = yield from self.wait(calibrator.calibrate(request))
        if result.pose is None:
            why = {"camera": self.params.camera, "reason": result.reason}
            return Failure(Message("{camera} cannot be calibrated: {reason}", **why))
        return self._take_over(result, result.pose, believed)

    def _pictures(self, board: MarkerBoard, face: Pose) -> Execution[tuple[BoardPicture, ...]]:
        """Takes pictures of a board from as many views as the arm reaches, in the frame of the robot."""
        camera = self.context.cell.device(self.params.camera, CameraSpec)
        first = yield from self.take_picture(camera.id)
        back, taken = self.camera_in_tip(camera).inverse(), list[BoardPicture]()
        for view in islice(board_views(board, face, first.intrinsics), _TRIES):
            refusal = yield from self.go([(PoseMove(view @ back),)])
            if isinstance(refusal, NoMotion):
                continue
            image, pose = yield from self.capture()
            robot = self.context.frames.at(image.snapshot).robot(camera.id)
            carrier = robot.inverse() @ pose @ self.context.frames.mounting(camera.id).inverse()
            taken.append(BoardPicture(image, carrier))
            self.progress(len(taken), Message("picture {number} of {count}", number=len(taken), count=_VIEWS))
            if len(taken) == _VIEWS:
                break
        return tuple(taken)

    def _take_over(self, result: CalibrationResult, found: Pose, believed: Pose) -> Outcome:
        change = believed.inverse() @ found
        known = {
            "camera": self.params.camera,
            "moved": 1e3 * math.hypot(*change.position),
            "turned": math.degrees(2.0 * math.acos(min(1.0, abs(change.orientation[3])))),
            "residual": result.residual,
        }
        reason = Message(
            "{camera} is {moved:.1f} mm and {turned:.2f} deg from where it was believed, within {residual:.2f} px",
            **known,
        )
        with self.world.transaction(author=self.name, reason=reason) as tx:
            tx.set(self.params.camera, v.MOUNTING, found)
            tx.set(self.params.camera, v.CALIBRATION_RESIDUAL, round(result.residual, 3))
            tx.set(self.params.camera, v.SIGHT_ERROR, None)
        self.context.frames.mount(self.params.camera, found)
        return Success(reason)
