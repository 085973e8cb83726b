"""What fits, what can be grasped, what is of like size, and what a person may not put where."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from skiros_py.errors import UsageError, WorldError
from skiros_py.world.change import Writer
from skiros_py.world.element import Placement
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import Answer, Reasoners
from skiros_py.world.reasoners.sizes import SizeReasoner, similarity
from skiros_py.world.world import World

ONTOLOGY = Ontology.load([Path(__file__).parents[4] / "ontologies"])
SIZES = SizeReasoner()

lengths = st.floats(0.01, 0.5)
sizes = st.tuples(lengths, lengths, lengths)
PARTS = ("kitting:Starter", "kitting:Alternator", "kitting:Compressor", "kitting:RelayBox")


def solid(size: tuple[float, ...]) -> str:
    return json.dumps([{"kind": "box", "size": size, "at": [0, 0, size[2] / 2]}])


def world_of(**things: tuple[str, tuple[float, ...] | None]) -> World:
    """A world of things by id, each of a class and a size of its own, on the floor."""
    world = World(ONTOLOGY, reasoners=Reasoners((SIZES,)))
    with world.transaction("test", "things") as tx:
        tx.add("sk:Floor", id="floor")
        for name, (class_, size) in things.items():
            properties = {} if size is None else {"sk:solid": solid(size)}
            tx.add(class_, id=name, properties=properties, placement=Placement("sk:on", "floor"))
    return world


def crate(size: tuple[float, ...] | None) -> tuple[str, tuple[float, ...] | None]:
    return "kitting:StoragePlace", size


def part(size: tuple[float, ...] | None) -> tuple[str, tuple[float, ...] | None]:
    return "kitting:RelayBox", size


# ---------------------------------------------------------------- relations


@settings(max_examples=30, deadline=None)
@given(st.lists(sizes, min_size=1, max_size=5), st.lists(sizes, min_size=1, max_size=5), st.booleans())
def test_the_pairs_of_a_relation_equal_its_single_answers(
    parts: list[tuple[float, ...]], crates: list[tuple[float, ...]], unknown: bool
) -> None:
    things = {f"part_{n}": part(size) for n, size in enumerate(parts)}
    boxes = {f"crate_{n}": crate(None if unknown and n == 0 else size) for n, size in enumerate(crates)}
    world = world_of(**things, **boxes)
    expected = [(p, c) for p in things for c in boxes if SIZES.answer(world, p, "sk:fitsIn", c).holds]

    assert list(SIZES.pairs(world, "sk:fitsIn", tuple(things), tuple(boxes))) == expected
    assert world.objects("part_0", "sk:fitsIn") == tuple(sorted(c for p, c in expected if p == "part_0"))


@settings(max_examples=30, deadline=None)
@given(sizes, sizes, st.floats(0.0, 0.1))
def test_a_part_that_fits_also_fits_a_larger_container_and_the_value_is_the_clearance(
    size: tuple[float, float, float], room: tuple[float, float, float], more: float
) -> None:
    world = world_of(p=part(size), small=crate(room), large=crate((room[0] + more, room[1] + more, room[2])))
    answer = SIZES.answer(world, "p", "sk:fitsIn", "small")

    assert answer.holds is (answer.value is not None and answer.value >= 0.005)
    assert not answer.holds or SIZES.answer(world, "p", "sk:fitsIn", "large").holds
    long, short = max(size[:2]), min(size[:2])
    assert answer.value == pytest.approx(min(max(room[:2]) - long, min(room[:2]) - short), abs=1e-9)


@pytest.mark.parametrize(("width", "holds"), [(0.049, True), (0.0799, True), (0.08, False), (0.2, False)])
def test_a_gripper_can_grasp_parts_narrower_than_its_opening(width: float, holds: bool) -> None:
    world = world_of(p=part(None), gripper=("sk:Gripper", None))
    with world.transaction("test", "widths") as tx:
        tx.set("p", "sk:graspWidth", width)
        tx.set("gripper", "sk:maxGap", 0.08)

    answer = SIZES.answer(world, "p", "sk:graspableBy", "gripper")
    assert answer.holds is holds
    assert answer.reason == f"p is {width:.3f} m wide, gripper opens 0.080 m"
    assert world.related("p", "sk:graspableBy", "gripper") is holds
    assert world.subjects("sk:graspableBy", "gripper") == (("p",) if holds else ())


def test_without_a_width_or_an_opening_nothing_is_graspable_and_the_answer_says_why() -> None:
    world = world_of(p=part(None), gripper=("sk:Gripper", None))

    answer = SIZES.answer(world, "p", "sk:graspableBy", "gripper")
    assert answer == Answer(False, "p has no sk:graspWidth, or gripper no sk:maxGap")
    assert world.objects("p", "sk:graspableBy") == ()


# ---------------------------------------------------------------- alike


@settings(max_examples=50, deadline=None)
@given(sizes, sizes, st.permutations([0, 1, 2]))
def test_similarity_is_symmetric_between_0_and_1_and_1_for_equal_sizes_in_any_orientation(
    one: tuple[float, float, float], other: tuple[float, float, float], turn: list[int]
) -> None:
    world = world_of(a=part(one), b=part(other), c=part(tuple(one[axis] for axis in turn)))
    alike = similarity(world, "a", "b")

    assert alike is not None
    assert 0.0 < alike <= 1.0
    assert similarity(world, "b", "a") == pytest.approx(alike)
    assert similarity(world, "a", "c") == pytest.approx(1.0)


def test_similarity_is_the_overlap_of_the_volumes_divided_by_their_union() -> None:
    world = world_of(a=part((0.1, 0.1, 0.1)), b=part((0.1, 0.1, 0.2)), unknown=crate(None))

    assert similarity(world, "a", "b") == pytest.approx(0.5)
    assert similarity(world, "a", "unknown") is None
    assert SIZES.functions["sk:similarity"](world, "a", "b") == pytest.approx(0.5)


@pytest.mark.parametrize("class_", PARTS)
def test_an_element_with_the_size_of_a_class_is_most_likely_of_that_class(class_: str) -> None:
    world = world_of(seen=("kitting:Part", None))
    size = SIZES.data(world_of(one=(class_, None)), "one", "dimensions")
    assert isinstance(size, tuple)
    with world.transaction("look", "measured, lying on another side") as tx:
        tx.set("seen", "sk:solid", solid((size[2] * 1.03, size[0] * 0.97, size[1])))

    found = SIZES.classify(world, "seen", PARTS)
    assert found[0][0] == class_
    assert found[0][1] > 0.5


@settings(max_examples=50, deadline=None)
@given(sizes, st.permutations([*PARTS, "kitting:Part", "sk:Gripper"]))
@example((50.0, 50.0, 50.0), [*PARTS, "kitting:Part", "sk:Gripper"])
def test_likelihoods_sum_to_1_and_are_sorted_for_any_measured_size(
    size: tuple[float, float, float], classes: list[str]
) -> None:
    found = SIZES.classify(world_of(seen=("kitting:Part", size)), "seen", classes)

    assert sorted(name for name, _ in found) == sorted(PARTS), "what has no size is left out"
    assert sum(likely for _, likely in found) == pytest.approx(1.0)
    assert [likely for _, likely in found] == sorted((likely for _, likely in found), reverse=True)


def test_elements_without_a_measured_size_or_candidates_of_known_size_are_not_classified() -> None:
    world = world_of(usual=("kitting:Starter", None), seen=("kitting:Part", (0.1, 0.1, 0.1)))

    assert SIZES.classify(world, "usual", PARTS) == ()
    assert SIZES.classify(world, "seen", ("kitting:Part",)) == ()
    assert SIZES.classify(world, "seen", ()) == ()


# ---------------------------------------------------------------- veto


@pytest.mark.parametrize("writer", [Writer.PERSON, Writer.JOB])
def test_a_person_or_a_job_cannot_put_a_thing_where_it_does_not_fit(writer: Writer) -> None:
    world = world_of(p=part((0.2, 0.1, 0.1)), small=crate((0.15, 0.15, 0.1)))

    with (
        pytest.raises(WorldError, match=r"sizes: p does not fit into small: 0.100 x 0.200 m into 0.150 x 0.150 m"),
        world.transaction("somebody", "tidy up", writer=writer) as tx,
    ):
        tx.place("p", "sk:in", "small")
    placement = world.placement("p")
    assert placement is not None
    assert placement.place == "floor"


@pytest.mark.parametrize("writer", [Writer.SKILL, Writer.SYSTEM])
def test_sensed_values_are_believed(writer: Writer) -> None:
    world = world_of(p=part((0.2, 0.1, 0.1)), small=crate((0.15, 0.15, 0.1)))
    with world.transaction("look", "seen there", writer=writer) as tx:
        tx.place("p", "sk:in", "small")

    assert world.related("p", "sk:in", "small")


@pytest.mark.parametrize(("size", "room"), [((0.1, 0.1, 0.1), (0.15, 0.15, 0.1)), ((0.2, 0.1, 0.1), None)])
def test_a_person_may_place_a_part_that_fits_or_has_an_unknown_size(
    size: tuple[float, ...], room: tuple[float, ...] | None
) -> None:
    world = world_of(p=part(size), c=crate(room))
    with world.transaction("somebody", "tidy up", writer=Writer.PERSON) as tx:
        tx.place("p", "sk:in", "c")

    assert world.related("p", "sk:in", "c")


def test_only_placing_inside_requires_fitting_also_for_new_elements() -> None:
    world = world_of(p=part((0.2, 0.1, 0.1)), small=crate((0.15, 0.15, 0.1)))
    with world.transaction("somebody", "on the lid", writer=Writer.PERSON) as tx:
        tx.place("p", "sk:on", "small")
    assert world.related("p", "sk:on", "small")

    properties = {"sk:solid": solid((0.3, 0.3, 0.3))}
    with (
        pytest.raises(WorldError, match="q does not fit into small"),
        world.transaction("somebody", "another", writer=Writer.PERSON) as tx,
    ):
        tx.add("kitting:RelayBox", id="q", properties=properties, placement=Placement("sk:in", "small"))
    assert not world.has("q")


def test_an_unknown_key_is_refused() -> None:
    world = world_of(p=part((0.2, 0.1, 0.1)))

    assert SIZES.data(world, "p", "dimensions") == pytest.approx((0.2, 0.1, 0.1))
    assert SIZES.data(world, "floor", "dimensions") is None
    with pytest.raises(UsageError, match="sizes reads no 'weight'"):
        SIZES.data(world, "p", "weight")
