from __future__ import annotations

from dataclasses import replace
from itertools import count

import pytest

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.actions import actions_of, moved_and_place
from skiros_py.planning.domain.literals import Conjunction, expand
from skiros_py.planning.domain.model import Action, Atom, NoneSuch, Variable
from skiros_py.skills.conditions import (
    AllOf,
    AnyOf,
    Computed,
    ConditionType,
    Exists,
    Has,
    Not,
    Nothing,
    Pattern,
    Related,
    Role,
    Verdict,
    any_of,
)
from skiros_py.skills.parameters import Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.testing import tiny_ontology
from skiros_py.testing.tiny import (
    AT_LOCATION,
    CARRIES,
    DRIVE,
    EMPTY_HANDED,
    HOLDING,
    IN_CONTAINER,
    PICK,
    PLACE,
    REACHABLE,
)

_ROBOT = Param("Robot", "sk:Robot", "Who.")
_BALL = Param("Ball", "tiny:Ball", "What.")
_BOX = Param("Box", "tiny:Box", "Where.")
GIVE = SkillDescription(
    "give", "Hands a ball over.", "Robot", "Ball", (_ROBOT, _BALL), (), (), (CARRIES("Robot", "Ball"),)
)
LOAD = replace(GIVE, name="load", params=(_ROBOT, _BALL, _BOX), pre=(IN_CONTAINER("Ball", "Box"),))
STORED = ConditionType(
    "Stored",
    (Role("ball", "tiny:Ball"), Role("where", "sk:Location")),
    Exists("box", "tiny:Box", AllOf((Related("sk:in", "ball", "box"), Related("sk:on", "box", "where")))),
    "The ball lies in some box that stands there.",
)


def ways_of(pattern: Pattern, where: str = "here") -> tuple[Conjunction, ...]:
    return expand(pattern, where, tiny_ontology(), count(1))


def action(skill: SkillDescription) -> Action:
    """Returns the action, or its first variant: the one in which it is moved from the kind of place that it gets."""
    return actions_of(skill, tiny_ontology())[0]


@pytest.mark.parametrize(
    ("pattern", "atom"),
    [
        (Related("sk:in", "ball", "box"), Atom("sk:in", ("ball", "box"))),
        (Nothing("sk:in", "slot"), Atom("nothing sk:in", ("slot",))),
        (Has("sk:drivingPose", "box"), Atom("has sk:drivingPose", ("box",))),
        (Computed("tiny:fitsIn", "ball", "slot", lambda *_: Verdict(True, "")), Atom("tiny:fitsIn", ("ball", "slot"))),
    ],
)
def test_each_simple_pattern_becomes_one_literal(pattern: Related, atom: Atom) -> None:
    (conjunction,) = ways_of(pattern)

    assert (conjunction.atoms, conjunction.variables) == ((atom,), ())


def test_a_conjunction_of_disjunctions_becomes_every_combination() -> None:
    a, b, c, d = (Related("sk:in", name, "box") for name in "abcd")

    ways = ways_of(AllOf((AnyOf((a, b)), AnyOf((c, d)))))

    pairs = [tuple(atom.arguments[0] for atom in way.atoms) for way in ways]
    assert pairs == [("a", "c"), ("a", "d"), ("b", "c"), ("b", "d")]


def test_an_existential_adds_a_typed_variable() -> None:
    (way,) = ways_of(Exists("box", "tiny:Box", Related("sk:in", "ball", "box")))

    assert way.variables == (Variable("box #1", "tiny:Box"),)
    assert way.atoms == (Atom("sk:in", ("ball", "box #1")),)


def test_each_existential_adds_its_own_variable() -> None:
    inside = Exists("box", "tiny:Box", Related("sk:in", "ball", "box"))
    outside = Exists("box", "tiny:Box", Related("sk:on", "ball", "box"))

    (way,) = ways_of(AllOf((inside, outside)))

    assert [variable.name for variable in way.variables] == ["box #1", "box #2"]
    assert [atom.arguments[1] for atom in way.atoms] == ["box #1", "box #2"]


def test_a_negated_emptiness_adds_a_variable_for_the_occupant() -> None:
    (way,) = ways_of(Not(Nothing("sk:heldBy", "gripper")))

    (holder,) = way.variables
    assert way.atoms == (Atom("sk:heldBy", (holder.name, "gripper")),)
    assert holder.type == tiny_ontology().relations["sk:heldBy"].domain


def test_a_relation_holds_if_one_of_its_subrelations_holds() -> None:
    ways = ways_of(Related("sk:placement", "ball", "box"))

    assert [atom.predicate for way in ways for atom in way.atoms] == [
        "sk:at",
        "sk:heldBy",
        "sk:in",
        "sk:mayBeIn",
        "sk:on",
        "tiny:carries",
    ]


def test_negating_a_relation_negates_each_subrelation() -> None:
    (way,) = ways_of(Not(Related("sk:placement", "ball", "box")))

    assert [atom.predicate for atom in way.atoms] == [
        f"not {r}" for r in ("sk:at", "sk:heldBy", "sk:in", "sk:mayBeIn", "sk:on", "tiny:carries")
    ]


def test_the_absence_of_a_relation_is_the_absence_of_each_subrelation() -> None:
    (way,) = ways_of(Nothing("sk:placement", "box"))

    assert [atom.predicate for atom in way.atoms] == [
        f"nothing {r}" for r in ("sk:at", "sk:heldBy", "sk:in", "sk:mayBeIn", "sk:on", "tiny:carries")
    ]


def test_a_double_negation_cancels_out() -> None:
    pattern = Related("sk:in", "ball", "box")

    assert ways_of(Not(Not(pattern))) == ways_of(pattern)


def test_a_negated_relation_has_its_own_predicate() -> None:
    (way,) = ways_of(Not(Related("sk:in", "a", "b")))

    assert way == Conjunction((Atom("not sk:in", ("a", "b")),))


def test_the_absence_of_elements_becomes_a_quantifier() -> None:
    (way,) = ways_of(Not(Exists("b", "tiny:Box", AllOf((Related("sk:in", "a", "b"), Related("sk:on", "b", "c"))))))

    atoms = Atom("sk:in", ("a", "b #1")), Atom("sk:on", ("b #1", "c"))
    assert way == Conjunction(none=(NoneSuch((Variable("b #1", "tiny:Box"),), atoms),))


def test_the_absence_of_two_alternatives_becomes_two_quantifiers() -> None:
    either = AnyOf((Related("sk:in", "a", "b"), Related("sk:on", "a", "b")))
    (way,) = ways_of(Not(Exists("b", "tiny:Box", either)))

    assert [none.atoms[0].predicate for none in way.none] == ["sk:in", "sk:on"]


def test_nested_absence_is_refused_by_name_and_place() -> None:
    inner = Not(Exists("ball", "tiny:Ball", Related("sk:in", "ball", "b")))

    with pytest.raises(PlanningError, match="precondition X of 'y': 'no Box of which there is no …' cannot be planned"):
        ways_of(Not(Exists("b", "tiny:Box", inner)), "precondition X of 'y'")


@pytest.mark.parametrize("never", [AnyOf(()), Not(AllOf(()))])
def test_a_pattern_that_never_holds_is_refused_by_place(never: Pattern) -> None:
    with pytest.raises(PlanningError, match="precondition X of 'y': any of no conditions never holds"):
        ways_of(never, "precondition X of 'y'")


def test_every_action_has_a_precondition_on_the_capable_agent() -> None:
    assert [action(skill).pre[0] for skill in (DRIVE, PICK, PLACE)] == [
        Atom("can_drive", ("?Base",)),
        Atom("can_pick", ("?Arm",)),
        Atom("can_place", ("?Arm",)),
    ]


def test_the_parameters_of_the_skill_come_first_in_their_order() -> None:
    assert [v.name for v in action(PICK).parameters] == ["?Arm", "?Gripper", "?Robot", "?Box", "?Ball"]


def test_driving_has_an_added_parameter_for_the_place_that_the_robot_leaves() -> None:
    drive = action(DRIVE)

    assert drive.parameters[-1] == Variable("?Robot_from", "sk:Location")
    assert Atom("sk:at", ("?Robot", "?Robot_from")) in drive.pre
    assert drive.delete == (Atom("sk:at", ("?Robot", "?Robot_from")),)


def test_additions_to_an_action_are_listed_with_their_reasons() -> None:
    assert action(DRIVE).notes == (
        "precondition can_drive(Base): who has the skill",
        "parameter Robot_from, precondition at(Robot, Robot_from): the place that Robot leaves",
        "effect not at(Robot, Robot_from): Robot has one place only",
    )


def test_an_action_has_a_variant_per_relation_to_the_old_place() -> None:
    variants = actions_of(DRIVE, tiny_ontology())

    assert [v.name for v in variants] == ["drive/1", "drive/2", "drive/3"]
    assert [v.delete for v in variants] == [(Atom(r, ("?Robot", "?Robot_from")),) for r in ("sk:at", "sk:in", "sk:on")]


def test_a_ball_can_come_from_a_container_a_surface_a_gripper_or_another_robot() -> None:
    variants = actions_of(GIVE, tiny_ontology())

    assert [v.delete[0].predicate for v in variants] == ["tiny:carries", "sk:heldBy", "sk:in", "sk:mayBeIn", "sk:on"]


def test_the_added_parameter_for_the_old_place_never_clashes_with_a_declared_one() -> None:
    own = Param("Robot_from", "sk:Location", "Where to look from.")
    drive = action(replace(DRIVE, params=(*DRIVE.params, own)))

    assert [v.name for v in drive.parameters[-2:]] == ["?Robot_from", "?Robot_from'"]
    assert drive.delete == (Atom("sk:at", ("?Robot", "?Robot_from'")),)


def test_a_place_named_in_a_precondition_is_left_whatever_the_relation() -> None:
    assert action(PICK).delete == (Atom("sk:in", ("?Ball", "?Box")),)
    assert action(PLACE).delete == (Atom("sk:heldBy", ("?Ball", "?Gripper")),)


def test_the_ontology_declares_which_end_of_a_relation_moves() -> None:
    ontology = tiny_ontology()

    assert moved_and_place(Atom("sk:in", ("ball", "box")), ontology) == ("ball", "box")
    assert moved_and_place(Atom("tiny:carries", ("robot", "ball")), ontology) == ("ball", "robot")


def test_a_thing_moved_to_a_subject_place_leaves_its_container() -> None:
    assert action(LOAD).delete == (Atom("sk:in", ("?Ball", "?Box")),)


def test_the_old_carrier_of_a_subject_place_is_a_further_parameter_of_the_domain() -> None:
    give = action(GIVE)

    assert give.parameters[-1] == Variable("?Ball_from", "sk:Robot")
    assert give.delete == (Atom("tiny:carries", ("?Ball_from", "?Ball")),)


def test_the_carrier_itself_does_not_move() -> None:
    load = replace(LOAD, pre=(*LOAD.pre, AT_LOCATION("Robot", "Box")))

    assert Atom("sk:at", ("?Robot", "?Box")) not in action(load).delete


def test_a_plain_relation_deletes_nothing() -> None:
    place = Param("Place", "sk:Location", "Where.")
    knows = replace(
        AT_LOCATION,
        pattern=Related("tiny:knows", "robot", "location"),
    )
    show = SkillDescription("show", "-", "Robot", "Place", (_ROBOT, place), (), (), (knows("Robot", "Place"),))

    assert action(show).delete == ()


def test_a_declared_negative_effect_is_a_delete() -> None:
    lose = replace(LOAD, name="lose", post=(~IN_CONTAINER("Ball", "Box"),))

    assert (action(lose).add, action(lose).delete) == ((), (Atom("sk:in", ("?Ball", "?Box")),))


def test_each_alternative_of_a_precondition_is_a_variant_of_the_skill() -> None:
    either = any_of(HOLDING("Gripper", "Ball"), IN_CONTAINER("Ball", "Box"))
    gripper = Param("Gripper", "sk:Gripper", "Whose.")
    variants = actions_of(replace(LOAD, params=(*LOAD.params, gripper), pre=(either,)), tiny_ontology())

    assert [(a.name, a.skill) for a in variants] == [("load/1", "load"), ("load/2", "load")]
    assert Atom("sk:heldBy", ("?Ball", "?Gripper")) in variants[0].pre
    assert Atom("sk:in", ("?Ball", "?Box")) in variants[1].pre
    assert "variant: way 2 of Holding(Gripper, Ball) or In(Ball, Box): in(Ball, Box)" in variants[1].notes


def test_a_postcondition_that_cannot_be_caused_is_refused_with_skill_and_condition() -> None:
    with pytest.raises(PlanningError, match=r"skill 'drive', postcondition Reachable\(Location\)"):
        actions_of(replace(DRIVE, post=(REACHABLE("Location"),)), tiny_ontology())


def test_a_postcondition_that_does_not_say_how_something_is_placed_is_refused() -> None:
    somewhere = ConditionType("Somewhere", IN_CONTAINER.roles, Related("sk:placement", "ball", "place"), "-")

    with pytest.raises(PlanningError, match=r"skill 'load' has a postcondition of sk:placement.*use one of sk:at"):
        actions_of(replace(LOAD, post=(somewhere("Ball", "Box"),)), tiny_ontology())


def test_a_negated_precondition_is_a_predicate_of_its_own() -> None:
    pick = action(replace(PICK, pre=(*PICK.pre, ~HOLDING("Gripper", "Ball"))))

    assert pick.pre[-1] == Atom("not sk:heldBy", ("?Ball", "?Gripper"))


def test_two_existentials_with_one_name_are_different_variables() -> None:
    other, where = Param("Other", "tiny:Ball", "Another."), Param("Where", "sk:Location", "Where.")
    look = action(
        replace(GIVE, params=(_ROBOT, _BALL, other, where), pre=(STORED("Ball", "Where"), STORED("Other", "Where")))
    )

    assert Atom("sk:in", ("?Ball", "?box #1")) in look.pre
    assert Atom("sk:in", ("?Other", "?box #2")) in look.pre
    assert look.delete == (Atom("sk:in", ("?Ball", "?box #1")),), "the ball leaves its own box"


def test_an_existential_never_clashes_with_a_parameter_of_the_same_name() -> None:
    where, box = Param("Where", "sk:Location", "Where."), Param("box", "tiny:Box", "Another.")
    look = action(replace(GIVE, params=(_ROBOT, _BALL, where, box), pre=(STORED("Ball", "Where"),)))

    assert [v.name for v in look.parameters] == ["?Robot", "?Ball", "?Where", "?box", "?box #1"]
    assert not [atom for atom in look.pre if "?box" in atom.arguments]


def test_hold_conditions_must_hold_at_the_start() -> None:
    gripper = Param("Gripper", "sk:Gripper", "What it must not carry.")
    careful = replace(DRIVE, params=(*DRIVE.params, gripper), hold=(EMPTY_HANDED("Gripper"),))

    assert Atom("nothing sk:heldBy", ("?Gripper",)) in action(careful).pre


def test_a_hold_condition_with_two_alternatives_makes_variants() -> None:
    either = any_of(REACHABLE("Box"), AT_LOCATION("Robot", "Box"))

    assert [a.name for a in actions_of(replace(LOAD, hold=(either,)), tiny_ontology())] == ["load/1", "load/2"]


def test_a_hold_condition_that_pddl_cannot_express_is_refused_by_name() -> None:
    never = ConditionType("Never", (Role("ball", "tiny:Ball"),), AnyOf(()), "-")

    with pytest.raises(PlanningError, match=r"skill 'load', precondition Never\(Ball\): any of no conditions"):
        actions_of(replace(LOAD, hold=(never("Ball"),)), tiny_ontology())


START = ConditionType(
    "StartsAt",
    (Role("robot", "sk:Robot"), Role("location", "sk:Location")),
    Related("sk:startLocation", "robot", "location"),
    "A relation of which a robot has one only.",
)
_PLACE = Param("Place", "sk:Location", "Where.")
MOVE_IN = SkillDescription("move_in", "-", "Robot", "Place", (_ROBOT, _PLACE), (), (), (START("Robot", "Place"),))


def test_a_functional_property_replaces_an_existing_value() -> None:
    had, had_none = actions_of(MOVE_IN, tiny_ontology())
    before = Atom("sk:startLocation", ("?Robot", "?Place_before"))

    assert before in had.pre
    assert had.delete == (before,)
    assert [none.atoms for none in had_none.none] == [(before,)]
    assert had_none.delete == ()


def test_a_functional_value_named_in_a_precondition_is_replaced() -> None:
    other = Param("Other", "sk:Location", "The old one.")
    (move,) = actions_of(
        replace(MOVE_IN, params=(*MOVE_IN.params, other), pre=(START("Robot", "Other"),)), tiny_ontology()
    )

    assert move.delete == (Atom("sk:startLocation", ("?Robot", "?Other")),)
