from __future__ import annotations

from dataclasses import replace
from itertools import count

import pytest

from skiros_py.errors import PlanningError
from skiros_py.planning.actions import actions_of, moved_and_place
from skiros_py.planning.literals import Conjunction, expand
from skiros_py.planning.model import Action, Atom, Variable
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
from skiros_py.testing.tiny_skills import (
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
    (result,) = actions_of(skill, tiny_ontology())
    return result


@pytest.mark.parametrize(
    ("pattern", "atom"),
    [
        (Related("sk:in", "ball", "box"), Atom("sk:in", ("ball", "box"))),
        (Nothing("sk:in", "slot"), Atom("nothing sk:in", ("slot",))),
        (Has("sk:drivingPose", "box"), Atom("has sk:drivingPose", ("box",))),
        (Computed("tiny:fitsIn", "ball", "slot", lambda *_: Verdict(True, "")), Atom("tiny:fitsIn", ("ball", "slot"))),
    ],
)
def test_each_simple_pattern_is_one_literal(pattern: Related, atom: Atom) -> None:
    (conjunction,) = ways_of(pattern)

    assert (conjunction.atoms, conjunction.variables) == ((atom,), ())


def test_a_conjunction_of_disjunctions_becomes_every_combination() -> None:
    a, b, c, d = (Related("sk:in", name, "box") for name in "abcd")

    ways = ways_of(AllOf((AnyOf((a, b)), AnyOf((c, d)))))

    pairs = [tuple(atom.arguments[0] for atom in way.atoms) for way in ways]
    assert pairs == [("a", "c"), ("a", "d"), ("b", "c"), ("b", "d")]


def test_an_existential_brings_a_typed_variable() -> None:
    (way,) = ways_of(Exists("box", "tiny:Box", Related("sk:in", "ball", "box")))

    assert way.variables == (Variable("box #1", "tiny:Box"),)
    assert way.atoms == (Atom("sk:in", ("ball", "box #1")),)


def test_each_existential_brings_a_variable_of_its_own() -> None:
    some_box = Exists("box", "tiny:Box", Related("sk:in", "ball", "box"))

    (way,) = ways_of(AllOf((some_box, some_box)))

    assert [variable.name for variable in way.variables] == ["box #1", "box #2"]
    assert [atom.arguments[1] for atom in way.atoms] == ["box #1", "box #2"]


def test_that_something_is_there_brings_a_variable_for_what_it_is() -> None:
    (way,) = ways_of(Not(Nothing("sk:heldBy", "gripper")))

    (holder,) = way.variables
    assert way.atoms == (Atom("sk:heldBy", (holder.name, "gripper")),)
    assert holder.type == tiny_ontology().relations["sk:heldBy"].domain


def test_a_relation_that_has_narrower_ones_is_refused_and_they_are_named() -> None:
    with pytest.raises(PlanningError, match=r"here: sk:placement is too general .*name one of .*sk:in.*tiny:carries"):
        ways_of(Related("sk:placement", "ball", "box"))


def test_a_double_negation_is_none() -> None:
    pattern = Related("sk:in", "ball", "box")

    assert ways_of(Not(Not(pattern))) == ways_of(pattern)


@pytest.mark.parametrize(
    ("pattern", "named"),
    [
        (Related("sk:in", "a", "b"), r"not in\(a, b\): "),
        (Exists("b", "tiny:Box", Related("sk:in", "a", "b")), "no Box such that …: "),
        (AllOf(()), ""),
    ],
)
def test_what_strips_cannot_say_is_refused_by_name_and_place(pattern: Pattern, named: str) -> None:
    text = f"precondition X of 'y': {named}that something is not so cannot be planned for"
    with pytest.raises(PlanningError, match=text):
        ways_of(Not(pattern), "precondition X of 'y'")


def test_every_action_asks_who_can_do_it() -> None:
    assert [action(skill).pre[0] for skill in (DRIVE, PICK, PLACE)] == [
        Atom("can_drive", ("?Base",)),
        Atom("can_pick", ("?Arm",)),
        Atom("can_place", ("?Arm",)),
    ]


def test_the_skills_parameters_come_first_and_in_their_order() -> None:
    assert [v.name for v in action(PICK).parameters] == ["?Arm", "?Gripper", "?Robot", "?Box", "?Ball"]


def test_driving_leaves_the_place_where_the_robot_was_by_a_further_parameter() -> None:
    drive = action(DRIVE)

    assert drive.parameters[-1] == Variable("?Robot_from", "sk:Location")
    assert Atom("sk:at", ("?Robot", "?Robot_from")) in drive.pre
    assert drive.delete == (Atom("sk:at", ("?Robot", "?Robot_from")),)
    assert len(drive.notes) == 2, "an author can read what was added and why"


def test_a_place_named_by_a_precondition_is_left_whatever_relation_it_was() -> None:
    assert action(PICK).delete == (Atom("sk:in", ("?Ball", "?Box")),)
    assert action(PLACE).delete == (Atom("sk:heldBy", ("?Ball", "?Gripper")),)


def test_the_end_that_moves_is_the_ontologys_word() -> None:
    ontology = tiny_ontology()

    assert moved_and_place(Atom("sk:in", ("ball", "box")), ontology) == ("ball", "box")
    assert moved_and_place(Atom("tiny:carries", ("robot", "ball")), ontology) == ("ball", "robot")


def test_what_a_subject_place_takes_leaves_its_container() -> None:
    assert action(LOAD).delete == (Atom("sk:in", ("?Ball", "?Box")),)


def test_the_old_carrier_of_a_subject_place_is_a_further_parameter_of_the_domain() -> None:
    give = action(GIVE)

    assert give.parameters[-1] == Variable("?Ball_from", "sk:Robot")
    assert give.delete == (Atom("tiny:carries", ("?Ball_from", "?Ball")),)


def test_the_carrier_itself_stays_where_it_is() -> None:
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


def test_a_declared_end_of_a_relation_is_a_delete() -> None:
    lose = replace(LOAD, name="lose", post=(~IN_CONTAINER("Ball", "Box"),))

    assert (action(lose).add, action(lose).delete) == ((), (Atom("sk:in", ("?Ball", "?Box")),))


def test_each_way_a_precondition_can_hold_is_a_variant_of_the_skill() -> None:
    either = any_of(REACHABLE("Location"), AT_LOCATION("Robot", "Location"))
    variants = actions_of(replace(DRIVE, pre=(either,)), tiny_ontology())

    assert [(a.name, a.skill) for a in variants] == [("drive/1", "drive"), ("drive/2", "drive")]
    assert Atom("has sk:drivingPose", ("?Location",)) in variants[0].pre
    assert Atom("sk:at", ("?Robot", "?Location")) in variants[1].pre


def test_a_postcondition_that_cannot_be_caused_is_refused_with_skill_and_condition() -> None:
    with pytest.raises(PlanningError, match=r"skill 'drive', postcondition Reachable\(Location\)"):
        actions_of(replace(DRIVE, post=(REACHABLE("Location"),)), tiny_ontology())


def test_a_negated_precondition_is_refused_with_skill_and_condition() -> None:
    with pytest.raises(PlanningError, match=r"skill 'pick', precondition not Holding\(Gripper, Ball\)"):
        actions_of(replace(PICK, pre=(~HOLDING("Gripper", "Ball"),)), tiny_ontology())


def test_two_conditions_with_an_existential_of_one_name_speak_of_two_elements() -> None:
    other, where = Param("Other", "tiny:Ball", "Another."), Param("Where", "sk:Location", "Where.")
    look = action(
        replace(GIVE, params=(_ROBOT, _BALL, other, where), pre=(STORED("Ball", "Where"), STORED("Other", "Where")))
    )

    assert Atom("sk:in", ("?Ball", "?box #1")) in look.pre
    assert Atom("sk:in", ("?Other", "?box #2")) in look.pre
    assert look.delete == (Atom("sk:in", ("?Ball", "?box #1")),), "the ball leaves its own box"


def test_an_existential_never_means_a_parameter_of_its_name() -> None:
    where, box = Param("Where", "sk:Location", "Where."), Param("box", "tiny:Box", "Another.")
    look = action(replace(GIVE, params=(_ROBOT, _BALL, where, box), pre=(STORED("Ball", "Where"),)))

    assert [v.name for v in look.parameters] == ["?Robot", "?Ball", "?Where", "?box", "?box #1"]
    assert not [atom for atom in look.pre if "?box" in atom.arguments]


def test_what_must_hold_while_it_runs_must_hold_when_it_starts() -> None:
    gripper = Param("Gripper", "sk:Gripper", "What it must not carry.")
    careful = replace(DRIVE, params=(*DRIVE.params, gripper), hold=(EMPTY_HANDED("Gripper"),))

    assert Atom("nothing sk:heldBy", ("?Gripper",)) in action(careful).pre


def test_a_hold_condition_that_can_be_met_in_two_ways_makes_variants() -> None:
    either = any_of(REACHABLE("Location"), AT_LOCATION("Robot", "Location"))

    assert [a.name for a in actions_of(replace(DRIVE, hold=(either,)), tiny_ontology())] == ["drive/1", "drive/2"]


def test_a_hold_condition_that_cannot_be_written_is_refused_by_name() -> None:
    params = (*DRIVE.params, Param("Gripper", "sk:Gripper", "-"), Param("Ball", "tiny:Ball", "-"))

    with pytest.raises(PlanningError, match=r"skill 'drive', precondition not Holding\(Gripper, Ball\)"):
        actions_of(replace(DRIVE, params=params, hold=(~HOLDING("Gripper", "Ball"),)), tiny_ontology())
