"""What may be put where is what a transaction would allow."""

from __future__ import annotations

import pytest

from skiros_py.errors import UnknownName, UsageError, WorldError
from skiros_py.station.world.placements import placement_options
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import SKILLS
from skiros_py.world.world import World


@pytest.fixture
def world() -> World:
    return tiny_world()


def allowed(world: World, element: str, relation: str, place: str) -> bool:
    try:
        with world.transaction("tester", "tries") as tx:
            tx.place(element, relation, place)
            raise InterruptedError  # only wants to know
    except InterruptedError:
        return not tx.problems()
    except WorldError:
        return False


@pytest.mark.parametrize("element", ["ball_1", "box_a", "robot_1"])
def test_placement_options_agree_with_the_checks_of_a_transaction(world: World, element: str) -> None:
    view = world.snapshot()
    told = placement_options(view, view.element(element).type, element, 100)

    assert told.options
    for option in told.options:
        for place in option.places:
            assert place.fits == allowed(world, element, option.relation, place.id), (option.relation, place)


def test_the_relations_that_skills_need_are_accepted(world: World) -> None:
    skills = [skill.description for skill in SKILLS]
    told = placement_options(world.snapshot(), "tiny:Ball", None, 1, skills=skills)

    assert {option.relation for option in told.options if option.accepted} == {"sk:in", "sk:heldBy"}


def test_a_placement_relation_whose_subject_is_the_place_is_offered_inversely(world: World) -> None:
    told = placement_options(world.snapshot(), "tiny:Ball", None, 100, relation="tiny:carries")

    assert [place.id for place in told.options[0].places] == list(world.instances("sk:Robot"))


def test_placement_options_are_read_in_pages(world: World) -> None:
    view = world.snapshot()
    whole = placement_options(view, "tiny:Ball", None, 100, relation="sk:in").options[0]
    first = placement_options(view, "tiny:Ball", None, 2, relation="sk:in").options[0]
    rest = placement_options(view, "tiny:Ball", None, 100, relation="sk:in", after=first.next or "").options[0]

    assert first.next == first.places[-1].id
    assert first.places + rest.places == whole.places
    assert whole.total == first.total == len(whole.places)


def test_a_relation_that_is_not_a_placement_is_refused(world: World) -> None:
    with pytest.raises(UnknownName):
        placement_options(world.snapshot(), "tiny:Ball", None, 10, relation="sk:nothing")
    with pytest.raises(UsageError, match="sk:hasA does not place anything: use one of sk:at"):
        placement_options(world.snapshot(), "tiny:Ball", None, 10, relation="sk:hasA")
