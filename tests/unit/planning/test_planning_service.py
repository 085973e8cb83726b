from __future__ import annotations

from types import MappingProxyType

import pytest

from skiros_py.errors import PlanningError
from skiros_py.planning.plan import NoPlan, Plan, Step, read_plan
from skiros_py.testing import Bench, GivenPlanner, tiny_pddl, tiny_world
from skiros_py.testing.tiny_skills import AT_LOCATION

RIGHT = (
    "drive base_1 robot_1 box_a unknown_location",
    "pick arm_1 gripper_1 robot_1 box_a ball_1",
    "place arm_1 gripper_1 robot_1 ball_1 slot_1",
)
GOAL = "In(ball_1, slot_1)"


def planned(*steps: str, goal: str = GOAL) -> Plan | NoPlan:
    with Bench(tiny_world(), planner=GivenPlanner(*steps)) as bench:
        return bench.plan(goal).outcome


def test_a_right_plan_survives_the_replay() -> None:
    plan = planned(*RIGHT)

    assert isinstance(plan, Plan)
    assert [step.skill for step in plan.steps] == ["drive", "pick", "place"]
    assert plan.steps[0] == Step("drive", {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"})


def test_detours_are_left_out() -> None:
    wandering = ("drive base_1 robot_1 box_b unknown_location", "drive base_1 robot_1 box_a box_b", *RIGHT[1:])

    assert planned(*wandering) == planned(*RIGHT)


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        (RIGHT[1:], r"wrong at step 1 \(pick\(.*\): At\(robot_1, box_a\)"),
        (RIGHT[:2], r"wrong at the end: In\(ball_1, slot_1\)"),
        ((RIGHT[0], RIGHT[2]), r"wrong at step 2 \(place\(.*\): Holding\(gripper_1, ball_1\)"),
        (("fly base_1",), "'fly', which is not in the task"),
        (("drive base_1 robot_1 moon unknown_location",), "'moon', which is not in the task"),
    ],
)
def test_a_wrong_plan_is_refused_and_nothing_is_done(steps: tuple[str, ...], message: str) -> None:
    with pytest.raises(PlanningError, match=message):
        planned(*steps)


def test_the_message_names_the_planner() -> None:
    with pytest.raises(PlanningError, match="the plan of given is wrong"):
        planned(*RIGHT[1:])


def test_a_planner_may_answer_in_capitals() -> None:
    assert planned(*(step.upper() for step in RIGHT)) == planned(*RIGHT)


def test_when_each_condition_alone_could_be_reached_the_answer_says_so() -> None:
    outcome = planned(goal=f"{GOAL} and In(ball_1, slot_2)")

    assert outcome == NoPlan(("each condition could be reached alone, but not all of them together",))


def test_the_same_ball_in_two_slots_has_no_plan() -> None:
    with Bench(tiny_world()) as bench:
        outcome = bench.plan("In(ball_1, slot_1)", "In(ball_1, slot_2)").outcome

    assert isinstance(outcome, NoPlan)


def test_a_robot_leaves_an_unknown_location() -> None:
    with Bench(tiny_world()) as bench:
        outcome = bench.plan("At(robot_1, box_a)").outcome

    assert isinstance(outcome, Plan)
    assert [str(step) for step in outcome.steps] == ["drive(Base=base_1, Robot=robot_1, Location=box_a)"]


def test_a_robot_that_is_there_already_does_not_drive() -> None:
    world = tiny_world()
    with world.transaction("test", "parked") as tx:
        tx.place("robot_1", "sk:at", "box_a")

    with Bench(world) as bench:
        there, pick = bench.plan("At(robot_1, box_a)").outcome, bench.plan("Holding(gripper_1, ball_1)").outcome

    assert there == Plan(())
    assert isinstance(pick, Plan)
    assert [step.skill for step in pick.steps] == ["pick"]


def test_planning_never_changes_the_world() -> None:
    world = tiny_world()
    with Bench(world) as bench:
        before = world.version
        bench.plan(GOAL)

        assert world.version == before


def test_a_goal_of_a_class_takes_any_of_its_elements() -> None:
    with Bench(tiny_world()) as bench:
        outcome = bench.plan("In(RedBall, slot_2)").outcome

    assert isinstance(outcome, Plan)
    assert outcome.steps[-1].arguments["Ball"] == "red_ball_1"


def test_a_robot_without_skills_is_never_given_a_task_even_where_it_is_nearer() -> None:
    world = tiny_world(robots=2)
    with world.transaction("test", "parked") as tx:
        tx.place("robot_2", "sk:at", "box_a")

    with Bench(world, robots=["robot_1"]) as bench:
        outcome = bench.plan(GOAL).outcome

    assert isinstance(outcome, Plan)
    assert {a for step in outcome.steps for a in step.arguments.values() if a.endswith("_2")} == set()
    assert outcome.steps[0].skill == "drive"


def test_bookkeeping_of_the_goal_is_no_step_of_the_plan() -> None:
    texts = tiny_pddl(tiny_world(), AT_LOCATION("robot_1", "box_a"))
    lines = (("drive", "base_1", "robot_1", "box_a", "unknown_location"),)

    plan = read_plan(lines, texts, MappingProxyType({"drive": ("Base", "Robot", "Location")}))

    assert plan.steps[0].arguments == {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"}
