from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest
from support.planning import tiny_task
from unified_planning.io import PDDLReader

from skiros_py.planning.domain.model import Atom
from skiros_py.planning.domain.pddl import write_pddl
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.plan_validation import grounded, read_plan
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.planner import Solved
from skiros_py.planning.problem.reachability import Relaxation
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.replay import replay
from skiros_py.planning.robots.allocation import ASSIGNED, Dealing, deal
from skiros_py.planning.robots.ordering import order, schedule
from skiros_py.skills.conditions import AllOf, Condition, ConditionType, Exists, Related, Role
from skiros_py.skills.parameters import Kind, Param
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, FITS, IN_CONTAINER, PICK, PLACE
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView
from skiros_py.world.world import World

HAS_SLOT = ConditionType(
    "HasSlot", (Role("kit", "tiny:Box"), Role("slot", "tiny:Slot")), Related("sk:hasA", "kit", "slot"), "-"
)
IN_KIT = ConditionType(
    "InKit",
    (Role("ball", "tiny:Ball"), Role("kit", "tiny:Box")),
    Exists("slot", "tiny:Slot", AllOf((Related("sk:hasA", "kit", "slot"), Related("sk:in", "ball", "slot")))),
    "-",
    abstract=True,
)
AT_KIT = replace(
    PLACE,
    params=(*PLACE.params, Param("Kit", "tiny:Box", "Has the slot.", Kind.PLANNING)),
    pre=(*PLACE.pre, HAS_SLOT("Kit", "Slot"), AT_LOCATION("Robot", "Kit")),
)
SKILLS = {skill.name: skill for skill in (DRIVE, PICK, AT_KIT)}
SECONDS = {"drive": 5.0, "pick": 3.0, "place": 2.0}


def kit_world(parts: int, robots: int, *facts: str) -> World:
    """A ball in a box of its own for each slot of one kit."""
    each = (
        f"scene:part_{n} a tiny:Ball ; sk:in scene:store_{n} . scene:store_{n} a tiny:Box ; sk:on scene:floor . "
        f"scene:hole_{n} a tiny:Slot . scene:kit sk:hasA scene:hole_{n} ."
        for n in range(1, parts + 1)
    )
    return tiny_world("scene:kit a tiny:Box ; sk:on scene:floor .", *each, *facts, robots=robots)


def filled(parts: int) -> tuple[Condition, ...]:
    return tuple(IN_CONTAINER(f"part_{n}", f"hole_{n}") for n in range(1, parts + 1))


def timed_task(view: WorldView, *goal: Condition, agents: Sequence[str] | None = None) -> PlanningTask:
    task = tiny_task(view, *goal, skills=tuple(SKILLS.values()), agents=agents)
    actions = tuple(replace(a, duration=SECONDS.get(a.skill or "")) for a in task.domain.actions)
    return replace(task, domain=replace(task.domain, actions=actions))


def parts_of(task: PlanningTask) -> dict[str, tuple[int, ...]]:
    return {share.robot: tuple(share.parts) for share in Dealing(task).shares}


@pytest.mark.parametrize(("parts", "robots"), [(4, 2), (8, 3), (16, 4), (1, 2)])
def test_goals_are_allocated_fairly_to_all_robots(parts: int, robots: int) -> None:
    world = kit_world(parts, robots)
    counts = [len(own) for own in parts_of(timed_task(world, *filled(parts))).values()]

    assert sum(counts) == parts
    assert max(counts) - min(counts) <= 1


def test_a_robot_places_the_part_that_it_holds() -> None:
    world = Overlay(kit_world(3, 2))
    world.place("part_1", "sk:heldBy", "gripper_2")
    world.place("part_2", "sk:heldBy", "gripper_1")

    dealt = parts_of(timed_task(world, *filled(3)))

    assert 0 in dealt["robot_2"]
    assert 1 in dealt["robot_1"]


def test_a_robot_gets_no_goal_that_needs_a_skill_it_lacks() -> None:
    world = kit_world(4, 2)
    task = timed_task(world, *filled(4), agents=["base_1", "base_2", "arm_2"])

    assert parts_of(task) == {"robot_1": (), "robot_2": (0, 1, 2, 3)}


def test_a_robot_may_visit_places_of_goals_that_are_allocated_to_others() -> None:
    world = kit_world(1, 2)
    task = timed_task(world, *filled(1), AT_LOCATION("robot_2", "kit"))

    assert not any(share.things & {"kit", "store_1"} for share in Dealing(task).shares)
    assert isinstance(solved(world, task), Solved)


def test_a_task_for_one_robot_is_unchanged() -> None:
    world = kit_world(2, 1)
    task = timed_task(world, *filled(2))

    assert deal(task) is task


def test_conditions_that_already_hold_are_not_allocated() -> None:
    world = Overlay(kit_world(2, 2))
    world.place("part_1", "sk:in", "hole_1")

    dealt = parts_of(timed_task(world, *filled(2)))

    assert sorted(part for own in dealt.values() for part in own) == [1]


def test_conditions_about_the_same_thing_go_to_one_robot() -> None:
    world = kit_world(2, 2)
    task = timed_task(world, *filled(2), FITS("part_1", "hole_1"), IN_KIT("part_1", "kit"))
    dealt = parts_of(task)

    assert sorted(map(len, dealt.values())) == [1, 3]
    assert (0, 2, 3) in dealt.values()


def test_goals_by_class_are_allocated_too_and_surplus_things_are_ignored() -> None:
    world = kit_world(4, 2)
    task = timed_task(world, IN_KIT("tiny:Ball", "kit"), IN_CONTAINER("tiny:Ball", "hole_2"))
    dealt = Dealing(task).shares

    assert [len(share.parts) for share in dealt] == [1, 1]


def test_each_goal_by_class_gets_one_thing() -> None:
    world = kit_world(4, 2, "scene:other a tiny:RedBall ; sk:in scene:store_1 .")
    goal = IN_KIT("tiny:RedBall", "kit")
    task = timed_task(world, goal)
    first = next(share for share in Dealing(task).shares if share.parts)
    facts = {atom for atom in deal(task).problem.init if atom.predicate == ASSIGNED}
    arm = next(agent for agent in first.agents if agent.startswith("arm"))

    assert first.things <= {"other", "red_ball_1"}
    assert len(first.things) == 1
    assert {atom for atom in facts if atom.arguments[1] in ("other", "red_ball_1")} == {
        Atom(ASSIGNED, (arm, next(iter(first.things))))
    }


def test_the_allocated_task_is_the_same_every_time() -> None:
    world = kit_world(6, 3)

    assert deal(timed_task(world, *filled(6))) == deal(timed_task(world, *filled(6)))


def test_subsystems_belong_to_the_robot_they_are_part_of() -> None:
    world = kit_world(1, 2)

    assert timed_task(world, *filled(1)).teams == {
        "robot_1": {"arm_1", "base_1"},
        "robot_2": {"arm_2", "base_2"},
    }


# ------------------------------------------------------------ estimates


def test_an_estimate_is_the_sum_of_the_required_steps() -> None:
    world = kit_world(1, 2)
    cost = Relaxation(timed_task(world, *filled(1)), timed=True).cost

    assert cost[Atom("sk:at", ("robot_1", "store_1"))] == 5.0
    assert cost[Atom("sk:heldBy", ("part_1", "gripper_1"))] == 8.0
    assert cost[Atom("sk:in", ("part_1", "hole_1"))] == 15.0


def test_a_goal_that_no_allowed_robot_can_reach_has_no_estimate() -> None:
    world = kit_world(1, 2)
    cost = Relaxation(timed_task(world, *filled(1)), {"base_1", "arm_2"}, timed=True).cost

    assert Atom("sk:at", ("robot_1", "store_1")) in cost
    assert Atom("sk:in", ("part_1", "hole_1")) not in cost


# ------------------------------------------------------------ how long it all takes


def solved(view: WorldView, task: PlanningTask) -> object:
    texts = write_pddl(*(lambda t: (t.domain, t.problem))(deal(task)), name="allocation")
    return FastDownward().solve(texts.domain, texts.problem).result()


def planned(view: WorldView, task: PlanningTask) -> Plan:
    narrow = deal(task)
    texts = write_pddl(narrow.domain, narrow.problem, name="allocation")
    answer = FastDownward().solve(texts.domain, texts.problem).result()
    assert isinstance(answer, Solved)
    steps = read_plan(narrow, texts, answer)
    steps = without_detours(view, steps, task)
    return order(narrow, Plan(steps, grounded(narrow, steps)))


def without_detours(view: WorldView, steps: tuple[Step, ...], task: PlanningTask) -> tuple[Step, ...]:
    for index in reversed(range(len(steps))):
        shorter = steps[:index] + steps[index + 1 :]
        if replay(view, shorter, task.conditions, SKILLS) is None:
            steps = shorter
    return steps


@pytest.mark.parametrize(("parts", "robots", "best"), [(4, 2, 30.0), (8, 3, 45.0), (16, 4, 60.0)])
def test_the_plan_takes_no_longer_than_the_best_known(parts: int, robots: int, best: float) -> None:
    world = kit_world(parts, robots)
    plan = planned(world, timed_task(world, *filled(parts)))
    durations = [SECONDS[step.skill] for step in plan.steps]

    assert replay(world, plan.steps, filled(parts), SKILLS) is None
    assert max(map(sum, zip(schedule(plan.order, durations), durations, strict=True))) <= best


def test_of_four_parts_each_of_two_robots_places_two() -> None:
    world = kit_world(4, 2)
    plan = planned(world, timed_task(world, *filled(4)))
    placers = [step.arguments["Robot"] for step in plan.steps if step.skill == "place"]

    assert sorted(placers) == ["robot_1", "robot_1", "robot_2", "robot_2"]


def test_other_pddl_parsers_accept_an_allocated_task() -> None:
    world = kit_world(2, 2)
    narrow = deal(timed_task(world, *filled(2)))
    texts = write_pddl(narrow.domain, narrow.problem, name="allocation")

    assert "(assigned ?arm ?ball)" in texts.domain
    assert PDDLReader().parse_problem_string(texts.domain, texts.problem).fluent("assigned").arity == 2
