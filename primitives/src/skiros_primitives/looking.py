"""How primitives look: from which side, with which camera, and what they do with the picture.

The camera looks straight down wherever the arm can hold it so; at high places, it looks at them from the side.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from skiros_primitives.arm_moves import ArmPrimitive, further, refused
from skiros_primitives.camera_check import is_turned
from skiros_primitives.cameras import OVER, best_camera
from skiros_primitives.part_models import downward, part_models
from skiros_primitives.surfaces import inner_region
from skiros_primitives.views import repainted, unlocated
from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.camera import CameraSpec
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.messages import Message
from skiros_py.ports.kinematics import Kinematics
from skiros_py.ports.motion import SHARES, MotionPlan, NoMotion, PoseMove, Route, Vector
from skiros_py.ports.perception import (
    DetectionRequest,
    DetectionResult,
    PartDetector,
    Region,
    Registrar,
    RegistrationRequest,
    RegistrationResult,
)
from skiros_py.ports.values import DepthImage
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Failure, tick
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.pictures import Sighting
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import held_by, map_pose, obstacles, solid_of
from skiros_py.world import vocabulary as v
from skiros_py.world.element import Placement
from skiros_py.world.poses import write_pose
from skiros_py.world.transaction import Transaction

_LOOK_HEIGHTS = (OVER, 0.40, 0.34)
"""Heights of the camera above the viewed surface where it looks straight down, best first [m]."""
_LOW = (0.28, 0.22)
"""The same where all else is impossible [m]: from there it does not see the whole of a kit."""
_QUARTERS = 4
"""The camera is turned to so many sides."""
_TILTS = (math.radians(25.0), math.radians(45.0))
"""Angles off the vertical at which it looks where the arm cannot hold it straight above, best first."""
_DISTANCES = (0.42, 0.36, 0.30)
"""Distances at which it looks from the side, best first [m]."""
_SIDES = (math.pi, math.pi - math.radians(50.0), math.pi + math.radians(50.0))
"""From where it looks then, against the heading of the base, which faces the place: from the arm, and from beside."""
_ROUND = 6
"""From so many sides it may look at a place at which it is not known yet where the base will stand."""
_THERE = 0.02
"""A camera this near to where it should look from need not move [m] ..."""
ALIGNED = math.radians(3.0)
"""... if it is aligned this well."""


@dataclass(frozen=True, slots=True)
class View:
    """How a camera looks at a point.

    Attributes:
        tilt: Angle between its axis and the vertical [rad].
        side: Heading from the point to the camera, or of the camera's x axis where it looks straight down; against the
            heading of the base [rad].
        turn: How far it is turned about its axis [rad].
    """

    tilt: float
    side: float
    turn: float = 0.0

    def pose(self, point: Vector, distance: float, heading: float) -> Pose:
        """Returns where the camera is.

        Args:
            point: What it looks at, in the map [m].
            distance: How far it is from there [m].
            heading: Heading of the base in the map [rad].
        """
        x, y, z = point
        if not self.tilt:
            return downward(x, y, z + distance, heading + self.side)
        leaning = Pose.of(x, y, z, yaw=heading + self.side) @ Pose.of(0.0, 0.0, 0.0, pitch=self.tilt)
        return leaning @ downward(0.0, 0.0, distance, self.turn)


_QUARTER_TURNS = tuple(math.tau * quarter / _QUARTERS for quarter in range(_QUARTERS))
VIEWS = (
    *(View(0.0, turn) for turn in _QUARTER_TURNS),
    *(View(tilt, side, turn) for tilt, side, turn in product(_TILTS, _SIDES, _QUARTER_TURNS)),
)
_DOWN = range(_QUARTERS)
"""Numbers of the views straight down."""
_TILTED = tuple([number for number, view in enumerate(VIEWS) if view.tilt == tilt] for tilt in _TILTS)
_BY_TILT: tuple[tuple[Sequence[int], tuple[float, ...]], ...] = (
    (_DOWN, _LOOK_HEIGHTS),
    *((numbers, _DISTANCES) for numbers in _TILTED),
    (_DOWN, _LOW),
)
"""Numbers of the views that are alike, and at which distances they are taken [m], the best first."""


_CHOSEN = 3
"""Progress code of a camera that was chosen."""
_OFF = 2
"""Progress code of a camera that sees things off."""
UNKNOWN_SHAPE = Message("something of unknown shape")


@dataclass(frozen=True, slots=True, kw_only=True)
class LookingParams:
    """Parameters of every primitive that looks."""

    arm: str = param(v.ARM, "The arm that works there; it moves a camera that it carries.", kind=Kind.HARDWARE)
    camera: str | None = param(
        v.CAMERA, "The camera to look with; left open: the one that sees the place best.", kind=Kind.OPTIONAL
    )


class LookingPrimitive(ArmPrimitive):
    """Base of the primitives that look; their parameters are :class:`LookingParams` and more."""

    looks_again = True
    _view: int | None = None
    """From which side the last picture was taken."""
    _seen_from: tuple[Pose, Pose]
    """Where robot and camera were in the map when the picture was taken that was searched last."""

    _first: Sighting | None = None
    """Where something was seen, while the next look is to be from another side, which tells of the camera."""
    _chosen: str | None = None
    """The camera that sees best what is to be seen, where none is named."""

    @property
    def camera(self) -> str:
        """Id of the camera that it looks with: the one that is named, or was chosen, or is on the arm.

        Raises:
            DeviceError: The arm has none.
        """
        named: str | None = self.params.camera or self._chosen
        if named is None and (own := self.hand_camera) is not None:
            return own.id
        if named is None:
            raise DeviceError("no camera sees what {arm} is to look at: name one", arm=self.params.arm)
        return named

    def choose_camera(self, region: Region, most: float | None = None, without: Collection[str] = ()) -> None:
        """Chooses the camera that sees a place best, where none is named; see :func:`best_camera`."""
        if self.params.camera is None:
            self._chosen = best_camera(self.context, self.arm.spec, region, most, without)
            if self._chosen is not None and not self.carries(self._chosen):
                self.progress(_CHOSEN, Message("looks with {camera}", camera=self._chosen))

    def tell(self, off: Message | None) -> None:
        """Says that a camera is off, where it is."""
        if off is not None:
            self.progress(_OFF, off)

    def in_vain(self, reason: str) -> Failure:
        """Returns a failure; the next look for the same purpose is one from another side."""
        if self._view is not None:
            angle = math.degrees(VIEWS[self._view].side)
            self.context.tried.note("view", self._view, Message("looked from {angle:.0f} deg", angle=angle))
        return Failure(reason)

    def look_for_parts(self, region: Region, x: float, y: float) -> Execution[DetectionResult | NoMotion]:
        """Searches a region for parts, in a picture from straight above a point of the map [m]."""
        picture = yield from self.look_down((x, y, region.pose.position[2]))
        return picture if isinstance(picture, NoMotion) else (yield from self.detect(region, picture))

    def detect(self, region: Region, picture: tuple[DepthImage, Pose]) -> Execution[DetectionResult]:
        """Searches a region in a picture for parts."""
        detector = self.context.port(PartDetector, self.camera)
        image, models = self._below_held(picture[0]), part_models(self.world)
        request = DetectionRequest(image, picture[1], region, models, self.seed(), self.camera)
        self._seen_from = self.context.frames.at(picture[0].snapshot).robot(self.camera), picture[1]
        return (yield from self.wait(detector.detect(request)))

    def _below_held(self, image: DepthImage) -> DepthImage:
        """Returns a picture in which nothing was measured where it shows what the gripper holds: that hides things."""
        held = self.held() if self.carries(self.camera) else None
        if held is None:
            return image
        return repainted(image, held.solid, self.camera_in_tip(self._camera).inverse() @ held.pose, _AROUND_HELD, 0.0)

    def sighting(self, pose: Pose) -> Sighting:
        """Returns where something was seen in the picture that was searched last, by its pose in the map."""
        robot, camera = self._seen_from
        carrier, now = self.context.cell.group_of(self.camera).id, self.context.board.snapshot.time
        return Sighting(robot, robot.inverse() @ camera, robot.inverse() @ pose, carrier, now)

    def capture(self) -> Execution[tuple[DepthImage, Pose]]:
        """Takes a picture from where the camera is; returns it with the camera's pose in the map."""
        image = yield from self.take_picture(self.camera)
        return image, self.context.frames.at(image.snapshot).located(self.camera)

    def look_down(
        self, point: Vector, *, aside: float = 0.0, shown: Vector | None = None
    ) -> Execution[tuple[DepthImage, Pose] | NoMotion]:
        """Takes a picture from above a point; returns it with the camera's pose in the map.

        Straight down wherever that is possible, else from a side. Where the camera looks at it from there already,
        nothing moves; nor where it is not on the arm.

        Args:
            point: Where to look, on the viewed surface in the map [m].
            aside: How far to retract the tool [m]: a part in the gripper hides that side of the image, so the point
                should lie on the other side.
            shown: A place beside the point that what is held should not hide, in the map [m].
        """
        if not self.carries(self.camera):
            return (yield from self.capture())
        base = self.base_pose
        refusal: NoMotion | None = None
        unseen = tuple(unlocated(self.context, obstacles(self.context, parts=False)))
        beyond: set[tuple[float, int]] = set()  # what is out of reach stays so, however near to things it may be
        for space, (numbers, distances) in product((unseen, ()) if unseen else ((),), _BY_TILT):
            choices = product(SHARES, distances, self._sides(numbers, point, base, shown))
            for share, distance, views in choices:  # rather lower than nearer to things, or where some may be
                if (distance, views[0]) in beyond:
                    continue
                options = {"shares": (share,), "unseen": space}
                stuck = yield from self._take_view(views, point, distance, base, aside=aside, **options)
                if stuck is None:
                    return (yield from self.capture())
                beyond |= {(distance, views[0])} if refused(stuck).is_out_of_reach else set()
                refusal = further(refusal, stuck)
        assert refusal is not None, "each view is taken or refused"
        x, y, _ = point
        reason = Message("cannot look at ({x:.2f}, {y:.2f}) from above: {reason}", x=x, y=y, reason=refusal.reason)
        return replace(refusal, reason=reason)

    def _take_view(
        self, views: Sequence[int], point: Vector, distance: float, base: Pose, *, aside: float, **options: Any
    ) -> Execution[NoMotion | None]:
        """Moves the camera to one of some views, unless it looks from there already; returns why it does not."""
        at = None if aside else self._looks_from(point, distance, base, views)
        if at is None:
            planned = yield from self.plan(self._routes(point, distance, base, views, aside=aside), **options)
            stuck = planned if isinstance(planned, NoMotion) else (yield from self.follow_plan(planned))
            if stuck is not None or isinstance(planned, NoMotion):
                return stuck
            at = views[planned.route]
        self._view = at
        return None

    def plan_look(self, point: Vector, base: Pose, shown: Vector | None = None) -> Execution[MotionPlan | NoMotion]:
        """Plans the motion to where the camera looks straight down at a point, as for :meth:`look_down`.

        Args:
            point: Where to look, on the viewed surface in the map [m].
            base: Where the base will be then, in the map.
            shown: A place beside the point that what is held should not hide, in the map [m].
        """
        fresh, *_ = self._sides(_DOWN, point, base, shown)
        return (yield from self.plan(self._routes(point, _LOOK_HEIGHTS[0], base, fresh), base=base))

    def _sides(self, numbers: Sequence[int], point: Vector, base: Pose, shown: Vector | None) -> list[list[int]]:
        """Returns some views in groups, those first that promise more.

        What is held hides the half of a picture in which the tip is.
        """
        fresh = list(self.context.tried.fresh("view", numbers))
        if shown is not None and self.held() is not None:
            tip = self.camera_in_tip(self._camera).inverse().position[:2]

            def is_beside(number: int) -> bool:
                place = VIEWS[number].pose(point, _DISTANCES[0], base.yaw).inverse() @ Pose(shown)
                return place.position[0] * tip[0] + place.position[1] * tip[1] < 0.0

            fresh = list(filter(is_beside, fresh)) or fresh
        turned = self._turned(fresh, point, base)
        return [some for some in (turned or fresh, [one for one in numbers if one not in (turned or fresh)]) if some]

    def _turned(self, numbers: Sequence[int], point: Vector, base: Pose) -> list[int]:
        """Returns those views from which a look tells whether the camera is where it is believed to be."""
        first, distance = self._first, _LOOK_HEIGHTS[0]
        if first is None:
            return []
        return [one for one in numbers if is_turned(first, VIEWS[one].pose(point, distance, base.yaw))]

    def _routes(
        self, point: Vector, distance: float, base: Pose, views: Sequence[int], *, aside: float = 0.0
    ) -> list[Route]:
        camera_in_tip = self.camera_in_tip(self._camera)
        x, y, _ = camera_in_tip.position
        away = -aside / max(1e-9, math.hypot(x, y))
        back = camera_in_tip.inverse() @ Pose((away * x, away * y, 0.0))
        return [(PoseMove(VIEWS[view].pose(point, distance, base.yaw) @ back),) for view in views]

    @property
    def _camera(self) -> CameraSpec:
        return self.context.cell.device(self.camera, CameraSpec)

    def _looks_from(self, point: Vector, distance: float, base: Pose, views: Sequence[int]) -> int | None:
        """Returns in which of some views the camera looks at a point already; None for none of them."""
        camera = self.context.frames.at(self.context.board.snapshot).located(self.camera)
        for view in views:
            off = VIEWS[view].pose(point, distance, base.yaw).inverse() @ camera
            if math.hypot(*off.position) < _THERE and abs(off.orientation[3]) > math.cos(ALIGNED / 2.0):
                return view
        return None

    def find(self, kit: str, believed: Pose, picture: tuple[DepthImage, Pose]) -> Execution[RegistrationResult]:
        """Finds a kit in a picture.

        Raises:
            DeviceError: The kit has no shape.
        """
        camera, solid = self.camera, solid_of(self.world, kit)
        if solid is None:
            raise DeviceError(f"{self.name} needs a shape of {kit}")
        image, seen_from = picture
        request = RegistrationRequest(self._below_held(image), seen_from, solid, believed, self.seed(), camera, kit)
        self._seen_from = self.context.frames.at(image.snapshot).robot(camera), seen_from
        return (yield from self.wait(self.context.port(Registrar, camera).register(request)))

    def register(self, kit: str, believed: Pose, picture: tuple[DepthImage, Pose]) -> Execution[RegistrationResult]:
        """Finds a kit in a picture, and writes where it is.

        Raises:
            DeviceError: The kit has no shape.
        """
        result = yield from self.find(kit, believed, picture)
        if result.pose is not None:
            frame = next(iter(self.world.objects(kit, v.POSE_FRAME)), None)
            in_map = map_pose(self.context, frame) if frame else None
            own = in_map.inverse() @ result.pose if in_map is not None else result.pose
            reason = Message("fitted within {cost:.1f} mm", cost=result.cost * 1000.0)
            with self.world.transaction(author=self.name, reason=reason) as tx:
                write_pose(tx, kit, own, frame)
            self.fitted |= {kit}
        return result

    def content(self, compartment: str, picture: tuple[DepthImage, Pose]) -> Execution[str | None]:
        """Looks in a picture for something in a compartment.

        Returns:
            Why it is not empty, which is written; an empty text if it is; None where it cannot be seen.
        """
        region = inner_region(self.context, compartment)
        if isinstance(region, str):
            return ""
        look = yield from self.detect(region, picture)
        if not look.detections:
            return "" if look.visible >= _CLEAR else None
        seen = look.detections[0]
        what = seen.type.partition(":")[2] if seen.type else UNKNOWN_SHAPE
        reason = Message("{compartment} is taken: {what} is seen there", compartment=compartment, what=what)
        with self.world.transaction(author=self.name, reason=reason) as tx:
            found = tx.add(seen.type or v.OBSTACLE, placement=Placement(v.IN, compartment))
            self.write_in(tx, found, seen.pose, compartment)
        return reason

    def write_in(self, tx: Transaction, element: str, pose: Pose, place: str) -> None:
        """Writes the pose in the map at which something is seen, so that it moves with its place."""
        frame = map_pose(self.context, place)
        write_pose(tx, element, pose if frame is None else frame.inverse() @ pose, None if frame is None else place)

    def fit(self, kit: str, believed: Pose, picture: tuple[DepthImage, Pose]) -> Execution[RegistrationResult]:
        """Registers a kit, and finds at the same time in the same picture how what is held sits."""
        registering, looking = self.register(kit, believed, picture), self._look_at_held(picture[0])
        result, looked = tick(registering), tick(looking)
        while result is None or looked is None:
            yield
            result, looked = result or tick(registering), looked or tick(looking)
        return result

    def _look_at_held(self, image: DepthImage) -> Execution[bool]:
        """Looks how what is held sits now, which may have slid on the way; returns True."""
        holding = held_by(self.context, self.gripper_id)
        if holding is None:
            return True
        part, held = holding
        found = yield from self.how_it_sits(image, self.camera, part, held.pose, self._around())
        if found is not None and found.pose is not None and found.pose.distance(held.pose) > _SLID:
            slid = found.pose.distance(held.pose) * 1e3
            with self.world.transaction(author=self.name, reason=Message("slid by {slid:.0f} mm", slid=slid)) as tx:
                write_pose(tx, part, found.pose, self.gripper_id)
        return True


def kit_region(context: RunContext, kit: str, at: Pose) -> Region:
    """Returns the area above a kit at its upper edge; of a kit without a shape, a point."""
    solid = solid_of(context.world, kit)
    low, high = np.zeros((2, 3)) if solid is None else solid.bounds()
    (x, y, _), (dx, dy, _), top = (low + high) / 2.0, (high - low) / 2.0, high[2]
    return Region(at @ Pose((float(x), float(y), float(top))), (float(dx), float(dy)))


def possible_looks(context: RunContext, arm: ArmSpec, base: Pose, point: Vector) -> tuple[Pose, ...]:
    """Returns poses of an arm's tip in one of which it has to be to look at a point.

    Args:
        context: The run.
        arm: The arm.
        base: Where its base stands about, in the map; it may stand on any side.
        point: Where to look, in the map [m].

    Returns:
        Alternatives, those straight down first; none for an arm without a camera.
    """
    mine = context.world.objects(arm.id, v.HAS_A)
    camera = next((one for one in context.cell.group_of(arm.id).of(CameraSpec) if one.id in mine), None)
    if camera is None:
        return ()
    kinematics, home = context.port(Kinematics, arm.id), dict(zip(arm.joints, arm.home, strict=True))
    back = kinematics.pose(camera.frame, home).inverse() @ kinematics.pose(arm.tip, home)
    down = [VIEWS[number].pose(point, _LOOK_HEIGHTS[-1], base.yaw) for number in _DOWN]
    sides = [math.tau * side / _ROUND for side in range(_ROUND)]
    tilted = [
        View(_TILTS[-1], side, turn).pose(point, _DISTANCES[1], base.yaw)
        for side, turn in product(sides, _QUARTER_TURNS)
    ]
    return tuple(pose @ back for pose in (*down, *tilted))


_AROUND_HELD = 0.015
"""How far beside where it is believed to be what is held may be seen, the pads of the fingers too [m]."""
_CLEAR = 0.9
"""Minimum fraction of a compartment that must be seen to call it empty."""
_SLID = 0.003
"""What is held is believed to sit elsewhere when it is seen at least this far off [m]."""
