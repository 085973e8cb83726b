"""A job says which parts it has moved from where to where: its own, and no others."""

from __future__ import annotations

from skiros_py.tasks.jobs.job import Intent, Job, JobOrder, JobState, MaterialActual
from skiros_py.tasks.jobs.run import moved
from skiros_py.testing import tiny_world
from skiros_py.world.world import World

BALL = {"element": "ball_1", "class_": "tiny:Ball", "label": "ball 1"}


def job(**more: object) -> Job:
    return Job(order=JobOrder(id="a", goal=("x",)), number=1, state=JobState.RUNNING, **more)


def steps(*parts: str) -> list[Intent]:
    return [Intent(number=n, skill="pick", arguments={"Robot": "robot_1", "Part": p}) for n, p in enumerate(parts)]


def place(world: World, part: str, relation: str, where: str) -> None:
    with world.transaction("test", "it moved") as tx:
        tx.place(part, relation, where)


def test_only_the_ends_of_its_way_count():
    world = tiny_world()
    began = world.version
    place(world, "ball_1", "sk:heldBy", "gripper_1")
    place(world, "ball_1", "sk:in", "slot_1")
    (found,) = moved(world, job(seen=began), steps("ball_1"))
    assert (found.element, found.class_, found.origin, found.place) == ("ball_1", "tiny:Ball", "box_a", "slot_1")


def test_what_moved_before_is_not_told():
    world = tiny_world()
    place(world, "ball_1", "sk:in", "slot_1")
    assert moved(world, job(seen=world.version), steps("ball_1")) == ()


def test_what_no_step_of_it_names_was_moved_by_somebody_else():
    world = tiny_world()
    began = world.version
    place(world, "ball_1", "sk:in", "slot_1")
    assert moved(world, job(seen=began), steps("red_ball_1")) == ()


def test_what_came_back_to_where_it_lay_was_not_moved():
    world = tiny_world()
    began = world.version
    place(world, "ball_1", "sk:heldBy", "gripper_1")
    place(world, "ball_1", "sk:in", "box_a")
    assert moved(world, job(seen=began), steps("ball_1")) == ()


def test_a_robot_that_drove_is_no_material():
    world = tiny_world()
    began = world.version
    place(world, "robot_1", "sk:at", "box_b")
    assert moved(world, job(seen=began), steps("ball_1")) == ()


def test_what_was_told_before_goes_on_from_there():
    world = tiny_world()
    place(world, "ball_1", "sk:heldBy", "gripper_1")
    told = MaterialActual(**BALL, origin="box_a", place="gripper_1")
    began = world.version
    place(world, "ball_1", "sk:in", "slot_1")
    (found,) = moved(world, job(seen=began, materials=(told,)), steps("ball_1"))
    assert (found.origin, found.place) == ("box_a", "slot_1")


def test_looking_twice_at_the_same_changes_tells_the_same():
    world = tiny_world()
    began = world.version
    place(world, "ball_1", "sk:heldBy", "gripper_1")
    place(world, "ball_1", "sk:in", "slot_1")
    once = moved(world, job(seen=began), steps("ball_1"))
    assert moved(world, job(seen=began, materials=once), steps("ball_1")) == once


def test_while_nothing_runs_what_was_told_stands():
    world = tiny_world()
    told = (MaterialActual(**BALL, origin="box_a", place="gripper_1"),)
    place(world, "ball_1", "sk:in", "slot_1")
    assert moved(world, job(materials=told), steps("ball_1")) == told


def test_a_part_that_is_no_more_has_no_place():
    world = tiny_world()
    began = world.version
    place(world, "ball_1", "sk:in", "slot_1")
    with world.transaction("test", "eaten") as tx:
        tx.remove("ball_1")
    (found,) = moved(world, job(seen=began), steps("ball_1"))
    assert (found.element, found.origin, found.place) == ("ball_1", "box_a", "")
