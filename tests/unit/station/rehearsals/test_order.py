"""The world of a rehearsal is what is believed, and what is not believed is assumed, and said."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from skiros_py.errors import UsageError
from skiros_py.geometry import Pose
from skiros_py.skills.cell_reader import read_cell
from skiros_py.station.rehearsals.order import RehearsalOrder, order_from, order_of
from skiros_py.station.session import Options, Session
from skiros_py.station.worlds import open_world
from skiros_py.world import vocabulary as v
from skiros_py.world.change import Writer
from skiros_py.world.element import Placement
from skiros_py.world.world import World


def played(order: RehearsalOrder, folder: Path) -> World:
    """Returns the world in which an order is played."""
    file = folder / "played.ttl"
    file.write_text(order.scene)
    return open_world(str(file))


def test_the_scene_of_a_rehearsal_can_be_opened_and_is_the_same_but_for_its_name(tmp_path: Path) -> None:
    world = open_world("kitting")

    again = played(order_from(world, Options(), ["InKit(Starter, kit_1)"]), tmp_path)

    robots = world.instances(v.ROBOT)
    for there, here in zip(read_cell(again, robots).bodies, read_cell(world, robots).bodies, strict=True):
        assert replace(there, pose=here.pose) == here
        assert here.pose == there.pose or (here.pose and there.pose and there.pose.distance(here.pose) < 1e-6)
    assert list(again.goals) == list(world.goals)


def test_it_is_said_which_poses_were_never_seen() -> None:
    world = open_world("kitting")
    with world.transaction("test", "seen", writer=Writer.SKILL) as tx:
        tx.set("compressor_1", v.POSE, Pose((4.9, -1.6, 0.6)))

    told = order_from(world, Options()).assumptions

    assert told == (
        "where in pallet_a alternator_1, relay_box_1 and starter_1 lie was never seen: drawn",
        "where in pallet_b relay_box_2 lie was never seen: drawn",
    )


def test_a_held_part_is_rehearsed_where_it_was_taken_from(tmp_path: Path) -> None:
    world = open_world("kitting")
    with world.transaction("test", "taken", writer=Writer.SKILL) as tx:
        tx.place("starter_1", v.HELD_BY, "gripper_1")
        tx.set("starter_1", v.POSE, Pose())

    before = world.version
    order = order_from(world, Options())

    assert world.version == before
    assert world.placement("starter_1") == Placement(v.HELD_BY, "gripper_1")
    placement = played(order, tmp_path).placement("starter_1")
    assert placement is not None
    assert (placement.relation, placement.place) == (v.IN, "pallet_a")
    assert "starter_1 is held: rehearsed as if it were still in pallet_a" in order.assumptions


def test_a_base_starts_where_it_is_localised(tmp_path: Path) -> None:
    with Session("kitting", Options(fake=True)) as session:
        session.run(["Holding(gripper_1, starter_1)"])
        robot = session.spec.robots[0]
        localised = robot.pose(session.cycle.board.snapshot, session.cycle.board.guard)
        order = order_of(session, ["InKit(Starter, kit_1)"])

    again = played(order, tmp_path)
    start = read_cell(again, again.instances(v.ROBOT)).robots[0].start
    assert localised.distance(robot.start) > 1.0
    assert start.distance(localised) < 1e-4


def test_the_second_world_is_simulated_as_fast_as_it_can_and_keeps_nothing(tmp_path: Path) -> None:
    options = Options(seed=7, fake=True, pace=1.0, data=tmp_path, goal="InKit(Starter, kit_1)")

    there = order_from(open_world("kitting"), options).options

    assert (there.seed, there.fake, there.pace, there.data, there.goal) == (7, False, None, None, ())


@pytest.mark.parametrize("how", [{"draws": 0}, {"rounds": 0}])
def test_a_rehearsal_without_draws_or_rounds_is_refused(how: dict[str, Any]) -> None:
    with pytest.raises(UsageError, match="at least one"):
        order_from(open_world("kitting"), Options(), **how)
