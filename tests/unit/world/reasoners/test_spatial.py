"""Spatial relations against definitions spelt out over corners and sample points, and laws they must obey."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.errors import UsageError, WorldError
from skiros_py.geometry import Array, Pose
from skiros_py.world.element import Placement
from skiros_py.world.ontology import Ontology
from skiros_py.world.overlay import Overlay
from skiros_py.world.poses import map_pose, write_pose
from skiros_py.world.reasoners.registry import Answer, Reasoners
from skiros_py.world.reasoners.sizes import SizeReasoner
from skiros_py.world.reasoners.spatial import SpatialReasoner
from skiros_py.world.world import World

ONTOLOGY = Ontology.load([Path(__file__).parents[4] / "ontologies"])
SPATIAL = SpatialReasoner()
RELATIONS = sorted(SPATIAL.relations)

Thing = tuple[tuple[float, float, float], Pose]
"""Full lengths of a box that stands on its frame, and where that is."""

lengths = st.floats(0.02, 0.6)
near_by = st.floats(-0.8, 0.8)
turns = st.one_of(st.sampled_from([0.0, np.pi / 2, np.pi]), st.floats(-3.0, 3.0))
standing = st.builds(lambda x, y, z, w: Pose.of(x, y, z, yaw=w), near_by, near_by, near_by, turns)
anyhow = st.builds(lambda x, y, z, *t: Pose.of(x, y, z, roll=t[0], pitch=t[1], yaw=t[2]), *[near_by] * 3, *[turns] * 3)
things = st.tuples(st.tuples(lengths, lengths, lengths), st.one_of(standing, anyhow))


def world_of(*things: Thing) -> World:
    world = World(ONTOLOGY, reasoners=Reasoners((SPATIAL, SizeReasoner())))
    with world.transaction("test", "things") as tx:
        tx.add("sk:Floor", id="floor")
        for name, (size, pose) in zip("abcdefgh", things, strict=False):
            solid = json.dumps([{"kind": "box", "size": size, "at": [0, 0, size[2] / 2]}])
            properties = {"sk:solid": solid, "sk:pose": pose}
            tx.add("sk:Object", id=name, properties=properties, placement=Placement("sk:on", "floor"))
    return world


def answer(world: World, subject: str, relation: str, object_: str) -> Answer:
    return world.reasoners.answer(world, subject, relation, object_)


def points(thing: Thing, per_side: int = 2) -> Array:
    """Points of a thing in the map, its corners among them."""
    size, pose = thing
    grid = np.array(np.meshgrid(*[np.linspace(-0.5, 0.5, per_side)] * 3)).reshape(3, -1).T * size
    return pose.apply(grid + np.array([0.0, 0.0, size[2] / 2]))


# ---------------------------------------------------------------- what they mean


@settings(max_examples=50, deadline=None)
@given(things, things)
def test_a_body_is_beside_another_if_all_its_corners_are_beyond_that_side(a: Thing, b: Thing) -> None:
    world = world_of(a, b)
    local = b[1].inverse().apply(points(a))
    for relation, axis, side in (
        ("sk:inFrontOf", 0, 1.0),
        ("sk:behind", 0, -1.0),
        ("sk:leftOf", 1, 1.0),
        ("sk:rightOf", 1, -1.0),
    ):
        found = answer(world, "a", relation, "b")
        gap = (side * local[:, axis]).min() - b[0][axis] / 2

        assert found.value == pytest.approx(gap, abs=1e-9)
        if abs(gap) > 0.004:
            assert found.holds is bool(gap > 0), relation


@settings(max_examples=50, deadline=None)
@given(things, things)
def test_a_body_is_above_another_if_it_is_higher_and_their_outlines_overlap(a: Thing, b: Thing) -> None:
    world = world_of(a, b)
    gap = points(a)[:, 2].min() - points(b)[:, 2].max()
    found = answer(world, "a", "sk:above", "b")

    assert found.value == pytest.approx(gap, abs=1e-9)
    assert answer(world, "b", "sk:below", "a").holds is found.holds
    if gap < -0.004:
        assert not found.holds
    elif gap > 0.0:
        low, high = points(b)[:, :2].min(axis=0), points(b)[:, :2].max(axis=0)
        clear = (points(a)[:, :2].min(axis=0) > high) | (points(a)[:, :2].max(axis=0) < low)
        assert not (found.holds and clear.any())
        if (np.abs(points(a)[:, :2].mean(axis=0) - points(b)[:, :2].mean(axis=0)) < 0.005).all():
            assert found.holds


@settings(max_examples=50, deadline=None)
@given(things, things)
def test_a_body_is_inside_another_if_it_is_within_all_its_sides_except_the_top(a: Thing, b: Thing) -> None:
    local = b[1].inverse().apply(points(a))
    half = np.array(b[0]) / 2
    clear = min((half[:2] - np.abs(local[:, :2]).max(axis=0)).min(), local[:, 2].min())
    found = answer(world_of(a, b), "a", "sk:inside", "b")

    assert found.value == pytest.approx(clear, abs=1e-9)
    if clear < -0.004 or local[:, 2].min() > b[0][2]:
        assert not found.holds
    elif clear > 0.0 and local[:, 2].max() < b[0][2]:
        assert found.holds


@settings(max_examples=50, deadline=None)
@given(things, things)
def test_sampled_points_agree_with_overlap_and_nearness(a: Thing, b: Thing) -> None:
    world = world_of(a, b)
    local = b[1].inverse().apply(points(a, per_side=7))
    deep = (np.array(b[0]) / 2 - np.abs(local - (0, 0, b[0][2] / 2))).min(axis=1).max()

    if deep > 0.004 and min(*a[0], *b[0]) > 0.02:
        assert answer(world, "a", "sk:overlaps", "b").holds
    apart = np.linalg.norm(points(a, per_side=7)[:, None] - points(b, per_side=7)[None], axis=2).min()
    found = answer(world, "a", "sk:near", "b")
    assert found.value is not None
    assert found.value <= apart + 1e-9
    assert found.holds is (found.value <= 0.5)


@settings(max_examples=60, deadline=None)
@given(things, st.floats(-0.02, 0.02), st.floats(-0.5, 0.5))
def test_a_body_rests_on_the_top_that_its_lowest_point_touches(a: Thing, height: float, aside: float) -> None:
    table = ((0.5, 0.5, 0.4), Pose.of(0, 0, 0.1))
    low = points(a)[:, 2].min()
    middle = points(a).mean(axis=0)
    x, y, z = a[1].position
    pose = Pose((x - middle[0] + aside, y - middle[1], z - low + 0.5 + height), a[1].orientation)
    found = answer(world_of((a[0], pose), table), "a", "sk:restsOn", "b")

    if abs(abs(height) - 0.005) > 1e-6 and abs(abs(aside) - 0.25) > 1e-6:
        assert found.holds is (abs(height) < 0.005 and abs(aside) < 0.25)


def test_bodies_in_a_hollow_body_rest_on_its_bottom() -> None:
    world = world_of(((0.1, 0.1, 0.05), Pose.of(0, 0, 0.2)), ((0.2, 0.2, 0.3), Pose.of(0, 0, 0.2)))

    assert not answer(world, "a", "sk:restsOn", "b").holds
    with world.transaction("test", "it is the room in a box") as tx:
        tx.set("b", "sk:hollow", True)
    assert answer(world, "a", "sk:restsOn", "b").holds


# ---------------------------------------------------------------- laws


@settings(max_examples=50, deadline=None)
@given(things, things)
def test_opposite_sides_exclude_each_other_and_nearness_and_overlap_are_symmetric(a: Thing, b: Thing) -> None:
    world = world_of(a, b)
    for one, other in (("sk:leftOf", "sk:rightOf"), ("sk:inFrontOf", "sk:behind"), ("sk:above", "sk:below")):
        assert not (answer(world, "a", one, "b").holds and answer(world, "a", other, "b").holds)
    for relation in ("sk:near", "sk:overlaps"):
        there, back = answer(world, "a", relation, "b"), answer(world, "b", relation, "a")
        assert there.holds is back.holds
        assert there.value == pytest.approx(back.value, abs=1e-9)


@settings(max_examples=50, deadline=None)
@given(things, things, turns)
def test_left_and_right_are_inverse_for_bodies_with_equal_yaw(a: Thing, b: Thing, yaw: float) -> None:
    a, b = ((size, Pose.of(*pose.position, yaw=yaw)) for size, pose in (a, b))
    world = world_of(a, b)
    for one, other in (("sk:leftOf", "sk:rightOf"), ("sk:inFrontOf", "sk:behind")):
        there, back = answer(world, "a", one, "b"), answer(world, "b", other, "a")
        assert there.value == pytest.approx(back.value, abs=1e-9)
        assert there.holds is back.holds or abs((there.value or 0.0) + 0.003) < 1e-6


@settings(max_examples=50, deadline=None)
@given(things, things, standing)
def test_a_body_inside_another_overlaps_it_and_is_near_it(a: Thing, b: Thing, there: Pose) -> None:
    pose = b[1] @ Pose.of(*(0.2 * x for x in there.position), yaw=there.yaw)
    world = world_of((a[0], pose), b)

    if answer(world, "a", "sk:inside", "b").holds:
        assert answer(world, "a", "sk:overlaps", "b").holds
        assert answer(world, "a", "sk:near", "b").holds


MOVED_WITH = ("sk:leftOf", "sk:rightOf", "sk:inFrontOf", "sk:behind", "sk:near", "sk:overlaps", "sk:inside")


@settings(max_examples=50, deadline=None)
@given(things, things, anyhow, standing)
def test_moving_two_bodies_together_keeps_their_relations(a: Thing, b: Thing, anyway: Pose, upright: Pose) -> None:
    world = world_of(a, b)
    for relations, motion in ((MOVED_WITH, anyway), (RELATIONS, upright)):
        moved = world_of((a[0], motion @ a[1]), (b[0], motion @ b[1]))
        for relation in relations:
            before, after = answer(world, "a", relation, "b"), answer(moved, "a", relation, "b")
            assert after.value == pytest.approx(before.value, abs=1e-7)
            if before.holds is not after.holds:  # only where it was a matter of rounding
                assert (
                    min(abs((before.value or 0.0) - edge) for edge in (-0.005, -0.003, 0.0, 0.003, 0.005, 0.5)) < 1e-6
                )


# ---------------------------------------------------------------- many at once


@settings(max_examples=40, deadline=None)
@given(st.lists(things, min_size=2, max_size=8), st.data())
def test_the_pairs_of_a_relation_equal_its_single_answers(found: list[Thing], data: st.DataObject) -> None:
    world = world_of(*found)
    with world.transaction("test", "one on another, one lost, one hollow, one of no size") as tx:
        tx.relate("b", "sk:poseFrame", "a")
        if len(found) > 3:
            tx.set("c", "sk:pose", None)
            tx.set("d", "sk:hollow", True)
        if len(found) > 4:
            tx.set("e", "sk:solid", None)
        if len(found) > 5:
            tx.relate("f", "sk:poseFrame", "c")
    ids = world.instances("sk:Object")
    subjects, objects = (tuple(data.draw(st.permutations(ids)))[: data.draw(st.integers(1, 8))] for _ in range(2))
    for relation in RELATIONS:
        expected = [(s, o) for s in subjects for o in objects if s != o and answer(world, s, relation, o).holds]

        assert list(SPATIAL.pairs(world, relation, subjects, objects)) == expected
        assert world.objects("a", relation) == tuple(o for o in ids if answer(world, "a", relation, o).holds)
        assert world.subjects(relation, "a") == tuple(s for s in ids if answer(world, s, relation, "a").holds)


@pytest.mark.parametrize("relation", RELATIONS)
def test_the_search_tree_finds_the_same_pairs_as_single_comparisons(relation: str) -> None:
    """Many go by a search tree and remembered boxes, few one with each."""
    rng = np.random.default_rng(3)
    world = World(ONTOLOGY, reasoners=Reasoners((SPATIAL,)))
    with world.transaction("test", "boxes all over a hall, on and beside each other") as tx:
        tx.add("sk:Floor", id="floor", properties={"sk:pose": Pose(), "sk:size": (20.0, 20.0)})
        for _ in range(600):
            x, y, height, yaw = rng.uniform((0, 0, 0, -3), (4, 4, 3, 3))
            pose = Pose.of(x, y, 0.054 * int(height), yaw=yaw)
            tx.add("kitting:RelayBox", properties={"sk:pose": pose}, placement=Placement("sk:on", "floor"))
    state = world.snapshot()
    ids = state.instances("sk:SpatialThing")
    together = set(SPATIAL.pairs(state, relation, ids, ids))

    some = [ids[number] for number in rng.choice(len(ids), 40, replace=False)]
    apart = {pair for one in some for pair in SPATIAL.pairs(state, relation, (one,), ids)}
    assert {pair for pair in together if pair[0] in some} == apart
    if relation != "sk:inside":
        assert together


# ---------------------------------------------------------------- what people are told


TABLE = ((1.0, 0.6, 0.5), Pose.of(2, 0, 0, yaw=np.pi / 2))  # looks along the map's y


@pytest.mark.parametrize(
    ("where", "relation", "holds", "reason"),
    [
        ((1.4, 0, 0), "sk:leftOf", True, "a is left of b, with 0.250 m between them"),
        ((2.6, 0, 0), "sk:leftOf", False, "a is not left of b: it would have to be 0.950 m further to the left"),
        ((2.6, 0, 0), "sk:rightOf", True, "a is right of b, with 0.250 m between them"),
        ((2, 0.9, 0), "sk:inFrontOf", True, "a is in front of b, with 0.350 m between them"),
        ((2, 0.9, 0), "sk:behind", False, "a is not behind b: it would have to be 1.450 m further back"),
        ((2, 0, 0.5), "sk:above", True, "a is above b, with 0.000 m between them"),
        ((2, 0, 0.3), "sk:above", False, "a is not above b: it would have to be 0.200 m higher"),
        ((0, 0, 0.6), "sk:above", False, "a is not above b: it is beside it"),
        ((2, 0, 0.5), "sk:below", False, "a is not below b: it would have to be 0.600 m lower"),
        ((2, 0, 0.5), "sk:restsOn", True, "a rests on b"),
        ((2, 0, 0.6), "sk:restsOn", False, "a does not rest on b: it is 0.100 m above its surface"),
        ((2, 0, 0.4), "sk:restsOn", False, "a does not rest on b: it is 0.100 m below its surface"),
        ((3, 0, 0.5), "sk:restsOn", False, "a does not rest on b: its middle is not over it"),
        ((1.4, 0, 0), "sk:near", True, "a is near b: there are 0.250 m between them"),
        ((0.4, 0, 0), "sk:near", False, "a is not near b: there are 1.250 m between them, more than 0.5 m"),
        ((2, 0, 0.4), "sk:overlaps", True, "a and b overlap by 0.100 m"),
        ((2, 0, 0.5), "sk:overlaps", False, "a and b do not overlap"),
        ((2, 0, 0.1), "sk:inside", True, "a is inside b, with 0.100 m to its sides"),
        ((2.3, 0, 0.1), "sk:inside", False, "a is not inside b: it sticks out by 0.050 m"),
        ((2, 0, 0.7), "sk:inside", False, "a is not inside b: it is over it"),
    ],
)
def test_every_answer_gives_its_reason_with_the_deciding_number(
    where: tuple[float, float, float], relation: str, holds: bool, reason: str
) -> None:
    found = answer(world_of(((0.1, 0.1, 0.1), Pose(where)), TABLE), "a", relation, "b")

    assert (found.holds, found.reason) == (holds, reason)


@pytest.mark.parametrize("relation", RELATIONS)
def test_no_relation_holds_for_an_element_without_a_pose_and_the_answer_names_it(relation: str) -> None:
    world = world_of(TABLE)

    for pair in (("floor", "a"), ("a", "floor")):
        found = answer(world, pair[0], relation, pair[1])
        assert found == Answer(False, "the pose of floor in the map is not known")
        assert not world.related(pair[0], relation, pair[1])


@pytest.mark.parametrize("relation", ["sk:restsOn", "sk:overlaps", "sk:inside"])
def test_an_element_without_a_size_counts_as_a_point_unless_the_relation_needs_the_size(relation: str) -> None:
    world = world_of(TABLE, TABLE)
    with world.transaction("test", "no shape") as tx:
        tx.set("b", "sk:solid", None)

    assert answer(world, "a", relation, "b") == Answer(False, "the size of b is not known")
    assert answer(world, "a", "sk:near", "b").holds


def test_a_held_part_has_relations_to_a_gripper_of_unknown_pose() -> None:
    world = world_of(((0.1, 0.1, 0.1), Pose()), TABLE)
    with world.transaction("test", "held") as tx:
        tx.add("sk:Gripper", id="gripper", placement=Placement("sk:on", "floor"))
        write_pose(tx, "a", Pose.of(0.2, 0, 0), "gripper")

    assert answer(world, "a", "sk:inFrontOf", "gripper").holds
    assert answer(world, "a", "sk:near", "gripper").value == pytest.approx(0.15)
    assert answer(world, "a", "sk:near", "b").reason == "the pose of a in the map is not known"
    assert answer(world, "a", "sk:above", "gripper").reason == "the pose of a and gripper in the map is not known"


def test_no_spatial_relation_holds_between_an_element_and_itself() -> None:
    world = world_of(TABLE)

    assert not any(answer(world, "a", relation, "a").holds for relation in RELATIONS)
    assert world.objects("a", "sk:near") == ()


def test_all_relations_between_two_elements_are_listed_with_their_values() -> None:
    world = world_of(((0.1, 0.1, 0.1), Pose.of(2, 0, 0.5)), TABLE)

    found = {relation.relation: relation.value for relation in world.reasoners.between(world, "a", "b")}
    assert sorted(found) == ["sk:above", "sk:near", "sk:restsOn"]
    assert found["sk:near"] == pytest.approx(0.0)


def test_relations_in_an_overlay_use_the_poses_of_the_overlay() -> None:
    world = world_of(((0.1, 0.1, 0.1), Pose()), TABLE)
    supposed = Overlay(world)
    supposed.set_value("a", "sk:pose", Pose.of(2, 0, 0.5))

    assert supposed.related("a", "sk:restsOn", "b")
    assert supposed.subjects("sk:restsOn", "b") == ("a",)
    assert not world.related("a", "sk:restsOn", "b")


def test_the_computed_super_relation_holds_if_any_of_its_relations_holds() -> None:
    world = world_of(((0.1, 0.1, 0.1), Pose()), TABLE)

    assert world.related("a", "sk:computed", "b")
    assert world.objects("a", "sk:computed") == ("b",)


# ---------------------------------------------------------------- data by key


def test_spatial_data_is_read_and_stored_by_key() -> None:
    world = world_of(((0.1, 0.1, 0.1), Pose()), TABLE)
    with world.transaction("test", "on the table") as tx:
        SPATIAL.store(tx, "a", "pose in b", Pose.of(0.1, 0.2, 0.5))

    assert SPATIAL.data(world, "a", "frame") == "b"
    assert SPATIAL.data(world, "a", "position") == pytest.approx((1.8, 0.1, 0.5))
    assert SPATIAL.data(world, "a", "position in b") == pytest.approx((0.1, 0.2, 0.5))
    assert SPATIAL.data(world, "a", "orientation in b") == (0.0, 0.0, 0.0, 1.0)
    assert SPATIAL.data(world, "a", "distance to b") == pytest.approx(0.0)
    assert SPATIAL.data(world, "floor", "pose") is None
    assert SPATIAL.data(world, "floor", "distance to a") is None


def test_storing_a_position_keeps_the_orientation_and_vice_versa() -> None:
    world = world_of(TABLE)
    turned = Pose.of(0, 0, 0, yaw=1.0).orientation
    with world.transaction("test", "here") as tx:
        SPATIAL.store(tx, "a", "position", (5.0, 6.0, 7.0))
    assert map_pose(world, "a") == Pose((5.0, 6.0, 7.0), TABLE[1].orientation)

    with world.transaction("test", "turned") as tx:
        SPATIAL.store(tx, "a", "orientation", turned)
    assert map_pose(world, "a") == Pose((5.0, 6.0, 7.0), turned)


def test_storing_the_frame_keeps_the_pose_in_the_map() -> None:
    world = world_of(((0.1, 0.1, 0.1), Pose.of(2, 0, 0.5)), TABLE)
    with world.transaction("test", "taken along") as tx:
        SPATIAL.store(tx, "a", "frame", "b")
    assert SPATIAL.data(world, "a", "position") == pytest.approx((2, 0, 0.5))
    assert SPATIAL.data(world, "a", "frame") == "b"

    with world.transaction("test", "put down") as tx:
        SPATIAL.store(tx, "a", "frame", "")
    assert SPATIAL.data(world, "a", "position") == pytest.approx((2, 0, 0.5))
    assert SPATIAL.data(world, "a", "frame") == ""


@pytest.mark.parametrize("key", ["colour", "pose on b", "distance", "frame in b", ""])
def test_an_unknown_key_is_refused_with_the_known_keys(key: str) -> None:
    world = world_of(TABLE)

    with pytest.raises(UsageError, match="it reads pose, position, orientation"):
        SPATIAL.data(world, "a", key)
    with pytest.raises(UsageError, match=r"it stores pose \(a Pose\)"), world.transaction("test", "?") as tx:
        SPATIAL.store(tx, "a", key, 1.0)


def test_storing_an_invalid_value_is_refused_and_changes_nothing() -> None:
    world = world_of(TABLE)

    with pytest.raises(WorldError, match="needs a pose"), world.transaction("test", "?") as tx:
        SPATIAL.store(tx, "a", "position", (float("nan"), 0.0, 0.0))
    with pytest.raises(UsageError, match="stores no 'position'"), world.transaction("test", "?") as tx:
        SPATIAL.store(tx, "a", "position", (1.0, 2.0))
    with pytest.raises(WorldError, match="unknown element 'moon'"), world.transaction("test", "?") as tx:
        SPATIAL.store(tx, "a", "pose in moon", Pose())
    assert map_pose(world, "a") == TABLE[1]
