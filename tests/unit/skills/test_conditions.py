from __future__ import annotations

import pytest

from skiros_py.errors import DescriptionError, UnknownName
from skiros_py.skills.conditions import (
    AllOf,
    Computed,
    Condition,
    ConditionType,
    Exists,
    Has,
    Not,
    Nothing,
    Related,
    Role,
    any_of,
)
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import (
    AT_LOCATION,
    CARRIES,
    EMPTY_HANDED,
    FITS,
    FREE,
    HOLDING,
    IN_CONTAINER,
    REACHABLE,
)
from skiros_py.world.overlay import Overlay
from skiros_py.world.world import World

STORED = ConditionType(
    "Stored",
    (Role("ball", "tiny:Ball"), Role("where", "sk:Location")),
    Exists("box", "tiny:Box", AllOf((Related("sk:in", "ball", "box"), Related("sk:on", "box", "where")))),
    "The ball lies in some box that stands there.",
)


def says(condition: Condition, *facts: str) -> list[str]:
    return condition.evaluate(tiny_world(*facts)).lines()


def test_a_condition_that_holds_names_the_supporting_facts() -> None:
    assert says(IN_CONTAINER("ball_1", "box_a")) == ["In(ball_1, box_a) (holds)", "  ball_1 in box_a"]


def test_a_condition_that_fails_names_the_actual_facts() -> None:
    assert says(IN_CONTAINER("ball_1", "box_b")) == [
        "In(ball_1, box_b) (does not hold)",
        "  ball_1 is not in box_b: it is in box_a",
    ]


def test_a_failed_emptiness_condition_names_the_content() -> None:
    verdict = FREE("slot_1").evaluate(tiny_world("scene:ball_9 a tiny:Ball ; sk:in scene:slot_1 ."))

    assert not verdict
    assert verdict.lines()[-1].strip() == "ball_9 in slot_1"


def test_a_missing_property_is_named_and_class_values_count() -> None:
    assert says(REACHABLE("box_a")) == ["Reachable(box_a) (holds)", "  box_a has a drivingPose"]
    assert says(REACHABLE("floor")) == ["Reachable(floor) (does not hold)", "  floor has no drivingPose"]


@pytest.mark.parametrize(
    "condition",
    [
        IN_CONTAINER("ball_1", "box_a"),
        IN_CONTAINER("ball_1", "box_b"),
        EMPTY_HANDED("gripper_1"),
        REACHABLE("floor"),
        FITS("ball_1", "slot_1"),
        STORED("ball_1", "floor"),
        any_of(HOLDING("gripper_1", "ball_1"), CARRIES("robot_1", "ball_1")),
    ],
    ids=str,
)
def test_a_negated_condition_over_elements_holds_exactly_when_the_plain_one_does_not(condition: Condition) -> None:
    world = tiny_world()

    assert bool((~condition).evaluate(world)) is not bool(condition.evaluate(world))
    assert ~~condition == condition


def test_a_negated_condition_that_fails_names_the_contradicting_fact() -> None:
    assert says(~IN_CONTAINER("ball_1", "box_a")) == ["not In(ball_1, box_a) (does not hold)", "  ball_1 in box_a"]


def test_an_existential_names_its_witness() -> None:
    assert says(STORED("red_ball_1", "floor"))[1].strip() == "box_b is the Box (holds)"


def test_an_existential_without_a_witness_names_the_class_it_searched() -> None:
    assert says(STORED("ball_1", "slot_1"))[1].strip() == "no Box makes it true for ball_1, slot_1"


def test_a_class_as_argument_means_some_element_of_it() -> None:
    world = tiny_world()

    assert IN_CONTAINER("tiny:RedBall", "box_b").evaluate(world)
    assert not IN_CONTAINER("tiny:RedBall", "box_a").evaluate(world)
    assert IN_CONTAINER("tiny:Ball", "box_b").evaluate(world), "a subclass counts"
    assert not IN_CONTAINER("tiny:Giant", "box_a").evaluate(world), "there is none at all"


def test_a_class_is_written_without_its_prefix() -> None:
    assert str(IN_CONTAINER("tiny:RedBall", "box_b")) == "In(RedBall, box_b)"


def test_a_disjunction_holds_by_either_part_and_lists_both_when_neither_does() -> None:
    either = any_of(IN_CONTAINER("ball_1", "box_b"), HOLDING("gripper_1", "ball_1"))
    world = tiny_world()
    held = Overlay(world)
    held.place("ball_1", "sk:heldBy", "gripper_1")

    assert either.evaluate(held)
    lines = [line.strip() for line in either.evaluate(world).lines()]
    assert lines[1:] == [
        "any of these (does not hold)",
        "In(ball_1, box_b) (does not hold)",
        "ball_1 is not in box_b: it is in box_a",
        "Holding(gripper_1, ball_1) (does not hold)",
        "ball_1 is not heldBy gripper_1: it is in box_a",
    ]


def test_a_disjunction_takes_each_argument_once_with_its_class() -> None:
    either = any_of(IN_CONTAINER("Ball", "Box"), HOLDING("Gripper", "Ball"))

    assert either.arguments == ("Ball", "Box", "Gripper")
    assert [role.class_ for role in either.type.roles] == ["tiny:Ball", "sk:Container", "sk:Gripper"]


def test_parameters_are_bound_to_elements() -> None:
    condition = AT_LOCATION("Robot", "Location")
    binding = {"Robot": "robot_1", "Location": "unknown_location"}

    assert condition.evaluate(tiny_world(), binding)
    assert str(condition.bind(binding)) == "At(robot_1, unknown_location)"


def test_a_computed_condition_gives_the_reason_of_its_function() -> None:
    giant = "scene:giant_1 a tiny:Giant ; sk:in scene:box_a ."

    assert says(FITS("giant_1", "slot_1"), giant)[1].strip() == "giant_1 does not fit into slot_1"


NEAR = ConditionType(
    "Near", (Role("one", "tiny:Ball"), Role("other", "tiny:Box")), Computed("sk:near", "one", "other"), "-"
)
POSES = 'scene:ball_1 sk:pose "0 0 0 0 0 0"^^sk:poseLiteral .', 'scene:box_a sk:pose "0.2 0 0 0 0 0"^^sk:poseLiteral .'


def test_a_computed_condition_without_a_function_is_answered_by_the_reasoner_of_the_view() -> None:
    assert says(NEAR("ball_1", "box_a"), *POSES) == [
        "Near(ball_1, box_a) (holds)",
        "  ball_1 is near box_a: there are 0.200 m between them",
    ]
    assert says(NEAR("ball_1", "box_b"), *POSES)[1].strip() == "the pose of box_b in the map is not known"


def test_a_reasoner_evaluates_the_assumptions_of_an_overlay() -> None:
    world = tiny_world(*POSES)
    overlay = Overlay(world)
    overlay.set_value("box_a", "sk:pose", None)

    assert NEAR("ball_1", "box_a").evaluate(world)
    assert not NEAR("ball_1", "box_a").evaluate(overlay)


def test_a_relation_that_no_reasoner_computes_is_said_to_be_unknown() -> None:
    pattern = Computed("sk:near", "one", "other")
    world = World(tiny_world().ontology)
    with world.transaction("test", "two things") as tx:
        tx.add("sk:Floor", id="floor")
        tx.add("sk:Floor", id="cellar")

    with pytest.raises(UnknownName, match="no reasoner computes it"):
        pattern.evaluate(world, {"one": "floor", "other": "cellar"})


@pytest.mark.parametrize("pattern", [Computed("sk:near", "a", "b"), FITS.pattern.rename({"ball": "a", "slot": "b"})])
def test_the_pairs_of_a_computed_pattern_are_those_for_which_it_holds(pattern: Computed) -> None:
    world = tiny_world(*POSES, "scene:giant_1 a tiny:Giant ; sk:in scene:box_a .")
    balls, others = world.instances("tiny:Ball"), world.instances("sk:Container")
    expected = {(a, b) for a in balls for b in others if pattern.evaluate(world, {"a": a, "b": b})}

    assert expected
    assert set(pattern.pairs(world, balls, others)) == expected


def test_the_wrong_number_of_arguments_is_the_authors_fault_and_is_explained() -> None:
    with pytest.raises(DescriptionError, match=r"In takes \(ball, place\), got \(Ball\)"):
        IN_CONTAINER("Ball")


def test_evaluating_on_an_overlay_leaves_the_world_alone() -> None:
    world = tiny_world()
    overlay = Overlay(world)
    overlay.place("ball_1", "sk:in", "slot_1")

    assert IN_CONTAINER("ball_1", "slot_1").evaluate(overlay)
    assert not IN_CONTAINER("ball_1", "slot_1").evaluate(world)


def test_a_placement_relation_may_have_the_place_as_its_subject() -> None:
    world = tiny_world()
    with world.transaction("test", "loaded") as tx:
        tx.relate("robot_1", "tiny:carries", "ball_1")

    assert CARRIES("robot_1", "ball_1").evaluate(world)
    assert not IN_CONTAINER("ball_1", "box_a").evaluate(world)


def test_renaming_touches_free_variables_only() -> None:
    pattern = Exists("box", "tiny:Box", AllOf((Related("sk:in", "ball", "box"), Has("sk:drivingPose", "box"))))

    assert pattern.rename({"ball": "b", "box": "other"}) == Exists(
        "box", "tiny:Box", AllOf((Related("sk:in", "b", "box"), Has("sk:drivingPose", "box")))
    )
    assert Nothing("sk:in", "slot").rename({"slot": "s"}) == Nothing("sk:in", "s")


@pytest.mark.parametrize(
    "condition", [IN_CONTAINER("ball_1", "moon"), HOLDING("moon", "ball_1"), FITS("ball_1", "moon")]
)
def test_a_condition_about_a_missing_element_does_not_hold_and_says_so(condition: Condition) -> None:
    world = tiny_world()

    verdict = condition.evaluate(world)

    assert not verdict
    assert verdict.lines() == [f"{condition} (does not hold)", "  there is no moon"]
    assert (~condition).evaluate(world), "it is not so"


def test_all_missing_elements_are_named() -> None:
    assert says(IN_CONTAINER("mars", "moon"))[1].strip() == "there is no mars and no moon"


def test_no_element_of_a_class_is_there_when_its_negation_holds() -> None:
    world = tiny_world("scene:ball_2 a tiny:Ball ; sk:in scene:slot_1 .")

    assert IN_CONTAINER("tiny:Ball", "slot_1").evaluate(world)
    assert not (~IN_CONTAINER("tiny:Ball", "slot_1")).evaluate(world), "another ball that is elsewhere does not count"
    assert (~IN_CONTAINER("tiny:RedBall", "slot_1")).evaluate(world)


@pytest.mark.parametrize("class_", ["tiny:Ball", "tiny:RedBall", "tiny:Giant"])
@pytest.mark.parametrize("place", ["box_a", "box_b", "slot_1"])
def test_a_negated_condition_over_classes_holds_exactly_when_the_plain_one_does_not(class_: str, place: str) -> None:
    world, condition = tiny_world(), IN_CONTAINER(class_, place)

    assert bool((~condition).evaluate(world)) is not bool(condition.evaluate(world))


def test_the_quantifier_of_a_class_is_inside_the_negation() -> None:
    pattern = (~IN_CONTAINER("tiny:Ball", "slot_1")).closed_pattern(tiny_world().ontology)

    assert pattern == Not(Exists("tiny:Ball", "tiny:Ball", Related("sk:in", "tiny:Ball", "slot_1")))


def test_an_element_called_like_a_quantified_variable_is_not_mistaken_for_it() -> None:
    world = tiny_world(
        "scene:box a sk:Surface ; sk:on scene:floor . scene:box_q a tiny:Box ; sk:on scene:box ."
        " scene:ball_q a tiny:Ball ; sk:in scene:box_q ."
    )

    assert STORED("ball_q", "box").evaluate(world)
    assert not STORED("ball_1", "box").evaluate(world)


def test_renaming_into_a_quantified_name_gives_the_quantifier_another() -> None:
    pattern = Exists("box", "tiny:Box", Related("sk:in", "ball", "box"))

    renamed = pattern.rename({"ball": "box"})

    assert isinstance(renamed, Exists)
    assert renamed.variable != "box"
    assert renamed.pattern == Related("sk:in", "box", renamed.variable)
