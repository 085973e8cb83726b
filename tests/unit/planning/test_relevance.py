"""Problems hold what the goal can need, and no more: whatever else there is in the world."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest
from agreement import disagreement
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from random_tasks import TAKE, RandomTask, mixed_task, random_task

from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.problem.task import Capability, PlanningTask, build_task
from skiros_py.skills.conditions import Condition, ConditionType, Related, Role
from skiros_py.skills.parameters import Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.goals import parse_goal
from skiros_py.testing import CONDITIONS, tiny_world
from skiros_py.testing.tiny import (
    AT_LOCATION,
    DRIVE,
    EMPTY_HANDED,
    FREE,
    HAS_PART,
    HOLDING,
    IN_CONTAINER,
    PICK,
    PLACE,
)
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView
from skiros_py.world.world import World

SKILLS = (DRIVE, PICK, PLACE)


@pytest.fixture(scope="module")
def planner() -> Iterator[Kairos]:
    kairos = Kairos()
    yield kairos
    kairos.close()


def task(
    view: WorldView, *goal: Condition, width: int | None = None, skills: tuple[SkillDescription, ...] = SKILLS
) -> PlanningTask:
    able = [Capability(skill, view.instances(skill.agent_class)) for skill in skills]
    return build_task(view, able, goal, width=width)


def things(found: PlanningTask, *classes: str) -> set[str]:
    return {name for name, type_ in found.problem.objects.items() if type_ in classes}


# ------------------------------------------------------------------ what a goal names, and what follows from that


def test_a_problem_contains_the_goal_things_their_places_and_capable_agents() -> None:
    found = task(tiny_world(), IN_CONTAINER("ball_1", "slot_1"), width=1)

    assert set(found.problem.objects) == {
        "arm_1", "ball_1", "base_1", "box_a", "gripper_1", "robot_1", "slot_1", "unknown_location",
    }  # fmt: skip


def test_irrelevant_skills_are_left_out_of_the_problem() -> None:
    found = task(tiny_world(), AT_LOCATION("robot_1", "box_a"))

    assert [action.skill for action in found.domain.actions] == ["drive"]
    assert set(found.problem.objects) == {"base_1", "box_a", "robot_1", "unknown_location"}


def test_only_the_complete_problem_is_marked_as_complete() -> None:
    assert task(tiny_world(), IN_CONTAINER("ball_1", "slot_1")).complete
    assert not task(tiny_world(), IN_CONTAINER("ball_1", "slot_1"), width=1).complete


def test_obstacles_and_their_possible_targets_are_in_the_problem() -> None:
    world = tiny_world("scene:ball_9 a tiny:Ball ; sk:in scene:slot_1 .")

    found = task(world, IN_CONTAINER("ball_1", "slot_1"), width=1, skills=(*SKILLS, TAKE))

    assert "ball_9" in found.problem.objects
    assert len(things(found, "tiny:Slot")) > 1


STANDS_ON = ConditionType(
    "StandsOn", (Role("upper", "sk:Location"), Role("lower", "sk:Location")), Related("sk:on", "upper", "lower"), "-"
)
CLIMB = replace(
    DRIVE,
    name="climb",
    params=(*DRIVE.params[:2], Param("From", "sk:Location", "Whence."), DRIVE.params[2]),
    pre=(HAS_PART("Robot", "Base"), AT_LOCATION("Robot", "From"), STANDS_ON("Location", "From")),
)


@pytest.mark.parametrize("width", [1, None])
def test_a_route_over_several_places_is_in_the_problem_without_unrelated_places(width: int | None) -> None:
    world = tiny_world("scene:slot_9 a tiny:Slot ; sk:on scene:box_b .", boxes(20))
    with world.transaction("test", "on the ground") as tx:
        tx.place("robot_1", "sk:at", "floor")

    found = task(world, AT_LOCATION("robot_1", "slot_9"), skills=(CLIMB,), width=width)

    assert set(found.problem.objects) == {"base_1", "box_b", "floor", "robot_1", "slot_9"}


# ------------------------------------------------------------------ candidates for what may be chosen


def boxes(number: int) -> str:
    return "\n".join(f"scene:box_{n} a tiny:Box ; sk:on scene:floor ." for n in range(100, 100 + number))


def balls(number: int, where: str = "sk:in scene:box_a", class_: str = "tiny:Ball") -> str:
    return "\n".join(f"scene:ball_{n} a {class_} ; {where} ." for n in range(100, 100 + number))


def test_only_a_few_of_many_candidates_are_in_the_problem() -> None:
    found = task(tiny_world(balls(50), boxes(50)), IN_CONTAINER("tiny:Ball", "slot_1"), width=3)

    assert len(things(found, "tiny:Ball", "tiny:RedBall")) == 3
    assert len(things(found, "tiny:Box")) <= 3


def test_each_choice_in_a_goal_has_its_own_candidates() -> None:
    goal = (IN_CONTAINER("tiny:Ball", "slot_1"), IN_CONTAINER("tiny:Ball", "slot_2"))

    found = task(tiny_world(balls(50)), *goal, width=1)

    assert len(things(found, "tiny:Ball")) == 2


def test_candidates_are_usable_and_fitting_even_if_others_come_first() -> None:
    world = tiny_world(
        balls(30, "sk:on scene:floor"),
        "scene:giant_1 a tiny:Giant ; sk:in scene:box_a .",
        "scene:zebra_1 a tiny:Ball ; sk:in scene:box_b .",
    )
    with world.transaction("test", "put away") as tx:
        tx.place("ball_1", "sk:on", "floor")
        tx.place("red_ball_1", "sk:on", "floor")

    found = task(world, IN_CONTAINER("tiny:Ball", "slot_1"), width=1)

    assert things(found, "tiny:Ball", "tiny:RedBall", "tiny:Giant") == {"zebra_1"}


def test_the_problem_does_not_depend_on_unrelated_elements() -> None:
    goal = (IN_CONTAINER("tiny:RedBall", "slot_1"), AT_LOCATION("robot_1", "box_a"))
    crowd = tiny_world(boxes(100), balls(200), "scene:door_1 a tiny:Door ; sk:on scene:floor .")

    assert task(crowd, *goal, width=1).problem == task(tiny_world(), *goal, width=1).problem


def test_all_views_of_one_world_give_the_same_problem() -> None:
    world = tiny_world(balls(80))
    goal = IN_CONTAINER("tiny:Ball", "slot_1")
    problems = [task(view, goal, width=2).problem for view in (world, world.snapshot(), Overlay(world))]

    assert problems[0] == problems[1] == problems[2]


def test_elements_hidden_by_a_view_are_not_candidates() -> None:
    found = task(
        Overlay(tiny_world(balls(80)), frozenset({"ball_1", "ball_100"})),
        IN_CONTAINER("tiny:Ball", "slot_1"),
        width=2,
    )

    assert things(found, "tiny:Ball") == {"ball_101", "ball_102"}


# ------------------------------------------------------------------ things that differ by name only


def test_the_complete_problem_has_as_many_equal_things_as_the_goal_can_use() -> None:
    goal = (IN_CONTAINER("tiny:Ball", "slot_1"), IN_CONTAINER("tiny:Ball", "slot_2"))

    found = task(tiny_world(balls(50)), *goal)

    assert len(things(found, "tiny:Ball")) == 2


def test_things_in_different_places_are_not_equal() -> None:
    world = tiny_world(balls(20), "scene:ball_900 a tiny:Ball ; sk:in scene:box_b .")

    assert things(task(world, IN_CONTAINER("tiny:Ball", "slot_1")), "tiny:Ball") == {"ball_1", "ball_900"}


def test_elements_named_in_the_goal_are_not_interchangeable() -> None:
    goal = (IN_CONTAINER("ball_120", "slot_1"), IN_CONTAINER("tiny:Ball", "slot_2"))

    assert things(task(tiny_world(balls(30)), *goal), "tiny:Ball") == {"ball_1", "ball_120"}


def test_consumable_things_are_all_in_the_problem() -> None:
    token = Param("Token", "tiny:Ball", "What it costs.")
    paid = replace(
        DRIVE,
        params=(*DRIVE.params, token, Param("Box", "tiny:Box", "Where that lies."), Param("Sink", "tiny:Slot", "-")),
        pre=(*DRIVE.pre, IN_CONTAINER("Token", "Box")),
        post=(*DRIVE.post, IN_CONTAINER("Token", "Sink")),
    )
    goal = (AT_LOCATION("robot_1", "box_a"), IN_CONTAINER("tiny:RedBall", "slot_2"))

    found = task(tiny_world(balls(20)), *goal, skills=(paid, PICK, PLACE))

    assert len(things(found, "tiny:Ball")) == 21


# ------------------------------------------------------------------ nothing is lost


@pytest.mark.parametrize("seed", range(12))
def test_leaving_out_elements_does_not_change_plan_existence(seed: int, planner: Kairos) -> None:
    assert disagreement(random_task(seed), planner) == ""


@pytest.mark.parametrize("seed", [*range(12), 89, 174, 357])
def test_leaving_out_elements_does_not_change_plan_existence_for_composite_goals_numbers_and_stock(
    seed: int, planner: Kairos
) -> None:
    assert disagreement(mixed_task(seed), planner) == ""


QUANTIFIED = (
    "for all s: Slot (In({0}, s))",
    "for all s: Slot (exists b: {0} (In(b, s)))",
    "for all s: Slot (exists b: {0} (In(b, s) and not In(b, box_b)))",
    "for all s: Slot (In({0}, s) or Free(s))",
    "for all s: Slot (In({0}, s) or In({1}, s))",
    "for all b: {0} (exists s: Slot (In(b, s)))",
    "exists b: {0} (exists c: {1} (In(b, slot_1) and In(c, slot_2)))",
    "exists b: {0} (for all s: Slot (In(b, s) or (exists c: {1} (In(c, s)))))",
    "exists b: {0} (Holding(gripper_1, b) and In({1}, slot_1))",
    "exists s: Slot (In({0}, s) and In({1}, s))",
)
CLASSES = st.sampled_from(("Ball", "RedBall"))


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sampled_from(QUANTIFIED), CLASSES, CLASSES, st.integers(0, 3), st.integers(0, 3), st.integers(2, 3))
@example("for all s: Slot (In({0}, s))", "RedBall", "Ball", 3, 0, 3)
@example("for all s: Slot (exists b: {0} (In(b, s)))", "RedBall", "Ball", 0, 3, 3)
def test_leaving_out_equal_things_does_not_change_plan_existence_for_quantified_goals(
    planner: Kairos, goal: str, one: str, other: str, known: int, counted: int, slots: int
) -> None:
    stock = f'scene:reds a sk:Stock ; sk:stockOf "tiny:RedBall" ; sk:stockCount {counted} .'
    world = tiny_world(
        balls(known, "sk:in scene:box_b", "tiny:RedBall"),
        "scene:slot_3 a tiny:Slot ; sk:on scene:floor ." if slots == 3 else "",
        f"scene:box_b sk:hasA scene:reds . {stock}" if counted else "",
    )
    able = tuple(Capability(skill, world.instances(skill.agent_class)) for skill in SKILLS)
    conditions = parse_goal([goal.format(one, other)], world, CONDITIONS)

    assert disagreement(RandomTask(world, able, conditions), planner) == ""


def test_the_complete_problem_allows_a_gripper_to_be_emptied_anywhere(planner: Kairos) -> None:
    """Two balls change places: one must be put down in a third slot, which nothing speaks of."""
    world: World = tiny_world("scene:slot_3 a tiny:Slot ; sk:on scene:floor .")
    with world.transaction("test", "each in the slot of the other") as tx:
        tx.place("ball_1", "sk:in", "slot_2")
        tx.place("red_ball_1", "sk:in", "slot_1")
    able = [Capability(skill, world.instances(skill.agent_class)) for skill in (*SKILLS, TAKE)]
    goal = (IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("red_ball_1", "slot_2"))

    assert disagreement(RandomTask(world, tuple(able), goal), planner) == ""
    assert "slot_3" in build_task(world, able, goal).problem.objects


@pytest.mark.parametrize(
    "goal", [HOLDING("gripper_1", "tiny:Ball"), ~EMPTY_HANDED("gripper_1"), FREE("slot_1"), ~FREE("slot_1")]
)
def test_goals_of_every_kind_have_plans_with_one_candidate_each(goal: Condition, planner: Kairos) -> None:
    world = tiny_world(balls(5), "scene:giant_1 a tiny:Giant ; sk:in scene:slot_1 .")
    able = tuple(Capability(skill, world.instances(skill.agent_class)) for skill in (*SKILLS, TAKE))

    assert disagreement(RandomTask(world, able, (goal,)), planner, width=1) == ""
