from __future__ import annotations

from dataclasses import replace

from support.planning import tiny_task

from skiros_py.planning.explanation.explaining import explain
from skiros_py.planning.plan import CauseKind
from skiros_py.skills.conditions import Condition
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, EMPTY_HANDED, HAS_PART, HOLDING, IN_CONTAINER, PICK, PLACE

CAREFUL = replace(
    DRIVE,
    params=(
        *DRIVE.params,
        Param("Arm", "sk:Arm", "Its arm.", Kind.HARDWARE),
        Param("Gripper", "sk:Gripper", "What must be empty.", Kind.HARDWARE),
    ),
    pre=(*DRIVE.pre, HAS_PART("Robot", "Arm"), HAS_PART("Arm", "Gripper"), EMPTY_HANDED("Gripper")),
)
HELD, ELSEWHERE = HOLDING("gripper_1", "ball_1"), AT_LOCATION("robot_1", "box_b")


def blamed(*goal: Condition, drive: SkillDescription = CAREFUL) -> set[Condition]:
    world = tiny_world()
    (cause,) = explain(tiny_task(world, *goal, skills=(drive, PICK, PLACE))).causes
    assert cause.kind is CauseKind.CONFLICT
    return set(cause.conditions)


def test_the_two_incompatible_conditions_of_a_long_goal_are_named() -> None:
    assert blamed(IN_CONTAINER("red_ball_1", "slot_1"), HELD, ELSEWHERE) == {HELD, ELSEWHERE}


def test_compatible_conditions_are_not_blamed() -> None:
    goal = IN_CONTAINER("red_ball_1", "slot_1"), HELD, ELSEWHERE

    assert blamed(*goal, drive=DRIVE) == set(goal)  # there is a plan: no pair is found that excludes itself
