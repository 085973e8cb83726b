from __future__ import annotations

from dataclasses import replace

import pytest
from support.planning import tiny_task

from skiros_py.planning.explanation.causes import find_causes
from skiros_py.planning.explanation.explaining import explain
from skiros_py.planning.plan import CauseKind
from skiros_py.skills.conditions import Condition
from skiros_py.skills.parameters import Param
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, FREE, HOLDING, IN_CONTAINER, REACHABLE
from skiros_py.world.world import World

GIANT = "scene:giant_1 a tiny:Giant ; sk:in scene:box_a ."
PARTS = [f"scene:part_{n} a tiny:Ball ; sk:in scene:box_a ." for n in range(60)]


def reasons(world: World, *goal: Condition, agents: tuple[str, ...] | None = None) -> tuple[str, ...]:
    return tuple(found.cause.text for found in find_causes(tiny_task(world, *goal, agents=agents)))


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
            "In(ball_1, slot_1) cannot be reached: skill 'place' would do it, but arm_1 does not have it",
            id="the robot lacks the skill",
        ),
        pytest.param(
            tiny_world("scene:ball_9 a tiny:Ball ; sk:in scene:slot_1 ."),
            IN_CONTAINER("ball_1", "slot_1"),
            None,
            "In(ball_1, slot_1) cannot be reached: skill 'place' would do it, but needs that nothing is in slot_1, "
            "and ball_9 is in slot_1, and no skill takes it away",
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
            REACHABLE("floor"),
            None,
            "Reachable(floor) cannot be reached: floor has no driving pose, and no skill changes it",
            id="nobody taught where to stand, and nothing else is wanted",
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
def test_the_reason_names_the_skill_and_the_obstacle(
    world: World, goal: Condition, agents: tuple[str, ...] | None, reason: str
) -> None:
    (given_reason,) = reasons(world, goal, agents=agents)

    assert given_reason.startswith(reason)


def test_a_part_at_an_unknown_place_is_explained_by_its_place() -> None:
    (reason,) = reasons(lost(), IN_CONTAINER("ball_1", "slot_1"))

    assert "needs that ball_1 is held by gripper_1" in reason
    assert "skill 'pick' would do it, but needs that ball_1 is in a Box" in reason


def test_a_cause_contains_the_skill_and_its_unreachable_precondition_as_data() -> None:
    world = lost()

    (found,) = find_causes(tiny_task(world, IN_CONTAINER("ball_1", "slot_1")))

    assert found.cause.kind is CauseKind.MISSING_FACT
    assert (found.cause.skill, found.cause.precondition) == ("pick", "ball_1 is in a Box")
    assert found.cause.elements == ("ball_1", "unknown_location")
    assert found.cause.conditions == (IN_CONTAINER("ball_1", "slot_1"),)


def test_only_conditions_that_can_never_hold_are_explained() -> None:
    found = reasons(tiny_world(GIANT), IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("giant_1", "slot_2"))

    assert [reason.partition(" cannot")[0] for reason in found] == ["In(giant_1, slot_2)"]


def test_a_condition_that_already_holds_needs_no_explanation() -> None:
    assert reasons(tiny_world(), FREE("slot_1"), HOLDING("gripper_1", "ball_1")) == ()


def test_a_property_that_no_element_has_is_reported_for_the_class() -> None:
    skill = replace(DRIVE, params=(*DRIVE.params, Param("Slot", "tiny:Slot", "A slot.")), pre=(REACHABLE("Slot"),))
    world = tiny_world()

    (found,) = find_causes(tiny_task(world, AT_LOCATION("robot_1", "box_a"), skills=(skill,)))

    assert "needs that a Slot has a driving pose, and no Slot has a driving pose" in found.cause.text


def test_a_skill_that_needs_its_own_effect_is_named_once() -> None:
    skill = replace(DRIVE, pre=(*DRIVE.pre, AT_LOCATION("Robot", "Location")))
    world = tiny_world()

    (found,) = find_causes(tiny_task(world, AT_LOCATION("robot_1", "box_a"), skills=(skill,)))

    assert found.cause.text.count("skill 'drive'") == 1


def test_of_two_robots_the_one_that_lacks_the_skill_is_named() -> None:
    world = tiny_world(robots=2)

    (found,) = find_causes(tiny_task(world, AT_LOCATION("robot_2", "box_a"), agents=("base_1",)))

    assert found.cause.kind is CauseKind.NO_SKILL
    assert (found.cause.skill, found.cause.elements) == ("drive", ("base_2",))


def test_many_like_things_do_not_change_the_cause() -> None:
    stray = "scene:ball_9 a tiny:Ball ; sk:in scene:slot_1 ."
    few, many = tiny_world(stray), tiny_world(stray, *PARTS)
    goal = IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("tiny:Ball", "slot_2")

    assert reasons(few, *goal) == reasons(many, *goal) != ()


@pytest.mark.parametrize(
    ("goal", "kind", "elements"),
    [
        (["In(ball_1, slot_1)", "In(ball_1, slot_2)"], CauseKind.CONTRADICTION, {"ball_1", "slot_1", "slot_2"}),
        (["In(ball_1, slot_1)", "Holding(gripper_1, ball_1)"], CauseKind.CONTRADICTION, {"ball_1", "gripper_1"}),
        (["In(ball_1, slot_1)", "In(red_ball_1, slot_1)"], CauseKind.CONTRADICTION, {"slot_1"}),
        (["In(ball_1, slot_1)", "Free(slot_1)"], CauseKind.CONTRADICTION, {"slot_1", "ball_1"}),
        (["In(RedBall, slot_1)", "In(RedBall, slot_2)"], CauseKind.TOO_FEW, {"tiny:RedBall", "red_ball_1"}),
        (["In(red_ball_1, slot_1)", "In(RedBall, slot_2)"], CauseKind.TOO_FEW, {"red_ball_1"}),
    ],
)
def test_mutually_exclusive_conditions_are_named_with_their_subject(
    goal: list[str], kind: CauseKind, elements: set[str]
) -> None:
    from skiros_py.tasks.goals import parse_goal
    from skiros_py.testing import CONDITIONS

    world = tiny_world()
    conditions = parse_goal(goal, world, CONDITIONS)

    (found,) = find_causes(tiny_task(world, *conditions))

    assert found.cause.kind is kind
    assert elements <= set(found.cause.elements)
    assert set(found.cause.conditions) == set(conditions)


def test_a_condition_that_undoes_its_own_requirement_is_explained_as_such() -> None:
    """Nothing here finds out why: the explanation says no more than it knows."""
    world = tiny_world()

    found = explain(tiny_task(world, IN_CONTAINER("ball_1", "slot_1")))

    assert [cause.kind for cause in found.causes] == [CauseKind.CONFLICT]
    assert "whatever is done for it undoes something else that it needs" in found.reasons[0]
