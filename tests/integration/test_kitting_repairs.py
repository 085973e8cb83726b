"""What is said of goals without a plan in the kitting scene, and that what is offered works when it is applied."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import pytest

import skiros_py
from skiros_py.planning.edits import Move
from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.station.session import Session
from skiros_py.world.change import Writer

Moves = Sequence[tuple[str, ...]]

MISSING = (
    [("relay_box_2", "sk:in", "kit_1_b"), ("compressor_1",), ("starter_1", "sk:in", "kit_1_a")],
    (
        "exists p: Part (InKit(p, kit_1) and not ObjectAtLocation(p, kit_1_a)) and for all p: Starter (InKit(p, kit_1))"
        " and ObjectAtLocation(Compressor, kit_1_b)"
    ),
)
TWICE = (
    [
        ("compressor_1", "sk:in", "kit_1_c"),
        ("relay_box_1", "sk:on", "floor"),
        ("alternator_1", "sk:in", "kit_1_a"),
        ("relay_box_2", "sk:in", "kit_1_d"),
    ],
    (
        "exists p: RelayBox (InKit(p, kit_1) and not ObjectAtLocation(p, kit_1_a)) and LocationEmpty(kit_1_d) and "
        "(InKit(RelayBox, kit_1) or ObjectAtLocation(starter_1, kit_1_b))"
    ),
)
FOR_ALL = ([], "for all p: Part (InKit(p, kit_1))")
IN_TWO = ([("relay_box_2", "sk:in", "kit_1_b"), ("relay_box_1", "sk:in", "kit_1_d")], "LocationEmpty(kit_1_b)")
NOT_IN_KIT = ([("relay_box_1", "sk:in", "kit_1_b")], "not InKit(relay_box_1, kit_1)")
NOT_THERE = ([("starter_1", "sk:in", "kit_1_b")], "not ObjectAtLocation(starter_1, kit_1_b)")
SOME_NOT_THERE = (
    [("compressor_1", "sk:in", "kit_1_a")],
    "exists p: Compressor (InKit(p, kit_1) and not ObjectAtLocation(p, kit_1_a))",
)
CASES = (MISSING, TWICE, FOR_ALL, IN_TWO, NOT_IN_KIT, NOT_THERE, SOME_NOT_THERE)


@contextmanager
def kitting(moves: Moves) -> Iterator[Session]:
    with skiros_py.open("kitting", fake=True) as session:
        with session.world.transaction("test", "set up", writer=Writer.PERSON) as tx:
            for element, *placement in moves:
                if placement:
                    tx.place(element, *placement)
                else:
                    tx.remove(element)
        yield session


def unplanned(session: Session, goal: str) -> NoPlan:
    outcome = session.plan([goal]).outcome
    assert isinstance(outcome, NoPlan)
    return outcome


@pytest.mark.parametrize(
    ("case", "reason", "repair"),
    [
        pytest.param(FOR_ALL, "kit_1 has room for 4 only", "remove alternator_1 from the scene", id="five parts"),
        pytest.param(IN_TWO, "no skill takes it away", "put relay_box_2 in pallet_a", id="other kept places"),
        pytest.param(
            NOT_IN_KIT,
            "relay_box_1 is in kit_1_b, and no skill takes it from there",
            "put relay_box_1 in pallet_",
            id="not in the kit",
        ),
        pytest.param(NOT_THERE, "kit_1_b is not a StoragePlace", "put starter_1 in pallet_a", id="not there"),
        pytest.param(
            SOME_NOT_THERE, "kit_1_a is not a StoragePlace", "put compressor_1 in pallet_a", id="some not there"
        ),
    ],
)
def test_the_reason_is_given_and_the_smallest_repair_comes_first(
    case: tuple[Moves, str], reason: str, repair: str
) -> None:
    moves, goal = case
    with kitting(moves) as session:
        found = unplanned(session, goal)

    assert reason in found.reasons[0]
    assert found.repairs[0].text.startswith(repair)


@pytest.mark.parametrize(
    "case", CASES, ids=["missing", "twice", "five parts", "kept places", "not in kit", "not there", "some not there"]
)
def test_each_repair_can_be_applied_and_moves_each_thing_at_most_once(case: tuple[Moves, str]) -> None:
    moves, goal = case
    with kitting(moves) as session:
        repairs = unplanned(session, goal).repairs
    assert repairs
    for repair in repairs:
        moved = [edit.element for edit in repair.edits if isinstance(edit, Move)]
        assert len(set(moved)) == len(moved)
    for repair in (repair for repair in repairs if not repair.without):
        with kitting(moves) as session:
            repair.apply(session.world)

            assert isinstance(session.plan([goal]).outcome, Plan), repair.text


def test_the_explanation_of_a_full_kit_names_all_its_compartments() -> None:
    taken = [("starter_1", "a"), ("alternator_1", "b"), ("compressor_1", "c"), ("relay_box_1", "d")]
    with kitting([(part, "sk:in", f"kit_1_{place}") for part, place in taken]) as session:
        (cause,) = unplanned(session, "InKit(relay_box_2, kit_1)").causes

    heart = "kit_1 is full: kit_1_a, kit_1_b, kit_1_c and kit_1_d are taken, and no skill takes anything away"
    assert cause.why == heart
    assert cause.text.endswith(heart)


def test_of_conditions_that_exclude_each_other_every_repair_gives_one_up() -> None:
    with kitting([("base_1",)]) as session:
        one = unplanned(session, "ObjectAtLocation(relay_box_1, kit_1_a)")
        both = unplanned(session, "ObjectAtLocation(relay_box_1, kit_1_a) and ObjectAtLocation(relay_box_2, kit_1_a)")

    assert [repair.text for repair in one.repairs] == ["put kit_1 on deck_1 and put robot_1 at pallet_a"]
    assert "kit_1_a takes one relay box only" in both.reasons[0]
    assert both.repairs
    assert all(repair.without for repair in both.repairs)


def test_two_robots_at_one_docking_place_are_explained_by_its_room_for_one_robot() -> None:
    with skiros_py.open("kitting_two", fake=True) as session:
        found = unplanned(session, "RobotAtLocation(robot_1, pallet_a) and RobotAtLocation(robot_2, pallet_a)")

    assert "pallet_a takes one robot only" in found.reasons[0]


def test_two_parts_in_one_compartment_are_explained_by_its_room_for_one_part() -> None:
    with kitting([("starter_1", "sk:in", "kit_1_a")]) as session:
        found = unplanned(session, "ObjectAtLocation(starter_1, kit_1_a) and ObjectAtLocation(relay_box_1, kit_1_a)")

    assert "kit_1_a takes one part only" in found.reasons[0]
    assert found.repairs[0].instead
    assert any(repair.without for repair in found.repairs)


def test_without_a_robot_the_missing_robot_is_the_cause():
    with kitting([("robot_1",)]) as session:
        outcome = unplanned(session, "ObjectAtLocation(Alternator, kit_1_b)")
        assert outcome.reasons == ("ObjectAtLocation(Alternator, kit_1_b) cannot be reached: there is no Robot",)
        assert [repair.text for repair in outcome.repairs] == ["see to it that there is a Robot"]
