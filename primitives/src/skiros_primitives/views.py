"""Pictures: taken by a camera on an arm, shown to its planner with all that they may show and that is known."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from skiros_primitives.obstacle_review import review_obstacles
from skiros_primitives.surfaces import support_region
from skiros_py import geometry
from skiros_py.devices.arm import Arm, ArmSpec
from skiros_py.devices.camera import Camera, CameraSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.errors import DeviceError
from skiros_py.geometry import Array, Pose, Solid
from skiros_py.messages import Message
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.frames import FrameTree
from skiros_py.ports.kinematics import BASE_LINK, Kinematics
from skiros_py.ports.motion import DepthView, MotionCheck, NoMotion, Obstacle, SceneMapper
from skiros_py.ports.perception import HeldRegistrar, HeldRequest, HeldResult
from skiros_py.ports.values import DepthImage, Pending
from skiros_py.skills.context import RunContext
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.surroundings import held_by, map_pose, solid_of
from skiros_py.world import vocabulary as v

_STRIDE = 2
"""Of the rows and columns of a picture, every so many is used."""
_HEIGHT = 1.2
"""Height of a robot whose links are not known [m]."""
_LINK = 0.12
"""How far links stick out around the line between their joints, and bases above where links begin on them [m]."""
_FINGER = 0.03
"""The same around what is on a hand [m]."""
_NEAR = 2.5
"""How far from a camera places may be that it shows [m]."""
_APART = 0.05
"""Where another robot is, is uncertain by so much [m]."""
_LOOK_EVERY = 0.2
"""Time from what a picture showed in the way of an arm to the next picture [s]."""
_SILENCE = 10.0
"""How long a camera may be silent [s]."""
_ASK_AGAIN = 0.1
"""Time after which it is asked again [s]."""


def depth_view(context: RunContext, arm: str, image: DepthImage, camera: str, around: Sequence[Obstacle]) -> DepthView:
    """Returns a picture for the planner of an arm.

    Args:
        context: The run.
        arm: Id of the arm.
        image: The picture.
        camera: Id of the camera that took it.
        around: What is believed to stand around, with the errors of where it is.
    """
    tree, k = context.frames.at(image.snapshot), image.intrinsics
    depth = image.depth[::_STRIDE, ::_STRIDE].copy()
    height, width = depth.shape
    cx, cy = k.cx / _STRIDE, k.cy / _STRIDE
    intrinsics = replace(k, width=width, height=height, fx=k.fx / _STRIDE, fy=k.fy / _STRIDE, cx=cx, cy=cy)
    own, camera_pose = context.cell.group_of(arm), tree.located(camera)
    near = [one for one in around if math.dist(one.pose.position, camera_pose.position) < _NEAR]
    known = (*around, *unlocated(context, near))
    moving = tuple(
        replace(one, error=0.0 if robot is own else _APART)
        for robot in context.cell.robots
        for one in robot_blocks(context, robot, tree)
    )
    return DepthView(arm, depth, intrinsics, camera_pose, image.snapshot.time, known, moving)


def unlocated(context: RunContext, places: Iterable[Obstacle]) -> Iterator[Obstacle]:
    """Yields the space on places in which things may be that were put there and not been seen yet."""
    for place in places:
        block = _unlocated(context, place.id)
        if block is not None:
            yield block


def _unlocated(context: RunContext, place: str) -> Obstacle | None:
    """Returns the space on a place in which things may be that were put there and not been seen yet; None for none."""
    world, height = context.world, 0.0
    for thing in world.subjects(v.IN, place):
        solid = solid_of(world, thing) if map_pose(context, thing) is None else None
        if solid is not None:
            low, high = solid.bounds()
            height = max(height, float((high - low).max()))
    region = support_region(context, place) if height else ""
    if isinstance(region, str):
        return None
    (x, y), lift = region.half_extents, Pose((0.0, 0.0, height / 2.0))
    return Obstacle(place, Solid.box(2.0 * x, 2.0 * y, height), region.pose @ lift)


def hand_camera(context: RunContext, arm: str) -> CameraSpec | None:
    """Returns the camera on an arm; None for none."""
    owned = context.world.objects(arm, v.HAS_A)
    return next((one for one in context.cell.group_of(arm).of(CameraSpec) if one.id in owned), None)


def robot_blocks(context: RunContext, robot: RobotSpec, tree: FrameTree, thick: float = _LINK) -> Iterator[Obstacle]:
    """Yields a robot as blocks: its base, its links and what its grippers hold.

    Args:
        context: The run.
        robot: The robot.
        tree: Where everything is.
        thick: How far links stick out around the line between their joints [m].
    """
    base, height = robot.pose(tree.snapshot, context.board.guard), _HEIGHT
    kinematics = context.frames.kinematics(robot)
    if kinematics is not None:
        links = {BASE_LINK: Pose(), **kinematics.poses(tree.joints(robot))}
        places = dict(zip(links, base.apply(np.array([pose.position for pose in links.values()])), strict=True))
        height, hands = _LINK, {kinematics.parents.get(arm.tip) for arm in robot.of(ArmSpec)}
        for link, parent in kinematics.parents.items():
            if parent == BASE_LINK:
                height = max(height, links[link].position[2] + _LINK)
            else:
                yield _rod(robot.id, places[parent], places[link], _FINGER if parent in hands else thick)
    xs, ys = zip(*robot.outline, strict=True)
    middle = Pose(((min(xs) + max(xs)) / 2.0, (min(ys) + max(ys)) / 2.0, height / 2.0))
    block = geometry.Primitive("box", (max(xs) - min(xs), max(ys) - min(ys), height))
    yield Obstacle(robot.id, Solid((block,)), base @ middle)
    for gripper in robot.of(GripperSpec):
        holding = held_by(context, gripper.id)
        if holding is not None:
            part, held = holding
            yield Obstacle(part, held.solid, tree.located(gripper.arm) @ held.pose)


def _rod(name: str, start: Array, end: Array, radius: float) -> Obstacle:
    """Returns a rod around the line between the places of two links in the map [m], which may be one place."""
    way = end - start
    length = float(np.linalg.norm(way))
    x, y, z = (start + way / 2.0).tolist()
    tilt = math.acos(max(-1.0, min(1.0, float(way[2]) / length))) if length > 0.0 else 0.0
    block = geometry.Primitive("cylinder", (radius, length + 2.0 * radius))
    return Obstacle(name, Solid((block,)), Pose.of(x, y, z, pitch=tilt, yaw=math.atan2(way[1], way[0])))


def repainted(image: DepthImage, solid: Solid, pose: Pose, around: float, depth: float) -> DepthImage:
    """Returns a picture with another depth where it shows something.

    Args:
        image: The picture.
        solid: Its shape.
        pose: Its pose in the optical frame.
        around: How far beside the box around it may be what is seen of it [m].
        depth: The depth [m]; 0 for nothing that was measured.
    """
    low, high = solid.bounds()
    at = pose.inverse().apply(image.points())
    v, u = np.nonzero(image.depth > 0.0)
    shown = np.all((at >= low - around) & (at <= high + around), axis=1)
    if not shown.any():
        return image
    painted = image.depth.copy()
    painted[v[shown], u[shown]] = depth
    return replace(image, depth=painted)


class SeeingPrimitive(Primitive[Any]):
    """Base of the primitives of an arm with a camera and a planner; their parameters have a field ``arm``."""

    looks_ahead: ClassVar[bool] = True
    """Whether it takes pictures while its arm moves freely."""

    @property
    def arm(self) -> Arm:
        """The arm."""
        return Arm(self.context.board, self.params.arm)

    @property
    def robot(self) -> RobotSpec:
        """The robot that the arm belongs to."""
        return self.context.cell.group_of(self.params.arm)

    def carries(self, camera: str) -> bool:
        """Returns whether a camera is on the arm, rather than on something else or over the place."""
        return camera in self.world.objects(self.params.arm, v.HAS_A)

    def camera_in_tip(self, camera: CameraSpec) -> Pose:
        """Returns the pose of a camera on the arm's hand in the frame of the tip."""
        kinematics = self.context.port(Kinematics, self.params.arm)
        positions = dict(zip(self.arm.spec.joints, self.arm.state.positions, strict=True))
        tip, optical = (kinematics.pose(link, positions) for link in (self.arm.spec.tip, camera.frame))
        return tip.inverse() @ optical @ self.context.frames.mounting(camera.id)

    def how_it_sits(
        self, image: DepthImage, camera: str, part: str, guess: Pose, around: Iterable[Obstacle]
    ) -> Execution[HeldResult | None]:
        """Finds in a picture how a part sits in the gripper; None without a port for that, or a shape of the part.

        Args:
            image: The picture.
            camera: Id of the camera, which is on the arm's hand.
            part: Id of the part.
            guess: How it is expected to sit, in the frame of the tip.
            around: What is believed to stand around, with the errors of where it is.
        """
        registrar, solid = self.context.ports.find(HeldRegistrar, camera), solid_of(self.world, part)
        if registrar is None or solid is None or not self.carries(camera):
            return None
        place = self.camera_in_tip(self.context.cell.device(camera, CameraSpec))
        tip = self.context.frames.at(image.snapshot).located(camera) @ place.inverse()
        to_tip, (x, y, z) = tip.inverse(), tip.matrix()[2, :3].tolist()
        others = tuple(  # after a low lift, it is still between its neighbours, or beside a wall
            replace(one, pose=to_tip @ one.pose)
            for one in around
            if one.id != part and math.dist(one.pose.position, tip.position) < _NEAR
        )
        request = HeldRequest(image, place, solid, guess, camera, part, (x, y, z), others)
        return (yield from self.wait(registrar.sits(request)))

    def take_picture(self, camera: str) -> Execution[DepthImage]:
        """Takes a picture; a camera that is silent for a moment is asked again.

        Raises:
            DeviceError: It stays silent.
        """
        handle, deadline = Camera(self.context.board, camera), self.context.now + _SILENCE
        while True:
            try:
                picture = handle.capture()
                while not (self.context.lockstep or picture.done()):
                    if self.context.now >= deadline:
                        raise DeviceError("{camera} sends no picture", camera=camera)
                    yield
                image = yield from self.wait(picture)
                self.context.pictures.add(image, camera, self.robot.id)
                return image
            except DeviceError:
                if self.context.now >= deadline:
                    raise
            yield from self.context.sleep(_ASK_AGAIN)

    def show_pictures(self, around: Sequence[Obstacle]) -> Pending[tuple[Obstacle, ...]] | None:
        """Shows the planner the pictures that it has not got yet; returns its last answer, None for no picture."""
        mapper, seen = self.context.ports.find(SceneMapper, self.params.arm), None
        for image, camera in self.context.pictures.take(self.robot.id):
            with suppress(DeviceError):  # where the camera was, or a robot, is unknown
                view = depth_view(self.context, self.params.arm, image, camera, around)
                review_obstacles(self.context, self.name, view)
                seen = seen if mapper is None else mapper.see(view)
        return seen

    def note_unknown(self, seen: Pending[tuple[Obstacle, ...]] | None) -> None:
        """Keeps what pictures have shown that is unknown; announces it when that is more than before.

        Args:
            seen: The planner's answer to the last of them, after a later answer of its has come; None for no picture.
        """
        if seen is None or not (self.context.lockstep or seen.done()):
            return
        before = self.context.pictures.unknown.get(self.robot.id, ())
        unknown = self.context.pictures.unknown[self.robot.id] = seen.result()
        if len(unknown) > len(before):
            self.emit("unknown_seen", {"things": len(unknown), "at": [one.pose.position for one in unknown]})

    def look_ahead(
        self, around: Callable[[], tuple[Obstacle, ...]], rest: Callable[[], MotionCheck]
    ) -> Execution[NoMotion] | None:
        """Takes pictures while the arm moves, until one shows something unknown in the rest of its way.

        Args:
            around: Returns what is believed to stand around, with the errors of where it is.
            rest: Returns what is left of the motion.

        Returns:
            What answers only then; None where the arm has no camera or no planner that takes pictures.
        """
        mapper = self.context.ports.find(SceneMapper, self.params.arm) if self.looks_ahead else None
        if mapper is None:
            return None
        camera = self.hand_camera
        return None if camera is None else self._way_seen(mapper, camera.id, around(), rest)

    @property
    def hand_camera(self) -> CameraSpec | None:
        """The camera on the arm; None for none."""
        return hand_camera(self.context, self.params.arm)

    def _way_seen(
        self, mapper: SceneMapper, camera: str, around: tuple[Obstacle, ...], rest: Callable[[], MotionCheck]
    ) -> Execution[NoMotion]:
        while True:
            try:
                yield from self.take_picture(camera)
            except DeviceError:  # a motion that was planned needs no pictures
                yield from self.context.sleep(_LOOK_EVERY)
                continue
            seen = self.show_pictures(around)
            blocked = yield from self.wait(mapper.blocked(rest()))
            self.note_unknown(seen)
            if blocked is not None:
                why = Message("{arm} stops on its way: {reason}", arm=self.params.arm, reason=blocked.reason)
                return replace(blocked, reason=why)
            yield from self.context.sleep(_LOOK_EVERY)
