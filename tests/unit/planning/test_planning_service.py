from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace

import pytest
from support.planning import tiny_task

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.pddl import write_pddl
from skiros_py.planning.plan import NoPlan, Plan, Step
from skiros_py.planning.plan_validation import read_plan
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.planners.planner import Planners, Solved
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.service import PlanningOptions, plan
from skiros_py.skills.conditions import AllOf, ConditionType, Exists, Nothing, Related, Role
from skiros_py.skills.parameters import Param
from skiros_py.skills.skill import Skill
from skiros_py.testing import CONDITIONS, SKILLS, Bench, GivenPlanner, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, EMPTY_HANDED, IN_CONTAINER, PICK, pretend
from skiros_py.world.world import World

RIGHT = (
    "drive base_1 robot_1 box_a unknown_location",
    "pick arm_1 gripper_1 robot_1 box_a ball_1",
    "place arm_1 gripper_1 robot_1 ball_1 slot_1",
)
GOAL = "In(ball_1, slot_1)"


def planned(*steps: str, goal: str = GOAL) -> Plan | NoPlan:
    with Bench(tiny_world(), planner=GivenPlanner(*steps)) as bench:
        return bench.plan(goal).outcome


def test_a_correct_plan_passes_the_replay() -> None:
    plan = planned(*RIGHT)

    assert isinstance(plan, Plan)
    assert [step.skill for step in plan.steps] == ["drive", "pick", "place"]
    assert plan.steps[0] == Step("drive", {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"})


def test_detours_are_removed_from_a_plan() -> None:
    wandering = (RIGHT[0], "drive base_1 robot_1 box_a box_a", *RIGHT[1:])

    assert planned(*wandering) == planned(*RIGHT)


@pytest.mark.parametrize(
    ("steps", "reason"),
    [
        (RIGHT[1:], r"the plan of given breaks at step 1 \(pick\(.*\)\): At\(robot_1, box_a\)"),
        (RIGHT[:2], r"the plan of given breaks at the end: In\(ball_1, slot_1\)"),
        ((RIGHT[0], RIGHT[2]), r"the plan of given breaks at step 2 \(place\(.*\)\): Holding\(gripper_1, ball_1\)"),
    ],
)
def test_a_plan_that_fails_the_replay_is_a_fault_with_its_first_bad_step(steps: tuple[str, ...], reason: str) -> None:
    with pytest.raises(PlanningError) as caught:
        planned(*steps)

    assert re.fullmatch(reason, str(caught.value))


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        (("fly base_1",), "'fly', which is not in the task"),
        (("drive base_1 robot_1 moon unknown_location",), "'moon', which is not in the task"),
    ],
)
def test_an_answer_with_unknown_names_is_a_fault_of_the_planner(steps: tuple[str, ...], message: str) -> None:
    with pytest.raises(PlanningError, match=message):
        planned(*steps)


def test_a_planner_may_answer_in_upper_case() -> None:
    assert planned(*(step.upper() for step in RIGHT)) == planned(*RIGHT)


def test_conditions_that_exclude_each_other_are_named_as_such() -> None:
    outcome = planned(goal=f"{GOAL} and In(ball_1, slot_2)")

    assert isinstance(outcome, NoPlan)
    assert [str(cause.kind) for cause in outcome.causes] == ["contradiction"]
    assert outcome.reasons[0].startswith("In(ball_1, slot_1) and In(ball_1, slot_2) exclude each other")


def test_one_condition_that_undoes_what_it_needs_is_not_said_to_be_several() -> None:
    outcome = planned()

    assert isinstance(outcome, NoPlan)
    assert outcome.reasons == (
        "In(ball_1, slot_1) cannot be reached: whatever is done for it undoes something else that it needs",
    )


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
    task = tiny_task(tiny_world(), AT_LOCATION("robot_1", "box_a"))
    texts = write_pddl(task.domain, task.problem, name="tiny")
    lines = (("drive", "base_1", "robot_1", "box_a", "unknown_location"),)

    steps = read_plan(task, texts, Solved(lines))

    assert steps[0].arguments == {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"}


# ------------------------------------------------------------------ goals that say more than one fact

EMPTY_BOX = ConditionType("EmptyBox", (Role("box", "sk:Container"),), Nothing("sk:in", "box"), "Nothing is in the box.")
SOMEWHERE = ConditionType(
    "Somewhere",
    (Role("ball", "tiny:Ball"), Role("place", "sk:SpatialThing")),
    Related("sk:placement", "ball", "place"),
    "It is in, on or at it.",
)
STORED = ConditionType(
    "Stored",
    (Role("ball", "tiny:Ball"), Role("where", "sk:Location")),
    Exists("box", "sk:Container", AllOf((Related("sk:in", "ball", "box"), Related("sk:on", "box", "where")))),
    "The ball lies in something that stands there.",
    abstract=True,
)
WORDS = {**CONDITIONS, "EmptyBox": EMPTY_BOX, "Somewhere": SOMEWHERE, "Stored": STORED}


def really_planned(goal: str, world: World | None = None, skills: Sequence[Skill] = SKILLS) -> Plan | NoPlan:
    with Bench(world or tiny_world(), skills, conditions=WORDS) as bench:
        return bench.plan(goal).outcome


def names(outcome: Plan | NoPlan) -> list[str]:
    assert isinstance(outcome, Plan), outcome
    return [step.skill for step in outcome.steps]


@pytest.mark.parametrize(
    ("goal", "steps"),
    [
        ("not In(ball_1, box_a)", ["drive", "pick"]),
        ("not In(Ball, box_a)", ["drive", "pick"]),
        ("not At(robot_1, unknown_location)", ["drive"]),
        ("not At(robot_1, box_a)", []),
    ],
)
def test_a_negated_condition_can_be_a_goal(goal: str, steps: list[str]) -> None:
    assert names(really_planned(goal)) == steps


def test_a_non_empty_gripper_can_be_a_goal() -> None:
    assert names(really_planned("not EmptyHanded(gripper_1)")) == ["drive", "pick"]


def test_an_untracked_empty_place_can_be_a_goal() -> None:
    assert names(really_planned("EmptyBox(box_a)")) == ["drive", "pick"]


def test_a_tracked_empty_place_can_be_a_goal() -> None:
    take = replace(
        PICK,
        name="take",
        params=(*PICK.params[:3], Param("Slot", "tiny:Slot", "Where."), PICK.params[4]),
        pre=(*PICK.pre[:2], IN_CONTAINER("Ball", "Slot"), EMPTY_HANDED("Gripper")),
    )
    world = tiny_world("scene:ball_9 a tiny:Ball ; sk:in scene:slot_1 .")

    assert names(really_planned("Free(slot_1)", world, (*SKILLS, pretend(take)))) == ["take"]


def test_a_goal_with_a_relation_is_reached_by_a_subrelation() -> None:
    assert names(really_planned("Somewhere(ball_1, slot_1)")) == ["drive", "pick", "place"]


def test_a_goal_with_a_variable_and_a_class_in_it_is_reached() -> None:
    world = tiny_world()
    with world.transaction("test", "out of sight") as tx:
        tx.place("ball_1", "sk:heldBy", "gripper_1")

    assert names(really_planned("Stored(ball_1, floor)", world)) == ["place"]
    assert really_planned("Stored(RedBall, floor)", world) == Plan(())


def test_two_goals_of_one_class_are_reached_by_elements_of_their_own() -> None:
    outcome = really_planned("In(Ball, slot_1) and In(Ball, slot_2)")

    assert isinstance(outcome, Plan)
    placed = {s.arguments["Slot"]: s.arguments["Ball"] for s in outcome.steps if s.skill == "place"}
    assert set(placed) == {"slot_1", "slot_2"}
    assert set(placed.values()) == {"ball_1", "red_ball_1"}


def test_hold_conditions_of_driving_are_achieved_before_driving() -> None:
    gripper = Param("Gripper", "sk:Gripper", "What it must not carry.")
    careful = replace(DRIVE, params=(*DRIVE.params, gripper), hold=(EMPTY_HANDED("Gripper"),))
    world = tiny_world()
    with world.transaction("test", "has its hand full") as tx:
        tx.place("ball_1", "sk:heldBy", "gripper_1")

    assert names(really_planned("At(robot_1, box_a)", world, (pretend(careful), *SKILLS[1:]))) == ["place", "drive"]


@pytest.mark.parametrize("name", ["finish", "reach-goal-1", "place/1", "Größe", "42"])
def test_a_skill_may_have_any_name(name: str) -> None:
    skills = (pretend(replace(DRIVE, name=name)), *SKILLS[1:])

    assert names(really_planned("In(RedBall, slot_1)", None, skills)) == [name, "pick", "place"]


def test_the_goal_is_kept_with_its_atoms() -> None:
    goal = (IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("tiny:RedBall", "slot_2"))

    task = tiny_task(tiny_world(), *goal)

    assert task.conditions == goal
    assert [[atom.predicate for atom in atoms] for _, atoms in task.goal] == [["sk:in"], ["reached 2"]]
    assert [a.name for a in task.domain.actions if a.skill is None] == [
        "bookkeeping:finish",
        "bookkeeping:reach-goal-2",
    ]


# ------------------------------------------------------------------ which planner, and in time


def test_a_plan_names_its_planner() -> None:
    with Bench(tiny_world(), planner=GivenPlanner(*RIGHT)) as bench:
        found = bench.plan(GOAL)

    assert (found.planner, found.notes) == ("given", ())


def test_if_no_planner_supports_the_task_the_fault_lists_what_each_lacks() -> None:
    poor = GivenPlanner(*RIGHT)
    poor.supports = frozenset({":strips"})

    with Bench(tiny_world(), planner=poor) as bench, pytest.raises(PlanningError, match="given does not take :typing"):
        bench.plan(GOAL)


def test_a_temporal_task_is_planned_with_an_order_and_start_times() -> None:
    world = tiny_world()
    able = [Capability(s.description, world.instances(s.description.agent_class)) for s in SKILLS]
    names = ("fast-downward", "kairos")

    with closing(Planners(names, lambda name: FastDownward() if name == "fast-downward" else Kairos())) as planners:
        found = plan(planners, world, able, (IN_CONTAINER("ball_1", "slot_1"),), options=PlanningOptions(temporal=True))

    assert isinstance(found.outcome, Plan)
    assert found.planner == "kairos"
    assert [step.skill for step in found.outcome.steps] == ["drive", "pick", "place"]
    assert found.texts is not None
    assert ":durative-actions" in found.texts.requirements
