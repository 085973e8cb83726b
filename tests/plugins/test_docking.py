"""A base docks where its arm reaches what is wanted: at the driving pose where it does, or else on any free side."""

from __future__ import annotations

import math
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import shapely
from support.stepping import run

from skiros_primitives import docking
from skiros_primitives.docking import Task, Wanted, can_put_down, docking_pose, docks_around
from skiros_py.devices.arm import ArmSpec
from skiros_py.geometry import Pose, Solid, wrap_angle
from skiros_py.ports.motion import MotionPlan, MotionRequest, NoMotion, Obstacle, PoseMove, Reached, ReachRequest
from skiros_py.ports.paths import floor_area, placed
from skiros_py.ports.values import Done
from skiros_py.skills.outcome import Failure
from skiros_py.skills.primitive import Execution
from skiros_py.testing.conformance.cells import small_cell

ROBOT = small_cell(cameras=False).robots[0]
FRONT = max(x for x, _ in ROBOT.outline)
TABLE = Obstacle("table", Solid.box(0.6, 0.8, 1.0), Pose((2.0, 0.0, 0.5)))
TAUGHT = Pose((1.7 - 0.135 - FRONT, 0.0, 0.0))
MOUNT = Pose((0.1, 0.0, 0.0))


class Arm:
    """Stands for run and planner: the arm reaches so far from where it stands on its base."""

    def __init__(self, reach: float, ahead: frozenset[str] = frozenset()) -> None:
        self.reached, self.ahead = reach, ahead
        self.plans, self.checks = 0, 0
        self.ports = SimpleNamespace(find=lambda *_: self)
        self.port = lambda *_: self
        self.now, self.lockstep, self.waiting = 0.0, True, nullcontext
        self.context = self

    def _reaches(self, base: Pose, tool: Pose) -> bool:
        return math.dist((base @ MOUNT).position[:2], tool.position[:2]) <= self.reached

    def plan(self, request: MotionRequest) -> Done[MotionPlan | NoMotion]:
        self.plans += 1
        move = request.routes[0][0]
        assert isinstance(move, PoseMove)
        return Done(MotionPlan(0, ()) if self._reaches(request.base, move.pose) else NoMotion("out of reach"))

    def reach(self, request: ReachRequest) -> Done[tuple[Reached, ...]]:
        self.checks += 1
        there = (
            tuple(0.3 if self._reaches(base, t[0][0]) else None for t in request.targets) for base in request.bases
        )
        return Done(tuple(there))

    def wait(self, pending: Done[Any]) -> Execution[Any]:
        yield from ()
        return pending.result()

    def seed(self) -> int:
        return 0


def free(_pose: Pose) -> Execution[bool]:
    yield from ()
    return True


def chosen(
    monkeypatch: pytest.MonkeyPatch, arm: Arm, *wanted: Pose, looks: tuple[Pose, ...] = (), is_free: Any = free
) -> Any:
    task = Task(
        tuple(Wanted(f"cell_{n}", (pose,)) for n, pose in enumerate(wanted)),
        tuple((pose,) for pose in looks),
        frozenset(),
        None,
    )
    monkeypatch.setattr(docking, "task_at", lambda *_: task)
    monkeypatch.setattr(docking, "on_floor", lambda *_: TABLE)
    monkeypatch.setattr(docking, "obstacles", lambda *_, **__: (TABLE,))
    monkeypatch.setattr(docking, "_mount", lambda *_: MOUNT)
    monkeypatch.setattr(docking, "_kit", lambda _, location: location)
    primitive: Any = arm
    return run(docking_pose(primitive, ROBOT, "kit_1", TAUGHT, is_free))


NEAR, FAR, BEHIND = Pose((1.8, 0.0, 1.0)), Pose((1.9, 0.0, 1.0)), Pose((2.2, 0.0, 1.0))
TO_NEAR, TO_FAR = (math.dist((TAUGHT @ MOUNT).position[:2], pose.position[:2]) for pose in (NEAR, FAR))


def test_where_the_farthest_place_is_reached_it_docks_as_taught_and_asks_no_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    arm = Arm(TO_FAR + 0.01)

    assert chosen(monkeypatch, arm, FAR, NEAR) == TAUGHT
    assert (arm.plans, arm.checks) == (1, 1)


def test_where_nothing_is_wanted_nothing_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    arm = Arm(TO_FAR)

    assert chosen(monkeypatch, arm) == TAUGHT
    assert (arm.plans, arm.checks) == (0, 0)


def test_it_docks_nearer_where_the_arm_does_not_reach_as_taught(monkeypatch: pytest.MonkeyPatch) -> None:
    found = chosen(monkeypatch, Arm(TO_FAR - 0.05), FAR, NEAR)

    assert found.position[0] > TAUGHT.position[0]
    assert found.distance(TAUGHT) < 0.2


def test_it_docks_nearer_where_it_can_put_down_but_not_look_as_taught(monkeypatch: pytest.MonkeyPatch) -> None:
    found = chosen(monkeypatch, Arm(TO_FAR - 0.05), NEAR, looks=(FAR,))

    assert found.position[0] > TAUGHT.position[0]


def test_it_docks_on_the_side_from_which_the_arm_reaches_what_is_far_from_the_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = chosen(monkeypatch, Arm(TO_FAR - 0.10), BEHIND)

    assert found.position[0] > 2.0
    assert abs(wrap_angle(found.yaw - math.pi)) < math.radians(31.0)


def test_it_docks_as_taught_where_no_other_pose_is_free_or_better(monkeypatch: pytest.MonkeyPatch) -> None:
    def taken(_pose: Pose) -> Execution[bool]:
        yield from ()
        return False

    assert chosen(monkeypatch, Arm(TO_FAR - 0.05), FAR, NEAR, is_free=taken) == TAUGHT
    assert chosen(monkeypatch, Arm(0.10), FAR, NEAR) == TAUGHT


def test_it_does_not_drive_where_all_that_the_next_steps_need_is_out_of_reach(monkeypatch: pytest.MonkeyPatch) -> None:
    refusal = chosen(monkeypatch, Arm(0.10, frozenset({"cell_0", "cell_1"})), FAR, NEAR)

    assert isinstance(refusal, Failure)
    assert refusal.values == {"cause": "reach", "out_of_reach": ["cell_0", "cell_1"]}
    assert refusal.reason == f"cell_0 and cell_1 is out of reach of {ROBOT.id} from every side of kit_1"


def test_it_drives_where_only_some_of_what_the_next_steps_need_is_in_reach(monkeypatch: pytest.MonkeyPatch) -> None:
    found = chosen(monkeypatch, Arm(TO_NEAR + 0.01, frozenset({"cell_0", "cell_1"})), Pose((2.0, 0.0, 9.0)), NEAR)

    assert isinstance(found, Pose)


@pytest.mark.parametrize("turned", [0.0, math.pi / 2.0, math.pi])
def test_docks_are_a_small_gap_away_from_each_side_and_faced_as_taught(turned: float) -> None:
    place = floor_area(TABLE.solid, TABLE.pose)
    taught = TAUGHT @ Pose.of(0.0, 0.0, 0.0, yaw=turned)

    found = docks_around(place, ROBOT.outline, MOUNT, taught, np.array([[2.0, 0.0]]))

    gaps = [shapely.distance(placed(ROBOT.outline, pose), place) for pose in found]
    assert min(gaps) == pytest.approx(docking._GAP)
    sides = {round(wrap_angle(pose.yaw - turned) / (math.pi / 2.0), 3) % 4.0 for pose in found}
    assert {0.0, 1.0, 2.0, 3.0} <= sides


@pytest.mark.parametrize(
    ("reach", "ahead", "expected"),
    [
        (TO_FAR + 0.01, {"kit_1", "cell_0"}, True),
        (TO_FAR - 0.05, {"kit_1", "cell_0"}, True),  # from nearer
        (0.10, {"kit_1", "cell_0"}, False),
        (0.10, {"kit_1"}, True),  # it goes to no compartment there
        (0.10, {"cell_0"}, True),  # it does not drive there
    ],
)
def test_whether_a_part_can_be_put_down_is_known_before_it_is_grasped(
    monkeypatch: pytest.MonkeyPatch, reach: float, ahead: set[str], expected: bool
) -> None:
    arm: Any = Arm(reach, frozenset(ahead))
    arm.world = SimpleNamespace(has=lambda id_: id_ == "kit_1", value=lambda *_: TAUGHT)
    for name, stand_in in {
        "on_floor": lambda *_: TABLE,
        "obstacles": lambda *_, **__: (TABLE,),
        "_mount": lambda *_: MOUNT,
        "_kit": lambda _, location: location,
        "_touching": lambda *_: frozenset(),
        "_releases": lambda *_: [Wanted("cell_0", (FAR,)), Wanted("cell_1", (Pose((9.0, 0.0, 1.0)),))],
        "map_pose": lambda *_: Pose(),
        "solid_of": lambda *_: Solid.box(0.1, 0.1, 0.1),
        "rides": lambda *_: False,
    }.items():
        monkeypatch.setattr(docking, name, stand_in)

    assert run(can_put_down(arm, ROBOT, ROBOT.of(ArmSpec)[0], "part_1", [Pose()])) is expected
