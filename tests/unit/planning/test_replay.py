from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.planning import tiny_task

from skiros_py.planning.plan import Step
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.replay import apply_effects, replay
from skiros_py.skills.parameters import Param
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, CARRIES, DRIVE, EMPTY_HANDED, IN_CONTAINER, PICK, PLACE
from skiros_py.world.overlay import Overlay

SKILLS = {skill.name: skill for skill in (DRIVE, PICK, PLACE)}
GOAL = IN_CONTAINER("ball_1", "slot_1")
HAND = {"Arm": "arm_1", "Gripper": "gripper_1", "Robot": "robot_1"}
DRIVE_A = Step("drive", {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"})
PICK_1 = Step("pick", {**HAND, "Box": "box_a", "Ball": "ball_1"})
PLACE_1 = Step("place", {**HAND, "Ball": "ball_1", "Slot": "slot_1"})
WORLD = tiny_world("scene:giant_1 a tiny:Giant ; sk:in scene:slot_2 .", robots=2)
TASK = tiny_task(WORLD, GOAL)


def test_a_correct_plan_has_no_flaw_and_does_not_change_the_world() -> None:
    before = WORLD.version

    assert replay(WORLD, [DRIVE_A, PICK_1, PLACE_1], [GOAL], SKILLS) is None
    assert WORLD.version == before
    assert not GOAL.evaluate(WORLD)


@pytest.mark.parametrize(
    ("steps", "index", "text"),
    [
        ([PICK_1, PLACE_1], 0, "At(robot_1, box_a)"),
        ([DRIVE_A, PLACE_1], 1, "Holding(gripper_1, ball_1)"),
        ([DRIVE_A, PICK_1, PICK_1], 2, "In(ball_1, box_a)"),
        ([DRIVE_A, PICK_1], None, "In(ball_1, slot_1)"),
        ([], None, "In(ball_1, slot_1)"),
    ],
)
def test_a_wrong_plan_is_caught_at_its_first_flaw(steps: list[Step], index: int | None, text: str) -> None:
    flaw = replay(WORLD, steps, [GOAL], SKILLS)

    assert flaw is not None
    assert (flaw.step, flaw.verdict.text) == (index, text)


def test_a_full_slot_is_a_flaw() -> None:
    flaw = replay(
        WORLD, [DRIVE_A, PICK_1, replace(PLACE_1, arguments={**PLACE_1.arguments, "Slot": "slot_2"})], [], SKILLS
    )

    assert flaw is not None
    assert flaw.verdict.lines()[-1].strip() == "giant_1 in slot_2"


def test_a_postcondition_that_does_not_follow_is_a_flaw() -> None:
    here, there = AT_LOCATION("Robot", "Location"), AT_LOCATION("Robot", "Other")
    params = (*DRIVE.params, Param("Other", "sk:Location", "Another place."))
    drive = Step("drive", {**DRIVE_A.arguments, "Other": "box_b"})

    for post in ((here, there), (there, here)):
        both = replace(DRIVE, params=params, pre=(), post=post)
        assert replay(WORLD, [drive], [], {"drive": both}) is not None


def test_a_hold_condition_that_does_not_hold_at_the_start_is_a_flaw() -> None:
    gripper = Param("Gripper", "sk:Gripper", "What it must not carry.")
    careful = replace(DRIVE, params=(*DRIVE.params, gripper), hold=(EMPTY_HANDED("Gripper"),))
    drive = Step("drive", {**DRIVE_A.arguments, "Gripper": "gripper_1"})
    full = Overlay(WORLD)
    full.place("ball_1", "sk:heldBy", "gripper_1")

    flaw = replay(full, [drive], [], {"drive": careful})

    assert replay(WORLD, [drive], [], {"drive": careful}) is None
    assert flaw is not None
    assert (flaw.step, flaw.verdict.text) == (0, "EmptyHanded(gripper_1)")


def test_driving_to_the_current_place_changes_nothing() -> None:
    there = Overlay(WORLD)
    apply_effects(there, DRIVE.post, DRIVE_A.arguments)
    apply_effects(there, DRIVE.post, DRIVE_A.arguments)

    assert there.subjects("sk:at", "box_a") == ("robot_1",)
    assert replay(there, [DRIVE_A, PICK_1, PLACE_1], [GOAL], SKILLS) is None


def test_effects_move_the_load_of_a_subject_place() -> None:
    overlay = Overlay(WORLD)

    apply_effects(overlay, (CARRIES("Robot", "Ball"),), {"Robot": "robot_2", "Ball": "ball_1"})

    assert overlay.subjects("tiny:carries", "ball_1") == ("robot_2",)
    assert overlay.subjects("sk:in", "box_a") == ()


# ------------------------------------------------- the same world, told twice: conditions on an overlay, and PDDL

_ids = {
    skill.name: [[o for o, t in TASK.problem.objects.items() if WORLD.ontology.is_a(t, p.type)] for p in skill.params]
    for skill in SKILLS.values()
}
steps = st.one_of(
    [
        st.tuples(*(st.sampled_from(ids) for ids in _ids[name])).map(
            lambda chosen, skill=skill: Step(skill.name, dict(zip([p.key for p in skill.params], chosen, strict=True)))
        )
        for name, skill in SKILLS.items()
    ]
)


def pddl_run(task: PlanningTask, plan: list[Step]) -> bool:
    """A naive twin of every planner: sets of atoms, applied by the book."""
    actions = {action.skill: action for action in task.domain.actions}
    state = set(task.problem.init)
    for step in plan:
        action = actions[step.skill]
        binding = {f"?{key}": value for key, value in step.arguments.items()}
        if step.skill == "drive":
            places = [
                a.arguments[1] for a in state if a.predicate == "sk:at" and a.arguments[0] == step.arguments["Robot"]
            ]
            binding["?Robot_from"] = places[0]
        if not {atom.bind(binding) for atom in action.pre if not atom.predicate.startswith("can_")} <= state:
            return False
        state -= {atom.bind(binding) for atom in action.delete}
        state |= {atom.bind(binding) for atom in action.add}
    return True


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(steps, max_size=5))
def test_replay_and_pddl_agree_on_every_plan(plan: list[Step]) -> None:
    assert (replay(WORLD, plan, [], SKILLS) is None) == pddl_run(TASK, plan)


@settings(max_examples=100, deadline=None)
@given(st.sampled_from(["ball_1", "red_ball_1"]), st.sampled_from(["slot_1", "slot_2"]), st.integers(0, 3))
def test_replay_and_pddl_agree_on_plans_that_nearly_work(ball: str, slot: str, missing: int) -> None:
    box = "box_a" if ball == "ball_1" else "box_b"
    plan = [
        Step("drive", {**DRIVE_A.arguments, "Location": box}),
        Step("pick", {**PICK_1.arguments, "Box": box, "Ball": ball}),
        Step("place", {**PLACE_1.arguments, "Ball": ball, "Slot": slot}),
    ]
    plan = plan[:missing] + plan[missing + 1 :]

    assert (replay(WORLD, plan, [], SKILLS) is None) == pddl_run(TASK, plan)
