from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.errors import DescriptionError
from skiros_py.skills.conditions import (
    AllOf,
    AnyOf,
    Condition,
    Exists,
    Not,
    Related,
    all_of,
    any_of,
    exists,
    for_all,
)
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, CARRIES, FITS, FREE, HOLDING, IN_CONTAINER

WORLD = tiny_world("scene:ball_2 a tiny:Ball ; sk:in scene:slot_1 .")
ONTOLOGY = WORLD.ontology
BALLS, PLACES = ("ball_1", "ball_2", "red_ball_1"), ("box_a", "slot_1", "slot_2")


def reasons(condition: Condition) -> list[str]:
    return [line.strip() for line in condition.evaluate(WORLD).lines()]


def test_nested_conditions_are_printed_in_parentheses() -> None:
    one, other, third = FREE("slot_1"), FREE("slot_2"), CARRIES("robot_1", "ball_1")

    assert str(any_of(all_of(one, other), ~third)) == "(Free(slot_1) and Free(slot_2)) or not Carries(robot_1, ball_1)"
    assert str(~any_of(one, other)) == "not (Free(slot_1) or Free(slot_2))"
    assert str(all_of(~any_of(one, other), third)) == "not (Free(slot_1) or Free(slot_2)) and Carries(robot_1, ball_1)"
    assert str(~exists("s", "tiny:Slot", FREE("s"))) == "not exists s: Slot (Free(s))"


def test_nested_conditions_with_the_same_operator_are_flattened() -> None:
    one, other, third = FREE("slot_1"), FREE("slot_2"), CARRIES("robot_1", "ball_1")

    assert any_of(any_of(one, other), third) == any_of(one, other, third)
    assert all_of(one, all_of(other, third)) == all_of(one, other, third)
    assert any_of(~any_of(one, other), third) != any_of(one, other, third)
    assert any_of(one) == one


@pytest.mark.parametrize("join", [all_of, any_of])
def test_an_empty_conjunction_or_disjunction_is_refused(join: Callable[..., Condition]) -> None:
    with pytest.raises(DescriptionError, match="give at least one condition"):
        join()


def test_the_variable_of_a_quantifier_is_no_argument_and_its_class_is_named() -> None:
    condition = for_all("s", "tiny:Slot", any_of(~IN_CONTAINER("tiny:Ball", "s"), AT_LOCATION("robot_1", "box_a")))

    assert condition.arguments == ("tiny:Ball", "robot_1", "box_a")
    assert [role.class_ for role in condition.type.roles] == ["tiny:Ball", "sk:Robot", "sk:Location"]
    assert condition.names == ("tiny:Slot", "tiny:Ball", "robot_1", "box_a")


@pytest.mark.parametrize("make", [for_all, exists])
@pytest.mark.parametrize("variable", ["", "7up", "tiny:Slot", "a b", "?s"])
def test_a_variable_with_an_invalid_name_is_refused(make: Callable[..., Condition], variable: str) -> None:
    with pytest.raises(DescriptionError, match="cannot be a variable"):
        make(variable, "tiny:Slot", FREE(variable))


def test_a_variable_that_is_not_used_or_bound_twice_is_refused() -> None:
    with pytest.raises(DescriptionError, match=r"exists s: s is no argument of Free\(slot_1\)"):
        exists("s", "tiny:Slot", FREE("slot_1"))
    with pytest.raises(DescriptionError, match="for all s: s is no argument of exists s"):
        for_all("s", "tiny:Slot", exists("s", "tiny:Slot", FREE("s")))


def test_for_all_fails_by_the_first_element_that_fails() -> None:
    assert reasons(for_all("s", "tiny:Slot", FREE("s"))) == [
        "for all s: Slot (Free(s)) (does not hold)",
        "it does not hold for the Slot slot_1 (does not hold)",
        "Free(slot_1) (does not hold)",
        "ball_2 in slot_1",
    ]


def test_for_all_holds_of_a_class_without_elements_and_says_so() -> None:
    nobody = for_all("g", "tiny:Giant", IN_CONTAINER("g", "slot_1"))

    assert nobody.evaluate(WORLD)
    assert reasons(nobody)[1] == "there is no Giant, so it holds for all"
    assert not (~nobody).evaluate(WORLD)


def test_exists_names_its_witness_or_what_was_tried() -> None:
    assert reasons(exists("s", "tiny:Slot", FREE("s")))[1] == "slot_2 is the Slot (holds)"
    lines = reasons(exists("b", "tiny:RedBall", IN_CONTAINER("b", "slot_1")))
    assert lines[1:] == [
        "no RedBall makes it true (1 tried) (does not hold)",
        "In(red_ball_1, slot_1) (does not hold)",
        "red_ball_1 is not in slot_1: it is in box_b",
    ]
    assert reasons(exists("g", "tiny:Giant", IN_CONTAINER("g", "slot_1")))[1] == "there is no Giant"


def test_a_negated_disjunction_that_fails_shows_the_part_that_holds() -> None:
    assert reasons(~any_of(FREE("slot_1"), FREE("slot_2")))[1:] == [
        "any of these (holds)",
        "Free(slot_2) (holds)",
        "nothing in slot_2",
    ]


def test_a_removed_element_fails_only_its_part_of_the_condition() -> None:
    assert any_of(FREE("slot_9"), FREE("slot_2")).evaluate(WORLD)
    assert "there is no slot_9" in reasons(all_of(FREE("slot_9"), FREE("slot_2")))


def test_a_class_is_quantified_within_the_condition_that_names_it() -> None:
    in_1, in_2 = IN_CONTAINER("tiny:Ball", "slot_1"), IN_CONTAINER("tiny:Ball", "slot_2")

    def some(place: str) -> Exists:
        return Exists("tiny:Ball", "tiny:Ball", Related("sk:in", "tiny:Ball", place))

    assert all_of(in_1, ~in_2).closed_pattern(ONTOLOGY) == AllOf((some("slot_1"), Not(some("slot_2"))))
    assert (~any_of(in_1, in_2)).closed_pattern(ONTOLOGY) == Not(AnyOf((some("slot_1"), some("slot_2"))))
    quantified = for_all("s", "tiny:Slot", IN_CONTAINER("tiny:Ball", "s"))
    assert quantified.closed_pattern(ONTOLOGY) == Not(Exists("s", "tiny:Slot", Not(some("s"))))


def test_binding_replaces_free_variables_in_all_parts_only() -> None:
    condition = any_of(exists("Ball", "tiny:Ball", FITS("Ball", "Slot")), HOLDING("Gripper", "Ball"))

    bound = condition.bind({"Slot": "slot_1", "Ball": "ball_1", "Gripper": "gripper_1"})

    assert str(bound) == "exists Ball: Ball (Fits(Ball, slot_1)) or Holding(gripper_1, ball_1)"
    assert str((~condition).bind({"Slot": "slot_1"})).startswith("not (exists Ball: Ball (Fits(Ball, slot_1)) or")


def test_a_bound_variable_is_renamed_if_an_element_has_its_name() -> None:
    world = tiny_world("scene:b a tiny:Slot ; sk:on scene:floor . scene:ball_2 a tiny:Ball ; sk:in scene:b .")
    condition = exists("b", "tiny:Ball", IN_CONTAINER("b", "Slot"))

    assert str(condition.bind({"Slot": "b"})) == "exists b_: Ball (In(b_, b))"
    assert condition.evaluate(world, {"Slot": "b"})
    assert not condition.evaluate(world, {"Slot": "slot_1"})


def places(variables: tuple[str, ...]) -> st.SearchStrategy[Condition]:
    things = st.sampled_from([*BALLS, "tiny:Ball", "tiny:RedBall", *(v for v in variables if v.startswith("b"))])
    where = st.sampled_from([*PLACES, *(v for v in variables if v.startswith("s"))])
    slots = st.sampled_from([*PLACES[1:], *(v for v in variables if v.startswith("s"))])
    return st.builds(IN_CONTAINER, things, where) | st.builds(FREE, slots)


def quantified(kind: Callable[..., Condition], variable: str, part: Condition) -> Condition:
    class_ = "tiny:Ball" if variable.startswith("b") else "tiny:Slot"
    return kind(variable, class_, part) if variable in part.arguments else part


def trees(depth: int = 3, variables: tuple[str, ...] = ()) -> st.SearchStrategy[Condition]:
    if depth == 0:
        return places(variables)
    inner = trees(depth - 1, variables)
    variable = f"{'bs'[depth % 2]}{depth}"
    return st.one_of(
        places(variables),
        inner.map(lambda c: ~c),
        st.builds(
            lambda join, parts: join(*parts), st.sampled_from([all_of, any_of]), st.lists(inner, min_size=2, max_size=3)
        ),
        st.builds(
            lambda kind, part: quantified(kind, variable, part),
            st.sampled_from([for_all, exists]),
            trees(depth - 1, (*variables, variable)),
        ),
    )


@settings(deadline=None, max_examples=150)
@given(trees())
def test_a_condition_holds_exactly_when_its_closed_pattern_does(condition: Condition) -> None:
    pattern = condition.closed_pattern(ONTOLOGY)
    verdict = condition.evaluate(WORLD)

    assert bool(verdict) == bool(pattern.evaluate(WORLD, {name: name for name in condition.arguments}))
    assert bool((~condition).evaluate(WORLD)) is not bool(verdict)
    assert verdict.lines()[0].startswith(str(condition))
    assert ~~condition == condition
    assert hash(~~condition) == hash(condition)


@settings(deadline=None, max_examples=100)
@given(trees())
def test_a_condition_over_parameters_says_the_same_as_over_the_elements_they_are_bound_to(condition: Condition) -> None:
    parameters = condition.bind({name: name.upper() for name in (*BALLS, *PLACES)})
    binding = {name.upper(): name for name in (*BALLS, *PLACES)}

    assert parameters.bind(binding) == condition
    assert parameters.evaluate(WORLD, binding) == condition.evaluate(WORLD)
