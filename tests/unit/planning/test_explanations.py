from __future__ import annotations

from dataclasses import replace

import pytest

from skiros_py.planning.explanation import explain
from skiros_py.skills.conditions import Condition
from skiros_py.skills.parameters import Param
from skiros_py.testing import tiny_task, tiny_world
from skiros_py.testing.tiny_skills import AT_LOCATION, DRIVE, FREE, HOLDING, IN_CONTAINER, REACHABLE
from skiros_py.world.world import World

GIANT = "scene:giant_1 a tiny:Giant ; sk:in scene:box_a ."


def reasons(world: World, *goal: Condition, agents: tuple[str, ...] | None = None) -> tuple[str, ...]:
    return explain(tiny_task(world, *goal, agents=agents), world)


def lost() -> World:
    world = tiny_world()
    with world.transaction("test", "dropped") as tx:
        tx.place("ball_1", "sk:on", "unknown_location")
    return world


@pytest.mark.parametrize(
    ("world", "goal", "agents", "reason"),
    [
        pytest.param(
            tiny_world(GIANT),
            IN_CONTAINER("giant_1", "slot_1"),
            None,
            "In(giant_1, slot_1) cannot be reached: skill 'place' would do it, but needs that giant_1 fits in slot_1",
            id="the part does not fit",
        ),
        pytest.param(
            tiny_world(),
            IN_CONTAINER("ball_1", "slot_1"),
            ("base_1",),
            "In(ball_1, slot_1) cannot be reached: skill 'place' would do it, but needs that an Arm has the "
            "skill 'place'",
            id="the robot lacks the skill",
        ),
        pytest.param(
            tiny_world("scene:ball_9 a tiny:Ball ; sk:in scene:slot_1 ."),
            IN_CONTAINER("ball_1", "slot_1"),
            None,
            "In(ball_1, slot_1) cannot be reached: skill 'place' would do it, but needs that nothing is in slot_1, "
            "and ball_9 is in slot_1",
            id="the slot is full",
        ),
        pytest.param(
            tiny_world(),
            AT_LOCATION("robot_1", "floor"),
            None,
            "At(robot_1, floor) cannot be reached: skill 'drive' would do it, but needs that floor has a driving pose",
            id="nobody taught where to stand",
        ),
        pytest.param(
            tiny_world(),
            IN_CONTAINER("ball_1", "box_b"),
            None,
            "In(ball_1, box_b) cannot be reached: box_b is not a Slot, which skill 'place' needs",
            id="the place is of the wrong class",
        ),
        pytest.param(
            tiny_world(),
            IN_CONTAINER("tiny:Giant", "slot_1"),
            None,
            "In(Giant, slot_1) cannot be reached: there is no Giant",
            id="there is none of the class",
        ),
    ],
)
def test_the_reason_names_skill_and_obstacle(
    world: World, goal: Condition, agents: tuple[str, ...] | None, reason: str
) -> None:
    (given_reason,) = reasons(world, goal, agents=agents)

    assert given_reason.startswith(reason)


def test_a_part_at_an_unknown_place_is_blamed_on_where_it_is() -> None:
    (reason,) = reasons(lost(), IN_CONTAINER("ball_1", "slot_1"))

    assert "needs that ball_1 is held by a Gripper" in reason
    assert "skill 'pick' would do it, but needs that ball_1 is in a Box" in reason


def test_only_conditions_that_can_never_hold_are_explained() -> None:
    found = reasons(tiny_world(GIANT), IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("giant_1", "slot_2"))

    assert [reason.partition(" cannot")[0] for reason in found] == ["In(giant_1, slot_2)"]


def test_conditions_that_exclude_each_other_only_have_no_reason_each() -> None:
    assert reasons(tiny_world(), IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("ball_1", "slot_2")) == ()


def test_what_holds_already_needs_no_explanation() -> None:
    assert reasons(tiny_world(), FREE("slot_1"), HOLDING("gripper_1", "ball_1")) == ()


def test_a_property_that_nothing_has_is_said_of_the_class() -> None:
    skill = replace(DRIVE, params=(*DRIVE.params, Param("Slot", "tiny:Slot", "A slot.")), pre=(REACHABLE("Slot"),))
    goal = AT_LOCATION("robot_1", "box_a")

    (reason,) = explain(tiny_task(tiny_world(), goal, skills=(skill,)), tiny_world())

    assert reason.endswith("needs that a Slot has a driving pose, and no Slot has a driving pose")


def test_a_skill_that_needs_what_it_is_wanted_for_is_told_once() -> None:
    goal = AT_LOCATION("robot_1", "box_a")
    skill = replace(DRIVE, pre=(*DRIVE.pre, AT_LOCATION("Robot", "Location")))

    (reason,) = explain(tiny_task(tiny_world(), goal, skills=(skill,)), tiny_world())

    assert reason.count("skill 'drive'") == 1
