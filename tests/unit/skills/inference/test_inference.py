from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from skiros_py.errors import DescriptionError, UnknownName
from skiros_py.skills.conditions import Computed, Exists, Has, Not, Nothing, Pattern, Related, Verdict, any_of
from skiros_py.skills.inference.inferring import Inferred, Missing, applying, infer
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import (
    AT_LOCATION,
    CARRIES,
    DRIVE,
    EMPTY_HANDED,
    HAS_PART,
    HOLDING,
    IN_CONTAINER,
    PICK,
    PLACE,
)
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import AT, IN, MASS
from skiros_py.world.world import World

MORE_BALLS = "scene:ball_2 a tiny:Ball ; sk:in scene:box_a . scene:ball_3 a tiny:Ball ; sk:in scene:box_a ."


def world_at(place: str, *facts: str, robots: int = 1) -> World:
    world = tiny_world(*facts, robots=robots)
    with world.transaction("test", "drives") as tx:
        tx.place("robot_1", AT, place)
    return world


@cache
def at_box_a() -> World:
    return world_at("box_a", MORE_BALLS)


def with_param(skill: SkillDescription, key: str, **changes: Any) -> SkillDescription:
    return replace(skill, params=tuple(replace(p, **changes) if p.key == key else p for p in skill.params))


def inferred(skill: SkillDescription, view: WorldView, agent: str | None = None, **given: Any) -> Inferred:
    answer = infer(skill, given, view, agent)
    assert isinstance(answer, Inferred), answer
    return answer


def lacking(skill: SkillDescription, view: WorldView, agent: str | None = None, **given: Any) -> Missing:
    answer = infer(skill, given, view, agent)
    assert isinstance(answer, Missing), answer
    return answer


def test_all_parameters_of_a_pick_are_inferred_from_its_arm() -> None:
    assert inferred(PICK, at_box_a(), "arm_1").lines() == [
        "Arm = arm_1: it does it",
        "Gripper = gripper_1: the only one that fits",
        "Robot = robot_1: the only one that fits",
        "Box = box_a: the only one that fits",
        "Ball = ball_1: of 3 that fit, the first by id",
    ]


def test_given_parameters_are_kept_and_the_others_are_inferred_to_match() -> None:
    answer = inferred(PICK, at_box_a(), "arm_1", Ball="ball_3", Box=None)

    assert answer.values["Ball"] == "ball_3"
    assert "Ball" not in answer.reasons


def test_with_several_robots_devices_of_the_executing_robot_are_inferred() -> None:
    world = world_at("box_a", robots=2)

    assert dict(inferred(HOLD_STILL, world, "arm_2").values) == {
        "Arm": "arm_2",
        "Gripper": "gripper_2",
        "Robot": "robot_2",
    }


HOLD_STILL = SkillDescription(
    name="hold_still",
    help="Does nothing.",
    agent="Arm",
    target="Gripper",
    params=PICK.params[:3],
    pre=(HAS_PART("Robot", "Arm"), HAS_PART("Arm", "Gripper")),
    post=(EMPTY_HANDED("Gripper"),),
)


def test_inference_starts_without_values_of_previous_runs() -> None:
    world = world_at("box_a")
    first = inferred(PICK, world, "arm_1").values["Ball"]
    with world.transaction("test", "moves") as tx:
        tx.place("robot_1", AT, "box_b")

    assert (first, inferred(PICK, world, "arm_1").values["Ball"]) == ("ball_1", "red_ball_1")


def test_of_several_candidates_the_preferred_one_is_chosen() -> None:
    world = world_at("box_a", MORE_BALLS, "scene:ball_3 sk:mass 0.5 .")
    skill = with_param(PICK, "Ball", prefer=(Related(IN, "it", "Robot"), Has(MASS, "it")))

    answer = inferred(skill, world, "arm_1")

    assert answer.values["Ball"] == "ball_3"
    assert answer.reasons["Ball"] == "of 3 that fit, preferred: ball_3 has a mass"


def test_the_first_fulfilled_preference_decides() -> None:
    world = world_at("box_a", MORE_BALLS, "scene:red_ball_2 a tiny:RedBall ; sk:in scene:box_a .")
    skill = with_param(PICK, "Ball", prefer=(Has(MASS, "it"), Not(Computed("sk:near", "it", "Robot", _is_first))))

    assert inferred(skill, world, "arm_1").values["Ball"] == "ball_2"


def _is_first(view: WorldView, subject: str, object_: str) -> Any:
    return Verdict(subject == "ball_1", f"{subject} is first of {object_}")


def test_of_equally_preferred_candidates_the_cheapest_is_chosen() -> None:
    masses = "scene:ball_1 sk:mass 0.5 . scene:ball_2 sk:mass 0.2 . "
    world = world_at("box_a", MORE_BALLS, masses)
    by_property = inferred(with_param(PICK, "Ball", cost=MASS), world, "arm_1")
    by_function = inferred(with_param(PICK, "Ball", cost=lambda view, ball: -len(view.instances("sk:Arm"))), world)

    assert by_property.values["Ball"] == "ball_2"
    assert by_property.reasons["Ball"] == "of 3 that fit, the one of least mass (0.2)"
    assert by_function.reasons["Ball"] == "of 3 that fit, the first by id"


def test_preferences_take_precedence_over_costs() -> None:
    world = world_at("box_a", MORE_BALLS, "scene:ball_3 sk:mass 0.5 .")
    skill = with_param(PICK, "Ball", prefer=Has(MASS, "it"), cost=lambda view, ball: float(ball[-1]))

    assert inferred(skill, world, "arm_1").values["Ball"] == "ball_3"


def test_related_elements_of_another_class_are_not_chosen() -> None:
    world = tiny_world("scene:ball_0 a tiny:Ball ; sk:in scene:a_slot . scene:a_slot a tiny:Slot ; sk:on scene:floor .")
    skill = replace(PICK, pre=(IN_CONTAINER("Ball", "Box"),))

    assert inferred(skill, world, "arm_1").values["Box"] == "box_a"
    assert isinstance(infer(skill, {"Ball": "ball_0"}, world, "arm_1"), Missing)


def test_a_computed_relation_of_an_element_with_itself_is_evaluated() -> None:
    same = Computed("sk:near", "it", "Other", lambda view, a, b: Verdict(a == b, "the same"))
    other = replace(PICK, pre=(), params=(*PICK.params, Param("Other", "tiny:Ball", "A ball.")))
    skill = with_param(other, "Ball", where=same)

    assert inferred(skill, at_box_a(), "arm_1", Other="ball_2").values["Ball"] == "ball_2"


def test_a_preference_on_one_parameter_also_determines_dependent_parameters() -> None:
    world = tiny_world("scene:red_ball_1 sk:mass 0.5 .")
    skill = with_param(replace(PICK, pre=(IN_CONTAINER("Ball", "Box"),)), "Ball", prefer=Has(MASS, "it"))

    answer = inferred(skill, world, "arm_1")

    assert (answer.values["Ball"], answer.values["Box"]) == ("red_ball_1", "box_b")
    assert answer.reasons["Box"] == "of 2 that fit, the one that goes with the rest"


def test_a_broken_cost_function_is_the_authors_fault() -> None:
    skill = with_param(PICK, "Ball", cost=lambda view, ball: 1 / 0)

    with pytest.raises(DescriptionError, match="the cost of ball_1 as parameter Ball could not be worked out: ZeroDiv"):
        infer(skill, {}, at_box_a(), "arm_1")


@pytest.mark.parametrize("nonsense", [None, "cheap", float("nan"), True])
def test_a_cost_that_is_not_a_number_counts_as_the_highest(nonsense: Any) -> None:
    skill = with_param(PICK, "Ball", cost=lambda view, ball: 5.0 if ball == "ball_2" else nonsense)

    assert inferred(skill, at_box_a(), "arm_1").values["Ball"] == "ball_2"


def test_two_candidates_for_a_unique_parameter_are_an_error() -> None:
    answer = lacking(with_param(PICK, "Ball", unique=True), at_box_a(), "arm_1")

    assert answer.keys == ("Ball",)
    assert str(answer) == "parameter Ball not specified: Ball: ball_1, ball_2, ball_3 all fit: say which"
    assert answer.values["Gripper"] == "gripper_1"


def test_one_candidate_for_a_unique_parameter_is_taken() -> None:
    assert inferred(with_param(PICK, "Box", unique=True), at_box_a(), "arm_1").values["Box"] == "box_a"


def test_a_partial_description_restricts_the_candidates() -> None:
    world = world_at("box_b")
    skill = replace(
        PICK,
        target="Slot",
        params=(Param("Arm", "sk:Arm", "Who."), Param("Slot", "sk:Container", "Any.", where=Nothing(IN, "it"))),
        pre=(),
        post=(HAS_PART("Arm", "Slot"),),
    )

    assert inferred(skill, world, "arm_1").reasons["Slot"] == "of 2 that fit, the first by id"
    assert inferred(skill, world, "arm_1").values["Slot"] == "slot_1"


@pytest.mark.parametrize(
    ("pattern", "ball"),
    [
        (Exists("box", "tiny:Box", Related(IN, "it", "box")), "ball_1"),
        (Exists("slot", "tiny:Slot", Related(IN, "it", "slot")), "ball_2"),
        (Not(Related(IN, "it", "Box")), "ball_2"),
        (Computed("sk:fitsIn", "it", "Box", lambda view, a, b: _is_first(view, a, b)), "ball_1"),
    ],
)
def test_patterns_that_generate_no_candidates_filter_them(pattern: Pattern, ball: str) -> None:
    world = world_at("box_a", "scene:ball_2 a tiny:Ball ; sk:in scene:slot_1 .")
    skill = with_param(replace(PICK, pre=(AT_LOCATION("Robot", "Box"),)), "Ball", where=pattern)

    assert inferred(skill, world, "arm_1", Robot="robot_1").values["Ball"] == ball


def test_a_disjunction_leads_to_candidates_on_both_sides() -> None:
    world = world_at("box_a", "scene:ball_9 a tiny:Ball . scene:robot_1 tiny:carries scene:ball_9 .")
    skill = replace(
        PICK, pre=(AT_LOCATION("Robot", "Box"), any_of(IN_CONTAINER("Ball", "Box"), CARRIES("Robot", "Ball")))
    )

    answer = inferred(skill, world, "arm_1", Robot="robot_1")

    assert answer.reasons["Ball"] == "of 2 that fit, the first by id"


def test_a_single_unsuitable_candidate_is_chosen_so_that_the_check_can_name_it() -> None:
    world = world_at("box_a")
    with world.transaction("test", "holds") as tx:
        tx.place("red_ball_1", "sk:heldBy", "gripper_1")

    answer = inferred(PICK, world, "arm_1")

    assert answer.values["Gripper"] == "gripper_1"
    assert answer.reasons["Gripper"] == "the only candidate, although EmptyHanded(Gripper) does not hold"
    assert answer.values["Ball"] == "ball_1"
    assert not EMPTY_HANDED("Gripper").evaluate(world, answer.values)


def test_if_no_candidate_is_suitable_the_best_one_gives_the_reason() -> None:
    answer = lacking(PLACE, at_box_a(), "arm_1", Slot="slot_1")

    assert answer.keys == ("Ball",)
    assert answer.lines() == [
        "Ball: ball_1, the best of 4 candidates (does not hold)",
        "  Holding(gripper_1, ball_1) (does not hold)",
        "    ball_1 is not heldBy gripper_1: it is in box_a",
    ]


def test_a_class_without_elements_is_reported_and_the_other_parameters_are_inferred() -> None:
    skill = with_param(PICK, "Ball", type="tiny:Giant")

    answer = lacking(skill, at_box_a(), "arm_1")

    assert str(answer) == "parameter Ball not specified: Ball: there is no tiny:Giant"
    assert answer.values["Box"] == "box_a"


def test_a_required_value_cannot_be_inferred() -> None:
    skill = replace(DRIVE, params=(*DRIVE.params, Param("Speed", "number", "How fast.", unit="m/s")))

    answer = lacking(skill, at_box_a(), "base_1", Location="box_b")

    assert str(answer) == "parameter Speed not specified: Speed: a number [m/s] must be given"
    assert isinstance(infer(skill, {"Location": "box_b", "Speed": 0.0}, at_box_a(), "base_1"), Inferred)


def test_several_missing_parameters_are_all_named_in_order() -> None:
    skill = replace(PICK, params=(*PICK.params, Param("Speed", "number", "How fast.")))

    answer = lacking(with_param(skill, "Ball", type="tiny:Giant"), at_box_a(), "arm_1")

    assert answer.keys == ("Ball", "Speed")
    assert str(answer).startswith("parameters Ball, Speed not specified: ")


def test_an_optional_parameter_stays_open_and_its_conditions_are_not_evaluated() -> None:
    skill = with_param(PICK, "Box", kind=Kind.OPTIONAL)

    answer = inferred(skill, at_box_a(), "arm_1")

    assert answer.values["Box"] is None
    assert answer.reasons["Ball"] == "of 4 that fit, the first by id"
    assert [str(c) for c in applying(skill.needs, answer.values)] == [
        "HasPart(Robot, Arm)",
        "HasPart(Arm, Gripper)",
        "EmptyHanded(Gripper)",
    ]


def test_a_preference_about_an_optional_parameter_left_open_does_not_count() -> None:
    skill = with_param(with_param(PICK, "Box", kind=Kind.OPTIONAL), "Ball", prefer=Related(IN, "it", "Box"))

    assert inferred(skill, at_box_a(), "arm_1").values["Ball"] == "ball_1"


def test_a_default_is_treated_like_a_given_value() -> None:
    skill = with_param(PICK, "Box", kind=Kind.OFFLINE, default="box_b")

    assert inferred(skill, at_box_a(), "arm_1", Box="box_a").values["Ball"] == "ball_1"
    assert inferred(skill, world_at("box_b"), "arm_1").values["Ball"] == "red_ball_1"


def test_learned_concepts_are_not_candidates() -> None:
    from skiros_py.world.branches import learn

    world = world_at("box_a")
    with world.transaction("test", "shown") as tx:
        learn(tx, "ball_1")

    assert set(world.abstracts("tiny:Ball"))
    assert inferred(PICK, world, "arm_1").values["Ball"] == "ball_1"


def test_an_undeclared_term_is_an_error_and_not_an_empty_answer() -> None:
    skill = with_param(PICK, "Ball", where=Related("sk:under", "it", "Box"))

    with pytest.raises(UnknownName, match="sk:under"):
        infer(skill, {}, at_box_a(), "arm_1")


def test_unconnected_parameters_are_searched_separately() -> None:
    balls = " ".join(f"scene:ball_{n} a tiny:Ball ; sk:in scene:box_a ." for n in range(2, 400))
    skill = replace(
        PICK,
        params=tuple(Param(key, "tiny:Ball", "A ball.") for key in "ABCD"),
        agent="A",
        target="A",
        pre=(),
        post=(HOLDING("A", "B"),),
    )

    assert [*inferred(skill, tiny_world(balls)).reasons.values()] == ["of 400 that fit, the first by id"] * 4
