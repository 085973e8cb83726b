"""Plans for many robots use them: a small version of benchmarks/fleet.py, and what it does not vary."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import pytest
from fleet import CHAIN, SECONDS, SKILLS, is_valid_outside, measure
from planning_worlds import PART_CLASSES, able, crowded

from skiros_py.planning.plan import Plan
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.replay import replay
from skiros_py.planning.service import Planned, PlanningOptions, plan
from skiros_py.skills.conditions import Condition
from skiros_py.world.vocabulary import AT, HELD_BY
from skiros_py.world.world import World
from skiros_skills.conditions import OBJECT_AT_LOCATION

SLOTS = [f"kit_{kit}_{letter}" for kit in (2, 3) for letter in "abcd"]


def planned(world: World, goal: Sequence[Condition], tries: int = 20) -> Planned:
    planner = FastDownward()
    try:
        return plan(planner, world, able(world), goal, options=PlanningOptions(tries=tries))
    finally:
        planner.close()


def checked(world: World, goal: Sequence[Condition]) -> Plan:
    found = planned(world, goal)
    assert isinstance(found.outcome, Plan)
    assert replay(world, found.outcome.steps, goal, SKILLS) is None
    assert is_valid_outside(found)
    return found.outcome


def makespan(plan: Plan) -> float:
    return max(start + SECONDS[step.skill] for start, step in zip(plan.starts, plan.steps, strict=True))


def named(world: World, number: int) -> list[Condition]:
    parts = sorted(part for class_ in PART_CLASSES for part in world.instances(class_) if not part.endswith("_1"))
    return [OBJECT_AT_LOCATION(part, slot) for part, slot in zip(parts[:number], SLOTS, strict=False)]


def test_more_robots_never_take_longer_and_stay_near_the_bound() -> None:
    runs = [measure(8, robots, seed=0) for robots in (1, 2, 4, 8)]

    assert [run.makespan for run in runs] == sorted((run.makespan for run in runs), reverse=True)
    assert all(run.ratio <= most for run, most in zip(runs, (1.3, 1.3, 1.3, 1.6), strict=True))
    assert all(run.valid == (True, True) for run in runs)


def test_robots_that_would_be_in_the_way_of_others_are_left_out() -> None:
    # Dispatching all eight robots to twelve parts takes 1.36 times the bound: they wait for each other.
    assert measure(12, 8, seed=0, tries=0, outside=False).ratio <= 1.3


def test_further_tries_give_no_longer_plan_and_the_same_one_every_time() -> None:
    first, better, again = (planned(*wanted, tries) for tries in (0, 60, 60) for wanted in [_crowd(8, 4)])

    assert isinstance(first.outcome, Plan)
    assert isinstance(better.outcome, Plan)
    assert makespan(better.outcome) <= makespan(first.outcome)
    assert again.outcome == better.outcome


def _crowd(parts: int, robots: int) -> tuple[World, list[Condition]]:
    world = crowded(parts=40, boxes=10, kits=2, robots=robots)
    return world, named(world, parts)


def test_parts_wanted_by_class_are_shared_out_too() -> None:
    world = crowded(parts=40, boxes=10, kits=2, robots=4)
    goal = [OBJECT_AT_LOCATION(class_, slot) for class_, slot in zip(PART_CLASSES * 2, SLOTS, strict=True)]

    assert makespan(checked(world, goal)) <= 1.3 * max(2 * CHAIN, 4 * CHAIN - 2 * SECONDS["pick"])


def test_robots_at_places_that_others_need_make_way() -> None:
    world = crowded(parts=40, boxes=10, kits=2, robots=3)
    goal = named(world, 4)
    places = [placement.place for c in goal if (placement := world.placement(c.arguments[0])) is not None]
    with world.transaction("test", "robots stand about") as tx:
        for robot, place in zip(("robot_1", "robot_2", "robot_3"), ("kit_2", *places[:1], "kit_3"), strict=True):
            tx.place(robot, AT, place)

    checked(world, goal)


def test_a_part_in_a_gripper_is_brought_by_its_robot() -> None:
    world = crowded(parts=40, boxes=10, kits=2, robots=3)
    goal = named(world, 3)
    held = goal[1].arguments[0]
    gripper = sorted(world.instances("sk:Gripper"))[2]
    with world.transaction("test", "picked before") as tx:
        tx.place(held, HELD_BY, gripper)

    steps = checked(world, goal).steps

    assert [s.arguments["Gripper"] for s in steps if held in s.arguments.values()] == [gripper]


@pytest.mark.parametrize("robots", [2, 3])
def test_a_kit_takes_one_robot_at_a_time(robots: int) -> None:
    world = crowded(parts=40, boxes=10, kits=2, robots=robots)

    found = checked(world, named(world, 4))

    stays = sorted(
        (start, start + SECONDS["place"])
        for start, step in zip(found.starts, found.steps, strict=True)
        if step.skill == "place"
    )
    assert all(before[1] <= after[0] for before, after in pairwise(stays))
