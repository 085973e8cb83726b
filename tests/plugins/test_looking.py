"""From where a camera looks at a place: where what is held hides nothing, and without a motion where it is already."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import pytest

from skiros_primitives.looking import LookingParams, LookingPrimitive, looks_into
from skiros_primitives.part_models import downward
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.motion import Held, NoMotion, Obstacle
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
        super().__init__(context, LookingParams("arm", "camera"))
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
        first, others = self._sides(POINT, Pose(), shown)
        assert sorted([*first, *others]) == [0, 1, 2, 3]
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
