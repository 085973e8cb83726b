from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import kairos
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.planning import tiny_task
from unified_planning.io import PDDLReader

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.pddl import PddlTexts, write_pddl
from skiros_py.planning.domain.sequencing import in_sequence, write_with_costs
from skiros_py.planning.domain.temporal import write_temporal
from skiros_py.planning.plan import NoPlan, Plan, Step
from skiros_py.planning.plan_validation import validate
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.planners.planner import Answer, Planner, Planners, Solved, Unsolvable
from skiros_py.planning.problem.task import Capability, PlanningTask
from skiros_py.planning.replay import Flaw, replay
from skiros_py.planning.requests import Check
from skiros_py.planning.robots.allocation import deal
from skiros_py.planning.robots.ordering import order
from skiros_py.planning.sequence import Round, counts
from skiros_py.planning.service import plan as plan_for
from skiros_py.programs import Ended
from skiros_py.skills.conditions import AllOf, Condition, ConditionType, Exists, Related, Role
from skiros_py.tasks.goals import parse_goal
from skiros_py.testing import CONDITIONS, GivenPlanner, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, IN_CONTAINER, PICK, PLACE
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView
from skiros_py.world.world import World

SKILLS = {skill.name: skill for skill in (DRIVE, PICK, PLACE)}
ON = "scene:floor sk:useSequenceNumbers true ."
BOTH = IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("red_ball_1", "slot_2")
"""The first ball lies in box_a, the red one in box_b."""


def numbered(*facts: str, a: int | None = 2, b: int | None = 1, robots: int = 1) -> World:
    numbers = [f"scene:box_{n} sk:sequenceNumber {v} ." for n, v in (("a", a), ("b", b)) if v is not None]
    return tiny_world(ON, *numbers, *facts, robots=robots)


def drive(location: str, robot: int = 1) -> Step:
    return Step("drive", {"Base": f"base_{robot}", "Robot": f"robot_{robot}", "Location": location})


def written(
    world: WorldView, *goal: Condition, reached: Mapping[str, int] | None = None
) -> tuple[PlanningTask, PddlTexts]:
    task = in_sequence(tiny_task(world, *goal), reached)
    return task, write_with_costs(task, name="round")


def planned(
    world: WorldView, *goal: Condition, reached: Mapping[str, int] | None = None, by: Planner | None = None
) -> Plan | None:
    task, texts = written(world, *goal, reached=reached)
    answer = (by or FastDownward()).solve(texts.domain, texts.problem).result()
    if isinstance(answer, Unsolvable):
        return None
    plan = validate(task, texts, answer)
    assert isinstance(plan, Plan), plan
    return plan


def visits(plan: Plan | None, robot: str = "robot_1") -> list[str]:
    assert plan is not None
    return [s.arguments["Location"] for s in plan.steps if s.skill == "drive" and s.arguments["Robot"] == robot]


# ------------------------------------------------------------ plans keep to the numbers


@pytest.mark.parametrize("planner", [FastDownward(), Kairos()], ids=["fast-downward", "kairos"])
@pytest.mark.parametrize(("a", "b"), [(1, 2), (2, 1)])
def test_no_robot_visits_a_lower_number_after_a_higher_one(planner: Planner, a: int, b: int) -> None:
    plan = planned(numbered(a=a, b=b), *BOTH, by=planner)

    assert visits(plan) == (["box_a", "box_b"] if a < b else ["box_b", "box_a"])


def test_disabled_sequence_numbers_change_nothing() -> None:
    world = tiny_world("scene:box_a sk:sequenceNumber 2 .", "scene:box_b sk:sequenceNumber 1 .")
    task = tiny_task(world, *BOTH)

    assert not counts(world)
    assert in_sequence(task) is task


def test_sequence_numbers_are_enabled_and_set_like_any_property() -> None:
    world = tiny_world()
    with world.transaction(author="person", reason="our round") as tx:
        tx.set("floor", "sk:useSequenceNumbers", True)
        tx.set("box_a", "sk:sequenceNumber", 2)
        tx.set("box_b", "sk:sequenceNumber", 1)

    assert visits(planned(world, *BOTH)) == ["box_b", "box_a"]


def test_a_number_may_be_visited_again_but_no_lower_one() -> None:
    world = numbered("scene:ball_2 a tiny:Ball ; sk:in scene:box_a .", "scene:slot_3 a tiny:Slot ; sk:on scene:floor .")
    goal = *BOTH, IN_CONTAINER("ball_2", "slot_3")

    assert visits(planned(world, *goal))[0] == "box_b"
    assert set(visits(planned(world, *goal))[1:]) == {"box_a"}


def test_locations_without_a_number_are_free_at_any_time() -> None:
    world = numbered(a=None, b=1)
    flaw = replay(world, [drive("box_a"), drive("box_b"), drive("box_a")], [], SKILLS)

    assert flaw is None
    assert planned(world, *BOTH, AT_LOCATION("robot_1", "box_a")) is not None


def test_each_robot_follows_its_own_sequence() -> None:
    world = numbered(robots=2)
    goal = AT_LOCATION("robot_1", "box_a"), AT_LOCATION("robot_2", "box_b")

    assert planned(world, *goal) is not None
    assert replay(world, [drive("box_a", 1), drive("box_b", 2)], goal, SKILLS) is None


def test_numbers_already_reached_count_when_replanning() -> None:
    world = numbered()

    assert planned(world, BOTH[0], reached={"robot_1": 2}) is not None
    assert planned(world, BOTH[1], reached={"robot_1": 2}) is None
    assert planned(world, BOTH[1], reached={"robot_1": 1}) is not None
    assert planned(world, BOTH[0], reached={"robot_1": 3}) is None


def test_a_robot_may_start_a_new_task_from_any_place() -> None:
    world = Overlay(numbered())
    world.place("robot_1", "sk:at", "box_a")

    assert visits(planned(world, *BOTH))[0] == "box_b"


def test_a_plan_in_sequence_is_a_plan_of_the_pddl_task_and_gets_a_partial_order() -> None:
    world = numbered(robots=2)
    task = deal(in_sequence(tiny_task(world, *BOTH)))
    texts = write_pddl(task.domain, task.problem, name="round")
    answer = FastDownward().solve(texts.domain, texts.problem).result()
    assert isinstance(answer, Solved)
    plan = validate(task, texts, answer)
    assert isinstance(plan, Plan)

    ordered = order(task, plan)
    assert {s.arguments["Robot"] for s in plan.steps} == {"robot_1", "robot_2"}
    assert sum(not waits for waits in ordered.after) == 2


# ------------------------------------------------------------ the replay keeps to them, too


def test_the_replay_refuses_a_plan_that_goes_back_and_says_so() -> None:
    flaw = replay(numbered(), [drive("box_a"), drive("box_b")], [], SKILLS)

    assert flaw is not None
    assert flaw.step == 1
    assert flaw.verdict.text.startswith("robot_1 comes to box_b (sequence number 1) after number 2")


def test_the_replay_of_the_rest_knows_what_was_reached_and_what_the_present_step_will_reach() -> None:
    world = numbered()

    assert replay(world, [drive("box_b")], [], SKILLS, reached={"robot_1": 2}) is not None
    assert checked(world, [drive("box_a")], [drive("box_b")]) is not None
    assert checked(world, [drive("box_b")], [drive("box_a")], {"robot_1": 1}) is None


def test_the_progress_of_each_robot_in_the_sequence_is_reported() -> None:
    world = numbered(robots=2)
    way = Round(world, reached={"robot_2": 1})
    for step in (drive("box_b", 1), drive("box_a", 2)):
        assert way.take(world, DRIVE, step.arguments) is None

    assert way.reached == {"robot_1": 1, "robot_2": 2}


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.lists(st.one_of(st.none(), st.integers(1, 4)), min_size=3, max_size=3),
    st.lists(st.sampled_from([0, 1, 2]), min_size=1, max_size=3, unique=True),
    st.one_of(st.none(), st.integers(1, 5)),
)
def test_a_plan_exists_exactly_if_the_sequence_numbers_allow_one(
    numbers: list[int | None], wanted: list[int], start: int | None
) -> None:
    stores = [
        f"scene:store_{i} a tiny:Box ; sk:on scene:floor {f'; sk:sequenceNumber {n}' if n is not None else ''} ."
        f"scene:thing_{i} a tiny:Ball ; sk:in scene:store_{i} . scene:hole_{i} a tiny:Slot ; sk:on scene:floor ."
        for i, n in enumerate(numbers)
    ]
    world = tiny_world(ON, *stores)
    goal = [IN_CONTAINER(f"thing_{i}", f"hole_{i}") for i in wanted]
    reached = {} if start is None else {"robot_1": start}
    plan = planned(world, *goal, reached=reached, by=Kairos())
    possible = all((number := numbers[i]) is None or number >= (start or 0) for i in wanted)

    assert (plan is not None) == possible
    if plan is not None:
        assert replay(world, plan.steps, goal, SKILLS, reached=reached) is None


def test_if_only_sequence_numbers_prevent_a_plan_the_reason_says_so() -> None:
    world = numbered()
    task = tiny_task(world, BOTH[1])
    texts = write_pddl(task.domain, task.problem, name="round")
    answer = FastDownward().solve(texts.domain, texts.problem).result()
    assert isinstance(answer, Solved)
    plan = validate(task, texts, answer)
    assert isinstance(plan, Plan)

    assert planned(world, BOTH[1], reached={"robot_1": 2}) is None
    flaw = replay(world, plan.steps, BOTH[1:], SKILLS, reached={"robot_1": 2})
    assert flaw is not None
    assert flaw.verdict.text == (
        "robot_1 comes to box_b (sequence number 1) after number 2: "
        "sequence numbers count here, so no robot visits a lower one after a higher"
    )
    assert replay(world, plan.steps, BOTH[1:], SKILLS) is None


# ------------------------------------------------------------ costs


def test_driving_between_numbers_costs_their_difference() -> None:
    world = numbered(a=7, b=3)
    _, texts = written(world, *BOTH)

    assert texts.requirements == (":strips", ":typing", ":action-costs")
    assert "(= (sequence-cost box_b box_a) 5)" in texts.problem
    assert "(= (sequence-cost box_a box_a) 1)" in texts.problem
    assert "(sequence-cost box_a box_b)" not in texts.problem
    assert texts.domain.count("(increase (total-cost) (sequence-cost ?location_last ?location))") == 1


def test_other_pddl_parsers_accept_the_costs_and_a_planner_minimises_them() -> None:
    world = numbered("scene:slot_3 a tiny:Slot ; sk:on scene:floor .", a=7, b=3)
    _, texts = written(world, *BOTH)
    read = PDDLReader().parse_problem_string(texts.domain, texts.problem)
    domain = kairos.parse_domain(texts.domain)
    problem = kairos.parse_problem(texts.problem, domain)
    result = kairos.Planner().solve(problem, anytime=False)

    assert len(read.quality_metrics) == 1
    assert result.status == kairos.Status.SOLVED
    assert kairos.validate(problem, result.plan).valid


def test_sequence_numbers_and_time_go_together() -> None:
    world = numbered()
    task = in_sequence(tiny_task(world, *BOTH))
    texts = write_temporal(task, name="round")
    answer = Kairos().solve(texts.domain, texts.problem).result()

    assert isinstance(answer, Solved)
    plan = validate(task, texts, answer)
    assert isinstance(plan, Plan)
    assert visits(plan) == ["box_b", "box_a"]


# ------------------------------------------------------------ several kits keep their order

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


def kits(first: int = 1, second: int = 2) -> World:
    return tiny_world(
        ON,
        *(f"scene:kit_{k} a tiny:Box ; sk:on scene:floor ; sk:workNumber {n} ." for k, n in ((1, first), (2, second))),
        *(f"scene:hole_{k}{i} a tiny:Slot . scene:kit_{k} sk:hasA scene:hole_{k}{i} ." for k in (1, 2) for i in (1, 2)),
        *(f"scene:part_{i} a tiny:Ball ; sk:in scene:box_a ." for i in (1, 2, 3, 4)),
    )


def kits_filled(plan: Plan | None) -> list[str]:
    assert plan is not None
    return [re.sub(r"hole_(.).", r"kit_\1", s.arguments["Slot"]) for s in plan.steps if s.skill == "place"]


FILLED = tuple(IN_CONTAINER(f"part_{2 * k + i - 2}", f"hole_{k}{i}") for k in (1, 2) for i in (1, 2))


@pytest.mark.parametrize(("first", "second"), [(1, 2), (2, 1)])
def test_the_kit_of_the_lower_number_is_finished_first(first: int, second: int) -> None:
    expected = ["kit_1", "kit_1", "kit_2", "kit_2"]

    assert kits_filled(planned(kits(first, second), *FILLED)) == (expected if first < second else expected[::-1])


def test_goals_by_class_respect_the_order_of_the_kits() -> None:
    world = kits(2, 1)
    goal = IN_KIT("tiny:RedBall", "kit_1"), IN_KIT("part_1", "kit_2")

    assert kits_filled(planned(world, *goal)) == ["kit_2", "kit_1"]


def test_the_replay_refuses_to_begin_a_kit_too_early_and_says_what_comes_first() -> None:
    world = kits()
    hand = {"Arm": "arm_1", "Gripper": "gripper_1", "Robot": "robot_1"}
    steps = [drive("box_a"), Step("pick", {**hand, "Box": "box_a", "Ball": "part_3"})]
    steps += [Step("place", {**hand, "Ball": "part_3", "Slot": "hole_21"})]
    flaw = replay(world, steps, FILLED, SKILLS)

    assert flaw is not None
    assert flaw.verdict.text == (
        "part_3 goes to kit_2 (work number 2) before In(part_1, hole_11) holds: "
        "kit_1 has work number 1 and is done first"
    )


# ------------------------------------------------------------ said to people


def checked(
    world: World, running: Sequence[Step], rest: Sequence[Step], reached: Mapping[str, int] | None = None
) -> Flaw | None:
    check = Check((), tuple(running), tuple(rest), SKILLS, reached or {})
    return check.answer(world.snapshot(), Planners.only(GivenPlanner()), lambda: False).flaw


def outcome(
    world: World, *goal: Condition, reached: Mapping[str, int] | None = None, by: Planner | None = None
) -> Plan | NoPlan:
    able = [Capability(skill, tuple(world.instances(skill.agent_class))) for skill in SKILLS.values()]
    return plan_for(by or FastDownward(), world, able, goal, reached=reached).outcome


def test_a_plan_prevented_by_sequence_numbers_is_explained_in_a_sentence() -> None:
    world = numbered(a=1, b=2)
    found = outcome(world, AT_LOCATION("robot_1", "box_a"), BOTH[1])

    assert isinstance(found, NoPlan)
    (reason,) = found.reasons
    assert "no plan keeps to the sequence numbers" in reason
    assert "robot_1 comes to box_a (sequence number 1) after number 2" in reason
    assert isinstance(outcome(world, AT_LOCATION("robot_1", "box_b"), BOTH[0]), Plan)


def test_numbers_are_not_blamed_for_what_would_be_impossible_without_them() -> None:
    world = numbered("scene:giant_1 a tiny:Giant ; sk:in scene:box_a .")
    found = outcome(world, IN_CONTAINER("giant_1", "slot_1"))

    assert isinstance(found, NoPlan)
    assert found.reasons
    assert not any("sequence" in reason for reason in found.reasons)


# ------------------------------------------------------------ what has to hold before a later turn


def in_turns() -> World:
    """Slot 2 comes before slot 1; the giant is too heavy for anybody."""
    giant = "scene:giant_1 a tiny:Giant ; sk:in scene:box_a ."
    return tiny_world(ON, giant, "scene:slot_1 sk:workNumber 2 .", "scene:slot_2 sk:workNumber 1 .")


@pytest.mark.parametrize(
    "first",
    [
        "In(giant_1, slot_2) or In(ball_1, slot_2)",
        "In(ball_1, slot_2) or In(giant_1, slot_2)",
        "(In(giant_1, slot_1) and In(ball_1, slot_2)) or (In(ball_1, slot_2) and not In(ball_1, box_a))",
        "exists b: Giant (In(b, slot_2)) or exists b: Ball (In(b, slot_2) and not In(b, box_b))",
        "for all s: Slot (In(red_ball_1, s) or In(ball_1, s) or not In(ball_1, box_a)) and In(ball_1, slot_2)",
    ],
)
def test_any_alternative_of_the_earlier_goal_satisfies_the_sequence(first: str) -> None:
    world = in_turns()
    found = outcome(world, *parse_goal([first, "In(red_ball_1, slot_1)"], world, CONDITIONS))

    assert isinstance(found, Plan)
    assert [step.arguments["Slot"] for step in found.steps if step.skill == "place"] == ["slot_2", "slot_1"]


def test_a_place_with_a_higher_number_than_all_goals_is_filled_last() -> None:
    world = tiny_world(ON, "scene:slot_1 sk:workNumber 1 .", "scene:slot_2 sk:workNumber 9 .")
    goal = parse_goal(["In(ball_1, slot_1)", "not In(red_ball_1, box_b)", "EmptyHanded(gripper_1)"], world, CONDITIONS)
    found = outcome(world, *goal)

    assert isinstance(found, Plan)
    assert [step.arguments["Slot"] for step in found.steps if step.skill == "place"] == ["slot_1", "slot_2"]


def test_goals_with_very_many_alternatives_are_left_to_the_replay() -> None:
    world = in_turns()
    many = " or ".join(f"(In(ball_1, slot_{n % 2 + 1}) and not Free(slot_{n % 2 + 1}))" for n in range(60))
    task, _ = written(
        world, *parse_goal([f"({many}) and In(ball_1, slot_2)", "In(red_ball_1, slot_1)"], world, CONDITIONS)
    )

    assert len(task.domain.actions) < 200


class Tired(Kairos):
    """Gives up where numbers count."""

    def read(self, ended: Ended, folder: Path) -> Answer:
        if re.search("goes.on.from", (folder / "domain.pddl").read_text()):
            return Unsolvable("too tired", proven=False)
        return super().read(ended, folder)


def test_numbers_are_not_blamed_where_it_is_not_proved_that_they_leave_no_plan() -> None:
    world = numbered(a=1, b=2)

    with pytest.raises(PlanningError, match="too tired"):
        outcome(world, AT_LOCATION("robot_1", "box_a"), BOTH[1], by=Tired())
