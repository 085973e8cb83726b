"""From where a camera looks at a place: where what is held hides nothing, and without a motion where it is already."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.stepping import run

from skiros_primitives.looking import VIEWS, LookingParams, LookingPrimitive
from skiros_primitives.part_models import downward
from skiros_primitives.registering import looks_into
from skiros_primitives.views import repainted
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.motion import Held, MotionPlan, NoMotion, Obstacle
from skiros_py.ports.values import CameraIntrinsics, DepthImage
from skiros_py.skills.context import Tried
from skiros_py.skills.outcome import Execution, Outcome, Success

POINT = (1.0, 2.0, 0.5)
HEIGHT = 0.46
MOUNT = Pose.of(0.07, 0.0, -0.07, yaw=math.pi / 2.0)
"""Of a camera in front of the hand, which sees the tip at the lower edge of its pictures."""


class Looking(LookingPrimitive):
    """One that looks, with a camera that is somewhere."""

    name = "looking"

    def __init__(self, camera: Pose = Pose(), *, holds: bool = False, mount: Pose = MOUNT) -> None:  # noqa: B008 - it is frozen
        tree = SimpleNamespace(located=lambda _camera: camera)
        board, frames = SimpleNamespace(snapshot=None), SimpleNamespace(at=lambda _snapshot: tree)
        cell = SimpleNamespace(device=lambda camera, _type: camera)
        context: Any = SimpleNamespace(tried=Tried(), frames=frames, board=board, cell=cell)
        super().__init__(context, LookingParams(arm="arm", camera="camera"))
        self._holds, self._mount = holds, mount

    def execute(self) -> Execution[Outcome]:
        yield
        return Success()

    def camera_in_tip(self, camera: Any) -> Pose:
        return self._mount

    def held(self) -> Held | None:
        return Held(Solid.box(0.05, 0.05, 0.05), Pose()) if self._holds else None

    def sides(self, degrees: float) -> list[int]:
        """Returns from which sides it looks at a place beside the point, in some direction."""
        angle = math.radians(degrees)
        shown = (POINT[0] + 0.1 * math.cos(angle), POINT[1] + 0.1 * math.sin(angle), POINT[2])
        first, *others = self._sides(range(4), POINT, Pose(), shown)
        assert sorted(sum(others, first)) == [0, 1, 2, 3]
        return first

    def from_where(self, views: list[int]) -> int | None:
        return self._looks_from(POINT, HEIGHT, Pose(), views)


@pytest.mark.parametrize(("degrees", "sides"), [(45.0, [0, 3]), (135.0, [0, 1]), (-135.0, [1, 2]), (-45.0, [2, 3])])
def test_a_place_is_looked_at_from_where_it_is_in_the_upper_half_of_the_picture_which_shows_no_held_part(
    degrees: float, sides: list[int]
) -> None:
    assert Looking(holds=True).sides(degrees) == sides
    assert Looking().sides(degrees) == [0, 1, 2, 3]


def test_a_camera_that_sees_the_tip_at_the_right_edge_looks_from_where_the_place_is_in_the_left_half() -> None:
    turned = MOUNT @ Pose.of(
        0.0, 0.0, 0.0, yaw=-math.pi / 2.0
    )  # its x axis points away from the tip: that is at the left

    assert Looking(holds=True, mount=turned).sides(45.0) == [0, 1]


def test_sides_tried_in_vain_come_after_those_that_show_less() -> None:
    looking = Looking(holds=True)
    for side in (0, 3):
        looking.context.tried.note("view", side, "looked in vain")

    assert looking.sides(45.0) == [1, 2]


def test_a_camera_that_is_where_it_should_be_need_not_move() -> None:
    there = downward(POINT[0] + 0.01, POINT[1], POINT[2] + HEIGHT, math.radians(91.0))

    assert Looking(there).from_where([0, 1, 2, 3]) == 1
    assert Looking(there).from_where([0, 2, 3]) is None
    assert Looking(Pose((0.03, 0.0, 0.0)) @ there).from_where([1]) is None
    assert Looking(there @ Pose.of(0.0, 0.0, 0.0, roll=math.radians(5.0))).from_where([1]) is None


class Stuck(Looking):
    """One whose arm finds no way; it notes which spaces it was to keep out of."""

    base_pose = Pose()

    def carries(self, camera: str) -> bool:
        return True

    def plan(self, routes: Any, *, unseen: Sequence[Obstacle] = (), **_others: Any) -> Execution[NoMotion]:  # type: ignore[override]
        self.avoided.append(tuple(unseen))
        yield
        return NoMotion("no way")

    def look(self) -> list[tuple[Obstacle, ...]]:
        self.avoided: list[tuple[Obstacle, ...]] = []
        deque(self.look_down(POINT), maxlen=0)
        return self.avoided


def test_the_arm_goes_where_unseen_parts_may_be_only_where_there_is_no_other_way(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    space = Obstacle("pallet_a", Solid.box(0.4, 0.4, 0.1), Pose())
    monkeypatch.setattr("skiros_primitives.looking.obstacles", lambda *_, **__: ())
    monkeypatch.setattr("skiros_primitives.looking.unlocated", lambda *_: iter([space]))
    unseen = Stuck().look()
    monkeypatch.setattr("skiros_primitives.looking.unlocated", lambda *_: iter([]))
    seen = Stuck().look()

    assert set(seen) == {()}
    assert unseen == [(space,)] * len(seen) + seen


PLACE = Pose.of(1.0, 0.5, 0.8, yaw=0.7)


@pytest.mark.parametrize(
    ("camera", "seen"),
    [
        (Pose.of(0.0, 0.0, 0.3, roll=math.pi), True),
        (Pose.of(0.05, -0.05, 0.3, roll=math.pi), True),
        (Pose.of(0.15, 0.0, 0.3, roll=math.pi), False),
        (Pose.of(0.0, 0.0, 0.3, roll=math.pi - 0.2), False),
        (Pose.of(0.0, 0.0, -0.3), False),
        (Pose.of(0.0, 0.0, -0.3, roll=math.pi), False),
    ],
    ids=["above", "a little aside", "far aside", "tilted", "from below, upwards", "below, downwards"],
)
def test_a_place_is_looked_into_without_a_motion_only_steeply_from_above(camera: Pose, seen: bool) -> None:
    assert looks_into(PLACE @ camera, PLACE) is seen


def test_a_picture_without_what_is_held_shows_what_is_beside_it() -> None:
    """The part hides the middle of a floor 0.4 m below the camera; its own depths count as not measured."""
    intrinsics = CameraIntrinsics(64, 48, 50.0, 50.0, 31.5, 23.5, 0.1, 2.0)
    v, u = np.mgrid[0:48, 0:64]
    is_part = (np.abs(u - 31.5) < 10) & (np.abs(v - 23.5) < 8)
    depth = np.where(is_part, 0.2, 0.4).astype(np.float32)
    image: Any = DepthImage(None, depth, np.zeros((48, 64, 3), np.uint8), intrinsics)  # type: ignore[arg-type]
    tip = Pose((0.0, 0.0, 0.24))  # in the optical frame
    held = Held(Solid.box(0.08, 0.064, 0.06), Pose.of(0.0, 0.0, 0.02, roll=math.pi))

    left = repainted(image, held.solid, tip @ held.pose, 0.015, 0.0).depth

    assert (left[is_part] == 0.0).all()
    assert (left[~is_part] == np.float32(0.4)).all()


class Shy(Looking):
    """One whose arm cannot hold its camera straight above anything, or not at all; nothing moves in fact."""

    tilted: bool = True

    def __init__(self) -> None:
        super().__init__()
        self.asked: list[tuple[float, tuple[float, ...]]] = []

    @property
    def base_pose(self) -> Pose:
        return Pose()

    def carries(self, camera: str) -> bool:
        return camera == "camera"

    def plan(self, routes: Any, **options: Any) -> Execution[MotionPlan | NoMotion]:
        """Plans to where the camera is not straight above the point."""
        yield
        cameras = [route[0].pose @ MOUNT for route in routes]
        self.asked.append((cameras[0].distance(Pose(POINT)), options["shares"]))
        if self.tilted and all(off_vertical(camera) > 0.1 for camera in cameras):
            return MotionPlan(0, ())
        return NoMotion.because("reach", "out of reach")

    def follow_plan(self, planned: MotionPlan) -> Execution[NoMotion | None]:
        yield
        assert planned.route == 0
        return None

    def capture(self) -> Execution[Any]:
        yield
        return "a picture"


def off_vertical(camera: Pose) -> float:
    """Returns the angle between where a camera looks and straight down [rad]."""
    return math.acos(min(1.0, -float(camera.matrix()[2, 2])))


def looked(looking: Shy) -> Any:
    return run(looking.look_down(POINT))


def test_where_the_arm_cannot_hold_the_camera_straight_above_it_looks_from_the_side(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("skiros_primitives.looking.obstacles", lambda *_, **__: ())
    looking = Shy()

    assert looked(looking) == "a picture"

    *downward, last = looking.asked
    assert [round(distance, 3) for distance, _ in downward] == [0.46, 0.40, 0.34]  # each asked for once
    assert last[1] == (1.0,)


def test_where_no_view_is_within_reach_it_says_so_and_asks_for_each_distance_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("skiros_primitives.looking.obstacles", lambda *_, **__: ())
    looking = Shy()
    looking.tilted = False

    refusal = looked(looking)

    assert refusal.values["cause"] == "reach"
    assert {share for _, share in looking.asked} == {(1.0,)}


@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_every_view_has_the_point_in_the_middle_and_tilted_ones_stand_on_the_side_of_the_base(heading: float) -> None:
    assert max(view.tilt for view in VIEWS) <= math.radians(50.0)
    for view in VIEWS:
        camera = view.pose(POINT, 0.3, heading)

        assert camera.inverse().apply(np.array([POINT])) == pytest.approx(np.array([[0.0, 0.0, 0.3]]))
        assert off_vertical(camera) == pytest.approx(view.tilt, abs=1e-6)
        aside = np.subtract(camera.position, POINT)[:2] @ (math.cos(heading), math.sin(heading))
        assert aside < -0.05 if view.tilt else aside == pytest.approx(0.0)
