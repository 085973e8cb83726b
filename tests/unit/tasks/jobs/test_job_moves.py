"""A job says which parts it has moved from where to where: its own, and no others."""

from __future__ import annotations

from skiros_py.tasks.jobs.job import Intent, Job, JobOrder, JobState, MaterialActual
from skiros_py.tasks.jobs.run import moved
from skiros_py.testing import tiny_world
from skiros_py.world.vocabulary import LOT
from skiros_py.world.world import World

BALL = {"element": "ball_1", "class_": "tiny:Ball", "label": "ball 1"}


def job(**more: object) -> Job:
    return Job(order=JobOrder(id="a", goal=("x",)), number=1, state=JobState.RUNNING, **more)


def steps(*parts: str) -> list[Intent]:
    return [Intent(number=n, skill="pick", arguments={"Robot": "robot_1", "Part": p}) for n, p in enumerate(parts)]


def place(world: World, part: str, relation: str, where: str) -> None:
    with world.transaction("test", "it moved") as tx:
        tx.place(part, relation, where)


def test_only_the_first_and_last_place_of_a_part_are_reported():
    world = tiny_world()
    began = world.version
    place(world, "ball_1", "sk:heldBy", "gripper_1")
    place(world, "ball_1", "sk:in", "slot_1")
    (found,) = moved(world, job(seen=began), steps("ball_1"))
    assert (found.element, found.class_, found.origin, found.place) == ("ball_1", "tiny:Ball", "box_a", "slot_1")


def test_moves_before_the_job_are_not_reported():
    world = tiny_world()
    place(world, "ball_1", "sk:in", "slot_1")
    assert moved(world, job(seen=world.version), steps("ball_1")) == ()


def test_elements_that_no_step_names_are_not_reported_as_moved():
    world = tiny_world()
    began = world.version
    place(world, "ball_1", "sk:in", "slot_1")
    assert moved(world, job(seen=began), steps("red_ball_1")) == ()


def test_an_element_that_returned_to_its_place_is_not_reported_as_moved():
    world = tiny_world()
    began = world.version
    place(world, "ball_1", "sk:heldBy", "gripper_1")
    place(world, "ball_1", "sk:in", "box_a")
    assert moved(world, job(seen=began), steps("ball_1")) == ()


def test_a_moved_robot_is_not_reported_as_material():
    world = tiny_world()
    began = world.version
    place(world, "robot_1", "sk:at", "box_b")
    assert moved(world, job(seen=began), steps("ball_1")) == ()


def test_a_report_of_moves_continues_from_the_previous_one():
    world = tiny_world()
    place(world, "ball_1", "sk:heldBy", "gripper_1")
    told = MaterialActual(**BALL, origin="box_a", place="gripper_1")
    began = world.version
    place(world, "ball_1", "sk:in", "slot_1")
    (found,) = moved(world, job(seen=began, materials=(told,)), steps("ball_1"))
    assert (found.origin, found.place) == ("box_a", "slot_1")


def test_evaluating_the_same_changes_twice_gives_the_same_moves():
    world = tiny_world()
    began = world.version
    place(world, "ball_1", "sk:heldBy", "gripper_1")
    place(world, "ball_1", "sk:in", "slot_1")
    once = moved(world, job(seen=began), steps("ball_1"))
    assert moved(world, job(seen=began, materials=once), steps("ball_1")) == once


def test_without_running_steps_the_reported_moves_do_not_change():
    world = tiny_world()
    told = (MaterialActual(**BALL, origin="box_a", place="gripper_1"),)
    place(world, "ball_1", "sk:in", "slot_1")
    assert moved(world, job(materials=told), steps("ball_1")) == told


def test_a_moved_part_is_reported_with_its_lot_also_after_its_removal():
    world = tiny_world()
    began = world.version
    with world.transaction("mes", "delivery") as tx:
        tx.set("ball_1", LOT, "L-0815")
    place(world, "ball_1", "sk:in", "slot_1")
    told = moved(world, job(seen=began), steps("ball_1"))
    with world.transaction("test", "eaten") as tx:
        tx.remove("ball_1")
    later = moved(world, job(seen=began, materials=told), steps("ball_1"))
    assert [(one.lot, one.place) for one in (*told, *later)] == [("L-0815", "slot_1"), ("L-0815", "")]


def test_a_removed_part_has_no_place():
    world = tiny_world()
    began = world.version
    place(world, "ball_1", "sk:in", "slot_1")
    with world.transaction("test", "eaten") as tx:
        tx.remove("ball_1")
    (found,) = moved(world, job(seen=began), steps("ball_1"))
    assert (found.element, found.origin, found.place) == ("ball_1", "box_a", "")
