from __future__ import annotations

from dataclasses import replace

from skiros_py.planning.domain.actions import actions_of
from skiros_py.planning.domain.goals import emptiness_classes, maintain_emptiness
from skiros_py.planning.domain.model import Action, Atom, NoneSuch, Variable
from skiros_py.skills.conditions import ConditionType, Nothing, Role
from skiros_py.skills.parameters import Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.testing import tiny_ontology
from skiros_py.testing.tiny import EMPTY_HANDED, FREE, IN_CONTAINER, PICK, PLACE

TAKE = replace(
    PICK,
    name="take",
    params=(*PICK.params[:3], Param("Slot", "tiny:Slot", "Where."), PICK.params[4]),
    pre=(IN_CONTAINER("Ball", "Slot"), EMPTY_HANDED("Gripper")),
)
EMPTY_BOX = ConditionType("EmptyBox", (Role("box", "sk:Container"),), Nothing("sk:in", "box"), "Nothing is in the box.")


def maintained(*skills: SkillDescription) -> dict[str, Action]:
    drafts = [action for skill in skills for action in actions_of(skill, tiny_ontology())]
    return {action.name: action for action in maintain_emptiness(drafts, tiny_ontology())}


def test_classes_with_tracked_emptiness_are_found_in_the_preconditions() -> None:
    actions = [action for skill in (PICK, PLACE) for action in actions_of(skill, tiny_ontology())]

    assert emptiness_classes(actions) == {"nothing sk:heldBy": "sk:Gripper", "nothing sk:in": "tiny:Slot"}


def test_taking_fills_the_gripper_and_placing_frees_it() -> None:
    actions = maintained(PICK, PLACE)

    assert Atom("nothing sk:heldBy", ("?Gripper",)) in actions["pick"].delete
    assert Atom("nothing sk:heldBy", ("?Gripper",)) in actions["place"].add


def test_placing_fills_the_slot_and_taking_out_frees_it() -> None:
    actions = maintained(PICK, PLACE, TAKE)

    assert Atom("nothing sk:in", ("?Slot",)) in actions["place"].delete
    assert Atom("nothing sk:in", ("?Slot",)) in actions["take"].add


def test_emptiness_without_a_condition_on_it_is_not_tracked() -> None:
    assert not [atom for atom in maintained(PICK, PLACE)["pick"].add if atom.predicate == "nothing sk:in"]


def none_there(place: str) -> NoneSuch:
    holder = f"{place} holder #sk:in"
    return NoneSuch((Variable(holder, "sk:SpatialThing"),), (Atom("sk:in", (holder, place)),))


def test_if_a_skill_fills_without_checking_each_emptiness_precondition_is_quantified() -> None:
    careless = replace(PLACE, name="throw", pre=tuple(c for c in PLACE.pre if c.type is not FREE))
    actions = maintained(PLACE, careless)

    assert actions["place"].none == (none_there("?Slot"),)
    assert actions["throw"].none == ()
    assert not [a for action in actions.values() for a in action.atoms if a.predicate == "nothing sk:in"]


def test_if_the_source_class_is_too_general_each_emptiness_precondition_is_quantified() -> None:
    anywhere = replace(
        TAKE, name="grab", params=(*TAKE.params[:3], Param("Slot", "sk:Container", "Where."), TAKE.params[4])
    )

    assert maintained(PLACE, anywhere)["place"].none == (none_there("?Slot"),)


def test_if_two_place_classes_are_queried_each_emptiness_precondition_is_quantified() -> None:
    box = Param("Box", "tiny:Box", "Where.")
    boxed = replace(PLACE, name="pack", params=(*PLACE.params, box), pre=(*PLACE.pre, EMPTY_BOX("Box")))

    assert maintained(PLACE, boxed)["pack"].none == (none_there("?Slot"), none_there("?Box"))


def test_gripper_emptiness_is_tracked_even_if_place_emptiness_cannot_be() -> None:
    careless = replace(PLACE, name="throw", pre=tuple(c for c in PLACE.pre if c.type is not FREE))

    assert Atom("nothing sk:heldBy", ("?Gripper",)) in maintained(PICK, PLACE, careless)["place"].add
