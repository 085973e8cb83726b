"""Areas of the floor: no two robots are ever promised the same place, and somebody always goes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.devices.arm import ArmSpec
from skiros_py.execution.claims import Claims
from skiros_py.execution.floor import FloorAreas, FloorWay
from skiros_py.geometry import Pose
from skiros_py.ports.board import DeviceBoard
from skiros_py.ports.cell import CellSpec, RobotSpec
from skiros_py.ports.device import MobileSpec
from skiros_py.ports.paths import BaseLeg, BasePath, PosePath
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.testing.tiny import world_of

OUTLINE = ((-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3))


@cache
def robots(count: int) -> tuple[RobotSpec, ...]:
    world = world_of("", robots=count)
    return read_cell(world, world.instances("sk:Robot")).robots


def moved(robot: RobotSpec, start: Pose) -> RobotSpec:
    devices = (replace(d, start=start) if isinstance(d, MobileSpec) else d for d in robot.devices)
    return replace(robot, devices=tuple(devices))


def floor_with(*places: tuple[float, float], claims: Claims | None = None) -> FloorAreas:
    """Returns the floor of a cell whose robots stand at these places [m], heading along x."""
    there = zip(robots(len(places)), places, strict=True)
    specs = tuple(moved(r, Pose((x, y, 0.0))) for r, (x, y) in there)
    return FloorAreas(DeviceBoard(FakeCell(CellSpec((), specs))), specs, claims or Claims())


def straight(floor: FloorAreas, number: int, start: tuple[float, float], end: tuple[float, float]) -> FloorWay:
    """Asks for the straight way of a robot between two places."""
    heading = math.atan2(end[1] - start[1], end[0] - start[0])
    path = BasePath((BaseLeg(*end),), heading)
    return floor.ask(f"robot_{number}", OUTLINE, Pose((start[0], start[1], 0.0)), path)


def test_an_unoccupied_path_is_granted_at_once() -> None:
    floor = floor_with((0.0, 0.0), (0.0, 5.0))

    way = straight(floor, 1, (0.0, 0.0), (4.0, 0.0))

    assert way.free
    assert floor.is_driving("robot_1")
    assert not floor.is_driving("robot_2")


def test_a_robot_standing_on_a_path_blocks_it() -> None:
    floor = floor_with((0.0, 0.0), (2.0, 0.2))

    way = straight(floor, 1, (0.0, 0.0), (4.0, 0.0))

    assert not way.free
    assert way.blocked
    assert way.waits_for() == ("robot_2",)


def test_a_robot_waits_for_a_driving_robot_until_that_has_arrived_elsewhere() -> None:
    floor = floor_with((0.0, 0.0), (2.0, -2.0))
    first = straight(floor, 1, (0.0, 0.0), (4.0, 0.0))
    second = straight(floor, 2, (2.0, -2.0), (2.0, 2.0))
    assert (second.free, second.blocked, second.waits_for()) == (False, False, ("robot_1",))

    first.release()

    assert second.free


def test_the_floor_behind_a_driving_robot_is_released_before_it_arrives() -> None:
    floor = floor_with((0.0, 0.0), (0.0, -2.0))
    first = straight(floor, 1, (0.0, 0.0), (4.0, 0.0))
    second = straight(floor, 2, (0.0, -2.0), (0.0, 2.0))

    first.passed(0.1)
    assert not second.free
    first.passed(0.5)
    assert second.free
    assert floor.is_driving("robot_1")


def test_robots_get_the_floor_in_the_order_of_their_requests() -> None:
    floor = floor_with((0.0, 0.0), (2.0, -2.0), (3.0, 2.0))
    crossing = straight(floor, 1, (0.0, 0.0), (4.0, 0.0))
    waiting = straight(floor, 2, (2.0, -2.0), (2.0, 4.0))
    later = straight(floor, 3, (3.0, 2.0), (0.0, 2.0))
    assert later.waits_for() == ("robot_2",)

    crossing.release()

    assert waiting.free
    assert not later.free


def test_a_withdrawn_path_request_blocks_no_other_robot() -> None:
    floor = floor_with((0.0, 0.0), (2.0, -2.0), (3.0, 2.0))
    straight(floor, 1, (0.0, 0.0), (4.0, 0.0))
    waiting = straight(floor, 2, (2.0, -2.0), (2.0, 4.0))
    later = straight(floor, 3, (3.0, 2.0), (0.0, 2.0))

    waiting.release()

    assert later.free


def test_a_turn_on_the_spot_claims_the_area_swept_by_the_corners() -> None:
    floor = floor_with((0.0, 0.0), (0.0, 0.7))
    turning = BasePath((), math.pi / 2)

    standing = BasePath((), 0.0)
    with floor.ask("robot_1", OUTLINE, Pose(), standing) as way:
        assert way.free
    assert not floor.ask("robot_1", OUTLINE, Pose(), turning).free


# ------------------------------------------------------------------ giving way


def test_of_two_robots_in_each_others_way_the_later_one_is_to_leave_the_path_of_the_other() -> None:
    floor = floor_with((0.0, 0.0), (2.0, 0.0))
    first = straight(floor, 1, (0.0, 0.0), (4.0, 0.0))
    later = straight(floor, 2, (2.0, 0.0), (-2.0, 0.0))

    assert first.to_leave() is None
    area = later.to_leave()
    assert area is not None
    assert area.contains(shapely.Point(4.0, 0.0))
    assert not area.contains(shapely.Point(-2.0, 0.0))


def test_a_robot_without_room_leaves_it_to_the_other_one_and_both_learn_if_that_has_none() -> None:
    floor = floor_with((0.0, 0.0), (2.0, 0.0))
    first = straight(floor, 1, (0.0, 0.0), (4.0, 0.0))
    later = straight(floor, 2, (2.0, 0.0), (-2.0, 0.0))

    later.refuse()
    assert later.to_leave() is None
    assert first.to_leave() is not None
    assert (first.deadlock(), later.deadlock()) == ((), ())

    first.refuse()
    assert first.to_leave() is None
    assert (first.deadlock(), later.deadlock()) == (("robot_2",), ("robot_1",))


def test_a_robot_that_gives_way_is_not_held_up_by_the_pending_path_it_blocks() -> None:
    floor = floor_with((0.0, 0.0), (2.0, 0.0))
    first = straight(floor, 1, (0.0, 0.0), (4.0, 0.0))
    straight(floor, 2, (2.0, 0.0), (-2.0, 0.0)).release()

    with straight(floor, 2, (2.0, 0.0), (2.0, 3.0)) as aside:
        assert aside.free
        assert (first.free, first.blocked) == (False, False)


def test_of_three_robots_that_wait_in_a_ring_only_the_last_is_to_give_way() -> None:
    floor = floor_with((0.0, 0.0), (4.0, 0.0), (4.0, 4.0))
    ring = [
        straight(floor, 1, (0.0, 0.0), (4.0, 0.0)),
        straight(floor, 2, (4.0, 0.0), (4.0, 4.0)),
        straight(floor, 3, (4.0, 4.0), (0.0, 0.0)),
    ]

    assert [way.to_leave() is not None for way in ring] == [False, False, True]
    ring[2].refuse()
    assert [way.to_leave() is not None for way in ring] == [False, True, False]


def test_a_robot_waiting_for_a_working_one_gives_way_to_those_that_wait_only_for_it() -> None:
    floor = floor_with((0.0, 0.0), (2.0, 0.0), (2.0, 3.0))
    straight(floor, 1, (0.0, 0.0), (4.0, 0.0))
    waiting = straight(floor, 2, (2.0, 0.0), (2.0, 3.0))
    assert waiting.to_leave() is not None


def test_a_robot_is_not_sent_away_for_one_that_waits_for_a_working_robot_too() -> None:
    floor = floor_with((0.0, 0.0), (2.0, 0.0), (4.0, 0.0))
    straight(floor, 1, (0.0, 0.0), (4.0, 0.0))
    next_in_line = straight(floor, 2, (2.0, 0.0), (4.0, 0.0))

    assert next_in_line.to_leave() is None


def test_a_robot_that_nothing_runs_on_is_named_as_idle() -> None:
    claims = Claims()
    floor = floor_with((0.0, 0.0), (2.0, 0.2), claims=claims)
    way = straight(floor, 1, (0.0, 0.0), (4.0, 0.0))

    assert way.idle() == ("robot_2",)
    with claims.request("pick", ["arm_2"]):
        assert way.idle() == ()
    assert way.idle() == ("robot_2",)


REACHING = ((0.0, -0.1), (0.8, -0.1), (0.8, 0.1), (0.0, 0.1))
"""The floor below an arm that is stretched out ahead."""


def arm(number: int) -> str:
    return robots(number)[-1].of(ArmSpec)[0].id


def test_an_arm_stretched_over_a_path_blocks_it_until_it_is_retracted() -> None:
    floor = floor_with((0.0, 0.0), (2.0, 1.0))
    assert floor.stretch(arm(2), REACHING) == ()

    way = straight(floor, 1, (2.7, -2.0), (2.7, 3.0))
    assert (way.free, way.blocked, way.waits_for()) == (False, True, ("robot_2",))

    floor.stretch(arm(2), OUTLINE)
    assert way.free


def test_an_arm_does_not_reach_over_a_granted_path_before_it_has_been_driven() -> None:
    floor = floor_with((0.0, 0.0), (2.0, 0.75))
    way = straight(floor, 1, (0.0, 0.0), (4.0, 0.0))
    sideways = tuple((y, -x) for x, y in REACHING)
    assert way.free

    assert floor.stretch(arm(2), sideways) == ("robot_1",)
    assert floor.stretched(arm(2)) == ()
    way.release()

    assert floor.stretch(arm(2), sideways) == ()
    assert floor.stretched(arm(2)) == sideways


def test_an_arm_does_not_wait_for_a_pending_path_request() -> None:
    """Or an arm might wait for a base that waits for another base that waits for the arm."""
    floor = floor_with((0.0, 0.0), (2.0, 1.0), (5.0, -2.0))
    crossing = straight(floor, 3, (5.0, -2.0), (0.0, -2.0))
    wish = straight(floor, 1, (2.7, -4.0), (2.7, 3.0))
    assert not wish.free

    assert floor.stretch(arm(2), REACHING) == ()
    crossing.release()

    assert (wish.free, wish.blocked) == (False, True)


def test_an_arm_does_not_block_its_own_base() -> None:
    floor = floor_with((0.0, 0.0), (2.0, 1.0))
    floor.stretch(arm(2), REACHING)

    assert straight(floor, 2, (2.0, 1.0), (6.0, 1.0)).free


PLACES = st.tuples(st.integers(0, 6), st.integers(0, 6)).map(lambda p: (float(p[0]), float(p[1])))


@settings(max_examples=40, deadline=None)
@given(st.lists(PLACES, min_size=2, max_size=4, unique=True), st.data())
def test_paths_granted_at_the_same_time_never_intersect(
    places: Sequence[tuple[float, float]], data: st.DataObject
) -> None:
    floor = floor_with(*places)
    ways = []
    for number, place in enumerate(places, start=1):
        end = data.draw(PLACES.filter(lambda p, place=place: p != place))
        ways.append(straight(floor, number, place, end))
        if data.draw(st.booleans()):
            ways.pop(data.draw(st.integers(0, len(ways) - 1))).release()

    areas = [way.area for way in ways if way.free]

    assert not any(one.intersects(other) for n, one in enumerate(areas) for other in areas[:n])


@settings(max_examples=40, deadline=None)
@given(st.lists(PLACES, min_size=2, max_size=3, unique=True), st.data())
def test_no_arm_reaches_over_a_path_granted_to_another_robot(
    places: Sequence[tuple[float, float]], data: st.DataObject
) -> None:
    floor = floor_with(*places)
    ways: list[FloorWay] = []
    for number, (x, y) in enumerate(places, start=1):
        end = data.draw(PLACES.filter(lambda p, place=(x, y): p != place))
        if data.draw(st.booleans()):
            floor.stretch(arm(number), REACHING)
        else:
            ways.append(straight(floor, number, (x, y), end))
    for number in range(1, len(places) + 1):
        if not floor.is_driving(f"robot_{number}"):
            floor.stretch(arm(number), REACHING)

    above = {f"robot_{n}": shapely.box(x, y - 0.1, x + 0.8, y + 0.1) for n, (x, y) in enumerate(places, start=1)}

    for way in ways:
        reaching = [robot for n, robot in enumerate(above, 1) if floor.stretched(arm(n)) and robot != way.robot]
        assert not (way.free and any(above[robot].intersects(way.area) for robot in reaching))


@settings(max_examples=40, deadline=None)
@given(st.lists(PLACES, min_size=2, max_size=4, unique=True), st.data())
def test_some_request_is_always_granted_unless_all_are_blocked(
    places: Sequence[tuple[float, float]], data: st.DataObject
) -> None:
    floor = floor_with(*places)
    ends = [data.draw(PLACES.filter(lambda p, place=place: p != place)) for place in places]

    ways = [straight(floor, number, *ride) for number, ride in enumerate(zip(places, ends, strict=True), start=1)]

    assert any(way.free or way.blocked for way in ways)


@settings(max_examples=40, deadline=None)
@given(st.lists(PLACES, min_size=2, max_size=4, unique=True), st.data())
def test_if_all_robots_wait_for_each_other_one_of_them_is_to_give_way_until_none_can(
    places: Sequence[tuple[float, float]], data: st.DataObject
) -> None:
    floor = floor_with(*places)
    ends = [data.draw(st.sampled_from([p for p in places if p != place])) for place in places]
    ways = [straight(floor, number, *ride) for number, ride in enumerate(zip(places, ends, strict=True), start=1)]
    assert all(way.blocked for way in ways)

    for _ in ways:
        asked = [way for way in ways if way.to_leave() is not None]
        assert asked or any(way.deadlock() for way in ways)
        for way in asked:
            way.refuse()
    assert any(way.deadlock() for way in ways)


@pytest.mark.parametrize("legs", [0.0, 0.3, 1.0])
def test_releasing_the_driven_floor_never_enlarges_a_path(legs: float) -> None:
    way = straight(floor_with((0.0, 0.0), (0.0, 5.0)), 1, (0.0, 0.0), (4.0, 0.0))
    whole = way.area

    way.passed(legs)

    assert whole.buffer(1e-9).contains(way.area)


def test_a_sideways_moving_base_claims_exactly_the_area_it_sweeps() -> None:
    floor = floor_with((0.0, 0.0), (2.0, 0.0), (2.0, 4.0))
    sideways = PosePath(tuple(Pose((0.2 * step, 0.2 * step, 0.0)) for step in range(1, 11)))

    way = floor.ask("robot_1", OUTLINE, Pose(), sideways)

    assert way.free  # robot_2 stands beside the diagonal, robot_3 behind its end
    crossing = straight(floor, 2, (2.0, 0.0), (0.0, 2.0))
    assert (crossing.free, crossing.waits_for()) == (False, ("robot_1",))
    way.passed(9.0)
    assert crossing.free


def test_a_flying_base_claims_no_floor_and_blocks_no_other() -> None:
    floor = floor_with((0.0, 0.0), (1.0, 0.0))
    way = floor.ask("robot_2", (), Pose((1.0, 0.0, 1.0)), PosePath((Pose((0.0, 0.0, 1.0)), Pose((3.0, 0.0, 1.0)))))

    assert way.free
    assert straight(floor, 1, (0.0, 0.0), (4.0, 0.0)).free
