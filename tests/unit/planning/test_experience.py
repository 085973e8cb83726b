"""What robots learn from their runs, and that plans use what works better."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.planning import tiny_task

from skiros_py.errors import DescriptionError
from skiros_py.planning.experience import (
    EXPECTED,
    KEPT,
    Case,
    Experience,
    Tally,
    estimated,
    forget,
    observe,
    place_and_part,
    records,
    timed,
)
from skiros_py.planning.plan import Plan
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.planners.planner import Planner
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.service import PlanningOptions, plan
from skiros_py.skills.conditions import Condition
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, HOLDING, IN_CONTAINER, PICK, PLACE
from skiros_py.world.element import Value
from skiros_py.world.world import World

DECLARED = replace(DRIVE, duration=20.0)
TIMES = st.lists(st.tuples(st.floats(0.5, 100.0), st.booleans()), min_size=1, max_size=2 * KEPT)


def drove(world: World, seconds: float, place: str = "box_a", agent: str = "base_1", *, well: bool = True) -> None:
    observe(world, DRIVE, agent, {"Base": agent, "Location": place}, seconds, is_success=well)


def drives(world: World, place: str = "box_a", robot: str = "robot_1") -> tuple[float, float]:
    found = Experience(world).of(Case("drive", robot, "sk:Base", place), 20.0)
    assert found is not None
    return found.seconds, found.chance


# ------------------------------------------------------------ statistics


@given(TIMES)
def test_a_success_rate_is_between_none_and_all_and_the_time_at_least_that_of_a_success(
    runs: list[tuple[float, bool]],
) -> None:
    tally = Tally()
    for seconds, well in runs:
        tally = tally.after(seconds, is_success=well)
    found = estimated((tally,), 20.0)

    assert found is not None
    assert 0.0 < found.chance < 1.0
    assert found.seconds >= min([*tally.times, 20.0])
    assert len(tally.times) + len(tally.failed) <= 2 * KEPT


@given(TIMES)
def test_a_further_success_raises_the_chance_and_a_further_failure_lowers_it(runs: list[tuple[float, bool]]) -> None:
    tally = Tally()
    for seconds, well in runs:
        tally = tally.after(seconds, is_success=well)
    now, better, worse = (
        estimated((one,), 20.0)
        for one in (tally, tally.after(5.0, is_success=True), tally.after(5.0, is_success=False))
    )

    assert now is not None
    assert better is not None
    assert worse is not None
    assert worse.chance <= now.chance
    assert worse.chance < better.chance


@given(st.integers(0, 40), st.integers(20, 60))
def test_what_was_long_ago_is_forgotten(early: int, late: int) -> None:
    tally = Tally()
    for well in [False] * early + [True] * late:
        tally = tally.after(5.0, is_success=well)
    found = estimated((tally,), 20.0)

    assert found is not None
    assert found.chance > 0.6
    assert tally.successes + tally.failures <= 20.0


def test_failed_attempts_add_their_time_before_the_success() -> None:
    found = estimated((Tally(successes=48.0, failures=50.0, times=(10.0,), failed=(4.0,)),), None)

    assert found is not None
    assert found.chance == pytest.approx((2.0 * EXPECTED + 48.0) / 100.0)
    assert found.seconds == pytest.approx(10.0 + (1.0 / found.chance - 1.0) * 4.0)


def test_without_any_time_there_is_no_estimate() -> None:
    assert estimated((), None) is None


# ------------------------------------------------------------ records


def test_each_robot_place_and_type_has_one_record_of_its_own() -> None:
    world = tiny_world()
    for box, ball in (("box_a", "ball_1"), ("box_a", "ball_1"), ("box_b", "red_ball_1")):
        observe(world, PICK, "arm_1", {"Arm": "arm_1", "Box": box, "Ball": ball}, 4.0)

    assert [(e.properties["sk:atPlace"], e.properties["sk:partType"]) for e in records(world)] == [
        ("box_a", "tiny:Ball"),
        ("box_b", "tiny:RedBall"),
    ]
    assert {e.properties["sk:ofRobot"] for e in records(world)} == {"robot_1"}


@pytest.mark.parametrize(
    ("skill", "keys"), [(DRIVE, ("Location", "")), (PICK, ("Box", "Ball")), (PLACE, ("Slot", "Ball"))]
)
def test_place_and_part_are_found_by_their_classes(skill: object, keys: tuple[str, str]) -> None:
    assert place_and_part(skill, tiny_world().ontology) == keys  # type: ignore[arg-type]


@pytest.mark.parametrize(("seconds", "agent"), [(0.0, "base_1"), (9.0, "gone")])
def test_invalid_runs_teach_nothing(seconds: float, agent: str) -> None:
    world = tiny_world()
    before = world.version

    drove(world, seconds, agent=agent)

    assert world.version == before


def test_what_is_unknown_at_one_place_is_taken_from_the_others() -> None:
    world = tiny_world()
    assert drives(world)[0] == pytest.approx(20.0 / EXPECTED)
    for _ in range(9):
        drove(world, 8.0, well=True)
        drove(world, 8.0, "box_b", well=False)

    assert drives(world)[1] > drives(world, "slot_1")[1] > drives(world, "box_b")[1]
    assert drives(world, "slot_1", robot="robot_9")[0] < drives(world, "box_b")[0]


def test_records_of_earlier_versions_count_for_all_robots_of_the_class() -> None:
    world = tiny_world()
    old: dict[str, Value] = {"sk:ofSkill": "drive", "sk:appliesTo": "sk:Base", "sk:runTimes": (7.0, 8.0, 9.0)}
    with world.transaction("test", "an earlier version") as tx:
        tx.add("sk:LearnedDuration", "drive by sk:Base", None, old, learned=True)

    assert drives(world)[0] == pytest.approx(8.0 / drives(world)[1])
    drove(world, 5.0)
    assert len(records(world)) == 2


@pytest.mark.parametrize(
    ("of", "left"),
    [({"place": "box_a"}, 1), ({"skill": "drive", "robot": "robot_1"}, 0), ({"robot": "other"}, 2), ({}, 0)],
)
def test_what_was_learned_is_forgotten_by_what_it_is_of(of: Mapping[str, str], left: int) -> None:
    world = tiny_world()
    drove(world, 5.0)
    drove(world, 5.0, "box_b")
    with world.transaction("test", "forgets") as tx:
        assert forget(tx, world, **of) == 2 - left

    assert len(records(world)) == left


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("inf"), float("nan")])
def test_an_invalid_duration_is_refused(seconds: float) -> None:
    with pytest.raises(DescriptionError, match="duration of skill 'drive'"):
        replace(DRIVE, duration=seconds)


def test_a_task_contains_the_durations_of_its_actions() -> None:
    world = tiny_world()
    for _ in range(100):
        drove(world, 4.0)
    task = timed(tiny_task(world, AT_LOCATION("robot_1", "box_a"), skills=[DECLARED]))
    (drive,) = {action for action in task.domain.actions if action.skill == "drive"}

    assert drive.seconds({"?Base": "base_1", "?Location": "box_a"}) == pytest.approx(4.0, rel=0.02)


# ------------------------------------------------------------ plans

TWO_BALLS = """\
scene:ball_2 a tiny:Ball ; rdfs:label "ball two" ; sk:in scene:box_b .
"""


@pytest.fixture(scope="module")
def fast_downward() -> Iterator[Planner]:
    planner = FastDownward()
    yield planner
    planner.close()


@pytest.fixture(scope="module")
def kairos() -> Iterator[Planner]:
    planner = Kairos()
    yield planner
    planner.close()


def planned(planner: Planner, world: World, *goal: Condition, temporal: bool = False) -> Plan:
    able = [Capability(s, tuple(world.instances(s.agent_class))) for s in (DRIVE, PICK, PLACE)]
    outcome = plan(planner, world, able, goal, options=PlanningOptions("test", temporal)).outcome
    assert isinstance(outcome, Plan), outcome
    return outcome


def picked(world: World, agent: str, box: str, ball: str, *, well: bool, times: int = 8) -> None:
    for _ in range(times):
        observe(world, PICK, agent, {"Arm": agent, "Box": box, "Ball": ball}, 8.0, is_success=well)


def used(found: Plan, key: str, skill: str = "pick") -> set[str]:
    return {step.arguments[key] for step in found.steps if step.skill == skill}


@pytest.mark.parametrize("other", ["arm_1", "arm_2"])
def test_the_plan_uses_the_robot_that_does_not_fail_with_that_type(fast_downward: Planner, other: str) -> None:
    world = tiny_world(robots=2)
    failing = "arm_1" if other == "arm_2" else "arm_2"
    picked(world, failing, "box_a", "ball_1", well=False)
    picked(world, other, "box_a", "ball_1", well=True)
    found = planned(fast_downward, world, IN_CONTAINER("ball_1", "slot_1"))

    assert used(found, "Arm") == {other}


@pytest.mark.parametrize("better", ["box_a", "box_b"])
def test_the_plan_uses_the_place_where_picking_does_not_fail(fast_downward: Planner, better: str) -> None:
    world = tiny_world(TWO_BALLS)
    failing = "box_a" if better == "box_b" else "box_b"
    picked(world, "arm_1", failing, "ball_1", well=False)
    picked(world, "arm_1", better, "ball_1", well=True)
    found = planned(fast_downward, world, IN_CONTAINER("tiny:Ball", "slot_1"))

    assert used(found, "Box") == {better}


@pytest.mark.parametrize("better", ["box_a", "box_b"])
def test_the_plan_uses_the_dock_where_driving_does_not_fail(fast_downward: Planner, better: str) -> None:
    world = tiny_world(TWO_BALLS)
    for _ in range(6):
        drove(world, 30.0, "box_a", well=better == "box_a")
        drove(world, 30.0, "box_b", well=better == "box_b")
    found = planned(fast_downward, world, HOLDING("gripper_1", "tiny:Ball"))

    assert used(found, "Location", "drive") == {better}


@pytest.mark.parametrize("better", ["arm_1", "arm_2"])
def test_durations_of_temporal_plans_are_those_of_robot_and_place(kairos: Planner, better: str) -> None:
    world = tiny_world(robots=2)
    for arm in ("arm_1", "arm_2"):
        picked(world, arm, "box_a", "ball_1", well=arm == better)
    found = planned(kairos, world, IN_CONTAINER("ball_1", "slot_1"), temporal=True)

    assert used(found, "Arm") == {better}


def test_a_plan_tells_its_expected_time_and_chance(fast_downward: Planner) -> None:
    world = tiny_world()
    goal = HOLDING("gripper_1", "ball_1")
    before = planned(fast_downward, world, goal)
    picked(world, "arm_1", "box_a", "ball_1", well=True, times=40)
    drove(world, 6.0)
    after = planned(fast_downward, world, goal)

    assert (before.seconds, before.chance) == (None, None)
    assert after.seconds == pytest.approx(14.0, rel=0.1)
    assert after.chance is not None
    assert 0.9 < after.chance < 1.0


def test_after_forgetting_the_next_plan_is_as_before_learning(fast_downward: Planner) -> None:
    world = tiny_world(TWO_BALLS)
    goal = IN_CONTAINER("tiny:Ball", "slot_1")
    before = planned(fast_downward, world, goal)
    usual = next(iter(used(before, "Box")))
    picked(world, "arm_1", usual, "ball_1", well=False)
    learned = planned(fast_downward, world, goal)
    with world.transaction("test", "forgets") as tx:
        forget(tx, world)
    after = planned(fast_downward, world, goal)

    assert used(learned, "Box") != {usual}
    assert (after.steps, after.seconds, after.chance) == (before.steps, before.seconds, before.chance)


def test_the_how_to_runs_as_it_is_written() -> None:
    page = Path(__file__).parents[3] / "docs" / "how-to" / "learned-costs.md"
    (block,) = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)

    exec(block, {})
