from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.geometry import Pose
from skiros_py.skills.conditions.watch import Watches
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import REACHABLE, tiny_ontology
from skiros_py.world.journal.data_directory import DataDirectory
from skiros_py.world.overlay import Overlay
from skiros_py.world.taught import lesson_about
from skiros_py.world.vocabulary import APPLIES_TO, DRIVING_POSE, GRASP_WIDTH, TAUGHT_DRIVING_POSE, TAUGHT_GRASP
from skiros_py.world.world import World

BENCH = "scene:bench_1 a tiny:Bench ; sk:on scene:floor ."


def teach(world: World, class_: str, x: float) -> str:
    with world.transaction("person", "shows it") as tx:
        properties = {APPLIES_TO: class_, DRIVING_POSE: Pose((x, 0.0, 0.0))}
        return tx.add(TAUGHT_DRIVING_POSE, properties=properties, learned=True)


def docks(world: World, element: str) -> float | None:
    pose = world.value(element, DRIVING_POSE)
    return pose.position[0] if isinstance(pose, Pose) else None


def test_a_taught_value_overrides_the_class_value() -> None:
    world = tiny_world()

    teach(world, "tiny:Box", -2.0)

    assert docks(world, "box_a") == -2.0


def test_the_value_of_an_element_overrides_a_taught_value() -> None:
    world = tiny_world()
    teach(world, "tiny:Box", -2.0)

    with world.transaction("person", "this one is different") as tx:
        tx.set("box_a", DRIVING_POSE, Pose((-3.0, 0.0, 0.0)))

    assert (docks(world, "box_a"), docks(world, "box_b")) == (-3.0, -2.0)


def test_a_value_taught_for_a_more_specific_class_takes_precedence() -> None:
    world = tiny_world(BENCH)

    teach(world, "tiny:Bench", -2.0)
    teach(world, "tiny:Box", -3.0)

    assert (docks(world, "bench_1"), docks(world, "box_a")) == (-2.0, -3.0)


@given(st.integers(1, 25))
def test_the_latest_value_taught_for_a_class_is_used(times: int) -> None:
    world = tiny_world()

    for number in range(times):
        teach(world, "tiny:Box", -2.0 - number)

    assert docks(world, "box_a") == -1.0 - times


def test_a_class_without_a_value_can_be_taught_one() -> None:
    world = tiny_world()
    assert docks(world, "slot_1") is None

    teach(world, "tiny:Slot", -2.0)

    assert docks(world, "slot_1") == -2.0
    assert docks(Overlay(world), "slot_1") == -2.0


def test_removing_a_taught_value_restores_the_previous_one() -> None:
    world = tiny_world()
    teach(world, "tiny:Box", -2.0)
    lesson = teach(world, "tiny:Box", -3.0)

    with world.transaction("person", "that was wrong") as tx:
        tx.remove(lesson)

    assert docks(world, "box_a") == -2.0


def test_a_taught_grasp_width_makes_a_class_graspable() -> None:
    world = tiny_world()
    assert not world.related("ball_1", "sk:graspableBy", "gripper_1")

    with world.transaction("person", "shows it") as tx:
        tx.add(TAUGHT_GRASP, properties={APPLIES_TO: "tiny:Ball", GRASP_WIDTH: 0.05}, learned=True)

    assert world.related("ball_1", "sk:graspableBy", "gripper_1")
    assert world.related("red_ball_1", "sk:graspableBy", "gripper_1")


def test_a_watched_condition_changes_with_taught_values() -> None:
    world = tiny_world()
    watch = Watches(world).add((REACHABLE("slot_1"),), {})
    before = watch.broken()

    lesson = teach(world, "tiny:Slot", -2.0)
    taught = watch.broken()
    with world.transaction("person", "that was wrong") as tx:
        tx.remove(lesson)

    assert (before is None, taught is None, watch.broken() is None) == (False, True, False)


def test_learned_concepts_survive_a_restart(tmp_path: Path) -> None:
    with DataDirectory.open(tmp_path / "data", tiny_ontology()) as directory:
        lesson = teach(directory.world, "tiny:Slot", -2.0)

    with DataDirectory.open(tmp_path / "data", tiny_ontology()) as directory:
        with directory.world.transaction("person", "builds") as tx:
            tx.add("sk:Floor", id="floor")
            tx.add("tiny:Slot", id="slot_9")
            tx.place("slot_9", "sk:on", "floor")
        assert directory.world.element(lesson).properties[APPLIES_TO] == "tiny:Slot"
        assert docks(directory.world, "slot_9") == pytest.approx(-2.0)


def test_the_lesson_that_gives_a_taught_value_is_found() -> None:
    world = tiny_world()
    teach(world, "tiny:Box", -2.0)
    lesson = teach(world, "tiny:Box", -3.0)

    found = lesson_about(world, "tiny:Box", DRIVING_POSE)

    assert found is not None
    assert found.id == lesson
    assert lesson_about(world, "tiny:Ball", DRIVING_POSE) is None
    assert lesson_about(world, "tiny:Box", "sk:mass") is None
