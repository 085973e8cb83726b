"""Common base of the looking primitives: an image from straight above, and the parts it shows."""

from __future__ import annotations

import math

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_primitives.part_models import part_models
from skiros_primitives.poses import downward
from skiros_py.devices.camera import Camera, CameraSpec
from skiros_py.geometry import Pose
from skiros_py.ports.kinematics import Kinematics
from skiros_py.ports.motion import NoMotion, PoseMove
from skiros_py.ports.perception import LookRequest, LookResult, PartDetector, Region
from skiros_py.ports.values import DepthImage
from skiros_py.skills.primitive import Execution

_LOOK_HEIGHTS = (0.46, 0.40, 0.34)
"""Heights of the camera above the viewed surface, best first [m]; low ones for when the arm cannot reach higher."""


class LookingPrimitive(ArmPrimitive):
    """Base of the primitives that look; their parameters have fields ``arm`` and ``camera``."""

    def look_for_parts(self, region: Region, x: float, y: float) -> Execution[LookResult | NoMotion]:
        """Searches a region for parts, in a picture from straight above a point of the map [m]."""
        camera = self.camera_spec(self.params.camera)
        detector = self.context.port(PartDetector, camera.id)
        image = yield from self.look_down(camera, x, y, region.pose.position[2])
        if isinstance(image, NoMotion):
            return image
        pose = self.camera_pose(camera, image)
        request = LookRequest(image, pose, region, part_models(self.world), self.seed(), camera.id)
        return (yield from self.wait(detector.detect(request)))

    def look_down(
        self, camera: CameraSpec, x: float, y: float, surface: float, *, aside: float = 0.0
    ) -> Execution[DepthImage | NoMotion]:
        """Takes a picture from straight above a point of the map.

        Args:
            camera: The camera.
            x: Where to look, in the map [m].
            y: Where to look, in the map [m].
            surface: Height of the viewed surface, in the map [m].
            aside: How far to retract the tool [m]: a part in the gripper hides that side of the image, so the point
                should lie on the other side.
        """
        tool_camera = self._camera_in_tool(camera)
        answer: NoMotion | None = NoMotion("no height tried")
        for height in _LOOK_HEIGHTS:
            poses = [downward(x, y, surface + height, yaw) @ tool_camera.inverse() for yaw in self._yaws()]
            back = Pose((-aside, 0.0, 0.0))
            answer = yield from self.go([(PoseMove(pose @ back),) for pose in poses])
            if answer is None:
                return (yield from self.wait(Camera(self.context.board, camera.id).capture()))
        return NoMotion(f"cannot look at ({x:.2f}, {y:.2f}) from above: {answer.reason}" if answer else "")

    def camera_pose(self, camera: CameraSpec, image: DepthImage) -> Pose:
        """Returns the camera pose in the map when it took an image, from joints and localisation."""
        return self.context.frames.at(image.snapshot).located(camera.id)

    def camera_spec(self, camera: str) -> CameraSpec:
        """Returns the description of one of the robot's cameras."""
        return self.context.cell.device(camera, CameraSpec)

    def _yaws(self) -> list[float]:
        return [self.base_pose.yaw + quarter * math.pi / 2.0 for quarter in range(4)]

    def _camera_in_tool(self, camera: CameraSpec) -> Pose:
        kinematics = self.context.port(Kinematics, self.params.arm)
        positions = dict(zip(self.arm_spec.joints, self.arm.state.positions, strict=True))
        tool, optical = (kinematics.pose(link, positions) for link in (self.arm_spec.tip, camera.frame))
        return tool.inverse() @ optical
