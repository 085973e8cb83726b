from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.errors import DescriptionError, WorldError
from skiros_py.skills.conditions import (
    AllOf,
    Compare,
    Condition,
    ConditionType,
    Decrease,
    Expression,
    Has,
    Increase,
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
        (saying(Compare("tiny:charge", ">=", "it", 8)), (Assign("tiny:charge", "it", 8, ">="),)),
        (saying(Compare("tiny:charge", "<", "it", 8)), (Assign("tiny:charge", "it", math.nextafter(8, 0), "<="),)),
        (~saying(Compare("tiny:charge", "<", "it", 8)), (Assign("tiny:charge", "it", 8, ">="),)),
        (saying(Increase("tiny:charge", "it", 30.0)), (Increase("tiny:charge", "it", 30.0),)),
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
        ~saying(Compare("tiny:charge", "=", "it", 3)),
        ~saying(Decrease("tiny:charge", "it", 3.0)),
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


@pytest.mark.parametrize("by", [0.0, -3.0, math.nan, math.inf, True])
def test_a_change_by_no_number_above_zero_is_refused(by: float) -> None:
    with pytest.raises(DescriptionError, match=r"decrease tiny:charge by .*: give a number above 0, or a property"):
        Decrease("tiny:charge", "it", by)


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


CHARGED = "scene:robot_1 tiny:charge 40.0 ."
AT_LEAST_8 = ConditionType("Enough", (Role("it", "sk:Robot"),), Compare("tiny:charge", ">=", "it", 8), "-")
ENOUGH = AT_LEAST_8("robot_1")


def test_a_written_inequality_leaves_a_number_that_meets_it_and_else_becomes_its_limit() -> None:
    for charge, kept in ((40.0, 40.0), (5.0, 8)):
        world = tiny_world(f"scene:robot_1 tiny:charge {charge} .")

        write(world, *effects_of(ENOUGH))

        assert world.value("robot_1", "tiny:charge") == kept
        assert ENOUGH.evaluate(world)


def test_more_than_eight_are_nine_where_a_number_is_whole() -> None:
    world = tiny_world("scene:box_a sk:sequenceNumber 2 .")
    more = ConditionType("More", (Role("it", "tiny:Box"),), Compare("sk:sequenceNumber", ">", "it", 8), "-")("box_a")
    overlay = Overlay(world.snapshot())

    suppose_effects(overlay, effects_of(more))
    write(world, *effects_of(more))

    assert [view.value("box_a", "sk:sequenceNumber") for view in (overlay, world)] == [9, 9]
    assert more.evaluate(world)


def test_plans_count_with_the_limit_of_an_inequality_since_no_more_is_promised() -> None:
    overlay = Overlay(tiny_world(CHARGED).snapshot())

    suppose_effects(overlay, effects_of(ENOUGH))

    assert overlay.value("robot_1", "tiny:charge") == 8


def test_numbers_grow_and_fall_by_an_amount_or_by_the_property_of_another_element() -> None:
    world = tiny_world(CHARGED, "scene:box_a sk:mass 12.5 .")

    write(world, Increase("tiny:charge", "robot_1", 30), Decrease("tiny:charge", "robot_1", "sk:mass", "box_a"))

    assert world.value("robot_1", "tiny:charge") == 57.5


def test_ten_times_a_tenth_is_one() -> None:
    world = tiny_world("scene:robot_1 tiny:charge 1.0 .")

    write(world, *[Decrease("tiny:charge", "robot_1", 0.1)] * 10)

    assert world.value("robot_1", "tiny:charge") == 0.0


def test_a_missing_number_or_amount_changes_nothing_and_the_postcondition_says_so() -> None:
    roles = (Role("robot", "sk:Robot"), Role("source", "tiny:Box"))
    word = ConditionType("Fed", roles, Increase("tiny:charge", "robot", "sk:mass", "source"), "-")
    for facts, why in ((CHARGED, "box_a has no number for its mass"), ("", "robot_1 has no number for its charge")):
        world = tiny_world(facts)
        before = world.version

        write(world, *effects_of(word("robot_1", "box_a")))

        assert world.version == before
        assert word("robot_1", "box_a").evaluate(world).why == why


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
