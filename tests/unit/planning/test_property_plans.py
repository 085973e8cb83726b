"""Properties in plans: a scanned part, a charged battery, a door that is open, ajar or closed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
import unified_planning.shortcuts as up
from hypothesis import given, settings
from hypothesis import strategies as st
from support.planning import tiny_task
from unified_planning.engines import SequentialPlanValidator, ValidationResultStatus
from unified_planning.io import PDDLReader

from skiros_py.errors import PlanningError, UsageError
from skiros_py.planning.domain.actions import actions_of
from skiros_py.planning.domain.model import Atom
from skiros_py.planning.plan import NoPlan, Plan, Step
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.replay import replay
from skiros_py.planning.service import Planned, PlanningOptions
from skiros_py.planning.service import plan as plan_for
from skiros_py.skills.conditions import (
    AllOf,
    AnyOf,
    ClassRelated,
    Compare,
    Condition,
    ConditionType,
    Expression,
    Has,
    IsA,
    Not,
    Related,
    Role,
)
from skiros_py.skills.parameters import Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.testing import tiny_ontology, tiny_world
from skiros_py.testing.tiny import DRIVE, FITS, PICK
from skiros_py.world.view import WorldView

ROBOT, DOOR = Role("robot", "sk:Robot"), Role("door", "tiny:Door")
PART, KEY = Role("part", "sk:Manipulatable"), Role("key", "sk:Manipulatable")


def door_is(state: str) -> ConditionType:
    return ConditionType(f"Door{state.title()}", (DOOR,), Compare("tiny:opening", "=", "door", state), "-")


OPEN, AJAR, CLOSED = door_is("open"), door_is("ajar"), door_is("closed")
SCANNED = ConditionType("Scanned", (PART,), Compare("tiny:scanned", "=", "part", True), "Its code was read.", True)
CODED = ConditionType("Coded", (PART,), Has("tiny:scanned", "part"), "Somebody tried to read its code.")
CHARGED = ConditionType("Charged", (ROBOT,), Compare("tiny:charge", ">=", "robot", 20), "Enough for a task.")
FULL = ConditionType("Full", (ROBOT,), Compare("tiny:charge", "=", "robot", 100), "-")
OPENS = ConditionType("Opens", (KEY, DOOR), ClassRelated("tiny:madeFor", "key", "door"), "Keys like it open such.")
BEHIND = ConditionType("Behind", (PART, DOOR), Related("sk:on", "part", "door"), "It lies behind the door.")
RED = ConditionType("Red", (PART,), IsA("part", "tiny:RedBall"), "-")

_ROBOT, _DOOR = Param("Robot", "sk:Robot", "Who."), Param("Door", "tiny:Door", "Which.")
_PART, _KEY = Param("Part", "sk:Manipulatable", "What."), Param("Key", "sk:Manipulatable", "With what.")


def skill(name: str, *params: Param, pre: tuple[Condition, ...], post: tuple[Condition, ...]) -> SkillDescription:
    return SkillDescription(name, "-", "Robot", params[0].key, (_ROBOT, *params), pre, (), post)


UNLOCK = skill("unlock", _DOOR, _KEY, pre=(CLOSED("Door"), OPENS("Key", "Door")), post=(AJAR("Door"),))
PUSH = skill("push", _DOOR, pre=(~CLOSED("Door"), CHARGED("Robot")), post=(OPEN("Door"),))
SHUT = skill("shut", _DOOR, pre=(~CLOSED("Door"),), post=(CLOSED("Door"),))
SCAN = skill("scan", _PART, _DOOR, pre=(BEHIND("Part", "Door"), OPEN("Door")), post=(SCANNED("Part"),))
SKILLS = (UNLOCK, PUSH, SHUT, SCAN)

FACTS = (
    "scene:door_1 a tiny:Door ; sk:on scene:floor . scene:door_2 a tiny:Door ; sk:on scene:floor .",
    "scene:key_1 a tiny:Key ; sk:on scene:floor . scene:toy_key_1 a tiny:ToyKey ; sk:on scene:floor .",
    "scene:ball_2 a tiny:Ball ; sk:on scene:door_1 . scene:red_ball_2 a tiny:RedBall ; sk:on scene:door_2 .",
)
CHARGE = "scene:robot_1 tiny:charge 40.0 ."
WORLD = tiny_world(*FACTS, CHARGE)


def planned(view: WorldView, *goal: Condition, skills: Sequence[SkillDescription] = SKILLS) -> Planned:
    planner = FastDownward()
    able = [Capability(s, view.instances("sk:Robot")) for s in skills]
    try:
        return plan_for(planner, view, able, goal, options=PlanningOptions("doors"))
    finally:
        planner.close()


def steps_of(outcome: Plan | NoPlan) -> list[str]:
    assert isinstance(outcome, Plan), outcome
    return [step.skill for step in outcome.steps]


def why_not(view: WorldView, *goal: Condition, skills: Sequence[SkillDescription] = SKILLS) -> str:
    outcome = planned(view, *goal, skills=skills).outcome
    assert isinstance(outcome, NoPlan)
    return "; ".join(outcome.reasons)


def test_doors_are_opened_to_scan_what_is_behind_and_shut_again() -> None:
    outcome = planned(WORLD, SCANNED("ball_2"), CLOSED("door_1")).outcome

    assert steps_of(outcome) == ["unlock", "push", "scan", "shut"]
    assert isinstance(outcome, Plan)
    assert outcome.steps[0].arguments == {"Robot": "robot_1", "Door": "door_1", "Key": "key_1"}
    assert replay(WORLD, outcome.steps, [SCANNED("ball_2")], {s.name: s for s in SKILLS}) is None


def test_the_replay_finds_the_missing_precondition_of_a_step() -> None:
    scan = Step("scan", {"Robot": "robot_1", "Part": "ball_2", "Door": "door_1"})

    flaw = replay(WORLD, [scan], [], {"scan": SCAN})

    assert flaw is not None
    assert flaw.verdict.lines()[-1].strip() == "the opening of door_1 is 'closed', not 'open'"


def test_a_goal_of_a_class_and_a_negated_goal_are_planned() -> None:
    outcome = planned(WORLD, SCANNED("tiny:RedBall"), ~CLOSED("door_1")).outcome

    assert isinstance(outcome, Plan)
    assert [s.arguments["Part"] for s in outcome.steps if s.skill == "scan"] == ["red_ball_2"]
    assert {s.arguments["Door"] for s in outcome.steps if s.skill == "unlock"} == {"door_1", "door_2"}


def test_a_value_that_already_holds_needs_no_step() -> None:
    ajar = tiny_world(*FACTS, CHARGE, 'scene:door_1 tiny:opening "ajar" .')

    assert steps_of(planned(ajar, SCANNED("ball_2")).outcome) == ["push", "scan"]


@pytest.mark.parametrize(
    ("charge", "why"),
    [
        ("scene:robot_1 tiny:charge 5.0 .", "the charge of robot_1 is 5, not at least 20, and no skill changes it"),
        ("", "robot_1 has no charge, and no skill changes it"),
    ],
)
def test_a_battery_without_a_charging_skill_is_the_reason(charge: str, why: str) -> None:
    text = why_not(tiny_world(*FACTS, charge), OPEN("door_1"))

    assert text.endswith(f"skill 'push' would do it, but needs that the charge of a Robot is at least 20, and {why}")


def test_a_door_without_a_key_of_its_kind_is_the_reason() -> None:
    facts = (FACTS[0], FACTS[1].partition(".")[2], FACTS[2])

    text = why_not(tiny_world(*facts, CHARGE), AJAR("door_1"))

    assert "what is like a manipulatable" in text.lower()
    assert "made for what is like door_1" in text


def test_an_unreachable_goal_is_reported_with_the_present_state() -> None:
    assert why_not(WORLD, FULL("robot_1")) == (
        "Full(robot_1) cannot be reached: the charge of robot_1 is 40, not 100, and no skill changes it"
    )


@pytest.mark.parametrize("goal", [(SCANNED("ball_2"), CLOSED("door_1")), (SCANNED("tiny:RedBall"), ~CLOSED("door_1"))])
def test_an_external_validator_accepts_domain_and_plan(goal: tuple[Condition, ...], tmp_path: Path) -> None:
    result = planned(WORLD, *goal)
    assert isinstance(result.outcome, Plan)
    assert result.texts is not None
    (tmp_path / "domain.pddl").write_text(result.texts.domain)
    (tmp_path / "problem.pddl").write_text(result.texts.problem)
    (tmp_path / "plan").write_text("\n".join(map(result.texts.line, result.outcome.groundings)) + "\n")

    up.get_environment().credits_stream = None
    reader = PDDLReader()
    problem = reader.parse_problem(str(tmp_path / "domain.pddl"), str(tmp_path / "problem.pddl"))
    plan = reader.parse_plan(problem, str(tmp_path / "plan"))

    assert SequentialPlanValidator().validate(problem, plan).status is ValidationResultStatus.VALID


def test_an_effect_on_a_property_determines_all_comparisons_of_it() -> None:
    actions = {a.name: a for a in tiny_task(WORLD, AJAR("door_1"), OPEN("door_2"), skills=SKILLS).domain.actions}

    assert Atom('value tiny:opening = "open"', ("?Door",)) in actions["push"].add
    assert set(actions["push"].delete) == {
        Atom('value tiny:opening = "ajar"', ("?Door",)),
        Atom('value tiny:opening = "closed"', ("?Door",)),
    }
    assert Atom('not value tiny:opening = "closed"', ("?Door",)) in actions["push"].add
    assert Atom('not value tiny:opening = "closed"', ("?Door",)) in actions["shut"].delete


def test_properties_have_readable_names_in_pddl() -> None:
    planning = planned(WORLD, SCANNED("ball_2"))

    assert planning.texts is not None
    predicates = re.findall(r"^ {4}\(([\w-]+)", planning.texts.domain.partition("(:predicates")[2], flags=re.MULTILINE)
    assert {"opening_closed", "not_opening_closed", "charge_at_least_20", "class_made_for", "scanned_true"} <= set(
        predicates
    )


def test_a_removed_value_no_longer_holds() -> None:
    forget = skill("forget", _PART, pre=(CODED("Part"),), post=(~CODED("Part"),))
    world = tiny_world(*FACTS, CHARGE, "scene:ball_1 tiny:scanned true .")

    assert steps_of(planned(world, ~CODED("ball_1"), skills=(forget,)).outcome) == ["forget"]
    assert steps_of(planned(world, ~SCANNED("ball_1"), skills=(forget,)).outcome) == ["forget"]


def test_a_value_that_the_class_gives_anyway_cannot_be_taken_away() -> None:
    plain = ConditionType("Plain", (DOOR,), Not(Has("tiny:opening", "door")), "-")

    with pytest.raises(PlanningError, match=r"skill 'strip' takes away the tiny:opening of Door.*tiny:Door gives one"):
        actions_of(skill("strip", _DOOR, pre=(), post=(plain("Door"),)), tiny_ontology())


def test_negated_facts_that_no_skill_changes_are_evaluated_at_the_start() -> None:
    sort = skill("sort", _PART, pre=(~RED("Part"),), post=(SCANNED("Part"),))

    assert steps_of(planned(WORLD, SCANNED("ball_2"), skills=(sort,)).outcome) == ["sort"]
    assert why_not(WORLD, SCANNED("red_ball_2"), skills=(sort,)).endswith(
        "needs that it is not true that red_ball_2 is a RedBall, and red_ball_2 is a RedBall, and no skill changes it"
    )


def test_a_negated_computed_relation_holds_if_the_relation_does_not() -> None:
    world = tiny_world("scene:giant_1 a tiny:Giant ; sk:in scene:box_a .")
    balls, slots = Param("Ball", "tiny:Ball", "-"), Param("Slot", "tiny:Slot", "-")
    grow = skill("reject", balls, slots, pre=(~FITS("Ball", "Slot"),), post=(SCANNED("Ball"),))

    task = tiny_task(world, SCANNED("giant_1"), skills=(grow,))

    assert {a.arguments for a in task.problem.init if a.predicate == "not tiny:fitsIn"} == {
        ("giant_1", "slot_1"),
        ("giant_1", "slot_2"),
    }


def test_negations_of_any_and_all_are_pushed_inwards() -> None:
    either = AnyOf((Compare("tiny:opening", "=", "door", "open"), Compare("tiny:opening", "=", "door", "ajar")))
    neither = ConditionType("Neither", (DOOR,), Not(either), "-")
    not_both = ConditionType("NotBoth", (DOOR,), Not(AllOf(either.patterns)), "-")

    (one,) = actions_of(replace(PUSH, pre=(neither("Door"),)), tiny_ontology())
    two = actions_of(replace(PUSH, pre=(not_both("Door"),)), tiny_ontology())

    assert {a.predicate for a in one.pre} >= {'not value tiny:opening = "open"', 'not value tiny:opening = "ajar"'}
    assert len(two) == 2


GENTLE = ConditionType("Gentle", (Role("gripper", "sk:Gripper"),), Expression("gripper.force < 5.0"), "-")


def test_a_sensor_condition_is_refused_as_a_precondition_and_as_a_goal() -> None:
    words = r"'\w+.force < 5.0' can only be sensed"
    with pytest.raises(PlanningError, match=rf"skill 'pick', precondition Gentle\(Gripper\): {words}"):
        actions_of(replace(PICK, pre=(GENTLE("Gripper"),)), tiny_ontology())
    with pytest.raises(PlanningError, match=rf"skill 'pick', precondition not Gentle\(Gripper\): {words}"):
        actions_of(replace(PICK, pre=(~GENTLE("Gripper"),)), tiny_ontology())
    with pytest.raises(UsageError, match=rf"goal 'Gentle\(gripper_1\)': {words}"):
        tiny_task(WORLD, GENTLE("gripper_1"))


def test_a_sensed_hold_condition_is_left_to_the_run_and_the_action_says_so() -> None:
    gripper = Param("Gripper", "sk:Gripper", "-")
    gentle = replace(DRIVE, params=(*DRIVE.params, gripper), hold=(GENTLE("Gripper"),))
    drive = Step("drive", {"Base": "base_1", "Robot": "robot_1", "Location": "box_a", "Gripper": "gripper_1"})

    action = actions_of(gentle, tiny_ontology())[0]

    assert "hold condition Gentle(Gripper) left out: sensed while it runs, unknown to plans" in action.notes
    assert replay(WORLD, [drive], [], {"drive": gentle}) is None


# ------------------------------------------------- the same world, told twice: conditions on an overlay, and PDDL

FORGET = skill("forget", _PART, pre=(CODED("Part"),), post=(~CODED("Part"),))
DOUBT = skill("doubt", _PART, pre=(~CODED("Part"),), post=(~SCANNED("Part"),))
TOLD = (*SKILLS, FORGET, DOUBT)
TASK = tiny_task(WORLD, SCANNED("ball_2"), skills=TOLD)
_ids = {"Robot": ("robot_1",), "Door": ("door_1", "door_2"), "Key": ("key_1",), "Part": ("ball_2", "red_ball_2")}
any_step = st.one_of(
    [
        st.fixed_dictionaries({p.key: st.sampled_from(_ids[p.key]) for p in s.params}).map(
            lambda arguments, name=s.name: Step(name, arguments)
        )
        for s in TOLD
    ]
)


def pddl_flaw(plan: Sequence[Step]) -> bool:
    actions = {action.skill: action for action in TASK.domain.actions}
    state = set(TASK.problem.init)
    for step in plan:
        binding = {f"?{key}": value for key, value in step.arguments.items()}
        action = actions[step.skill]
        if not {atom.bind(binding) for atom in action.pre} <= state:
            return True
        state -= {atom.bind(binding) for atom in action.delete}
        state |= {atom.bind(binding) for atom in action.add}
    return False


@settings(max_examples=200, deadline=None)
@given(st.lists(any_step, max_size=6))
def test_replay_and_pddl_agree_on_what_properties_do(plan: list[Step]) -> None:
    assert (replay(WORLD, plan, [], {s.name: s for s in TOLD}) is not None) == pddl_flaw(plan)


@settings(max_examples=100, deadline=None)
@given(st.permutations(["unlock", "push", "scan", "shut", "forget", "doubt"]), st.integers(1, 6))
def test_replay_and_pddl_agree_on_the_skills_of_one_door_in_any_order(names: list[str], count: int) -> None:
    mine = {"Robot": "robot_1", "Door": "door_1", "Key": "key_1", "Part": "ball_2"}
    params = {s.name: [p.key for p in s.params] for s in TOLD}
    plan = [Step(name, {key: mine[key] for key in params[name]}) for name in names[:count]]

    assert (replay(WORLD, plan, [], {s.name: s for s in TOLD}) is not None) == pddl_flaw(plan)


def test_a_class_that_a_precondition_asks_for_becomes_that_of_the_parameter() -> None:
    red = skill("paint", _PART, _DOOR, pre=(RED("Part"), BEHIND("Part", "Door")), post=(SCANNED("Part"),))

    (action,) = actions_of(red, tiny_ontology())

    assert [v.type for v in action.parameters if v.name == "?Part"] == ["tiny:RedBall"]
    assert [atom.predicate for atom in action.pre] == ["can_paint", "sk:on"]
    assert steps_of(planned(WORLD, SCANNED("red_ball_2"), skills=[red]).outcome) == ["paint"]
    assert "not a RedBall" in why_not(WORLD, SCANNED("ball_2"), skills=[red])
