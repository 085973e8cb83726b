from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.errors import DescriptionError, WorldError
from skiros_py.skills.conditions import (
    AllOf,
    Compare,
    Condition,
    ConditionType,
    Expression,
    Has,
    Not,
    Pattern,
    Related,
    Role,
    any_of,
)
from skiros_py.skills.conditions.effects import (
    Assign,
    Effect,
    Relate,
    Unrelate,
    effects_of,
    suppose_effects,
    write_effects,
)
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, CARRIES, EMPTY_HANDED, FITS, HOLDING, IN_CONTAINER
from skiros_py.world.overlay import Overlay
from skiros_py.world.world import World

DOOR = 'scene:door_1 a tiny:Door ; tiny:opening "ajar" ; sk:on scene:floor .'


def saying(pattern: Pattern, class_: str = "tiny:Ball") -> Condition:
    return ConditionType("Word", (Role("it", class_),), pattern, "-")("it")


OPEN = Compare("tiny:opening", "=", "it", "open")
SCANNED = Compare("tiny:scanned", "=", "it", True)


@pytest.mark.parametrize(
    ("condition", "effects"),
    [
        (HOLDING("g", "b"), (Relate("sk:heldBy", "b", "g"),)),
        (~HOLDING("g", "b"), (Unrelate("sk:heldBy", "b", "g"),)),
        (saying(OPEN), (Assign("tiny:opening", "it", "open"),)),
        (saying(SCANNED), (Assign("tiny:scanned", "it", True),)),
        (~saying(SCANNED), (Assign("tiny:scanned", "it", False),)),
        (saying(Compare("tiny:scanned", "!=", "it", False)), (Assign("tiny:scanned", "it", True),)),
        (saying(Not(Has("tiny:opening", "it"))), (Assign("tiny:opening", "it", None),)),
        (~saying(Has("tiny:opening", "it")), (Assign("tiny:opening", "it", None),)),
        (~saying(Not(OPEN)), (Assign("tiny:opening", "it", "open"),)),
        (
            saying(AllOf((OPEN, SCANNED))),
            (Assign("tiny:opening", "it", "open"), Assign("tiny:scanned", "it", True)),
        ),
        (EMPTY_HANDED("g"), ()),
        (~EMPTY_HANDED("g"), ()),
    ],
)
def test_each_achievable_condition_has_its_effects(condition: Condition, effects: tuple[Effect, ...]) -> None:
    assert effects_of(condition) == effects


@pytest.mark.parametrize(
    "condition",
    [
        saying(Has("tiny:opening", "it")),
        saying(Compare("tiny:charge", ">=", "it", 3)),
        ~saying(OPEN),
        FITS("b", "s"),
        saying(Expression("it.gap = 1")),
        any_of(HOLDING("g", "b"), CARRIES("r", "b")),
    ],
)
def test_an_unachievable_condition_is_refused_as_an_effect_by_name(condition: Condition) -> None:
    with pytest.raises(DescriptionError) as caught:
        effects_of(condition)

    assert str(caught.value).startswith(f"{condition} cannot be brought about: a skill can")


def write(world: World, *effects: Effect) -> None:
    with world.transaction("test", "effects") as tx:
        write_effects(tx, world.ontology, effects)


def test_written_effects_hold_in_the_world() -> None:
    world = tiny_world(DOOR)

    write(
        world,
        Relate("sk:heldBy", "ball_1", "gripper_1"),
        Relate("tiny:carries", "robot_1", "red_ball_1"),
        Relate("tiny:knows", "robot_1", "box_a"),
        Assign("tiny:opening", "door_1", None),
    )

    assert world.related("ball_1", "sk:heldBy", "gripper_1")
    assert world.related("robot_1", "tiny:carries", "red_ball_1")
    assert world.related("robot_1", "tiny:knows", "box_a")
    assert world.value("door_1", "tiny:opening") == "closed", "that of its class"


def test_removing_a_relation_that_does_not_hold_changes_nothing() -> None:
    world = tiny_world()
    before = world.version

    write(world, Unrelate("tiny:knows", "robot_1", "box_a"), Unrelate("sk:in", "ball_1", "box_a"))

    assert world.version == before
    assert world.related("ball_1", "sk:in", "box_a"), "everything is somewhere: it ends by another place"


def test_an_effect_on_a_missing_element_is_refused_by_the_world() -> None:
    for effect in (Unrelate("tiny:knows", "robot_9", "box_a"), Assign("tiny:opening", "door_9", "open")):
        with pytest.raises(WorldError, match="_9"):
            write(tiny_world(), effect)


BALLS, PLACES = st.sampled_from(["ball_1", "red_ball_1"]), st.sampled_from(["box_a", "slot_1", "slot_2"])
achievable = st.one_of(
    st.builds(IN_CONTAINER, BALLS, PLACES),
    st.builds(HOLDING, st.just("gripper_1"), BALLS),
    st.builds(CARRIES, st.just("robot_1"), BALLS),
    st.builds(AT_LOCATION, st.just("robot_1"), PLACES),
    st.builds(
        lambda pattern, ball: Condition(ConditionType("Word", (Role("it", "tiny:Ball"),), pattern, "-"), (ball,)),
        st.sampled_from([SCANNED, Not(SCANNED), Not(Has("tiny:scanned", "it")), Compare("sk:mass", "=", "it", 2)]),
        BALLS,
    ),
)


@settings(max_examples=60, deadline=None)
@given(st.lists(achievable, min_size=1, max_size=5))
def test_the_last_effect_wins_in_the_world_and_on_an_overlay(conditions: list[Condition]) -> None:
    world = tiny_world()
    overlay = Overlay(world.snapshot())

    for condition in conditions:
        suppose_effects(overlay, effects_of(condition))
        write(world, *effects_of(condition))
        assert condition.evaluate(overlay)
        assert condition.evaluate(world)
    for condition in conditions:
        assert condition.evaluate(overlay).holds == condition.evaluate(world).holds


def test_the_key_of_a_condition_is_its_text_or_its_given_name() -> None:
    holding = HOLDING("Gripper", "Ball")

    assert holding.key == "Holding(Gripper, Ball)"
    assert holding.named("held").key == "held"
    assert holding.named("held").bind({"Ball": "ball_1"}).key == "held"
    assert holding.named("held") == holding, "it says the same"
    assert (~holding.named("held")).key == "not Holding(Gripper, Ball)", "which is something else"
    with pytest.raises(DescriptionError, match="must not be empty"):
        holding.named(" ")


def test_a_doubly_negated_relation_has_the_effect_of_the_relation() -> None:
    assert effects_of(saying(Not(Not(Related("tiny:knows", "it", "it"))))) == (Relate("tiny:knows", "it", "it"),)
